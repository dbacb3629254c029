//! Downsampling: one point for each voxel and side of the surface.

use cloud::voxel::{Grid, VoxelError};
use nalgebra::{Point3, Vector3};

/// How near the wanted count is near enough, as a share of it.
const TOLERANCE: f64 = 0.005;
const STEPS_MAX: usize = 40;
/// Clouds that exceed the wanted count by at most this share are not thinned.
const LEFT_ALONE: f64 = 0.1;

/// Points with their normals, one each.
pub(crate) struct Oriented {
    pub points: Vec<Point3<f32>>,
    pub normals: Vec<Vector3<f64>>,
}

/// Thins a cloud to about `wanted` points by bisecting the voxel size. Returns the points and the voxels' side in m, `None`
/// where the cloud was small enough.
///
/// A voxel's points are averaged, but those with opposite normals separately: they are the two sides of a thin wall.
pub(crate) fn to_count(
    source: Oriented,
    wanted: usize,
) -> Result<(Oriented, Option<f32>), VoxelError> {
    if source.points.len() as f64 <= (1.0 + LEFT_ALONE) * wanted as f64 {
        return Ok((source, None));
    }
    let widest = cloud::bounds(&source.points).map_or(0.0, |bounds| bounds.extent().max());
    // Smaller voxels would have indices beyond the grid's range.
    let (mut low, mut high) = (widest * 1e-4, widest);
    let mut best: Option<(usize, Oriented, f32)> = None;
    for _ in 0..STEPS_MAX {
        let size_m = (low * high).sqrt();
        let oriented = averaged(&source, size_m)?;
        let count = oriented.points.len();
        let miss = count.abs_diff(wanted);
        if best.as_ref().is_none_or(|(least, ..)| miss < *least) {
            best = Some((miss, oriented, size_m));
        }
        if miss as f64 <= TOLERANCE * wanted as f64 {
            break;
        }
        if count > wanted {
            low = size_m
        } else {
            high = size_m
        }
    }
    Ok(match best {
        Some((_, oriented, size_m)) => (oriented, Some(size_m)),
        None => (source, None),
    })
}

#[derive(Clone, Copy, Default)]
struct Side {
    point: Vector3<f64>,
    normal: Vector3<f64>,
    count: f64,
}

fn averaged(source: &Oriented, size_m: f32) -> Result<Oriented, VoxelError> {
    let mut grid = Grid::new(size_m)?;
    grid.extend(&source.points)?;
    let mut sides = vec![[Side::default(); 2]; grid.len()];
    for (point, normal) in source.points.iter().zip(&source.normals) {
        let Some(cell) = grid.cell_of(point) else {
            continue;
        };
        let [front, _] = &sides[cell];
        let side = usize::from(front.count > 0.0 && front.normal.dot(normal) < 0.0);
        let side = &mut sides[cell][side];
        side.point += point.coords.cast();
        side.normal += normal;
        side.count += 1.0;
    }
    let used = sides.iter().flatten().filter(|side| side.count > 0.0);
    let (points, normals) = used
        .filter_map(|side| {
            let normal = side.normal.try_normalize(1e-9)?;
            Some((Point3::from((side.point / side.count).cast()), normal))
        })
        .unzip();
    Ok(Oriented { points, normals })
}
