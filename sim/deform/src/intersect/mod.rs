//! Self-intersections of a mesh: which pairs of triangles pass through each other. A bounding volume hierarchy finds the
//! candidate pairs, exact predicates decide.

mod boxes;
mod fans;
#[cfg(test)]
mod tests;
mod triangles;

use mesh::Mesh;
use nalgebra::Point3;

use boxes::BoxTree;
use fans::Fans;
use triangles::Triangles;

/// Finds the self-intersections that a deformation has added to its source mesh.
///
/// The box tree is built once over the source, and only its boxes change with the vertices. Two triangles intersect where
/// they have a point in common beyond a shared vertex or edge; the predicates are exact.
pub struct SelfIntersections {
    /// In the order of the tree's leaves, so that neighbours are near in memory.
    triangles: Vec<[u32; 3]>,
    tree: BoxTree,
    fans: Fans,
    /// The source's own, sorted.
    known: Vec<[u32; 2]>,
}

impl SelfIntersections {
    /// Prepares for meshes with the triangles of `source`, whose own intersections are remembered.
    pub fn of(source: &Mesh) -> Self {
        let vertices_m: Vec<Point3<f64>> = source.vertices.iter().map(|v| v.cast()).collect();
        let tree = BoxTree::new(&vertices_m, &source.triangles);
        let in_order = |&triangle: &u32| source.triangles[triangle as usize];
        let triangles: Vec<[u32; 3]> = tree.order.iter().map(in_order).collect();
        let mut intersections = Self {
            fans: Fans::new(vertices_m.len(), &triangles),
            triangles,
            tree,
            known: Vec::new(),
        };
        intersections.known = intersections.pairs(&vertices_m);
        intersections
    }

    /// Pairs of triangles that intersect in the source, each once, sorted.
    pub fn source_pairs(&self) -> &[[u32; 2]] {
        &self.known
    }

    /// Pairs of triangles that intersect with the vertices at `vertices_m` but did not in the source, each once, sorted.
    ///
    /// `vertices_m`: as many as the source has, finite, in the source's unit.
    pub fn new_pairs(&self, vertices_m: &[Point3<f64>]) -> Vec<[u32; 2]> {
        let mut pairs = self.pairs(vertices_m);
        pairs.retain(|pair| self.known.binary_search(pair).is_err());
        pairs
    }

    fn pairs(&self, vertices_m: &[Point3<f64>]) -> Vec<[u32; 2]> {
        let mut pairs = Vec::new();
        let mut triangles = Triangles::new(vertices_m, &self.triangles);
        triangles.skip_plain_fans(&self.fans);
        let visit = |a: u32, b: u32| {
            if triangles.intersect(a, b) {
                let [a, b] = [a, b].map(|place| self.tree.order[place as usize]);
                pairs.push([a.min(b), a.max(b)]);
            }
        };
        self.tree.for_near_pairs(vertices_m, &self.triangles, visit);
        pairs.sort_unstable();
        pairs
    }
}
