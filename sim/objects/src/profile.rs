//! Outlines of the objects, and the surface that an outline makes when it turns about z.
//!
//! Radii by height were measured on scans of the real objects; what a scanner cannot see (the inside
//! of a cup, the bottom of a can) follows the usual make of such objects.

use std::f32::consts::TAU;

use nalgebra::Point3;

use crate::class::ObjectClass;
use crate::mesh::Mesh;

/// Points round the axis. A multiple of four, so that the widest ring reaches the exact extent on x and y.
pub(crate) const SEGMENTS: usize = 64;
/// Longest step along an outline.
const STEP_M: f32 = 0.006;
const BALL_RINGS: usize = 48;

/// Closed outline (radius, height) in metres, from the axis at the bottom, outward and up, to the axis again.
pub(crate) fn of(class: ObjectClass) -> Vec<[f32; 2]> {
    match class {
        ObjectClass::MediumCan => subdivided(MEDIUM_CAN_MM),
        ObjectClass::FoodCan => subdivided(&food_can_mm()),
        ObjectClass::SmallCup => subdivided(SMALL_CUP_MM),
        ObjectClass::MediumCup => subdivided(MEDIUM_CUP_MM),
        ObjectClass::LargeCup => subdivided(LARGE_CUP_MM),
        ObjectClass::TinyBall => ball(TINY_BALL_MM),
        ObjectClass::SmallBall => ball(SMALL_BALL_MM),
        ObjectClass::MediumBall => ball(MEDIUM_BALL_MM),
    }
}

/// Surface of revolution about z of an outline of (radius, height) in metres.
///
/// The outline starts and ends on the axis (radius 0) and keeps the solid on its left when it goes
/// from the bottom outward and up; then the mesh is closed and its triangles face outward.
pub fn revolve(outline_m: &[[f32; 2]], segments: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let rings: Vec<Ring> = outline_m
        .iter()
        .map(|&point| Ring::add(&mut mesh, point, segments))
        .collect();
    for pair in rings.windows(2) {
        for j in 0..segments {
            let next = (j + 1) % segments;
            let [low, low_next] = [pair[0].index(j), pair[0].index(next)];
            let [high, high_next] = [pair[1].index(j), pair[1].index(next)];
            if low != low_next {
                mesh.triangles.push([low, low_next, high_next]);
            }
            if high != high_next {
                mesh.triangles.push([low, high_next, high]);
            }
        }
    }
    mesh
}

/// The vertices of one outline point: a full turn of them, or one on the axis.
struct Ring {
    first: u32,
    on_axis: bool,
}

impl Ring {
    fn add(mesh: &mut Mesh, [radius_m, height_m]: [f32; 2], segments: usize) -> Self {
        let ring = Ring {
            first: mesh.vertices.len() as u32,
            on_axis: radius_m <= 0.0,
        };
        let count = if ring.on_axis { 1 } else { segments };
        mesh.vertices.extend((0..count).map(|j| {
            let (sin, cos) = (TAU * j as f32 / segments as f32).sin_cos();
            Point3::new(radius_m * cos, radius_m * sin, height_m)
        }));
        ring
    }

    fn index(&self, j: usize) -> u32 {
        if self.on_axis {
            self.first
        } else {
            self.first + j as u32
        }
    }
}

fn subdivided(outline_mm: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let metres = |p: [f32; 2]| p.map(|length_mm| length_mm / 1000.0);
    let mut outline_m = vec![metres(outline_mm[0])];
    for pair in outline_mm.windows(2) {
        let [a, b] = [metres(pair[0]), metres(pair[1])];
        let steps = ((b[0] - a[0]).hypot(b[1] - a[1]) / STEP_M).ceil().max(1.0);
        outline_m.extend((1..=steps as usize).map(|k| {
            let share = k as f32 / steps;
            [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
        }));
    }
    outline_m
}

/// The outline of a ball from its radii by angle (degrees) from the top; straight between them, on the axis at both ends.
fn ball(radii_mm: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let radius_m = |degrees: f32| {
        let after = radii_mm.partition_point(|entry| entry[0] <= degrees);
        let [from, to] = [after - 1, after.min(radii_mm.len() - 1)].map(|index| radii_mm[index]);
        let share = (degrees - from[0]) / (to[0] - from[0]).max(1.0);
        (from[1] + share * (to[1] - from[1])) / 1000.0
    };
    let below_m = radius_m(180.0);
    let inner = (1..BALL_RINGS).map(|k| {
        let degrees = 180.0 - 180.0 * k as f32 / BALL_RINGS as f32;
        let (sin, cos) = degrees.to_radians().sin_cos();
        [radius_m(degrees) * sin, below_m + radius_m(degrees) * cos]
    });
    std::iter::once([0.0, 0.0])
        .chain(inner)
        .chain([[0.0, below_m + radius_m(0.0)]])
        .collect()
}

/// Foam basketball, with the foot that the scanner's stand has left.
const TINY_BALL_MM: &[[f32; 2]] = &[
    [0.0, 32.1],
    [15.0, 31.3],
    [25.0, 31.0],
    [45.0, 30.76],
    [65.0, 30.65],
    [85.0, 30.6],
    [95.0, 30.6],
    [115.0, 30.67],
    [135.0, 30.88],
    [149.0, 30.95],
    [157.5, 34.1],
    [161.0, 33.4],
    [165.0, 32.75],
    [170.0, 32.1],
    [175.0, 31.76],
    [180.0, 31.7],
];

/// Tennis ball, with a foot like the other's.
const SMALL_BALL_MM: &[[f32; 2]] = &[
    [0.0, 32.6],
    [15.0, 32.5],
    [35.0, 32.15],
    [55.0, 31.96],
    [85.0, 32.0],
    [95.0, 32.0],
    [115.0, 32.02],
    [149.0, 32.1],
    [157.5, 34.6],
    [161.0, 33.85],
    [165.0, 33.2],
    [170.0, 32.5],
    [175.0, 32.18],
    [180.0, 32.1],
];

/// Foam ball with a flat that it stands on.
const MEDIUM_BALL_MM: &[[f32; 2]] = &[
    [0.0, 48.4],
    [15.0, 48.2],
    [25.0, 48.9],
    [35.0, 48.9],
    [65.0, 48.4],
    [75.0, 48.45],
    [90.0, 48.7],
    [125.0, 48.75],
    [135.0, 48.4],
    [145.0, 46.1],
    [155.0, 43.3],
    [165.0, 41.9],
    [180.0, 41.6],
];

/// Drawn aluminium can: domed bottom inside a foot ring, long neck, seam, recessed lid.
const MEDIUM_CAN_MM: &[[f32; 2]] = &[
    [0.0, 10.0],
    [8.0, 9.3],
    [15.0, 7.2],
    [21.0, 3.8],
    [24.0, 1.0],
    [26.0, 0.0],
    [28.0, 0.2],
    [31.0, 1.0],
    [31.9, 4.0],
    [32.45, 6.0],
    [32.75, 8.5],
    [32.75, 102.0],
    [32.4, 104.5],
    [31.4, 107.0],
    [30.1, 110.0],
    [28.6, 113.0],
    [27.1, 116.0],
    [26.4, 118.0],
    [26.4, 122.0],
    [26.0, 124.0],
    [25.6, 126.4],
    [25.1, 127.4],
    [24.3, 127.2],
    [23.8, 126.0],
    [23.2, 121.5],
    [21.8, 121.0],
    [20.8, 122.3],
    [0.0, 122.6],
];

/// Welded tin: seams at both ends, beads round the body, recessed ends.
fn food_can_mm() -> Vec<[f32; 2]> {
    const BODY_MM: f32 = 36.6;
    const BEAD_DEPTH_MM: f32 = 0.7;
    const BEADS: usize = 12;
    const BEADS_FROM_MM: f32 = 28.0;
    const BEADS_TO_MM: f32 = 92.0;
    let mut outline = vec![
        [0.0, 3.2],
        [34.4, 3.0],
        [35.0, 0.6],
        [35.7, 0.0],
        [36.9, 0.4],
    ];
    outline.extend([[37.1, 2.8], [36.0, 4.2], [36.4, 7.0], [BODY_MM, 9.0]]);
    let pitch_mm = (BEADS_TO_MM - BEADS_FROM_MM) / (2 * BEADS) as f32;
    outline.extend((0..=2 * BEADS).map(|k| {
        let depth_mm = if k % 2 == 1 { BEAD_DEPTH_MM } else { 0.0 };
        [BODY_MM - depth_mm, BEADS_FROM_MM + pitch_mm * k as f32]
    }));
    outline.extend([
        [BODY_MM, 110.0],
        [36.5, 113.8],
        [37.6, 114.6],
        [37.95, 115.6],
    ]);
    outline.extend([
        [37.8, 117.9],
        [37.0, 118.5],
        [36.0, 118.3],
        [35.3, 117.5],
        [34.8, 114.4],
    ]);
    outline.extend([[33.0, 114.2], [31.5, 115.0], [0.0, 115.0]]);
    outline
}

/// Paper cup: skirt round a raised bottom, straight taper, rolled rim.
const SMALL_CUP_MM: &[[f32; 2]] = &[
    [0.0, 8.0],
    [27.4, 8.0],
    [27.1, 0.2],
    [27.6, 0.0],
    [28.5, 0.2],
    [41.3, 98.6],
    [42.2, 98.9],
    [43.6, 99.2],
    [44.25, 100.6],
    [44.0, 102.0],
    [43.0, 102.8],
    [41.9, 102.9],
    [40.9, 102.2],
    [40.6, 100.8],
    [28.8, 10.0],
    [27.6, 9.0],
    [0.0, 9.0],
];

/// Plastic cup: rounded foot with a slightly raised bottom, taper, lip turned in.
const MEDIUM_CUP_MM: &[[f32; 2]] = &[
    [0.0, 3.0],
    [20.0, 2.6],
    [22.5, 0.4],
    [24.0, 0.0],
    [26.0, 0.5],
    [27.8, 3.6],
    [29.0, 6.0],
    [29.8, 8.5],
    [30.4, 12.0],
    [30.9, 17.5],
    [32.5, 32.0],
    [34.2, 48.0],
    [35.9, 64.0],
    [37.6, 80.0],
    [39.2, 96.0],
    [41.2, 115.5],
    [41.7, 119.8],
    [41.4, 122.2],
    [40.8, 124.4],
    [40.4, 126.2],
    [39.9, 126.7],
    [39.4, 126.3],
    [39.6, 124.0],
    [40.2, 119.0],
    [38.2, 96.0],
    [33.2, 48.0],
    [29.9, 18.0],
    [28.6, 9.0],
    [26.5, 5.0],
    [23.0, 4.2],
    [0.0, 4.2],
];

/// Drinks cup: short foot, shallow step, long straight taper, lip turned in.
const LARGE_CUP_MM: &[[f32; 2]] = &[
    [0.0, 4.0],
    [30.0, 4.0],
    [31.5, 0.3],
    [32.3, 0.0],
    [33.3, 0.3],
    [33.6, 3.0],
    [34.5, 5.5],
    [35.4, 8.8],
    [36.1, 13.0],
    [36.6, 24.0],
    [44.0, 153.0],
    [44.35, 159.8],
    [44.2, 162.2],
    [43.8, 165.2],
    [43.5, 168.5],
    [43.3, 170.6],
    [42.8, 171.1],
    [42.3, 170.6],
    [42.6, 165.0],
    [43.1, 159.0],
    [42.9, 153.0],
    [35.5, 24.0],
    [35.0, 14.0],
    [33.5, 7.0],
    [31.5, 5.4],
    [0.0, 5.2],
];
