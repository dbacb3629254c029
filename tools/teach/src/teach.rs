//! Adds an object to a model.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adaptation::{Block, FeatureRows, FitSettings, KEPT_MAX};
use anyhow::{Context, Result, bail, ensure};
use classifier::TestCloud;
use mesh::Mesh;
use mesh::file::{MILLIMETRE, ply_bytes, read};
use serde::Serialize;
use sim_dataset::digest::hex_digest;
use sim_dataset::folder::REFERENCES;

use crate::adapt::{Adapted, adapt};
use crate::history::{Did, HeldOut, Step, origin_of};
use crate::judge::{Judged, Twin, held_out, told_apart};
use crate::look::{Watch, features, features_of_samples, to_learn, to_measure};
use crate::object::{Counts, check_label, extents_m, load, specimens};
use crate::progress::{Part, Progress};
use crate::stored::{Beside, Sizes, Stored};

/// What to teach.
#[derive(Debug, Clone)]
pub struct Order {
    /// Name of the object.
    pub label: String,
    /// Points or a mesh of it, +z up.
    pub scan: PathBuf,
    /// What it was made of, for the history.
    pub from: String,
    /// Length of the scan's unit, m.
    pub metres_per_unit: f64,
    /// Where the new model goes.
    pub out: PathBuf,
    /// How many dents and scans.
    pub counts: Counts,
    /// How layers are fitted.
    pub fit: FitSettings,
    /// Everything random comes from this.
    pub seed: u64,
}

/// What came of it.
#[derive(Debug, Clone, Serialize)]
pub struct Taught {
    /// Name of the object.
    pub label: String,
    /// The new model.
    pub model: PathBuf,
    /// Its size, bytes.
    pub model_bytes: usize,
    /// Size of its features, bytes.
    pub features_bytes: usize,
    /// The undented object.
    pub reference: PathBuf,
    /// The new object, on dents and views that it was not taught with.
    pub held_out: HeldOut,
    /// Accuracy on the kept clouds of the objects that were known before: of the old model, and of the new one.
    pub others_right: [f64; 2],
    /// What is hard to tell from it.
    pub twins: Vec<Twin>,
    /// What is doubtful about the mesh, in words.
    pub doubt: Option<String>,
    /// How long it took, s.
    pub seconds: Seconds,
}

/// How long the parts took, s.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Seconds {
    /// From the scan to a sound mesh.
    pub mesh: f64,
    /// Dents.
    pub dents: f64,
    /// Simulated scans.
    pub views: f64,
    /// Features, fitting, measuring and writing.
    pub model: f64,
}

/// Whether an object of this name can be taught.
///
/// # Errors
/// The name cannot be a label, or is one of the model's.
pub fn check_new(stored: &Stored, label: &str) -> Result<()> {
    check_label(label)?;
    if !stored.metadata.labels.iter().any(|known| known == label) {
        return Ok(());
    }
    let since = match origin_of(&stored.history, label) {
        Some(step) => format!("since {}", step.at),
        None => "from its training".to_owned(),
    };
    bail!(
        "{} knows {label} already, {since}; choose another name, or first: teach --forget {label}",
        stored.path.display()
    )
}

/// Teaches an object to a model and writes the new one.
///
/// # Errors
/// The object cannot be used, the label is taken, or a file cannot be read or written; the error names the remedy. The old model
/// and its files are unchanged after an error.
pub fn teach(
    stored: &Stored,
    order: &Order,
    stop: &AtomicBool,
    progress: &Progress,
) -> Result<Taught> {
    check_new(stored, &order.label)?;
    let finished = || progress.step();
    let watch = Watch {
        finished: &finished,
        stop,
    };
    let mut seconds = Seconds::default();
    let mut clock = Instant::now();
    let mut lap = || {
        std::mem::replace(&mut clock, Instant::now())
            .elapsed()
            .as_secs_f64()
    };
    progress.begin(Part::Mesh, 1);
    let object = load(&order.label, &order.scan, order.metres_per_unit)?;
    seconds.mesh = lap();
    watch.go_on()?;
    let Counts { grasps, scans } = order.counts;
    progress.begin(Part::Dent, grasps);
    let specimens = specimens(&object, order.counts, order.seed, &watch)?;
    seconds.dents = lap();
    progress.begin(Part::Look, 2 * scans + scans.div_ceil(2));
    let seeds = [1, 2, 3].map(|part: u64| order.seed.wrapping_mul(8).wrapping_add(part));
    let fit_inputs = to_learn(&specimens.fit, &stored.metadata, seeds[0], &watch)?;
    let check_inputs = to_learn(&specimens.check, &stored.metadata, seeds[1], &watch)?;
    let test_inputs = to_measure(&specimens.test, &stored.metadata, seeds[2], &watch)?;
    ensure!(
        !fit_inputs.is_empty() && !check_inputs.is_empty() && !test_inputs.is_empty(),
        "the camera sees too little of {} in the hand; is it large enough, and is its scan +z up?",
        order.label
    );
    seconds.views = lap();
    progress.begin(Part::Adapt, order.fit.steps);
    let mut extractor = stored.extractor()?;
    let width = stored.kept.width;
    let block = Block {
        label: Some(order.label.clone()),
        fit: features(&fit_inputs, &mut extractor, width)?.thinned(KEPT_MAX[0]),
        check: features(&check_inputs, &mut extractor, width)?.thinned(KEPT_MAX[1]),
    };
    let test = features_of_samples(&test_inputs, &mut extractor, width)?;
    let adapted = adapt(stored, block, &order.fit, |_| {
        progress.step();
        watch.go_on().is_ok()
    })?;
    watch.go_on()?;
    progress.begin(Part::Measure, 1);
    let mesh = object.denter.source().stood_up();
    let measured = measure(stored, &adapted, &test, &mesh)?;
    let bytes = std::fs::read(&order.scan)
        .with_context(|| format!("cannot read {}", order.scan.display()))?;
    let did = Did::Teach {
        label: order.label.clone(),
        from: order.from.clone(),
        sha256: hex_digest(&bytes),
        held_out: measured.held_out.clone(),
    };
    let mut self_test = stored.self_test.clone();
    self_test.extend(
        check_inputs
            .iter()
            .map(|input| TestCloud::of(&order.label, input)),
    );
    let changed = adapted.changed(self_test, Step::now(did, &stored.digest));
    let folder = order.out.with_file_name(REFERENCES);
    let mut beside = references_for(stored, &folder)?;
    let reference = folder.join(format!("{}.ply", order.label));
    beside.push(Beside {
        path: reference.clone(),
        bytes: ply_bytes(&mesh),
    });
    watch.go_on()?;
    let Sizes { model, features } = stored.write(&changed, &order.out, beside)?;
    seconds.model = lap();
    Ok(Taught {
        label: order.label.clone(),
        model: order.out.clone(),
        model_bytes: model,
        features_bytes: features,
        reference,
        held_out: measured.held_out,
        others_right: measured.others_right,
        twins: measured.twins,
        doubt: object.doubt(),
        seconds,
    })
}

struct Measured {
    held_out: HeldOut,
    others_right: [f64; 2],
    twins: Vec<Twin>,
}

fn measure(
    stored: &Stored,
    adapted: &Adapted,
    test: &[FeatureRows],
    mesh: &Mesh,
) -> Result<Measured> {
    let judge = adapted.judge();
    let new = stored.head.classes();
    let answers: Vec<Judged> = test.iter().map(|samples| judge.judge(samples)).collect();
    let before = stored.judge();
    let references = stored.references()?;
    let mut others_right = [0.0; 2];
    let mut twins = Vec::new();
    for (class, label) in stored.metadata.labels.iter().enumerate() {
        let check = &stored.kept.blocks[class].check;
        let now = judge.judge_each(check);
        for (total, answers) in others_right
            .iter_mut()
            .zip([&before.judge_each(check), &now])
        {
            *total += held_out(answers, class).right / new as f64;
        }
        let apart = told_apart((new, &answers), (class, &now));
        let larger_m = larger_m(mesh, &references.join(format!("{label}.ply")));
        twins.extend(Twin::of(label, apart, larger_m));
    }
    Ok(Measured {
        held_out: held_out(&answers, new),
        others_right,
        twins,
    })
}

/// How much wider and higher a mesh is than that of a file, m.
fn larger_m(mesh: &Mesh, other: &Path) -> Option<[f64; 2]> {
    let other = read(other, MILLIMETRE).ok()?.mesh();
    let size = |mesh: &Mesh| {
        let [x, y, z] = extents_m(mesh).map(f64::from);
        [x.max(y), z]
    };
    let ([width, height], [other_width, other_height]) = (size(mesh), size(&other));
    Some([width - other_width, height - other_height])
}

/// The references of what a model knows that the new model's folder lacks.
///
/// # Errors
/// A reference cannot be read.
pub fn references_for(stored: &Stored, folder: &Path) -> Result<Vec<Beside>> {
    let from = stored.references()?;
    let mut files = Vec::new();
    for label in &stored.metadata.labels {
        let name = format!("{label}.ply");
        let (source, path) = (from.join(&name), folder.join(&name));
        if source.is_file() && !path.exists() {
            let bytes = std::fs::read(&source)
                .with_context(|| format!("cannot read {}", source.display()))?;
            files.push(Beside { path, bytes });
        }
    }
    Ok(files)
}
