#![allow(clippy::unwrap_used)]
use super::*;

const CAMERA: Intrinsics = crate::D435I;
const WIDTH: usize = CAMERA.width as usize;
const HEIGHT: usize = CAMERA.height as usize;
const QUIET: NoiseParameters = NoiseParameters {
    disparity_sigma_px: 0.0,
    correlated_share: 0.0,
    baseline_m: 0.04986,
    edge_dropout: 0.0,
    edge_mixing: 0.0,
};

/// A surface across the whole image whose depth grows by 4 % from left to right.
fn slope(depth_m: f64) -> InverseDepth {
    let mut image = InverseDepth::empty(WIDTH, HEIGHT);
    for row in image.per_m.chunks_exact_mut(WIDTH) {
        for (u, per_m) in row.iter_mut().enumerate() {
            let share = u as f64 / WIDTH as f64 - 0.5;
            *per_m = (1.0 / (depth_m * (1.0 + 0.04 * share))) as f32;
        }
    }
    image
}

/// Left half at one depth, right half at another.
fn step(left_m: f32, right_m: f32) -> InverseDepth {
    let mut image = InverseDepth::empty(WIDTH, HEIGHT);
    for row in image.per_m.chunks_exact_mut(WIDTH) {
        row[..424].fill(1.0 / left_m);
        row[424..].fill(1.0 / right_m);
    }
    image
}

/// How much farther than it is each pixel with a depth was measured, mm.
fn errors_mm(clean: &InverseDepth, measured: &DepthImage) -> impl Iterator<Item = f64> {
    let pixels = clean.per_m.iter().zip(&measured.depth_mm);
    pixels
        .filter(|(_, depth_mm)| **depth_mm > 0)
        .map(|(&per_m, &depth_mm)| f64::from(depth_mm) - 1000.0 / f64::from(per_m))
}

#[test]
fn the_errors_deviation_grows_with_the_square_of_depth() {
    let seed = 9;
    println!("seed {seed}");
    for correlated_share in [0.0, 0.5, 1.0] {
        let parameters = NoiseParameters {
            correlated_share,
            ..NoiseParameters::default()
        };
        let mut noise = Noise::new(parameters, seed).unwrap();
        for depth_m in [0.3, 0.5, 0.7, 1.5] {
            let clean = slope(depth_m);
            let measured = noise.apply(&clean, &CAMERA);
            let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
            for error_mm in errors_mm(&clean, &measured) {
                (count, sum, squares) =
                    (count + 1.0, sum + error_mm, squares + error_mm * error_mm);
            }
            // Steps of disparity and of millimetres are uniform errors of a twelfth of their squares.
            let mm_per_px = 1000.0 * depth_m * depth_m / (CAMERA.fx * 0.04986);
            let expected_mm =
                ((0.08 * mm_per_px).powi(2) + (mm_per_px / 32.0).powi(2) / 12.0 + 1.0 / 12.0)
                    .sqrt();
            let deviation_mm = (squares / count).sqrt();
            let ratio = deviation_mm / expected_mm;
            assert!(
                (0.95..1.05).contains(&ratio),
                "{depth_m} m: {deviation_mm} mm, expected {expected_mm} mm"
            );
            assert!(
                (sum / count).abs() < 0.05 * expected_mm,
                "{depth_m} m: mean {} mm",
                sum / count
            );
        }
    }
}

#[test]
fn neighbours_share_the_correlated_part() {
    let correlation = |correlated_share: f64| {
        let parameters = NoiseParameters {
            disparity_sigma_px: 0.5,
            correlated_share,
            ..QUIET
        };
        let clean = slope(0.8);
        let measured = Noise::new(parameters, 1).unwrap().apply(&clean, &CAMERA);
        let error = |k: usize| f64::from(measured.depth_mm[k]) - 1000.0 / f64::from(clean.per_m[k]);
        let pairs = (0..clean.per_m.len() - 1).filter(|k| k % 848 > 60 && k % 848 < 847);
        let (mut product, mut square) = (0.0, 0.0);
        for k in pairs {
            product += error(k) * error(k + 1);
            square += error(k) * error(k);
        }
        product / square
    };
    assert!(correlation(0.0).abs() < 0.02, "{}", correlation(0.0));
    assert!(
        (0.35..0.6).contains(&correlation(0.5)),
        "{}",
        correlation(0.5)
    );
}

#[test]
fn a_band_on_the_left_is_blind() {
    let mut noise = Noise::new(NoiseParameters::default(), 2).unwrap();
    for depth_m in [0.3_f32, 0.5, 0.7, 1.5] {
        let measured = noise.apply(&step(depth_m, depth_m), &CAMERA);
        let band_px = (CAMERA.fx * 0.04986 / f64::from(depth_m)).ceil() as usize;
        for v in 0..HEIGHT {
            let first = (0..WIDTH).find(|&u| measured.at(u, v) > 0);
            assert_eq!(first, Some(band_px), "row {v} at {depth_m} m");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_images_and_each_image_is_new() {
    let draw = |seed: u64| {
        let mut noise = Noise::new(NoiseParameters::default(), seed).unwrap();
        [
            noise.apply(&step(0.4, 0.9), &CAMERA),
            noise.apply(&step(0.4, 0.9), &CAMERA),
        ]
    };
    assert_eq!(draw(3), draw(3));
    assert_ne!(draw(3), draw(4));
    assert_ne!(draw(3)[0], draw(3)[1]);
}

#[test]
fn too_near_or_nothing_is_not_measured() {
    let mut noise = Noise::new(QUIET, 0).unwrap();
    assert!(
        noise
            .apply(&step(0.160, 0.165), &CAMERA)
            .depth_mm
            .iter()
            .all(|&depth_mm| depth_mm == 0)
    );
    assert!(
        noise
            .apply(&step(0.167, 0.170), &CAMERA)
            .depth_mm
            .iter()
            .any(|&depth_mm| depth_mm > 0)
    );
    let nothing = InverseDepth::empty(WIDTH, HEIGHT);
    let mut noise = Noise::new(NoiseParameters::default(), 0).unwrap();
    assert!(
        noise
            .apply(&nothing, &CAMERA)
            .depth_mm
            .iter()
            .all(|&depth_mm| depth_mm == 0)
    );
}

#[test]
fn without_error_only_the_steps_remain() {
    let clean = slope(0.45);
    let measured = Noise::new(QUIET, 0).unwrap().apply(&clean, &CAMERA);
    let half_step_mm = 0.5 * 1000.0 * 0.46 * 0.46 / (CAMERA.fx * 0.04986) / 32.0 + 0.5;
    for error_mm in errors_mm(&clean, &measured) {
        assert!(error_mm.abs() <= half_step_mm + 0.01, "{error_mm} mm");
    }
}

#[test]
fn pixels_at_an_edge_drop_out_or_lie_between() {
    let clean = step(0.9, 0.4);
    let edge = [422, 423, 424, 425];
    let count = |parameters: NoiseParameters, of: &dyn Fn(u16) -> bool| {
        let measured = Noise::new(parameters, 7).unwrap().apply(&clean, &CAMERA);
        edge.map(|u| (0..HEIGHT).filter(|&v| of(measured.at(u, v))).count())
    };
    // The shadow of the near right half hides what is left of it, so only the right side is telling.
    let dropped = count(
        NoiseParameters {
            edge_dropout: 1.0,
            ..QUIET
        },
        &|mm| mm == 0,
    );
    assert_eq!(dropped[2], 480);
    assert!((180..300).contains(&dropped[3]), "{dropped:?}");
    let between = count(
        NoiseParameters {
            edge_mixing: 1.0,
            ..QUIET
        },
        &|mm| (405..890).contains(&mm),
    );
    assert!(between[2] > 400 && between[3] == 0, "{between:?}");
    assert_eq!(count(QUIET, &|mm| mm == 400)[2..], [480, 480]);
}

#[test]
fn parameters_out_of_range_are_named() {
    for parameters in [
        NoiseParameters {
            disparity_sigma_px: -1.0,
            ..QUIET
        },
        NoiseParameters {
            disparity_sigma_px: f64::NAN,
            ..QUIET
        },
    ] {
        let error = Noise::new(parameters, 0).err().unwrap().to_string();
        assert!(
            error.contains("disparity_sigma_px") && error.contains("from 0 to 2"),
            "{error}"
        );
    }
    let error = NoiseParameters {
        edge_dropout: 1.5,
        ..QUIET
    }
    .validate()
    .unwrap_err()
    .to_string();
    assert_eq!(
        error,
        "parameter edge_dropout is 1.5; it must be from 0 to 1"
    );
}
