//! Files as people have them, spoilt in every way: the readers give a scan or an error, and never panic, spin or take more
//! memory than the file explains. `FUZZ_INPUTS=1000000` for that many of each format.

#![allow(clippy::unwrap_used)]

use std::alloc::System;
use std::env;
use std::fs;

use cap::Cap;
use mesh::file::{FileError, MILLIMETRE, read};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tempfile::TempDir;

/// What a reader may take beside four times the file. An allocation beyond it fails and ends the process.
const MEMORY_MAX: usize = 64 << 20;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

const PLY: &[&str] = &[
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
     end_header\n0.5 -0.25 0.125 \n9 \n1 2 -3 \n8\n4 5 6\n7\n",
    "ply\r\nformat ascii 1.0\r\ncomment a b\r\nelement vertex 4\r\nproperty double x\r\nproperty double y\r\n\
     property double z\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\nelement face 2\r\n\
     property list uchar int vertex_index\r\nend_header\r\n0 0 0 0 0 1\r\n1 0 0 0 0 1\r\n1 1 0 0 0 1\r\nnan 1 0 0 0 1\r\n\r\n\
     3 0 1 2\r\n3 0 2 1\r\n",
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty half f_(XY)\n\
     element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 1 -\n1 0 1 -\n0 1 1 -\n5 0 1 2 -1 0\n",
    "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
     element face 1\nproperty list ushort uint vertex_indices\nproperty list uchar float texcoord\nend_header\n\
     \0\0\0\x3f\0\0\0\x3f\0\0\0\x3f\0\0\x20\x3f\0\0\0\x3f\0\0\0\x3f\0\0\0\x3f\0\0\x20\x3f\0\0\0\x3f\
     \x03\0\0\0\0\0\x01\0\0\0\x02\0\0\0\x01\0\0\0\0",
    "ply\nformat binary_big_endian 1.0\nelement vertex 2\nproperty uint64 t\nproperty int16 x\nproperty char y\n\
     property double z\nend_header\n\0\0\0\0\0\0\0\x01\0\x02\x03\x3f\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x01\0\x02\x03\x3f\0\0\0\0\0\0\0",
];

const PCD: &[&str] = &[
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z _ rgb _\nSIZE 4 4 4 1 4 1\nTYPE F F F U F U\nCOUNT 1 1 1 2 1 0\nWIDTH 2\n\
     HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA binary\n\0\0\0\x3f\0\0\0\x3f\0\0\0\x3f\x01\x02\x01\x02\x03\x04\
     \0\0\x20\x3f\0\0\0\x3f\0\0\0\x3f\x01\x02\x01\x02\x03\x04",
    "VERSION .7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 8 4 4 4\nTYPE F F F F F F\nCOUNT 1 1 1 1 1 1\nWIDTH 1\n\
     HEIGHT 3\nPOINTS 3\nDATA ascii\n0.5 1 2 0 0 1\nnan nan nan 0 0 1\n0 0 0 0 1 0\n",
    "COLUMNS x y z i\nPOINTS 2\nDATA ascii\n1 2 3 4\n5 6 7 8\n",
    "FIELDS x y z\nSIZE 2 1 4\nTYPE I U F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary_compressed\n\
     \x0f\0\0\0\x0e\0\0\0\x0d\x01\0\x02\0\x03\x04\0\0\0\x3f\0\0\0\x3f\0",
];

const OBJ: &[&str] = &[
    "# C:\\scans\\\nmtllib a.mtl\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 \\\n 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 -2//-1 4//1\n",
    "\u{feff}v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nf -3 -2 -1\r\nf -1 -2 -3\r\n",
    "v 1 0 0\nvn 0 0 1\nv nan 0 1\nvn 0 1 0\nv 0 0 0\nvn 1 0 0\n",
    "f 1//7 2//8 3//9\nv 1 2 3 4 5 6\nv 1e3 -2. 3\nv 7 8 9\n",
];

#[test]
fn spoilt_files_give_a_scan_or_an_error() {
    let inputs: usize = env::var("FUZZ_INPUTS").map_or(20_000, |count| count.parse().unwrap());
    let seed = 20_261_127;
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    // In memory: a disk would take most of the time.
    let folder = TempDir::new_in("/dev/shm").unwrap();
    for (name, files) in [("a.ply", PLY), ("a.pcd", PCD), ("a.obj", OBJ)] {
        // If it ends the process, the input is still there.
        let path = folder.path().join(name);
        println!("{}", path.display());
        let mut taken = 0;
        for _ in 0..inputs {
            let bytes = spoilt(files, &mut random);
            fs::write(&path, &bytes).unwrap();
            let limit = ALLOCATOR.allocated() + MEMORY_MAX + 4 * bytes.len();
            ALLOCATOR.set_limit(limit).unwrap();
            let scan = read(&path, MILLIMETRE);
            ALLOCATOR.set_limit(usize::MAX).unwrap();
            match scan {
                Ok(scan) => {
                    taken += 1;
                    let corners = scan.triangles.iter().flatten();
                    assert!(
                        corners
                            .max()
                            .is_none_or(|&last| (last as usize) < scan.points_m.len())
                    );
                    assert!(scan.points_m.iter().all(cloud::is_finite));
                }
                Err(FileError::Empty { .. }) => taken += 1,
                Err(error) => assert!(error.to_string().contains(name), "{error}"),
            }
        }
        println!("{name}: {taken} of {inputs} were read");
        // If nearly all or none were, the inputs would test nothing.
        assert!((inputs / 20..inputs * 19 / 20).contains(&taken), "{taken}");
    }
}

#[test]
fn what_is_not_spoilt_is_read() {
    let folder = TempDir::new().unwrap();
    for (name, files) in [("a.ply", PLY), ("a.pcd", PCD), ("a.obj", OBJ)] {
        for file in files {
            let path = folder.path().join(name);
            fs::write(&path, file).unwrap();
            let scan = read(&path, MILLIMETRE).unwrap();
            assert!(scan.points_m.len() + scan.dropped.count() >= 2, "{file:?}");
        }
    }
}

/// A file with up to four changes.
fn spoilt(files: &[&str], random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = files[random.random_range(0..files.len())]
        .as_bytes()
        .to_vec();
    for _ in 0..random.random_range(1..=4) {
        let place = random.random_range(0..=bytes.len());
        match random.random_range(0..8) {
            0 => bytes.truncate(place),
            1 if place < bytes.len() => bytes[place] = random.random(),
            2 if place < bytes.len() => bytes[place] ^= 1 << random.random_range(0..8),
            3 => insert(
                &mut bytes,
                place,
                BITS[random.random_range(0..BITS.len())].as_bytes(),
            ),
            4 => {
                let number = u64::MAX >> random.random_range(0..64);
                insert(&mut bytes, place, number.to_string().as_bytes());
            }
            5 => {
                let other = files[random.random_range(0..files.len())].as_bytes();
                let start = random.random_range(0..other.len());
                let end = random.random_range(start..other.len().min(start + 60));
                insert(&mut bytes, place, &other[start..end]);
            }
            6 => {
                let end = (place + random.random_range(0..40)).min(bytes.len());
                bytes.drain(place..end);
            }
            7 => {
                // A piece many times, as in a large file.
                let end = (place + random.random_range(0..12)).min(bytes.len());
                let piece = bytes[place..end].repeat(random.random_range(1..200));
                insert(&mut bytes, place, &piece);
            }
            _ => {}
        }
    }
    bytes
}

fn insert(bytes: &mut Vec<u8>, place: usize, piece: &[u8]) {
    bytes.splice(place..place, piece.iter().copied());
}

/// What has a meaning somewhere.
const BITS: &[&str] = &[
    "\n",
    "\r\n",
    "\r",
    " ",
    "\\\n",
    "#",
    "\u{feff}",
    "nan ",
    "-1 ",
    "0 ",
    "1e999 ",
    "3.0 ",
    "0,5 ",
    "/",
    "//",
    "-",
    "comment \u{fc}\n",
    "property list uchar int vertex_indices\n",
    "property float x\n",
    "element face 9\n",
    "end_header\n",
    "element vertex 4000000000\n",
    "COUNT 0 1 1\n",
    "POINTS 3\n",
    "DATA ascii\n",
    "_ ",
    "f 1 1 1 1 1 1 1 1\n",
    "v 1 2 3\n",
    "\0\0\0\0",
    "\u{7f}",
];
