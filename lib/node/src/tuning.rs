//! Parameters that change while the node runs, by the protocol of dynamic_reconfigure.
//!
//! Its clients (dynparam, rqt_reconfigure) read `~parameter_descriptions` and `~parameter_updates`, and call
//! `~set_parameters`. A value out of its range becomes the nearest in it, as with dynamic_reconfigure's own servers.

use crate::node::Node;
use crate::publication::Latch;
use crate::publisher::Publisher;
use crate::service_server::Server;
use msg::dynamic_reconfigure::{
    Config, ConfigDescription, DoubleParameter, Group, GroupState, IntParameter, ParamDescription,
    Reconfigure, ReconfigureRes,
};
use parameter::Tunable;
use serde::Serialize;
use std::fmt::Display;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// dynamic_reconfigure sorts parameters into groups, of which there must be this one.
const GROUP: &str = "Default";

/// The parameters in force. Clones share them.
pub struct Tuned<P: 'static> {
    core: Arc<Core<P>>,
    _links: Arc<Links>,
}

struct Core<P: 'static> {
    current: Mutex<Arc<P>>,
    /// Locked during a change, which writes to the parameter server; [`Tuned::now`] does not wait for it.
    changing: Mutex<()>,
    tunables: &'static [Tunable<P>],
    updates: Publisher<Config>,
}

struct Links {
    _descriptions: Publisher<ConfigDescription>,
    _service: Server,
}

impl<P> Clone for Tuned<P> {
    fn clone(&self) -> Self {
        Self {
            core: Arc::clone(&self.core),
            _links: Arc::clone(&self._links),
        }
    }
}

impl<P> Tuned<P> {
    /// The parameters as they are now; a later change does not concern this copy.
    pub fn now(&self) -> Arc<P> {
        Arc::clone(&self.core.lock())
    }
}

impl Node {
    /// Lets `tunables` of the node's parameters be changed. A change that `validate` refuses is not made.
    ///
    /// # Errors
    /// The topics or the service of dynamic_reconfigure cannot be offered.
    pub fn tune<P, E>(
        &self,
        parameters: P,
        tunables: &'static [Tunable<P>],
        validate: impl Fn(&P) -> Result<(), E> + Send + Sync + 'static,
    ) -> anyhow::Result<Tuned<P>>
    where
        P: Serialize + Clone + Default + Send + Sync + 'static,
        E: Display,
    {
        let descriptions = self.publish("~parameter_descriptions", 1, Latch::Yes)?;
        descriptions.send(describe(tunables));
        let core = Arc::new(Core {
            updates: self.publish("~parameter_updates", 4, Latch::Yes)?,
            current: Mutex::new(Arc::new(parameters)),
            changing: Mutex::new(()),
            tunables,
        });
        core.updates
            .send(config(tunables, |tunable| (tunable.get)(&core.lock())));
        let service = self.serve::<Reconfigure>("~set_parameters", {
            let (core, node) = (Arc::clone(&core), self.clone());
            move |request, _| std::future::ready(Ok(core.change(&request.config, &validate, &node)))
        })?;
        Ok(Tuned {
            core,
            _links: Arc::new(Links {
                _descriptions: descriptions,
                _service: service,
            }),
        })
    }
}

impl<P> Core<P> {
    fn lock(&self) -> MutexGuard<'_, Arc<P>> {
        self.current.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<P: Serialize + Clone + Send + 'static> Core<P> {
    /// Changes what was asked for and is allowed; answers with what is in force.
    fn change<E: Display>(
        &self,
        asked: &Config,
        validate: &impl Fn(&P) -> Result<(), E>,
        node: &Node,
    ) -> ReconfigureRes {
        let _changing = self.changing.lock().unwrap_or_else(PoisonError::into_inner);
        let current = Arc::clone(&self.lock());
        let changed = changed(&*current, self.tunables, asked);
        match validate(&changed) {
            Ok(()) => {
                *self.lock() = Arc::new(changed.clone());
                node.change_parameters(&changed);
            }
            Err(error) => log::warn!("parameters not changed: {error}"),
        }
        let config = config(self.tunables, |tunable| (tunable.get)(&self.lock()));
        // Published during the change, so that the last message is what is in force.
        self.updates.send(config.clone());
        ReconfigureRes { config }
    }
}

fn changed<P: Clone>(current: &P, tunables: &[Tunable<P>], asked: &Config) -> P {
    let mut changed = current.clone();
    let reals = asked.doubles.iter().map(|real| (&real.name, real.value));
    let wholes = asked
        .ints
        .iter()
        .map(|whole| (&whole.name, f64::from(whole.value)));
    for (name, value) in reals.chain(wholes) {
        match tunables.iter().find(|tunable| tunable.name == name) {
            Some(tunable) => tunable.set_clamped(&mut changed, value),
            None => log::warn!("parameter {name} cannot be changed while the node runs"),
        }
    }
    changed
}

fn describe<P: Default>(tunables: &[Tunable<P>]) -> ConfigDescription {
    let parameters = tunables.iter().map(|tunable| {
        let unit = match tunable.unit {
            "" => String::new(),
            unit => format!(", {unit}"),
        };
        ParamDescription {
            name: tunable.name.into(),
            type_: if tunable.is_whole { "int" } else { "double" }.into(),
            description: format!("{}{unit}", tunable.about),
            ..Default::default()
        }
    });
    let defaults = P::default();
    ConfigDescription {
        groups: vec![Group {
            name: GROUP.into(),
            parameters: parameters.collect(),
            ..Default::default()
        }],
        max: config(tunables, |tunable| tunable.max),
        min: config(tunables, |tunable| tunable.min),
        dflt: config(tunables, |tunable| (tunable.get)(&defaults)),
    }
}

fn config<P>(tunables: &[Tunable<P>], value: impl Fn(&Tunable<P>) -> f64) -> Config {
    let (wholes, reals): (Vec<_>, Vec<_>) = tunables.iter().partition(|tunable| tunable.is_whole);
    let int = |tunable: &&Tunable<P>| IntParameter {
        name: tunable.name.into(),
        value: value(tunable) as i32,
    };
    let double = |tunable: &&Tunable<P>| DoubleParameter {
        name: tunable.name.into(),
        value: value(tunable),
    };
    Config {
        ints: wholes.iter().map(int).collect(),
        doubles: reals.iter().map(double).collect(),
        groups: vec![GroupState {
            name: GROUP.into(),
            state: true,
            ..Default::default()
        }],
        ..Default::default()
    }
}
