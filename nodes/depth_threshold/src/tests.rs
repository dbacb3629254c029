#![allow(clippy::unwrap_used)]

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
        let data = depths
            .iter()
            .flat_map(|depth| depth.to_le_bytes())
            .collect();
        Self {
            width,
            encoding: "16UC1",
            is_bigendian: false,
            step: 2 * width,
            data,
        }
    }

    fn metres(width: u32, depths: &[f32]) -> Self {
        let data = depths
            .iter()
            .flat_map(|depth| depth.to_le_bytes())
            .collect();
        Self {
            width,
            encoding: "32FC1",
            is_bigendian: false,
            step: 4 * width,
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
fn what_is_no_depth_is_left_out() {
    let image = Image::metres(
        6,
        &[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 0.5],
    );
    assert_eq!(image.depths(keep_all()), [0.5]);
    assert_eq!(Image::millimetres(2, &[0, 500]).depths(keep_all()), [0.5]);
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
fn decimation_takes_the_lower_median_of_what_is_valid() {
    let depths = [500, 0, 10, 40, 504, 502, 30, 20];
    let parameters = Parameters {
        decimation: 2,
        ..keep_all()
    };
    let points = Image::millimetres(4, &depths).points(parameters);
    assert_eq!(
        points.iter().map(|point| point.z).collect::<Vec<_>>(),
        [0.502, 0.02]
    );
    // The decimated pixel (1, 0) with all four intrinsics halved.
    let camera = intrinsics(4, 2);
    assert!(
        (f64::from(points[1].x) - (1.0 - camera.cx / 2.0) / (camera.fx / 2.0) * 0.02).abs() < 1e-8
    );
}

#[test]
fn decimation_from_four_on_takes_the_mean_rounded_down() {
    let mut depths = [0; 16];
    depths[3] = 500;
    depths[9] = 501;
    let parameters = Parameters {
        decimation: 4,
        ..keep_all()
    };
    assert_eq!(
        Image::millimetres(4, &depths).depths(parameters.clone()),
        [0.5]
    );
    assert!(
        Image::millimetres(4, &[0; 16])
            .depths(parameters)
            .is_empty()
    );
}

#[test]
fn decimation_pads_to_multiples_of_four() {
    let mut depths = Depths::default();
    Image::millimetres(11, &[500; 11 * 7])
        .view()
        .decode(&mut depths)
        .unwrap();
    let mut decimated = Depths::default();
    decimation::decimate(&depths, 2, &mut decimated);
    assert_eq!((decimated.width, decimated.height), (8, 4));
    assert_eq!(
        decimated.row(2),
        [500.0, 500.0, 500.0, 500.0, 500.0, 0.0, 0.0, 0.0]
    );
    assert_eq!(decimated.row(3), [0.0; 8]);
    // A picture smaller than one square has no pixel left.
    assert!(
        Image::millimetres(3, &[500; 9])
            .depths(Parameters {
                decimation: 8,
                ..keep_all()
            })
            .is_empty()
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

/// The message for an image that is wrong in one way.
fn refusal(change: impl FnOnce(&mut DepthImage)) -> String {
    let image = Image::millimetres(4, &[500; 12]);
    let mut view = image.view();
    change(&mut view);
    let mut thresholder = Thresholder::new(Parameters::default()).unwrap();
    thresholder
        .points(&view, &intrinsics(view.width, view.height))
        .unwrap_err()
        .to_string()
}

#[test]
fn bad_images_are_refused_by_name() {
    assert!(refusal(|image| image.encoding = "8UC1").contains("encoding \"8UC1\""));
    assert!(refusal(|image| image.encoding = "rgb8").contains("encoding \"rgb8\""));
    assert!(refusal(|image| image.step = 7).contains("step 7"));
    assert!(refusal(|image| image.encoding = "32FC1").contains("step 8"));
    assert!(refusal(|image| image.data = &image.data[1..]).contains("23 bytes of data"));
    assert!(refusal(|image| image.step = 9).contains("24 bytes of data"));
    assert!(refusal(|image| image.height = u32::MAX).contains("bytes of data"));
    assert!(refusal(|image| image.width = u32::MAX).contains("step 8"));
    assert!(refusal(|image| image.height = 0).contains("4×0"));
}

#[test]
fn camera_info_of_another_stream_is_refused() {
    let image = Image::millimetres(4, &[500; 12]);
    let mut thresholder = Thresholder::new(Parameters::default()).unwrap();
    let message = thresholder
        .points(&image.view(), &intrinsics(8, 6))
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("4×3") && message.contains("8×6"),
        "{message}"
    );
}

#[test]
fn bad_intrinsics_are_refused_by_name() {
    let good = [418.0, 0.0, 424.0, 0.0, 418.0, 238.0, 0.0, 0.0, 1.0];
    assert!(Intrinsics::from_k(&good, 848, 480).is_ok());
    let refusal = |at: usize, value: f64| {
        let mut k = good;
        k[at] = value;
        Intrinsics::from_k(&k, 848, 480).unwrap_err().to_string()
    };
    assert!(
        Intrinsics::from_k(&[0.0; 9], 848, 480)
            .unwrap_err()
            .to_string()
            .contains("calibrated")
    );
    assert!(refusal(0, -1.0).contains("fx = -1"));
    assert!(refusal(4, f64::NAN).contains("fy = NaN"));
    assert!(refusal(2, 900.0).contains("(900, 238)"));
    assert!(refusal(5, f64::NAN).contains("(424, NaN)"));
    assert!(refusal(1, 0.1).contains("is not [fx 0 cx"));
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let refusal = |yaml: &str| {
        let parameters: Parameters = serde_yaml::from_str(yaml).unwrap();
        Thresholder::new(parameters).unwrap_err().to_string()
    };
    assert!(refusal("depth_max_m: .nan").contains("depth_max_m is NaN"));
    assert!(
        refusal("depth_min_m: 0.8")
            .contains("depth_min_m is 0.8; it must be from 0 to 0.7 m (depth_max_m)")
    );
    assert!(refusal("decimation: 9").contains("decimation is 9"));
    assert!(refusal("edge_jump_m: -0.1").contains("edge_jump_m is -0.1"));
    let unknown = serde_yaml::from_str::<Parameters>("depth_maximum: 1")
        .unwrap_err()
        .to_string();
    assert!(unknown.contains("depth_maximum"), "{unknown}");
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
