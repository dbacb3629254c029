//! How well could any classifier tell the two small balls apart from what a held scan shows?
//!
//! For random scans of dented balls, the simulator's own likelihood gives how exactly width and height of the ball can be
//! known at best (the Cramér-Rao bound), when the dent's depth and height, the ball's pose in the hand and the error of
//! the camera mount are unknown as well. From that follows how often the best classifier is right. The bound is local: it
//! leaves out that quite another dent on a ball of another size could look the same.

mod scan;

use anyhow::Result;
use clap::Parser;
use nalgebra::{Matrix2, Vector2};
use rand::{Rng, RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use scan::Scan;
use sim_deform::{Denter, Settings};
use sim_objects::{ObjectClass, Variation};

/// Upper bound of how often a classifier can tell the two small balls apart (Cramér-Rao)
#[derive(Debug, Parser)]
struct Arguments {
    /// Scans of each ball
    #[arg(long, default_value_t = 50)]
    scans: u64,
    /// Seed of the first scan; the next one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

const BALLS: [ObjectClass; 2] = [ObjectClass::TinyBall, ObjectClass::SmallBall];
/// Views of a scan.
const VIEWS: usize = 3;
/// What the network gets of a large cloud: four samples of 128 points.
const NETWORK_POINTS: f64 = 512.0;

/// What is known about the dent.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Dent {
    Known,
    Unknown,
    /// As unknown that nothing can be learned from the surface that it has moved.
    Useless,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    println!(
        "best standard deviation of a ball's width and height, mm (median, and 90 % of scans are better than), and how often \
         the best classifier is right; {} scans of each ball from seed {}",
        arguments.scans, arguments.seed
    );
    let denters = BALLS.map(|ball| Denter::new(ball.mesh(&Variation::NONE), &Settings::default()));
    let [tiny, small] = denters;
    let denters = [tiny?, small?];
    let mut rows: Vec<(usize, Dent, Option<f64>, Vec<Covariance>)> = Vec::new();
    for points in [None, Some(NETWORK_POINTS)] {
        for views in [1, VIEWS] {
            for dent in [Dent::Known, Dent::Unknown, Dent::Useless] {
                rows.push((views, dent, points, Vec::new()));
            }
        }
    }
    for (index, denter) in denters.iter().enumerate() {
        for seed in (arguments.seed..).take(arguments.scans as usize) {
            let scan = Scan::random(index, denter, seed)?;
            for (views, dent, points, found) in &mut rows {
                found.push(scan.covariance(*views, *dent, *points));
            }
        }
    }
    for (views, dent, points, found) in rows {
        let sigmas = |axis: usize| {
            let mut sigmas: Vec<f64> = found
                .iter()
                .map(|found| 1e3 * found.of_size_m2[(axis, axis)].sqrt())
                .collect();
            sigmas.sort_by(f64::total_cmp);
            let at = |share: f64| sigmas[(share * (sigmas.len() - 1) as f64) as usize];
            format!("{:.2} ({:.2})", at(0.5), at(0.9))
        };
        let mut random = Pcg64Mcg::seed_from_u64(arguments.seed);
        let right = found.iter().map(|found| found.right(&mut random));
        let right: f64 = right.sum::<f64>() / found.len() as f64;
        println!(
            "{views} view(s), {}, dent {dent:?}: width {}, height {}, right {:.1} %",
            points.map_or("all pixels".to_owned(), |points| format!("{points} points")),
            sigmas(0),
            sigmas(1),
            100.0 * right
        );
    }
    Ok(())
}

/// How exactly the size of one specimen can be known.
struct Covariance {
    ball: usize,
    /// Of width and height.
    of_size_m2: Matrix2<f64>,
}

impl Covariance {
    /// How often the best classifier names balls of this kind rightly, both balls being as frequent.
    fn right(&self, random: &mut impl Rng) -> f64 {
        const DRAWS: usize = 200;
        let inverse = self.of_size_m2.try_inverse().unwrap_or_else(Matrix2::zeros);
        let spread = self
            .of_size_m2
            .cholesky()
            .map_or_else(Matrix2::zeros, |cholesky| cholesky.l());
        let mut right = 0;
        for _ in 0..DRAWS {
            let size = Variation::random(random.random());
            let noise: [f64; 2] = [(); 2].map(|()| StandardNormal.sample(random));
            let measured = actual_m(self.ball, &size) + spread * Vector2::from(noise);
            let log_likelihood = |ball: usize| -> f64 {
                let logs: Vec<f64> = sizes()
                    .map(|size| {
                        let off = actual_m(ball, &size) - measured;
                        -0.5 * (off.transpose() * inverse * off)[0]
                    })
                    .collect();
                let most = logs.iter().copied().fold(f64::MIN, f64::max);
                most + logs.iter().map(|log| (log - most).exp()).sum::<f64>().ln()
            };
            right += usize::from(log_likelihood(self.ball) > log_likelihood(1 - self.ball));
        }
        right as f64 / DRAWS as f64
    }
}

fn actual_m(ball: usize, size: &Variation) -> Vector2<f64> {
    let [width_m, height_m] = BALLS[ball].size_m();
    Vector2::new(
        f64::from(width_m * size.width_scale),
        f64::from(height_m * size.height_scale),
    )
}

/// All sizes that specimens have, evenly.
fn sizes() -> impl Iterator<Item = Variation> {
    const STEPS: i32 = 10;
    let scale = |step: i32| 1.0 + 0.01 * step as f32 / STEPS as f32;
    (-STEPS..=STEPS).flat_map(move |width| {
        (-STEPS..=STEPS).map(move |height| Variation {
            width_scale: scale(width),
            height_scale: scale(height),
        })
    })
}
