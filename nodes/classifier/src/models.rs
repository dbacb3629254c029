//! The model in force, and that of the scan under way.

use classifier::{LoadError, Model, Parameters, SelfTest, self_test_path};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A model that one request uses at a time.
pub type SharedModel = Arc<Mutex<Model>>;

/// Which model answers. It may be exchanged at any time; each scan keeps the one that it began with.
pub struct Models {
    state: Mutex<State>,
}

struct State {
    in_force: SharedModel,
    /// The latest scan, and the model that answers it.
    scan: Option<(String, SharedModel)>,
}

impl Models {
    /// Loads the first model.
    ///
    /// # Errors
    /// Names the file and what is wrong with it.
    pub fn load(parameters: &Parameters) -> Result<Self, LoadError> {
        let in_force = load(parameters)?;
        let state = Mutex::new(State {
            in_force,
            scan: None,
        });
        Ok(Self { state })
    }

    /// Loads another model, which answers from the next scan on. It has named the clouds of its self-test rightly then.
    ///
    /// # Errors
    /// Names the file and what is wrong with it, or the cloud that it does not name rightly; the model of before stays in
    /// force.
    pub fn exchange(&self, parameters: &Parameters) -> Result<(), LoadError> {
        let new = load(parameters)?;
        self.state().in_force = new;
        Ok(())
    }

    /// The model in force.
    pub fn in_force(&self) -> SharedModel {
        Arc::clone(&self.state().in_force)
    }

    /// The model that answers the scan of this name.
    pub fn of_scan(&self, scan_id: &str) -> SharedModel {
        let mut state = self.state();
        match &state.scan {
            Some((id, model)) if id == scan_id => Arc::clone(model),
            _ => {
                let model = Arc::clone(&state.in_force);
                state.scan = Some((scan_id.to_owned(), Arc::clone(&model)));
                model
            }
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn load(parameters: &Parameters) -> Result<SharedModel, LoadError> {
    let path = Path::new(&parameters.model);
    let mut model = Model::load(path, parameters.provider, &parameters.device)?;
    match SelfTest::beside(path, &model.metadata().run_id)? {
        Some(test) => {
            test.try_on(&mut model)
                .map_err(|source| LoadError::SelfTest {
                    path: self_test_path(path),
                    source,
                })?;
            log::info!(
                "{} names the {} clouds of its self-test rightly",
                path.display(),
                test.clouds.len()
            );
        }
        None => log::info!("{} has no self-test beside it", path.display()),
    }
    Ok(Arc::new(Mutex::new(model)))
}
