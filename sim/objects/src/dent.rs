//! Two opposing dents, as the fingers of a gripper press them.

use nalgebra::Vector2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::mesh::Mesh;

/// Deepest dent. The surface stays free of folds on the narrowest object up to here.
pub const SQUEEZE_MAX_M: f64 = 0.015;

/// Everything below is left alone entirely at the bottom and free to move here.
const FOOT_M: f32 = 0.020;
/// How far from its height the radius under a finger is looked for.
const NEAR_M: f32 = 0.010;

/// A dent that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DentError {
    /// The depth is not a number, negative or too large.
    #[error("squeeze is {squeeze_m} m: expected 0 to {SQUEEZE_MAX_M} m")]
    Squeeze {
        /// What was asked for.
        squeeze_m: f64,
    },
}

/// Presses two opposite sides of an upright object inward by `squeeze_m` metres each.
///
/// Height, direction and width of the two fingers come from `seed`. The bottom stays where it is, no
/// vertex moves outward, and the triangles stay the same. A squeeze of 0 changes nothing.
///
/// # Errors
/// [`DentError::Squeeze`] where `squeeze_m` is not within 0 to [`SQUEEZE_MAX_M`].
pub fn dent(mesh: &Mesh, squeeze_m: f64, seed: u64) -> Result<Mesh, DentError> {
    if !(0.0..=SQUEEZE_MAX_M).contains(&squeeze_m) {
        return Err(DentError::Squeeze { squeeze_m });
    }
    let mut dented = mesh.clone();
    if squeeze_m > 0.0 && !mesh.vertices.is_empty() {
        let fingers = Fingers::random(mesh, seed);
        for vertex in &mut dented.vertices {
            let shift = fingers.shift(vertex.coords.xy(), vertex.z) * squeeze_m as f32;
            vertex.x += shift.x;
            vertex.y += shift.y;
        }
    }
    Ok(dented)
}

/// Two fingers that press against each other along `direction` at `height_m`.
struct Fingers {
    direction: Vector2<f32>,
    height_m: f32,
    /// Standard deviations of the pressed area, sideways and upward.
    reach_side_m: f32,
    reach_up_m: f32,
    /// Distance of the surface from the axis at that height.
    radius_m: f32,
}

impl Fingers {
    fn random(mesh: &Mesh, seed: u64) -> Self {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let azimuth_rad: f32 = rng.random_range(0.0..std::f32::consts::PI);
        let height_m = mesh.bounds().1.z * rng.random_range(0.35..0.75);
        Self {
            direction: Vector2::new(azimuth_rad.cos(), azimuth_rad.sin()),
            height_m,
            reach_side_m: rng.random_range(0.012..0.018),
            reach_up_m: rng.random_range(0.012..0.020),
            radius_m: radius_at(mesh, height_m),
        }
    }

    /// Displacement of a point (x, y, height) for a squeeze of one metre.
    fn shift(&self, point: Vector2<f32>, height_m: f32) -> Vector2<f32> {
        let along_m = self.direction.dot(&point);
        let aside_m = self.direction.perp(&point);
        let weight = bell(aside_m, self.reach_side_m)
            * bell(height_m - self.height_m, self.reach_up_m)
            * smooth_step(height_m / FOOT_M)
            * smooth_step(along_m.abs() / self.radius_m);
        -along_m.signum() * weight * self.direction
    }
}

fn radius_at(mesh: &Mesh, height_m: f32) -> f32 {
    mesh.vertices
        .iter()
        .filter(|v| (v.z - height_m).abs() < NEAR_M)
        .map(|v| v.x.hypot(v.y))
        .fold(NEAR_M, f32::max)
}

fn bell(distance_m: f32, deviation_m: f32) -> f32 {
    (-0.5 * (distance_m / deviation_m).powi(2)).exp()
}

fn smooth_step(share: f32) -> f32 {
    let t = share.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{ObjectClass, Variation};

    #[test]
    fn zero_squeeze_is_the_identity() {
        for class in ObjectClass::ALL {
            let mesh = class.mesh(&Variation::NONE);
            assert_eq!(dent(&mesh, 0.0, 3).unwrap(), mesh);
        }
    }

    #[test]
    fn same_seed_gives_the_same_bytes_and_another_seed_does_not() {
        let mesh = ObjectClass::MediumCan.mesh(&Variation::NONE);
        let dented = dent(&mesh, 0.008, 11).unwrap();
        assert_eq!(dented, dent(&mesh, 0.008, 11).unwrap());
        assert_ne!(dented, dent(&mesh, 0.008, 12).unwrap());
    }

    #[test]
    fn a_dent_moves_two_opposite_sides_inward_and_leaves_the_bottom() {
        let squeeze_m = 0.010;
        for class in ObjectClass::ALL {
            for seed in 0..20 {
                let mesh = class.mesh(&Variation::NONE);
                let dented = dent(&mesh, squeeze_m, seed).unwrap();
                let mut deepest_m = [0.0_f32; 2];
                for (before, after) in mesh.vertices.iter().zip(&dented.vertices) {
                    let moved = after - before;
                    let inward_m = -moved.xy().dot(&before.coords.xy());
                    assert!(
                        inward_m >= -1e-9,
                        "{class}, seed {seed}: {before} moved outward"
                    );
                    assert_eq!(before.z, after.z);
                    assert!(before.z > 0.0 || moved.norm() == 0.0);
                    let side = usize::from(moved.y > 0.0 || moved.y == 0.0 && moved.x > 0.0);
                    deepest_m[side] = deepest_m[side].max(moved.norm());
                }
                for depth_m in deepest_m {
                    let share = depth_m / squeeze_m as f32;
                    assert!(
                        (0.85..1.001).contains(&share),
                        "{class}, seed {seed}: {depth_m} m"
                    );
                }
            }
        }
    }

    #[test]
    fn the_deepest_dent_keeps_the_mesh_closed_and_unfolded() {
        for class in ObjectClass::ALL {
            for seed in 0..20 {
                let mesh = class.mesh(&Variation::NONE);
                let fingers = Fingers::random(&mesh, seed);
                let dented = dent(&mesh, SQUEEZE_MAX_M, seed).unwrap();
                assert!(dented.is_closed_manifold());
                assert!(
                    dented.volume_m3() < mesh.volume_m3(),
                    "{class}, seed {seed}"
                );
                // Along the fingers' line the order of points must stay: no fold.
                let mut last_m = 0.0;
                for k in 0..=100 {
                    let point = fingers.direction * (fingers.radius_m * k as f32 / 100.0);
                    let shift = fingers.shift(point, fingers.height_m) * SQUEEZE_MAX_M as f32;
                    let place_m = fingers.direction.dot(&(point + shift));
                    assert!(place_m >= last_m, "{class}, seed {seed}: folds at {k} %");
                    last_m = place_m;
                }
            }
        }
    }

    #[test]
    fn an_impossible_squeeze_is_refused_by_value() {
        let mesh = ObjectClass::TinyBall.mesh(&Variation::NONE);
        for squeeze_m in [-0.001, 0.0151, f64::NAN, f64::INFINITY] {
            let text = dent(&mesh, squeeze_m, 0).unwrap_err().to_string();
            assert!(
                text.contains(&squeeze_m.to_string()) && text.contains("0.015"),
                "{text}"
            );
        }
    }
}
