//! Weights of Eq. 5.

use serde::{Deserialize, Serialize};

/// Weights of the terms of Eq. 5, each at least 0, and the target length of edges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LossWeights {
    /// w_dist: weight of the Chamfer distance.
    pub distance: f64,
    /// w_edge: weight of the edges' lengths.
    pub edge: f64,
    /// w_normal: weight of the bends between adjacent triangles.
    pub normal: f64,
    /// w_smooth: weight of the Laplacian.
    pub smooth: f64,
    /// L_target: wanted length of edges, m. At 0 every edge costs its squared length.
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

/// A weight out of range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} of the loss is {value}: expected a number of at least 0")]
pub struct LossWeightError {
    /// Name of the setting.
    pub name: &'static str,
    /// Its value.
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
