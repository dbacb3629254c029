//! What a user can set.

use hand_eye::HandRegion;
use parameter::{ParameterError, Tunable, tunables};
use serde::{Deserialize, Serialize};

/// Where registration of a view starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InitialGuess {
    /// The hand's pose before the camera, where a view has one; otherwise as `Identity`.
    Kinematic,
    /// The first view's place, as the paper does.
    Identity,
}

/// What registration makes small where it starts from kinematics. From identity it is always the distance between points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Metric {
    /// The distance of points from the model's surface (Chen and Medioni 1992).
    Plane,
    /// The distance between points (Besl and McKay 1992), as in the paper.
    Point,
}

/// How views are registered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Where registration starts: `kinematic` or `identity`.
    pub initial_guess: InitialGuess,
    /// Side of the cubes in which the model keeps one point each, m.
    pub voxel_m: f64,
    /// How many of a view's thinned points are matched at most.
    pub sample_count: usize,
    /// A view with fewer points than this is an error.
    pub min_points: usize,
    /// The smallest share of a view's points that must have a neighbour in the model; below, the view is refused.
    pub min_fitness: f64,

    /// Kinematic start: what is made small, the distance to the surface (`plane`) or between points (`point`).
    pub metric: Metric,
    /// Kinematic start: farthest that a point may be from its neighbour, m.
    pub max_correspondence_m: f64,
    /// Kinematic start: steps at most.
    pub max_iterations: usize,
    /// Kinematic start: share of the pairs that is used, those that fit best.
    pub kept_fraction: f64,
    /// Kinematic start: farthest that the view's middle may be moved, m; a view that asks for more is refused.
    pub max_correction_m: f64,
    /// Kinematic start: most that the view may be turned, rad; a view that asks for more is refused.
    pub max_correction_rad: f64,
    /// Kinematic start: a motion is left alone if the mean square of how much it moves the surfaces along their
    /// normals is below this share of how much it moves the points. 0 corrects everything.
    pub degenerate_below: f64,
    /// Kinematic start: only points above this plane of the hand frame are matched, m. What is below, the forearm, does
    /// not turn with the wrist.
    pub rigid_above_m: f64,
    /// Kinematic start: only points this near to the hand's axis are matched, m.
    pub rigid_radius_m: f64,

    /// Kinematic start: from the hand's origin to the fingertips, m, as in roi_crop.
    pub gripper_length_m: f64,
    /// Kinematic start: largest share of the object that a view may miss, or show anew, where it and the views before
    /// should see the same. Beyond it the object has changed, and the scan ends.
    pub max_change: f64,
    /// Kinematic start: the same share of the gripper. Beyond it the pose is wrong, which says nothing about the object.
    pub max_gripper_change: f64,
    /// A scan in which a view shares less of its points with those before is not to be trusted.
    pub min_overlap: f64,
    /// Kinematic start: farthest that the hand's axis may be from where kinematics and mount put it, m; beyond it the scan
    /// is not to be trusted.
    pub max_displacement_m: f64,
    /// Kinematic start: the same for the angle between the axes, rad.
    pub max_tilt_rad: f64,

    /// Identity start: farthest that a point may be from its neighbour, m.
    pub identity_max_correspondence_m: f64,
    /// Identity start: steps at most.
    pub identity_max_iterations: usize,
    /// Identity start: it ends when a step changes neither fitness nor RMSE by more than this share.
    pub identity_relative_stop: f64,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            initial_guess: InitialGuess::Kinematic,
            voxel_m: 0.002,
            sample_count: 3000,
            min_points: 100,
            min_fitness: 0.3,
            metric: Metric::Plane,
            max_correspondence_m: 0.01,
            max_iterations: 30,
            kept_fraction: 0.9,
            max_correction_m: 0.015,
            max_correction_rad: 8.0_f64.to_radians(),
            degenerate_below: 0.02,
            rigid_above_m: HandRegion::default().above_m,
            rigid_radius_m: HandRegion::default().radius_m,
            gripper_length_m: 0.1577,
            max_change: 0.15,
            max_gripper_change: 0.2,
            min_overlap: 0.5,
            max_displacement_m: 0.024,
            max_tilt_rad: 3.0_f64.to_radians(),
            identity_max_correspondence_m: 0.01,
            identity_max_iterations: 1000,
            identity_relative_stop: 1e-6,
        }
    }
}

impl Parameters {
    /// What may change from one scan to the next.
    pub const TUNABLES: &[Tunable<Self>] = tunables! { Self;
        voxel_m: f64, 0.0002..=0.05, "m", "Side of the cubes in which the model keeps one point each";
        sample_count: usize, 100..=1_000_000, "", "How many of a view's points are matched at most";
        min_points: usize, 10..=1_000_000, "", "A view with fewer points is an error";
        min_fitness: f64, 0.0..=1.0, "", "Smallest share of a view's points with a neighbour";
        max_correspondence_m: f64, 0.0005..=0.1, "m", "Kinematic start: farthest neighbour";
        max_iterations: usize, 1..=10_000, "", "Kinematic start: steps at most";
        kept_fraction: f64, 0.1..=1.0, "", "Kinematic start: share of the pairs that is used";
        max_correction_m: f64, 0.0..=0.2, "m", "Kinematic start: farthest that a view may be moved";
        max_correction_rad: f64, 0.0..=1.0, "rad", "Kinematic start: most that a view may be turned";
        degenerate_below: f64, 0.0..=1.0, "", "Kinematic start: motions that move surfaces less are left alone";
        rigid_above_m: f64, -1.0..=1.0, "m", "Kinematic start: only points above this plane are matched";
        rigid_radius_m: f64, 0.01..=10.0, "m", "Kinematic start: only points this near to the axis are matched";
        gripper_length_m: f64, 0.0..=1.0, "m", "Kinematic start: from the hand's origin to the fingertips";
        max_change: f64, 0.0..=1.0, "", "Kinematic start: the scan ends where more of the object is gone or new";
        max_gripper_change: f64, 0.0..=1.0, "", "Kinematic start: a pose that changes more of the gripper is wrong";
        min_overlap: f64, 0.0..=1.0, "", "A scan with a view that shares less with those before is doubted";
        max_displacement_m: f64, 0.0..=1.0, "m", "Kinematic start: a hand farther from its place is doubted";
        max_tilt_rad: f64, 0.0..=3.2, "rad", "Kinematic start: a hand tilted more from its place is doubted";
        identity_max_correspondence_m: f64, 0.0005..=0.5, "m", "Identity start: farthest neighbour";
        identity_max_iterations: usize, 1..=100_000, "", "Identity start: steps at most";
        identity_relative_stop: f64, 0.0..=0.1, "", "Identity start: it ends when a step changes less";
    };

    /// The part of the hand's frame that is matched and compared.
    pub(crate) fn region(&self) -> HandRegion {
        HandRegion {
            above_m: self.rigid_above_m,
            radius_m: self.rigid_radius_m,
        }
    }

    /// Square of the distance along the surface beyond which a point's neighbour does not count for it, m²: the point hangs
    /// over the edge of what the model has seen.
    pub(crate) fn aside_max_sq(&self) -> f32 {
        const ASIDE_VOXELS: f64 = 1.5;
        (ASIDE_VOXELS * self.voxel_m).powi(2) as f32
    }

    /// Checks every number against its range.
    ///
    /// # Errors
    /// The first that is out of it.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let mut tunables = Self::TUNABLES.iter();
        tunables.try_for_each(|tunable| tunable.check(self))
    }
}
