//! Test results by number of views.

use classifier::{ModelMetadata, Output};
use serde::{Deserialize, Serialize};

use crate::data::clouds::Seen;
use crate::evaluation::test_result::{Answered, TestResult};

/// Test result for one kind of clouds.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct DataTest {
    /// Description of the clouds.
    pub data: String,
    /// The result.
    #[serde(flatten)]
    pub test: TestResult,
}

/// One test for each way of looking at the objects: the whole surface, one view, two, ..., and standing on a box: all, one
/// view, two, ....
pub(super) fn by_view(
    data: &str,
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
    let test = |(kind, answers): (String, Vec<&Seen<Output>>)| {
        let answered = answers.iter().map(|answer| Answered {
            log_probabilities: &answer.taken.log_probabilities,
            known_score: f64::from(answer.taken.known_score),
            label: answer.label as usize,
        });
        DataTest {
            data: format!("{data}: {kind}"),
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
