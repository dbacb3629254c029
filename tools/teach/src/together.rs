//! Several files that are written together or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use adaptation::features_path;
use anyhow::{Context, Result};
use classifier::{Model, Provider, SelfTest, TestCloud, self_test_path};
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
    let mut drafts = Vec::with_capacity(files.len() + 1);
    for file in others {
        drafts.push((draft(file)?, file.path.clone()));
    }
    let model_draft = draft(model)?;
    let features = features_path(&model.path);
    let features = drafts.iter().find(|(_, path)| *path == features);
    let features = features.map(|(draft, _)| draft.path());
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
        draft
            .finish()
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

fn draft(Beside { path, bytes }: &Beside) -> Result<Draft> {
    let draft = || -> std::io::Result<Draft> {
        if let Some(folder) = path.parent().filter(|folder| *folder != Path::new("")) {
            std::fs::create_dir_all(folder)?;
        }
        let mut draft = Draft::of(path)?;
        draft.file().write_all(bytes)?;
        draft.file().sync_all()?;
        Ok(draft)
    };
    draft().with_context(|| {
        format!(
            "cannot write {}; is there space, and may you write there? Nothing has changed",
            path.display()
        )
    })
}
