//! The undented objects that a model knows, for the node `deformation`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use mesh::file::write_ply;
use sim_dataset::folder::{Folder, REFERENCES};
use sim_objects::{ObjectClass, Variation};

/// Writes LABEL.ply for each label into the folder `references` beside the model: the datasets' own, else that of the
/// eight. A dataset of before may have none; that label is left out.
///
/// # Errors
/// The file system refuses.
pub fn write(model: &Path, labels: &[String], datasets: &[PathBuf]) -> Result<()> {
    let folder = model.with_file_name(REFERENCES);
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for label in labels {
        let to = folder.join(format!("{label}.ply"));
        let of_datasets = datasets
            .iter()
            .map(|root| Folder::at(root).reference(label));
        let class = ObjectClass::ALL
            .into_iter()
            .find(|class| class.name() == label);
        match (of_datasets.rev().find(|path| path.is_file()), class) {
            (Some(from), _) => {
                let bytes =
                    fs::read(&from).with_context(|| format!("cannot read {}", from.display()))?;
                whole_file::write(&to, &bytes)
                    .with_context(|| format!("cannot write {}", to.display()))?;
            }
            (None, Some(class)) => write_ply(&to, &class.mesh(&Variation::NONE))?,
            (None, None) => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_dataset_brings_its_own_and_the_eight_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let dataset = folder.path().join("my-can");
        fs::create_dir_all(dataset.join(REFERENCES)).unwrap();
        fs::write(dataset.join("references/my-can.ply"), "mine").unwrap();
        let labels = ["tiny-ball", "my-can", "of-before"].map(str::to_owned);
        write(&folder.path().join("model.onnx"), &labels, &[dataset]).unwrap();
        let written = folder.path().join(REFERENCES);
        assert_eq!(fs::read(written.join("my-can.ply")).unwrap(), b"mine");
        assert_eq!(fs::read_dir(&written).unwrap().count(), 2);
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/references");
        assert_eq!(
            fs::read(written.join("tiny-ball.ply")).unwrap().len(),
            fs::read(shipped.join("tiny-ball.ply")).unwrap().len()
        );
    }
}
