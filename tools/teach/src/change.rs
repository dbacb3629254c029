//! Changes of a model without an object: forgetting, renaming, and going back.

use std::path::{Path, PathBuf};

use adaptation::{copy_path, features_path};
use anyhow::{Context, Result, bail, ensure};
use classifier::SelfTest;
use sim_dataset::folder::REFERENCES;

use crate::adapt::calibrated;
use crate::history::{Did, Step};
use crate::object::check_label;
use crate::stored::{Beside, Stored, Unprepared};
use crate::teach::references_for;
use crate::together::write_together;

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
    let adapted = calibrated(stored, stored.head.without_class(class), blocks)?;
    let mut self_test = stored.self_test.clone();
    self_test.retain(|cloud| cloud.label != label);
    let did = Did::Forget {
        label: label.to_owned(),
    };
    let changed = adapted.changed(self_test, Step::now(did, &stored.digest));
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
    let mut self_test = stored.self_test.clone();
    let renamed = self_test.iter_mut().filter(|cloud| cloud.label == label);
    renamed.for_each(|cloud| to.clone_into(&mut cloud.label));
    let changed = crate::stored::Changed {
        self_test,
        head: stored.head.clone(),
        inverse_temperature: stored.inverse_temperature,
        known_threshold: stored.metadata.known_threshold,
        known_by: stored.metadata.known_by,
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
    // The model that is taken back stays beside the others: were this interrupted, it would be in force still.
    let mut files = stored.copies(path)?;
    files.extend([
        Beside {
            path: features_path(path),
            bytes: read(&features)?,
        },
        Beside {
            path: path.clone(),
            bytes: read(&copy)?,
        },
    ]);
    // A model of before may be older than its self-test.
    let id = Unprepared::open(&copy)?.metadata.run_id;
    let self_test = SelfTest::beside(&copy, &id)?.unwrap_or_default();
    write_together(&files, &self_test.clouds)?;
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
