//! A reference's outside as a coarse mesh that two pads can press.

mod resample;

use arap::{Arap, ArapError, ArapSettings, Grip, MeshFault};
use cloud::Tree;
use mesh::{Mesh, triangle};
use nalgebra::{Point3, Vector3};

use crate::layer::Layer;
use resample::resampled;

/// Approximate number of vertices of the coarse mesh.
const VERTICES: f64 = 1500.0;
/// Mean distance between neighbouring vertices of the coarse mesh, by the least one that resampling allows.
const SPREAD: f64 = 1.15;
/// Share of the length at each end that is stiff: a can's lids, a cup's base and rim. As in the paper, Sec. IV-B.
const STIFF_SHARE: f64 = 0.05;
/// Radius of the part of a finger pad that touches: that of Baxter's electric gripper.
const PAD_RADIUS_M: f64 = 0.006;
/// Share of the unevenness below a pad, which is of rubber, that the pad flattens.
const PAD_FLATNESS: f64 = 0.8;

/// Where a finger pad presses, and how far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pad {
    /// On the undeformed surface.
    pub centre: Point3<f64>,
    /// Unit vector, outward there; the pad moves against it.
    pub normal: Vector3<f64>,
    pub depth_m: f64,
}

/// A point of the surface, by its barycentric coordinates in a triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    vertices: [u32; 3],
    shares: [f64; 3],
}

/// The outside of a reference.
pub(crate) struct Shell {
    pub(crate) vertices_m: Vec<Point3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
    normals: Vec<Vector3<f64>>,
    /// Triangles of each vertex.
    around: Vec<Vec<u32>>,
    free: Vec<bool>,
    tree: Tree,
    arap: Arap,
}

impl Shell {
    /// The outside of an upright mesh; the inside of a hollow, as of a cup, is left out.
    ///
    /// # Errors
    /// A mesh that cannot be deformed.
    pub fn new(mesh: &Mesh, outer: &Layer, hollow: Option<&Layer>) -> Result<Self, ArapError> {
        let outside = outside(mesh, outer, hollow);
        // An even mesh has two equilateral triangles to a vertex.
        let spacing_m = (outside.area_m2() / VERTICES / 0.75f64.sqrt()).sqrt();
        let coarse = resampled(&outside, (spacing_m / SPREAD) as f32);
        let vertices_m: Vec<Point3<f64>> = coarse.vertices.iter().map(|v| v.cast()).collect();
        let height_m = f64::from(mesh.bounds().1.z);
        let stiff_m = STIFF_SHARE * height_m;
        let free: Vec<bool> = vertices_m
            .iter()
            .map(|v| (stiff_m..height_m - stiff_m).contains(&v.z))
            .collect();
        let held: Vec<u32> = (0..free.len() as u32)
            .filter(|&v| !free[v as usize])
            .collect();
        let mut around = vec![Vec::new(); vertices_m.len()];
        for (index, corners) in coarse.triangles.iter().enumerate() {
            corners
                .iter()
                .for_each(|&v| around[v as usize].push(index as u32));
        }
        let settings = ArapSettings {
            energy_change_min: 1e-3,
            iterations_max: 30,
            ..ArapSettings::default()
        };
        let arap = Arap::new(&coarse, &held, settings)?;
        let tree = Tree::new(&coarse.vertices).ok_or(MeshFault::Empty {
            vertices: 0,
            triangles: 0,
        })?;
        Ok(Self {
            normals: mesh::vertex_normals(&vertices_m, &coarse.triangles),
            arap,
            tree,
            around,
            free,
            triangles: coarse.triangles,
            vertices_m,
        })
    }

    /// Prepares two pads that press at the same time.
    pub(crate) fn press(&self, pads: &[Pad; 2]) -> Result<Press<'_>, ArapError> {
        let mut handles: Vec<(u32, usize)> = Vec::new();
        for (number, pad) in pads.iter().enumerate() {
            for vertex in self.below(pad) {
                if handles.iter().all(|(other, _)| *other != vertex) {
                    handles.push((vertex, number));
                }
            }
        }
        let vertices: Vec<u32> = handles.iter().map(|(vertex, _)| *vertex).collect();
        Ok(Press {
            shell: self,
            grip: self.arap.grip(&vertices)?,
            pads: *pads,
            handles,
        })
    }

    /// The free vertices that a pad touches; where there is none, the nearest free one.
    fn below(&self, pad: &Pad) -> Vec<u32> {
        let centre = pad.centre.cast::<f32>();
        let found = self.tree.within(&centre, PAD_RADIUS_M as f32);
        let is_below =
            |vertex: &usize| self.free[*vertex] && self.normals[*vertex].dot(&pad.normal) > 0.0;
        let found: Vec<u32> = found
            .map(|found| found.index)
            .filter(is_below)
            .map(|vertex| vertex as u32)
            .collect();
        if !found.is_empty() {
            return found;
        }
        let distance_m = |vertex: &usize| (self.vertices_m[*vertex] - pad.centre).norm();
        let all = (0..self.free.len()).filter(is_below);
        let nearest = all.min_by(|a, b| distance_m(a).total_cmp(&distance_m(b)));
        nearest.map(|vertex| vertex as u32).into_iter().collect()
    }

    /// The point of the surface nearest to a given one.
    pub(crate) fn spot(&self, place: &Point3<f64>) -> Spot {
        let nearest = self.tree.nearest(&place.cast()).index;
        let mut best = (
            f64::MAX,
            Spot {
                vertices: [nearest as u32; 3],
                shares: [1.0, 0.0, 0.0],
            },
        );
        for &index in &self.around[nearest] {
            let vertices = self.triangles[index as usize];
            let corners = vertices.map(|v| self.vertices_m[v as usize]);
            let shares = shares(corners, place);
            let off_m2 = (mean(shares, corners.map(|c| c.coords)) - place.coords).norm_squared();
            if off_m2 < best.0 {
                best = (off_m2, Spot { vertices, shares });
            }
        }
        best.1
    }
}

/// Pads on a shell, to be pressed by one depth after the other.
pub(crate) struct Press<'a> {
    shell: &'a Shell,
    grip: Grip<'a>,
    pads: [Pad; 2],
    handles: Vec<(u32, usize)>,
}

impl Press<'_> {
    /// How far each vertex moves when the pads are pressed in by these depths.
    pub fn moved(&mut self, depths_m: [f64; 2]) -> Result<Vec<Vector3<f64>>, ArapError> {
        let target = |&(vertex, number): &(u32, usize)| {
            let (place, pad) = (self.shell.vertices_m[vertex as usize], &self.pads[number]);
            let gap_m = (pad.centre - place).dot(&pad.normal).max(0.0);
            let shift_m = (depths_m[number] - PAD_FLATNESS * gap_m).max(0.0);
            place - pad.normal * shift_m
        };
        let targets_m: Vec<_> = self.handles.iter().map(target).collect();
        let deformed = self.grip.deform(&targets_m)?;
        let rest = &self.shell.vertices_m;
        Ok(deformed
            .vertices_m
            .iter()
            .zip(rest)
            .map(|(to, from)| to - from)
            .collect())
    }
}

impl Spot {
    /// Interpolates a vector that is given at each vertex.
    pub fn of(&self, vectors: &[Vector3<f64>]) -> Vector3<f64> {
        mean(self.shares, self.vertices.map(|v| vectors[v as usize]))
    }
}

fn mean(shares: [f64; 3], [a, b, c]: [Vector3<f64>; 3]) -> Vector3<f64> {
    a * shares[0] + b * shares[1] + c * shares[2]
}

/// Barycentric coordinates of a triangle's point near to another point.
fn shares(corners: [Point3<f64>; 3], place: &Point3<f64>) -> [f64; 3] {
    let across = triangle::area_normal(corners);
    let area_sq = across.norm_squared();
    if area_sq == 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let [a, b, c] = corners;
    let share = |from: Point3<f64>, to: Point3<f64>| {
        ((to - from).cross(&(place - from)).dot(&across) / area_sq).max(0.0)
    };
    let shares = [share(b, c), share(c, a), share(a, b)];
    let sum: f64 = shares.iter().sum();
    shares.map(|share| share / sum)
}

/// The triangles whose centroids are nearer to the outer layer than to the hollow's.
fn outside(mesh: &Mesh, outer: &Layer, hollow: Option<&Layer>) -> Mesh {
    let is_outside = |triangle: &&[u32; 3]| {
        let corners = mesh.corners(triangle);
        let middle = Point3::from(mean([1.0 / 3.0; 3], corners.map(|c| c.coords))).cast();
        let normal = triangle::normal(corners).cast::<f32>();
        let off = |layer: &Layer| {
            let near = &layer.samples[layer.nearest(&middle)];
            let turned = if near.normal.dot(&normal) > 0.0 {
                0.0
            } else {
                1.0
            };
            (near.point - middle).norm() + turned
        };
        hollow.is_none_or(|hollow| off(outer) <= off(hollow))
    };
    let triangles: Vec<_> = mesh.triangles.iter().filter(is_outside).copied().collect();
    Mesh {
        triangles,
        vertices: mesh.vertices.clone(),
    }
}
