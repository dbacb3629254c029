//! The part of a view that turns with the hand, with the directions of its surface.

use std::num::NonZeroUsize;

use cloud::normals::Moments;
use cloud::{Tree, transformed, voxel};
use nalgebra::{Isometry3, Point3, Vector3};

use super::View;

/// Fewer points than these are no view of a gripper.
pub(super) const POINTS_MIN: usize = 200;
/// The forearm, which does not turn with the hand, ends below this height over the hand's frame, m; the mount's error is in it.
const ABOVE_M: f32 = 0.02;
/// Gripper and object are nearer to the hand's axis than this, m.
const RADIUS_M: f32 = 0.12;
const VOXEL_M: f32 = 0.0025;
/// Points that a normal is taken from: a patch of about a centimetre.
const PATCH: NonZeroUsize = NonZeroUsize::MIN.saturating_add(19);
/// A patch is flat if the variance across it is below this share of that along its shorter side.
const FLAT_BELOW: f64 = 0.1;

/// What is matched of a view, in its camera's frame.
pub(super) struct Surface {
    pub(super) hand_from_camera: Isometry3<f64>,
    pub(super) points: Vec<Point3<f32>>,
    /// Towards the camera; `None` where the surface is not flat.
    pub(super) normals: Vec<Option<Vector3<f32>>>,
    pub(super) tree: Tree,
}

impl Surface {
    /// Or how many points there were, if too few.
    pub(super) fn new(view: &View) -> Result<Self, usize> {
        let in_hand = transformed(&view.hand_from_camera, &view.points);
        let turns = |point: &Point3<f32>| {
            point.z > ABOVE_M && point.xy().coords.norm_squared() < RADIUS_M * RADIUS_M
        };
        let near: Vec<Point3<f32>> = in_hand
            .iter()
            .zip(&view.points)
            .filter_map(|(placed, point)| turns(placed).then_some(*point))
            .collect();
        let points = voxel::downsample(&near, VOXEL_M).unwrap_or_default();
        let Some(tree) = Tree::new(&points).filter(|_| points.len() >= POINTS_MIN) else {
            return Err(points.len());
        };
        let normals = points.iter().map(|point| normal(point, &points, &tree));
        Ok(Self {
            hand_from_camera: view.hand_from_camera,
            normals: normals.collect(),
            points,
            tree,
        })
    }
}

fn normal(point: &Point3<f32>, points: &[Point3<f32>], tree: &Tree) -> Option<Vector3<f32>> {
    let mut moments = Moments::default();
    for near in tree.nearest_n(point, PATCH) {
        moments.add(&(points[near.index] - point).cast());
    }
    let plane = moments.plane()?;
    if plane.variances[0] > FLAT_BELOW * plane.variances[1] {
        return None;
    }
    let normal: Vector3<f32> = plane.normal.into_inner().cast();
    Some(if normal.dot(&point.coords) > 0.0 {
        -normal
    } else {
        normal
    })
}
