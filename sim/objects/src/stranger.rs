//! Objects that are none of the eight: what a classifier must call unknown.
//!
//! Random solids teach it what else there is; the named ones, of other makes, test what it learned.

use std::f32::consts::TAU;
use std::fmt;

use nalgebra::{Point3, Vector3};
use rand::{Rng, RngExt};

use crate::class::ObjectClass;
use crate::mesh::Mesh;
use crate::profile::revolve;
use crate::variation::Variation;

/// Household objects that are none of the eight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stranger {
    /// Milk carton, 60 x 60 x 115 mm.
    Carton,
    /// Funnel upside down, 90 x 110 mm.
    Cone,
    /// Bottle with a neck, 66 x 180 mm.
    Bottle,
    /// Wine glass, 70 x 150 mm.
    Goblet,
    /// Bowl, 120 x 55 mm.
    Bowl,
    /// Ring standing upright, 110 mm.
    Ring,
    /// Mug with a handle, 80 x 95 mm.
    Mug,
    /// Banana standing on one end, 150 mm.
    Banana,
}

impl Stranger {
    /// All of them.
    pub const ALL: [Stranger; 8] = [
        Stranger::Carton,
        Stranger::Cone,
        Stranger::Bottle,
        Stranger::Goblet,
        Stranger::Bowl,
        Stranger::Ring,
        Stranger::Mug,
        Stranger::Banana,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Stranger::Carton => "carton",
            Stranger::Cone => "cone",
            Stranger::Bottle => "bottle",
            Stranger::Goblet => "goblet",
            Stranger::Bowl => "bowl",
            Stranger::Ring => "ring",
            Stranger::Mug => "mug",
            Stranger::Banana => "banana",
        }
    }

    /// Its surface in the object frame.
    pub fn mesh(self) -> Mesh {
        let turned = |outline_mm: &[[f32; 2]]| {
            let outline_m: Vec<_> = outline_mm.iter().map(|p| p.map(|mm| mm / 1000.0)).collect();
            revolve(&outline_m, SEGMENTS)
        };
        let mesh = match self {
            Stranger::Carton => Mesh::cuboid(
                Point3::new(-0.03, -0.03, 0.0),
                Point3::new(0.03, 0.03, 0.115),
            ),
            Stranger::Cone => turned(&[[0.0, 0.0], [45.0, 0.0], [6.0, 110.0], [0.0, 110.0]]),
            Stranger::Bottle => turned(BOTTLE_MM),
            Stranger::Goblet => turned(GOBLET_MM),
            Stranger::Bowl => turned(BOWL_MM),
            Stranger::Ring => tube(0.011, |t| {
                let (sin, cos) = (TAU * t).sin_cos();
                Point3::new(0.044 * sin, 0.0, 0.055 - 0.044 * cos)
            }),
            Stranger::Mug => {
                let mut mug = turned(MUG_MM);
                mug.append(&tube(0.006, |t| {
                    let (sin, cos) = (0.5 * TAU * t).sin_cos();
                    Point3::new(0.038 + 0.028 * sin, 0.0, 0.048 - 0.028 * cos)
                }));
                mug
            }
            Stranger::Banana => tube(0.018, |t| {
                let (sin, cos) = (0.3 * TAU * (t - 0.5)).sin_cos();
                Point3::new(0.09 * cos, 0.0, 0.09 * sin)
            }),
        };
        mesh.stood_up()
    }
}

impl fmt::Display for Stranger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

const SEGMENTS: usize = 48;

const BOTTLE_MM: &[[f32; 2]] = &[
    [0.0, 0.0],
    [31.0, 0.0],
    [33.0, 3.0],
    [33.0, 105.0],
    [30.0, 122.0],
    [20.0, 140.0],
    [14.0, 155.0],
    [13.5, 180.0],
    [0.0, 180.0],
];

const GOBLET_MM: &[[f32; 2]] = &[
    [0.0, 0.0],
    [32.0, 0.0],
    [30.0, 3.0],
    [6.0, 8.0],
    [4.5, 60.0],
    [20.0, 72.0],
    [32.0, 90.0],
    [35.0, 112.0],
    [31.0, 150.0],
    [30.0, 150.0],
    [33.5, 112.0],
    [30.0, 91.0],
    [19.0, 74.0],
    [0.0, 70.0],
];

const BOWL_MM: &[[f32; 2]] = &[
    [0.0, 0.0],
    [28.0, 0.0],
    [45.0, 16.0],
    [57.0, 38.0],
    [60.0, 55.0],
    [57.5, 55.0],
    [54.5, 39.0],
    [43.0, 19.0],
    [27.0, 4.0],
    [0.0, 3.5],
];

const MUG_MM: &[[f32; 2]] = &[
    [0.0, 0.0],
    [38.0, 0.0],
    [40.0, 3.0],
    [40.0, 95.0],
    [36.5, 95.0],
    [36.5, 6.0],
    [0.0, 5.0],
];

/// A round tube along a path given by a number from 0 to 1, with closed ends.
fn tube(radius_m: f32, path: impl Fn(f32) -> Point3<f32>) -> Mesh {
    const STEPS: usize = 48;
    let outline: Vec<[f32; 2]> = (0..=STEPS)
        .map(|step| [1.0, step as f32 / STEPS as f32])
        .collect();
    let ends = [[0.0, 0.0]].into_iter().chain(outline).chain([[0.0, 1.0]]);
    let mut mesh = revolve(&ends.collect::<Vec<_>>(), SEGMENTS / 2);
    for vertex in &mut mesh.vertices {
        let along = (path(vertex.z + 1e-3) - path(vertex.z - 1e-3)).normalize();
        let across = Vector3::y();
        *vertex = path(vertex.z) + radius_m * (vertex.x * across + vertex.y * along.cross(&across));
    }
    mesh
}

/// A random solid in the object frame, 3 to 20 cm high, that none of the eight is as large as on all three sides: a random
/// outline turned about z, with a random cross-section.
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
    let extent = |mesh: &Mesh| {
        let (min, max) = mesh.bounds();
        max - min
    };
    let (own, other) = (extent(mesh), extent(&class.mesh(&Variation::NONE)));
    (0..3).all(|axis| (own[axis] / other[axis] - 1.0).abs() < ALIKE)
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
    fn strangers_stand_on_their_bottom_and_are_closed() {
        for stranger in Stranger::ALL {
            let mesh = stranger.mesh();
            assert!(mesh.is_closed_manifold(), "{stranger}");
            let (min, max) = mesh.bounds();
            assert!(min.z.abs() < 1e-6, "{stranger}: {min}");
            assert!((0.05..0.19).contains(&max.z), "{stranger}: {max}");
        }
    }

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
