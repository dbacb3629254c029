//! How right answers are.

use std::time::Instant;

use deformation::{Parameters, Reference, measure};

use super::unseen::{self, Unseen};
use super::{Case, Truth};

/// From which depth on a dent in view counts, m: the shallowest of those asked for, less what the mesh rounds.
pub const DENTED_M: f64 = 0.0038;
/// The shallowest and deepest of two dents that count as alike, as a ratio: a squeezed object has two.
const ALIKE: f64 = 0.8;

/// A case and its answer.
#[derive(Debug, Clone, Default)]
pub struct Row {
    pub class: String,
    pub seed: u64,
    pub asked_m: f64,
    pub flattened: bool,
    pub distance_m: f64,
    /// Of the dent that is meant.
    pub truth_m: f64,
    pub depth_m: f64,
    pub dents: usize,
    pub significance: f64,
    pub centre_error_m: f64,
    pub direction_error_rad: f64,
    pub seen_share: f64,
    pub rms_m: f64,
    pub reason: String,
    pub milliseconds: f64,
    pub unseen: Unseen,
}

impl Row {
    /// Measures a case.
    pub fn of(case: &Case, reference: &Reference) -> Self {
        let parameters = Parameters {
            synthesis: false,
            ..Parameters::default()
        };
        let start = Instant::now();
        let result = measure(reference, &case.observation(), &parameters);
        let mut row = Self {
            milliseconds: 1e3 * start.elapsed().as_secs_f64(),
            class: case.class.clone(),
            seed: case.seed,
            asked_m: case.asked_m,
            flattened: case.flattened,
            distance_m: case.distance_m,
            truth_m: case.truth.first().map_or(0.0, |dent| dent.depth_m),
            unseen: Unseen::of(case, reference),
            ..Self::default()
        };
        let found = match result {
            Ok(found) => found,
            Err(doubt) => {
                row.reason = doubt.to_string();
                return row;
            }
        };
        row.reason = found
            .doubt
            .as_ref()
            .map(ToString::to_string)
            .unwrap_or_default();
        row.dents = found.dents.len();
        row.significance = found.significance;
        row.seen_share = found.seen_share;
        row.rms_m = found.undented_rms_m;
        let Some(dent) = found.dents.first() else {
            return row;
        };
        row.depth_m = dent.depth_m;
        let away_m = |truth: &Truth| (dent.centre - truth.centre).norm();
        let meant = case
            .truth
            .iter()
            .filter(|truth| truth.depth_m > ALIKE * row.truth_m);
        if let Some(truth) = meant.min_by(|a, b| away_m(a).total_cmp(&away_m(b))) {
            row.truth_m = truth.depth_m;
            row.centre_error_m = away_m(truth);
            row.direction_error_rad = dent.direction.angle(&truth.direction);
        }
        row
    }

    fn is_dented(&self) -> bool {
        self.truth_m >= DENTED_M
    }
}

/// The table of many.
#[derive(Debug, Clone, Default)]
pub struct Table {
    pub undented: usize,
    pub dented: usize,
    /// Of dented against undented, by significance.
    pub auroc: f64,
    /// Undented objects with a dent.
    pub false_dents: usize,
    /// Dents in view that were not found.
    pub missed: usize,
    /// Asked depth, mean error, half its 95 % interval, mean absolute error, m, and how many.
    pub depths: Vec<[f64; 5]>,
    /// Median and 90 % of each, m and rad.
    pub centre_m: [f64; 2],
    pub direction_rad: [f64; 2],
    /// Median and 99 %.
    pub milliseconds: [f64; 2],
    pub unseen: unseen::Table,
}

impl Table {
    pub fn of(rows: &[Row]) -> Self {
        let undented: Vec<&Row> = rows.iter().filter(|row| row.asked_m == 0.0).collect();
        let dented: Vec<&Row> = rows.iter().filter(|row| row.is_dented()).collect();
        let found = || dented.iter().filter(|row| row.dents > 0);
        let spread = |values: Vec<f64>, high: f64| [at(&values, 0.5), at(&values, high)];
        Self {
            undented: undented.len(),
            dented: dented.len(),
            auroc: auroc(&undented, &dented),
            false_dents: undented.iter().filter(|row| row.dents > 0).count(),
            missed: dented.iter().filter(|row| row.dents == 0).count(),
            depths: [0.004, 0.008, 0.012]
                .map(|asked_m| depths(found().copied(), asked_m))
                .to_vec(),
            centre_m: spread(found().map(|row| row.centre_error_m).collect(), 0.9),
            direction_rad: spread(found().map(|row| row.direction_error_rad).collect(), 0.9),
            milliseconds: spread(rows.iter().map(|row| row.milliseconds).collect(), 0.99),
            unseen: unseen::Table::of(rows.iter().map(|row| &row.unseen)),
        }
    }
}

fn auroc(undented: &[&Row], dented: &[&Row]) -> f64 {
    let mut above = 0.0;
    for a in dented {
        for b in undented {
            above += match a.significance.total_cmp(&b.significance) {
                std::cmp::Ordering::Greater => 1.0,
                std::cmp::Ordering::Equal => 0.5,
                std::cmp::Ordering::Less => 0.0,
            };
        }
    }
    above / (dented.len() * undented.len()).max(1) as f64
}

fn depths<'a>(found: impl Iterator<Item = &'a Row>, asked_m: f64) -> [f64; 5] {
    let errors: Vec<f64> = found
        .filter(|row| (row.asked_m - asked_m).abs() < 1e-6)
        .map(|row| row.depth_m - row.truth_m)
        .collect();
    let count = errors.len() as f64;
    let bias_m = errors.iter().sum::<f64>() / count;
    let mean_m = errors.iter().map(|error| error.abs()).sum::<f64>() / count;
    let variance: f64 = errors.iter().map(|error| (error - bias_m).powi(2)).sum();
    let half_m = NORMAL_95 * (variance / (count - 1.0).max(1.0) / count).sqrt();
    [asked_m, bias_m, half_m, mean_m, count]
}

/// Two-sided, in standard deviations.
const NORMAL_95: f64 = 1.96;

/// 95 % interval of a share (Wilson, 1927), in words.
pub fn interval(count: usize, all: usize) -> String {
    let (n, share) = (all.max(1) as f64, count as f64 / all.max(1) as f64);
    let square = NORMAL_95 * NORMAL_95 / n;
    let middle = share + square / 2.0;
    let half = (share * (1.0 - share) * square + square * square / 4.0).sqrt();
    let percent = |value: f64| 100.0 * value.max(0.0) / (1.0 + square);
    format!(
        "{count} of {all} ({:.1} %, 95 %: {:.1} to {:.1} %)",
        100.0 * share,
        percent(middle - half),
        percent(middle + half)
    )
}

pub fn at(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = (share * sorted.len() as f64) as usize;
    sorted
        .get(place.min(sorted.len().saturating_sub(1)))
        .copied()
        .unwrap_or(f64::NAN)
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (undented, dented) = (self.undented, self.dented);
        writeln!(
            f,
            "{undented} undented, {dented} with a dent in view: AUROC {:.4}",
            self.auroc
        )?;
        writeln!(
            f,
            "undented with a dent: {}; dents missed: {}",
            interval(self.false_dents, undented),
            interval(self.missed, dented)
        )?;
        for [asked_m, bias_m, half_m, mean_m, count] in &self.depths {
            writeln!(
                f,
                "depth at {:.0} mm: bias {:+.2} ± {:.2} mm, mean error {:.2} mm ({count} scans)",
                1e3 * asked_m,
                1e3 * bias_m,
                1e3 * half_m,
                1e3 * mean_m
            )?;
        }
        let [median_m, high_m] = self.centre_m.map(|m| 1e3 * m);
        writeln!(f, "centre: median {median_m:.1} mm, 90 % {high_m:.1} mm")?;
        let [median, high] = self.direction_rad.map(f64::to_degrees);
        writeln!(f, "direction: median {median:.1} deg, 90 % {high:.1} deg")?;
        let [median, high] = self.milliseconds;
        writeln!(f, "time: median {median:.1} ms, 99 % {high:.1} ms")?;
        write!(f, "{}", self.unseen)
    }
}

/// A line of names and one for each row.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "class,seed,asked_mm,flattened,distance_m,truth_mm,depth_mm,dents,significance,centre_mm,direction_deg,seen,\
         rms_mm,ms,reason\n",
    );
    for row in rows {
        let millimetres = [row.truth_m, row.depth_m]
            .map(|m| format!("{:.2}", 1e3 * m))
            .join(",");
        text += &format!(
            "{},{},{},{},{:.3},{millimetres},{},{:.2},{:.1},{:.1},{:.2},{:.3},{:.1},{}\n",
            row.class,
            row.seed,
            1e3 * row.asked_m,
            row.flattened,
            row.distance_m,
            row.dents,
            row.significance,
            1e3 * row.centre_error_m,
            row.direction_error_rad.to_degrees(),
            row.seen_share,
            1e3 * row.rms_m,
            row.milliseconds,
            row.reason
        );
    }
    text
}
