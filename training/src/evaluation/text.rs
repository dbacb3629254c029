//! An evaluation in words.

use super::{DataTest, Evaluation, Known};
use crate::data::trained_on::Unseen;

impl Evaluation {
    /// A few lines a test, for people.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for tested in &self.tests {
            let DataTest {
                data, seen, test, ..
            } = tested;
            text += &format!(
                "{data}: {seen}\n{}accuracy {} on {} clouds; called known: {}, of all {} though wrong; calibration error {:.3}\n\n",
                test.confusion.table(),
                percent(test.accuracy),
                test.clouds,
                percent(test.known_share),
                percent(test.known_wrong_share),
                test.calibration_error,
            );
        }
        text += &self.strangers_table();
        text + &format!(
            "\n{}; {}\n",
            match self.of_dataset {
                Some(Unseen::Unknown) =>
                    "the model file does not say whether the dataset's meshes were trained on",
                _ => "none of it was trained on",
            },
            self.origin.to_text(),
        )
    }

    /// Strangers of each kind: those least like the known objects first.
    pub(super) fn strangers(&self) -> Vec<(String, &Known)> {
        let far = "of other kinds and sizes, and an empty hand".to_owned();
        let near = self.near.iter().rev();
        let near = near.map(|near| {
            let name = format!("of the same kinds, {}", near.difference);
            (name, &near.known)
        });
        std::iter::once((far, &self.known)).chain(near).collect()
    }

    fn strangers_table(&self) -> String {
        let row = |(name, known): (String, &Known)| {
            format!(
                "| {name} | {} | {:.3} | {} |\n",
                known.stranger_clouds,
                known.auroc,
                percent(1.0 - known.strangers_called_unknown)
            )
        };
        format!(
            "Strangers against {} clouds of known objects, of which {} are called known; known is here always wrong.\n\n\
             | strangers | clouds | AUROC | known and wrong |\n|---|---|---|---|\n{}",
            self.known.known_clouds,
            percent(self.known.known_called_known),
            self.strangers().into_iter().map(row).collect::<String>(),
        )
    }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
