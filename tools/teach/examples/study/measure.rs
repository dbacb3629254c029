//! Figures of a model.

use adaptation::FeatureRows;
use teach::judge::{Judge, Judged};

/// Clouds as a network sees them: of what a model knows before, by class, and of strangers, as in [`crate::seen::Test`].
pub struct Known {
    pub old: Vec<Vec<FeatureRows>>,
    pub strangers: [Vec<FeatureRows>; 2],
}

/// Figures of a model after so many taught objects.
#[derive(Debug, Clone)]
pub struct Row {
    pub taught: usize,
    /// Share of the scans that were named rightly.
    pub new_right: f64,
    pub old_right: f64,
    /// Share of all scans of known objects.
    known_wrong: f64,
    known: f64,
    /// Of strangers unlike what is taught, and of all.
    pub auroc: [f64; 2],
    /// Share of the strangers (unlike, then all) that are called known.
    strangers_known: [f64; 2],
    /// To make its views, and to adapt and write the model.
    pub seconds: [f64; 2],
    pub model_bytes: usize,
}

impl Known {
    /// Measures layers whose classes are those of before and then the new ones.
    pub fn row(&self, judge: &Judge, new: &[&[FeatureRows]]) -> Row {
        let judged = |clouds: &[FeatureRows]| -> Vec<Judged> {
            clouds.iter().map(|cloud| judge.judge(cloud)).collect()
        };
        let old = self.old.iter().map(|clouds| judged(clouds));
        let new_answers = new.iter().map(|clouds| judged(clouds));
        let all: Vec<(usize, Vec<Judged>)> = old.chain(new_answers).enumerate().collect();
        let (old, taught) = all.split_at(self.old.len());
        let right = |groups| share(groups, |class, answer| answer.best == class);
        let scores = |answers: &[Judged]| -> Vec<f64> { answers.iter().map(|a| a.score).collect() };
        let known: Vec<f64> = all
            .iter()
            .flat_map(|(_, answers)| scores(answers))
            .collect();
        let [alike, unlike] = self.strangers.each_ref().map(|clouds| judged(clouds));
        let strangers = [unlike.clone(), [alike, unlike].concat()];
        Row {
            taught: new.len(),
            new_right: right(taught),
            old_right: right(old),
            known_wrong: share(&all, |class, answer| answer.known && answer.best != class),
            known: share(&all, |_, answer| answer.known),
            auroc: strangers
                .each_ref()
                .map(|some| auroc(&known, &scores(some))),
            strangers_known: strangers.map(|some| share(&[(0, some)], |_, answer| answer.known)),
            seconds: [0.0; 2],
            model_bytes: 0,
        }
    }
}

impl Row {
    pub const HEADING: &str = "| method | taught | new named rightly | the eight named rightly | known and wrong | known | \
        AUROC of strangers | with a carton, a bottle, a bowl | strangers called known | with those | model, bytes |\n\
        |---|---|---|---|---|---|---|---|---|---|---|";

    /// A row of a table.
    pub fn text(&self, name: &str) -> String {
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        let [unlike, all] = self.auroc;
        let new = match self.taught {
            0 => "–".to_owned(),
            _ => percent(self.new_right),
        };
        format!(
            "| {name} | {} | {new} | {} | {} | {} | {unlike:.4} | {all:.4} | {} | {} | {} |",
            self.taught,
            percent(self.old_right),
            percent(self.known_wrong),
            percent(self.known),
            percent(self.strangers_known[0]),
            percent(self.strangers_known[1]),
            self.model_bytes
        )
    }
}

fn share(groups: &[(usize, Vec<Judged>)], is_meant: impl Fn(usize, &Judged) -> bool) -> f64 {
    let total: usize = groups.iter().map(|(_, answers)| answers.len()).sum();
    let answers = groups
        .iter()
        .flat_map(|(class, answers)| answers.iter().map(move |answer| (*class, answer)));
    let meant = answers.filter(|(class, answer)| is_meant(*class, answer));
    meant.count() as f64 / total.max(1) as f64
}

/// Probability that a known object scores higher than a stranger.
fn auroc(known: &[f64], strangers: &[f64]) -> f64 {
    let wins: f64 = known
        .iter()
        .flat_map(|k| strangers.iter().map(move |s| (k, s)))
        .map(|(k, s)| match k.total_cmp(s) {
            std::cmp::Ordering::Greater => 1.0,
            std::cmp::Ordering::Equal => 0.5,
            std::cmp::Ordering::Less => 0.0,
        })
        .sum();
    wins / (known.len() * strangers.len()).max(1) as f64
}
