//! Whether a scan shows one object.

use std::num::NonZeroUsize;

use cloud::Tree;
use cloud::voxel::downsample;
use mesh::file::Scan;
use nalgebra::Point3;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::ReconstructError;

/// Parts with a wider gap than this between them are not of one object, m. Views of an object leave no such gap: the fingers
/// hide a strip, not a ring.
const GAP_M: f32 = 0.008;
/// Side of the voxels that stand for the surface, m: however dense the points are, each counts alike.
const VOXEL_M: f32 = 0.003;
/// A part with this share of the surface is an object, a smaller one a leftover: the fingertips are 5 % of a can.
const OBJECT_SHARE: f64 = 0.1;
/// Number of points that are sampled on the surface of a mesh.
const SURFACE_POINTS: usize = 20_000;

/// Nearest neighbours from which the point spacing of a scan is estimated: the point itself and four others, as on a square grid.
const NEIGHBOURS: NonZeroUsize = NonZeroUsize::MIN.saturating_add(4);
/// In a sparse scan, a gap is a distance of more than this many times the point spacing.
const SPACINGS: f32 = 2.0;

/// Refuses a scan that shows several objects, each with a tenth of the surface or more, and more than 8 mm from the others, or
/// more than the points of a sparse scan are from each other. Leftovers are no objects.
///
/// # Errors
/// [`ReconstructError::SeveralObjects`].
pub fn check_one_object(scan: &Scan) -> Result<(), ReconstructError> {
    let surface = match scan.is_cloud() {
        true => scan.points_m.clone(),
        false => {
            let mut random = Pcg64Mcg::seed_from_u64(0);
            scan.mesh().surface_points(SURFACE_POINTS, &mut random)
        }
    };
    // Points too far apart for voxels are of no object; what is wrong with them is said later.
    let Ok(voxels) = downsample(&surface, VOXEL_M) else {
        return Ok(());
    };
    let least = OBJECT_SHARE * voxels.len() as f64;
    let Some(tree) = Tree::new(&voxels) else {
        return Ok(());
    };
    let gap_m = GAP_M.max(SPACINGS * spacing_m(&voxels, &tree));
    let sizes = part_sizes(&voxels, &tree, gap_m);
    let count = sizes.iter().filter(|&&size| size as f64 >= least).count();
    if count > 1 {
        return Err(ReconstructError::SeveralObjects {
            count,
            gap_mm: 1e3 * gap_m,
        });
    }
    Ok(())
}

/// Distance of the farthest of a point's neighbours, m: the median over all points.
fn spacing_m(points: &[Point3<f32>], tree: &Tree) -> f32 {
    let farthest_sq = |point| {
        let near = tree.nearest_n(point, NEIGHBOURS);
        near.map(|near| near.distance_sq).fold(0.0, f32::max)
    };
    let mut squares: Vec<f32> = points.iter().map(farthest_sq).collect();
    let middle = squares.len() / 2;
    squares.sort_by(f32::total_cmp);
    squares.get(middle).map_or(0.0, |square| square.sqrt())
}

/// Sizes of the parts that points with no wider gap make.
fn part_sizes(points: &[Point3<f32>], tree: &Tree, gap_m: f32) -> Vec<usize> {
    let mut is_reached = vec![false; points.len()];
    let mut sizes = Vec::new();
    for first in 0..points.len() {
        if std::mem::replace(&mut is_reached[first], true) {
            continue;
        }
        let (mut size, mut open) = (0, vec![first]);
        while let Some(at) = open.pop() {
            size += 1;
            for near in tree.within(&points[at], gap_m) {
                if !std::mem::replace(&mut is_reached[near.index], true) {
                    open.push(near.index);
                }
            }
        }
        sizes.push(size);
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::Mesh;
    use nalgebra::Isometry3;

    fn count(mesh: Mesh, is_cloud: bool) -> usize {
        let mut scan = Scan::from(mesh);
        if is_cloud {
            let mut random = Pcg64Mcg::seed_from_u64(1);
            scan.points_m = scan.mesh().surface_points(30_000, &mut random);
            scan.triangles.clear();
        }
        match check_one_object(&scan) {
            Err(ReconstructError::SeveralObjects { count, .. }) => count,
            _ => 1,
        }
    }

    /// A can, and another solid of this radius so far beside it.
    fn two(radius_m: f32, gap_m: f32) -> Mesh {
        let mut mesh = Mesh::cylinder(0.03, 0.0, 0.1, 48);
        let beside = Mesh::cylinder(radius_m, 0.0, 2.0 * radius_m, 48);
        let at = Isometry3::translation(0.03 + gap_m + radius_m, 0.0, 0.0);
        mesh.append(&beside.transformed(&at));
        mesh
    }

    #[test]
    fn two_objects_are_told_from_one_with_leftovers() {
        for is_cloud in [false, true] {
            assert_eq!(count(two(0.03, 0.013), is_cloud), 2);
            assert_eq!(count(two(0.03, 0.004), is_cloud), 1, "a lid that lies on");
            assert_eq!(count(two(0.01, 0.02), is_cloud), 1, "a leftover");
            let mut shell = Mesh::cylinder(0.03, 0.0, 0.1, 48);
            shell.append(&Mesh::cylinder(0.027, 0.003, 0.097, 48));
            assert_eq!(count(shell, is_cloud), 1, "two walls");
        }
        assert_eq!(count(Mesh::default(), true), 1);
    }

    #[test]
    fn a_sparse_scan_is_of_one_object() {
        for points in [30, 100, 300, 1000] {
            let mut random = Pcg64Mcg::seed_from_u64(points as u64);
            let surface = Mesh::cylinder(0.03, 0.0, 0.1, 48);
            let scan = Scan {
                points_m: surface.surface_points(points, &mut random),
                ..Scan::default()
            };
            assert_eq!(check_one_object(&scan), Ok(()), "{points} points");
        }
    }
}
