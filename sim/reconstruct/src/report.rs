//! Report of a reconstruction.

use std::fmt;

use mesh::file::Scan;
use mesh::{HalfEdges, Mesh, sides};
use serde::Serialize;

use crate::clean::Mended;

/// How points became a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FromPoints {
    /// Points that went into the reconstruction.
    pub points: usize,
    /// Side of the voxels that thinned them; `None` where there were no more than wanted.
    pub voxel_m: Option<f32>,
    /// Where the normals come from.
    pub normals: NormalSource,
    /// Mean distance between neighbouring points.
    pub spacing_m: f64,
    /// Side of the finest cells.
    pub cell_m: f64,
    /// Root mean square distance of the points from the surface.
    pub distance_rms_m: f64,
    /// Triangles left out because no points supported them.
    pub trimmed: usize,
    /// Times of the parts. Not serialised: they differ from run to run.
    #[serde(skip)]
    pub seconds: Seconds,
}

/// Where the normals of a cloud come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NormalSource {
    /// The file.
    Given,
    /// The file, where all look inward; they were turned over.
    GivenInward,
    /// Estimated from the points: the file has no normals.
    Estimated,
    /// Estimated from the points: the file's normals have inconsistent signs, as a plane fit leaves them.
    EstimatedForSides,
    /// Estimated from the points: the file's normals are not perpendicular to the surface.
    EstimatedForAskew,
}

impl fmt::Display for NormalSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Given => "given",
            Self::GivenInward => "given inward and turned over",
            Self::Estimated => "estimated",
            Self::EstimatedForSides => "estimated anew, since the given ones look to either side",
            Self::EstimatedForAskew => {
                "estimated anew, since the given ones do not stand on the surface"
            }
        })
    }
}

/// Durations of the steps, s.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// Normals and thinning.
    pub points: f64,
    /// Poisson reconstruction, trimming and repair.
    pub poisson: f64,
    /// Remeshing to even triangles.
    pub remesh: f64,
}

/// What was done with a scan, and the properties of the resulting mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Points or vertices of the scan.
    pub scan_points: usize,
    /// Triangles of the scan; 0 for a cloud.
    pub scan_triangles: usize,
    /// Points of the file that were no measurements: not finite, or at (0, 0, 0).
    pub dropped_points: usize,
    /// How a cloud became a surface; `None` for a mesh.
    pub from_points: Option<FromPoints>,
    /// What was mended, by kind.
    pub mended: Mended,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Boundary loops: closed lines along which the mesh is open.
    pub boundary_loops: usize,
    /// Handles, like that of a mug (the genus). If the object has none, they are bridges between walls that are closer to
    /// each other than the points.
    pub handles: usize,
}

impl Report {
    pub(crate) fn new(
        scan: &Scan,
        from_points: Option<FromPoints>,
        mended: Mended,
        mesh: &Mesh,
    ) -> Self {
        let edges = mesh.half_edges();
        let loops = edges.boundary_loops();
        Self {
            scan_points: scan.points_m.len(),
            scan_triangles: scan.triangles.len(),
            dropped_points: scan.dropped.count(),
            from_points,
            mended,
            vertices: mesh.vertices.len(),
            triangles: mesh.triangles.len(),
            boundary_loops: loops,
            handles: handles(mesh, &edges, loops),
        }
    }
}

impl Report {
    /// A property that no object for a gripper has, in words; `None` if there is none. A can or cup has no handle and may
    /// be open at both ends, a mug has one handle. Other numbers come from unusable normals or points.
    pub fn doubt(&self) -> Option<String> {
        let handles = (self.handles > HANDLES_MAX).then(|| format!("{} handles", self.handles));
        let open = (self.boundary_loops > OPEN_MAX)
            .then(|| format!("{} open places", self.boundary_loops));
        let found: Vec<String> = handles.into_iter().chain(open).collect();
        (!found.is_empty()).then(|| found.join(" and "))
    }

    /// Whether a surface made of points has so many handles or loops that it is unusable.
    pub(crate) fn is_tangled(&self) -> bool {
        self.from_points.is_some() && (self.handles > TANGLED || self.boundary_loops > TANGLED)
    }
}

const HANDLES_MAX: usize = 2;
const OPEN_MAX: usize = 4;
/// Number of handles or boundary loops from which a surface made of points is unusable. Measured: thin walls that touch in
/// places give about ten, normals with inconsistent signs hundreds.
const TANGLED: usize = 50;

/// Genus of a mesh of one component, by Euler's formula.
fn handles(mesh: &Mesh, edges: &HalfEdges, boundary_loops: usize) -> usize {
    let directed = mesh.triangles.iter().flat_map(|&corners| sides(corners));
    let open = directed
        .filter(|&(from, to)| !edges.contains(to, from))
        .count();
    let edge_count = (3 * mesh.triangles.len() + open) / 2;
    // Vertices − edges + triangles = 2 − 2 handles − loops.
    (2 + edge_count).saturating_sub(mesh.vertices.len() + mesh.triangles.len() + boundary_loops) / 2
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(from) = &self.from_points {
            write!(f, "{} points", self.scan_points)?;
            if self.dropped_points > 0 {
                write!(f, " ({} more were no measurements)", self.dropped_points)?;
            }
            if let Some(voxel_m) = from.voxel_m {
                write!(
                    f,
                    ", {} after voxels of {:.2} mm",
                    from.points,
                    voxel_m * 1000.0
                )?;
            }
            write!(
                f,
                ", normals {}, Poisson to cells of {:.2} mm",
                from.normals,
                from.cell_m * 1000.0
            )?;
        } else {
            write!(
                f,
                "{} vertices and {} triangles",
                self.scan_points, self.scan_triangles
            )?;
        }
        let open = match self.boundary_loops {
            0 => "closed".to_owned(),
            count => format!("open at {count} places"),
        };
        let handles = match self.handles {
            0 => String::new(),
            count => format!(", {count} handles"),
        };
        writeln!(
            f,
            " → {} vertices, {} triangles, {open}{handles}",
            self.vertices, self.triangles
        )?;
        write!(f, "\nmended: {}", self.mended)
    }
}

impl fmt::Display for Mended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = [
            (self.vertices_joined, "vertices joined"),
            (self.degenerate, "degenerate triangles"),
            (self.duplicate, "duplicate triangles"),
            (self.edges_cut, "edges cut open"),
            (self.overfull, "triangles too many at an edge"),
            (self.vertices_split, "vertices split"),
            (self.turned, "triangles turned over"),
            (self.components_dropped, "components dropped"),
            (self.unused, "unused vertices"),
        ];
        let mended = kinds.iter().filter(|(count, _)| *count > 0);
        let mended: Vec<String> = mended
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        f.write_str(if mended.is_empty() { "nothing" } else { "" })?;
        f.write_str(&mended.join(", "))
    }
}
