//! The same measurement with several seeds, as tables: the mean of all, and the worst.

use serde::{Deserialize, Serialize};

use super::{Evaluation, Known, Objects, Origin, TestResult};

/// Results with one seed after the other.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Tests {
    /// What was measured on what, for each seed.
    pub origins: Vec<Origin>,
    /// Clouds of known objects.
    pub known: Vec<KnownRow>,
    /// Strangers: those least like the known objects first.
    pub strangers: Vec<StrangerRow>,
}

/// Known objects of one kind, seen in one way.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct KnownRow {
    /// Which objects.
    pub data: String,
    /// How these objects relate to training: the very same ones, others of the same kind, or those of a dataset.
    pub are: Objects,
    /// What was seen of them.
    pub seen: String,
    /// Results of the seeds.
    pub seeds: Vec<KnownShares>,
}

/// Answers about known objects; shares of all clouds.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct KnownShares {
    /// Number of clouds.
    pub clouds: usize,
    /// Those whose label is right, known or not.
    pub right: f64,
    /// Those whose label is right and known.
    pub known_right: f64,
    /// Those whose label is wrong and called known.
    pub known_wrong: f64,
}

/// Strangers of one kind.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct StrangerRow {
    /// Which.
    pub data: String,
    /// Results of the seeds.
    pub seeds: Vec<StrangerShares>,
}

/// Answers about strangers.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct StrangerShares {
    /// Number of clouds.
    pub clouds: usize,
    /// Chance that a known object scores higher than a stranger.
    pub auroc: f64,
    /// Share that is called known, which is always wrong.
    pub known_wrong: f64,
}

impl From<&TestResult> for KnownShares {
    fn from(test: &TestResult) -> Self {
        Self {
            clouds: test.clouds,
            right: test.accuracy,
            known_right: test.known_share - test.known_wrong_share,
            known_wrong: test.known_wrong_share,
        }
    }
}

impl From<&Known> for StrangerShares {
    fn from(known: &Known) -> Self {
        Self {
            clouds: known.stranger_clouds,
            auroc: known.auroc,
            known_wrong: 1.0 - known.strangers_called_unknown,
        }
    }
}

impl Tests {
    /// Joins the results of several seeds.
    pub fn of(evaluations: &[Evaluation]) -> Self {
        let mut known: Vec<KnownRow> = Vec::new();
        let mut strangers: Vec<StrangerRow> = Vec::new();
        for evaluation in evaluations {
            for test in &evaluation.tests {
                let shares = KnownShares::from(&test.test);
                let same = |row: &&mut KnownRow| row.data == test.data && row.seen == test.seen;
                match known.iter_mut().find(same) {
                    Some(row) => row.seeds.push(shares),
                    None => known.push(KnownRow {
                        data: test.data.clone(),
                        are: test.are,
                        seen: test.seen.clone(),
                        seeds: vec![shares],
                    }),
                }
            }
            for (data, found) in evaluation.strangers() {
                let shares = StrangerShares::from(found);
                match strangers.iter_mut().find(|row| row.data == data) {
                    Some(row) => row.seeds.push(shares),
                    None => strangers.push(StrangerRow {
                        data,
                        seeds: vec![shares],
                    }),
                }
            }
        }
        Self {
            origins: evaluations
                .iter()
                .map(|evaluation| evaluation.origin.clone())
                .collect(),
            known,
            strangers,
        }
    }

    /// Both tables, in Markdown.
    pub fn to_tables(&self) -> String {
        let mut text = "| objects | each is | seen | clouds | label right | known and right | known and wrong |\n\
                        |---|---|---|---|---|---|---|\n"
            .to_owned();
        for KnownRow {
            data,
            are,
            seen,
            seeds,
        } in &self.known
        {
            let clouds: usize = seeds.iter().map(|shares| shares.clouds).sum();
            let shares = KnownRow::shares(seeds).join(" | ");
            text += &format!("| {data} | {are} | {seen} | {clouds} | {shares} |\n");
        }
        text += "\n| strangers | clouds | AUROC | known and wrong |\n|---|---|---|---|\n";
        for StrangerRow { data, seeds } in &self.strangers {
            let clouds: usize = seeds.iter().map(|shares| shares.clouds).sum();
            let [auroc, wrong] = StrangerRow::shares(seeds);
            text += &format!("| {data} | {clouds} | {auroc} | {wrong} |\n");
        }
        text
    }
}

impl KnownRow {
    /// Label right, known and right, known and wrong: the mean of the seeds, and the worst.
    pub fn shares(seeds: &[KnownShares]) -> [String; 3] {
        let of = |share: fn(&KnownShares) -> f64| seeds.iter().map(share).collect::<Vec<_>>();
        [
            percent_low(&of(|shares| shares.right)),
            percent_low(&of(|shares| shares.known_right)),
            percent_high(&of(|shares| shares.known_wrong)),
        ]
    }
}

impl StrangerRow {
    /// AUROC, known and wrong: the mean of the seeds, and the worst.
    pub fn shares(seeds: &[StrangerShares]) -> [String; 2] {
        let aurocs: Vec<f64> = seeds.iter().map(|shares| shares.auroc).collect();
        let wrong: Vec<f64> = seeds.iter().map(|shares| shares.known_wrong).collect();
        let worst = aurocs.iter().copied().fold(f64::MAX, f64::min);
        [
            format!("{:.3} ({worst:.3})", mean(&aurocs)),
            percent_high(&wrong),
        ]
    }
}

/// Where high shares are good.
fn percent_low(shares: &[f64]) -> String {
    percent(
        mean(shares),
        shares.iter().copied().fold(f64::MAX, f64::min),
    )
}

/// Where low shares are good.
fn percent_high(shares: &[f64]) -> String {
    percent(mean(shares), shares.iter().copied().fold(0.0, f64::max))
}

fn percent(mean: f64, worst: f64) -> String {
    format!("{:.1} ({:.1}) %", 100.0 * mean, 100.0 * worst)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_is_the_lowest_of_what_is_right_and_the_highest_of_what_is_wrong() {
        let shares = |right, known_wrong| KnownShares {
            clouds: 10,
            right,
            known_right: right - 0.1,
            known_wrong,
        };
        let seeds = [shares(0.9, 0.03), shares(1.0, 0.0), shares(0.95, 0.0)];
        assert_eq!(
            KnownRow::shares(&seeds),
            ["95.0 (90.0) %", "85.0 (80.0) %", "1.0 (3.0) %"]
        );
        let strangers = |auroc, known_wrong| StrangerShares {
            clouds: 10,
            auroc,
            known_wrong,
        };
        assert_eq!(
            StrangerRow::shares(&[strangers(0.9, 0.2), strangers(1.0, 0.1)]),
            ["0.950 (0.900)", "15.0 (20.0) %"]
        );
    }
}
