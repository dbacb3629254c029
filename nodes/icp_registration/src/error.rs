//! Why there is no answer.

use cloud::voxel::VoxelError;
use parameter::ParameterError;

/// Why a view cannot be registered at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegistrationError {
    /// No points.
    #[error("the view has no points; is something within the camera's depth range?")]
    Empty,
    /// No shape.
    #[error(
        "the view has only {count} points (min_points is {needed}); is the object within the depth range?"
    )]
    TooFew {
        /// Points there.
        count: usize,
        /// Points needed.
        needed: usize,
    },
    /// NaN or infinite.
    #[error("point {index} of the view is NaN or infinite; drop such points first")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// Points without a surface.
    #[error("the view's {count} points lie on one line or in one place, and have no surface")]
    Collinear {
        /// Number of points.
        count: usize,
    },
    /// A plane without thickness.
    #[error(
        "the view's {count} points lie exactly in one plane; nothing tells where along it they belong, and no camera measures so"
    )]
    Planar {
        /// Number of points.
        count: usize,
    },
    /// Coordinates that cannot be in metres.
    #[error("the view is too large: {0}; are its points in metres?")]
    TooLarge(#[source] VoxelError),
    /// A pose of NaN or infinite numbers.
    #[error("the view's hand_from_camera is NaN or infinite; look at the transforms on /tf")]
    BadPose,
    /// The object is no longer where it was, nor another there.
    #[error(
        "the object is gone: {:.0} % of what the views before saw of it is not there any more. It was dropped or taken away; \
         put it back and scan again", 1e2 * .gone
    )]
    Dropped {
        /// Share of the surface that is gone, 0 to 1.
        gone: f64,
    },
    /// Another object is where the first was.
    #[error(
        "the hand holds another object than before, or the same one otherwise: {:.0} % of what the views before saw is gone, \
         and {:.0} % of what is there now they did not see. It was swapped, or it slipped in the fingers; scan again",
        1e2 * .gone, 1e2 * .new
    )]
    Swapped {
        /// Share of the surface that is gone, 0 to 1.
        gone: f64,
        /// Share of the surface that is new, 0 to 1.
        new: f64,
    },
    /// Something is there that was not.
    #[error(
        "something was put into the hand during the scan: {:.0} % of what is there now the views before did not see; scan \
         again", 1e2 * .new
    )]
    PutIn {
        /// Share of the surface that is new, 0 to 1.
        new: f64,
    },
    /// The same object, but not where the fingers held it.
    #[error(
        "the object slipped in the fingers by {:.0} mm since the views before: the pose that fits it does not fit the gripper; \
         grasp it firmly and scan again", 1e3 * .moved_m
    )]
    Slipped {
        /// How far its middle moved, m.
        moved_m: f64,
    },
    /// Some views with, some without kinematics.
    #[error(
        "this view has {} kinematic pose, but the scan began with one that has {}; give all views one, or none",
        if *.has_pose { "a" } else { "no" },
        if *.has_pose { "none" } else { "one" }
    )]
    MixedPoses {
        /// Whether this view has one.
        has_pose: bool,
    },
}

/// Why views cannot be registered at once.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegisterError {
    /// A parameter out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A view that cannot be registered.
    #[error("view {index}")]
    View {
        /// Index of the view, from 0.
        index: usize,
        /// The reason.
        source: RegistrationError,
    },
}
