//! Z-buffer rasteriser for triangle meshes and planes.
//!
//! Inverse depth is affine in image coordinates, so that interpolating it is exact (perspective
//! correct), and the nearest surface is the largest value.

use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

use crate::image::InverseDepth;
use crate::intrinsics::Intrinsics;
use crate::placement::Placement;
use crate::scene::Scene;
use mesh::Mesh;

/// Surfaces nearer than this are cut off.
const NEAR_M: f32 = 0.02;
/// Twice the area in square pixels below which a triangle covers nothing.
const AREA_MIN_PX2: f64 = 1e-12;

/// Renders scenes with one camera; its buffers are used again for each view.
pub struct Renderer {
    intrinsics: Intrinsics,
    target: InverseDepth,
    /// The current mesh's vertices in the optical frame and in the image.
    in_camera: Vec<Vector3<f32>>,
    in_image: Vec<Projected>,
}

impl Renderer {
    /// A renderer for one camera.
    pub fn new(intrinsics: Intrinsics) -> Self {
        let target = InverseDepth::empty(intrinsics.width as usize, intrinsics.height as usize);
        Self {
            intrinsics,
            target,
            in_camera: Vec::new(),
            in_image: Vec::new(),
        }
    }

    /// What was rendered last.
    pub fn last(&self) -> &InverseDepth {
        &self.target
    }

    /// What the camera sees, without noise.
    pub fn render(&mut self, scene: &Scene, placement: &Placement) -> &InverseDepth {
        self.target.per_m.fill(0.0);
        if let (Some(camera_from_base), Some(wall_x_m)) =
            (placement.camera_from_base, scene.wall_x_m)
        {
            let normal = camera_from_base * Vector3::x_axis();
            self.draw_plane(
                &(camera_from_base * Point3::new(wall_x_m, 0.0, 0.0)),
                &normal,
            );
        }
        for (link, camera_from_link) in scene.links.iter().zip(&placement.camera_from_links) {
            if let Some(camera_from_link) = camera_from_link {
                self.draw_mesh(&link.mesh, camera_from_link);
            }
        }
        self.draw_mesh(&scene.hand, &placement.camera_from_hand);
        &self.target
    }

    fn draw_mesh(&mut self, mesh: &Mesh, camera_from_mesh: &Isometry3<f64>) {
        let rotation: Matrix3<f32> = camera_from_mesh
            .rotation
            .to_rotation_matrix()
            .into_inner()
            .cast();
        let translation: Vector3<f32> = camera_from_mesh.translation.vector.cast();
        self.in_camera.clear();
        self.in_camera.extend(
            mesh.vertices
                .iter()
                .map(|v| rotation * v.coords + translation),
        );
        self.in_image.clear();
        self.in_image.extend(
            self.in_camera
                .iter()
                .map(|p| Projected::new(&self.intrinsics, p)),
        );
        for triangle in &mesh.triangles {
            let corners = triangle.map(|index| self.in_camera[index as usize]);
            let behind = corners.iter().filter(|p| p.z < NEAR_M).count();
            if behind == 0 {
                fill(
                    &mut self.target,
                    triangle.map(|index| self.in_image[index as usize]),
                );
            } else if behind < 3 {
                self.draw_clipped(&corners);
            }
        }
    }

    /// Draws the part of a triangle that lies beyond the near plane.
    fn draw_clipped(&mut self, corners: &[Vector3<f32>; 3]) {
        let mut kept: Vec<Projected> = Vec::with_capacity(4);
        for (k, a) in corners.iter().enumerate() {
            let b = &corners[(k + 1) % 3];
            if a.z >= NEAR_M {
                kept.push(Projected::new(&self.intrinsics, a));
            }
            if (a.z >= NEAR_M) != (b.z >= NEAR_M) {
                let mut cut = a + (b - a) * ((NEAR_M - a.z) / (b.z - a.z));
                cut.z = NEAR_M;
                kept.push(Projected::new(&self.intrinsics, &cut));
            }
        }
        for k in 2..kept.len() {
            fill(&mut self.target, [kept[0], kept[k - 1], kept[k]]);
        }
    }

    /// Draws an endless plane through a point, wherever it lies in front of the camera.
    fn draw_plane(&mut self, point: &Point3<f64>, normal: &Unit<Vector3<f64>>) {
        let distance_m = normal.dot(&point.coords);
        if distance_m == 0.0 {
            return;
        }
        // normal . z (x/z, y/z, 1) = distance, hence 1/z = (normal . ray) / distance.
        let along = normal.into_inner() / distance_m;
        let camera = &self.intrinsics;
        for (v, row) in self
            .target
            .per_m
            .chunks_exact_mut(self.target.width)
            .enumerate()
        {
            let at_row = along.y * (v as f64 - camera.cy) / camera.fy + along.z
                - along.x * camera.cx / camera.fx;
            let (start, step) = (at_row as f32, (along.x / camera.fx) as f32);
            for (u, pixel) in row.iter_mut().enumerate() {
                let per_m = start + step * u as f32;
                *pixel = if per_m < 1.0 / NEAR_M {
                    pixel.max(per_m)
                } else {
                    *pixel
                };
            }
        }
    }
}

/// A point in the image with its inverse depth. Meaningless where the depth is not positive.
#[derive(Debug, Clone, Copy)]
struct Projected {
    u: f64,
    v: f64,
    per_m: f64,
}

impl Projected {
    fn new(camera: &Intrinsics, point: &Vector3<f32>) -> Self {
        let per_m = 1.0 / f64::from(point.z);
        let u = camera.fx * f64::from(point.x) * per_m + camera.cx;
        let v = camera.fy * f64::from(point.y) * per_m + camera.cy;
        Self { u, v, per_m }
    }
}

/// Draws a triangle, both sides alike. A pixel is covered if its centre is inside or on the edge.
fn fill(target: &mut InverseDepth, [a, b, c]: [Projected; 3]) {
    let area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
    let top = a.v.min(b.v).min(c.v).ceil().max(0.0);
    let bottom =
        a.v.max(b.v)
            .max(c.v)
            .floor()
            .min(target.height as f64 - 1.0);
    if area.abs() < AREA_MIN_PX2 || top > bottom {
        return;
    }
    let step_u = ((b.per_m - a.per_m) * (c.v - a.v) - (c.per_m - a.per_m) * (b.v - a.v)) / area;
    let step_v = ((c.per_m - a.per_m) * (b.u - a.u) - (b.per_m - a.per_m) * (c.u - a.u)) / area;
    let least = a.per_m.min(b.per_m).min(c.per_m) as f32;
    let most = a.per_m.max(b.per_m).max(c.per_m) as f32;
    let edges = [Edge::new(&a, &b), Edge::new(&b, &c), Edge::new(&c, &a)];
    for v in top as usize..=bottom as usize {
        let Some((left, right)) = span(&edges, v as f64, target.width) else {
            continue;
        };
        let start = a.per_m + (left as f64 - a.u) * step_u + (v as f64 - a.v) * step_v;
        let (start, step) = (start as f32, step_u as f32);
        let row = &mut target.per_m[v * target.width..][left..=right];
        for (k, pixel) in row.iter_mut().enumerate() {
            // A sliver's slope is ill-conditioned; no pixel may leave the range of the corners.
            *pixel = pixel.max((start + step * k as f32).clamp(least, most));
        }
    }
}

/// Edge of a triangle in the image, from its upper to its lower end.
///
/// The order of the ends does not depend on the triangle, so that two neighbours compute the same
/// crossing and leave no gap between them.
struct Edge {
    upper: Projected,
    lower: Projected,
    slope: f64,
}

impl Edge {
    fn new(a: &Projected, b: &Projected) -> Self {
        let (upper, lower) = if (a.v, a.u) <= (b.v, b.u) {
            (*a, *b)
        } else {
            (*b, *a)
        };
        let height = lower.v - upper.v;
        let slope = if height > 0.0 {
            (lower.u - upper.u) / height
        } else {
            0.0
        };
        Self {
            upper,
            lower,
            slope,
        }
    }
}

/// First and last column that a triangle covers in row `v`, within the image.
fn span(edges: &[Edge; 3], v: f64, width: usize) -> Option<(usize, usize)> {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for edge in edges {
        if edge.upper.v <= v && v <= edge.lower.v {
            let crossing = edge.upper.u + (v - edge.upper.v) * edge.slope;
            let other = if edge.upper.v == edge.lower.v {
                edge.lower.u
            } else {
                crossing
            };
            left = left.min(crossing.min(other));
            right = right.max(crossing.max(other));
        }
    }
    let (left, right) = (left.ceil().max(0.0), right.floor().min(width as f64 - 1.0));
    (left <= right).then_some((left as usize, right as usize))
}

#[cfg(test)]
mod tests;
