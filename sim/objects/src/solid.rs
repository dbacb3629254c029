//! Random solids. A classifier learns from them to call objects other than the eight unknown.

use mesh::{Mesh, revolve};
use rand::{Rng, RngExt};

use crate::class::ObjectClass;
use crate::family::beyond;

const SEGMENTS: usize = 48;

/// A random solid in the object frame, 3 to 20 cm high: a random outline turned about z, with a random cross-section. Solids
/// with nearly the same extents as instances of one of the eight objects are drawn again.
pub fn random_solid(random: &mut impl Rng) -> Mesh {
    loop {
        let mesh = solid(random);
        if !ObjectClass::ALL
            .into_iter()
            .any(|class| is_as_large(&mesh, class))
        {
            return mesh;
        }
    }
}

fn is_as_large(mesh: &Mesh, class: ObjectClass) -> bool {
    const ALIKE: f32 = 0.06;
    let (min, max) = mesh.bounds();
    let extent_m = max - min;
    let [width_m, height_m] = class.size_range_m();
    [width_m, width_m, height_m]
        .into_iter()
        .enumerate()
        .all(|(axis, range_m)| beyond(extent_m[axis], range_m) < ALIKE)
}

fn solid(random: &mut impl Rng) -> Mesh {
    let height_m = random.random_range(0.03..0.20);
    let radius_m = random.random_range(0.012..0.06);
    let knots: Vec<f32> = (0..random.random_range(2..=6))
        .map(|_| radius_m * random.random_range(0.4..1.2))
        .collect();
    let section = Section::random(random);
    const STEPS: usize = 24;
    let outline: Vec<[f32; 2]> = (0..=STEPS)
        .map(|step| {
            let share = step as f32 / STEPS as f32;
            let place = share * (knots.len() - 1) as f32;
            let below = (place as usize).min(knots.len() - 2);
            let between = place - below as f32;
            let radius_m = knots[below] + between * (knots[below + 1] - knots[below]);
            [radius_m, height_m * share]
        })
        .collect();
    let ends = [[0.0, 0.0]].into_iter().chain(outline);
    let mut mesh = revolve(&ends.chain([[0.0, height_m]]).collect::<Vec<_>>(), SEGMENTS);
    for vertex in &mut mesh.vertices {
        let scale = section.radius(vertex.y.atan2(vertex.x));
        (vertex.x, vertex.y) = (scale * vertex.x, scale * vertex.y);
    }
    mesh
}

/// Radius by angle, at most about 1.
enum Section {
    Round,
    /// |x|^power + |y / flatness|^power = 1: from an ellipse to nearly a box.
    Superellipse {
        power: f32,
        flatness: f32,
    },
    Lobes {
        count: f32,
        depth: f32,
    },
}

impl Section {
    fn random(random: &mut impl Rng) -> Self {
        match random.random_range(0..10) {
            0..3 => Self::Round,
            3..7 => Self::Superellipse {
                power: random.random_range(2.0..10.0),
                flatness: random.random_range(0.35..1.0),
            },
            _ => Self::Lobes {
                count: random.random_range(2..=6) as f32,
                depth: random.random_range(0.05..0.3),
            },
        }
    }

    fn radius(&self, angle_rad: f32) -> f32 {
        match *self {
            Self::Round => 1.0,
            Self::Superellipse { power, flatness } => {
                let (sin, cos) = angle_rad.sin_cos();
                (cos.abs().powf(power) + (sin / flatness).abs().powf(power)).powf(-1.0 / power)
            }
            Self::Lobes { count, depth } => 1.0 - depth * (1.0 - (count * angle_rad).cos()) / 2.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    use super::*;

    #[test]
    fn random_solids_are_closed_differ_and_are_none_of_the_eight() {
        let seed = 3;
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let solids: Vec<Mesh> = (0..50).map(|_| random_solid(&mut random)).collect();
        for (index, solid) in solids.iter().enumerate() {
            assert!(
                solid.is_closed_manifold() && solid.volume_m3() > 0.0,
                "solid {index}"
            );
            assert!(solids[..index].iter().all(|other| other != solid));
            assert!(
                !ObjectClass::ALL
                    .into_iter()
                    .any(|class| is_as_large(solid, class))
            );
        }
    }
}
