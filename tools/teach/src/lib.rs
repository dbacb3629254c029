//! Teaches a model one more object: dents its mesh, looks at it in simulation, and fits the last layers of the network again.
//!
//! [`teach::teach`] does all of it. [`stored::Stored`] is a model with its features and its history, which [`change`] changes
//! without an object.

pub mod adapt;
pub mod change;
pub mod graph;
pub mod history;
pub mod judge;
pub mod look;
pub mod object;
pub mod prepare;
pub mod progress;
pub mod source;
pub mod stored;
pub mod teach;
mod together;
pub mod unprepared;
pub mod views;
