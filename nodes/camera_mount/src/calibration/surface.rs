//! The part of a view that turns with the hand, with the directions of its surface.

use cloud::{Tree, normals, transformed, voxel};
use hand_eye::HandRegion;
use nalgebra::{Isometry3, Point3, Vector3};

use super::View;

/// Fewer points than these are no view of a gripper.
pub(super) const POINTS_MIN: usize = 200;
const VOXEL_M: f32 = 0.0025;
/// Side of the patch that a normal is taken from, m: some 16 points.
const PATCH_M: f32 = 0.01;

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
        let region = HandRegion::default();
        let in_hand = transformed(&view.hand_from_camera, &view.points);
        let near: Vec<Point3<f32>> = in_hand
            .iter()
            .zip(&view.points)
            .filter_map(|(placed, point)| region.holds(placed).then_some(*point))
            .collect();
        // Neither fails: no point of the hand's region is far away.
        let points = voxel::downsample(&near, VOXEL_M).unwrap_or_default();
        let mut normals = normals::of_patches(&points, PATCH_M).unwrap_or_default();
        normals::towards(&Point3::origin(), &points, &mut normals);
        let Some(tree) = Tree::new(&points).filter(|_| points.len() >= POINTS_MIN) else {
            return Err(points.len());
        };
        Ok(Self {
            hand_from_camera: view.hand_from_camera,
            normals,
            points,
            tree,
        })
    }
}
