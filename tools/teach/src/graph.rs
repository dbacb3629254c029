//! What needs a running graph: recording the object in the hand, and having the classifier answer with the new model.

use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use msg::deformable_cobot::{LoadModel, LoadModelReq};
use node::Node;
use record_object::{Grasps, Made, Motion, Order, Target};

use crate::history::origin_of;
use crate::progress::Progress;
use crate::stored::{history_of, references_of};
use crate::unprepared::Unprepared;

/// How long the classifier has to be found, to load the model and to try it.
const LOAD_PATIENCE: Duration = Duration::from_secs(20);
/// The node that compares objects with references.
const REFERENCES: &str = "deformation/references";
/// The sweep that shows most: as far as the wrist goes, rad.
const SWEEP_RAD: f64 = 6.0;

/// Records the object in the hand; its mesh goes to LABEL.ply.
///
/// # Errors
/// There is a file of that name already, or the recording failed; nothing has changed then.
pub fn record(label: &str, grasps: Grasps, progress: &Progress) -> Result<Made> {
    let file = PathBuf::from(format!("{label}.ply"));
    ensure!(
        !file.exists(),
        "{file} is there already; teach it with --scan {file}, or move it away to record {label} anew",
        file = file.display()
    );
    let order = Order {
        target: Target::new(Path::new("."), label, false)?,
        grasps,
        motion: Motion::Sweep(SWEEP_RAD),
    };
    let recorded = in_graph(async |node| record_object::record(&node, &order, progress).await);
    recorded.with_context(|| format!("{label} was not recorded, and nothing has changed"))
}

/// Runs what needs a node, of which there is one in the life of a process.
fn in_graph<T>(work: impl AsyncFnOnce(Node) -> Result<T>) -> Result<T> {
    let mut result = None;
    let slot = &mut result;
    let name = format!("teach_{}", std::process::id());
    let code = node::run_program(&name, move |node| async move {
        *slot = Some(work(node).await);
        Ok(())
    });
    match result {
        Some(result) => result,
        None if code == ExitCode::SUCCESS => bail!("stopped"),
        None => bail!("there is no ROS master"),
    }
}

/// Has the running graph use a model, by a program of its own that Ctrl-C at this terminal does not reach: once the files are
/// written, the classifier answers with them, or has said why it does not.
///
/// # Errors
/// As [`load_here`].
pub fn load(model: &Path) -> Result<String> {
    // This very program, also where a new build has replaced its file meanwhile.
    let mut command = Command::new("/proc/self/exe");
    command.args(["--load", "--model"]).arg(model);
    // ROS's own words: names that are mapped, private parameters.
    command.args(std::env::args().filter(|word| word.contains(":=")));
    let ended = command.process_group(0).stdin(Stdio::null()).output();
    let ended = ended.context("cannot start this program again")?;
    let said = String::from_utf8_lossy(&ended.stderr);
    let said = said.trim();
    ensure!(
        ended.status.success(),
        "{}",
        said.strip_prefix("teach: ").unwrap_or(said)
    );
    Ok(said.to_owned())
}

/// Has the running classifier answer with a model, and the node `deformation` compare with what lies in the folder of
/// references beside it; says so.
///
/// # Errors
/// There is no classifier, or it refuses the model; with the remedy.
pub fn load_here(model: &Path) -> Result<String> {
    let model = std::path::absolute(model)
        .with_context(|| format!("cannot tell where {} is", model.display()))?;
    let unprepared = Unprepared::open(&model)?;
    let labels = &unprepared.metadata.labels;
    let history = history_of(&unprepared.builder, &model)?;
    let is_taught = |label: &str| origin_of(&history, label).is_some();
    // Before the model, so that a reference is there at the first answer with the new label.
    let placed = Placed::of(&references_of(&model)?, labels, is_taught);
    let loaded = in_graph(async |node| ask(&node, &model).await);
    match loaded {
        Ok(id) => {
            placed?;
            Ok(format!(
                "the classifier answers with {id} from the next scan on"
            ))
        }
        Err(error) => {
            placed.map_or(Ok(()), Placed::take_back)?;
            let file = model.display();
            Err(error.context(format!(
                "{file} is written, but the classifier does not use it yet; launch the graph with model:={file}, or while \
                 it runs: rosrun deformable_cobot teach --load --model {file}"
            )))
        }
    }
}

async fn ask(node: &Node, model: &Path) -> Result<String> {
    let request = LoadModelReq {
        model: model.display().to_string(),
    };
    let life = node.life();
    let answer = node
        .call::<LoadModel>("load_model", request, LOAD_PATIENCE, &life)
        .await?;
    ensure!(answer.error.is_empty(), "{}", answer.error);
    Ok(answer.model_id)
}

/// References in the folder that the node `deformation` reads, which looks there at each scan.
#[derive(Debug, Default)]
struct Placed {
    /// With what was there before.
    files: Vec<(PathBuf, Option<Vec<u8>>)>,
}

impl Placed {
    /// Copies the references of these labels there, where a graph runs. A file that is there is replaced only by that of an
    /// object that was taught.
    fn of(references: &Path, labels: &[String], is_taught: impl Fn(&str) -> bool) -> Result<Self> {
        let mut placed = Self::default();
        let Some(folder) = deformation_folder() else {
            return Ok(placed);
        };
        for label in labels {
            let name = format!("{label}.ply");
            let path = folder.join(&name);
            let before = std::fs::read(&path).ok();
            let Ok(bytes) = std::fs::read(references.join(&name)) else {
                continue;
            };
            let is_other = before.as_ref().is_some_and(|before| *before != bytes);
            if before.is_some() && !(is_other && is_taught(label)) {
                continue;
            }
            whole_file::write(&path, &bytes).with_context(|| {
                format!(
                    "cannot put {name} into {}, where the node deformation looks for it; launch with references:=FOLDER of \
                     your own",
                    folder.display()
                )
            })?;
            placed.files.push((path, before));
        }
        Ok(placed)
    }

    /// Puts back what was there before.
    fn take_back(self) -> Result<()> {
        for (path, before) in self.files {
            let done = match &before {
                Some(bytes) => whole_file::write(&path, bytes),
                None => std::fs::remove_file(&path),
            };
            done.with_context(|| format!("cannot take back {}", path.display()))?;
        }
        Ok(())
    }
}

/// The folder that the node `deformation` reads, as the parameter server has it.
fn deformation_folder() -> Option<PathBuf> {
    let name = format!("/{REFERENCES}");
    let output = Command::new("rosparam")
        .args(["get", &name])
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let folder = PathBuf::from(text.trim().trim_matches(['\'', '"']));
    (output.status.success() && folder.is_dir()).then_some(folder)
}
