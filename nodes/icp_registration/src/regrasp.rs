//! Lays two scans of one object onto each other, between which it was put back into the hand another way.
//!
//! Nobody knows how it was turned, so that the second scan is tried upside down and upright, and from all sides. Each try
//! is corrected as a view is; the one that agrees best is kept. Only what a grasp should have shown is compared: what
//! the fingers cover, the underside, and what looks away from a camera that is a little above say nothing.
//!
//! Of an object with straight sides that was turned over, nothing tells how high it is: both ends are taken to have been
//! held equally deep.

use std::f64::consts::{PI, TAU};
use std::num::NonZeroUsize;

use cloud::normals::Moments;
use cloud::{Bounds, Tree, transformed, voxel};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

use parameter::ParameterError;

use crate::error::RegistrationError;
use crate::parameters::Parameters;
use crate::registrar::Registrar;

/// Starts about the hand's axis: half their step is what a correction can make good.
const TURNS: usize = 24;
/// Voxels of the search, and of the end, m.
const COARSE_M: f64 = 0.004;
const FINE_M: f64 = 0.002;
/// Farther than this from the other scan a point does not agree with it, m.
const MATCH_M: f64 = 0.005;
/// Distance at which one that does not counts in the search, m.
const LIMIT_M: f64 = 0.01;
/// Upright must fit better than this share of the error of upside down, which is what people are asked for: a can looks
/// the same both ways, and a camera's errors are the more alike the more alike an object is held (half the mean square of
/// a spool in the simulated hand).
const UPRIGHT_BELOW: f64 = 0.3;
/// Nearer to a boundary of what a grasp hides, a point may be seen or not, m.
const MARGIN_M: f64 = 0.004;
/// Neighbours that give a point's normal.
const NEIGHBOURS: NonZeroUsize = NonZeroUsize::MIN.saturating_add(11);
/// Sine and cosine of the camera's elevation over the object, some 15 degrees.
const ELEVATION: [f32; 2] = [0.26, 0.97];
/// Cosine between normal and line of sight below which a depth camera sees little.
const GRAZING: f32 = 0.3;
/// With fewer points that should be seen, a pose cannot be judged.
const JUDGED_MIN: usize = 50;
/// Share of the points at each end of an axis that may be strays.
const STRAYS: f64 = 0.01;

/// The least share of points that two scans of one object have in common: each hides what the fingers hold.
pub const FITNESS_MIN: f64 = 0.6;
/// The largest distance between two scans of one object where they agree, root mean square, m.
pub const RMSE_MAX_M: f64 = 0.002;

/// What every grasp hides of the object, in the hand's frame, +z out along the gripper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hidden {
    /// Height of the lowest points that are cropped to the object, m.
    pub below_m: f64,
    /// Height of the fingertips, m.
    pub fingertips_m: f64,
    /// Width of the fingers along x, m; they are at +y and -y.
    pub finger_width_m: f64,
}

/// How the object was put back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regrasp {
    /// Maps the second scan onto the first.
    pub first_from_second: Isometry3<f64>,
    /// Whether the end that was up is held in the second.
    pub upside_down: bool,
    /// Of the points of either scan that the other should show, the share with a neighbour there.
    pub fitness: f64,
    /// Root of the mean square of their distances, m.
    pub rmse_m: f64,
}

/// Two scans that are not laid onto each other.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegraspError {
    /// They do not agree, however the second is turned.
    #[error(
        "the two grasps show no common surface: at best {:.0} % of their points agree, to {:.1} mm (wanted {:.0} %, {:.1} mm); is it \
         the same object, undented meanwhile?",
        1e2 * .0.fitness, 1e3 * .0.rmse_m, 1e2 * FITNESS_MIN, 1e3 * RMSE_MAX_M
    )]
    Disagree(Regrasp),
    /// One of them cannot be registered at all.
    #[error(transparent)]
    Registration(#[from] RegistrationError),
    /// A parameter of registration.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
}

/// Finds how the second scan lies on the first; both in m, in the hand's frame, each cropped to the object.
///
/// # Errors
/// [`RegraspError`]: nothing agrees, or a scan is no surface.
pub fn regrasp(
    first: &[Point3<f32>],
    second: &[Point3<f32>],
    hidden: &Hidden,
) -> Result<Regrasp, RegraspError> {
    let coarse = Pair::new(first, second, COARSE_M, hidden)?;
    let fine = Pair::new(first, second, FINE_M, hidden)?;
    let best = |upside_down| -> Result<Agreement, RegistrationError> {
        let mut best: Option<(f64, Isometry3<f64>)> = None;
        for start in starts(first, second, upside_down) {
            let found = coarse.settle(start)?;
            let error_sq = coarse.agreement(&found).error_sq;
            if best.is_none_or(|(least_sq, _)| error_sq < least_sq) {
                best = Some((error_sq, found));
            }
        }
        let found = best.map_or_else(Isometry3::identity, |(_, found)| found);
        Ok(fine.agreement(&fine.settle(found)?))
    };
    let (over, upright) = (best(true)?, best(false)?);
    let upside_down = upright.error_sq >= UPRIGHT_BELOW * over.error_sq;
    let chosen = if upside_down { over } else { upright };
    let regrasp = Regrasp {
        first_from_second: chosen.first_from_second,
        upside_down,
        fitness: chosen.fitness,
        rmse_m: chosen.rmse_m,
    };
    if regrasp.fitness < FITNESS_MIN || regrasp.rmse_m > RMSE_MAX_M {
        return Err(RegraspError::Disagree(regrasp));
    }
    Ok(regrasp)
}

/// Poses of the second scan in which its box lies in that of the first, at its top or its bottom.
fn starts(
    first: &[Point3<f32>],
    second: &[Point3<f32>],
    upside_down: bool,
) -> impl Iterator<Item = Isometry3<f64>> {
    let target = bulk(first);
    let over = if upside_down { PI } else { 0.0 };
    (0..TURNS).flat_map(move |turn| {
        let turn_rad = TAU * turn as f64 / TURNS as f64;
        let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn_rad)
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), over);
        let turned = transformed(
            &Isometry3::from_parts(Translation3::identity(), rotation),
            second,
        );
        let own = bulk(&turned);
        let across = target.centre() - own.centre();
        let heights = [target.max.z - own.max.z, target.min.z - own.min.z];
        heights.map(|height| {
            let shift = Vector3::new(across.x, across.y, height).cast::<f64>();
            Isometry3::from_parts(shift.into(), rotation)
        })
    })
}

/// The box around all but strays.
fn bulk(points: &[Point3<f32>]) -> Bounds {
    let mut bounds = Bounds {
        min: Point3::origin(),
        max: Point3::origin(),
    };
    let strays = (points.len() as f64 * STRAYS) as usize;
    for axis in 0..3 {
        let mut values: Vec<f32> = points.iter().map(|point| point[axis]).collect();
        values.sort_unstable_by(f32::total_cmp);
        if let (Some(min), Some(max)) = (values.get(strays), values.iter().rev().nth(strays)) {
            (bounds.min[axis], bounds.max[axis]) = (*min, *max);
        }
    }
    bounds
}

/// How well the scans agree in one pose.
struct Agreement {
    first_from_second: Isometry3<f64>,
    fitness: f64,
    rmse_m: f64,
    /// Mean square distance, in which a point without a neighbour counts as one at the limit, m².
    error_sq: f64,
}

/// Both scans, thinned, ready to be laid onto each other many times.
struct Pair {
    scans: [Surface; 2],
    registrar: Registrar,
    hidden: Hidden,
}

impl Pair {
    fn new(
        first: &[Point3<f32>],
        second: &[Point3<f32>],
        voxel_m: f64,
        hidden: &Hidden,
    ) -> Result<Self, RegraspError> {
        let scans = [
            Surface::new(first, voxel_m)?,
            Surface::new(second, voxel_m)?,
        ];
        let parameters = Parameters {
            voxel_m,
            max_correspondence_m: 4.0 * voxel_m,
            // How the object was put back is known no better than this.
            max_correction_m: 0.05,
            max_correction_rad: 0.7,
            min_fitness: 0.0,
            // The clouds are of the object alone, wherever a start puts them.
            rigid_above_m: -1.0,
            rigid_radius_m: 1.0,
            ..Parameters::default()
        };
        let mut registrar = Registrar::new(parameters)?;
        registrar.add_view(&scans[0].points, Some(Isometry3::identity()))?;
        Ok(Self {
            scans,
            registrar,
            hidden: *hidden,
        })
    }

    fn settle(&self, start: Isometry3<f64>) -> Result<Isometry3<f64>, RegistrationError> {
        let mut registrar = self.registrar.clone();
        let evidence = registrar.add_view(&self.scans[1].points, Some(start))?;
        Ok(evidence.transform)
    }

    fn agreement(&self, first_from_second: &Isometry3<f64>) -> Agreement {
        let [first, second] = &self.scans;
        let mut distances_sq = second.distances_sq(first, first_from_second, &self.hidden);
        distances_sq.extend(first.distances_sq(second, &first_from_second.inverse(), &self.hidden));
        let limit_sq = LIMIT_M * LIMIT_M;
        let (mut matched, mut matched_sq, mut error_sq) = (0.0, 0.0, 0.0);
        for distance_sq in &distances_sq {
            error_sq += distance_sq.min(limit_sq);
            if *distance_sq <= MATCH_M * MATCH_M {
                matched += 1.0;
                matched_sq += distance_sq;
            }
        }
        let count = distances_sq.len();
        let mean = |sum: f64| {
            if count < JUDGED_MIN {
                limit_sq
            } else {
                sum / count as f64
            }
        };
        Agreement {
            first_from_second: *first_from_second,
            fitness: matched / count.max(1) as f64,
            rmse_m: (matched_sq / f64::max(matched, 1.0)).sqrt(),
            error_sq: mean(error_sq),
        }
    }
}

/// A scan's points with the outward normals of its surface, thinned.
struct Surface {
    points: Vec<Point3<f32>>,
    normals: Vec<Vector3<f32>>,
    tree: Tree,
}

impl Surface {
    fn new(points: &[Point3<f32>], voxel_m: f64) -> Result<Self, RegistrationError> {
        let points =
            voxel::downsample(points, voxel_m as f32).map_err(RegistrationError::TooLarge)?;
        let tree = Tree::new(&points).ok_or(RegistrationError::Empty)?;
        let middle = cloud::bounds(&points).map_or_else(Point3::origin, |bounds| bounds.centre());
        let normal = |point: &Point3<f32>| {
            let mut moments = Moments::default();
            for near in tree.nearest_n(point, NEIGHBOURS) {
                moments.add(&points[near.index].coords.cast());
            }
            let normal = moments.plane()?.normal.into_inner().cast::<f32>();
            // What the camera saw looks to it: outward, and a little up.
            let outward = (point - middle).xy().normalize();
            let seen_from = Vector3::new(outward.x, outward.y, ELEVATION[0]);
            Some(normal * normal.dot(&seen_from).signum())
        };
        let normals = points.iter().map(|point| normal(point).unwrap_or_default());
        Ok(Self {
            normals: normals.collect(),
            points,
            tree,
        })
    }

    /// Squared distance from another scan of each of the points that it should show, m².
    fn distances_sq(
        &self,
        other: &Surface,
        other_from_own: &Isometry3<f64>,
        hidden: &Hidden,
    ) -> Vec<f64> {
        let rotation = other_from_own.rotation.cast::<f32>();
        let places = transformed(other_from_own, &self.points);
        let pairs = places.iter().zip(&self.normals);
        let shown = pairs.filter(|(place, normal)| hidden.shows(place, &(rotation * *normal)));
        shown
            .map(|(place, _)| f64::from(other.tree.nearest(place).distance_sq))
            .collect()
    }
}

impl Hidden {
    /// Whether a grasp shows a point of the hand frame, whose normal looks so.
    fn shows(&self, place: &Point3<f32>, normal: &Vector3<f32>) -> bool {
        let (z, x) = (f64::from(place.z), f64::from(place.x));
        let is_held =
            x.abs() < self.finger_width_m / 2.0 + MARGIN_M && z < self.fingertips_m + MARGIN_M;
        let towards_camera = normal.xy().norm() * ELEVATION[1] + normal.z * ELEVATION[0];
        z > self.below_m + MARGIN_M && !is_held && towards_camera > GRAZING
    }
}
