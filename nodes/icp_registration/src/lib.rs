//! Brings the views of a scan into one cloud, view after view.
//!
//! Each view is laid onto the model, which is all views before it, thinned to one point a voxel. Where the kinematics
//! say how the hand held the object before the camera, they are the start, and registration only corrects them: within
//! bounds, and only along motions that the surfaces determine. A can is nearly a cylinder; nothing in its shape tells
//! how far it was turned, and a registration from scratch slides on it. Without kinematics each view starts where the
//! first one was, as in the paper (Sec. VI-C and its reference implementation).

mod align;
mod axis_turn;
mod change;
mod check;
mod closed_form;
mod correction;
mod coverage;
mod error;
mod evidence;
mod judge;
mod matching;
mod model;
mod mount;
mod observability;
mod parameters;
mod point_to_point;
mod register;
mod registrar;
mod regrasp;
mod rows;
mod time_offset;
mod trust;
mod visibility;

pub use axis_turn::AxisTurn;
pub use error::{RegisterError, RegistrationError};
pub use evidence::{StopReason, ViewEvidence};
pub use mount::Displacement;
pub use parameters::{InitialGuess, Metric, Parameters};
pub use register::register;
pub use registrar::Registrar;
pub use regrasp::{Hidden, Regrasp, RegraspError, regrasp};
pub use time_offset::{TimeOffset, TimeOffsets};
pub use trust::Count;
pub use visibility::{Change, Comparison};

#[cfg(test)]
mod tests;
