//! The figures that the documentation shows: a file of results, and the page that is made of it alone.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use whole_file::write as write_whole;

use super::{Evaluation, Shifts};

/// Results of one model.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Figures {
    /// Of scans as in training.
    pub tests: Option<Evaluation>,
    /// Of scans that are shifted.
    pub shifts: Option<Shifts>,
}

const HEAD: &str = "\
# Figures of the shipped model

Made by `evaluate --figures` (`make figures`) from [figures.json](figures.json) alone.
[model.md](model.md) says how the model was made.

What training and test have in common:

- A held-out instance has a width and height, and with them a form, that no object of training has; its family's measures lie in
  the same ranges, which follow standards where there are some.
- The outlines of the very objects were traced from eight recorded scans, down to the foot that some have from their scanner; a
  third of the training specimens are such. No recorded cloud is trained on.
- Training and test clouds come from one simulator, with the same ranges of noise, mount error and dents, except where a
  table says what is shifted.
- Dents, poses and noise of the test are drawn anew, with another seed. What is shifted are scans of the very objects.

An answer that is known and wrong is the only kind that does harm; each table has a column for it.
";

impl Figures {
    /// Those in a file; none where there is no file yet.
    ///
    /// # Errors
    /// It cannot be read, or is no file of results.
    pub fn read(path: &Path) -> Result<Self> {
        if !path.exists() {
            return Ok(Self::default());
        }
        let unreadable = || {
            format!(
                "{} holds no figures as this version writes them; delete it and measure again",
                path.display()
            )
        };
        let text = fs::read_to_string(path).with_context(unreadable)?;
        serde_json::from_str(&text).with_context(unreadable)
    }

    /// Writes the file and, beside it, the page.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = format!("{:#}\n", serde_json::to_value(self)?);
        write_whole(path, text.as_bytes())?;
        write_whole(&path.with_extension("md"), self.to_page().as_bytes())?;
        Ok(())
    }

    /// The page.
    pub fn to_page(&self) -> String {
        let mut page = HEAD.to_owned();
        if let Some(tests) = &self.tests {
            page += &format!(
                "\n## As in training\n\n{}\n{}",
                wrapped(&tests.origin.to_text()),
                tests.to_tables()
            );
        }
        if let Some(shifts) = &self.shifts {
            page += &format!(
                "\n## One thing at a time is otherwise\n\n{}\n{}",
                wrapped(&shifts.origin.to_text()),
                shifts.to_text()
            );
        }
        page
    }
}

/// The first letter large, and a full stop.
fn wrapped(line: &str) -> String {
    let mut letters = line.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    format!("{}{}.\n", first.unwrap_or_default(), letters.as_str())
}
