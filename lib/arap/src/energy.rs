//! The energy of Eq. 3, its gradient with respect to the rotations, and the right-hand side for the positions.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use crate::one_ring::OneRings;

/// A unit quaternion: real part, then the imaginary ones.
pub(super) type Quaternion = [f64; 4];

/// A rotation at each vertex.
#[derive(Debug, Clone)]
pub(super) struct Rotations {
    quaternions: Vec<Quaternion>,
    /// R − I for each rotation R: small rotations keep their full precision this way.
    excess: Vec<Matrix3<f64>>,
}

impl Rotations {
    /// No rotation anywhere.
    pub fn identity(count: usize) -> Self {
        Self {
            quaternions: vec![[1.0, 0.0, 0.0, 0.0]; count],
            excess: vec![Matrix3::zeros(); count],
        }
    }

    /// Sets each rotation to that of `from`, followed by a rotation about the vector `scale`·`turns[i]` (axis times angle
    /// in radians, to third order; see [`turn_on`]).
    pub fn set_turned(&mut self, from: &Self, turns: &[Vector3<f64>], scale: f64) {
        let turned = from
            .quaternions
            .iter()
            .zip(turns)
            .map(|(from, turn)| turn_on(from, &(turn * scale)));
        for ((quaternion, excess), turned) in self
            .quaternions
            .iter_mut()
            .zip(&mut self.excess)
            .zip(turned)
        {
            (*quaternion, *excess) = (turned, excess_of(&turned));
        }
    }

    /// The turns that `set_turned` needs to come from `from` to these rotations.
    pub fn turns_from(&self, from: &Self) -> Vec<Vector3<f64>> {
        let pairs = self.quaternions.iter().zip(&from.quaternions);
        pairs
            .map(|(to, from)| {
                let real: f64 = (0..4).map(|k| to[k] * from[k]).sum();
                imaginary_of_quotient(to, from) * (2.0 / real)
            })
            .collect()
    }
}

/// Multiplies `from` by the normalised quaternion (1, turn/2). This retraction agrees with the exponential map of `turn`
/// to third order, needs no sine, and rotates by less than 180° however long `turn` is.
fn turn_on(from: &Quaternion, turn: &Vector3<f64>) -> Quaternion {
    let [w, x, y, z] = *from;
    let half = turn / 2.0;
    let turned = [
        w - half.x * x - half.y * y - half.z * z,
        x + half.x * w + half.y * z - half.z * y,
        y + half.y * w + half.z * x - half.x * z,
        z + half.z * w + half.x * y - half.y * x,
    ];
    let norm = turned.iter().map(|part| part * part).sum::<f64>().sqrt();
    turned.map(|part| part / norm)
}

/// Imaginary part of a·b⁻¹ for a unit quaternion b.
fn imaginary_of_quotient(a: &Quaternion, b: &Quaternion) -> Vector3<f64> {
    let (a_imaginary, b_imaginary) = (
        Vector3::new(a[1], a[2], a[3]),
        Vector3::new(b[1], b[2], b[3]),
    );
    a_imaginary * b[0] - b_imaginary * a[0] - a_imaginary.cross(&b_imaginary)
}

fn excess_of(&[w, x, y, z]: &Quaternion) -> Matrix3<f64> {
    Matrix3::new(
        -(y * y + z * z),
        x * y - w * z,
        x * z + w * y,
        x * y + w * z,
        -(x * x + z * z),
        y * z - w * x,
        x * z - w * y,
        y * z + w * x,
        -(x * x + y * y),
    ) * 2.0
}

/// What does not change while a mesh deforms: its one-rings with cotangent weights, and its rest positions.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    pub rings: OneRings,
    pub rest_m: Vec<Vector3<f64>>,
    /// α·S(M) of Eq. 3.
    pub smoothing_m2: f64,
}

impl Surface {
    /// Right-hand side of ARAP's global step, for displacements: Σⱼ wᵢⱼ/2 · ((Rᵢ−I) + (Rⱼ−I)) · (vᵢ−vⱼ) for each vertex i.
    pub fn pulls(&self, rotations: &Rotations, pulls: &mut [[f64; 4]]) {
        in_parts(pulls, |vertex, pull| {
            let (place, own) = (self.rest_m[vertex], rotations.excess[vertex]);
            let mut sum = Vector3::zeros();
            for (neighbour, weight) in self.rings.of(vertex) {
                let edge = place - self.rest_m[neighbour];
                sum += (own + rotations.excess[neighbour]) * edge * (weight / 2.0);
            }
            *pull = [sum.x, sum.y, sum.z, 0.0];
            0.0
        });
    }

    /// Returns the energy in m² of the displaced vertices with these rotations. Writes its derivative with respect to a
    /// further rotation of each vertex, m²/rad, into `gradient`.
    pub fn energy(
        &self,
        rotations: &Rotations,
        moved_m: &[Vector3<f64>],
        gradient: &mut [Vector3<f64>],
    ) -> f64 {
        in_parts(gradient, |vertex, slope| {
            let (stretch, stretch_slope) = self.stretch(vertex, &rotations.excess[vertex], moved_m);
            let (bend, bend_slope) = self.bend(vertex, &rotations.quaternions);
            *slope = stretch_slope + bend_slope * self.smoothing_m2;
            stretch + self.smoothing_m2 * bend
        })
    }

    /// First term of Eq. 3 at one vertex: Σⱼ wᵢⱼ |(v'ᵢ−v'ⱼ) − Rᵢ(vᵢ−vⱼ)|² over its neighbours, and its gradient.
    fn stretch(
        &self,
        vertex: usize,
        excess: &Matrix3<f64>,
        moved_m: &[Vector3<f64>],
    ) -> (f64, Vector3<f64>) {
        let (place, moved) = (self.rest_m[vertex], moved_m[vertex]);
        let (mut energy, mut torque) = (0.0, Vector3::zeros());
        for (neighbour, weight) in self.rings.of(vertex) {
            let edge = place - self.rest_m[neighbour];
            let turned_by = excess * edge;
            let misfit = moved - moved_m[neighbour] - turned_by;
            energy += weight * misfit.norm_squared();
            torque += (edge + turned_by).cross(&misfit) * weight;
        }
        (energy, torque * -2.0)
    }

    /// Second term of Eq. 3 at one vertex: Σⱼ |Rᵢ−Rⱼ|² over its neighbours (Frobenius norm), and the gradient of the sum
    /// over all vertices, in which each pair counts twice. For unit quaternions p and q with d = |p−q|², |Rᵢ−Rⱼ|² = 8d − 2d².
    fn bend(&self, vertex: usize, quaternions: &[Quaternion]) -> (f64, Vector3<f64>) {
        let own = quaternions[vertex];
        let (mut energy, mut pull) = (0.0, [0.0; 4]);
        for (neighbour, _) in self.rings.of(vertex) {
            let other = &quaternions[neighbour];
            let difference: Quaternion = std::array::from_fn(|k| own[k] - other[k]);
            let squared: f64 = difference.iter().map(|part| part * part).sum();
            energy += squared * (8.0 - 2.0 * squared);
            for k in 0..4 {
                pull[k] += difference[k] * (1.0 - squared / 2.0);
            }
        }
        (energy, imaginary_of_quotient(&pull, &own) * 16.0)
    }

    /// Σⱼ wᵢⱼ |vᵢ−vⱼ|² over a vertex's neighbours, at rest.
    pub fn stiffness(&self, vertex: usize) -> f64 {
        let place = self.rest_m[vertex];
        let edges = self.rings.of(vertex);
        edges
            .map(|(neighbour, weight)| weight * (place - self.rest_m[neighbour]).norm_squared())
            .sum()
    }
}

/// Vertices in one part of a sum. Fixed, so that the order of additions does not depend on the number of threads.
const PART: usize = 4096;
/// Meshes with fewer vertices are summed by one thread: several such meshes at a time keep the threads better busy.
const PARALLEL_MIN: usize = 32_768;

/// Calls `work` with each index and its entry, and sums up what it returns: part by part, then the parts in order, so
/// that the sum is the same for any number of threads.
fn in_parts<T: Send>(entries: &mut [T], work: impl Fn(usize, &mut T) -> f64 + Sync) -> f64 {
    let sum = |(part, entries): (usize, &mut [T])| -> f64 {
        let numbered = entries.iter_mut().enumerate();
        numbered
            .map(|(index, entry)| work(part * PART + index, entry))
            .sum()
    };
    if entries.len() < PARALLEL_MIN {
        return entries.chunks_mut(PART).enumerate().map(sum).sum();
    }
    let sums: Vec<f64> = entries.par_chunks_mut(PART).enumerate().map(sum).collect();
    sums.iter().sum()
}
