//! What the program says.

use anyhow::Result;
use serde_json::json;
use teach::history::{Did, origin_of};
use teach::look;
use teach::stored::Stored;
use teach::teach::Taught;

/// What came of teaching.
pub fn text(taught: &Taught) -> String {
    let Taught {
        label,
        model,
        held_out,
        others_right: [before, now],
        seconds,
        ..
    } = taught;
    let mut text = format!(
        "{label}: named rightly in {:.1} % of {} held-out scans of {} views, and known in {:.1} %\n\
         what was known before: {:.1} % of the kept clouds were named rightly, now {:.1} %\n",
        100.0 * held_out.right,
        held_out.scans,
        look::VIEWS,
        100.0 * held_out.known_and_right,
        100.0 * before,
        100.0 * now,
    );
    for twin in &taught.twins {
        text += &format!("{}\n", twin.to_text(label));
    }
    text + &format!(
        "{}: {} bytes, features {} bytes, in {:.0} s\n",
        model.display(),
        taught.model_bytes,
        taught.features_bytes,
        seconds.mesh + seconds.dents + seconds.views + seconds.model,
    )
}

/// A change in words.
pub fn words(did: &Did) -> String {
    match did {
        Did::Teach { label, .. } => format!("teaching {label}"),
        Did::Forget { label } => format!("forgetting {label}"),
        Did::Rename { label, to } => format!("renaming {label} to {to}"),
    }
}

/// Says what a model knows.
pub fn list(stored: &Stored, json: bool) -> Result<()> {
    let references = stored.references()?;
    let mut rows = Vec::new();
    let mut text = format!("{} ({})\n", stored.path.display(), stored.metadata.run_id);
    let width = stored
        .metadata
        .labels
        .iter()
        .map(String::len)
        .max()
        .unwrap_or(0);
    for label in &stored.metadata.labels {
        let step = origin_of(&stored.history, label);
        let reference = references.join(format!("{label}.ply"));
        let reference = Some(reference).filter(|path| path.is_file());
        let without = if reference.is_none() {
            "; no reference"
        } else {
            ""
        };
        let origin = match step.map(|step| (&step.did, &step.at)) {
            Some((Did::Teach { from, held_out, .. }, at)) => format!(
                "taught {at} from {from}: {:.1} % of {} held-out scans",
                100.0 * held_out.right,
                held_out.scans
            ),
            _ => "from the training".to_owned(),
        };
        text += &format!("{label:width$}  {origin}{without}\n");
        rows.push(json!({ "label": label, "taught": step, "reference": reference }));
    }
    if json {
        let described = json!({
            "model": stored.path, "run_id": stored.metadata.run_id, "labels": rows, "history": stored.history,
        });
        return program::print(format_args!("{described:#}\n"));
    }
    program::print(text)
}
