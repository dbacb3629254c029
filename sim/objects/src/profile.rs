//! The surface that an outline makes when it turns about z.

use std::f32::consts::TAU;

use nalgebra::Point3;

use crate::mesh::Mesh;

/// Points round the axis. A multiple of four, so that the widest ring reaches the exact extent on x and y.
pub(crate) const SEGMENTS: usize = 64;
/// Longest step along an outline.
const STEP_M: f32 = 0.006;
const BALL_RINGS: usize = 48;

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

/// A closed outline (radius, height) in metres of corners in millimetres, with more points between them.
pub(crate) fn subdivided(outline_mm: &[[f32; 2]]) -> Vec<[f32; 2]> {
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
pub(crate) fn ball(radii_mm: &[[f32; 2]]) -> Vec<[f32; 2]> {
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
