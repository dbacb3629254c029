//! Objects that are none of the eight: they test whether a classifier calls them unknown.

use std::f32::consts::TAU;
use std::fmt;

use mesh::{Mesh, revolve};
use nalgebra::{Point3, Vector3};

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

#[cfg(test)]
mod tests {
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
}
