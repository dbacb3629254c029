//! Forward kinematics against published figures, and the scan pose against its promise.
#![allow(clippy::unwrap_used, missing_docs)]

use baxter::{Side, mirrored};
use nalgebra::{Isometry3, Point3, Quaternion, UnitQuaternion, Vector3};
use sim_baxter::{Kinematics, ScanPose, Urdf, UrdfError};

fn base_from_hand(angles_rad: &[f64; 7]) -> Isometry3<f64> {
    Kinematics::baxter()
        .unwrap()
        .base_from_hand(Side::Left, angles_rad)
        .unwrap()
}

fn distance_m(pose: &Isometry3<f64>, expected: [f64; 3]) -> f64 {
    (pose.translation.vector - Vector3::from(expected)).norm()
}

#[test]
fn hand_is_where_the_published_vectors_say() {
    let vectors = [
        ([0.0; 7], [0.79746, 0.99246, 0.32098]),
        (
            [0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0],
            [0.63393, 0.82893, 0.21935],
        ),
        (
            [-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5],
            [0.57123, 0.18079, 0.27115],
        ),
    ];
    for (angles_rad, expected) in vectors {
        let error_m = distance_m(&base_from_hand(&angles_rad), expected);
        println!("{angles_rad:?}: off by {:.4} mm", error_m * 1e3);
        assert!(error_m < 2e-5, "{angles_rad:?}: off by {error_m} m");
    }
}

#[test]
fn hand_is_turned_as_the_published_quaternion_says() {
    let pose = base_from_hand(&[-0.08, -1.0, -1.19, 1.94, 0.67, 1.03, -0.5]);
    let expected = Quaternion::new(0.0255, 0.14077, 0.98965, 0.01165);
    let error_rad = pose
        .rotation
        .angle_to(&UnitQuaternion::from_quaternion(expected));
    assert!(error_rad < 1e-4, "turned by {error_rad} rad");
}

#[test]
fn scan_poses_point_the_gripper_up_at_the_tabled_place() {
    let rows = [
        (
            [-0.387, 0.355, -1.435, 1.603, -1.209, 1.686, 0.0],
            [0.584, 0.000, 0.461],
        ),
        (
            [-0.040, 0.364, -1.389, 1.694, -1.185, 1.695, 0.0],
            [0.607, 0.169, 0.452],
        ),
        (
            [0.251, 0.371, -1.300, 1.994, -1.121, 1.650, 0.0],
            [0.519, 0.251, 0.461],
        ),
        (
            [0.519, 0.346, -1.260, 2.006, -1.124, 1.689, 0.0],
            [0.498, 0.369, 0.452],
        ),
    ];
    for (angles_rad, expected) in rows {
        let pose = base_from_hand(&angles_rad);
        let tilt_deg = tilt_deg(&pose);
        let error_mm = 1e3 * distance_m(&pose, expected);
        println!("{angles_rad:?}: off by {error_mm:.2} mm, tilted by {tilt_deg:.3} deg");
        assert!(error_mm < 1.2 && tilt_deg < 1.0);
    }
}

#[test]
fn wrist_turns_the_hand_about_its_own_z() {
    let mut angles_rad = [-0.387, 0.355, -1.435, 1.603, -1.209, 1.686, 0.0];
    let before = base_from_hand(&angles_rad);
    angles_rad[6] = 0.6;
    let before_from_after = before.inv_mul(&base_from_hand(&angles_rad));
    assert!(before_from_after.translation.vector.norm() < 1e-12);
    let turned = before_from_after.rotation.scaled_axis();
    assert!((turned - Vector3::z() * 0.6).norm() < 1e-9, "{turned:?}");
}

#[test]
fn right_hand_mirrors_the_left() {
    let kinematics = Kinematics::baxter().unwrap();
    let right = kinematics.base_from_hand(Side::Right, &[0.0; 7]).unwrap();
    assert!(distance_m(&right, [0.79746, -0.99246, 0.32098]) < 2e-5);
}

#[test]
fn mirrored_angles_put_the_right_hand_where_a_mirror_shows_the_left() {
    let left_rad = [-0.387, 0.355, -1.435, 1.603, -1.209, 1.686, 1.25];
    let left = base_from_hand(&left_rad).translation.vector;
    let kinematics = Kinematics::baxter().unwrap();
    let right = kinematics
        .base_from_hand(Side::Right, &mirrored(left_rad))
        .unwrap();
    assert!(distance_m(&right, [left.x, -left.y, left.z]) < 1e-4);
    assert!(tilt_deg(&right) < 0.1);
}

#[test]
fn shipped_scan_pose_is_valid_and_puts_the_object_before_the_camera() {
    let kinematics = Kinematics::baxter().unwrap();
    let text = include_str!("../../../config/scan_pose.yaml");
    let pose = ScanPose::from_yaml(text, &kinematics).unwrap();
    assert_eq!(pose, ScanPose::default(), "file and default must agree");
    let base_from_hand = base_from_hand(&pose.left_arm());
    assert!(tilt_deg(&base_from_hand) < 0.1);
    let base_from_camera = kinematics
        .chain("head_camera")
        .unwrap()
        .base_from_link(|joint| {
            if joint == "head_pan" {
                pose.head_pan_rad
            } else {
                0.0
            }
        });
    // Centre of a 12 cm object standing on the fingertips (z = 0.1577 m).
    let centre = base_from_hand * Point3::new(0.0, 0.0, 0.1577 + 0.06);
    let centre_in_camera = base_from_camera.inverse_transform_point(&centre);
    println!("centre of the object in head_camera: {centre_in_camera}");
    assert!((centre_in_camera - Point3::new(0.0, 0.0, 0.40)).norm() < 3e-3);
}

#[test]
fn scan_pose_outside_the_limits_is_refused_by_joint() {
    let kinematics = Kinematics::baxter().unwrap();
    let text = include_str!("../../../config/scan_pose.yaml").replace("1.603", "2.7");
    let error = ScanPose::from_yaml(&text, &kinematics)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("left_e1") && error.contains("2.7"),
        "{error}"
    );
    let text = include_str!("../../../config/scan_pose.yaml").replace("head_pan_rad", "head_tilt");
    let error = ScanPose::from_yaml(&text, &kinematics)
        .unwrap_err()
        .to_string();
    assert!(error.contains("head_tilt"), "{error}");
}

#[test]
fn fingertips_and_their_gap_are_those_of_the_electric_gripper() {
    let kinematics = Kinematics::baxter().unwrap();
    let tip = kinematics
        .chain("left_gripper")
        .unwrap()
        .base_from_link(|_| 0.0);
    let hand = base_from_hand(&[0.0; 7]);
    assert!((hand.inv_mul(&tip).translation.vector - Vector3::z() * 0.1577).norm() < 1e-9);
    let finger_y_m = |finger: &str, position_m: f64| {
        let chain = kinematics.chain(finger).unwrap();
        let position = |joint: &str| {
            if joint == "l_gripper_l_finger_joint" {
                position_m
            } else {
                0.0
            }
        };
        hand.inv_mul(&chain.base_from_link(position)).translation.y
    };
    let apart_m = |position_m| {
        finger_y_m("l_gripper_l_finger", position_m) - finger_y_m("l_gripper_r_finger", position_m)
    };
    assert!((apart_m(0.0) - 0.035).abs() < 1e-9);
    assert!((apart_m(0.020833) - 0.035 - 2.0 * 0.020833).abs() < 1e-9);
}

#[test]
fn faults_of_a_description_are_named() {
    let fault = |text: &str| Urdf::parse(text).unwrap_err();
    assert!(matches!(fault("<robot"), UrdfError::Xml(_)));
    let without_limit = r#"<robot><joint name="a" type="revolute"><parent link="x"/><child link="y"/></joint></robot>"#;
    assert!(matches!(
        fault(without_limit),
        UrdfError::Lacks { what: "limit", .. }
    ));
    let bad_origin = r#"<robot><joint name="a" type="fixed"><parent link="x"/><child link="y"/><origin xyz="0 nan 0"/></joint></robot>"#;
    assert!(matches!(
        fault(bad_origin),
        UrdfError::Invalid { what: "xyz", .. }
    ));
    let unknown = Kinematics::baxter().unwrap().chain("left_paw").unwrap_err();
    assert!(unknown.to_string().contains("left_paw"));
}

/// Angle between the gripper's axis and straight up.
fn tilt_deg(pose: &Isometry3<f64>) -> f64 {
    (pose.rotation * Vector3::z())
        .angle(&Vector3::z())
        .to_degrees()
}

#[test]
fn limits_of_the_description_are_those_that_all_programs_know() {
    let kinematics = Kinematics::baxter().unwrap();
    for side in Side::BOTH {
        let described = kinematics.arm_limits(side).unwrap();
        for (described, known) in described.into_iter().zip(side.joint_limits()) {
            assert_eq!(described.lower, known.lower_rad);
            assert_eq!(described.upper, known.upper_rad);
            assert_eq!(described.velocity, known.velocity_max_rad_s);
        }
    }
}

#[test]
fn limits_that_no_angle_keeps_are_refused_by_the_joints_name() {
    let upside_down = Urdf::BAXTER.replacen("lower=\"-3.059\"", "lower=\"4.0\"", 1);
    assert_ne!(upside_down, Urdf::BAXTER);
    let error = Urdf::parse(&upside_down).unwrap_err();
    assert!(
        matches!(error, UrdfError::Invalid { what: "limit", .. }),
        "{error}"
    );
}
