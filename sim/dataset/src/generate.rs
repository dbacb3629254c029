//! Makes a dataset, or its missing meshes.

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use rayon::ThreadPool;
use rayon::prelude::*;

use crate::error::DatasetError;
use crate::folder::Folder;
use crate::manifest::Row;
use crate::object::{Object, Source};
use crate::order::{Event, Order};
use crate::plan::ObjectPlan;
use crate::record::Record;
use crate::run::Run;
use crate::summary::Summary;

/// Makes the meshes that are missing in the folder. Ends early, between two units, once `stop` is true.
///
/// # Errors
/// - A source, a setting or the folder cannot be used: nothing has been changed.
/// - The work fails or is stopped: finished meshes stay, and the same order resumes from there.
/// - Not a single mesh could be made.
pub fn generate(
    order: &Order,
    stop: &AtomicBool,
    show: &(dyn Fn(Event) + Sync),
) -> Result<Summary, DatasetError> {
    let start = Instant::now();
    let pool = threads(order.jobs)?;
    let objects = pool.install(|| prepare(order, show))?;
    let plans = plan(order, &objects)?;
    let folder = Folder::at(&order.out);
    let record = Record::new(&objects, &plans, order.seed, &order.settings)
        .to_yaml()
        .map_err(|error| DatasetError::damaged(&folder.record(), &error))?;

    let mut journal = folder.open(&record, order.shard)?;
    let run = Run::new(order, &objects, &plans, folder);
    let mut rows = run.finished(&pool, &mut journal)?;
    let (kept, total) = (rows.len(), run.mesh_count());
    show(Event::Making {
        meshes: total,
        kept,
    });
    let made = run
        .make(&pool, journal, &mut rows, stop, show)
        .and_then(|journal| run.finish(&rows, journal));
    let plots = made.map_err(|cause| DatasetError::Halted {
        done: rows.len(),
        total,
        cause: Box::new(cause),
    })?;
    let (rows, folder) = (run.in_order(&rows), run.folder());
    refuse_nothing(&rows, folder)?;
    let doubts = objects.iter().filter_map(Object::doubt).collect();
    let time = start.elapsed();
    Ok(Summary::new(folder, &rows, doubts, plots, kept, time))
}

/// An error if no mesh could be made.
fn refuse_nothing(rows: &[Row], folder: &Folder) -> Result<(), DatasetError> {
    match rows.first() {
        Some(first) if !rows.iter().any(Row::has_mesh) => Err(DatasetError::Nothing {
            asked: rows.len(),
            reason: first.note.clone(),
            manifest: folder.manifest(),
        }),
        _ => Ok(()),
    }
}

/// A pool of `jobs` threads.
fn threads(jobs: NonZeroUsize) -> Result<ThreadPool, DatasetError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs.get());
    pool.build().map_err(|error| {
        let error = std::io::Error::other(error);
        DatasetError::io("start", Path::new("threads"))(error)
    })
}

/// Loads all objects in parallel, after a check that their names differ.
fn prepare(order: &Order, show: &(dyn Fn(Event) + Sync)) -> Result<Vec<Object>, DatasetError> {
    let names = order.sources.iter().map(Source::name);
    let mut names: Vec<String> = names.collect::<Result<_, _>>()?;
    names.sort();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        let name = pair[0].clone();
        return Err(DatasetError::SameName { name });
    }
    let objects = order.sources.len();
    show(Event::Preparing { objects });
    let load = |source: &Source| {
        let object = source.load(&order.settings)?;
        show(Event::Prepared);
        Ok(object)
    };
    order.sources.par_iter().map(load).collect()
}

fn plan(order: &Order, objects: &[Object]) -> Result<Vec<ObjectPlan>, DatasetError> {
    let intensities = order.settings.intensities_m.len();
    let plan =
        |(index, object)| ObjectPlan::new(index, object, intensities, order.count, order.seed);
    objects.iter().enumerate().map(plan).collect()
}
