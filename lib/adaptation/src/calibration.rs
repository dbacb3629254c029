//! Calibration: probabilities that match the frequency of right answers.

/// What is believed of a number before there is data, as if so many clouds had said so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prior {
    /// The number.
    pub value: f64,
    /// How many clouds it counts for.
    pub clouds: f64,
}

/// Temperature scaling (Guo et al. 2017): the factor 1/T of logits `[M][C]` that minimises the cross-entropy with the labels.
/// 1 without clouds.
///
/// If every answer is right, the plain cross-entropy has no minimum: it falls with every larger factor. Therefore the
/// targets are smoothed as in Platt scaling (Platt 1999, Sec. 2.2): the label gets (M + 1) / (M + 2), and the rest is spread
/// over the other classes.
pub fn inverse_temperature(logits: &[Vec<f32>], labels: &[usize]) -> f64 {
    let nothing = Prior {
        value: 1.0,
        clouds: 0.0,
    };
    inverse_temperature_near(logits, labels, nothing)
}

/// The same where the factor was another one before: its logarithm is normally distributed about that one's, and so
/// narrowly that the clouds of the prior count as much as others. That of the prior without clouds.
pub fn inverse_temperature_near(logits: &[Vec<f32>], labels: &[usize], prior: Prior) -> f64 {
    let others_share = 1.0 / (logits.len() as f64 + 2.0);
    // The loss is convex in the factor, so its derivative has one zero, which bisection finds.
    let slope = |factor: f64| -> f64 {
        let pairs = logits.iter().zip(labels);
        let of_clouds: f64 = pairs
            .map(|(logits, &label)| slope_of(logits, label, others_share, factor))
            .sum();
        of_clouds + prior.clouds * (factor / prior.value).ln() / factor
    };
    let (mut low, mut high) = (0.05_f64, 20.0_f64);
    if logits.is_empty() {
        return prior.value;
    }
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if slope(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low * high).sqrt()
}

/// The threshold that `share_kept` of the values reach, for values from a validation set; 0 without values.
pub fn threshold_keeping(mut values: Vec<f64>, share_kept: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let below = ((1.0 - share_kept) * values.len() as f64).floor() as usize;
    values.get(below).copied().unwrap_or(0.0)
}

/// The same, but so high that at most `strangers_share` of the strangers' values reach it, too.
pub fn threshold_between(
    known: Vec<f64>,
    share_kept: f64,
    mut strangers: Vec<f64>,
    strangers_share: f64,
) -> f64 {
    let keeping = threshold_keeping(known, share_kept);
    strangers.sort_by(|a, b| b.total_cmp(a));
    let passing = (strangers_share * strangers.len() as f64).floor() as usize;
    match strangers.get(passing) {
        // The next larger number, since what equals the threshold reaches it.
        Some(stranger) => keeping.max(stranger.next_up()),
        None => keeping,
    }
}

/// Derivative of the cross-entropy of softmax(factor · logits) with respect to the factor: the expected logit under these
/// probabilities minus that under the target, which gives `others_share` to the classes that are not the label.
fn slope_of(logits: &[f32], label: usize, others_share: f64, factor: f64) -> f64 {
    let highest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let (mut sum, mut weighted) = (0.0, 0.0);
    for &logit in logits {
        let weight = (factor * f64::from(logit - highest)).exp();
        sum += weight;
        weighted += weight * f64::from(logit);
    }
    let own = f64::from(logits[label]);
    let all: f64 = logits.iter().copied().map(f64::from).sum();
    let others = (all - own) / (logits.len().max(2) - 1) as f64;
    weighted / sum - (own + others_share * (others - own))
}

/// The log of the sum of exponentials.
pub fn log_sum_exp(logits: &[f32]) -> f64 {
    let highest = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let sum: f64 = logits.iter().map(|l| f64::from(l - highest).exp()).sum();
    f64::from(highest) + sum.ln()
}

/// The largest of `[C]` log-probabilities as a probability.
pub fn highest_probability(log_probabilities: &[f32]) -> f64 {
    let highest = log_probabilities
        .iter()
        .copied()
        .fold(f32::NEG_INFINITY, f32::max);
    f64::from(highest).exp()
}

/// Expected calibration error (Naeini et al. 2015) of (probability, right?) in 15 bins of equal width: the mean difference
/// between a bin's average probability and its share of right answers. 0 without answers.
pub fn calibration_error(judged: &[(f64, bool)]) -> f64 {
    const BINS: usize = 15;
    let mut bins = [(0.0, 0.0); BINS];
    for &(probability, right) in judged {
        let bin = ((probability * BINS as f64) as usize).min(BINS - 1);
        bins[bin].0 += probability;
        bins[bin].1 += f64::from(u8::from(right));
    }
    let distance: f64 = bins.iter().map(|(said, right)| (said - right).abs()).sum();
    distance / judged.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    fn probabilities(logits: &[f32], factor: f64) -> Vec<f64> {
        let raw: Vec<f64> = logits
            .iter()
            .map(|&l| (factor * f64::from(l)).exp())
            .collect();
        let sum: f64 = raw.iter().sum();
        raw.into_iter().map(|value| value / sum).collect()
    }

    /// Logits, and labels drawn from the probabilities that `factor` makes of them.
    fn drawn(factor: f64, seed: u64) -> (Vec<Vec<f32>>, Vec<usize>) {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        (0..20_000)
            .map(|_| {
                let logits: Vec<f32> = (0..4).map(|_| random.random_range(-3.0..3.0)).collect();
                let mut left: f64 = random.random();
                let mut label = 0;
                for probability in probabilities(&logits, factor) {
                    left -= probability;
                    label += usize::from(left > 0.0);
                }
                (logits, label.min(3))
            })
            .unzip()
    }

    #[test]
    fn the_temperature_is_found_again() {
        for (factor, seed) in [(0.5, 1), (1.0, 2), (3.0, 3)] {
            let (logits, labels) = drawn(factor, seed);
            let found = inverse_temperature(&logits, &labels);
            assert!(
                (found / factor - 1.0).abs() < 0.05,
                "seed {seed}: {found} of {factor}"
            );
        }
        assert_eq!(inverse_temperature(&[], &[]), 1.0);
    }

    #[test]
    fn a_prior_counts_for_its_clouds() {
        let (logits, labels) = drawn(2.0, 5);
        let near = |count: usize, clouds| {
            let prior = Prior { value: 0.5, clouds };
            inverse_temperature_near(&logits[..count], &labels[..count], prior)
        };
        assert_eq!(near(0, 100.0), 0.5);
        assert!((near(20_000, 100.0) / 2.0 - 1.0).abs() < 0.1);
        assert!((near(10, 1e6) / 0.5 - 1.0).abs() < 0.01);
        let between = near(50, 50.0);
        assert!((0.5..2.5).contains(&between), "{between}");
    }

    #[test]
    fn a_threshold_keeps_its_share() {
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        let threshold = threshold_keeping(values.clone(), 0.95);
        assert_eq!(
            values.iter().filter(|&&value| value >= threshold).count(),
            95
        );
        assert_eq!(threshold_keeping(Vec::new(), 0.95), 0.0);
        let strangers = |most: f64| (0..20).map(|k| most - f64::from(k)).collect::<Vec<_>>();
        assert_eq!(
            threshold_between(values.clone(), 0.95, strangers(0.0), 0.1),
            threshold
        );
        assert_eq!(
            threshold_between(values.clone(), 0.95, Vec::new(), 0.1),
            threshold
        );
        let high = threshold_between(values, 0.95, strangers(60.0), 0.1);
        assert_eq!(
            strangers(60.0)
                .iter()
                .filter(|&&value| value >= high)
                .count(),
            2
        );
    }

    #[test]
    fn right_answers_about_few_clouds_do_not_make_a_model_certain() {
        for count in [1, 30, 300] {
            let logits = vec![vec![4.0, -1.0, -1.0, -1.0]; count];
            let factor = inverse_temperature(&logits, &vec![0; count]);
            let found = probabilities(&logits[0], factor)[0];
            let expected = (count as f64 + 1.0) / (count as f64 + 2.0);
            assert!((found - expected).abs() < 1e-3, "{count} clouds: {found}");
        }
    }

    #[test]
    fn scaled_probabilities_are_calibrated_and_overconfident_ones_are_not() {
        let (logits, labels) = drawn(0.5, 4);
        let error_with = |factor| {
            let judge = |(logits, &label): (&Vec<f32>, &usize)| {
                let probabilities = probabilities(logits, factor);
                let best = (0..4).max_by(|&a, &b| probabilities[a].total_cmp(&probabilities[b]));
                let best = best.unwrap_or(0);
                (probabilities[best], best == label)
            };
            calibration_error(&logits.iter().zip(&labels).map(judge).collect::<Vec<_>>())
        };
        assert!(error_with(0.5) < 0.02, "{}", error_with(0.5));
        assert!(error_with(2.0) > 0.2, "{}", error_with(2.0));
        assert_eq!(calibration_error(&[]), 0.0);
    }
}
