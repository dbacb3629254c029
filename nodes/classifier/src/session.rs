//! Sessions of ONNX Runtime.

use adaptation::{FEATURES, Familiar, FeatureRows};
use ort::environment::Environment;
use ort::ep::{ExecutionProviderDispatch, OpenVINO};
use ort::session::{Session, builder::SessionBuilder};
use ort::value::TensorRef;

use crate::error::ClassifyError;
use crate::metadata::ModelMetadata;

/// Name of the network's input, float32 `[B, 3, N]`; `[B, 6, N]` with normals.
pub const INPUT_NAME: &str = "points";
/// Name of the network's output, float32 `[B, C]`.
pub const OUTPUT_NAME: &str = "log_probabilities";

/// Name of a second output that a network may have, float32 `[B]`: how much like the classes the cloud is. Without it, the
/// highest probability says so.
pub const KNOWN_SCORE_NAME: &str = "known_score";

/// What the network says of one cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// `[C]`
    pub log_probabilities: Vec<f32>,
    /// How much like the classes the cloud is; compared with the model's threshold.
    pub known_score: f32,
}

/// A session on ONNX Runtime's own code.
pub fn cpu(environment: &Environment, bytes: &[u8]) -> Result<Session, String> {
    let build = || builder(environment)?.commit_from_memory(bytes);
    build().map_err(|error: ort::Error| error.to_string())
}

/// A session on OpenVINO that has passed `try_out`.
pub fn openvino(
    environment: &Environment,
    bytes: &[u8],
    device: &str,
    try_out: impl Fn(&mut Session) -> Result<(), String>,
) -> Result<Session, String> {
    let start = |device: &str| {
        let mut session = on_device(environment, bytes, device)?;
        try_out(&mut session).map(|()| session)
    };
    first_ok(openvino_devices(device).into_iter().map(start))
}

/// OpenVINO's AUTO must be told what to choose from, and refuses a list with a device that is not there.
fn openvino_devices(device: &str) -> Vec<&str> {
    match device {
        "AUTO" => vec!["AUTO:GPU,CPU", "AUTO:CPU"],
        device => vec![device],
    }
}

fn on_device(environment: &Environment, bytes: &[u8], device: &str) -> Result<Session, String> {
    let openvino: ExecutionProviderDispatch = OpenVINO::default()
        .with_device_type(device)
        .with_num_threads(1)
        .build()
        .error_on_failure();
    let build = || {
        builder(environment)?
            .with_execution_providers([openvino])?
            // Else a network that OpenVINO refuses would run on the CPU under OpenVINO's name.
            .with_disable_cpu_fallback()?
            .commit_from_memory(bytes)
    };
    build().map_err(|error: ort::Error| error.to_string())
}

/// The first success, or else the last error.
fn first_ok<T>(attempts: impl Iterator<Item = Result<T, String>>) -> Result<T, String> {
    let mut last = Err("nothing was tried".to_owned());
    for attempt in attempts {
        last = attempt;
        if last.is_ok() {
            break;
        }
    }
    last
}

/// One thread without spinning: the network takes microseconds, and the cores have other work.
fn builder(environment: &Environment) -> ort::Result<SessionBuilder> {
    let builder = Session::builder(environment)?
        .with_intra_threads(1)?
        .with_intra_op_spinning(false)?;
    Ok(builder)
}

/// Runs the network on `input`, [S, 3 or 6, N], and takes the mean of its S answers. `familiar` scores them in the network's place, which
/// then has its features among its outputs.
pub fn infer(
    session: &mut Session,
    input: &[f32],
    metadata: &ModelMetadata,
    familiar: Option<&Familiar>,
) -> Result<Output, ClassifyError> {
    let failed = |error: ort::Error| ClassifyError::Inference(error.to_string());
    let (columns, points) = (metadata.columns(), metadata.point_count);
    let samples = input.len() / (columns * points).max(1);
    let clouds = TensorRef::from_array_view(([samples, columns, points], input)).map_err(failed)?;
    let outputs = session
        .run(ort::inputs![INPUT_NAME => clouds])
        .map_err(failed)?;
    let values = |name: &str| -> Result<Option<Vec<f32>>, ClassifyError> {
        let Some(output) = outputs.get(name) else {
            return Ok(None);
        };
        let (_, values) = output.try_extract_tensor::<f32>().map_err(failed)?;
        Ok(Some(values.to_vec()))
    };
    let rows = values(OUTPUT_NAME)?.unwrap_or_default();
    let log_probabilities = log_mean_exp(&rows, metadata.labels.len());
    let features = match familiar {
        None => None,
        Some(familiar) => values(FEATURES)?.map(|values| (familiar, values)),
    };
    if let Some((familiar, values)) = features {
        let mut rows = FeatureRows::new(values.len() / samples.max(1));
        rows.push(&values);
        return Ok(Output {
            log_probabilities,
            known_score: familiar.score(&rows) as f32,
        });
    }
    let known_score = match values(KNOWN_SCORE_NAME)? {
        Some(scores) => scores.iter().sum::<f32>() / samples as f32,
        None => log_probabilities
            .iter()
            .copied()
            .fold(f32::NEG_INFINITY, f32::max)
            .exp(),
    };
    Ok(Output {
        log_probabilities,
        known_score,
    })
}

/// Logs of the mean probabilities of rows of `classes` log-probabilities. One row stays what it is, to the last bit.
fn log_mean_exp(rows: &[f32], classes: usize) -> Vec<f32> {
    if rows.len() <= classes {
        return rows.to_vec();
    }
    let count = (rows.len() / classes.max(1)) as f32;
    let of_class = |class: usize| rows.iter().skip(class).step_by(classes.max(1));
    (0..classes)
        .map(|class| (of_class(class).map(|log| log.exp()).sum::<f32>() / count).ln())
        .collect()
}
