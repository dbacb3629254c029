//! Which wrist angles views are taken at, and when one may be taken.
//!
//! In active mode [`plan_scan`] gives the wrist angles to ask for, or the sweep whose images [`Spacing`] chooses from. In
//! passive mode [`Rests`] and [`Sweep`] watch the wrist and the clouds and find the views in what somebody else makes the
//! robot do (paper, Sec. VI-C 2).

mod moved;
mod offset;
mod parameters;
mod passage;
mod plan;
mod plan_error;
mod pose_check;
mod rests;
mod spacing;
mod sweep;
mod sweep_plan;
mod wrist_track;

pub use offset::ClockDifference;
pub use parameters::{Mode, Motion, Parameters};
pub use passage::{PassageRules, PassageView, Passages};
pub use plan::{check, plan, plan_scan};
pub use plan_error::PlanError;
pub use pose_check::{ImagePlane, PoseError, PoseRules};
pub use rests::{RestRules, RestView, Rests};
pub use spacing::{Place, Spacing};
pub use sweep::{ScanView, Sweep, SweepRules};
pub use sweep_plan::{SweepPlan, plan_sweep};
pub use wrist_track::{ClockSteps, WristTrack};
