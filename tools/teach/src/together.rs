//! Several files that are written together or not at all.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use adaptation::features_path;
use anyhow::{Context, Result};
use classifier::{Features, Model, Provider, SelfTest, TestCloud, self_test_path};
use whole_file::Draft;

/// A file to be written with a model.
#[derive(Debug, Clone)]
pub struct Beside {
    /// Where.
    pub path: PathBuf,
    /// What.
    pub bytes: Vec<u8>,
}

/// Writes all files whole, and under their names only once each of them is on the disk. The last one must be a model, which
/// is loaded before; those of the clouds that it names rightly become the self-test beside it.
///
/// # Errors
/// A file cannot be written, or the model cannot be used. Nothing has changed then.
pub(crate) fn write_together(files: &[Beside], clouds: &[TestCloud]) -> Result<()> {
    let Some((model, others)) = files.split_last() else {
        return Ok(());
    };
    // Removed after the drafts in them.
    let mut folders = Folders::default();
    let mut drafts = Vec::with_capacity(files.len() + 1);
    for file in files {
        folders.make_for(&file.path, file.bytes.len())?;
    }
    for file in others {
        drafts.push((draft(file)?, file.path.clone()));
    }
    let model_draft = draft(model)?;
    let features = features_path(&model.path);
    let features = drafts.iter().find(|(_, path)| *path == features);
    let features = features.map_or(Features::Unused, |(draft, _)| Features::File(draft.path()));
    let self_test = Model::load_with(model_draft.path(), features, Provider::Cpu, "CPU")
        .map_err(anyhow::Error::from)
        .and_then(|mut new| Ok(SelfTest::of(&mut new, clouds)?.encode()?))
        .context("the new model cannot be used; nothing has changed")?;
    let self_test = Beside {
        path: self_test_path(&model.path),
        bytes: self_test,
    };
    drafts.push((draft(&self_test)?, self_test.path));
    drafts.push((model_draft, model.path.clone()));
    for (draft, path) in drafts {
        draft.finish().map_err(unwritten(&path, 0))?;
    }
    Ok(())
}

fn draft(Beside { path, bytes }: &Beside) -> Result<Draft> {
    let draft = || -> std::io::Result<Draft> {
        let mut draft = Draft::of(path)?;
        draft.file().write_all(bytes)?;
        draft.file().sync_all()?;
        Ok(draft)
    };
    draft().map_err(unwritten(path, bytes.len()))
}

/// Why a file of so many bytes cannot be written, with the remedy.
pub(crate) fn unwritten(path: &Path, bytes: usize) -> impl FnOnce(std::io::Error) -> anyhow::Error {
    move |error| {
        let remedy = match error.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
                "free space on its disk, or name a place on another one with --model"
            }
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                "name a place with --model where you may write"
            }
            _ => "is there space, and may you write there?",
        };
        let (path, kilobytes) = (path.display(), bytes.div_ceil(1000));
        anyhow::Error::new(error).context(format!(
            "cannot write {path} ({kilobytes} kB); {remedy}; nothing has changed"
        ))
    }
}

/// The folders that are made for files, and removed again if there is nothing in them in the end: an empty folder of references
/// would be taken for one without any.
#[derive(Debug, Default)]
struct Folders(Vec<PathBuf>);

impl Folders {
    /// Makes the folder of a file where it is missing.
    fn make_for(&mut self, path: &Path, bytes: usize) -> Result<()> {
        let Some(folder) = path.parent().filter(|folder| *folder != Path::new("")) else {
            return Ok(());
        };
        let missing = folder.ancestors().take_while(|folder| !folder.exists());
        self.0.extend(missing.map(Path::to_path_buf));
        std::fs::create_dir_all(folder).map_err(unwritten(path, bytes))
    }
}

impl Drop for Folders {
    fn drop(&mut self) {
        self.0
            .sort_by_key(|folder| std::cmp::Reverse(folder.components().count()));
        for folder in &self.0 {
            // Fails where it holds something.
            let _ = std::fs::remove_dir(folder);
        }
    }
}
