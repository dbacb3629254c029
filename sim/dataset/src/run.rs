//! A run on one folder: finds the finished units, makes the others, completes the dataset.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::ThreadPool;
use rayon::prelude::*;
use sim_deform::Dent;

use crate::error::DatasetError;
use crate::folder::{Folder, Rows, keyed};
use crate::journal::Journal;
use crate::manifest::Row;
use crate::mesh_file;
use crate::object::Object;
use crate::order::{Event, Order};
use crate::plan::{ObjectPlan, Unit, file_name};
use crate::plot;

/// A run that makes a dataset.
pub struct Run<'a> {
    order: &'a Order,
    objects: &'a [Object],
    plans: &'a [ObjectPlan],
    folder: Folder,
}

impl<'a> Run<'a> {
    /// A run for these objects and their plans.
    pub fn new(
        order: &'a Order,
        objects: &'a [Object],
        plans: &'a [ObjectPlan],
        folder: Folder,
    ) -> Self {
        Self {
            order,
            objects,
            plans,
            folder,
        }
    }

    /// The dataset's folder.
    pub fn folder(&self) -> &Folder {
        &self.folder
    }

    /// Number of meshes of all units of this shard.
    pub fn mesh_count(&self) -> usize {
        self.units().map(|unit| unit.meshes.len()).sum()
    }

    fn units(&self) -> impl Iterator<Item = &Unit> {
        let plans = self.plans.iter();
        plans.flat_map(|plan| plan.units(self.order.shard))
    }

    fn mesh_path(&self, unit: &Unit, n: usize) -> PathBuf {
        let folder = self.folder.object(&self.objects[unit.object].name);
        folder.join(file_name(n, self.plans[unit.object].meshes))
    }

    fn key(&self, unit: &Unit, n: usize) -> (String, usize) {
        (self.objects[unit.object].name.clone(), n)
    }

    /// Rows of the units that earlier runs have finished and whose mesh files are unchanged. They stay in the journal, or
    /// in the manifest if nothing is missing.
    ///
    /// # Errors
    /// The journal or the manifest cannot be read.
    pub fn finished(&self, pool: &ThreadPool, journal: &mut Journal) -> Result<Rows, DatasetError> {
        let manifest = self.folder.rows()?;
        let known = match &manifest {
            Some(rows) => keyed(rows.clone()),
            None => keyed(journal.rows()?),
        };
        let units: Vec<&Unit> = self.units().collect();
        let of_unit = |unit: &&Unit| -> Option<Vec<Row>> {
            let row = |n| known.get(&self.key(unit, n)).cloned();
            let rows: Vec<Row> = unit.meshes.clone().map(row).collect::<Option<_>>()?;
            let is_whole = |row: &Row| mesh_file::belongs(&self.mesh_path(unit, row.n), row);
            rows.iter().all(is_whole).then_some(rows)
        };
        let rows: Vec<Row> =
            pool.install(|| units.par_iter().filter_map(of_unit).flatten().collect());
        let rows = keyed(rows);
        // Meshes of a finished dataset were removed or changed: it becomes an unfinished one.
        if manifest.is_some() && rows.len() < self.mesh_count() {
            journal.clear()?;
            journal.append(&self.in_order(&rows))?;
            self.folder.remove_rows()?;
        }
        Ok(rows)
    }

    /// Makes the units that have no rows yet, and adds their rows.
    ///
    /// # Errors
    /// A mesh cannot be made or written, or `stop` became true.
    pub fn make(
        &self,
        pool: &ThreadPool,
        journal: Journal,
        rows: &mut Rows,
        stop: &AtomicBool,
        show: &(dyn Fn(Event) + Sync),
    ) -> Result<Journal, DatasetError> {
        let is_left = |unit: &&Unit| !rows.contains_key(&self.key(unit, unit.meshes.start));
        let left: Vec<&Unit> = self.units().filter(is_left).collect();
        self.make_folders()?;
        let next = AtomicUsize::new(0);
        let failure = Mutex::new(None);
        let written = Mutex::new((journal, rows));
        let work = || {
            while lock(&failure).is_none() {
                let Some(unit) = left.get(next.fetch_add(1, Ordering::Relaxed)) else {
                    break;
                };
                let made = match stop.load(Ordering::Relaxed) {
                    true => Err(DatasetError::Stopped),
                    false => self.make_unit(unit),
                };
                let kept = made.and_then(|made| {
                    let (journal, rows) = &mut *lock(&written);
                    journal.append(&made)?;
                    rows.extend(keyed(made));
                    Ok(unit.meshes.len())
                });
                match kept {
                    Ok(meshes) => show(Event::Made { meshes }),
                    Err(error) => {
                        lock(&failure).get_or_insert(error);
                    }
                }
            }
        };
        // Each thread takes units in turn; threads without one then help with the parallel sums of the last ones.
        pool.broadcast(|_| work());
        match unlocked(failure) {
            Some(error) => Err(error),
            None => Ok(unlocked(written).0),
        }
    }

    /// Folders, and the undented objects: what deformations are measured from.
    fn make_folders(&self) -> Result<(), DatasetError> {
        self.folder.make_references()?;
        for object in self.objects {
            let reference = self.folder.reference(&object.name);
            mesh_file::place(&reference, object.denter.source())?;
            self.folder.make_object(&object.name)?;
        }
        Ok(())
    }

    /// Makes the meshes of one grasp. If it cannot be dented, its meshes keep their numbers and their rows say why they are
    /// missing, so that the numbers of other meshes do not depend on it.
    fn make_unit(&self, unit: &Unit) -> Result<Vec<Row>, DatasetError> {
        let (object, seed) = (&self.objects[unit.object], self.order.seed);
        let asked_m = &self.order.settings.intensities_m[..unit.meshes.len()];
        let dents = match object.denter.dent(&unit.grasp, asked_m) {
            Ok(dents) => dents,
            Err(error) => {
                let row = |(n, &asked_m)| {
                    Row::refused(object, unit, n, asked_m, format!("refused: {error}"), seed)
                };
                return Ok(unit.meshes.clone().zip(asked_m).map(row).collect());
            }
        };
        let place = |(n, dent): (usize, &Dent)| {
            let sha256 = mesh_file::place(&self.mesh_path(unit, n), &dent.mesh)?;
            Ok(Row::dented(object, unit, n, dent, sha256, seed))
        };
        unit.meshes.clone().zip(&dents).map(place).collect()
    }

    /// Draws the plots and writes the manifest last, so that its existence means that the dataset is complete. Returns the
    /// paths of the plots.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(&self, rows: &Rows, journal: Journal) -> Result<Vec<PathBuf>, DatasetError> {
        let names = self.objects.iter().map(|object| object.name.as_str());
        let plots = match self.order.shard {
            None => plot::paths(&self.folder, names),
            Some(_) => Vec::new(),
        };
        let is_whole = self.folder.manifest().exists() && plots.iter().all(|plot| plot.exists());
        if !is_whole {
            let rows = self.in_order(rows);
            if !plots.is_empty() {
                plot::draw_all(&self.folder, &rows)?;
            }
            self.folder.write_rows(&rows)?;
        }
        journal.remove()?;
        Ok(plots)
    }

    /// The rows sorted by object, in the order of the sources, then by number.
    pub fn in_order(&self, rows: &Rows) -> Vec<Row> {
        let of = |object: &Object| {
            let name = object.name.clone();
            let range = (name.clone(), 0)..=(name, usize::MAX);
            rows.range(range).map(|(_, row)| row.clone())
        };
        self.objects.iter().flat_map(of).collect()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unlocked<T>(mutex: Mutex<T>) -> T {
    mutex.into_inner().unwrap_or_else(PoisonError::into_inner)
}
