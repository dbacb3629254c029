use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;

const FEATURES: usize = 5;
const HIDDEN: usize = 4;

fn random_head(classes: usize, random: &mut Pcg64Mcg) -> Head {
    let mut layer = |inputs, outputs| Layer {
        weight: DMatrix::from_fn(inputs, outputs, |_, _| random.random_range(-1.0..1.0)),
        bias: DVector::from_fn(outputs, |_, _| random.random_range(-0.5..0.5)),
    };
    Head {
        hidden: layer(FEATURES, HIDDEN),
        last: layer(HIDDEN, classes),
    }
}

/// Clouds about a place of each class, and strangers anywhere.
fn random_features(classes: usize, random: &mut Pcg64Mcg) -> (Vec<FeatureRows>, FeatureRows) {
    let mut rows = |centre: [f32; FEATURES], spread: f32, count| {
        let mut rows = FeatureRows::new(FEATURES);
        for _ in 0..count {
            let row = centre.map(|middle| middle + random.random_range(-spread..spread));
            rows.push(&row);
        }
        rows
    };
    let centre = |class: usize| std::array::from_fn(|k| if k == class { 2.0 } else { 0.5 });
    let known = (0..classes)
        .map(|class| rows(centre(class), 0.8, 40 + 30 * class))
        .collect();
    (known, rows([1.0; FEATURES], 2.0, 90))
}

fn settings(change: Change) -> FitSettings {
    FitSettings {
        change,
        prior: 1e-2,
        prior_of_new: 1e-2,
        steps: 2000,
        ..FitSettings::default()
    }
}

#[test]
fn gradients_are_those_of_differences() {
    for (change, seed) in [(Change::Last, 1), (Change::Both, 2)] {
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let head = random_head(3, &mut random);
        let (known, strangers) = random_features(3, &mut random);
        let problem = Problem::new(&head, &known, &strangers, &settings(change));
        let at = problem.start.map(|value| value + 0.1);
        let (_, gradient) = problem.loss(&at);
        for index in 0..at.len() {
            const STEP: f64 = 1e-6;
            let mut beside = [at.clone(), at.clone()];
            beside[0][index] -= STEP;
            beside[1][index] += STEP;
            let [low, high] = beside.map(|at| problem.loss(&at).0);
            let difference = (high - low) / (2.0 * STEP);
            assert!(
                (gradient[index] - difference).abs() < 1e-7,
                "{index}: {difference}"
            );
        }
    }
}

#[test]
fn the_last_layer_is_where_plain_gradient_descent_ends() {
    let seed = 3;
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let head = random_head(2, &mut random).with_class();
    let (known, strangers) = random_features(3, &mut random);
    let settings = settings(Change::Last);
    let fitted = fit(&head, &known, &strangers, &settings, |_| true);
    let problem = Problem::new(&head, &known, &strangers, &settings);
    let mut at = problem.start.clone();
    for _ in 0..8_000 {
        at -= 0.4 * problem.loss(&at).1;
    }
    let slow = problem.head_at(&at);
    assert_eq!(fitted.hidden, head.hidden);
    let off = (&fitted.last.weight - &slow.last.weight).amax();
    assert!(off < 1e-3, "{off}");
    assert!((&fitted.last.bias - &slow.last.bias).amax() < 1e-3);
}

#[test]
fn a_new_class_is_told_from_the_old_ones_and_from_strangers() {
    // A prior that lets the clouds decide.
    let weak = |change| FitSettings {
        prior: 1e-5,
        prior_of_new: 1e-5,
        ..settings(change)
    };
    for (change, seed) in [(Change::Last, 4), (Change::Both, 5)] {
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let (known, strangers) = random_features(3, &mut random);
        let two = fit(
            &random_head(2, &mut random),
            &known[..2],
            &strangers,
            &weak(change),
            |_| true,
        );
        let three = fit(&two.with_class(), &known, &strangers, &weak(change), |_| {
            true
        });
        let share_right = |class: usize| {
            let logits = three.logits(&known[class].matrix());
            let right = logits.row_iter().filter(|row| {
                let own = row[class];
                own > 0.0 && row.iter().all(|&other| other <= own)
            });
            right.count() as f64 / known[class].len() as f64
        };
        for class in 0..3 {
            assert!(
                share_right(class) > 0.5,
                "{change:?} {class}: {}",
                share_right(class)
            );
        }
        assert_eq!(three.without_class(2).classes(), 2);
    }
}

#[test]
fn a_strong_prior_keeps_what_was() {
    let mut random = Pcg64Mcg::seed_from_u64(6);
    let head = random_head(3, &mut random);
    let (known, strangers) = random_features(3, &mut random);
    let strong = FitSettings {
        prior: 1e9,
        prior_of_new: 1e-2,
        ..settings(Change::Both)
    };
    let fitted = fit(&head, &known, &strangers, &strong, |_| true);
    assert!((&fitted.hidden.weight - &head.hidden.weight).amax() < 1e-6);
    let off = &fitted.last.weight - &head.last.weight;
    assert!(off.columns(0, 2).amax() < 1e-6);
    assert!(off.column(2).amax() > 1e-3, "the new class is free");
}
