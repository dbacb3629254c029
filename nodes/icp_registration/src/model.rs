//! All views so far, thinned.

use cloud::normals::Moments;
use cloud::voxel::{Grid, VoxelError};
use nalgebra::{Point3, Vector3};

use crate::rows::Rows;

/// The cloud that views are laid onto.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    grid: Grid,
    voxel_m: f32,
}

/// The model as it is while a view is laid onto it.
pub(crate) struct Searchable {
    pub(crate) points: Vec<Point3<f32>>,
    /// Of `points`.
    pub(crate) rows: Rows,
    /// About the distance between neighbouring points.
    pub(crate) voxel_m: f32,
}

/// Width of the rows: a search of one or two voxels meets four of them at most.
const ROW_VOXELS: f32 = 4.0;

impl Searchable {
    /// `None` for no points.
    pub(crate) fn new(points: Vec<Point3<f32>>, voxel_m: f32) -> Option<Self> {
        Rows::new(&points, ROW_VOXELS * voxel_m).map(|rows| Self {
            points,
            rows,
            voxel_m,
        })
    }
}

impl Model {
    pub(crate) fn new(voxel_m: f32) -> Result<Self, VoxelError> {
        Ok(Self {
            grid: Grid::new(voxel_m)?,
            voxel_m,
        })
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.grid.is_empty()
    }

    pub(crate) fn extend(&mut self, points: &[Point3<f32>]) -> Result<(), VoxelError> {
        self.grid.extend(points)
    }

    pub(crate) fn points(&self) -> Vec<Point3<f32>> {
        self.grid.means().collect()
    }

    /// `None` for an empty model.
    pub(crate) fn searchable(&self) -> Option<Searchable> {
        Searchable::new(self.points(), self.voxel_m)
    }

    /// Unit normal of each of the model's points; `None` where the surface is not flat.
    pub(crate) fn normals(
        &self,
        points: &[Point3<f32>],
    ) -> Result<Vec<Option<Vector3<f32>>>, VoxelError> {
        normals(points, PATCH_VOXELS * self.voxel_m)
    }
}

/// Voxels along the side of the patch that a normal is taken from: 8 mm at the default of 2 mm, in which the side of a
/// can rises by a quarter of a millimetre, less than a D435i's noise.
const PATCH_VOXELS: f32 = 4.0;
/// Fewer points than these make a normal of noise.
const PATCH_MIN_POINTS: usize = 6;
/// A patch is flat if the variance across it is below this share of that along its shorter side.
const FLAT_BELOW: f64 = 0.15;

/// The normal of each point's patch. One plane a cube of the grid costs a hundredth of one a point.
fn normals(points: &[Point3<f32>], patch_m: f32) -> Result<Vec<Option<Vector3<f32>>>, VoxelError> {
    let mut patches = Grid::new(patch_m)?;
    patches.extend(points)?;
    let patch_of: Vec<Option<usize>> = points.iter().map(|point| patches.cell_of(point)).collect();
    let mut moments = vec![Moments::default(); patches.len()];
    for (point, patch) in points.iter().zip(&patch_of) {
        if let Some(patch) = *patch {
            moments[patch].add(&point.coords.cast());
        }
    }
    let normals: Vec<_> = moments.iter().map(patch_normal).collect();
    Ok(patch_of.into_iter().map(|patch| normals[patch?]).collect())
}

fn patch_normal(moments: &Moments) -> Option<Vector3<f32>> {
    if moments.count() < PATCH_MIN_POINTS {
        return None;
    }
    let plane = moments.plane()?;
    let is_flat = plane.variances[0] < FLAT_BELOW * plane.variances[1];
    is_flat.then(|| plane.normal.into_inner().cast())
}
