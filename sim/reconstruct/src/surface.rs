//! From a cloud to a surface of even triangles.

use std::collections::HashSet;
use std::num::NonZeroUsize;
use std::time::Instant;

use cloud::Tree;
use cloud::normals::Moments;
use mesh::Mesh;
use mesh::file::Scan;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::downsample::{self, Oriented};
use crate::poisson::{Field, Sample, Surface};
use crate::report::{FromPoints, NormalSource, Seconds};
use crate::{ReconstructError, Settings, clean, normals, remesh, trim};

/// Number of neighbours from whose distance the area of a sample is estimated (12).
const AREA_NEIGHBOURS: NonZeroUsize = NonZeroUsize::MIN.saturating_add(11);
/// Thickness of a scan, as a share of its width, below which it is flat.
const THICKNESS_MIN: f64 = 1e-3;

/// Reconstructs the surface of a cloud: normals, thinning, Poisson, trimming, remeshing.
pub(crate) fn from_points(
    scan: &Scan,
    settings: &Settings,
) -> Result<(Mesh, FromPoints), ReconstructError> {
    let start = Instant::now();
    let (oriented, voxel_m, source) = oriented(scan, settings)?;
    let samples = samples(&oriented);
    let Some(tree) = Tree::new(&oriented.points) else {
        return Err(ReconstructError::TooFewPoints { count: 0 });
    };
    let spacing_m = spacing(&samples);
    let reach_m = settings.reach * spacing_m;
    let mut seconds = Seconds {
        points: start.elapsed().as_secs_f64(),
        ..Seconds::default()
    };

    let is_near = |point: &Point3<f64>| {
        f64::from(tree.nearest(&point.cast()).distance_sq) <= reach_m * reach_m
    };
    let field = Field::new(&samples, settings.depth, settings.screening, is_near);
    let mut surface = field.contour();
    let trimmed = trim::trim(&mut surface, &field, &tree, &oriented.points, reach_m);
    let whole = clean::clean(to_mesh(&surface)).0;
    seconds.poisson = start.elapsed().as_secs_f64() - seconds.points;

    let even = remesh::to_count(to_surface(&whole), settings.vertex_count, |point| {
        field.project(point)
    });
    seconds.remesh = start.elapsed().as_secs_f64() - seconds.points - seconds.poisson;
    let report = FromPoints {
        points: samples.len(),
        voxel_m,
        normals: source,
        spacing_m,
        cell_m: field.cell(),
        distance_rms_m: distance_rms(&samples, &field),
        trimmed,
        seconds,
    };
    Ok((to_mesh(&even), report))
}

/// The cloud without repeated points, with outward normals, thinned.
fn oriented(
    scan: &Scan,
    settings: &Settings,
) -> Result<(Oriented, Option<f32>, NormalSource), ReconstructError> {
    let mut seen = HashSet::with_capacity(scan.points_m.len());
    let is_new = |point: &Point3<f32>| {
        seen.insert([point.x, point.y, point.z].map(|coordinate| (coordinate + 0.0).to_bits()))
    };
    let kept: Vec<bool> = scan.points_m.iter().map(is_new).collect();
    let points: Vec<Point3<f32>> = kept_of(&scan.points_m, &kept);
    if points.len() < Settings::COUNT_MIN {
        return Err(ReconstructError::TooFewPoints {
            count: points.len(),
        });
    }
    refuse_flat(&points)?;
    let given = scan.normals.as_ref().map(|normals| {
        let normals = kept_of(normals, &kept).into_iter();
        normals
            .map(|normal| normal.cast().try_normalize(0.0).unwrap_or_default())
            .collect()
    });
    let (normals, source) = normals::outward(&points, given, settings.normal_neighbours);
    let has_normal: Vec<bool> = normals.iter().map(|normal| normal.norm() > 0.5).collect();
    let oriented = Oriented {
        points: kept_of(&points, &has_normal),
        normals: kept_of(&normals, &has_normal),
    };
    let count = oriented.points.len();
    if count < Settings::COUNT_MIN {
        return Err(ReconstructError::TooFewPoints { count });
    }
    let (oriented, voxel_m) = downsample::to_count(oriented, settings.point_count)?;
    Ok((oriented, voxel_m, source))
}

fn kept_of<T: Copy>(all: &[T], kept: &[bool]) -> Vec<T> {
    let pairs = all.iter().zip(kept);
    pairs
        .filter(|&(_, &kept)| kept)
        .map(|(&one, _)| one)
        .collect()
}

fn refuse_flat(points: &[Point3<f32>]) -> Result<(), ReconstructError> {
    let mut moments = Moments::default();
    for point in points {
        moments.add(&(point - points[0]).cast());
    }
    // Points on a line have no plane.
    let thickness_m = moments
        .plane()
        .map_or(0.0, |plane| plane.variances[0].sqrt());
    let width_m = cloud::bounds(points).map_or(0.0, |bounds| f64::from(bounds.extent().norm()));
    if thickness_m <= THICKNESS_MIN * width_m {
        return Err(ReconstructError::Flat {
            thickness_m,
            width_m,
        });
    }
    Ok(())
}

/// Points with the area that each represents: the disc around it that reaches its nearest neighbours on the same side of
/// the surface, divided by their number.
fn samples(oriented: &Oriented) -> Vec<Sample> {
    let Some(tree) = Tree::new(&oriented.points) else {
        return Vec::new();
    };
    let sample = |(point, normal): (&Point3<f32>, &Vector3<f64>)| {
        let near = tree.nearest_n(point, AREA_NEIGHBOURS).skip(1);
        let same_side = near.filter(|near| oriented.normals[near.index].dot(normal) >= 0.0);
        let (count, farthest_sq) = same_side.fold((0.0, 0.0_f32), |(count, _), near| {
            (count + 1.0, near.distance_sq)
        });
        Sample {
            point: point.cast(),
            normal: *normal,
            area: std::f64::consts::PI * f64::from(farthest_sq) / (count + 0.5),
        }
    };
    oriented
        .points
        .par_iter()
        .zip(&oriented.normals)
        .map(sample)
        .collect()
}

fn spacing(samples: &[Sample]) -> f64 {
    let area: f64 = samples.iter().map(|sample| sample.area).sum();
    (area / samples.len().max(1) as f64).sqrt()
}

fn distance_rms(samples: &[Sample], field: &Field) -> f64 {
    let distance_sq = |sample: &Sample| {
        let (place, _) = field.project(&sample.point)?;
        Some((place - sample.point).norm_squared())
    };
    let sum: f64 = samples.iter().filter_map(distance_sq).sum();
    (sum / samples.len().max(1) as f64).sqrt()
}

fn to_mesh(surface: &Surface) -> Mesh {
    Mesh {
        vertices: surface.points.iter().map(|point| point.cast()).collect(),
        triangles: surface.triangles.clone(),
    }
}

fn to_surface(mesh: &Mesh) -> Surface {
    Surface {
        points: mesh.vertices.iter().map(|point| point.cast()).collect(),
        triangles: mesh.triangles.clone(),
    }
}
