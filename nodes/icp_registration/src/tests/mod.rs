#![allow(clippy::unwrap_used)]

mod identity;
mod kinematic;
mod laws;
mod real;
mod refusals;
pub(crate) mod scene;
