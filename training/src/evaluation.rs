//! How good a model file is on simulated scans that it was not trained on.

use std::collections::BTreeMap;

use anyhow::{Result, ensure};
use classifier::Model;
use serde::Serialize;
use sim_objects::ObjectClass;

use crate::dataset::simulate;
use crate::metrics::Confusion;
use crate::samples::Samples;
use crate::scan_parameters::ScanParameters;
use crate::trainer::most_probable;

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Evaluation {
    /// What the figures were measured on.
    pub data: String,
    /// The training run that made the model.
    pub model_id: String,
    /// What ran the network.
    pub provider: String,
    /// Clouds that were named.
    pub clouds: usize,
    /// Share named rightly.
    pub accuracy: f64,
    /// The same by number of views, of held objects only.
    pub accuracy_by_views: BTreeMap<u32, f64>,
    /// The same, of objects that stood on a box, without kinematics.
    pub accuracy_on_table: f64,
    /// Share called known.
    pub known_share: f64,
    /// Right answers by class, in the order of `confusion.labels`.
    pub class_accuracies: Vec<f64>,
    /// All answers.
    pub confusion: Confusion,
}

/// Scans `specimens_per_class` new specimens of each class and has the model name them.
///
/// # Errors
/// The model has other labels, or a scan or the network fails.
pub fn evaluate(
    model: &mut Model,
    specimens_per_class: usize,
    parameters: &ScanParameters,
    seed: u64,
    finished: impl Fn() + Sync,
) -> Result<Evaluation> {
    let metadata = model.metadata().clone();
    let names = ObjectClass::ALL.map(ObjectClass::name);
    ensure!(
        metadata.labels == names,
        "the model names {}, but the simulated objects are {}",
        metadata.labels.join(", "),
        names.join(", ")
    );
    let samples = simulate(specimens_per_class, parameters, &metadata, seed, finished)?;
    let mut counts = Counts::new(&metadata.labels);
    for index in 0..samples.len() {
        let answer = model.infer(&samples.input(index, metadata.metres_per_unit))?;
        counts.add(&samples, index, &answer, metadata.known_threshold);
    }
    let data = format!("{specimens_per_class} simulated specimens a class, seed {seed}");
    Ok(Evaluation {
        data,
        model_id: metadata.run_id,
        provider: model.provider().to_owned(),
        clouds: samples.len(),
        accuracy: counts.all.accuracy(),
        accuracy_by_views: counts
            .by_views
            .iter()
            .map(|(&n, c)| (n, c.accuracy()))
            .collect(),
        accuracy_on_table: counts.on_table.accuracy(),
        known_share: counts.known as f64 / samples.len().max(1) as f64,
        class_accuracies: counts.all.class_accuracies(),
        confusion: counts.all,
    })
}

struct Counts {
    all: Confusion,
    by_views: BTreeMap<u32, Confusion>,
    on_table: Confusion,
    known: usize,
}

impl Counts {
    fn new(labels: &[String]) -> Self {
        let none = Confusion::new(labels);
        Self {
            all: none.clone(),
            by_views: BTreeMap::new(),
            on_table: none,
            known: 0,
        }
    }

    fn add(&mut self, samples: &Samples, index: usize, answer: &[f32], known_threshold: f64) {
        let (truth, prediction) = (samples.labels[index] as usize, most_probable(answer));
        self.all.add(truth, prediction);
        if samples.held[index] == 1 {
            let none = || Confusion::new(&self.all.labels);
            let views = self.by_views.entry(samples.view_counts[index]);
            views.or_insert_with(none).add(truth, prediction);
        } else {
            self.on_table.add(truth, prediction);
        }
        self.known += usize::from(f64::from(answer[prediction]).exp() >= known_threshold);
    }
}

impl Evaluation {
    /// A few lines for people.
    pub fn to_text(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let views = self.accuracy_by_views.iter();
        let views: Vec<String> = views
            .map(|(n, a)| format!("{n}: {}", percent(*a)))
            .collect();
        format!(
            "{}accuracy {} on {} clouds ({}; none trained on)\nheld, by number of views: {}\non a box: {}; called \
             known: {}\nmodel {}, {}\n",
            self.confusion.table(),
            percent(self.accuracy),
            self.clouds,
            self.data,
            views.join(", "),
            percent(self.accuracy_on_table),
            percent(self.known_share),
            self.model_id,
            self.provider
        )
    }
}
