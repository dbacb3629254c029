//! From a scan, points or a mesh, to a mesh that can be deformed (paper Sec. IV-B 1-2).
//!
//! A cloud gets outward normals, is thinned to an even density and becomes a surface by Poisson reconstruction. Parts that
//! no point supports are trimmed, and the rest is remeshed to even triangles. A mesh skips all this. Both are then
//! repaired, so that the result meets the conditions of [`check()`], which deformation relies on.
//!
//! Two walls nearer to each other than the thinned points grow together here and there; [`Report::handles`] tells, and a
//! larger [`Settings::point_count`] helps. Points without normals show two walls only if these are farther apart than
//! the raw points' neighbours.

mod check;
mod clean;
mod downsample;
mod normals;
mod poisson;
mod remesh;
mod report;
mod settings;
mod several;
mod surface;
mod trim;

use mesh::Mesh;
use mesh::file::Scan;

pub use check::{Defect, check};
pub use clean::Mended;
pub use report::{FromPoints, NormalSource, Report, Seconds};
pub use settings::Settings;
pub use several::check_one_object;

/// Why a scan does not become a mesh, and what to do about it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReconstructError {
    /// A setting out of range.
    #[error("{name} is {value}; expected {expected}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// What was asked for.
        value: String,
        /// The allowed range.
        expected: String,
    },
    /// Too few points for a shape.
    #[error(
        "the scan has {count} usable points; scan again for at least {}",
        Settings::COUNT_MIN
    )]
    TooFewPoints {
        /// How many there are, without repeats and those whose normal has no direction.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {index} of the scan is not finite; remove such points")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// The points lie in a plane or on a line.
    #[error(
        "the scan is flat: {thickness_m} m thick and {width_m} m wide; scan the object from more sides"
    )]
    Flat {
        /// Standard deviation of the points across their best plane.
        thickness_m: f64,
        /// Diagonal of the box around them.
        width_m: f64,
    },
    /// The numbers of normals and points differ.
    #[error("the scan has {normals} normals for {points} points; give each one, or none")]
    Normals {
        /// How many normals there are.
        normals: usize,
        /// How many points there are.
        points: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error(
        "triangle {triangle} of the scan names vertices {corners:?} of {vertices}; export it again"
    )]
    Corners {
        /// Index of the triangle.
        triangle: usize,
        /// Its corners.
        corners: [u32; 3],
        /// How many vertices there are.
        vertices: usize,
    },
    /// Parts too far from each other for one object.
    #[error(
        "{count} objects are in view, more than {gap_mm:.0} mm from each other; show one alone"
    )]
    SeveralObjects {
        /// How many there are.
        count: usize,
        /// A wider gap than this, mm, separates objects.
        gap_mm: f32,
    },
    /// A surface that no object has.
    #[error(
        "the scan's surface has {found}, which no object has: its points or normals are no surface's; leave the normals out, \
         or scan again"
    )]
    Tangled {
        /// What it has too many of.
        found: String,
    },
    /// The points are too far from the origin for voxels as small as their spacing.
    #[error(transparent)]
    Voxel(#[from] cloud::VoxelError),
    /// The repaired mesh still violates a condition of [`check()`].
    #[error("the scan cannot be mended ({0}); scan again, or repair it by hand")]
    Unmended(#[from] Defect),
}

/// Makes a clean mesh of a scan. The same scan and settings give the same mesh, whatever the number of threads.
///
/// # Errors
/// [`ReconstructError`] for settings out of range, and for scans of which no mesh can be made.
pub fn mesh_from_scan(
    scan: &Scan,
    settings: &Settings,
) -> Result<(Mesh, Report), ReconstructError> {
    settings.check()?;
    check_scan(scan)?;
    check_one_object(scan)?;
    let (raw, from_points) = if scan.is_cloud() {
        let (mesh, from_points) = surface::from_points(scan, settings)?;
        (mesh, Some(from_points))
    } else {
        (scan.mesh(), None)
    };
    let (mesh, mended) = clean::clean(raw);
    check(&mesh)?;
    let report = Report::new(scan, from_points, mended, &mesh);
    match report.doubt().filter(|_| report.is_tangled()) {
        Some(found) => Err(ReconstructError::Tangled { found }),
        None => Ok((mesh, report)),
    }
}

/// Checks what a reader of files guarantees, since a scan need not come from a file.
fn check_scan(scan: &Scan) -> Result<(), ReconstructError> {
    let points = scan.points_m.len();
    if let Some(index) = scan
        .points_m
        .iter()
        .position(|point| !cloud::is_finite(point))
    {
        return Err(ReconstructError::NotFinite { index });
    }
    if let Some(normals) = scan
        .normals
        .as_ref()
        .map(Vec::len)
        .filter(|&normals| normals != points)
    {
        return Err(ReconstructError::Normals { normals, points });
    }
    let is_there = |corners: &[u32; 3]| corners.iter().all(|&corner| (corner as usize) < points);
    match scan.triangles.iter().position(|corners| !is_there(corners)) {
        Some(triangle) => Err(ReconstructError::Corners {
            triangle,
            corners: scan.triangles[triangle],
            vertices: points,
        }),
        None => Ok(()),
    }
}
