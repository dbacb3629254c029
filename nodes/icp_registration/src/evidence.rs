//! What registration says about each view.

use nalgebra::Isometry3;

use crate::visibility::Comparison;

/// How a view was brought into the common cloud, and how well it fits there.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewEvidence {
    /// Maps the view's points into the common frame; of a view that was refused, its start.
    pub transform: Isometry3<f64>,
    /// Whether the view is in the cloud; otherwise it was refused.
    pub accepted: bool,
    /// Why it was refused; empty if it was not.
    pub reason: String,
    /// What ended the search.
    pub stop_reason: StopReason,
    /// Share of the view's (thinned) points with a neighbour within the matching distance.
    pub fitness: f64,
    /// Root of the mean square of those distances, m.
    pub rmse_m: f64,
    /// Number of those points.
    pub inliers: usize,
    /// Steps taken.
    pub iterations: usize,
    /// How far registration moved, or would have moved, the view's middle from the start, m. The start is what kinematics
    /// say, with what the views before said of the camera mount.
    pub correction_m: f64,
    /// How far it turned the view, or would have, rad.
    pub correction_rad: f64,
    /// Of the six motions, how many the surfaces leave free and were therefore not corrected. Always 0 from identity.
    pub degenerate_directions: usize,
    /// What it sees, compared with what the views before saw. Nothing changed where there are no kinematics.
    pub comparison: Comparison,
}

impl ViewEvidence {
    /// That of the view that makes the frame.
    pub(crate) fn first_view(transform: Isometry3<f64>, count: usize) -> Self {
        Self {
            transform,
            accepted: true,
            reason: String::new(),
            stop_reason: StopReason::FirstView,
            fitness: 1.0,
            rmse_m: 0.0,
            inliers: count,
            iterations: 0,
            correction_m: 0.0,
            correction_rad: 0.0,
            degenerate_directions: 0,
            comparison: Comparison::default(),
        }
    }

    /// Takes back that the view was accepted.
    pub(crate) fn refuse(&mut self, reason: &str) {
        self.accepted = false;
        self.reason = reason.to_owned();
        self.stop_reason = StopReason::Refused;
    }

    /// That of a view that touches none before it.
    pub(crate) fn unmatched(start: Isometry3<f64>) -> Self {
        Self {
            accepted: false,
            reason: "too few of its points are near the views before it".to_owned(),
            stop_reason: StopReason::Refused,
            fitness: 0.0,
            ..Self::first_view(start, 0)
        }
    }
}

/// What ended the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// A step that changed nothing more.
    Converged,
    /// The largest number of steps.
    IterationLimit,
    /// There was nothing to search: the first view makes the frame.
    FirstView,
    /// The result was not accepted.
    Refused,
}

impl StopReason {
    /// As in messages.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::IterationLimit => "iteration_limit",
            Self::FirstView => "first_view",
            Self::Refused => "refused",
        }
    }
}
