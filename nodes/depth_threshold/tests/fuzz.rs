//! Depth images, plain and packed, spoilt in every way: they give points or an error, and never panic, spin or take more memory
//! than the message explains. `FUZZ_INPUTS=1000000` for that many.

#![allow(clippy::unwrap_used)]

use std::alloc::System;
use std::env;

use cap::Cap;
use depth_threshold::{Calibration, DepthImage, Parameters, Thresholder, Unpacked};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What an image may take beside four times the message. An allocation beyond it fails and ends the process.
const MEMORY_MAX: usize = 64 << 20;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

const WIDTH: u32 = 16;
const HEIGHT: u32 = 12;

/// A message, plain or packed.
#[derive(Clone)]
struct Message {
    size: [u32; 2],
    step: u32,
    encoding: &'static str,
    is_bigendian: bool,
    data: Vec<u8>,
}

/// The right ones.
fn messages(random: &mut Pcg64Mcg) -> Vec<Message> {
    let words: Vec<u16> = (0..WIDTH * HEIGHT)
        .map(|_| random.random_range(0..3) * random.random_range(80..300))
        .collect();
    let message = |encoding, pixel_size: u32, is_bigendian, data| Message {
        size: [WIDTH, HEIGHT],
        step: pixel_size * WIDTH,
        encoding,
        is_bigendian,
        data,
    };
    let whole = |word: &u16| word.to_le_bytes();
    let metres = |word: &u16| (f32::from(*word) / 1e3).to_be_bytes();
    let little: Vec<u8> = words.iter().flat_map(whole).collect();
    let mut png = vec![0; 12];
    let mut encoder = png::Encoder::new(&mut png, WIDTH, HEIGHT);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let rows: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&rows)
        .unwrap();
    // 192 times 0.3 m: no zeros, all others, the first from 0 and then no difference.
    let mut rvl = vec![0; 12];
    rvl.extend(
        [WIDTH, HEIGHT, 0x0883_8B91]
            .into_iter()
            .flat_map(u32::to_le_bytes),
    );
    rvl.extend([0; 100]);
    vec![
        message("16UC1", 2, false, little.clone()),
        message("mono16", 2, true, little),
        message("32FC1", 4, true, words.iter().flat_map(metres).collect()),
        message("16UC1; compressedDepth", 0, false, png.clone()),
        message("32FC1; compressedDepth png", 0, false, png),
        message("16UC1; compressedDepth rvl", 0, false, rvl),
    ]
}

#[test]
fn spoilt_images_give_points_or_an_error() {
    let inputs: usize = env::var("FUZZ_INPUTS").map_or(20_000, |count| count.parse().unwrap());
    let seed = 20_261_127;
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let messages = messages(&mut random);
    let mut taken = 0;
    for number in 0..inputs {
        let message = spoilt(messages[number % messages.len()].clone(), &mut random);
        let decimation = random.random_range(1..=8);
        let limit = ALLOCATOR.allocated() + MEMORY_MAX + 4 * message.data.len();
        ALLOCATOR.set_limit(limit).unwrap();
        taken += usize::from(is_taken(&message, decimation));
        ALLOCATOR.set_limit(usize::MAX).unwrap();
    }
    println!("{taken} of {inputs} were images");
    // If nearly all or none were, the inputs would test nothing.
    assert!((inputs / 20..inputs * 19 / 20).contains(&taken), "{taken}");
}

fn is_taken(message: &Message, decimation: u32) -> bool {
    if !message.encoding.contains(';') {
        return gives_points(
            &DepthImage {
                width: message.size[0],
                height: message.size[1],
                step: message.step,
                encoding: message.encoding,
                is_bigendian: message.is_bigendian,
                data: &message.data,
            },
            decimation,
        );
    }
    let unpacked = Unpacked::new(message.encoding, &message.data);
    unpacked.is_ok_and(|unpacked| gives_points(&unpacked.image(), decimation))
}

fn gives_points(image: &DepthImage, decimation: u32) -> bool {
    let (width, height) = (image.width, image.height);
    let calibration = Calibration {
        width,
        height,
        d: &[],
        k: &[
            400.0,
            0.0,
            f64::from(width) / 2.0,
            0.0,
            400.0,
            f64::from(height) / 2.0,
            0.0,
            0.0,
            1.0,
        ],
        p: &[0.0; 12],
        binning: [0; 2],
        region: [0; 4],
    };
    let Ok(intrinsics) = calibration.intrinsics("image_rect_raw") else {
        return false;
    };
    let parameters = Parameters {
        decimation,
        ..Parameters::default()
    };
    let points = Thresholder::new(parameters)
        .unwrap()
        .points(image, &intrinsics);
    points.is_ok_and(|points| points.iter().all(|point| (0.25..0.71).contains(&point.z)))
}

/// A message with up to three changes, or none.
fn spoilt(mut message: Message, random: &mut Pcg64Mcg) -> Message {
    for _ in 0..random.random_range(0..=3) {
        let place = random.random_range(0..=message.data.len());
        match random.random_range(0..7) {
            0 => message.data.truncate(place),
            1 if place < message.data.len() => message.data[place] = random.random(),
            2 if place < message.data.len() => {
                message.data[place] ^= 1 << random.random_range(0..8)
            }
            3 => message.size[random.random_range(0..2)] = u32::MAX >> random.random_range(0..32),
            4 => message.step = u32::MAX >> random.random_range(0..32),
            5 => {
                // The size of packed words, where it stands.
                let bytes = (u32::MAX >> random.random_range(0..32)).to_le_bytes();
                let at = [12, 16, 20][random.random_range(0..3)];
                if let Some(size) = message.data.get_mut(at..at + 4) {
                    size.copy_from_slice(&bytes);
                }
            }
            6 => {
                let piece: Vec<u8> = (0..random.random_range(1..20))
                    .map(|_| random.random())
                    .collect();
                message.data.splice(place..place, piece);
            }
            _ => {}
        }
    }
    message
}
