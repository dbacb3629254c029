use crate::{Calibration, Intrinsics, IntrinsicsError};

const RECTIFIED: &str = "/camera/depth/image_rect_raw";
const RAW: &str = "/camera/aligned_depth_to_color/image_raw";
const K: [f64; 9] = [418.0, 0.0, 424.0, 0.0, 418.0, 238.0, 0.0, 0.0, 1.0];
const P: [f64; 12] = [
    400.0, 0.0, 420.0, -20.0, 0.0, 401.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0,
];
const D: [f64; 5] = [0.1, -0.2, 0.0, 0.0, 0.05];

fn calibration<'a>(d: &'a [f64], k: &'a [f64; 9], p: &'a [f64; 12]) -> Calibration<'a> {
    Calibration {
        width: 848,
        height: 480,
        d,
        k,
        p,
        binning: [0; 2],
        region: [0; 4],
    }
}

fn lens(found: Result<Intrinsics, IntrinsicsError>) -> [f64; 4] {
    let lens = found.unwrap();
    [lens.fx, lens.fy, lens.cx, lens.cy]
}

#[test]
fn p_describes_the_rectified_image_and_k_the_other() {
    let of_p = [400.0, 401.0, 420.0, 240.0];
    let of_k = [418.0, 418.0, 424.0, 238.0];
    for topic in [RECTIFIED, "/kinect2/sd/image_depth_rect", "image_rect"] {
        assert_eq!(lens(calibration(&D, &K, &P).intrinsics(topic)), of_p);
        assert_eq!(lens(calibration(&[], &K, &P).intrinsics(topic)), of_p);
        // Nobody said: without distortion rectification changes nothing.
        assert_eq!(
            lens(calibration(&[0.0; 5], &K, &[0.0; 12]).intrinsics(topic)),
            of_k
        );
    }
    for topic in [RAW, "/direct_rect/depth/image"] {
        assert_eq!(lens(calibration(&[0.0; 5], &K, &P).intrinsics(topic)), of_k);
    }
}

#[test]
fn distortion_that_nobody_took_out_is_refused_by_name() {
    let message = calibration(&D, &K, &P)
        .intrinsics(RAW)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("distortion [0.1, -0.2, 0.0, 0.0, 0.05]"),
        "{message}"
    );
    assert!(
        message.contains(RAW) && message.contains("image_rect_raw"),
        "{message}"
    );
    let message = calibration(&D, &K, &[0.0; 12])
        .intrinsics(RECTIFIED)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("no P") && message.contains(RECTIFIED),
        "{message}"
    );
}

#[test]
fn a_region_and_binning_change_the_matrix() {
    let binned = Calibration {
        binning: [2, 2],
        region: [100, 60, 640, 400],
        ..calibration(&[], &K, &P)
    };
    let found = binned.intrinsics(RAW).unwrap();
    assert_eq!((found.width, found.height), (320, 200));
    assert_eq!(lens(Ok(found)), [209.0, 209.0, 162.0, 89.0]);
}

#[test]
fn bad_matrices_are_refused_by_name() {
    let refusal = |at: usize, value: f64| {
        let mut k = K;
        k[at] = value;
        calibration(&[], &k, &P)
            .intrinsics(RAW)
            .unwrap_err()
            .to_string()
    };
    let nothing = calibration(&[], &[0.0; 9], &[0.0; 12]);
    assert!(
        nothing
            .intrinsics(RAW)
            .unwrap_err()
            .to_string()
            .contains("calibrated")
    );
    assert!(refusal(0, -1.0).contains("fx = -1"));
    assert!(refusal(4, f64::NAN).contains("fy = NaN"));
    assert!(refusal(2, 900.0).contains("(900, 238)"));
    assert!(refusal(5, f64::NAN).contains("(424, NaN)"));
    assert!(refusal(1, 0.1).contains("is not [fx 0 cx"));
    let mut p = P;
    p[9] = 0.5;
    let message = calibration(&[], &K, &p)
        .intrinsics(RECTIFIED)
        .unwrap_err()
        .to_string();
    assert!(message.contains("camera_info's P"), "{message}");
}
