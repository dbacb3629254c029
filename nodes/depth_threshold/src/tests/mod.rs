#![allow(clippy::unwrap_used)]

mod compressed;
mod decimation;
mod encodings;
mod intrinsics;
mod refusals;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;

/// Everything is kept, so that a test switches on what it is about.
fn keep_all() -> Parameters {
    Parameters {
        depth_min_m: 0.0,
        depth_max_m: 60.0,
        decimation: 1,
        edge_jump_m: 0.0,
    }
}

fn intrinsics(width: u32, height: u32) -> Intrinsics {
    Intrinsics {
        fx: 400.0,
        fy: 410.0,
        cx: 0.49 * f64::from(width),
        cy: 0.52 * f64::from(height),
        width,
        height,
    }
}

/// An image's bytes in each form that a message may have.
struct Image {
    width: u32,
    encoding: &'static str,
    is_bigendian: bool,
    step: u32,
    data: Vec<u8>,
}

impl Image {
    fn millimetres(width: u32, depths: &[u16]) -> Self {
        let bytes = depths.iter().flat_map(|depth| depth.to_le_bytes());
        Self::little_endian("16UC1", 2 * width, width, bytes.collect())
    }

    fn metres(width: u32, depths: &[f32]) -> Self {
        let bytes = depths.iter().flat_map(|depth| depth.to_le_bytes());
        Self::little_endian("32FC1", 4 * width, width, bytes.collect())
    }

    fn little_endian(encoding: &'static str, step: u32, width: u32, data: Vec<u8>) -> Self {
        Self {
            width,
            encoding,
            is_bigendian: false,
            step,
            data,
        }
    }

    fn view(&self) -> DepthImage<'_> {
        DepthImage {
            width: self.width,
            height: (self.data.len() / self.step as usize) as u32,
            step: self.step,
            encoding: self.encoding,
            is_bigendian: self.is_bigendian,
            data: &self.data,
        }
    }

    fn points(&self, parameters: Parameters) -> Vec<Point3<f32>> {
        let view = self.view();
        Thresholder::new(parameters)
            .unwrap()
            .points(&view, &intrinsics(view.width, view.height))
            .unwrap()
    }

    fn depths(&self, parameters: Parameters) -> Vec<f32> {
        self.points(parameters)
            .iter()
            .map(|point| point.z)
            .collect()
    }
}

fn random_millimetres(seed: u64, count: usize) -> Vec<u16> {
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    (0..count)
        .map(|_| {
            if random.random_bool(0.2) {
                0
            } else {
                random.random_range(200..800)
            }
        })
        .collect()
}

#[test]
fn points_lie_where_the_pinhole_model_says() {
    let depths = random_millimetres(1, 12 * 10);
    let camera = intrinsics(12, 10);
    let mut expected = Vec::new();
    for (index, &depth) in depths
        .iter()
        .enumerate()
        .filter(|(_, depth)| (250..=700).contains(*depth))
    {
        let (u, v, z) = (
            (index % 12) as f64,
            (index / 12) as f64,
            f64::from(depth) / 1000.0,
        );
        expected.push(
            Point3::new(
                (u - camera.cx) / camera.fx * z,
                (v - camera.cy) / camera.fy * z,
                z,
            )
            .cast::<f32>(),
        );
    }
    let parameters = Parameters {
        edge_jump_m: 0.0,
        ..Parameters::default()
    };
    let points = Image::millimetres(12, &depths).points(parameters);
    assert_eq!(points.len(), expected.len());
    assert!(
        points
            .iter()
            .zip(&expected)
            .all(|(point, expected)| (point - expected).norm() < 1e-6)
    );
}

#[test]
fn what_is_no_depth_is_left_out() {
    let image = Image::metres(
        6,
        &[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 0.5],
    );
    assert_eq!(image.depths(keep_all()), [0.5]);
    assert_eq!(Image::millimetres(2, &[0, 500]).depths(keep_all()), [0.5]);
}

#[test]
fn pixels_at_a_depth_edge_are_dropped_and_slopes_are_kept() {
    let parameters = Parameters {
        edge_jump_m: 0.01,
        ..keep_all()
    };
    let step = Image::millimetres(6, &[500, 500, 500, 600, 600, 600]);
    assert_eq!(step.depths(parameters.clone()), [0.5, 0.5, 0.6, 0.6]);
    let slope = Image::millimetres(4, &[500, 510, 520, 530]);
    assert_eq!(slope.depths(parameters.clone()).len(), 4);
    let beside_nothing = Image::millimetres(4, &[500, 0, 500, 500]);
    assert_eq!(beside_nothing.depths(parameters.clone()).len(), 3);
    let upright = Image::millimetres(1, &[500, 500, 600]);
    assert_eq!(upright.depths(parameters.clone()), [0.5]);
    // The wall behind is out of range, but its edge is an edge.
    let before_wall = Parameters {
        depth_max_m: 0.7,
        ..parameters
    };
    assert_eq!(
        Image::millimetres(4, &[500, 500, 1500, 1500]).depths(before_wall),
        [0.5]
    );
}

#[test]
fn memory_of_the_image_before_does_not_show() {
    let mut thresholder = Thresholder::new(Parameters {
        decimation: 2,
        ..keep_all()
    })
    .unwrap();
    for (seed, width) in [(3, 16), (4, 8), (5, 20)] {
        let image = Image::millimetres(width, &random_millimetres(seed, width as usize * 6));
        let fresh = image.points(Parameters {
            decimation: 2,
            ..keep_all()
        });
        assert_eq!(
            thresholder
                .points(&image.view(), &intrinsics(width, 6))
                .unwrap(),
            fresh
        );
    }
}

#[test]
fn a_camera_frame_takes_a_few_milliseconds() {
    let (width, height) = (848_u32, 480_u32);
    let depths: Vec<u16> = (0..width * height)
        .map(|index| {
            let (x, y) = (index % width, index / width);
            if x.abs_diff(424) < 100 && y.abs_diff(240) < 140 {
                400 + (x.abs_diff(424) / 4) as u16
            } else {
                1500
            }
        })
        .collect();
    let image = Image::millimetres(width, &depths);
    for decimation in [1, 2] {
        let mut thresholder = Thresholder::new(Parameters {
            decimation,
            ..Parameters::default()
        })
        .unwrap();
        let start = std::time::Instant::now();
        let rounds: u32 = 100;
        let mut count = 0;
        for _ in 0..rounds {
            count = thresholder
                .points(&image.view(), &intrinsics(width, height))
                .unwrap()
                .len();
        }
        println!(
            "decimation {decimation}: {:?} an image, {count} points",
            start.elapsed() / rounds
        );
        assert!(count > 50_000 / (decimation * decimation) as usize);
    }
}
