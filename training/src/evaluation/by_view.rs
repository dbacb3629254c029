//! Answers by how the camera looked.

use classifier::{ModelMetadata, Output};
use serde::Serialize;

use crate::samples::Samples;
use crate::test::{Answered, Test};

/// Answers on one kind of clouds.
#[derive(Debug, Clone, Serialize)]
pub struct DataTest {
    /// What it was measured on.
    pub data: String,
    /// What was found.
    #[serde(flatten)]
    pub test: Test,
}

/// One test for each way of looking at the objects: the whole surface, one view, two, ..., and standing on a box: all, one
/// view, two, ....
pub(super) fn by_view(
    data: &str,
    metadata: &ModelMetadata,
    samples: &Samples,
    answers: &[Output],
) -> Vec<DataTest> {
    const ON_BOX: &str = "on a box, without kinematics";
    let mut view_counts = samples.view_counts.clone();
    view_counts.sort_unstable();
    view_counts.dedup();
    // Only the whole surface has no views, and nobody holds it.
    let scanned = |held: u32, views: Option<u32>| {
        move |index: &usize| {
            let count = samples.view_counts[*index];
            let is_asked = views.map_or(count > 0, |views| count == views);
            samples.held[*index] == held && is_asked
        }
    };
    let select = |of: &dyn Fn(&usize) -> bool| (0..samples.len()).filter(of).collect::<Vec<_>>();
    let mut kinds = Vec::new();
    for &views in &view_counts {
        let held = u32::from(views > 0);
        kinds.push((views_text(views), select(&scanned(held, Some(views)))));
    }
    kinds.push((ON_BOX.to_owned(), select(&scanned(0, None))));
    for &views in view_counts.iter().filter(|&&views| views > 0) {
        let name = format!("{ON_BOX}: {}", views_text(views));
        kinds.push((name, select(&scanned(0, Some(views)))));
    }
    kinds.retain(|(_, indices)| !indices.is_empty());
    let test = |(kind, indices): (String, Vec<usize>)| {
        let answered = indices.iter().map(|&index| Answered {
            log_probabilities: &answers[index].log_probabilities,
            known_score: f64::from(answers[index].known_score),
            label: samples.labels[index] as usize,
        });
        DataTest {
            data: format!("{data}: {kind}"),
            test: Test::of(&metadata.labels, metadata.known_threshold, answered),
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
