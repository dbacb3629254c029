//! Small differences in size between two objects of one make.

use mesh::Mesh;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Largest relative deviation of a width or height from the traced object's.
const SPREAD: f32 = 0.01;

/// Factors from the traced object's size to a specimen's, each within 1 ± 1 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variation {
    /// Factor of the widths (x and y alike).
    pub width_scale: f32,
    /// Factor of the height.
    pub height_scale: f32,
}

impl Variation {
    /// The traced object's own size.
    pub const NONE: Variation = Variation {
        width_scale: 1.0,
        height_scale: 1.0,
    };

    /// A specimen drawn from `seed`.
    pub fn random(seed: u64) -> Self {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut scale = || 1.0 + rng.random_range(-SPREAD..=SPREAD);
        Self {
            width_scale: scale(),
            height_scale: scale(),
        }
    }

    /// Scales a mesh of the traced object's size.
    pub fn apply(&self, mesh: &mut Mesh) {
        for vertex in &mut mesh.vertices {
            vertex.x *= self.width_scale;
            vertex.y *= self.width_scale;
            vertex.z *= self.height_scale;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ObjectClass;

    #[test]
    fn specimens_differ_within_one_percent_and_repeat() {
        let first = Variation::random(0);
        for seed in 0..200 {
            let variation = Variation::random(seed);
            assert_eq!(variation, Variation::random(seed));
            for scale in [variation.width_scale, variation.height_scale] {
                assert!((scale - 1.0).abs() <= SPREAD + 1e-6, "seed {seed}: {scale}");
            }
            assert!(seed == 0 || variation != first, "seed {seed}");
        }
        let mesh = ObjectClass::SmallBall.mesh(&first);
        assert_eq!(mesh, ObjectClass::SmallBall.mesh(&first));
    }
}
