//! Normals and neighbours of a mesh's vertices, in double precision.

use mesh::Mesh;
use nalgebra::{Point3, Vector3};

use super::GraspError;

/// A mesh's surface as a finger feels it.
pub(super) struct Surface {
    pub vertices_m: Vec<Point3<f64>>,
    /// Unit vectors, the mean of the triangles around weighted by their angles; zero where there is no triangle.
    pub normals: Vec<Vector3<f64>>,
    /// Neighbours of vertex i are `neighbours[starts[i]..starts[i + 1]]`, each once, ascending.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Surface {
    pub fn new(mesh: &Mesh) -> Result<Self, GraspError> {
        check(mesh)?;
        let vertices_m: Vec<Point3<f64>> = mesh.vertices.iter().map(|v| v.cast()).collect();
        let (starts, neighbours) = neighbours(mesh);
        Ok(Self {
            normals: normals(&vertices_m, &mesh.triangles),
            vertices_m,
            starts,
            neighbours,
        })
    }

    pub fn neighbours(&self, vertex: u32) -> &[u32] {
        let [first, end] = [0, 1].map(|k| self.starts[vertex as usize + k] as usize);
        &self.neighbours[first..end]
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

/// The mean of the normals of the triangles around each vertex, weighted by their angles.
pub(super) fn normals(vertices_m: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); vertices_m.len()];
    for triangle in triangles {
        let corners = triangle.map(|index| vertices_m[index as usize]);
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|step| corners[(k + step) % 3]);
            let (ab, ac) = (b - a, c - a);
            let across = ab.cross(&ac);
            let angle_rad = across.norm().atan2(ab.dot(&ac));
            let normal = across.try_normalize(0.0).unwrap_or_default();
            normals[triangle[k] as usize] += angle_rad * normal;
        }
    }
    for normal in &mut normals {
        *normal = normal.try_normalize(0.0).unwrap_or_default();
    }
    normals
}

fn neighbours(mesh: &Mesh) -> (Vec<u32>, Vec<u32>) {
    let mut edges: Vec<[u32; 2]> = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let mut starts = vec![0; mesh.vertices.len() + 1];
    for edge in &edges {
        starts[edge[0] as usize + 1] += 1;
    }
    for k in 1..starts.len() {
        starts[k] += starts[k - 1];
    }
    (starts, edges.into_iter().map(|edge| edge[1]).collect())
}
