//! Makes a dataset, or what is missing in it.

use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;

use crate::error::DatasetError;
use crate::folder::{Folder, Rows};
use crate::journal::Journal;
use crate::manifest::Row;
use crate::object::{Object, Source};
use crate::plan::{ObjectPlan, Unit, file_name};
use crate::plot;
use crate::record::Record;
use crate::settings::Settings;
use crate::shard::Shard;
use crate::summary::Summary;

/// What to make, and how.
#[derive(Debug, Clone)]
pub struct Order {
    /// What is dented; the names differ.
    pub sources: Vec<Source>,
    /// The dataset's folder.
    pub out: PathBuf,
    /// Meshes of each object; by the paper's sampling ratio when `None`.
    pub count: Option<NonZeroUsize>,
    /// Everything random comes from this.
    pub seed: u64,
    /// Threads.
    pub jobs: NonZeroUsize,
    /// The part to make; all when `None`.
    pub shard: Option<Shard>,
    /// How meshes are made.
    pub settings: Settings,
}

/// What a run is at, for a progress display.
#[derive(Debug, Clone, Copy)]
pub enum Progress {
    /// Objects are being prepared.
    Preparing {
        /// How many.
        objects: usize,
    },
    /// One object is prepared.
    Prepared,
    /// Meshes are being made.
    Making {
        /// How many are wanted.
        meshes: usize,
        /// How many of these earlier runs have finished.
        kept: usize,
    },
    /// Some meshes are finished.
    Made {
        /// How many.
        meshes: usize,
    },
}

/// A dataset in the making.
struct Run<'a> {
    order: &'a Order,
    objects: Vec<Object>,
    plans: Vec<ObjectPlan>,
    folder: Folder,
    show: &'a (dyn Fn(Progress) + Sync),
}

/// Makes what is missing in the folder. Ends early, between two units, once `stop` is true.
///
/// # Errors
/// A source, a setting or the folder cannot be used; nothing is changed then. Or the work fails or is stopped; then all
/// that is finished stays, and the same order goes on from there.
pub fn generate(
    order: &Order,
    stop: &AtomicBool,
    show: &(dyn Fn(Progress) + Sync),
) -> Result<Summary, DatasetError> {
    let start = Instant::now();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(order.jobs.get())
        .build()
        .map_err(|error| {
            DatasetError::io("start", Path::new("threads"))(std::io::Error::other(error))
        })?;
    let objects = pool.install(|| prepare(order, show))?;
    let plans = plan(order, &objects)?;
    let record = Record::new(&objects, &plans, order.seed, &order.settings);
    let run = Run {
        order,
        objects,
        plans,
        folder: Folder::at(&order.out),
        show,
    };
    let record = record
        .to_yaml()
        .map_err(|error| DatasetError::damaged(&run.folder.record(), &error))?;
    let mut journal = run.folder.open(&record, order.shard)?;
    let mut rows = run.finished(&mut journal)?;
    let kept = rows.len();
    let total = run.units().map(|unit| unit.meshes.len()).sum();
    let mut plots = run.plots();
    if kept < total || run.folder.rows()?.is_none() {
        let made = run.make(&pool, journal, &mut rows, stop);
        let made = made.and_then(|journal| run.finish(&rows, journal));
        plots = made.map_err(|cause| DatasetError::Halted {
            done: rows.len(),
            total,
            cause: Box::new(cause),
        })?;
    } else {
        journal.remove()?;
    }
    let rows: Vec<Row> = run.in_order(&rows);
    Ok(Summary::new(
        &run.folder,
        &rows,
        plots,
        kept,
        start.elapsed(),
    ))
}

fn prepare(order: &Order, show: &(dyn Fn(Progress) + Sync)) -> Result<Vec<Object>, DatasetError> {
    let mut names: Vec<String> = order
        .sources
        .iter()
        .map(Source::name)
        .collect::<Result<_, _>>()?;
    names.sort();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(DatasetError::SameName {
            name: pair[0].clone(),
        });
    }
    show(Progress::Preparing {
        objects: order.sources.len(),
    });
    let load = |source: &Source| {
        let object = source.load(&order.settings)?;
        show(Progress::Prepared);
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

impl Run<'_> {
    /// All units of this shard.
    fn units(&self) -> impl Iterator<Item = &Unit> {
        self.plans
            .iter()
            .flat_map(|plan| plan.units(self.order.shard))
    }

    fn mesh_path(&self, unit: &Unit, n: usize) -> PathBuf {
        let name = file_name(n, self.plans[unit.object].meshes);
        self.folder
            .object(&self.objects[unit.object].name)
            .join(name)
    }

    fn key(&self, unit: &Unit, n: usize) -> (String, usize) {
        (self.objects[unit.object].name.clone(), n)
    }

    /// Rows of the units that earlier runs have finished, whose meshes are all there. They stay in the journal.
    fn finished(&self, journal: &mut Journal) -> Result<Rows, DatasetError> {
        let manifest = self.folder.rows()?;
        let known = match &manifest {
            Some(rows) => rows.clone(),
            None => journal.rows()?,
        };
        let known: Rows = known
            .into_iter()
            .map(|row| ((row.object.clone(), row.n), row))
            .collect();
        let mut rows = Rows::new();
        let mut lost = false;
        for unit in self.units() {
            let keys = unit.meshes.clone().map(|n| self.key(unit, n));
            let of_unit: Option<Vec<Row>> = keys.map(|key| known.get(&key).cloned()).collect();
            match of_unit {
                Some(of_unit) if self.meshes_are_there(unit) => {
                    rows.extend(
                        of_unit
                            .into_iter()
                            .map(|row| ((row.object.clone(), row.n), row)),
                    );
                }
                _ => lost = true,
            }
        }
        // Of a finished dataset, meshes were removed: it becomes an unfinished one.
        if manifest.is_some() && lost {
            journal.clear()?;
            journal.append(&self.in_order(&rows))?;
            self.folder.remove_rows()?;
        }
        Ok(rows)
    }

    fn meshes_are_there(&self, unit: &Unit) -> bool {
        // A crash of the whole machine can leave a file of its name without its bytes.
        let is_there = |n| fs::metadata(self.mesh_path(unit, n)).is_ok_and(|file| file.len() > 0);
        unit.meshes.clone().all(is_there)
    }

    /// Makes the units that have no rows yet.
    fn make(
        &self,
        pool: &rayon::ThreadPool,
        journal: Journal,
        rows: &mut Rows,
        stop: &AtomicBool,
    ) -> Result<Journal, DatasetError> {
        let left: Vec<&Unit> = self
            .units()
            .filter(|unit| !rows.contains_key(&self.key(unit, unit.meshes.start)))
            .collect();
        let left_meshes: usize = left.iter().map(|unit| unit.meshes.len()).sum();
        (self.show)(Progress::Making {
            meshes: rows.len() + left_meshes,
            kept: rows.len(),
        });
        for object in &self.objects {
            let folder = self.folder.object(&object.name);
            fs::create_dir_all(&folder).map_err(DatasetError::io("make", &folder))?;
        }
        let next = AtomicUsize::new(0);
        let failure = Mutex::new(None);
        let written = Mutex::new((journal, rows));
        // Each thread takes units in turn; at the end those without one help the others with theirs.
        pool.broadcast(|_| {
            while !stop.load(Ordering::Relaxed) && lock(&failure).is_none() {
                let Some(unit) = left.get(next.fetch_add(1, Ordering::Relaxed)) else {
                    break;
                };
                let made = self.make_unit(unit).and_then(|made| {
                    let (journal, rows) = &mut *lock(&written);
                    journal.append(&made)?;
                    rows.extend(
                        made.into_iter()
                            .map(|row| ((row.object.clone(), row.n), row)),
                    );
                    Ok(())
                });
                match made {
                    Ok(()) => (self.show)(Progress::Made {
                        meshes: unit.meshes.len(),
                    }),
                    Err(error) => {
                        lock(&failure).get_or_insert(error);
                    }
                }
            }
        });
        let (journal, rows) = written.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error);
        }
        let all = left
            .iter()
            .all(|unit| rows.contains_key(&self.key(unit, unit.meshes.start)));
        if all {
            Ok(journal)
        } else {
            Err(DatasetError::Stopped)
        }
    }

    /// Makes the meshes of one grasp; those that are there already are not written again.
    fn make_unit(&self, unit: &Unit) -> Result<Vec<Row>, DatasetError> {
        let object = &self.objects[unit.object];
        let asked_m = &self.order.settings.intensities_m[..unit.meshes.len()];
        let dents =
            object
                .denter
                .dent(&unit.grasp, asked_m)
                .map_err(|source| DatasetError::Dent {
                    object: object.name.clone(),
                    source,
                })?;
        let mut rows = Vec::with_capacity(dents.len());
        for (n, dent) in unit.meshes.clone().zip(&dents) {
            let path = self.mesh_path(unit, n);
            if !fs::metadata(&path).is_ok_and(|file| file.len() > 0) {
                sim_objects::file::write_ply(&path, &dent.mesh, 0.001)?;
            }
            rows.push(Row::new(object, unit, n, dent, self.order.seed));
        }
        Ok(rows)
    }

    /// Plots, and last the manifest: where it is, all is.
    fn finish(&self, rows: &Rows, journal: Journal) -> Result<Vec<PathBuf>, DatasetError> {
        let rows = self.in_order(rows);
        if self.order.shard.is_none() {
            plot::draw_all(&self.folder, &rows)?;
        }
        self.folder.write_rows(&rows)?;
        journal.remove()?;
        Ok(self.plots())
    }

    fn plots(&self) -> Vec<PathBuf> {
        match self.order.shard {
            Some(_) => Vec::new(),
            None => {
                let names = self.objects.iter().map(|object| object.name.as_str());
                plot::paths(&self.folder, names)
            }
        }
    }

    /// By object, in the order of the sources, then by number.
    fn in_order(&self, rows: &Rows) -> Vec<Row> {
        let of = |object: &Object| {
            let name = object.name.clone();
            rows.range((name.clone(), 0)..=(name, usize::MAX))
                .map(|(_, row)| row.clone())
        };
        self.objects.iter().flat_map(of).collect()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
