#![allow(clippy::unwrap_used)]

mod identity;
mod kinematic;
mod real;
mod refusals;
pub(crate) mod scene;
