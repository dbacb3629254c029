//! The part of a view that turns with the hand, with its surface normals.

use cloud::{Tree, normals, transformed, voxel};
use hand_eye::HandRegion;
use nalgebra::{Isometry3, Point3, Vector3};

use super::View;

/// Least number of points of a usable view.
pub(super) const POINTS_MIN: usize = 200;
const VOXEL_M: f32 = 0.0025;
/// Side of the patch that a normal is taken from, m: some 16 points.
const PATCH_M: f32 = 0.01;

/// The matched part of a view, in its camera's frame.
pub(super) struct Surface {
    pub(super) hand_from_camera: Isometry3<f64>,
    pub(super) points: Vec<Point3<f32>>,
    /// Unit normals that face the camera; `None` where the surface is not flat.
    pub(super) normals: Vec<Option<Vector3<f32>>>,
    pub(super) tree: Tree,
}

impl Surface {
    /// Downsamples the points and computes normals. `Err` holds the number of points if there are too few.
    pub(super) fn new(view: &View) -> Result<Self, usize> {
        let region = HandRegion::default();
        let in_hand = transformed(&view.hand_from_camera, &view.points);
        let near: Vec<Point3<f32>> = in_hand
            .iter()
            .zip(&view.points)
            .filter_map(|(placed, point)| region.holds(placed).then_some(*point))
            .collect();
        // Neither call can fail, since all points are within the hand's region.
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
