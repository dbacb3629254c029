#![allow(clippy::unwrap_used)]

use std::env;
use std::path::{Path, PathBuf};

use super::*;

const ANY_OPENING: Frame = Frame::Hand { opening_m: None };
const PLANE_M: f32 = 0.1277;

fn cropper() -> Cropper {
    Cropper::new(Parameters::default()).unwrap()
}

/// A sheet of points 2 mm apart, parallel to y and z, at this x, between these y and heights above the plane.
fn sheet(x: f32, y: [f32; 2], height: [f32; 2]) -> Vec<Point3<f32>> {
    const STEP_M: f32 = 0.002;
    let steps = |range: [f32; 2]| {
        (0..)
            .map(move |step| range[0] + STEP_M * step as f32)
            .take_while(move |at| *at <= range[1])
    };
    steps(y)
        .flat_map(|y| steps(height).map(move |height| Point3::new(x, y, PLANE_M + height)))
        .collect()
}

#[test]
fn each_point_is_counted_once_where_it_went() {
    let object = sheet(0.033, [-0.02, 0.02], [0.001, 0.1]);
    let mut points = object.clone();
    points.extend([Point3::new(0.03, 0.0, 0.1), Point3::new(0.5, 0.0, 0.05)]);
    points.extend([Point3::new(0.08, 0.05, 0.2), Point3::new(0.0, 0.0, 0.4)]);
    points.extend(sheet(0.0, [0.034, 0.042], [0.001, 0.031]));
    points.push(Point3::new(-0.05, -0.05, 0.25));
    let crop = cropper().crop(&points, ANY_OPENING).unwrap();
    assert_eq!(crop.points, object);
    assert_eq!(crop.up, Vector3::z());
    let fingers = points.len() - object.len() - 5;
    assert_eq!(
        crop.removed,
        Removed {
            below_gripper: 2,
            outside_cylinder: 2,
            on_fingers: fingers,
            outliers: 1
        }
    );
    assert_eq!(crop.removed.total() + crop.points.len(), points.len());
}

#[test]
fn a_known_opening_cuts_from_the_fingers_faces_on() {
    let frame = Frame::Hand {
        opening_m: Some(0.066),
    };
    // The face of a larger object beside a finger, and something beyond both.
    let points = [
        sheet(0.03, [-0.05, 0.05], [0.001, 0.02]),
        sheet(0.0, [0.02, 0.06], [0.001, 0.02]),
    ]
    .concat();
    let crop = cropper().crop(&points, frame).unwrap();
    let on_finger = |point: &&Point3<f32>| point.x == 0.0 && point.y >= 0.031;
    assert_eq!(
        crop.removed.on_fingers,
        points.iter().filter(on_finger).count()
    );
    assert_eq!(crop.removed.outside_cylinder, 0);
    let unknown = cropper().crop(&points, ANY_OPENING).unwrap();
    assert!(unknown.removed.on_fingers > crop.removed.on_fingers);
}

#[test]
fn above_the_fingertips_and_without_fingers_nothing_is_cut() {
    let above = sheet(0.0, [0.03, 0.06], [0.033, 0.06]);
    assert_eq!(cropper().crop(&above, ANY_OPENING).unwrap().points, above);
    let between = sheet(0.0, [0.03, 0.06], [0.001, 0.02]);
    let no_fingers = Parameters {
        finger_width_m: 0.0,
        ..Parameters::default()
    };
    assert_eq!(
        Cropper::new(no_fingers)
            .unwrap()
            .crop(&between, ANY_OPENING)
            .unwrap()
            .points,
        between
    );
}

#[test]
fn without_kinematics_the_height_decides() {
    for (axis, up) in [
        ("+z", Vector3::z()),
        ("-z", -Vector3::z()),
        ("-y", -Vector3::y()),
        ("+x", Vector3::x()),
    ] {
        let parameters = Parameters {
            up_axis: axis.parse().unwrap(),
            keep_above_m: 0.0205,
            ..Parameters::default()
        };
        let place = |height: f32| {
            let side = if up.x == 0.0 {
                Vector3::x()
            } else {
                Vector3::y()
            };
            Point3::from(up.cast() * height + side * 3.0)
        };
        let points: Vec<_> = (0..40).map(|step| place(0.001 * step as f32)).collect();
        let crop = Cropper::new(parameters)
            .unwrap()
            .crop(&points, Frame::Camera)
            .unwrap();
        assert_eq!(
            (crop.up, crop.removed.below_gripper, crop.points.len()),
            (up, 21, 19),
            "{axis}"
        );
    }
}

#[test]
fn nothing_left_says_where_it_went_and_where_to_look() {
    let refusal =
        |points: &[Point3<f32>], frame| cropper().crop(points, frame).unwrap_err().to_string();
    let object = sheet(0.03, [-0.02, 0.02], [0.001, 0.02]);
    let moved = |x, y, z| {
        object
            .iter()
            .map(|point| point + Vector3::new(x, y, z))
            .collect::<Vec<_>>()
    };
    let count = object.len();

    let message = refusal(&moved(0.0, 0.0, -0.1), ANY_OPENING);
    assert!(
        message.contains(&format!("{count} below the gripper"))
            && message.contains("grasp_depth_m"),
        "{message}"
    );
    let message = refusal(&moved(0.2, 0.0, 0.0), ANY_OPENING);
    assert!(
        message.contains(&format!("{count} outside the cylinder")) && message.contains("radius_m"),
        "{message}"
    );
    let message = refusal(&moved(-0.03, 0.045, 0.0), ANY_OPENING);
    assert!(
        message.contains(&format!("{count} on the fingers")) && message.contains("finger_inner_m"),
        "{message}"
    );
    let message = refusal(&object[..3], ANY_OPENING);
    assert!(
        message.contains("3 strays") && message.contains("stray_min_neighbours"),
        "{message}"
    );
    let message = refusal(&moved(0.0, 0.3, 0.0), Frame::Camera);
    assert!(message.contains("keep_above_m"), "{message}");
}

#[test]
fn few_points_are_no_object() {
    let least = Parameters::default().min_points;
    assert!(cropper().is_object(least) && !cropper().is_object(least - 1));
    assert_eq!(cropper().up(ANY_OPENING), Vector3::z());
    assert_eq!(cropper().up(Frame::Camera), Axis::OPTICAL_UP.vector());
}

#[test]
fn empty_and_not_finite_clouds_are_refused() {
    assert_eq!(cropper().crop(&[], ANY_OPENING), Err(CropError::Empty));
    let mut points = sheet(0.03, [-0.02, 0.02], [0.001, 0.02]);
    points[4].z = f32::NAN;
    assert_eq!(
        cropper().crop(&points, ANY_OPENING),
        Err(CropError::NotFinite { index: 4 })
    );
}

#[test]
fn axes_are_read_and_written() {
    for text in ["+x", "-x", "+y", "-y", "+z", "-z"] {
        assert_eq!(text.parse::<Axis>().unwrap().to_string(), text);
    }
    for text in ["", "+", "y", "+w", "--y", "+yy", "up"] {
        assert!(
            text.parse::<Axis>()
                .unwrap_err()
                .to_string()
                .contains("no axis"),
            "{text}"
        );
    }
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let refusal = |yaml: &str| match serde_yaml::from_str::<Parameters>(yaml) {
        Ok(parameters) => Cropper::new(parameters).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    };
    assert!(refusal("radius_m: 0").contains("radius_m is 0; it must be from 0.01 to 1 m"));
    assert!(
        refusal("grasp_depth_m: 0.2")
            .contains("grasp_depth_m is 0.2; it must be from 0 to 0.1577 m")
    );
    assert!(refusal("keep_above_m: .inf").contains("keep_above_m is inf"));
    assert!(refusal("min_points: 0").contains("min_points is 0"));
    assert!(refusal("up_axis: up").contains("\"up\" is no axis"));
    assert!(refusal("radius: 1").contains("radius"));
}

#[test]
#[ignore = "needs real data: DEFORMABLE_COBOT_REAL names the folder, ../shared/real by default"]
fn a_real_can_stands_out_of_its_box() {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let folder = env::var_os("DEFORMABLE_COBOT_REAL").map_or_else(beside, PathBuf::from);
    // As the viewer exports: y up.
    let parameters = Parameters {
        up_axis: "+y".parse().unwrap(),
        ..Parameters::default()
    };
    let cropper = Cropper::new(parameters).unwrap();
    for number in 1..=3 {
        let view = cloud::read(folder.join(format!("captures/can_a/out_{number}.ply")))
            .unwrap()
            .points;
        let crop = cropper.crop(&view, Frame::Camera).unwrap();
        let extent = cloud::bounds(&crop.points).unwrap().extent();
        println!(
            "view {number}: {} of {} points, {:?}, extent {extent:?}",
            crop.points.len(),
            view.len(),
            crop.removed
        );
        assert!(
            extent.x > 0.05 && extent.x < 0.08 && extent.y > 0.10 && extent.y < 0.14,
            "{extent:?}"
        );
    }
}
