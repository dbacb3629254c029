//! What is measured on, and what is taught.

use adaptation::{Block, FeatureRows, KEPT_MAX};
use anyhow::{Context, Result};
use classifier::{Extractor, ModelMetadata};
use mesh::Mesh;
use mesh::file::{MILLIMETRE, write_ply};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use record_object::Recorded;
use sim_objects::{ObjectClass, Stranger};
use sim_scan::{ScanParameters, dented};
use std::time::Instant;
use teach::look::{Watch, features, features_of_samples, to_learn, to_measure};
use teach::object::{Counts, extents_m, load, specimens};
use teach::stored::Stored;

use crate::Arguments;
use crate::measure::Known;

/// The network's input of each cloud.
type Inputs = Vec<Vec<f32>>;

/// Clouds of what a model knows before, and of strangers.
pub struct Test {
    /// By class of the model of before.
    old: Vec<Inputs>,
    /// Of kinds that are also taught here (carton, bottle, bowl), and of others.
    strangers: [Inputs; 2],
}

/// An object to be taught.
pub struct New {
    /// What is learned from.
    pub block: Block,
    /// The network's input of each scan that is measured on.
    pub inputs: Inputs,
    /// Features of these.
    pub test: Vec<FeatureRows>,
    /// Time for its mesh, dents and views to learn from.
    pub seconds: f64,
}

impl Test {
    pub fn of(
        metadata: &ModelMetadata,
        specimens: usize,
        seed: u64,
        watch: &Watch,
    ) -> Result<Self> {
        let mut random = Pcg64Mcg::seed_from_u64(seed ^ 0x5eed);
        let mut old = Vec::new();
        for label in &metadata.labels {
            let class: ObjectClass = label.parse()?;
            let seeds: Vec<u64> = (0..specimens).map(|_| random.random()).collect();
            let parameters = ScanParameters::default();
            let mesh = |seed: &u64| dented(class, &parameters, &mut Pcg64Mcg::seed_from_u64(*seed));
            let meshes: Vec<_> = seeds.par_iter().map(mesh).collect();
            let meshes: Vec<Mesh> = meshes.into_iter().collect::<Result<_, _>>()?;
            old.push(to_measure(&meshes, metadata, random.random(), watch)?);
        }
        let alike = [Stranger::Carton, Stranger::Bottle, Stranger::Bowl];
        let all = Stranger::ALL.into_iter();
        let (alike, unlike): (Vec<Stranger>, Vec<Stranger>) =
            all.partition(|stranger| alike.contains(stranger));
        let many = |strangers: Vec<Stranger>, nothing: Option<Mesh>, seed| {
            let meshes = strangers.into_iter().map(|stranger| stranger.mesh());
            let meshes = meshes.chain(nothing);
            let meshes = meshes.flat_map(|mesh| std::iter::repeat_n(mesh, specimens));
            to_measure(&meshes.collect::<Vec<_>>(), metadata, seed, watch)
        };
        let strangers = [
            many(alike, None, random.random())?,
            many(unlike, Some(Mesh::default()), random.random())?,
        ];
        Ok(Self { old, strangers })
    }

    /// As a network sees them.
    pub fn features(&self, extractor: &mut Extractor, width: usize) -> Result<Known> {
        let mut of = |inputs: &Inputs| features_of_samples(inputs, extractor, width);
        let [alike, unlike] = &self.strangers;
        Ok(Known {
            old: self.old.iter().map(&mut of).collect::<Result<_>>()?,
            strangers: [of(alike)?, of(unlike)?],
        })
    }
}

impl New {
    pub fn of(
        name: &'static str,
        mesh: &Mesh,
        stored: &Stored,
        counts: Counts,
        arguments: &Arguments,
        watch: &Watch,
    ) -> Result<Self> {
        let start = Instant::now();
        let folder = tempfile::tempdir()?;
        let file = folder.path().join(format!("{name}.ply"));
        write_ply(&file, mesh)?;
        let object = load(name, &file, MILLIMETRE).with_context(|| name)?;
        let mut made = specimens(&object, counts, arguments.seed, watch)?;
        if arguments.recorded {
            let recorded = one_grasp(&object.denter.source().stood_up(), arguments.seed)?;
            eprintln!(
                "{name}: {}; {:?} of {:?} m",
                recorded.unseen(),
                extents_m(&recorded.mesh),
                extents_m(object.denter.source())
            );
            write_ply(&file, &recorded.mesh)?;
            let object = load(name, &file, MILLIMETRE).with_context(|| name)?;
            let seen = specimens(&object, counts, arguments.seed, watch)?;
            (made.fit, made.check) = (seen.fit, seen.check);
        }
        let (metadata, width) = (&stored.metadata, stored.kept.width);
        let seeds =
            [11, 12, 13].map(|part: u64| arguments.seed.wrapping_mul(100).wrapping_add(part));
        let fit = to_learn(&made.fit, metadata, seeds[0], watch)?;
        let check = to_learn(&made.check, metadata, seeds[1], watch)?;
        let mut extractor = stored.extractor()?;
        let block = Block {
            label: Some(name.to_owned()),
            fit: features(&fit, &mut extractor, width)?.thinned(KEPT_MAX[0]),
            check: features(&check, &mut extractor, width)?.thinned(KEPT_MAX[1]),
        };
        let seconds = start.elapsed().as_secs_f64();
        // Each dent of the test may be looked at more than once.
        let all = made.test.clone();
        made.test = all.into_iter().cycle().take(arguments.specimens).collect();
        let inputs = to_measure(&made.test, metadata, seeds[2], watch)?;
        Ok(Self {
            block,
            test: features_of_samples(&inputs, &mut extractor, width)?,
            inputs,
            seconds,
        })
    }
}

/// What the robot would record of an object in one grasp, in views from all sides by a camera whose mount is known.
fn one_grasp(object: &Mesh, seed: u64) -> Result<Recorded> {
    let parameters = ScanParameters {
        view_count: 13,
        view_step_rad: 0.5,
        ..ScanParameters::nominal()
    };
    let views = sim_scan::scan(object, &parameters, seed)?;
    let whole = views.iter().max_by_key(|view| view.view_count);
    let points = &whole.context("no view shows it")?.points;
    Recorded::of_one_grasp(points)
}
