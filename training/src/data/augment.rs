//! Data augmentation: random changes of a cloud that keep its class.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

/// Magnitudes of the changes. Each cloud is also turned by a uniformly random angle about the up axis and mirrored with
/// probability ½, since an object may be held in any of these ways.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Augmentation {
    /// Largest tilt away from upright.
    pub tilt_rad: f64,
    /// Standard deviation of the whole cloud's translation along each axis.
    pub shift_m: f64,
    /// Standard deviation of each point's translation along each axis.
    pub jitter_m: f64,
}

impl Default for Augmentation {
    fn default() -> Self {
        Self {
            tilt_rad: 0.03,
            shift_m: 0.001,
            jitter_m: 0.0005,
        }
    }
}

/// Changes one cloud in metres with up along z: points of three values, or of six with their normals.
pub fn augment(
    cloud: &mut [f32],
    columns: usize,
    augmentation: &Augmentation,
    random: &mut Pcg64Mcg,
) {
    let mut normal = |deviation: f64| {
        let value: f64 = StandardNormal.sample(random);
        (value * deviation) as f32
    };
    let shift = [0; 3].map(|_| normal(augmentation.shift_m));
    for point in cloud.chunks_exact_mut(columns) {
        for value in &mut point[..3] {
            *value += normal(augmentation.jitter_m);
        }
    }
    let turned = turn(augmentation.tilt_rad, random);
    for point in cloud.chunks_exact_mut(columns) {
        for vector in point.chunks_exact_mut(3) {
            vector.copy_from_slice(&turned([vector[0], vector[1], vector[2]]));
        }
        point
            .iter_mut()
            .zip(shift)
            .for_each(|(value, by)| *value += by);
    }
}

/// A random rotation about the up axis, tilt and mirroring, as a map of vectors.
fn turn(tilt_rad: f64, random: &mut Pcg64Mcg) -> impl Fn([f32; 3]) -> [f32; 3] {
    let turn_rad = random.random_range(0.0..std::f32::consts::TAU);
    let lean_rad = random.random_range(0.0..=tilt_rad) as f32;
    let mirror = if random.random() { -1.0 } else { 1.0 };
    let second_turn_rad = random.random_range(0.0..std::f32::consts::TAU);
    let (turn_sin, turn_cos) = turn_rad.sin_cos();
    let (lean_sin, lean_cos) = lean_rad.sin_cos();
    let (second_sin, second_cos) = second_turn_rad.sin_cos();
    move |[x, y, z]| {
        let (x, y) = (mirror * x, y);
        let (x, y) = (turn_cos * x - turn_sin * y, turn_sin * x + turn_cos * y);
        let (x, z) = (lean_cos * x + lean_sin * z, lean_cos * z - lean_sin * x);
        let (x, y) = (
            second_cos * x - second_sin * y,
            second_sin * x + second_cos * y,
        );
        [x, y, z]
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn rigid_changes_keep_lengths_and_nearly_keep_upright() {
        let augmentation = Augmentation {
            tilt_rad: 0.03,
            shift_m: 0.0,
            jitter_m: 0.0,
        };
        for seed in 0..100 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let mut cloud = [0.3, 0.4, 0.0, 0.0, 0.0, 1.0];
            augment(&mut cloud, 3, &augmentation, &mut random);
            let length = |p: &[f32]| (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            assert!(
                (length(&cloud[..3]) - 0.5).abs() < 1e-6,
                "seed {seed}: {cloud:?}"
            );
            assert!(
                (length(&cloud[3..]) - 1.0).abs() < 1e-6,
                "seed {seed}: {cloud:?}"
            );
            assert!(cloud[5] > 0.9995, "seed {seed}: {cloud:?}");
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_change() {
        let changed = |seed| {
            let mut cloud = [0.3, 0.4, 0.0, 0.0, 0.0, 1.0];
            augment(
                &mut cloud,
                3,
                &Augmentation::default(),
                &mut Pcg64Mcg::seed_from_u64(seed),
            );
            cloud
        };
        assert_eq!(changed(5), changed(5));
        assert_ne!(changed(5), changed(6));
    }

    #[test]
    fn normals_turn_with_their_points_and_stay_where_points_are_moved() {
        let augmentation = Augmentation {
            tilt_rad: 0.5,
            jitter_m: 0.0,
            ..Augmentation::default()
        };
        for seed in 0..100 {
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            // The normals are the steps from the first point to the others.
            let mut cloud = [
                0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.8, 0.0, 0.6, 0.8, 0.0, 0.0, 0.6, 0.8, 0.0,
                0.6, 0.8,
            ];
            augment(&mut cloud, 6, &augmentation, &mut random);
            for point in cloud.chunks_exact(6) {
                for axis in 0..3 {
                    let step = point[axis] - cloud[axis];
                    assert!(
                        (step - point[3 + axis]).abs() < 1e-6,
                        "seed {seed}: {cloud:?}"
                    );
                }
            }
        }
    }
}
