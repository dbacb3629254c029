//! What was done with a scan.

use std::fmt;

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
    /// Whether the normals were found here, not in the file.
    pub normals_estimated: bool,
    /// Mean distance of those points.
    pub spacing_m: f64,
    /// Side of the finest cells.
    pub cell_m: f64,
    /// Root mean square distance of those points from the surface.
    pub distance_rms_m: f64,
    /// Triangles left out because no points supported them.
    pub trimmed: usize,
    /// Times of the parts, in seconds. Not part of what the same scan gives again.
    #[serde(skip)]
    pub seconds: Seconds,
}

/// Where the time went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// Normals and thinning.
    pub points: f64,
    /// Poisson's equation and its surface.
    pub poisson: f64,
    /// Even triangles.
    pub remesh: f64,
}

/// What was done with a scan, and what came out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Points or vertices of the scan.
    pub scan_points: usize,
    /// Triangles of the scan; 0 for a cloud.
    pub scan_triangles: usize,
    /// How a cloud became a surface; `None` for a mesh.
    pub from_points: Option<FromPoints>,
    /// What was mended, by kind.
    pub mended: Mended,
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Closed lines along which the mesh is open.
    pub boundary_loops: usize,
    /// Handles, as of a mug. Where the object has none, they are bridges between walls too near each other for the
    /// points' distance.
    pub handles: usize,
}

impl Report {
    pub(crate) fn new(
        scan: [usize; 2],
        from_points: Option<FromPoints>,
        mended: Mended,
        mesh: &Mesh,
    ) -> Self {
        let edges = mesh.half_edges();
        let loops = edges.boundary_loops();
        Self {
            scan_points: scan[0],
            scan_triangles: scan[1],
            from_points,
            mended,
            vertices: mesh.vertices.len(),
            triangles: mesh.triangles.len(),
            boundary_loops: loops,
            handles: handles(mesh, &edges, loops),
        }
    }
}

/// By Euler's formula, for a mesh of one component.
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
            if let Some(voxel_m) = from.voxel_m {
                write!(
                    f,
                    ", {} after voxels of {:.2} mm",
                    from.points,
                    voxel_m * 1000.0
                )?;
            }
            let normals = if from.normals_estimated {
                "estimated"
            } else {
                "given"
            };
            write!(
                f,
                ", normals {normals}, Poisson to cells of {:.2} mm",
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
        writeln!(
            f,
            " → {} vertices, {} triangles, {open}",
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
