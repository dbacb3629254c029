//! The facet that a thin wall gets when it is pressed against something flat: as broad as the object, unlike the dents
//! of fingers.

use std::f32::consts::FRAC_PI_2;

use mesh::Mesh;
use nalgebra::Point3;
use rand::{Rng, RngExt};

/// One facet on the side of an object that stands about the z axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flattening {
    /// Direction from the axis to the facet's middle, about z from x.
    pub towards_rad: f32,
    /// How far its middle lies inside of the object's largest radius before, m.
    pub depth_m: f32,
    /// Height of its middle, m.
    pub middle_m: f32,
    /// Half its height: from its middle up or down to where the wall is unchanged, m.
    pub reach_m: f32,
}

/// Springback: share of the wall's former height above the facet's plane that remains.
const LEFT: f32 = 0.08;
/// Share of the difference between arc and chord by which the wall on the facet's side widens; the rest widens the far side.
const YIELD: f32 = 0.6;

impl Flattening {
    /// A random facet of depth `depth_m` on an object of height `height_m`, both in m; the object's ends stay unchanged.
    pub fn random(depth_m: f32, height_m: f32, random: &mut impl Rng) -> Self {
        let middle_m = height_m * random.random_range(0.3..0.7);
        Self {
            towards_rad: random.random_range(0.0..std::f32::consts::TAU),
            depth_m,
            middle_m,
            reach_m: middle_m.min(height_m - middle_m) * random.random_range(0.6..1.0),
        }
    }

    /// Presses the facet in: moves the wall outside its plane onto the plane and widens it sideways, because a wall bends
    /// but does not shrink. The girth of a round object stays nearly the same. Inner and outer face of a wall come closer
    /// to each other; where they are less than a millimetre apart, as in a cup, their triangles may intersect, by less
    /// than a depth camera resolves.
    pub fn apply(&self, mesh: &mut Mesh) {
        let (sin, cos) = self.towards_rad.sin_cos();
        let out = |v: &Point3<f32>| cos * v.x + sin * v.y;
        let widest_m = mesh.vertices.iter().map(out).fold(0.0, f32::max);
        for vertex in &mut mesh.vertices {
            let plane_m = widest_m - self.depth_at(vertex.z);
            let radius_m = vertex.x.hypot(vertex.y);
            if plane_m <= 0.0 || radius_m <= plane_m {
                continue;
            }
            let (mut out_m, mut side_m) = (out(vertex), cos * vertex.y - sin * vertex.x);
            // The arc that the plane cuts off is longer than its chord.
            let arc_m = radius_m * (plane_m / radius_m).acos();
            let chord_m = (radius_m * radius_m - plane_m * plane_m).sqrt();
            side_m *= 1.0 + YIELD * (arc_m - chord_m) / radius_m;
            if out_m > plane_m {
                out_m = plane_m + LEFT * (out_m - plane_m);
            }
            (vertex.x, vertex.y) = (cos * out_m - sin * side_m, sin * out_m + cos * side_m);
        }
    }

    /// Depth at a height, m: `depth_m` in the middle, 0 at both ends, smooth in between.
    fn depth_at(&self, height_m: f32) -> f32 {
        let share = ((height_m - self.middle_m) / self.reach_m).clamp(-1.0, 1.0);
        self.depth_m * (FRAC_PI_2 * share).cos().powi(2)
    }
}

#[cfg(test)]
mod tests;
