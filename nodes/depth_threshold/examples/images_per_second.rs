//! How many images a second become clouds on one core, output message included; for tests/peers/registration. Prints one
//! JSON object: images a second by the share of the image that is within the depth limits.

use std::time::{Duration, Instant};

use depth_threshold::{DepthImage, Intrinsics, Parameters, Thresholder};
use msg::std_msgs::Header;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A D435i's image.
const CAMERA: Intrinsics = Intrinsics {
    width: 848,
    height: 480,
    fx: 418.265,
    fy: 418.265,
    cx: 424.158,
    cy: 238.24,
};
const PATIENCE: Duration = Duration::from_secs(1);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seed = 1;
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut rates = Vec::new();
    for share in [0.05, 0.5, 1.0] {
        let data = image(share, &mut random);
        let view = DepthImage::of_millimetres(CAMERA.width, CAMERA.height, &data);
        let mut thresholder = Thresholder::new(Parameters::default())?;
        let start = Instant::now();
        let (mut images, mut points) = (0, 0);
        while start.elapsed() < PATIENCE {
            let cloud = thresholder.points(&view, &CAMERA)?;
            let message = msg::cloud::from_points(Header::default(), &cloud);
            points = message.width;
            images += 1;
        }
        let rate = f64::from(images) / start.elapsed().as_secs_f64();
        rates.push(format!(
            "{{\"share\": {share}, \"points\": {points}, \"images_per_second\": {rate:.0}}}"
        ));
    }
    println!("[{}]", rates.join(", "));
    Ok(())
}

/// Rows of which a share is near, with a camera's noise, and the rest is a wall.
fn image(share: f64, random: &mut Pcg64Mcg) -> Vec<u8> {
    let near_rows = (f64::from(CAMERA.height) * share) as u32;
    let pixel = |row: u32, random: &mut Pcg64Mcg| -> u16 {
        let far_mm = if row < near_rows { 450 } else { 1500 };
        far_mm + random.random_range(0..3)
    };
    (0..CAMERA.height)
        .flat_map(|row| (0..CAMERA.width).map(move |_| row))
        .flat_map(|row| pixel(row, random).to_le_bytes())
        .collect()
}
