//! Triangle mesh.

use std::collections::{HashMap, HashSet};

use nalgebra::{Isometry3, Point3, Translation3};

use crate::half_edges::HalfEdges;

/// Triangle mesh in metres. Triangles turn counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Corner points, in metres.
    pub vertices: Vec<Point3<f32>>,
    /// Indices into `vertices`, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Axis-aligned box between two opposite corners.
    pub fn cuboid(min: Point3<f32>, max: Point3<f32>) -> Self {
        let vertices = (0..8)
            .map(|corner| {
                let pick = |axis: usize| {
                    if corner >> axis & 1 == 1 {
                        max[axis]
                    } else {
                        min[axis]
                    }
                };
                Point3::new(pick(0), pick(1), pick(2))
            })
            .collect();
        let quads: [[u32; 4]; 6] = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let triangles = quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect();
        Self {
            vertices,
            triangles,
        }
    }

    /// The mesh's adjacency.
    ///
    /// # Panics
    /// If a triangle names a vertex that does not exist.
    pub fn half_edges(&self) -> HalfEdges {
        HalfEdges::new(self.vertices.len(), &self.triangles)
    }

    /// The mesh moved rigidly.
    pub fn transformed(&self, target_from_mesh: &Isometry3<f32>) -> Self {
        Self {
            vertices: self.vertices.iter().map(|v| target_from_mesh * v).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// The mesh moved so that the centre of its bounding box's bottom is the origin: into the object frame, if +z is up.
    pub fn stood_up(&self) -> Self {
        let (min, max) = self.bounds();
        let middle = nalgebra::center(&min, &max);
        self.transformed(&Translation3::new(-middle.x, -middle.y, -min.z).into())
    }

    /// Adds another mesh's triangles; the two stay unconnected.
    pub fn append(&mut self, other: &Mesh) {
        let base = self.vertices.len() as u32;
        self.vertices.extend_from_slice(&other.vertices);
        self.triangles
            .extend(other.triangles.iter().map(|t| t.map(|index| index + base)));
    }

    /// The same surface with each triangle cut into four at the middles of its edges; the vertices keep their indices.
    pub fn subdivided(&self) -> Self {
        let mut vertices = self.vertices.clone();
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let [a, b] = [a, b].map(|index| &self.vertices[index as usize]);
                vertices.push(nalgebra::center(a, b));
                vertices.len() as u32 - 1
            })
        };
        let triangles = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
        Self {
            vertices,
            triangles,
        }
    }

    /// Smallest and largest coordinates, in metres. For an empty mesh the first exceeds the second.
    pub fn bounds(&self) -> (Point3<f32>, Point3<f32>) {
        let empty = (Point3::from([f32::MAX; 3]), Point3::from([f32::MIN; 3]));
        self.vertices
            .iter()
            .fold(empty, |(min, max), v| (min.inf(v), max.sup(v)))
    }

    /// Enclosed volume in cubic metres; negative where the triangles face inward.
    pub fn volume_m3(&self) -> f64 {
        let corner = |index: u32| self.vertices[index as usize].coords.cast::<f64>();
        self.triangles
            .iter()
            .map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c))) / 6.0)
            .sum()
    }

    /// True where every edge is shared by exactly two triangles that run along it in opposite directions.
    pub fn is_closed_manifold(&self) -> bool {
        let mut edges = HashSet::new();
        let unique = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .all(|edge| edge.0 != edge.1 && edges.insert(edge));
        unique && edges.iter().all(|&(a, b)| edges.contains(&(b, a)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primitives_are_closed_and_have_their_volume() {
        let cuboid = Mesh::cuboid(Point3::new(-1.0, 0.0, 1.0), Point3::new(1.0, 3.0, 2.0));
        assert!(cuboid.is_closed_manifold());
        assert!((cuboid.volume_m3() - 6.0).abs() < 1e-9);
        let cylinder = Mesh::cylinder(0.5, -1.0, 1.0, 256);
        assert!(cylinder.is_closed_manifold());
        assert!((cylinder.volume_m3() - std::f64::consts::FRAC_PI_2).abs() < 1e-3);
    }

    #[test]
    fn subdividing_changes_the_number_of_triangles_only() {
        let mesh = Mesh::cylinder(0.5, -1.0, 1.0, 32);
        let fine = mesh.subdivided();
        assert_eq!(fine.triangles.len(), 4 * mesh.triangles.len());
        assert_eq!(fine.vertices[..mesh.vertices.len()], mesh.vertices);
        assert!(fine.is_closed_manifold());
        assert!((fine.volume_m3() - mesh.volume_m3()).abs() < 1e-6);
    }

    #[test]
    fn an_open_mesh_is_not_closed() {
        let mut cuboid = Mesh::cuboid(Point3::origin(), Point3::new(1.0, 1.0, 1.0));
        cuboid.triangles.pop();
        assert!(!cuboid.is_closed_manifold());
    }

    #[test]
    fn append_keeps_both_closed() {
        let mut mesh = Mesh::cylinder(0.1, 0.0, 1.0, 8);
        mesh.append(&Mesh::cuboid(Point3::origin(), Point3::new(1.0, 1.0, 1.0)));
        assert!(mesh.is_closed_manifold());
    }
}
