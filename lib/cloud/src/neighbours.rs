//! Nearest neighbours: a static k-d tree (kiddo) under this workspace's types.

use std::num::NonZeroUsize;

use kiddo::SquaredEuclidean;
use kiddo::immutable::float::kdtree::ImmutableKdTree;
use nalgebra::Point3;

/// A point of the tree that was found near a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// Index into the slice that the tree was built of.
    pub index: usize,
    /// Squared distance from the query, m².
    pub distance_sq: f32,
}

/// A static tree over a cloud.
pub struct Tree {
    tree: ImmutableKdTree<f32, u32, 3, 32>,
}

impl Tree {
    /// Builds the tree; `None` if there are no points. Points must be finite.
    pub fn new(points: &[Point3<f32>]) -> Option<Self> {
        if points.is_empty() {
            return None;
        }
        let points: Vec<[f32; 3]> = points.iter().map(|point| point.coords.into()).collect();
        Some(Self {
            tree: ImmutableKdTree::new_from_slice(&points),
        })
    }

    /// The nearest point.
    pub fn nearest(&self, query: &Point3<f32>) -> Neighbour {
        let found = self
            .tree
            .nearest_one::<SquaredEuclidean>(query.coords.as_ref());
        Neighbour {
            index: found.item as usize,
            distance_sq: found.distance,
        }
    }

    /// The `count` nearest points, nearest first; fewer where the cloud has fewer.
    pub fn nearest_n(
        &self,
        query: &Point3<f32>,
        count: NonZeroUsize,
    ) -> impl Iterator<Item = Neighbour> {
        let found = self
            .tree
            .nearest_n::<SquaredEuclidean>(query.coords.as_ref(), count);
        found.into_iter().map(|found| Neighbour {
            index: found.item as usize,
            distance_sq: found.distance,
        })
    }

    /// All points nearer than `radius_m`, in no order.
    pub fn within(&self, query: &Point3<f32>, radius_m: f32) -> impl Iterator<Item = Neighbour> {
        let found = self
            .tree
            .within_unsorted::<SquaredEuclidean>(query.coords.as_ref(), radius_m * radius_m);
        found.into_iter().map(|found| Neighbour {
            index: found.item as usize,
            distance_sq: found.distance,
        })
    }
}

#[cfg(test)]
mod tests;
