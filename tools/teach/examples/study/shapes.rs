//! Objects that are in no list of this package, as meshes that can be dented.

use mesh::{Mesh, revolve};
use nalgebra::Point3;

/// Points round the axis.
const SEGMENTS: usize = 64;
/// Longest step along an outline, mm.
const STEP_MM: f32 = 5.0;

/// An outline (radius, height) in mm, with a square cross-section or a round one.
struct Shape {
    name: &'static str,
    outline_mm: &'static [[f32; 2]],
    section: Section,
}

#[derive(Clone, Copy)]
enum Section {
    Round,
    /// |x|^8 + |y / flatness|^8 = 1: a box with round edges.
    Box {
        flatness: f32,
    },
    Hexagon,
}

const SHAPES: [Shape; 12] = [
    Shape {
        name: "jar",
        outline_mm: &[
            [0.0, 0.0],
            [42.0, 0.0],
            [42.0, 65.0],
            [30.0, 82.0],
            [30.0, 105.0],
            [0.0, 105.0],
        ],
        section: Section::Round,
    },
    Shape {
        name: "spool",
        outline_mm: &[
            [0.0, 0.0],
            [42.0, 0.0],
            [42.0, 20.0],
            [25.0, 45.0],
            [25.0, 75.0],
            [42.0, 100.0],
            [42.0, 120.0],
            [0.0, 120.0],
        ],
        section: Section::Round,
    },
    Shape {
        name: "carton",
        outline_mm: &[[0.0, 0.0], [36.0, 0.0], [36.0, 150.0], [0.0, 150.0]],
        section: Section::Box { flatness: 1.0 },
    },
    Shape {
        name: "bottle",
        outline_mm: &[
            [0.0, 0.0],
            [28.0, 0.0],
            [28.0, 90.0],
            [12.0, 130.0],
            [12.0, 165.0],
            [0.0, 165.0],
        ],
        section: Section::Round,
    },
    Shape {
        name: "box",
        outline_mm: &[[0.0, 0.0], [45.0, 0.0], [45.0, 80.0], [0.0, 80.0]],
        section: Section::Box { flatness: 0.55 },
    },
    Shape {
        name: "bowl",
        outline_mm: &[
            [0.0, 0.0],
            [25.0, 0.0],
            [42.0, 20.0],
            [52.0, 45.0],
            [53.0, 65.0],
            [50.0, 65.0],
            [49.0, 46.0],
            [40.0, 23.0],
            [24.0, 4.0],
            [0.0, 4.0],
        ],
        section: Section::Round,
    },
    Shape {
        name: "tube",
        outline_mm: &[[0.0, 0.0], [20.0, 0.0], [20.0, 175.0], [0.0, 175.0]],
        section: Section::Round,
    },
    Shape {
        name: "tin",
        outline_mm: &[[0.0, 0.0], [50.0, 0.0], [50.0, 50.0], [0.0, 50.0]],
        section: Section::Round,
    },
    Shape {
        name: "hexagon",
        outline_mm: &[[0.0, 0.0], [40.0, 0.0], [40.0, 110.0], [0.0, 110.0]],
        section: Section::Hexagon,
    },
    Shape {
        name: "pear",
        outline_mm: &[
            [0.0, 0.0],
            [18.0, 2.0],
            [34.0, 14.0],
            [40.0, 32.0],
            [36.0, 52.0],
            [24.0, 72.0],
            [17.0, 90.0],
            [10.0, 100.0],
            [0.0, 103.0],
        ],
        section: Section::Round,
    },
    Shape {
        name: "flowerpot",
        outline_mm: &[
            [0.0, 0.0],
            [28.0, 0.0],
            [46.0, 75.0],
            [50.0, 77.0],
            [50.0, 95.0],
            [0.0, 95.0],
        ],
        section: Section::Round,
    },
    Shape {
        name: "flask",
        outline_mm: &[
            [0.0, 0.0],
            [40.0, 0.0],
            [40.0, 130.0],
            [20.0, 150.0],
            [0.0, 150.0],
        ],
        section: Section::Box { flatness: 0.5 },
    },
];

/// Names and meshes, the names in the order in which they are taught.
pub fn all() -> Vec<(&'static str, Mesh)> {
    SHAPES
        .iter()
        .map(|shape| (shape.name, shape.mesh()))
        .collect()
}

impl Shape {
    fn mesh(&self) -> Mesh {
        let mut outline_m = vec![self.outline_mm[0].map(|mm| mm / 1000.0)];
        for pair in self.outline_mm.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let steps = ((b[0] - a[0]).hypot(b[1] - a[1]) / STEP_MM).ceil().max(1.0);
            outline_m.extend((1..=steps as usize).map(|k| {
                let share = k as f32 / steps;
                [0, 1].map(|axis| (a[axis] + share * (b[axis] - a[axis])) / 1000.0)
            }));
        }
        let mut mesh = revolve(&outline_m, SEGMENTS);
        for vertex in &mut mesh.vertices {
            let scale = self.section.radius(vertex.y.atan2(vertex.x));
            *vertex = Point3::new(scale * vertex.x, scale * vertex.y, vertex.z);
        }
        mesh
    }
}

impl Section {
    /// Radius by angle, at most about 1.
    fn radius(self, angle_rad: f32) -> f32 {
        match self {
            Self::Round => 1.0,
            Self::Box { flatness } => {
                let (sin, cos) = angle_rad.sin_cos();
                (cos.abs().powf(8.0) + (sin / flatness).abs().powf(8.0)).powf(-1.0 / 8.0)
            }
            Self::Hexagon => {
                let sixth = std::f32::consts::FRAC_PI_3;
                let within = angle_rad.rem_euclid(sixth) - 0.5 * sixth;
                (0.5 * sixth).cos() / within.cos()
            }
        }
    }
}
