//! How simulated scans vary.

use serde::{Deserialize, Serialize};

/// How scans vary. Lengths in m, angles in rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScanParameters {
    /// Views of a specimen.
    pub view_count: usize,
    /// Turn of the wrist from view to view.
    pub view_step_rad: f64,
    /// Share of scans of an object that stands on a box instead of being held.
    pub table_share: f64,
    /// Smallest and largest turn of the box from view to view.
    pub table_step_rad: [f64; 2],
    /// Nearest and farthest distance of the camera from the axis of an object on a box.
    pub table_distance_m: [f64; 2],
    /// Lowest and highest elevation of the camera over an object on a box. The axis that a user names as up is the
    /// camera's own, so that it cannot look down much.
    pub table_elevation_rad: [f64; 2],
    /// Share of specimens without a dent.
    pub undented_share: f64,
    /// Shallowest and deepest dent.
    pub squeeze_m: [f64; 2],
    /// Share of the cans and cups with a facet where something flat was pressed against them, beside a gripper's dent.
    pub flattened_share: f64,
    /// Shallowest and deepest facet.
    pub flattening_m: [f64; 2],
    /// Largest lean of the wrist.
    pub wrist_lean_rad: f64,
    /// Largest lean of the object in the fingers.
    pub grasp_lean_rad: f64,
    /// Largest shift of the object in the fingers, along each axis.
    pub grasp_shift_m: f64,
    /// Lowest and highest elevation of the camera over a held object.
    pub elevation_rad: [f64; 2],
    /// Nearest and farthest distance of the camera from the object's axis.
    pub distance_m: [f64; 2],
    /// Largest error of the camera mount's direction.
    pub mount_error_rad: f64,
    /// Largest error of the camera mount's position.
    pub mount_error_m: f64,
    /// Share of scans in which the camera does not see all of one side of the object: shiny metal.
    pub flank_lost_share: f64,
    /// Least and most of it that is lost, in width.
    pub flank_lost_m: [f64; 2],
    /// How views are registered.
    pub registration: icp_registration::Parameters,
}

impl Default for ScanParameters {
    fn default() -> Self {
        Self {
            view_count: 4,
            view_step_rad: 0.6,
            table_share: 0.4,
            // A few tens of degrees: beyond that, views without kinematics seldom find each other.
            table_step_rad: [0.1, 0.7],
            table_distance_m: [0.25, 0.55],
            table_elevation_rad: [-0.05, 0.15],
            undented_share: 0.2,
            // As the paper dents (Sec. IV-B 7).
            squeeze_m: [0.004, 0.014],
            flattened_share: 0.3,
            flattening_m: [0.004, 0.014],
            wrist_lean_rad: 0.10,
            grasp_lean_rad: 0.03,
            grasp_shift_m: 0.002,
            elevation_rad: [-0.09, 0.70],
            distance_m: [0.30, 0.55],
            mount_error_rad: 0.035,
            mount_error_m: 0.010,
            flank_lost_share: 0.0,
            flank_lost_m: [0.0, 0.005],
            registration: icp_registration::Parameters::default(),
        }
    }
}

impl ScanParameters {
    /// Scans as in the demo: everything is where it is believed to be.
    pub fn nominal() -> Self {
        Self {
            table_share: 0.0,
            wrist_lean_rad: 0.0,
            grasp_lean_rad: 0.0,
            grasp_shift_m: 0.0,
            elevation_rad: [0.25, 0.25],
            distance_m: [0.40, 0.40],
            mount_error_rad: 0.0,
            mount_error_m: 0.0,
            flank_lost_share: 0.0,
            ..Self::default()
        }
    }
}
