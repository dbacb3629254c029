//! Test results by what was seen of the objects.

use std::fmt;

use classifier::{ModelMetadata, Output};
use serde::{Deserialize, Serialize};

use crate::data::clouds::Seen;
use crate::evaluation::test_result::{Answered, TestResult};

/// Test result for one kind of clouds.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct DataTest {
    /// Which objects.
    pub data: String,
    /// Whether the model learned from these objects or from others of their kind.
    pub are: Objects,
    /// What was seen of them.
    pub seen: String,
    /// The result.
    #[serde(flatten)]
    pub test: TestResult,
}

/// What tested objects are to those that the model learned from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Objects {
    /// Others of the same kind, with a size and form of their own.
    OthersOfTheKind,
    /// The same, dented anew.
    Same,
    /// Those of a dataset, dented anew.
    OfDataset,
}

impl fmt::Display for Objects {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::OthersOfTheKind => "another of its kind",
            Self::Same => "the very object",
            Self::OfDataset => "the dataset's object",
        })
    }
}

/// One test for each way of looking at the objects: the whole surface, one view, two, ..., and standing on a box: all, one
/// view, two, ....
pub(super) fn by_view(
    data: &str,
    are: Objects,
    metadata: &ModelMetadata,
    answers: &[Seen<Output>],
) -> Vec<DataTest> {
    const ON_BOX: &str = "on a box, without kinematics";
    let mut view_counts: Vec<u32> = answers.iter().map(|answer| answer.view_count).collect();
    view_counts.sort_unstable();
    view_counts.dedup();
    // Only clouds of the whole surface have no views; these count as not held.
    let select = |held: bool, views: Option<u32>| {
        let is_asked = |answer: &&Seen<Output>| {
            let count = answer.view_count;
            answer.held == held && views.map_or(count > 0, |views| count == views)
        };
        answers.iter().filter(is_asked).collect::<Vec<_>>()
    };
    let mut kinds = Vec::new();
    for &views in &view_counts {
        kinds.push((views_text(views), select(views > 0, Some(views))));
    }
    kinds.push((ON_BOX.to_owned(), select(false, None)));
    for &views in view_counts.iter().filter(|&&views| views > 0) {
        let name = format!("{ON_BOX}: {}", views_text(views));
        kinds.push((name, select(false, Some(views))));
    }
    kinds.retain(|(_, answers)| !answers.is_empty());
    let test = |(seen, answers): (String, Vec<&Seen<Output>>)| {
        let answered = answers.iter().map(|answer| Answered {
            log_probabilities: &answer.taken.log_probabilities,
            known_score: f64::from(answer.taken.known_score),
            label: answer.label as usize,
        });
        DataTest {
            data: data.to_owned(),
            are,
            seen,
            test: TestResult::of(&metadata.labels, metadata.known_threshold, answered),
        }
    };
    kinds.into_iter().map(test).collect()
}

fn views_text(views: u32) -> String {
    match views {
        0 => "whole surface".to_owned(),
        1 => "1 view".to_owned(),
        _ => format!("{views} views"),
    }
}
