//! What needs a running graph: recording the object in the hand, and having the classifier answer with the new model.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use msg::deformable_cobot::{LoadModel, LoadModelReq};
use node::Node;

/// How long the classifier has to be found, to load the model and to try it.
const LOAD_PATIENCE: Duration = Duration::from_secs(20);
/// The node that compares objects with references.
const REFERENCES: &str = "deformation/references";

/// Records the object in the hand with the program record_object, which lies beside this one; gives the file of its mesh.
///
/// # Errors
/// There is a file of that name already, or the recording failed, of which record_object has said why.
pub fn record(label: &str, grasps: u32) -> Result<PathBuf> {
    let mesh = PathBuf::from(format!("{label}.ply"));
    ensure!(
        !mesh.exists(),
        "{file} is there already; teach it with --scan {file}, or move it away to record {label} anew",
        file = mesh.display()
    );
    let program = std::env::current_exe().context("cannot tell where this program is")?;
    let program = program.with_file_name("record_object");
    let mut command = Command::new(&program);
    command.args([label, "--json", "--grasps", &grasps.to_string()]);
    // ROS's own words: names that are mapped, private parameters.
    command.args(std::env::args().filter(|word| word.contains(":=")));
    // It tells its user by stderr; its results are for programs.
    let ended = command.stdout(Stdio::null()).status();
    let ended = ended.with_context(|| format!("cannot start {}", program.display()))?;
    ensure!(
        ended.success(),
        "{label} was not recorded; nothing has changed"
    );
    Ok(mesh)
}

/// Has the running classifier answer with a model, and gives its id.
///
/// # Errors
/// There is no classifier, or it refuses the model; with the remedy.
pub fn load(model: &Path) -> Result<String> {
    let model = std::path::absolute(model)
        .with_context(|| format!("cannot tell where {} is", model.display()))?;
    let mut result = None;
    let slot = &mut result;
    let name = format!("teach_{}", std::process::id());
    let file = model.clone();
    let code = node::run_program(&name, move |node| async move {
        *slot = Some(ask(&node, &file).await);
        Ok(())
    });
    let loaded = match result {
        Some(loaded) => loaded,
        None if code == ExitCode::SUCCESS => Err(anyhow::anyhow!("stopped")),
        None => Err(anyhow::anyhow!("there is no ROS master")),
    };
    loaded.with_context(|| {
        let file = model.display();
        format!(
            "{file} is written, but the classifier does not use it yet; launch the graph with model:={file}, or while it \
             runs: rosservice call /load_model \"{{model: {file}}}\""
        )
    })
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

/// A reference in the folder that the node `deformation` reads, which looks there at each scan.
#[derive(Debug)]
pub struct Placed {
    path: PathBuf,
    before: Option<Vec<u8>>,
}

impl Placed {
    /// Copies a reference there; `None` where no graph runs.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn of(reference: &Path) -> Result<Option<Self>> {
        let Some(folder) = references() else {
            return Ok(None);
        };
        let path = folder.join(reference.file_name().unwrap_or_default());
        let before = std::fs::read(&path).ok();
        let bytes = std::fs::read(reference);
        let copied = bytes.and_then(|bytes| whole_file::write(&path, &bytes));
        copied.with_context(|| {
            format!(
                "cannot put {} into {}, where the node deformation looks for it; launch with references:=FOLDER of your own",
                reference.display(),
                folder.display()
            )
        })?;
        Ok(Some(Self { path, before }))
    }

    /// Puts back what was there before.
    ///
    /// # Errors
    /// The file cannot be changed.
    pub fn take_back(self) -> Result<()> {
        let done = match &self.before {
            Some(bytes) => whole_file::write(&self.path, bytes),
            None => std::fs::remove_file(&self.path),
        };
        done.with_context(|| format!("cannot take back {}", self.path.display()))
    }
}

/// The folder that the node `deformation` reads, as the parameter server has it.
fn references() -> Option<PathBuf> {
    let name = format!("/{REFERENCES}");
    let output = Command::new("rosparam")
        .args(["get", &name])
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let folder = PathBuf::from(text.trim().trim_matches(['\'', '"']));
    (output.status.success() && folder.is_dir()).then_some(folder)
}
