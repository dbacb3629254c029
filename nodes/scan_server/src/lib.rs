//! A scan from the goal to the label.
//!
//! [`Scanner::scan`] makes one: it has the wrist turned and views taken, at rest or during one sweep, hands the views to the
//! later stages, and waits for their answer. [`GoalServer`] is the server of the action that asks for scans. What both need of
//! the running graph is in [`Stages`] and [`Topics`], so that they can be tried without it.

mod answers;
mod goal_server;
mod goals;
mod parameters;
mod progress;
mod scanner;
mod stages;

pub use goal_server::{GoalServer, Topics};
pub use goals::{GoalId, GoalState, Goals, Outcome, Status};
pub use parameters::Parameters;
pub use progress::{Progress, State};
pub use scanner::{Scanned, Scanner};
pub use stages::{Stages, Wish};
