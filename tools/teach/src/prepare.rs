//! Makes the features of what a model knows, for one that has none beside it.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use adaptation::{Block, KEPT_MAX, Kept, STRANGERS, features_path};
use anyhow::{Result, ensure};
use classifier::{Extractor, Features, Model, Provider, SelfTest, TestCloud, self_test_path};
use mesh::Mesh;
use mesh::file::MILLIMETRE;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use sim_objects::{ObjectClass, random_solid};
use sim_scan::{ScanParameters, dented};

use crate::look::{Watch, features, to_learn};
use crate::object::{Counts, load, specimens};
use crate::progress::{Part, Progress};
use crate::stored::{Unprepared, references_of};
use crate::together::unwritten;

/// What to look at.
#[derive(Debug, Clone, Copy)]
pub struct Order {
    /// Dents and scans of each object.
    pub counts: Counts,
    /// Everything random comes from this.
    pub seed: u64,
}

/// Looks at new specimens of all that a model knows, and at strangers, and writes their features and a self-test beside it: the package's own
/// objects as in training, others by dents of their references, LABEL.ply. Gives the file and its size in bytes.
///
/// # Errors
/// A label has no reference, the model is not the robot's network, or the file cannot be written.
pub fn prepare(model: &Path, order: Order, stop: &AtomicBool) -> Result<(PathBuf, usize)> {
    let unprepared = Unprepared::open(model)?;
    let each = order.counts.scans + order.counts.scans.div_ceil(2);
    let progress = Progress::new(&[Part::Known, Part::Strangers]);
    let made = blocks(&unprepared, order, stop, &progress);
    progress.clear();
    let (blocks, clouds) = made?;
    let kept = Kept {
        model: unprepared.digest.clone(),
        made: format!(
            "teach --prepare, {each} scans of each label, seed {}",
            order.seed
        ),
        width: unprepared.head.features(),
        blocks,
    };
    // Whose features are only about to be written.
    let mut network = Model::load_with(model, Features::Unused, Provider::Cpu, "CPU")?;
    let test = SelfTest::of(&mut network, &clouds)?;
    let path = features_path(model);
    let bytes = kept.encode()?;
    for (path, bytes) in [
        (self_test_path(model), test.encode()?),
        (path.clone(), bytes.clone()),
    ] {
        whole_file::write(&path, &bytes).map_err(unwritten(&path, bytes.len()))?;
    }
    Ok((path, bytes.len()))
}

fn blocks(
    unprepared: &Unprepared,
    order: Order,
    stop: &AtomicBool,
    progress: &Progress,
) -> Result<(Vec<Block>, Vec<TestCloud>)> {
    let references = references_of(&unprepared.path)?;
    let mut extractor = unprepared.extractor()?;
    let mut random = Pcg64Mcg::seed_from_u64(order.seed);
    let mut maker = Maker {
        unprepared,
        watch: Watch {
            finished: &|| progress.step(),
            stop,
        },
        extractor: &mut extractor,
        clouds: Vec::new(),
    };
    let mut blocks = Vec::new();
    let labels = &unprepared.metadata.labels;
    let each = order.counts.scans + order.counts.scans.div_ceil(2);
    progress.begin(Part::Known, labels.len() * each);
    for label in labels {
        let seed = random.random();
        let meshes = match label.parse::<ObjectClass>() {
            Ok(class) => of_class(class, order.counts.scans, seed)?,
            Err(_) => of_reference(label, &references, order.counts, seed)?,
        };
        blocks.push(maker.block(Some(label), &meshes, random.random(), 1)?);
    }
    progress.begin(Part::Strangers, STRANGERS * each);
    let meshes = strangers(STRANGERS * order.counts.scans, random.random());
    blocks.push(maker.block(None, &meshes, random.random(), STRANGERS)?);
    Ok((blocks, maker.clouds))
}

/// Specimens to fit layers with, and to check.
type Parts = [Vec<Mesh>; 2];

struct Maker<'a> {
    unprepared: &'a Unprepared,
    watch: Watch<'a>,
    extractor: &'a mut Extractor,
    /// Candidates for the self-test.
    clouds: Vec<TestCloud>,
}

impl Maker<'_> {
    fn block(
        &mut self,
        label: Option<&str>,
        parts: &Parts,
        seed: u64,
        times: usize,
    ) -> Result<Block> {
        let mut rows = |part: usize| {
            let (metadata, width) = (&self.unprepared.metadata, self.unprepared.head.features());
            let seed = seed.wrapping_add(part as u64);
            let inputs = to_learn(&parts[part], metadata, seed, &self.watch)?;
            let name = label.unwrap_or("a stranger");
            ensure!(!inputs.is_empty(), "the camera sees too little of {name}");
            if part == 1
                && let Some(label) = label
            {
                let clouds = inputs.iter().map(|input| TestCloud::of(label, input));
                self.clouds.extend(clouds);
            }
            let rows = features(&inputs, self.extractor, width)?;
            Ok(rows.thinned(times * KEPT_MAX[part]))
        };
        Ok(Block {
            fit: rows(0)?,
            check: rows(1)?,
            label: label.map(str::to_owned),
        })
    }
}

fn of_class(class: ObjectClass, count: usize, seed: u64) -> Result<Parts> {
    let parameters = ScanParameters::default();
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut some = |count: usize| -> Result<Vec<Mesh>> {
        let seeds: Vec<u64> = (0..count).map(|_| random.random()).collect();
        let one = |seed: &u64| dented(class, &parameters, &mut Pcg64Mcg::seed_from_u64(*seed));
        let meshes: Vec<_> = seeds.par_iter().map(one).collect();
        Ok(meshes.into_iter().collect::<Result<_, _>>()?)
    };
    Ok([some(count)?, some(count.div_ceil(2))?])
}

fn of_reference(label: &str, references: &Path, counts: Counts, seed: u64) -> Result<Parts> {
    let path = references.join(format!("{label}.ply"));
    ensure!(
        path.is_file(),
        "there is no mesh of {label} to look at: put {label}.ply, in millimetres and +z up, into {}",
        references.display()
    );
    let object = load(label, &path, MILLIMETRE)?;
    let quiet = Watch {
        finished: &|| {},
        stop: &AtomicBool::new(false),
    };
    let made = specimens(&object, counts, seed, &quiet)?;
    Ok([made.fit, made.check])
}

/// Solids of any form and, a sixth of them, empty hands, as in training.
fn strangers(count: usize, seed: u64) -> Parts {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut some = |count: usize| -> Vec<Mesh> {
        let mesh = |number: usize| match number % 6 {
            5 => Mesh::default(),
            _ => random_solid(&mut random),
        };
        (0..count).map(mesh).collect()
    };
    [some(count), some(count.div_ceil(2))]
}
