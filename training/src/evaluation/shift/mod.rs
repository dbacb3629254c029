//! How answers change where one thing at a time leaves the range that was trained on.

mod curves;
mod disturb;
mod rates;

use std::num::NonZeroUsize;

use anyhow::Result;
use classifier::{Model, ModelMetadata, is_known, preprocess_parts};
use mesh::Mesh;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sim_objects::{Instance, Instances, ObjectClass};
use sim_scan::{ScanParameters, Setup, after_each_view, capture, dented_instance};

pub use curves::{Curve, Step, all};
pub use disturb::Shift;
pub use rates::{Rates, interval};

use crate::evaluation::calibration::highest_probability;
use crate::evaluation::origin::{Digest, Origin};
use crate::training::tally::most_probable;

/// Views of each scan.
const VIEWS: usize = 3;

/// All curves.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Shifts {
    /// What was measured on what.
    #[serde(flatten)]
    pub origin: Origin,
    /// One for each thing that leaves its range.
    pub curves: Vec<MeasuredCurve>,
}

/// One thing that leaves its range.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MeasuredCurve {
    /// What it is.
    pub name: String,
    /// The range that was trained on.
    pub trained: String,
    /// Nearest first.
    pub steps: Vec<MeasuredStep>,
}

/// The scans of one step.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct MeasuredStep {
    /// How far it is.
    pub step: String,
    /// Whether that was trained on.
    pub is_trained: bool,
    /// Answers after the first view.
    pub one_view: Rates,
    /// Answers after three.
    pub three_views: Rates,
}

/// Measures a model on curves like those of [`all`] with held objects, as many specimens of each class. The same specimens, poses and noise are scanned in each
/// step, so that steps differ by what is shifted alone. As on the robot, a cloud that registration doubts is not known.
///
/// # Errors
/// A specimen or a scan cannot be made, or the network fails.
pub fn measure(
    model: &mut Model,
    curves: &[Curve],
    specimens: NonZeroUsize,
    seed: u64,
    finished: impl Fn() + Sync,
) -> Result<Shifts> {
    let metadata = model.metadata().clone();
    let steps: Vec<&Step> = curves.iter().flat_map(|curve| &curve.steps).collect();
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let classes = metadata.labels.iter().enumerate();
    let mut scanned: Vec<Scanned> = classes
        .filter_map(|(label, name)| Some((label, name.parse::<ObjectClass>().ok()?)))
        .flat_map(|(label, class)| (0..specimens.get()).map(move |_| (label, class)))
        .map(|(label, class)| Scanned {
            label,
            class,
            seed: random.random(),
            steps: Vec::new(),
        })
        .collect();
    let scan = |scanned: &mut Scanned| -> Result<()> {
        for step in &steps {
            scanned.steps.push(scanned.under(step.shift, &metadata)?);
        }
        finished();
        Ok(())
    };
    scanned.par_iter_mut().try_for_each(scan)?;
    let mut rates = vec![[Rates::default(); 2]; steps.len()];
    let mut digest = Digest::default();
    for Scanned { label, steps, .. } in &scanned {
        for (rates, clouds) in rates.iter_mut().zip(steps) {
            for (rates, cloud) in rates.iter_mut().zip(clouds) {
                let Some(Cloud { input, is_trusted }) = cloud else {
                    rates.add_none();
                    continue;
                };
                digest.add(input);
                let output = model.infer(input)?;
                let is_known = is_known(
                    f64::from(output.known_score),
                    metadata.known_threshold,
                    highest_probability(&output.log_probabilities),
                );
                let is_right = most_probable(&output.log_probabilities) == *label;
                rates.add(is_right, is_known && *is_trusted);
            }
        }
    }
    let origin = Origin::of(model, specimens, seed, digest);
    let mut rates = rates.into_iter();
    let measured = |step: &Step| {
        let [one_view, three_views] = rates.next().unwrap_or_default();
        MeasuredStep {
            step: step.name.clone(),
            is_trained: step.is_trained,
            one_view,
            three_views,
        }
    };
    Ok(Shifts {
        origin,
        curves: with_rates(curves, measured),
    })
}

fn with_rates(curves: &[Curve], mut of: impl FnMut(&Step) -> MeasuredStep) -> Vec<MeasuredCurve> {
    let measured = |curve: &Curve| MeasuredCurve {
        name: curve.name.to_owned(),
        trained: curve.trained.clone(),
        steps: curve.steps.iter().map(&mut of).collect(),
    };
    curves.iter().map(measured).collect()
}

/// One specimen, and its clouds in each step.
struct Scanned {
    label: usize,
    class: ObjectClass,
    seed: u64,
    steps: Vec<[Option<Cloud>; 2]>,
}

/// After one view or after all; what the network gets.
struct Cloud {
    input: Vec<f32>,
    is_trusted: bool,
}

impl Scanned {
    fn under(&self, shift: Shift, metadata: &ModelMetadata) -> Result<[Option<Cloud>; 2]> {
        let mut random = Pcg64Mcg::seed_from_u64(self.seed);
        let mut parameters = ScanParameters {
            view_count: VIEWS,
            table_share: 0.0,
            ..ScanParameters::default()
        };
        shift.range(&mut parameters);
        let object = self.object(shift, &parameters, random.random())?;
        let mut setup = Setup::random(&object, &parameters, &mut random);
        let seed = random.random();
        shift.circumstances(&mut setup, &mut Pcg64Mcg::seed_from_u64(seed));
        let mut views = capture(&setup, &mut random)?;
        shift.views(&mut views, &setup, &mut Pcg64Mcg::seed_from_u64(seed));
        let objects = after_each_view(&setup, &views, &parameters)?;
        Ok([1, VIEWS].map(|count| {
            let object = objects.iter().find(|object| object.view_count == count)?;
            let input = preprocess_parts(&object.points, &object.up, metadata).ok()?;
            let is_trusted = object.trusted;
            Some(Cloud { input, is_trusted })
        }))
    }

    fn object(&self, shift: Shift, parameters: &ScanParameters, seed: u64) -> Result<Mesh> {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let instance = Instance::random(self.class, Instances::Test, &mut random);
        Ok(match shift {
            Shift::Dent(depth_m) => {
                sim_deform::pressed_instance(&instance, depth_m, random.random())?
            }
            _ => dented_instance(&instance, parameters, &mut random)?,
        })
    }
}

impl Shifts {
    /// A table for each curve, in Markdown.
    pub fn to_text(&self) -> String {
        let mut text = format!(
            "{} scans in each row, of held-out instances of the families, held; in brackets 95 % intervals (Wilson). Shares are of all scans: one without an\n\
             answer is neither right nor known. `*`: within the range that was trained on.\n",
            self.origin.specimens * ObjectClass::ALL.len()
        );
        for curve in &self.curves {
            text += &format!(
                "\n**{}**; trained: {}\n\n\
                 | | label right: 1 view | 3 views | known and right: 1 view | 3 views | known and wrong: 1 view | 3 views | no answer |\n\
                 |---|---|---|---|---|---|---|---|\n",
                curve.name, curve.trained
            );
            for step in &curve.steps {
                let both = |count: fn(&Rates) -> u32| {
                    let [one, three] = [&step.one_view, &step.three_views]
                        .map(|rates| interval(count(rates), rates.scans));
                    format!("{one} | {three}")
                };
                text += &format!(
                    "| {}{} | {} | {} | {} | {} |\n",
                    step.step,
                    if step.is_trained { " *" } else { "" },
                    both(|rates| rates.right),
                    both(|rates| rates.known_right),
                    both(|rates| rates.known_wrong),
                    step.three_views.none,
                );
            }
        }
        text
    }
}
