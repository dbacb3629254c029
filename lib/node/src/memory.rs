//! How a node that runs for weeks keeps its memory.

use std::ffi::c_int;

/// From this size on, memory is returned as soon as it is free: images and clouds, but no headers.
const RETURNED_FROM_BYTES: c_int = 128 << 10;

/// Makes the allocator return the memory of images and clouds.
///
/// By itself, glibc keeps blocks as large as the largest that was ever freed, and a heap for each thread, of which a node
/// has dozens: each becomes as large as the worst moment of its thread.
#[allow(unsafe_code)] // no crate in use offers this call
pub fn keep_small() {
    // SAFETY: two settings of the allocator, made before there are other threads; one that it does not know is ignored.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 1);
        libc::mallopt(libc::M_MMAP_THRESHOLD, RETURNED_FROM_BYTES);
    }
}
