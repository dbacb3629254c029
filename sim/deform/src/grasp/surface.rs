//! Normals and neighbours of a mesh's vertices, in double precision.

use mesh::{Mesh, Rows};
use nalgebra::{Point3, Vector3};

use super::GraspError;

/// A mesh's vertices with their normals and one-rings.
pub(super) struct Surface {
    pub vertices_m: Vec<Point3<f64>>,
    /// Unit vectors, the mean of the triangles around weighted by their angles; zero where there is no triangle.
    pub normals: Vec<Vector3<f64>>,
    one_rings: Rows<u32>,
}

impl Surface {
    pub fn new(mesh: &Mesh) -> Result<Self, GraspError> {
        check(mesh)?;
        let vertices_m: Vec<Point3<f64>> = mesh.vertices.iter().map(|v| v.cast()).collect();
        Ok(Self {
            normals: mesh::vertex_normals(&vertices_m, &mesh.triangles),
            vertices_m,
            one_rings: mesh.half_edges().one_rings(),
        })
    }

    /// The vertices next to one, ascending.
    pub fn neighbours(&self, vertex: u32) -> &[u32] {
        self.one_rings.of(vertex as usize)
    }
}

fn check(mesh: &Mesh) -> Result<(), GraspError> {
    let vertices = mesh.vertices.len();
    if mesh.triangles.is_empty() {
        return Err(GraspError::Empty {
            vertices,
            triangles: 0,
        });
    }
    let is_beyond = |t: &[u32; 3]| t.iter().any(|&index| index as usize >= vertices);
    if let Some(triangle) = mesh.triangles.iter().position(is_beyond) {
        return Err(GraspError::Index { triangle, vertices });
    }
    let is_odd = |v: &Point3<f32>| !v.iter().all(|x| x.is_finite());
    match mesh.vertices.iter().position(is_odd) {
        Some(vertex) => Err(GraspError::NotFinite { vertex }),
        None => Ok(()),
    }
}
