//! How a node that runs for weeks keeps its memory.

use std::ffi::c_int;

/// Blocks up to this size stay with the process when they are freed: images and clouds come thirty times a second, and new
/// memory for each costs milliseconds.
const KEPT_BYTES: c_int = 32 << 20;
/// Free memory at the end of the heap stays with the process up to this size.
const SPARE_BYTES: c_int = 16 << 20;

/// Makes the threads share one heap, which keeps what is freed.
///
/// By itself, glibc keeps a heap for each thread, of which a node has dozens: each becomes as large as the worst moment of
/// its thread.
#[allow(unsafe_code)] // no crate in use offers this call
pub fn share_heap() {
    // SAFETY: settings of the allocator, made before there are other threads; one that it does not know is ignored.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 1);
        libc::mallopt(libc::M_MMAP_THRESHOLD, KEPT_BYTES);
        libc::mallopt(libc::M_TRIM_THRESHOLD, SPARE_BYTES);
    }
}
