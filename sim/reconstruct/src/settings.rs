//! Settings of reconstruction.

use std::num::NonZeroUsize;

use serde::{Deserialize, Serialize};

use crate::ReconstructError;
use crate::poisson;

/// How a scan becomes a mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Points that the cloud is thinned to before reconstruction (paper: about 10,000).
    pub point_count: usize,
    /// Number of neighbours through which a plane is fitted for a point's normal, where the scan has none; 3 to 200.
    pub normal_neighbours: NonZeroUsize,
    /// Deepest level of the Poisson reconstruction (paper: 9), 5 to 12: its cells are 1.1 widths of the object, halved this
    /// many times, but no smaller than half the points' mean distance.
    pub depth: u32,
    /// Screening weight α: how strongly the surface is drawn to the points; 0 (unscreened) to 1000.
    pub screening: f64,
    /// Largest radius of the holes that are closed, in mean distances of the thinned points; 1 to 100.
    pub reach: f64,
    /// Vertices of the mesh made of points, to within 10 %. A scan that is a mesh keeps its own.
    pub vertex_count: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            point_count: 10_000,
            normal_neighbours: NonZeroUsize::MIN.saturating_add(15),
            depth: 9,
            screening: 4.0,
            reach: 4.0,
            vertex_count: 10_000,
        }
    }
}

impl Settings {
    /// Least number of points and of vertices.
    pub const COUNT_MIN: usize = 100;

    /// Checks that every setting is in its range.
    pub(crate) fn check(&self) -> Result<(), ReconstructError> {
        let depths = 5..=poisson::DEPTH_MAX;
        let refuse = |name, value: String, expected: String| {
            Err(ReconstructError::Setting {
                name,
                value,
                expected,
            })
        };
        if self.point_count < Self::COUNT_MIN {
            return refuse(
                "point_count",
                self.point_count.to_string(),
                format!("at least {}", Self::COUNT_MIN),
            );
        }
        if self.vertex_count < Self::COUNT_MIN {
            return refuse(
                "vertex_count",
                self.vertex_count.to_string(),
                format!("at least {}", Self::COUNT_MIN),
            );
        }
        if !(3..=200).contains(&self.normal_neighbours.get()) {
            return refuse(
                "normal_neighbours",
                self.normal_neighbours.to_string(),
                "3 to 200".to_owned(),
            );
        }
        if !depths.contains(&self.depth) {
            return refuse(
                "depth",
                self.depth.to_string(),
                format!("{} to {}", depths.start(), depths.end()),
            );
        }
        if !(0.0..=1000.0).contains(&self.screening) {
            return refuse(
                "screening",
                self.screening.to_string(),
                "0 to 1000".to_owned(),
            );
        }
        if !(1.0..=100.0).contains(&self.reach) {
            return refuse("reach", self.reach.to_string(), "1 to 100".to_owned());
        }
        Ok(())
    }
}
