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
    /// How.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// What.
    #[error("view {index}")]
    View {
        /// From 0.
        index: usize,
        /// Why.
        source: RegistrationError,
    },
}
