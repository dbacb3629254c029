//! Where the two fingers of a gripper press an object (paper Sec. IV-B 3–7).
//!
//! The object is grasped across its long side: principal component over its area, or +z for one without a long side,
//! such as a ball. Fingers may press within the middle part of its length; what lies beyond (a can's lids, a cup's base
//! and rolled rim) is stiff and held in place. The first handle is a vertex of that region; the second is the farthest
//! vertex of the thin slice at the same height. Each is pressed against its own outward normal by a nearly flat round pad.

mod axis;
mod error;
mod lining;
mod pad;
mod settings;
mod surface;
#[cfg(test)]
mod tests;

use mesh::Mesh;
use nalgebra::{Point3, Unit, Vector3};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

pub use error::{GraspError, GraspRefused};
pub use settings::GraspSettings;

pub(crate) use lining::Lining;
use pad::{Pad, Press};
use surface::Surface;

/// Largest angle between a handle's normal and the line from the other handle. Our choice: at more a finger slips.
const FACING_MAX_DEG: f64 = 60.0;
/// Largest share of the free width that each finger may press: both together leave a tenth of it.
const INTENSITY_SHARE: f64 = 1.0 / 2.2;

/// Share of the unevenness under a pad that the pad, being of rubber, flattens. At 1 the triangles under the pad would lie
/// in one plane, where rounding alone decides whether they intersect.
const PAD_FLATNESS: f64 = 0.8;

/// All places where an object can be grasped.
pub struct Grasps {
    surface: Surface,
    settings: GraspSettings,
    axis: Unit<Vector3<f64>>,
    /// Centroid of the surface's area.
    centre: Point3<f64>,
    /// Height of each vertex along the axis, from the middle of the object.
    heights_m: Vec<f64>,
    /// Largest height at which a finger may press.
    height_max_m: f64,
    held: Vec<u32>,
    /// Vertices at which a finger may press, ascending.
    region: Vec<u32>,
    /// The region's vertices by height.
    by_height: Vec<u32>,
}

/// Two opposite places on an object, and how they are pressed.
#[derive(Debug, Clone, PartialEq)]
pub struct Grasp {
    /// The asked vertex and the one opposite.
    pub handles: [u32; 2],
    /// Vertices under each finger pad, the handle first.
    pub patches: [Vec<u32>; 2],
    /// How far each pad moves before it touches each vertex of its patch, in metres.
    pub gaps_m: [Vec<f64>; 2],
    /// Where each pad moves: against the normal at its handle, into the object.
    pub directions: [Unit<Vector3<f64>>; 2],
    /// Distance between the handles, in metres.
    pub width_m: f64,
    /// I_max of Eq. 4: how far each finger may press before the two meet, in metres.
    pub intensity_max_m: f64,
}

impl Grasps {
    /// Finds the long side, the region and the held ends of a mesh.
    ///
    /// # Errors
    /// Settings out of range, or a mesh that is no surface or faces inward.
    pub fn new(mesh: &Mesh, settings: &GraspSettings) -> Result<Self, GraspError> {
        settings.validate()?;
        let surface = Surface::new(mesh)?;
        let (centre, flux) = axis::centre_and_flux(&surface.vertices_m, &mesh.triangles);
        if flux < 0.0 {
            return Err(GraspError::InsideOut);
        }
        let axis = match settings.long_axis {
            Some(axis) => Unit::new_normalize(axis.into_inner()),
            None => axis::long_axis(&surface.vertices_m, &mesh.triangles),
        };
        let (heights_m, half_m) = heights(&surface, &axis);
        let height_max_m = settings.graspable_ratio * half_m;
        let all = 0..heights_m.len() as u32;
        let (inside, held): (Vec<u32>, Vec<u32>) =
            all.partition(|&v| heights_m[v as usize].abs() <= height_max_m);
        let has_normal = |v: &u32| surface.normals[*v as usize] != Vector3::zeros();
        let region: Vec<u32> = inside.into_iter().filter(has_normal).collect();
        if region.is_empty() {
            let ratio = settings.graspable_ratio;
            return Err(GraspError::NoRegion { ratio });
        }
        let mut by_height = region.clone();
        by_height.sort_by(|&a, &b| heights_m[a as usize].total_cmp(&heights_m[b as usize]));
        Ok(Self {
            surface,
            settings: settings.clone(),
            axis,
            centre,
            heights_m,
            height_max_m,
            held,
            region,
            by_height,
        })
    }

    /// The object's long side.
    pub fn long_axis(&self) -> Unit<Vector3<f64>> {
        self.axis
    }

    /// Vertices beyond the graspable region, ascending: the constraint points c_i of Eq. 1.
    pub fn held(&self) -> &[u32] {
        &self.held
    }

    /// Vertices where a finger may press, ascending.
    pub fn region(&self) -> &[u32] {
        &self.region
    }

    /// The region's vertices in an order drawn uniformly from `seed`.
    pub fn order(&self, seed: u64) -> Vec<u32> {
        let mut order = self.region.clone();
        order.shuffle(&mut Pcg64Mcg::seed_from_u64(seed));
        order
    }

    /// Number of handles to sample by default: `sampling_ratio` of the region's vertices, at least one.
    pub fn default_count(&self) -> usize {
        let share = self.settings.sampling_ratio * self.region.len() as f64;
        (share.round() as usize).max(1)
    }

    /// The grasp whose first handle is the vertex `handle`.
    ///
    /// # Errors
    /// [`GraspRefused`]: why a gripper cannot press there.
    pub fn grasp(&self, handle: u32) -> Result<Grasp, GraspRefused> {
        if self.region.binary_search(&handle).is_err() {
            return Err(GraspRefused::OutsideRegion { handle });
        }
        let opposite = self.opposite(handle);
        let across = self.position(handle) - self.position(opposite);
        let width_m = across.norm();
        if width_m == 0.0 {
            return Err(GraspRefused::NoOpposite { handle });
        }
        self.check_facing(handle, across)?;
        self.check_facing(opposite, -across)?;
        if width_m > self.settings.opening_max_m {
            return Err(GraspRefused::TooWide {
                handle,
                width_m,
                opening_max_m: self.settings.opening_max_m,
            });
        }
        let handles = [handle, opposite];
        let pads = handles.map(|handle| self.pad(handle));
        let free_m = width_m - pads[0].thickness_m - pads[1].thickness_m;
        let is_shared = |vertex: &u32| pads[1].vertices.contains(vertex);
        if free_m <= 0.0 || pads[0].vertices.iter().any(is_shared) {
            return Err(GraspRefused::TooThin { handle, width_m });
        }
        let [first, second] = pads;
        Ok(Grasp {
            handles,
            patches: [first.vertices, second.vertices],
            gaps_m: [first.gaps_m, second.gaps_m],
            directions: handles.map(|handle| self.direction(handle)),
            width_m,
            intensity_max_m: INTENSITY_SHARE * free_m,
        })
    }

    /// The vertex of the slice at the handle's height that is farthest from it; of equally far ones the one whose
    /// coordinates come first, so that the order of vertices does not matter.
    fn opposite(&self, handle: u32) -> u32 {
        let place = self.position(handle);
        let height_m = self.heights_m[handle as usize];
        let half_m = 0.5 * self.settings.slice_m;
        let height = |&v: &u32| self.heights_m[v as usize];
        let first = self
            .by_height
            .partition_point(|v| height(v) < height_m - half_m);
        let end = self
            .by_height
            .partition_point(|v| height(v) <= height_m + half_m);
        let rank = |&v: &u32| (self.position(v) - place).norm_squared();
        let farthest = self.by_height[first..end].iter().max_by(|a, b| {
            let by_coordinates = || {
                let [a, b] = [a, b].map(|&&v| self.position(v));
                let pairs = b.iter().zip(a.iter()).map(|(b, a)| b.total_cmp(a));
                pairs.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
            };
            rank(a).total_cmp(&rank(b)).then_with(by_coordinates)
        });
        farthest.copied().unwrap_or(handle)
    }

    /// Refuses a vertex whose normal is too far from `outward`.
    fn check_facing(&self, vertex: u32, outward: Vector3<f64>) -> Result<(), GraspRefused> {
        let normal = self.surface.normals[vertex as usize];
        let angle_deg = normal.angle(&outward).to_degrees();
        if angle_deg <= FACING_MAX_DEG {
            return Ok(());
        }
        let slope_deg = normal.dot(&self.axis).abs().min(1.0).asin().to_degrees();
        if slope_deg > FACING_MAX_DEG {
            return Err(GraspRefused::EndCap { vertex });
        }
        Err(GraspRefused::NotFacing { vertex, angle_deg })
    }

    fn pad(&self, handle: u32) -> Pad {
        let is_free = |v: u32| self.heights_m[v as usize].abs() <= self.height_max_m;
        let press = Press {
            surface: &self.surface,
            is_free: &is_free,
            handle,
            direction: self.direction(handle),
            radius_m: 0.5 * self.settings.finger_width_m,
            wall_max_m: self.settings.wall_max_m,
        };
        press.pad()
    }

    fn position(&self, vertex: u32) -> Point3<f64> {
        self.surface.vertices_m[vertex as usize]
    }

    fn direction(&self, handle: u32) -> Unit<Vector3<f64>> {
        Unit::new_unchecked(-self.surface.normals[handle as usize])
    }
}

impl Grasp {
    /// All vertices that the fingers move: first pad, then second.
    pub fn pressed(&self) -> Vec<u32> {
        self.patches.concat()
    }

    /// Target positions of the [`Grasp::pressed`] vertices when each finger has pressed by `intensity_m` (Eq. 4). The
    /// handle moves that far; the vertices around it move less, by the gap that the pad, nearly flat, first has to close.
    pub fn targets_m(&self, vertices_m: &[Point3<f64>], intensity_m: f64) -> Vec<Point3<f64>> {
        let pads = self.patches.iter().zip(&self.gaps_m).zip(&self.directions);
        pads.flat_map(|((patch, gaps_m), direction)| {
            patch.iter().zip(gaps_m).map(move |(&vertex, gap_m)| {
                let shift_m = (intensity_m - PAD_FLATNESS * gap_m).max(0.0);
                vertices_m[vertex as usize] + shift_m * direction.into_inner()
            })
        })
        .collect()
    }
}

/// Height of each vertex along the axis from the middle of the surface, and half its length.
fn heights(surface: &Surface, axis: &Vector3<f64>) -> (Vec<f64>, f64) {
    let mut heights_m: Vec<f64> = surface
        .vertices_m
        .iter()
        .map(|v| v.coords.dot(axis))
        .collect();
    let min = heights_m.iter().copied().fold(f64::INFINITY, f64::min);
    let max = heights_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for height in &mut heights_m {
        *height -= 0.5 * (min + max);
    }
    (heights_m, 0.5 * (max - min))
}
