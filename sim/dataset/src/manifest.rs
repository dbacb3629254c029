//! manifest.csv: one row a mesh.

use serde::{Deserialize, Serialize};
use sim_deform::Dent;

use crate::object::Object;
use crate::plan::Unit;

const MM_PER_M: f64 = 1e3;

/// One mesh, made or refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the object, and of the mesh's folder.
    pub object: String,
    /// Number of the mesh in that folder, from 0.
    pub n: usize,
    /// The scan's file name, or `parametric`.
    pub source: String,
    /// Vertex under the first finger.
    pub handle_1: u32,
    /// Vertex under the second finger.
    pub handle_2: u32,
    /// Intensity that was asked for, mm (paper Eq. 4).
    pub asked_mm: f64,
    /// Intensity that was applied, mm; 0 where there is no mesh.
    pub applied_mm: f64,
    /// Chamfer distance, mm^2 (paper Eq. 5), unweighted like the next three losses. Empty where there is no mesh, like all
    /// optional columns.
    pub loss_distance_mm2: Option<f64>,
    /// Edge loss, mm^2.
    pub loss_edge_mm2: Option<f64>,
    /// Normal loss.
    pub loss_normal: Option<f64>,
    /// Laplacian smoothing loss, mm.
    pub loss_smooth_mm: Option<f64>,
    /// Their weighted sum.
    pub loss: Option<f64>,
    /// Edge loss as Eq. 5 is printed, mm^2. The distance is the same.
    pub printed_edge_mm2: Option<f64>,
    /// Normal loss as printed.
    pub printed_normal: Option<f64>,
    /// Laplacian smoothing loss as printed, 1/mm.
    pub printed_smooth_per_mm: Option<f64>,
    /// Their weighted sum.
    pub printed_loss: Option<f64>,
    /// Energy of the deformation (paper Eq. 3), mm^2; with `--energy laplacian` it has no one unit.
    pub energy_mm2: Option<f64>,
    /// Iterations of the deformation.
    pub iterations: Option<usize>,
    /// Seed of the run.
    pub seed: u64,
    /// SHA-256 of the mesh's file.
    pub sha256: Option<String>,
    /// Why the dent is shallower than asked, or was refused; empty otherwise.
    pub note: String,
}

impl Row {
    /// The row of mesh `n`, made by this dent, whose file has this digest.
    pub fn dented(
        object: &Object,
        unit: &Unit,
        n: usize,
        dent: &Dent,
        sha256: String,
        seed: u64,
    ) -> Self {
        Self {
            applied_mm: dent.applied_m * MM_PER_M,
            loss_distance_mm2: Some(dent.loss.distance_mm2),
            loss_edge_mm2: Some(dent.loss.edge_mm2),
            loss_normal: Some(dent.loss.normal),
            loss_smooth_mm: Some(dent.loss.smooth_mm),
            loss: Some(dent.loss.total),
            printed_edge_mm2: Some(dent.loss.printed.edge_mm2),
            printed_normal: Some(dent.loss.printed.normal),
            printed_smooth_per_mm: Some(dent.loss.printed.smooth_per_mm),
            printed_loss: Some(dent.loss.printed.total),
            energy_mm2: Some(dent.energy_m2 * MM_PER_M * MM_PER_M),
            iterations: Some(dent.iterations),
            sha256: Some(sha256),
            note: note(unit, dent).to_owned(),
            ..Self::refused(object, unit, n, dent.asked_m, String::new(), seed)
        }
    }

    /// The row of mesh `n` if it could not be made.
    pub fn refused(
        object: &Object,
        unit: &Unit,
        n: usize,
        asked_m: f64,
        note: String,
        seed: u64,
    ) -> Self {
        Self {
            object: object.name.clone(),
            n,
            source: object.source.clone(),
            handle_1: unit.grasp.handles[0],
            handle_2: unit.grasp.handles[1],
            asked_mm: asked_m * MM_PER_M,
            applied_mm: 0.0,
            loss_distance_mm2: None,
            loss_edge_mm2: None,
            loss_normal: None,
            loss_smooth_mm: None,
            loss: None,
            printed_edge_mm2: None,
            printed_normal: None,
            printed_smooth_per_mm: None,
            printed_loss: None,
            energy_mm2: None,
            iterations: None,
            seed,
            sha256: None,
            note,
        }
    }

    /// Whether there is a mesh file for this row.
    pub fn has_mesh(&self) -> bool {
        self.sha256.is_some()
    }
}

fn note(unit: &Unit, dent: &Dent) -> &'static str {
    if dent.applied_m < dent.asked_m.min(unit.grasp.intensity_max_m) {
        "lowered: the surface would pass through itself"
    } else if dent.applied_m < dent.asked_m {
        "clamped: the deepest of this grasp"
    } else {
        ""
    }
}

/// Formats rows as CSV, with a header line if `titles`.
///
/// # Errors
/// A row cannot be formatted; this does not happen with rows made by this program.
pub fn to_csv(rows: &[Row], titles: bool) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(titles)
        .from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    writer
        .into_inner()
        .map_err(|error| error.into_error().into())
}

/// Parses CSV with a header line.
///
/// # Errors
/// A line is not a row.
pub fn from_csv(text: &[u8]) -> Result<Vec<Row>, csv::Error> {
    csv::Reader::from_reader(text).deserialize().collect()
}
