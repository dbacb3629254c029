//! Which views make a scan, and when one may be taken.
//!
//! In active mode [`plan`] gives the wrist angles to ask for; in passive mode [`Sweep`] watches the wrist and the clouds and
//! finds the views in what somebody else makes the robot do (paper, Sec. VI-C 2). [`Goals`] are those of the action that
//! asks for scans.

mod goals;
mod parameters;
mod plan;
mod pose_check;
mod sweep;

pub use goals::{GoalId, GoalState, Goals, Outcome, Status};
pub use parameters::{Mode, Parameters};
pub use plan::{PlanError, plan};
pub use pose_check::{ImagePlane, PoseError, PoseRules};
pub use sweep::{Sweep, SweepRules, Taken};
