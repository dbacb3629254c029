//! Which views make a scan, and when one may be taken.
//!
//! In active mode [`plan`] gives the wrist angles to ask for; in passive mode [`Sweep`] watches the wrist and the clouds and
//! finds the views in what somebody else makes the robot do (paper, Sec. VI-C 2).

mod parameters;
mod plan;
mod sweep;

pub use parameters::{Mode, Parameters};
pub use plan::{PlanError, plan};
pub use sweep::{Sweep, SweepRules, Taken};
