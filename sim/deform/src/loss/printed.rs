//! Eq. 5 letter by letter.

use mesh::triangle;
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::LossWeights;

/// The terms of Eq. 5 as the paper prints them, where these differ from [`super::Loss`]; of lengths in millimetres. The
/// Chamfer distance is the same.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PrintedLoss {
    /// Sum over the vertices, and over the neighbours of each, of (length − L_target)², over the number of edges, with the
    /// source's mean edge as L_target. mm².
    pub edge_mm2: f64,
    /// The same sum of 1 − cos of the angle between the two triangles at the edge, over the number of triangles.
    pub normal: f64,
    /// Length of the mean of all vectors δ (Eq. 2): cotangents of any sign, over the area of the Voronoi cell. The vectors
    /// cancel each other, so that this says little. 1/mm.
    pub smooth_per_mm: f64,
    /// The sum with the weights of [`LossWeights`].
    pub total: f64,
}

impl PrintedLoss {
    /// Of a deformed mesh. `edge_mm2` and `normal` are means in which each edge counts once: the printed sums meet it from
    /// both its ends.
    pub(super) fn of(
        vertices_mm: &[Point3<f64>],
        triangles: &[[u32; 3]],
        [distance_mm2, edge_mm2, normal]: [f64; 3],
        weights: &LossWeights,
    ) -> Self {
        let deltas = deltas(vertices_mm, triangles);
        let mean = deltas.iter().sum::<Vector3<f64>>() / deltas.len().max(1) as f64;
        let (edge_mm2, normal, smooth_per_mm) = (2.0 * edge_mm2, 2.0 * normal, mean.norm());
        Self {
            edge_mm2,
            normal,
            smooth_per_mm,
            total: weights.distance * distance_mm2
                + weights.edge * edge_mm2
                + weights.normal * normal
                + weights.smooth * smooth_per_mm,
        }
    }
}

/// δ of each vertex (Eq. 2), in 1 over the unit of the vertices; zero for a vertex without a triangle.
pub(super) fn deltas(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut sums = vec![(Vector3::zeros(), 0.0); vertices.len()];
    for triangle in triangles {
        let corners = triangle.map(|index| vertices[index as usize]);
        let cotangents = triangle::cotangents(corners);
        let areas = triangle::voronoi_areas(corners);
        for k in 0..3 {
            let [a, b] = [(k + 1) % 3, (k + 2) % 3];
            let pull = 0.5 * cotangents[k] * (corners[a] - corners[b]);
            sums[triangle[a] as usize].0 += pull;
            sums[triangle[b] as usize].0 -= pull;
            sums[triangle[k] as usize].1 += areas[k];
        }
    }
    let delta = |(sum, area): (Vector3<f64>, f64)| if area > 0.0 { sum / area } else { sum };
    sums.into_iter().map(delta).collect()
}
