//! What realsense2_camera publishes of its depth stream.

use std::f64::consts::FRAC_PI_2;

use msg::Time;
use msg::geometry_msgs::TransformStamped;
use msg::sensor_msgs::{CameraInfo, Image};
use msg::std_msgs::Header;
use msg::tf2_msgs::TFMessage;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use sim_camera::{DepthImage, Intrinsics};

/// The camera's body frame (x forward, y left, z up); where it is mounted is said elsewhere.
const CAMERA_FRAME: &str = "camera_link";
const DEPTH_FRAME: &str = "camera_depth_frame";
const OPTICAL_FRAME: &str = "camera_depth_optical_frame";

/// The depth image in millimetres.
pub fn image(stamp: Time, image: &DepthImage) -> Image {
    Image {
        header: header(stamp, OPTICAL_FRAME),
        height: image.height as u32,
        width: image.width as u32,
        encoding: "16UC1".into(),
        is_bigendian: 0,
        step: 2 * image.width as u32,
        data: image.to_le_bytes(),
    }
}

/// The camera_info beside an image: rectified, without distortion.
pub fn camera_info(stamp: Time, camera: &Intrinsics) -> CameraInfo {
    let Intrinsics {
        fx,
        fy,
        cx,
        cy,
        width,
        height,
    } = *camera;
    CameraInfo {
        header: header(stamp, OPTICAL_FRAME),
        height,
        width,
        distortion_model: "plumb_bob".into(),
        D: vec![0.0; 5],
        K: [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        R: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        P: [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        ..Default::default()
    }
}

/// The driver's frames within the camera.
pub fn camera_frames(stamp: Time) -> TFMessage {
    let frame = |parent, child: &str, parent_from_child| TransformStamped {
        header: header(stamp, parent),
        child_frame_id: child.into(),
        transform: msg::transform::from_isometry(&parent_from_child),
    };
    TFMessage {
        transforms: vec![
            frame(CAMERA_FRAME, DEPTH_FRAME, Isometry3::identity()),
            frame(DEPTH_FRAME, OPTICAL_FRAME, camera_from_optical()),
        ],
    }
}

/// From the optical axes (x right, y down, z forward) to the body's.
pub fn camera_from_optical() -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_euler_angles(-FRAC_PI_2, 0.0, -FRAC_PI_2);
    Isometry3::from_parts(Translation3::identity(), rotation)
}

fn header(stamp: Time, frame: &str) -> Header {
    Header {
        seq: 0,
        stamp,
        frame_id: frame.into(),
    }
}
