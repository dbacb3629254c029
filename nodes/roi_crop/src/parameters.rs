//! What a user can set.

use baxter::{Gap, Side};
use parameter::{ParameterError, Tunable, check_ranges, tunables};
use serde::{Deserialize, Serialize};

use crate::Axis;

/// Where the object is in a cloud. Defaults are for Baxter's electric gripper with standard fingers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Hand frame: from its origin to the fingertips, m.
    pub gripper_length_m: f64,
    /// Hand frame: how deep the object stands between the fingers, m.
    pub grasp_depth_m: f64,
    /// Hand frame: farthest that the object reaches from the hand's axis, m. The largest cup has 44 mm; the rest is for
    /// a camera whose place is known badly.
    pub radius_m: f64,
    /// Hand frame: height of the tallest object, m.
    pub height_m: f64,
    /// Hand frame: width of a finger along x, m; 0 leaves the fingers in.
    pub finger_width_m: f64,
    /// Arm whose electric gripper says how far apart the fingers are: left or right.
    pub side: Side,
    /// How far apart they are at the ends of their travel, m.
    pub gap: Gap,
    /// Hand frame: where a finger's inner face may begin, from the axis, m, while the opening is unknown.
    pub finger_inner_m: f64,
    /// Hand frame: how much larger than the fingers the boxes are that are cut out, on each side, m.
    pub finger_margin_m: f64,

    /// Camera frame: which axis points up: `+x`, `-x`, `+y`, `-y`, `+z` or `-z`.
    pub up_axis: Axis,
    /// Camera frame: what is not higher than this along `up_axis` is no object, m.
    pub keep_above_m: f64,

    /// A point must have neighbours within this distance, m.
    pub stray_radius_m: f64,
    /// So many of them; 0 keeps all points.
    pub stray_min_neighbours: usize,

    /// What has fewer points is no object: the hand is empty. One view of the smallest ball has some 1200.
    pub min_points: usize,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            gripper_length_m: 0.1577,
            grasp_depth_m: 0.03,
            radius_m: 0.09,
            height_m: 0.22,
            finger_width_m: 0.042,
            side: Side::Left,
            gap: Gap::default(),
            finger_inner_m: 0.022,
            finger_margin_m: 0.002,
            up_axis: Axis::OPTICAL_UP,
            keep_above_m: -0.115,
            stray_radius_m: 0.006,
            stray_min_neighbours: 4,
            min_points: 256,
        }
    }
}

impl Parameters {
    /// What may change from one cloud to the next.
    pub const TUNABLES: &[Tunable<Self>] = tunables! { Self;
        gripper_length_m: f64, 0.0..=1.0, "m", "From the hand's origin to the fingertips";
        grasp_depth_m: f64, 0.0..=1.0, "m", "How deep the object stands between the fingers";
        radius_m: f64, 0.01..=1.0, "m", "Farthest that the object reaches from the hand's axis";
        height_m: f64, 0.01..=2.0, "m", "Height of the tallest object";
        finger_width_m: f64, 0.0..=0.5, "m", "Width of a finger; 0 leaves the fingers in";
        finger_inner_m: f64, 0.0..=0.5, "m", "Where a finger's inner face may begin, from the axis";
        finger_margin_m: f64, 0.0..=0.05, "m", "How much larger the boxes are that cut the fingers out";
        keep_above_m: f64, -100.0..=100.0, "m", "Without kinematics: height up to which all is ground";
        stray_radius_m: f64, 0.0005..=0.5, "m", "Distance within which a point must have neighbours";
        stray_min_neighbours: usize, 0..=1000, "", "So many of them; 0 keeps all points";
        min_points: usize, 1..=1_000_000, "", "What has fewer points is an empty hand";
    };

    /// Checks every number against its range.
    ///
    /// # Errors
    /// The first that is out of it.
    pub fn validate(&self) -> Result<(), ParameterError> {
        for tunable in Self::TUNABLES {
            tunable.check(self)?;
        }
        check_ranges! { self;
            grasp_depth_m: 0.0..=self.gripper_length_m, "m (gripper_length_m)";
        }
        self.gap.validate()
    }
}
