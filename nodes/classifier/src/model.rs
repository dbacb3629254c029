//! A loaded model and what it answers.

use std::path::Path;
use std::time::{Duration, Instant};

use adaptation::Familiar;
use nalgebra::{Point3, Vector3};
use ort::session::Session;

use crate::error::{ClassifyError, LoadError};
use crate::familiar::{self, Features};
use crate::interface::checked_metadata;
use crate::metadata::{KnownBy, ModelMetadata};
use crate::preprocess::{SAMPLES, preprocess_parts};
use crate::provider::Provider;
use crate::session::Output;
use crate::{runtime, session};

/// Largest accepted model file (paper, Sec. VI-B.3).
pub const MAX_MODEL_BYTES: u64 = 100_000;

/// An answer that is less probable is not known: it may as well be another of the model's objects. `train` calibrates
/// probabilities, so that this means the same in every model. How it was chosen: docs/model.md.
pub const CERTAIN_PROBABILITY: f64 = 0.8;

/// A model that is ready to classify.
#[derive(Debug)]
pub struct Model {
    session: Session,
    metadata: ModelMetadata,
    /// Where it is not the network's own score that tells what is known.
    familiar: Option<Familiar>,
    provider: String,
    fallback_reason: Option<String>,
}

/// How long each step of one classification took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Preprocessing.
    pub sample: Duration,
    /// The network.
    pub infer: Duration,
}

/// Which object it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The most probable label.
    pub label: String,
    /// Its probability.
    pub probability: f64,
    /// False: unlike everything that the model was trained on, or like two of its objects; see [`Answer::doubt`].
    pub known: bool,
    /// How much the cloud is like what the model knows, larger is more alike: a logit, or of a taught model minus a distance.
    pub known_score: f64,
    /// The model file's threshold of that score, the same for every cloud.
    pub known_threshold: f64,
    /// All labels, in the model's order.
    pub labels: Vec<String>,
    /// Their probabilities; the sum is 1.
    pub probabilities: Vec<f64>,
    /// How long it took.
    pub timing: Timing,
}

impl Model {
    /// Loads a model file and runs it on one sample and on several, so that the first real cloud does not wait.
    ///
    /// If OpenVINO is asked for and cannot start, the model runs on ONNX Runtime's CPU provider
    /// and [`Model::fallback_reason`] says why. `device` is OpenVINO's: CPU, GPU or AUTO.
    ///
    /// # Errors
    /// The file or ONNX Runtime is missing; the file lacks the metadata of [`ModelMetadata`]; or its input and output are not named
    /// and shaped as [`crate::INPUT_NAME`] and [`crate::OUTPUT_NAME`] describe.
    pub fn load(path: &Path, provider: Provider, device: &str) -> Result<Self, LoadError> {
        Self::load_with(path, Features::Beside, provider, device)
    }

    /// The same with the features of another file than the one beside the model, or without.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn load_with(
        path: &Path,
        features: Features,
        provider: Provider,
        device: &str,
    ) -> Result<Self, LoadError> {
        let mut bytes = read(path)?;
        let corrupt = |reason: String| LoadError::Corrupt {
            path: path.to_path_buf(),
            reason,
        };
        // The CPU session judges the file, so that a fault of the file is never taken for a
        // fault of OpenVINO.
        let environment = runtime::environment()?;
        let mut session = session::cpu(environment, &bytes).map_err(corrupt)?;
        let metadata = checked_metadata(&session, path)?;
        let mut familiar = None;
        if metadata.known_by == KnownBy::Features
            && let Some((known, with_features)) = familiar::read(path, &bytes, features)?
        {
            bytes = with_features;
            session = session::cpu(environment, &bytes).map_err(corrupt)?;
            familiar = Some(known);
        }
        let infer_blank = |session: &mut Session| {
            let sample = metadata.columns() * metadata.point_count;
            let mut infer = |samples| {
                session::infer(session, &vec![0.0; samples * sample], &metadata, None)
                    .map_err(|error| error.to_string())
            };
            infer(SAMPLES).and_then(|_| infer(1)).map(|_| ())
        };
        infer_blank(&mut session).map_err(corrupt)?;
        let mut running = Provider::Cpu.to_string();
        let mut fallback_reason = None;
        if provider == Provider::OpenVino {
            match session::openvino(environment, &bytes, device, infer_blank) {
                Ok(openvino) => {
                    session = openvino;
                    running = format!("{provider}:{device}");
                }
                Err(reason) => {
                    fallback_reason = Some(format!("{provider}:{device} cannot start: {reason}"));
                }
            }
        }
        Ok(Self {
            session,
            metadata,
            familiar,
            provider: running,
            fallback_reason,
        })
    }

    /// What the file says about itself.
    pub fn metadata(&self) -> &ModelMetadata {
        &self.metadata
    }

    /// What runs the network: `openvino:<device>` or `cpu`.
    pub fn provider(&self) -> &str {
        &self.provider
    }

    /// Why the CPU runs the network although OpenVINO was asked for.
    pub fn fallback_reason(&self) -> Option<&str> {
        self.fallback_reason.as_deref()
    }

    /// Names the object of a cloud; `points` in metres, `up` in their frame.
    ///
    /// # Errors
    /// The cloud has too few points or one that is not finite, or the network failed.
    pub fn classify(
        &mut self,
        points: &[Point3<f32>],
        up: &Vector3<f64>,
    ) -> Result<Answer, ClassifyError> {
        let start = Instant::now();
        let input = preprocess_parts(points, up, &self.metadata)?;
        let sampled = Instant::now();
        let output = self.infer(&input)?;
        let timing = Timing {
            sample: sampled - start,
            infer: sampled.elapsed(),
        };
        answer(&output, &self.metadata, timing)
    }

    /// Classifies one cloud. `input` holds one or more random samples of the cloud's points, as [`preprocess_parts`] makes them. The
    /// network runs on each sample, and the class probabilities are averaged. Returns the most probable label and its probability.
    ///
    /// # Errors
    /// The input is of another size than the network's, or the network failed.
    pub fn name(&mut self, input: &[f32]) -> Result<(String, f64), ClassifyError> {
        let sample = self.metadata.columns() * self.metadata.point_count;
        if input.is_empty() || !input.len().is_multiple_of(sample) {
            return Err(ClassifyError::Inference(format!(
                "an input of {} numbers, not of {sample} each",
                input.len()
            )));
        }
        let output = self.infer(input)?;
        let nothing = Timing {
            sample: Duration::ZERO,
            infer: Duration::ZERO,
        };
        let answer = answer(&output, &self.metadata, nothing)?;
        Ok((answer.label, answer.probability))
    }

    /// The network alone: `input` as from [`preprocess_parts`]; the answer is the mean of those to its samples.
    ///
    /// # Errors
    /// The network failed.
    pub fn infer(&mut self, input: &[f32]) -> Result<Output, ClassifyError> {
        let familiar = self.familiar.as_ref();
        session::infer(&mut self.session, input, &self.metadata, familiar)
    }
}

impl Answer {
    /// Why the object is not known; `None` where it is.
    pub fn doubt(&self) -> Option<String> {
        if self.known {
            return None;
        }
        if self.known_score < self.known_threshold {
            return Some(format!(
                "unlike everything that the model was trained on: its score {:.2} is below the threshold {:.2}",
                self.known_score, self.known_threshold
            ));
        }
        let others = self.labels.iter().zip(&self.probabilities);
        let second = others
            .filter(|(label, _)| **label != self.label)
            .max_by(|a, b| a.1.total_cmp(b.1));
        let (second, probability) = second?;
        Some(format!(
            "it may also be {second} ({probability:.3}): a probability of {:.3} is below {CERTAIN_PROBABILITY}; \
             more views or another grasp may tell",
            self.probability
        ))
    }
}

/// Whether an answer is called known: the cloud is like what the model was trained on, and like one of its objects alone.
pub fn is_known(known_score: f64, known_threshold: f64, probability: f64) -> bool {
    known_score >= known_threshold && probability >= CERTAIN_PROBABILITY
}

fn read(path: &Path) -> Result<Vec<u8>, LoadError> {
    let unreadable = |source| LoadError::Read {
        path: path.to_path_buf(),
        source,
    };
    // The size first: a wrong path may name something huge.
    let bytes = std::fs::metadata(path).map_err(unreadable)?.len();
    if bytes == 0 || bytes > MAX_MODEL_BYTES {
        return Err(LoadError::Size {
            path: path.to_path_buf(),
            bytes,
            max: MAX_MODEL_BYTES,
        });
    }
    std::fs::read(path).map_err(unreadable)
}

fn answer(
    output: &Output,
    metadata: &ModelMetadata,
    timing: Timing,
) -> Result<Answer, ClassifyError> {
    let raw: Vec<f64> = output
        .log_probabilities
        .iter()
        .map(|&l| f64::from(l).exp())
        .collect();
    let sum: f64 = raw.iter().sum();
    // The network ends in a log-softmax: only a damaged file gives anything but a sum of 1.
    let sums_to_one = (sum - 1.0).abs() < 1e-3;
    if raw.len() != metadata.labels.len() || !sums_to_one {
        return Err(ClassifyError::Output(format!(
            "{:?}",
            output.log_probabilities
        )));
    }
    let probabilities: Vec<f64> = raw.iter().map(|value| value / sum).collect();
    let (best, &probability) = probabilities
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .ok_or_else(|| ClassifyError::Output("nothing".to_owned()))?;
    let known_score = f64::from(output.known_score);
    Ok(Answer {
        label: metadata.labels[best].clone(),
        probability,
        known: is_known(known_score, metadata.known_threshold, probability),
        known_score,
        known_threshold: metadata.known_threshold,
        labels: metadata.labels.clone(),
        probabilities,
        timing,
    })
}
