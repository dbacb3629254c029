use super::{Image, intrinsics, keep_all, random_millimetres};
use crate::{Thresholder, Unpacked};
use nalgebra::Point3;

const WIDTH: u32 = 12;

fn points(format: &str, data: &[u8]) -> Vec<Point3<f32>> {
    let unpacked = Unpacked::new(format, data).unwrap();
    let image = unpacked.image();
    let lens = intrinsics(image.width, image.height);
    Thresholder::new(keep_all())
        .unwrap()
        .points(&image, &lens)
        .unwrap()
}

fn head(a: f32, b: f32) -> Vec<u8> {
    let quantisation = [a, b].into_iter().flat_map(f32::to_le_bytes);
    [0; 4].into_iter().chain(quantisation).collect()
}

fn by_png(words: &[u16]) -> Vec<u8> {
    png_of(words, png::ColorType::Grayscale)
}

fn png_of(words: &[u16], color: png::ColorType) -> Vec<u8> {
    let mut bytes = Vec::new();
    let height = (words.len() / color.samples()) as u32 / WIDTH;
    let mut encoder = png::Encoder::new(&mut bytes, WIDTH, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Sixteen);
    let rows: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&rows)
        .unwrap();
    bytes
}

/// As the paper's program packs them, with its word of 32 bits.
fn by_rvl(words: &[u16]) -> Vec<u8> {
    let mut nibbles = Vec::new();
    let mut number = |mut value: u32| loop {
        let more = u8::from(value > 7) << 3;
        nibbles.push((value & 7) as u8 | more);
        value >>= 3;
        if more == 0 {
            break;
        }
    };
    let (mut at, mut before) = (0, 0);
    while at < words.len() {
        let zeros = words[at..].iter().take_while(|&&word| word == 0).count();
        let others = words[at + zeros..]
            .iter()
            .take_while(|&&word| word != 0)
            .count();
        number(zeros as u32);
        number(others as u32);
        for &word in &words[at + zeros..][..others] {
            let difference = i32::from(word) - before;
            number(((difference << 1) ^ (difference >> 31)) as u32);
            before = i32::from(word);
        }
        at += zeros + others;
    }
    let word = |nibbles: &[u8]| {
        let shifted = nibbles.iter().enumerate();
        shifted.fold(0_u32, |word, (place, &nibble)| {
            word | u32::from(nibble) << (28 - 4 * place)
        })
    };
    let size = [WIDTH, words.len() as u32 / WIDTH];
    let packed = nibbles.chunks(8).map(word);
    size.into_iter()
        .chain(packed)
        .flat_map(u32::to_le_bytes)
        .collect()
}

#[test]
fn packed_millimetres_give_the_points_of_the_plain_image() {
    let depths = random_millimetres(11, 12 * 10);
    let plain = Image::millimetres(WIDTH, &depths).points(keep_all());
    let png = [head(0.0, 0.0), by_png(&depths)].concat();
    let rvl = [head(0.0, 0.0), by_rvl(&depths)].concat();
    for format in [
        "16UC1; compressedDepth",
        "16UC1; compressedDepth png",
        "mono16; compressedDepth",
    ] {
        assert_eq!(points(format, &png), plain, "{format}");
    }
    assert_eq!(points("16UC1; compressedDepth rvl", &rvl), plain);
}

#[test]
fn packed_metres_are_as_near_as_the_packing_is() {
    let depths = random_millimetres(12, 12 * 10);
    // The defaults of the package: 100 steps at 1 m, 10 m at most.
    let (a, b) = (100.0 * 101.0, 1.0 - 100.0 * 101.0 / 10.0);
    let word = |&depth: &u16| match depth {
        0 => 0,
        _ => (a / (f32::from(depth) / 1000.0) + b) as u16,
    };
    let words: Vec<u16> = depths.iter().map(word).collect();
    let plain = Image::millimetres(WIDTH, &depths).points(keep_all());
    for (format, packed) in [
        ("32FC1; compressedDepth", by_png(&words)),
        ("32FC1; compressedDepth rvl", by_rvl(&words)),
    ] {
        let unpacked = points(format, &[head(a, b), packed].concat());
        assert_eq!(unpacked.len(), plain.len());
        for (unpacked, plain) in unpacked.iter().zip(&plain) {
            assert!(
                (unpacked.z - plain.z).abs() < plain.z * plain.z / a * 1.01,
                "{unpacked} for {plain}"
            );
        }
    }
}

#[test]
fn what_cannot_be_unpacked_is_said_with_the_remedy() {
    let refusal = |format: &str, data: &[u8]| Unpacked::new(format, data).unwrap_err().to_string();
    let depths = random_millimetres(13, 12 * 10);
    let png = [head(0.0, 0.0), by_png(&depths)].concat();
    let rvl = [head(0.0, 0.0), by_rvl(&depths)].concat();
    for format in [
        "16UC1; jpeg compressed",
        "bgr8; jpeg compressed bgr8",
        "16UC1; compressedDepth zstd",
    ] {
        let message = refusal(format, &rvl);
        assert!(
            message.contains(format) && message.contains("republish compressedDepth"),
            "{message}"
        );
    }
    for end in 0..png.len() - 12 {
        Unpacked::new("16UC1; compressedDepth png", &png[..end]).unwrap_err();
    }
    for end in 0..rvl.len() {
        Unpacked::new("16UC1; compressedDepth rvl", &rvl[..end]).unwrap_err();
    }
    let mut huge = rvl.clone();
    huge[12..20].fill(0xFF);
    assert!(refusal("16UC1; compressedDepth rvl", &huge).contains("4294967295"));
    let three = random_millimetres(14, 3 * 12 * 10);
    let bytes = png_of(&three, png::ColorType::Rgb);
    let message = refusal("16UC1; compressedDepth", &[head(0.0, 0.0), bytes].concat());
    assert!(message.contains("one channel"), "{message}");
}
