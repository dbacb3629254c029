//! Which wrist angles views are taken at, and when one may be taken.
//!
//! In active mode [`plan`] gives the wrist angles to ask for. In passive mode [`Rests`] and [`Sweep`] watch the wrist and
//! the clouds and find the views in what somebody else makes the robot do (paper, Sec. VI-C 2).

mod moved;
mod parameters;
mod plan;
mod pose_check;
mod rests;
mod sweep;

pub use parameters::{Mode, Parameters};
pub use plan::{PlanError, check, plan};
pub use pose_check::{ImagePlane, PoseError, PoseRules};
pub use rests::{RestRules, RestView, Rests};
pub use sweep::{ScanView, Sweep, SweepRules};
