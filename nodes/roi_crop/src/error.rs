//! Why there is no object.

use crate::{Frame, Removed};

/// Why a cloud could not be cropped.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CropError {
    /// No points.
    #[error("the cloud to crop has no points; did the camera see anything within its depth range?")]
    Empty,
    /// NaN or infinite.
    #[error("point {index} of the cloud to crop is NaN or infinite; drop such points first")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// All points were cut away: the hand is empty, or the parameters do not fit.
    #[error(
        "nothing of the object is left of {input} points: {} below the gripper, {} outside the cylinder, {} on the \
         fingers, {} strays; is there something in the hand? If so, look at {look_at}",
        removed.below_gripper, removed.outside_cylinder, removed.on_fingers, removed.outliers
    )]
    NothingLeft {
        /// Points there were.
        input: usize,
        /// Where they went.
        removed: Removed,
        /// The parameters that took most of them.
        look_at: &'static str,
    },
}

impl CropError {
    pub(crate) fn nothing_left(input: usize, removed: Removed, frame: Frame) -> Self {
        let below = match frame {
            Frame::Hand { .. } => "gripper_length_m and grasp_depth_m",
            Frame::Camera => "up_axis and keep_above_m",
        };
        let reasons = [
            (removed.below_gripper, below),
            (
                removed.outside_cylinder,
                "radius_m and height_m, and config/camera_mount.yaml",
            ),
            (removed.on_fingers, "finger_width_m and finger_inner_m"),
            (removed.outliers, "stray_radius_m and stray_min_neighbours"),
        ];
        let most = reasons.into_iter().max_by_key(|(count, _)| *count);
        Self::NothingLeft {
            input,
            removed,
            look_at: most.map_or(below, |(_, parameters)| parameters),
        }
    }
}
