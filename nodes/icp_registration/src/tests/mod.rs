#![allow(clippy::unwrap_used)]

mod changed;
mod identity;
mod kinematic;
mod laws;
mod real;
mod refusals;
mod regrasp;
pub(crate) mod scene;
