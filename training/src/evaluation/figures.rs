//! The figures that the documentation shows: a file of results, and what is made of it alone: a page, and the few rows of the
//! README.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use whole_file::write as write_whole;

use super::seeds::{KnownRow, StrangerRow, Tests};
use super::{FLANK_LOST, HELD_OUT, Shifts, TRACED};

/// Results of one model.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Figures {
    /// Of scans as in training.
    pub tests: Option<Tests>,
    /// Of scans that are shifted.
    pub shifts: Option<Shifts>,
}

const HEAD: &str = "\
# Figures of the shipped model

Made by `make figures` from [figures.json](figures.json) alone. [model.md](model.md) says how the model was made.

What training and test have in common:

- \"Another of its kind\" is an object that the model has not learned from: its width and height, and with them its form, are those of
  no object of training. The ranges that its measures lie in are the same; they follow standards where there are some.
- \"The very object\" is one that the model has learned from; dents, poses and noise are new. The outlines of the eight were traced
  from recorded scans. This is the paper's case: a laboratory with eight objects of its own.
- \"The dataset's object\" is an object of a dataset. The meshes of `scans-dented-anew` are those eight recorded scans, dented anew: no
  cloud of them is trained on, but the traced outlines are of the same objects. (\"Perhaps trained on\": the file of an older model
  does not name its datasets.)
- Training and test clouds come from one simulator, with the same ranges of noise, mount error and dents, except where a
  table says what is shifted.
- No size of a near stranger that is tested is trained on. Those less than 5 % off are not trained on at all.

An answer that is known and wrong is the only kind that does harm; each table has a column for it.
";

const BEGIN: &str = "<!-- what make figures writes begins here -->\n";
const END: &str = "<!-- what make figures writes ends here -->\n";

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
                "\n## As in training\n\nThe mean of {} seed(s), in brackets the worst of them. {}\n\n{}",
                tests.origins.len(),
                STRANGERS,
                tests.to_tables()
            );
            page += "\n";
            for origin in &tests.origins {
                page += &format!("- {}\n", origin.to_text());
            }
        }
        if let Some(shifts) = &self.shifts {
            page += &format!(
                "\n## One thing at a time is otherwise\n\n{}\n\n- {}\n",
                shifts.to_text().trim_end(),
                shifts.origin.to_text(),
            );
        }
        page
    }

    /// The few rows that stand in the README; nothing where scans as in training were not measured.
    pub fn to_summary(&self) -> String {
        let Some(tests) = &self.tests else {
            return String::new();
        };
        let mut table = "| seen in simulation | label right | known and right | known and wrong |\n|---|---|---|---|\n".to_owned();
        for (data, seen, said) in [
            (
                TRACED,
                "whole surface",
                "the very object, dented anew, from all sides",
            ),
            (TRACED, "1 view", "the same in the hand, one view"),
            (TRACED, "3 views", "three views"),
            (
                HELD_OUT,
                "3 views",
                "another object of the same kind, three views",
            ),
            (
                FLANK_LOST,
                "3 views",
                "the same, with 6 mm of one side not seen",
            ),
        ] {
            let row = tests
                .known
                .iter()
                .find(|row| row.data == data && row.seen == seen);
            table.extend(row.map(|row| {
                let shares = KnownRow::shares(&row.seeds).join(" | ");
                format!("| {said} | {shares} |\n")
            }));
        }
        for StrangerRow { data, seeds } in &tests.strangers {
            let [_, wrong] = StrangerRow::shares(seeds);
            table += &format!("| a stranger {data} | | | {wrong} |\n");
        }
        table
    }

    /// A Markdown text with the summary between its two marks.
    ///
    /// # Errors
    /// It has no marks.
    pub fn within(&self, text: &str) -> Result<String> {
        let parts = text.split_once(BEGIN).and_then(|(before, rest)| {
            let (_, after) = rest.split_once(END)?;
            Some((before, after))
        });
        let (before, after) = parts.with_context(|| {
            format!(
                "it lacks the lines {} and {}, between which the table stands",
                BEGIN.trim_end(),
                END.trim_end()
            )
        })?;
        Ok(format!("{before}{BEGIN}{}{END}{after}", self.to_summary()))
    }

    /// Puts the summary into a Markdown file.
    ///
    /// # Errors
    /// The file cannot be read or written, or lacks the markers at the beginning and the end of the summary.
    pub fn write_within(&self, path: &Path) -> Result<()> {
        let named = || path.display().to_string();
        let text = fs::read_to_string(path).with_context(named)?;
        let text = self.within(&text).with_context(named)?;
        write_whole(path, text.as_bytes()).with_context(named)
    }
}

const STRANGERS: &str = "Strangers are compared with the held-out instances; AUROC is the chance that one of these scores higher.";
