//! Settings of making a dent.

use serde::{Deserialize, Serialize};

use crate::deformer::Energy;
use crate::grasp::GraspSettings;
use crate::loss::LossWeights;
use arap::ArapSettings;

/// How an object is grasped and deformed, and how the deformation is rated.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// The energy of a deformation (paper Eq. 3).
    pub energy: Energy,
    /// How smooth and exact it is.
    pub arap: ArapSettings,
    /// The gripper (Sec. IV-B).
    pub grasp: GraspSettings,
    /// The loss (Eq. 5).
    pub loss: LossWeights,
}
