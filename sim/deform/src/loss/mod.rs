//! How far a deformed mesh is from its source and from a well-shaped mesh (paper Sec. VI-A, Eq. 5).

mod printed;
#[cfg(test)]
mod tests;
mod weights;

use cloud::Tree;
use mesh::{Edge, Mesh, triangle};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

pub use printed::PrintedLoss;
pub use weights::{LossWeightError, LossWeights};

const MM_PER_M: f64 = 1000.0;

/// The terms of Eq. 5, each by itself and unweighted, and their weighted sum. Lengths are millimetres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Loss {
    /// Chamfer distance between the vertices of source and deformed mesh: mean squared distance to the nearest one, both
    /// ways, added. mm².
    pub distance_mm2: f64,
    /// Mean over the edges of (length − L_target)². mm².
    pub edge_mm2: f64,
    /// Sum over the edges between two triangles of 1 − cos of the angle between these, over the number of triangles.
    pub normal: f64,
    /// Mean over the vertices of ‖δ‖, where δ is the vertex less the mean of its neighbours. mm.
    pub smooth_mm: f64,
    /// The sum weighted by [`LossWeights`].
    pub total: f64,
    /// The same letter by letter.
    pub printed: PrintedLoss,
}

/// Computes the loss of deformations of one source mesh.
///
/// The sums of Eq. 5 over vertices and their neighbours visit every edge from both its ends; here each edge counts once.
pub struct LossOfSource {
    weights: LossWeights,
    source: Vec<Point3<f32>>,
    tree: Option<Tree>,
    triangles: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    /// Triangles on both sides of an edge.
    facing: Vec<[u32; 2]>,
    mean_edge_mm: f64,
}

impl LossOfSource {
    /// Builds the source's tree and lists its edges.
    pub fn new(source: &Mesh, weights: &LossWeights) -> Self {
        let edges = source.half_edges().edges();
        Self {
            weights: weights.clone(),
            source: source.vertices.clone(),
            tree: Tree::new(&source.vertices),
            triangles: source.triangles.clone(),
            facing: edges.iter().flat_map(facing).collect(),
            mean_edge_mm: mean(&edges, |edge| {
                let [a, b] = edge.ends.map(|end| source.vertices[end as usize]);
                f64::from((a - b).norm()) * MM_PER_M
            }),
            edges: edges.iter().map(|edge| edge.ends).collect(),
        }
    }

    /// The loss of the source with its vertices moved to `vertices_m`: as many as the source has, finite.
    pub fn of(&self, vertices_m: &[Point3<f32>]) -> Loss {
        let deformed_mm: Vec<Point3<f64>> = vertices_m
            .iter()
            .map(|v| v.cast::<f64>() * MM_PER_M)
            .collect();
        let distance_mm2 = self.distance_mm2(vertices_m);
        let edge_mm2 = self.edge_mm2(&deformed_mm, self.weights.edge_target_m * MM_PER_M);
        let normal = self.normal(&deformed_mm);
        let smooth_mm = self.smooth_mm(&deformed_mm);
        let weights = &self.weights;
        let printed_edge_mm2 = self.edge_mm2(&deformed_mm, self.mean_edge_mm);
        let terms = [distance_mm2, printed_edge_mm2, normal];
        Loss {
            distance_mm2,
            edge_mm2,
            normal,
            smooth_mm,
            total: weights.distance * distance_mm2
                + weights.edge * edge_mm2
                + weights.normal * normal
                + weights.smooth * smooth_mm,
            printed: PrintedLoss::of(&deformed_mm, &self.triangles, terms, weights),
        }
    }

    fn distance_mm2(&self, vertices_m: &[Point3<f32>]) -> f64 {
        match (&self.tree, Tree::new(vertices_m)) {
            (Some(source), Some(deformed)) => {
                let there = mean(vertices_m, |v| source.nearest(v).distance_sq.into());
                let back = mean(&self.source, |v| deformed.nearest(v).distance_sq.into());
                (there + back) * MM_PER_M * MM_PER_M
            }
            _ => 0.0,
        }
    }

    fn edge_mm2(&self, vertices_mm: &[Point3<f64>], target_mm: f64) -> f64 {
        mean(&self.edges, |&[a, b]| {
            let length_mm = (vertices_mm[a as usize] - vertices_mm[b as usize]).norm();
            (length_mm - target_mm).powi(2)
        })
    }

    fn normal(&self, vertices_mm: &[Point3<f64>]) -> f64 {
        let normal = |t: &[u32; 3]| triangle::normal(t.map(|index| vertices_mm[index as usize]));
        let normals: Vec<Vector3<f64>> = self.triangles.iter().map(normal).collect();
        let bends = self.facing.iter().map(|pair| {
            let [a, b] = pair.map(|triangle| normals[triangle as usize]);
            1.0 - a.dot(&b)
        });
        bends.sum::<f64>() / self.triangles.len().max(1) as f64
    }

    fn smooth_mm(&self, vertices_mm: &[Point3<f64>]) -> f64 {
        let mut sums = vec![(Vector3::zeros(), 0.0); vertices_mm.len()];
        for &[a, b] in &self.edges {
            for (from, to) in [(a, b), (b, a)] {
                let (sum, count) = &mut sums[from as usize];
                *sum += vertices_mm[from as usize] - vertices_mm[to as usize];
                *count += 1.0;
            }
        }
        mean(&sums, |(sum, count)| sum.norm() / f64::max(*count, 1.0))
    }
}

fn mean<T>(items: &[T], value: impl Fn(&T) -> f64) -> f64 {
    items.iter().map(value).sum::<f64>() / items.len().max(1) as f64
}

/// The pairs of triangles that share an edge.
fn facing(edge: &Edge) -> Vec<[u32; 2]> {
    let triangles = &edge.triangles;
    let pairs = (0..triangles.len())
        .flat_map(|a| (a + 1..triangles.len()).map(move |b| [triangles[a], triangles[b]]));
    pairs.collect()
}
