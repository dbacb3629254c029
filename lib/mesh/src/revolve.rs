//! The surface that an outline makes when it turns about z.

use std::f32::consts::TAU;

use nalgebra::Point3;

use crate::mesh::Mesh;

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

impl Mesh {
    /// Closed cylinder about z between two heights, in metres.
    pub fn cylinder(radius_m: f32, z_min_m: f32, z_max_m: f32, segments: usize) -> Self {
        let outline_m = [
            [0.0, z_min_m],
            [radius_m, z_min_m],
            [radius_m, z_max_m],
            [0.0, z_max_m],
        ];
        revolve(&outline_m, segments)
    }
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
