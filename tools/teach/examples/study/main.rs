//! How well models are taught: adds objects that are in no list, one after the other, by several methods, and measures each
//! model on the same new dents and views.
//!
//! `cargo run --release -p teach --example study [--objects 12] [--specimens 100] [--seed 1] [--plot taught.png]`; with
//! `--trained NAME=ONNX` beside it a model that `train` made of the eight and some of the same objects, whose scans
//! `--save-objects FOLDER` writes.

mod measure;
mod methods;
mod plot;
mod seen;
mod shapes;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adaptation::Head;
use anyhow::{Context, Result, ensure};
use clap::Parser;
use classifier::{KnownBy, shipped_model};
use mesh::file::write_ply;
use teach::history::{Did, HeldOut, Step};
use teach::judge::{Judge, held_out};
use teach::look::Watch;
use teach::object::Counts;
use teach::stored::{Stored, Unprepared};

use measure::Row;
use methods::Method;
use seen::{New, Test};

#[derive(Debug, Parser)]
struct Arguments {
    /// The model that is taught [default: the shipped one]
    #[arg(long)]
    model: Option<PathBuf>,
    /// Objects that are taught, at most 12
    #[arg(long, default_value_t = 12)]
    objects: usize,
    /// Specimens of each known object, of each taught one and of each stranger to measure on
    #[arg(long, default_value_t = 100)]
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
    /// Train on a simulated recording of one grasp, in which the hand hides part of the object, instead of on the complete mesh; the
    /// evaluation always uses the complete mesh
    #[arg(long)]
    recorded: bool,
    /// Only the shipped method
    #[arg(long)]
    shipped_only: bool,
    /// A model that knows the eight and some of the objects, to compare with; may be given several times
    #[arg(long, value_name = "NAME=ONNX", value_parser = named)]
    trained: Vec<(String, PathBuf)>,
    /// Draw accuracy, time and size of the shipped method by number of taught objects
    #[arg(long, value_name = "PNG")]
    plot: Option<PathBuf>,
    /// Write the objects' scans into this folder, and do nothing else
    #[arg(long, value_name = "FOLDER")]
    save_objects: Option<PathBuf>,
}

fn named(text: &str) -> Result<(String, PathBuf), String> {
    let (name, file) = text.split_once('=').ok_or("NAME=ONNX is needed")?;
    Ok((name.to_owned(), file.into()))
}

impl Arguments {
    fn counts(&self) -> Counts {
        Counts {
            grasps: self.grasps,
            scans: self.scans,
        }
    }
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(folder) = &arguments.save_objects {
        std::fs::create_dir_all(folder)?;
        for (name, mesh) in shapes::all().iter().take(arguments.objects) {
            write_ply(folder.join(format!("{name}.ply")), mesh)?;
        }
        return Ok(());
    }
    let model = match &arguments.model {
        Some(model) => model.clone(),
        None => shipped_model()?,
    };
    let stored = Stored::open(&model)?;
    let stop = AtomicBool::new(false);
    let watch = Watch {
        finished: &|| {},
        stop: &stop,
    };
    let test = Test::of(
        &stored.metadata,
        arguments.specimens,
        arguments.seed,
        &watch,
    )?;
    let mut new = Vec::new();
    for (name, mesh) in shapes::all().into_iter().take(arguments.objects) {
        let object = New::of(name, &mesh, &stored, arguments.counts(), &arguments, &watch)?;
        eprintln!(
            "{name}: {} clouds after {:.1} s",
            object.block.fit.len(),
            object.seconds
        );
        new.push(object);
    }
    let rows = rows(&arguments, &stored, &test, &new)?;
    if let Some(file) = &arguments.plot {
        plot::draw(file, &rows)?;
    }
    Ok(())
}

/// Measures all methods and prints a row for each number of taught objects; gives those of the shipped method.
fn rows(arguments: &Arguments, stored: &Stored, test: &Test, new: &[New]) -> Result<Vec<Row>> {
    let mut extractor = stored.extractor()?;
    let known = test.features(&mut extractor, stored.kept.width)?;
    println!("{}", Row::HEADING);
    let mut shipped = vec![known.row(&stored.judge(), &[])];
    shipped[0].model_bytes = std::fs::metadata(&stored.path)?.len() as usize;
    println!("{}", shipped[0].text("before"));
    let folder = tempfile::tempdir()?;
    for (name, method) in methods::all(arguments.shipped_only) {
        let is_shipped = matches!(&method, Method::Fit(fit) if *fit == Default::default());
        let mut state = stored.clone();
        let mut seconds: f64 = 0.0;
        for (index, object) in new.iter().enumerate() {
            let start = Instant::now();
            let adapted = method.adapted(&state, object.block.clone())?;
            seconds = seconds.max(start.elapsed().as_secs_f64());
            let taught = &new[..=index];
            let is_shown = [1, 5, 12].contains(&taught.len()) || taught.len() == new.len();
            if is_shipped || is_shown {
                let mut row = known.row(&method.judge(&adapted), &tests(taught));
                row.seconds = [object.seconds, start.elapsed().as_secs_f64()];
                let changed = adapted
                    .clone()
                    .changed(Vec::new(), step_of(object, &state.digest));
                let out = folder.path().join(format!("{index}.onnx"));
                row.model_bytes = state.write(&changed, &out, Vec::new())?.model;
                if is_shown {
                    println!("{}", row.text(name));
                }
                if is_shipped {
                    shipped.push(row);
                }
                if taught.len() == new.len() {
                    eprintln!(
                        "{name}: {}",
                        by_object(&method.judge(&adapted), stored, new)
                    );
                }
            }
            state = methods::after(state, adapted);
            // It stands in the file.
            state.history.push(step_of(object, &stored.digest));
        }
        eprintln!("{name}: at most {seconds:.1} s to adapt");
    }
    for (name, file) in &arguments.trained {
        println!("{}", trained(file, stored, test, new)?.text(name));
    }
    Ok(shipped)
}

/// How often each taught object is named rightly.
fn by_object(judge: &Judge, stored: &Stored, new: &[New]) -> String {
    let first = stored.head.classes();
    let words = new.iter().enumerate().map(|(index, object)| {
        let answers: Vec<_> = object.test.iter().map(|cloud| judge.judge(cloud)).collect();
        let right = held_out(&answers, first + index).right;
        let name = object.block.label.as_deref().unwrap_or_default();
        format!("{name} {:.0} %", 100.0 * right)
    });
    words.collect::<Vec<_>>().join(", ")
}

fn tests(taught: &[New]) -> Vec<&[adaptation::FeatureRows]> {
    taught.iter().map(|new| new.test.as_slice()).collect()
}

fn step_of(object: &New, parent: &str) -> Step {
    let did = Did::Teach {
        label: object.block.label.clone().unwrap_or_default(),
        from: "scan.ply".to_owned(),
        sha256: parent.to_owned(),
        held_out: HeldOut {
            scans: object.test.len(),
            right: 1.0,
            known_and_right: 1.0,
        },
    };
    Step::now(did, parent)
}

/// A model that was trained with the first objects, on the same clouds.
fn trained(file: &std::path::Path, stored: &Stored, test: &Test, new: &[New]) -> Result<Row> {
    let model = Unprepared::open(file)?;
    let mut extractor = model.extractor()?;
    let width = model.head.features();
    let names: Vec<&str> = new
        .iter()
        .filter_map(|new| new.block.label.as_deref())
        .collect();
    let labels = &model.metadata.labels;
    let taught: Vec<&New> = new
        .iter()
        .filter(|new| {
            labels
                .iter()
                .any(|label| Some(label) == new.block.label.as_ref())
        })
        .collect();
    let order = stored.metadata.labels.iter().map(String::as_str);
    let order: Option<Vec<usize>> = order
        .chain(names.into_iter().take(taught.len()))
        .map(|name| labels.iter().position(|label| label == name))
        .collect();
    let order = order
        .filter(|order| order.len() == labels.len())
        .with_context(|| format!("{} knows {}", file.display(), labels.join(", ")))?;
    ensure!(
        model.metadata.known_by == KnownBy::Network
            && model.metadata.point_count == stored.metadata.point_count
            && model.metadata.centring == stored.metadata.centring,
        "{} sees clouds in another way",
        file.display()
    );
    let head = Head {
        hidden: model.head.hidden.clone(),
        last: model.head.last.with_order(&order),
    };
    let judge = Judge {
        head: &head,
        inverse_temperature: model.inverse_temperature()?,
        familiar: None,
        known_threshold: model.metadata.known_threshold,
    };
    let tests: Result<Vec<_>> = taught
        .iter()
        .map(|new| teach::look::features_of_samples(&new.inputs, &mut extractor, width))
        .collect();
    let tests = tests?;
    let tests: Vec<_> = tests.iter().map(Vec::as_slice).collect();
    let mut row = test.features(&mut extractor, width)?.row(&judge, &tests);
    row.model_bytes = std::fs::metadata(file)?.len() as usize;
    Ok(row)
}
