//! Two scans, and how well they agree in a pose.

use cloud::{Tree, normals, transformed, voxel};
use nalgebra::{Isometry3, Point3, Vector3};

use super::{Hidden, RegraspError};
use crate::error::RegistrationError;
use crate::parameters::Parameters;
use crate::registrar::Registrar;

/// Farther than this from the other scan a point does not agree with it, m.
const MATCH_M: f64 = 0.005;
/// Distance at which one that does not counts in the search, m.
const LIMIT_M: f64 = 0.01;
/// Nearer to a boundary of what a grasp hides, a point may be seen or not, m.
const MARGIN_M: f64 = 0.004;
/// Voxels along the side of the patch that a normal is taken from.
const PATCH_VOXELS: f64 = 4.0;
/// Sine and cosine of the camera's elevation over the object, some 15 degrees.
const ELEVATION: [f32; 2] = [0.26, 0.97];
/// Cosine between normal and line of sight below which a depth camera sees little.
const GRAZING: f32 = 0.3;
/// With fewer points that should be seen, a pose cannot be judged.
const JUDGED_MIN: usize = 50;

/// How well the scans agree in one pose.
pub(super) struct Agreement {
    pub(super) first_from_second: Isometry3<f64>,
    pub(super) fitness: f64,
    pub(super) rmse_m: f64,
    /// Mean square distance, in which a point without a neighbour counts as one at the limit, m².
    pub(super) error_sq: f64,
}

/// Both scans, thinned, ready to be laid onto each other many times.
pub(super) struct Pair {
    scans: [Surface; 2],
    registrar: Registrar,
    hidden: Hidden,
}

impl Pair {
    pub(super) fn new(
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
            // Much of the object may be gone, and new, as long as a pose is wrong.
            max_change: 1.0,
            max_gripper_change: 1.0,
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

    /// The pose of the second scan to which a start is corrected.
    pub(super) fn settle(
        &self,
        start: Isometry3<f64>,
    ) -> Result<Isometry3<f64>, RegistrationError> {
        let mut registrar = self.registrar.clone();
        let evidence = registrar.add_view(&self.scans[1].points, Some(start))?;
        Ok(evidence.transform)
    }

    pub(super) fn agreement(&self, first_from_second: &Isometry3<f64>) -> Agreement {
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
        let outward = |(point, normal): (&Point3<f32>, Option<Vector3<f32>>)| {
            let normal = normal.unwrap_or_default();
            // What the camera saw looks to it: outward, and a little up.
            let outward = (point - middle).xy().try_normalize(0.0).unwrap_or_default();
            let seen_from = Vector3::new(outward.x, outward.y, ELEVATION[0]);
            normal * normal.dot(&seen_from).signum()
        };
        let normals = normals::of_patches(&points, (PATCH_VOXELS * voxel_m) as f32)
            .map_err(RegistrationError::TooLarge)?;
        let normals = points.iter().zip(normals).map(outward);
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
