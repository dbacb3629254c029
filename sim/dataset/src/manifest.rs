//! manifest.csv: one row a mesh.

use serde::{Deserialize, Serialize};
use sim_deform::denter::Dent;

use crate::object::Object;
use crate::plan::Unit;

/// What is said of one mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Whose folder it is in.
    pub object: String,
    /// Its number in the folder.
    pub n: usize,
    /// The scan's file name, or `parametric`.
    pub source: String,
    /// Vertex under the first finger.
    pub handle_1: u32,
    /// Vertex under the second finger.
    pub handle_2: u32,
    /// Intensity that was asked for, mm (paper Eq. 4).
    pub asked_mm: f64,
    /// Intensity that could be done, mm.
    pub applied_mm: f64,
    /// Chamfer distance (paper Eq. 5), unweighted as the next three.
    pub loss_distance: f64,
    /// Edge loss.
    pub loss_edge: f64,
    /// Normal loss.
    pub loss_normal: f64,
    /// Laplacian smoothing loss.
    pub loss_smooth: f64,
    /// Their weighted sum.
    pub loss: f64,
    /// Energy of the deformation, mm^2 (paper Eq. 3).
    pub energy_mm2: f64,
    /// Iterations of the deformation.
    pub iterations: usize,
    /// Of the run.
    pub seed: u64,
    /// Empty where all was done as asked.
    pub note: String,
}

impl Row {
    /// Of the dent that became mesh `n`.
    pub fn new(object: &Object, unit: &Unit, n: usize, dent: &Dent, seed: u64) -> Self {
        Self {
            object: object.name.clone(),
            n,
            source: object.source.clone(),
            handle_1: unit.grasp.handles[0],
            handle_2: unit.grasp.handles[1],
            asked_mm: dent.asked_m * 1e3,
            applied_mm: dent.applied_m * 1e3,
            loss_distance: dent.loss.distance,
            loss_edge: dent.loss.edge,
            loss_normal: dent.loss.normal,
            loss_smooth: dent.loss.smooth,
            loss: dent.loss.total,
            energy_mm2: dent.energy_m2 * 1e6,
            iterations: dent.iterations,
            seed,
            note: String::new(),
        }
    }
}

/// Rows as text, with a line of titles where wanted.
///
/// # Errors
/// Never, as long as all fields have a text.
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

/// Rows of a text with titles.
///
/// # Errors
/// A line is no row.
pub fn from_csv(text: &[u8]) -> Result<Vec<Row>, csv::Error> {
    csv::Reader::from_reader(text).deserialize().collect()
}
