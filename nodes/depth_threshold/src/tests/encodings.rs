//! The points are the same in each form that an image may have.

use super::*;

#[test]
fn both_ends_of_the_range_are_kept_in_both_encodings() {
    let parameters = Parameters {
        edge_jump_m: 0.0,
        ..Parameters::default()
    };
    let millimetres = Image::millimetres(6, &[249, 250, 251, 700, 701, 0]);
    assert_eq!(millimetres.depths(parameters.clone()).len(), 3);
    let metres = Image::metres(6, &[0.249, 0.25, 0.251, 0.7, 0.701, 0.0]);
    assert_eq!(metres.depths(parameters).len(), 3);
}

#[test]
fn byte_order_padding_and_encoding_do_not_change_the_points() {
    let depths = random_millimetres(2, 8 * 6);
    let expected = Image::millimetres(8, &depths).points(keep_all());

    let mut big = Image::millimetres(8, &depths);
    big.data = depths
        .iter()
        .flat_map(|depth| depth.to_be_bytes())
        .collect();
    big.is_bigendian = true;
    assert_eq!(big.points(keep_all()), expected);

    let mut padded = Image::millimetres(8, &depths);
    padded.data = padded
        .data
        .chunks(16)
        .flat_map(|row| [row, &[0xff; 5]].concat())
        .collect();
    padded.step = 21;
    assert_eq!(padded.points(keep_all()), expected);

    let metres: Vec<f32> = depths
        .iter()
        .map(|&depth| f32::from(depth) / 1000.0)
        .collect();
    let mut floats = Image::metres(8, &metres);
    let close = |points: Vec<Point3<f32>>| {
        points
            .iter()
            .zip(&expected)
            .all(|(a, b)| (a - b).norm() < 1e-6)
    };
    assert!(close(floats.points(keep_all())));
    floats.data = metres
        .iter()
        .flat_map(|depth| depth.to_be_bytes())
        .collect();
    floats.is_bigendian = true;
    assert!(close(floats.points(keep_all())));
}

#[test]
fn mono16_is_another_name_of_16uc1() {
    let depths = random_millimetres(9, 48);
    let named = Image::millimetres(8, &depths);
    let mut mono = Image::millimetres(8, &depths);
    mono.encoding = "mono16";
    assert_eq!(mono.points(keep_all()), named.points(keep_all()));
    mono.is_bigendian = true;
    mono.data = depths
        .iter()
        .flat_map(|depth| depth.to_be_bytes())
        .collect();
    assert_eq!(mono.points(keep_all()), named.points(keep_all()));
}
