//! Weights of Eq. 5.

use serde::{Deserialize, Serialize};

/// How much each term of Eq. 5 counts, and the wanted length of edges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LossWeights {
    /// w_dist, of the Chamfer distance.
    pub distance: f64,
    /// w_edge, of the edges' lengths.
    pub edge: f64,
    /// w_normal, of the bends between triangles.
    pub normal: f64,
    /// w_smooth, of the Laplacian.
    pub smooth: f64,
    /// L_target: 0 penalizes every edge by its square.
    pub edge_target_m: f64,
}

impl Default for LossWeights {
    fn default() -> Self {
        Self {
            distance: 1.0,
            edge: 1.0,
            normal: 0.01,
            smooth: 0.1,
            edge_target_m: 0.0,
        }
    }
}

/// A weight that cannot be meant.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} of the loss is {value}: expected a number of at least 0")]
pub struct LossWeightError {
    /// Name of the setting.
    pub name: &'static str,
    /// What it was.
    pub value: f64,
}

impl LossWeights {
    /// Refuses negative and non-finite values.
    ///
    /// # Errors
    /// Names the first such value.
    pub fn validate(&self) -> Result<(), LossWeightError> {
        let values = [
            ("distance", self.distance),
            ("edge", self.edge),
            ("normal", self.normal),
            ("smooth", self.smooth),
            ("edge_target_m", self.edge_target_m),
        ];
        match values
            .into_iter()
            .find(|(_, v)| !(v.is_finite() && *v >= 0.0))
        {
            Some((name, value)) => Err(LossWeightError { name, value }),
            None => Ok(()),
        }
    }
}
