//! How well models are taught: adds objects that are in no list, one after the other, by several methods, and measures each
//! model on the same new dents and views.
//!
//! `cargo run --release -p teach --example study [--model ONNX] [--objects 12] [--specimens 40] [--seed 1]`

mod shapes;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adaptation::{Block, Change, FeatureRows, FitSettings, Head};
use anyhow::{Context, Result};
use clap::Parser;
use classifier::{Extractor, shipped_model};
use mesh::Mesh;
use mesh::file::{MILLIMETRE, write_ply};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use sim_objects::{ObjectClass, Stranger};
use sim_scan::{ScanParameters, dented};
use teach::adapt::{Adapted, KEPT_MAX, adapt, calibrated};
use teach::judge::{Judge, Judged};
use teach::look::{Watch, features, features_of_samples, to_learn, to_measure};
use teach::object::{Counts, load, specimens};
use teach::stored::Stored;

#[derive(Debug, Parser)]
struct Arguments {
    /// The model that is taught [default: the shipped one]
    #[arg(long)]
    model: Option<PathBuf>,
    /// Objects that are taught, at most 12
    #[arg(long, default_value_t = 12)]
    objects: usize,
    /// Specimens of each known object, of each taught one and of each stranger to measure on
    #[arg(long, default_value_t = 40)]
    specimens: usize,
    /// Places where a gripper presses each object
    #[arg(long, default_value_t = Counts::default().grasps)]
    grasps: usize,
    /// Simulated scans to learn each from
    #[arg(long, default_value_t = Counts::default().scans)]
    scans: usize,
    /// Everything random comes from this
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// An object to be taught.
struct New {
    block: Block,
    test: Vec<FeatureRows>,
    seconds: f64,
}

/// What is measured on.
struct Test {
    /// By class of the model of before.
    old: Vec<Vec<FeatureRows>>,
    /// Of kinds that are also taught here (carton, bottle, bowl), and of others.
    strangers: [Vec<FeatureRows>; 2],
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let model = match &arguments.model {
        Some(model) => model.clone(),
        None => shipped_model()?,
    };
    let stored = Stored::open(&model)?;
    let mut extractor = stored.extractor()?;
    let test = test(&arguments, &stored, &mut extractor)?;
    let mut new = Vec::new();
    for (name, mesh) in shapes::all().into_iter().take(arguments.objects) {
        new.push(learned(&arguments, &stored, &mut extractor, name, &mesh)?);
        eprintln!("{name}: {:.1} s", new.last().map_or(0.0, |new| new.seconds));
    }
    println!(
        "| method | taught | new right | old right | known and wrong | known | AUROC | with carton, bottle, bowl | s a step |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let before = Judge {
        head: &stored.head,
        inverse_temperature: stored.inverse_temperature,
        known_threshold: stored.metadata.known_threshold,
    };
    row("before", &before, &[], &test, 0.0);
    for (name, method) in methods() {
        let mut state = stored.clone();
        let mut seconds: f64 = 0.0;
        for (index, object) in new.iter().enumerate() {
            let start = Instant::now();
            let adapted = match &method {
                Method::Fit(settings) => adapt(&state, object.block.clone(), settings, |_| true)?,
                Method::Prototypes => prototypes(&state, object.block.clone()),
            };
            seconds = seconds.max(start.elapsed().as_secs_f64());
            if [1, 5, 12].contains(&(index + 1)) || index + 1 == new.len() {
                row(name, &adapted.judge(), &new[..=index], &test, seconds);
            }
            state = after(state, adapted);
        }
    }
    Ok(())
}

enum Method {
    Fit(FitSettings),
    Prototypes,
}

/// The methods that are compared.
fn methods() -> Vec<(&'static str, Method)> {
    let as_shipped = FitSettings::default();
    let fit = |prior, prior_of_new, strangers_weight, change| {
        Method::Fit(FitSettings {
            change,
            prior,
            prior_of_new,
            strangers_weight,
            ..as_shipped.clone()
        })
    };
    vec![
        ("last layer", Method::Fit(as_shipped.clone())),
        ("last layer, weak prior", fit(1e-3, 1e-3, 1.0, Change::Last)),
        ("both layers", fit(1e-1, 1e-3, 4.0, Change::Both)),
        ("prototypes", Method::Prototypes),
    ]
}

/// A mean of hidden values for each class; a cloud belongs to the nearest, by the spread within classes.
fn prototypes(stored: &Stored, new: Block) -> Adapted {
    let mut blocks = stored.kept.blocks.clone();
    let strangers = blocks.pop();
    blocks.push(new);
    let hidden = blocks
        .iter()
        .map(|block| stored.head.hidden_of(&block.fit.matrix()));
    let hidden: Vec<_> = hidden.collect();
    let means: Vec<_> = hidden.iter().map(|rows| rows.row_mean()).collect();
    let squares = hidden.iter().zip(&means).map(|(rows, mean)| {
        let squares = rows.row_iter().map(|row| (row - mean).norm_squared());
        squares.sum::<f64>() / rows.nrows() as f64
    });
    let width = stored.head.hidden.bias.len();
    let variance = squares.sum::<f64>() / (blocks.len() * width) as f64;
    let mut head: Head = stored.head.with_class();
    for (class, mean) in means.iter().enumerate() {
        head.last
            .weight
            .set_column(class, &(mean.transpose() / variance));
        head.last.bias[class] = -0.5 * mean.norm_squared() / variance;
    }
    blocks.extend(strangers);
    calibrated(stored, head, blocks)
}

/// The model with its new layers, without files.
fn after(mut stored: Stored, adapted: Adapted) -> Stored {
    stored.head = adapted.head;
    stored.inverse_temperature = adapted.inverse_temperature;
    stored.metadata.known_threshold = adapted.known_threshold;
    stored.kept.blocks = adapted.blocks;
    stored
}

fn learned(
    arguments: &Arguments,
    stored: &Stored,
    extractor: &mut Extractor,
    name: &'static str,
    mesh: &Mesh,
) -> Result<New> {
    let start = Instant::now();
    let folder = std::env::temp_dir().join(format!("study-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let file = folder.join(format!("{name}.ply"));
    write_ply(&file, mesh)?;
    let stop = AtomicBool::new(false);
    let watch = Watch {
        finished: &|| {},
        stop: &stop,
    };
    let object = load(name, &file, MILLIMETRE).with_context(|| name)?;
    std::fs::remove_dir_all(&folder)?;
    let counts = Counts {
        grasps: arguments.grasps,
        scans: arguments.scans,
    };
    let mut made = specimens(&object, counts, arguments.seed, &watch)?;
    let dents = start.elapsed().as_secs_f64();
    let (metadata, width) = (&stored.metadata, stored.kept.width);
    let fit = to_learn(&made.fit, metadata, 11, &watch)?;
    let check = to_learn(&made.check, metadata, 12, &watch)?;
    let seconds = start.elapsed().as_secs_f64();
    eprintln!("{name}: dents {dents:.1} s, {} clouds", fit.len());
    // Each dent of the test may be looked at more than once.
    let all = made.test.clone();
    made.test = all.into_iter().cycle().take(arguments.specimens).collect();
    let test = to_measure(&made.test, metadata, 13, &watch)?;
    Ok(New {
        block: Block {
            label: Some(name.to_owned()),
            fit: features(&fit, extractor, width)?.thinned(KEPT_MAX[0]),
            check: features(&check, extractor, width)?.thinned(KEPT_MAX[1]),
        },
        test: features_of_samples(&test, extractor, width)?,
        seconds,
    })
}

fn test(arguments: &Arguments, stored: &Stored, extractor: &mut Extractor) -> Result<Test> {
    let stop = AtomicBool::new(false);
    let watch = Watch {
        finished: &|| {},
        stop: &stop,
    };
    let (metadata, width) = (&stored.metadata, stored.kept.width);
    let mut random = Pcg64Mcg::seed_from_u64(arguments.seed ^ 0x5eed);
    let mut seen = |meshes: Vec<Mesh>, seed| -> Result<Vec<FeatureRows>> {
        let inputs = to_measure(&meshes, metadata, seed, &watch)?;
        features_of_samples(&inputs, extractor, width)
    };
    let mut old = Vec::new();
    for label in &metadata.labels {
        let class: ObjectClass = label.parse()?;
        let seeds: Vec<u64> = (0..arguments.specimens).map(|_| random.random()).collect();
        let parameters = ScanParameters::default();
        let mesh = |seed: &u64| dented(class, &parameters, &mut Pcg64Mcg::seed_from_u64(*seed));
        let meshes: Vec<_> = seeds.par_iter().map(mesh).collect();
        old.push(seen(
            meshes.into_iter().collect::<Result<_, _>>()?,
            random.random(),
        )?);
    }
    let alike = [Stranger::Carton, Stranger::Bottle, Stranger::Bowl];
    let all = Stranger::ALL.into_iter();
    let (alike, unlike): (Vec<Stranger>, Vec<Stranger>) =
        all.partition(|stranger| alike.contains(stranger));
    let mut many = |strangers: Vec<Stranger>, nothing: Option<Mesh>, seed| {
        let meshes = strangers.into_iter().map(|stranger| stranger.mesh());
        let meshes = meshes.chain(nothing);
        let meshes = meshes.flat_map(|mesh| std::iter::repeat_n(mesh, arguments.specimens));
        seen(meshes.collect(), seed)
    };
    let seeds = [random.random(), random.random()];
    let strangers = [
        many(alike, None, seeds[0])?,
        many(unlike, Some(Mesh::default()), seeds[1])?,
    ];
    Ok(Test { old, strangers })
}

fn row(name: &str, judge: &Judge, new: &[New], test: &Test, seconds: f64) {
    let judged =
        |clouds: &[FeatureRows]| -> Vec<Judged> { clouds.iter().map(|c| judge.judge(c)).collect() };
    let old: Vec<(usize, Vec<Judged>)> = test
        .old
        .iter()
        .map(|clouds| judged(clouds))
        .enumerate()
        .collect();
    let new: Vec<(usize, Vec<Judged>)> = new
        .iter()
        .enumerate()
        .map(|(index, new)| (old.len() + index, judged(&new.test)))
        .collect();
    let strangers = test.strangers.each_ref().map(|clouds| judged(clouds));
    let right =
        |groups: &[(usize, Vec<Judged>)]| share(groups, |class, answer| answer.best == class);
    let all: Vec<(usize, Vec<Judged>)> = old.iter().chain(&new).cloned().collect();
    let known_wrong = share(&all, |class, answer| answer.known && answer.best != class);
    let known = share(&all, |_, answer| answer.known);
    let scores: Vec<f64> = all
        .iter()
        .flat_map(|(_, answers)| answers.iter().map(|a| a.score))
        .collect();
    let [alike, unlike] =
        strangers.map(|answers| answers.iter().map(|a| a.score).collect::<Vec<_>>());
    println!(
        "| {name} | {} | {} | {} | {} | {} | {:.4} | {:.4} | {seconds:.1} |",
        new.len(),
        percent(right(&new)),
        percent(right(&old)),
        percent(known_wrong),
        percent(known),
        auroc(&scores, &unlike),
        auroc(&scores, &[alike, unlike].concat()),
    );
}

fn share(groups: &[(usize, Vec<Judged>)], is_meant: impl Fn(usize, &Judged) -> bool) -> f64 {
    let total: usize = groups.iter().map(|(_, answers)| answers.len()).sum();
    let meant = groups
        .iter()
        .flat_map(|(class, answers)| answers.iter().map(move |a| (*class, a)));
    meant
        .filter(|(class, answer)| is_meant(*class, answer))
        .count() as f64
        / total.max(1) as f64
}

/// Probability that a known object scores higher than a stranger.
fn auroc(known: &[f64], strangers: &[f64]) -> f64 {
    let wins: f64 = known
        .iter()
        .flat_map(|k| {
            strangers.iter().map(move |s| {
                if k > s {
                    1.0
                } else {
                    0.5 * f64::from(u8::from(k == s))
                }
            })
        })
        .sum();
    wins / (known.len() * strangers.len()).max(1) as f64
}

fn percent(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
}
