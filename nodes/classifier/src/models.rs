//! The model in force, and that of the scan under way.

use classifier::{LoadError, Model, Parameters};
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

    /// Loads another model, which answers from the next scan on. It has run on blank clouds then.
    ///
    /// # Errors
    /// Names the file and what is wrong with it; the model of before stays in force.
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
    let model = Model::load(path, parameters.provider, &parameters.device)?;
    Ok(Arc::new(Mutex::new(model)))
}
