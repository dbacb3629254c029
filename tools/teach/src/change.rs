//! Changes of a model without an object: forgetting, renaming, and going back.

use std::path::{Path, PathBuf};

use adaptation::features_path;
use anyhow::{Context, Result, bail, ensure};
use sim_dataset::folder::REFERENCES;

use crate::adapt::calibrated;
use crate::history::{Did, Step};
use crate::object::check_label;
use crate::stored::{Beside, Stored, copy_path, write_together};
use crate::teach::references_for;

/// Removes an object from a model. Its reference stays, for going back.
///
/// # Errors
/// The model does not know it, or would know one object alone.
pub fn forget(stored: &Stored, label: &str, out: &Path) -> Result<()> {
    let class = class_of(stored, label)?;
    ensure!(
        stored.head.classes() > 2,
        "{} knows two objects, and with one alone there is nothing to tell apart; teach another one first",
        stored.path.display()
    );
    let mut blocks = stored.kept.blocks.clone();
    blocks.remove(class);
    let adapted = calibrated(stored, stored.head.without_class(class), blocks);
    let did = Did::Forget {
        label: label.to_owned(),
    };
    let changed = adapted.changed(Step::now(did, &stored.digest));
    let beside = references_for(stored, &out.with_file_name(REFERENCES))?;
    stored.write(&changed, out, beside)?;
    Ok(())
}

/// Gives an object another name, and copies its reference to that.
///
/// # Errors
/// The model does not know it, or knows the new name already.
pub fn rename(stored: &Stored, label: &str, to: &str, out: &Path) -> Result<()> {
    let class = class_of(stored, label)?;
    check_label(to)?;
    ensure!(
        !stored.metadata.labels.iter().any(|known| known == to),
        "{} knows {to} already; choose another name, or first: teach --forget {to}",
        stored.path.display()
    );
    let mut blocks = stored.kept.blocks.clone();
    blocks[class].label = Some(to.to_owned());
    let did = Did::Rename {
        label: label.to_owned(),
        to: to.to_owned(),
    };
    let changed = crate::stored::Changed {
        head: stored.head.clone(),
        inverse_temperature: stored.inverse_temperature,
        known_threshold: stored.metadata.known_threshold,
        blocks,
        step: Step::now(did, &stored.digest),
    };
    let folder = out.with_file_name(REFERENCES);
    let mut beside = references_for(stored, &folder)?;
    let reference = stored.references()?.join(format!("{label}.ply"));
    if let Ok(bytes) = std::fs::read(reference) {
        let path = folder.join(format!("{to}.ply"));
        beside.push(Beside { path, bytes });
    }
    stored.write(&changed, out, beside)?;
    Ok(())
}

/// Takes the last step back: the model and the features of before, byte by byte. Gives the step.
///
/// # Errors
/// Nothing was taught, or the model of before is not there any more.
pub fn undo(stored: &Stored) -> Result<Step> {
    let path = &stored.path;
    let Some(step) = stored.history.last() else {
        bail!(
            "nothing was taught to {}; there is no step to take back",
            path.display()
        );
    };
    let copy: PathBuf = copy_path(path, &step.parent);
    let features = features_path(&copy);
    let read = |file: &Path| {
        std::fs::read(file).with_context(|| {
            format!(
                "the model of before is not in {}; teach --forget is another way",
                file.display()
            )
        })
    };
    let files = [
        Beside {
            path: features_path(path),
            bytes: read(&features)?,
        },
        Beside {
            path: path.clone(),
            bytes: read(&copy)?,
        },
    ];
    write_together(&files)?;
    Ok(step.clone())
}

fn class_of(stored: &Stored, label: &str) -> Result<usize> {
    let labels = &stored.metadata.labels;
    labels
        .iter()
        .position(|known| known == label)
        .with_context(|| {
            format!(
                "{} does not know {label}; it knows {}",
                stored.path.display(),
                labels.join(", ")
            )
        })
}
