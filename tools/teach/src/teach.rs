//! Adds an object to a model.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adaptation::calibration::{Prior, inverse_temperature_near, log_sum_exp, threshold_near};
use adaptation::{Block, FeatureRows, FitSettings, Head, fit};
use anyhow::{Context, Result, bail, ensure};
use mesh::Mesh;
use mesh::file::{MILLIMETRE, ply_bytes, read};
use serde::Serialize;
use sim_dataset::digest::hex_digest;
use sim_dataset::folder::REFERENCES;

use crate::history::{Did, HeldOut, Step, origin_of};
use crate::judge::{Judge, Judged, Twin, held_out, logits, told_apart};
use crate::look::{Watch, features, features_of_samples, to_learn, to_measure};
use crate::object::{Counts, check_label, extents_m, load, specimens};
use crate::progress::Progress;
use crate::stored::{Beside, Changed, Sizes, Stored};

/// Most clouds of a label that are kept, to fit layers with and to check.
pub const KEPT_MAX: [usize; 2] = [240, 120];
/// So many clouds the temperature and the threshold of before count for.
const PRIOR_CLOUDS: f64 = 200.0;
/// Share of the clouds that the threshold of the known score accepts, as in training.
const KNOWN_SHARE: f64 = 0.95;

/// What to teach.
#[derive(Debug, Clone)]
pub struct Order {
    /// Name of the object.
    pub label: String,
    /// Points or a mesh of it, +z up.
    pub scan: PathBuf,
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
    /// Share of the kept clouds of what was known before that is named rightly by the model of before and by the new one.
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

/// Teaches an object to a model and writes the new one.
///
/// # Errors
/// What is wrong with the object, the label or the files, with the remedy; nothing has changed then.
pub fn teach(stored: &Stored, order: &Order, stop: &AtomicBool) -> Result<Taught> {
    check_new(stored, &order.label)?;
    let Counts { grasps, scans } = order.counts;
    let steps = grasps + 2 * scans + scans.div_ceil(2) + order.fit.steps;
    let progress = Progress::new(steps);
    let taught = run(stored, order, stop, &progress);
    progress.clear();
    taught
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

fn run(stored: &Stored, order: &Order, stop: &AtomicBool, progress: &Progress) -> Result<Taught> {
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
    progress.say("making a mesh of the scan");
    let object = load(&order.label, &order.scan, order.metres_per_unit)?;
    seconds.mesh = lap();
    progress.say("denting it");
    let specimens = specimens(&object, order.counts, order.seed, &watch)?;
    seconds.dents = lap();
    progress.say("looking at it");
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
    progress.say("adapting the model");
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
    progress.say("measuring it");
    let mesh = object.denter.source().stood_up();
    let measured = measure(stored, &adapted, &test, &mesh)?;
    let bytes = std::fs::read(&order.scan)
        .with_context(|| format!("cannot read {}", order.scan.display()))?;
    let from = order.scan.file_name().unwrap_or_default();
    let did = Did::Teach {
        label: order.label.clone(),
        from: from.to_string_lossy().into_owned(),
        sha256: hex_digest(&bytes),
        held_out: measured.held_out.clone(),
    };
    let changed = adapted.changed(Step::now(did, &stored.digest));
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

/// A model's new layers with what is fitted to them.
#[derive(Debug, Clone)]
pub struct Adapted {
    /// The layers.
    pub head: Head,
    /// 1/T of the probabilities.
    pub inverse_temperature: f64,
    /// Threshold of the known score.
    pub known_threshold: f64,
    /// A block for each label in order, and one of strangers.
    pub blocks: Vec<Block>,
}

impl Adapted {
    /// With the step that led to it.
    pub fn changed(self, step: Step) -> Changed {
        Changed {
            head: self.head,
            inverse_temperature: self.inverse_temperature,
            known_threshold: self.known_threshold,
            blocks: self.blocks,
            step,
        }
    }

    /// What judges answers of these layers.
    pub fn judge(&self) -> Judge<'_> {
        Judge {
            head: &self.head,
            inverse_temperature: self.inverse_temperature,
            known_threshold: self.known_threshold,
        }
    }
}

/// Fits the layers of a model to what it knows and one more class, and then temperature and threshold.
///
/// # Errors
/// The features have no strangers.
pub fn adapt(
    stored: &Stored,
    new: Block,
    settings: &FitSettings,
    go_on: impl FnMut(usize) -> bool,
) -> Result<Adapted> {
    let mut blocks = stored.kept.blocks.clone();
    let strangers = blocks.pop().filter(|block| block.label.is_none());
    let strangers = strangers.context("the features beside the model have no strangers")?;
    blocks.push(new);
    let rows: Vec<FeatureRows> = blocks.iter().map(|block| block.fit.clone()).collect();
    let head = fit(
        &stored.head.with_class(),
        &rows,
        &strangers.fit,
        settings,
        go_on,
    );
    blocks.push(strangers);
    Ok(calibrated(stored, head, blocks))
}

/// Layers with temperature and threshold as their check clouds and those of before have it.
pub fn calibrated(stored: &Stored, head: Head, blocks: Vec<Block>) -> Adapted {
    let (mut all, mut labels) = (Vec::new(), Vec::new());
    let known = blocks.iter().filter(|block| block.label.is_some());
    for (class, block) in known.enumerate() {
        let logits = logits(&head, &block.check);
        labels.extend(std::iter::repeat_n(class, logits.len()));
        all.extend(logits);
    }
    let prior = |value| Prior {
        value,
        clouds: PRIOR_CLOUDS,
    };
    let scores = all.iter().map(|logits| log_sum_exp(logits)).collect();
    Adapted {
        inverse_temperature: inverse_temperature_near(
            &all,
            &labels,
            prior(stored.inverse_temperature),
        ),
        known_threshold: threshold_near(
            scores,
            KNOWN_SHARE,
            prior(stored.metadata.known_threshold),
        ),
        head,
        blocks,
    }
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
    let before = Judge {
        head: &stored.head,
        inverse_temperature: stored.inverse_temperature,
        known_threshold: stored.metadata.known_threshold,
    };
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
