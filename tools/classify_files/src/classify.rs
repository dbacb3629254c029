//! Classifies clouds in files with the nodes' own code: each file is one view of the same scene.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use classifier::{Answer, Model};
use cloud::{Cloud, Dropped};
use icp_registration::{InitialGuess, Registrar, ViewEvidence};
use roi_crop::{Axis, Crop, Cropper, Frame};
use serde_json::{Value, json};

/// What is known about the scene.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Length of the files' unit, m.
    pub metres_per_file_unit: f64,
    /// Up direction in the files' frame.
    pub up: Axis,
    /// What is not higher than this along `up` is cut away, m; `None` keeps everything.
    pub keep_above_m: Option<f64>,
}

/// The answer and what led to it.
#[derive(Debug, Clone)]
pub struct Classified {
    /// Which object it is.
    pub answer: Answer,
    /// How each file was laid onto those before it.
    pub views: Vec<ViewEvidence>,
    /// What was no measurement in each file.
    pub dropped: Vec<Dropped>,
    /// The object, before sampling.
    pub object: Crop,
    /// Time for registration.
    pub register: Duration,
    /// Time for the crop.
    pub crop: Duration,
}

/// Lower than any point: keeps everything.
const NOTHING_CUT_M: f64 = -100.0;

/// Reads the files in turn, in metres; `finished` is called after each.
///
/// # Errors
/// A file that holds no cloud.
pub fn read_views(
    files: &[PathBuf],
    metres_per_file_unit: f64,
    finished: impl Fn(),
) -> Result<Vec<Cloud>> {
    let scale = metres_per_file_unit as f32;
    let read = |file: &PathBuf| {
        let mut cloud = cloud::read(file)?;
        finished();
        cloud.points.iter_mut().for_each(|point| *point *= scale);
        Ok(cloud)
    };
    files.iter().map(read).collect()
}

/// Registers views (m), cuts the object out and names it.
///
/// # Errors
/// A stage refuses its input.
pub fn classify_views(views: &[Cloud], scene: &Scene, model: &mut Model) -> Result<Classified> {
    let start = Instant::now();
    let parameters = icp_registration::Parameters {
        initial_guess: InitialGuess::Identity,
        ..icp_registration::Parameters::default()
    };
    let mut registrar = Registrar::new(parameters)?;
    let mut evidence = Vec::with_capacity(views.len());
    for (index, view) in views.iter().enumerate() {
        let added = registrar.add_view(&view.points, None);
        evidence.push(added.with_context(|| format!("view {}", index + 1))?);
    }
    let registered = Instant::now();
    let cropper = Cropper::new(roi_crop::Parameters {
        up_axis: scene.up,
        keep_above_m: scene.keep_above_m.unwrap_or(NOTHING_CUT_M),
        ..roi_crop::Parameters::default()
    })?;
    let object = cropper.crop(&registrar.cloud(), Frame::Camera)?;
    let cropped = Instant::now();
    let answer = model.classify(&object.points, &object.up)?;
    Ok(Classified {
        answer,
        views: evidence,
        dropped: views.iter().map(|view| view.dropped).collect(),
        object,
        register: registered - start,
        crop: cropped - registered,
    })
}

impl Classified {
    /// One object for programs: `label`, `known` with its score and threshold, `probabilities` by label, `timing_ms`, `views`.
    pub fn to_json(&self, model: &Model) -> Value {
        let answer = &self.answer;
        let timing = [
            self.register,
            self.crop,
            answer.timing.sample,
            answer.timing.infer,
        ]
        .map(|time| 1e3 * time.as_secs_f64());
        let probabilities = answer.labels.iter().zip(&answer.probabilities);
        let view = |(view, dropped): (&ViewEvidence, &Dropped)| {
            let rows: Vec<Vec<f64>> = view
                .transform
                .to_homogeneous()
                .row_iter()
                .map(|row| row.iter().copied().collect())
                .collect();
            json!({
                "accepted": view.accepted, "reason": view.reason, "fitness": view.fitness,
                "rmse_m": view.rmse_m, "iterations": view.iterations, "transform": rows,
                "dropped_points": dropped.count(),
            })
        };
        json!({
            "label": answer.label,
            "probability": answer.probability,
            "known": answer.known,
            "reason": answer.doubt().unwrap_or_default(),
            "known_score": answer.known_score,
            "known_threshold": answer.known_threshold,
            "probabilities": probabilities.map(|(label, p)| (label.clone(), json!(p)))
                .collect::<serde_json::Map<_, _>>(),
            "timing_ms": {
                "register": timing[0], "crop": timing[1], "sample": timing[2], "infer": timing[3],
                "total": timing.iter().sum::<f64>(),
            },
            "views": self.views.iter().zip(&self.dropped).map(view).collect::<Vec<_>>(),
            "point_count": self.object.points.len(),
            "provider": model.provider(),
            "model_id": model.metadata().run_id,
        })
    }

    /// A few lines for people.
    pub fn to_text(&self, model: &Model) -> String {
        let answer = &self.answer;
        let percent = 100.0 * answer.probability;
        let mut text = format!("{} ({percent:.1} %)\n", answer.label);
        if let Some(doubt) = answer.doubt() {
            text += &format!("not known: {doubt}\n");
        }
        text += "\n";
        for (label, probability) in answer.labels.iter().zip(&answer.probabilities) {
            text += &format!("  {label:<12} {:5.1} %\n", 100.0 * probability);
        }
        let stages = [
            ("register", self.register),
            ("crop", self.crop),
            ("sample", answer.timing.sample),
            ("infer", answer.timing.infer),
        ];
        let stages =
            stages.map(|(stage, time)| format!("{stage} {:.2} ms", 1e3 * time.as_secs_f64()));
        let (count, provider) = (self.object.points.len(), model.provider());
        text + &format!("\n{}; {count} points; {provider}\n", stages.join(", "))
    }
}
