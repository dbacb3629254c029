//! Random solids. A classifier learns from them to call objects other than the eight unknown.

use mesh::{Mesh, revolve};
use rand::{Rng, RngExt};

use crate::class::ObjectClass;
use crate::family::beyond;

const SEGMENTS: usize = 48;

/// A random solid in the object frame, 3 to 20 cm high: a random outline turned about z, with a random cross-section. One in four
/// is bent, and a smaller one, such as a handle, is joined to the side of one in four. Solids with nearly the same extents as
/// instances of one of the eight objects are drawn again.
pub fn random_solid(random: &mut impl Rng) -> Mesh {
    loop {
        let mesh = composed(random);
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

fn composed(random: &mut impl Rng) -> Mesh {
    let mut mesh = solid(random);
    if random.random_bool(0.25) {
        bend(&mut mesh, random);
    }
    if random.random_bool(0.25) {
        join_beside(&mut mesh, random);
    }
    mesh.stood_up()
}

/// Bends the axis to a parabola towards +x, by up to a third of the height.
fn bend(mesh: &mut Mesh, random: &mut impl Rng) {
    let height_m = mesh.bounds().1.z;
    let bow_m = height_m * random.random_range(0.05..0.33);
    for vertex in &mut mesh.vertices {
        let from_middle = 2.0 * vertex.z / height_m - 1.0;
        vertex.x -= bow_m * from_middle * from_middle;
    }
}

/// Adds a solid of a fifth to a half of the size to the side, somewhere along the height.
fn join_beside(mesh: &mut Mesh, random: &mut impl Rng) {
    let (min, max) = mesh.bounds();
    let mut part = solid(random);
    let scale = random.random_range(0.2..0.5);
    let height_m = scale * part.bounds().1.z;
    let z_m = random.random_range(0.0..=(max.z - height_m).max(0.0));
    let x_m = max.x * random.random_range(0.8..1.1);
    for vertex in &mut part.vertices {
        *vertex = vertex.coords.scale(scale).into();
        vertex.x += x_m;
        vertex.y += 0.5 * (min.y + max.y);
        vertex.z += z_m;
    }
    mesh.append(&part);
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
