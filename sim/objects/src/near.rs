//! Strangers that are nearly one of the eight: a can beside a can, a cup beside a cup, a ball beside a ball.

use std::fmt;

use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};

use crate::class::ObjectClass;
use crate::variation::Variation;

/// How much a stranger's size differs from that of the class nearest to it: the larger of the differences of width and
/// height, as a share. One class's own specimens differ by up to 1 %.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Difference {
    /// 2 to 5 %: about 1 to 3 mm of a ball's or can's width.
    To5,
    /// 5 to 10 %.
    To10,
    /// 10 to 20 %.
    To20,
}

/// Which widths may be drawn, so that a classifier is not tested on objects that it was trained to refuse: widths are
/// dealt out in stripes of 1 % of the class's width.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instances {
    /// Those to learn from.
    Training,
    /// Those to test on.
    Test,
}

const STRIPE: f32 = 0.01;

impl Difference {
    /// All of them, the hardest first.
    pub const ALL: [Difference; 3] = [Difference::To5, Difference::To10, Difference::To20];

    /// Least and largest difference.
    pub fn range(self) -> [f32; 2] {
        match self {
            Difference::To5 => [0.02, 0.05],
            Difference::To10 => [0.05, 0.10],
            Difference::To20 => [0.10, 0.20],
        }
    }

    fn contains(self, difference: f32) -> bool {
        let [least, largest] = self.range();
        (least..largest).contains(&difference)
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, largest] = self.range().map(|share| (100.0 * share).round());
        write!(f, "{least} to {largest} % off")
    }
}

/// An object of the kind of a class and of another size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearStranger {
    /// Whose form it has.
    pub class: ObjectClass,
    /// Its size against that class's.
    pub size: Variation,
}

impl NearStranger {
    /// One that differs so much from each of the eight, and so little from one. Balls stay as round as they are.
    pub fn random(difference: Difference, instances: Instances, random: &mut impl Rng) -> Self {
        let [least, largest] = difference.range();
        loop {
            let class = *ObjectClass::ALL
                .choose(random)
                .unwrap_or(&ObjectClass::MediumCan);
            let sign = if random.random_bool(0.5) { 1.0 } else { -1.0 };
            let most = sign * random.random_range(least..largest);
            let [width, height] = if class.is_hollow() {
                let other = most * random.random_range(-1.0..1.0);
                if random.random_bool(0.5) {
                    [most, other]
                } else {
                    [other, most]
                }
            } else {
                [most; 2]
            };
            let stranger = Self {
                class,
                size: Variation {
                    width_scale: 1.0 + width,
                    height_scale: 1.0 + height,
                },
            };
            if difference.contains(stranger.difference()) && stranger.is_of(instances) {
                return stranger;
            }
        }
    }

    /// From the class whose size is most like its own, whatever its form.
    pub fn difference(&self) -> f32 {
        let [width_m, height_m] = self.class.size_m();
        let own = [
            width_m * self.size.width_scale,
            height_m * self.size.height_scale,
        ];
        let from = |class: ObjectClass| {
            let pairs = own.into_iter().zip(class.size_m());
            pairs
                .map(|(own, other)| (own / other - 1.0).abs())
                .fold(0.0, f32::max)
        };
        ObjectClass::ALL
            .into_iter()
            .map(from)
            .fold(f32::MAX, f32::min)
    }

    fn is_of(&self, instances: Instances) -> bool {
        let stripe = ((self.size.width_scale - 1.0) / STRIPE).floor() as i64;
        (stripe.rem_euclid(2) == 0) == (instances == Instances::Test)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    use super::*;

    #[test]
    fn near_strangers_are_as_near_as_said_and_none_is_learned_and_tested() {
        let seed = 5;
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        for difference in Difference::ALL {
            let mut classes = Vec::new();
            for index in 0..400 {
                let instances = [Instances::Training, Instances::Test][index % 2];
                let stranger = NearStranger::random(difference, instances, &mut random);
                assert!(difference.contains(stranger.difference()), "{stranger:?}");
                assert!(
                    stranger.is_of(instances)
                        && !stranger.is_of([Instances::Test, Instances::Training][index % 2])
                );
                assert!(
                    stranger.class.is_hollow()
                        || stranger.size.width_scale == stranger.size.height_scale
                );
                // What is measured on the mesh is what was asked for.
                let (min, max) = stranger.class.mesh(&stranger.size).bounds();
                let [width_m, height_m] = stranger.class.size_m();
                assert!(
                    ((max.x - min.x) / width_m - stranger.size.width_scale).abs() < 1e-3,
                    "{stranger:?}"
                );
                assert!(
                    (max.z / height_m - stranger.size.height_scale).abs() < 1e-3,
                    "{stranger:?}"
                );
                classes.push(stranger.class);
            }
            // 2 to 5 % off tiny-ball or small-ball upward is often nearer to the other one, but never always.
            for class in ObjectClass::ALL {
                assert!(classes.contains(&class), "{class}, {difference}");
            }
        }
    }
}
