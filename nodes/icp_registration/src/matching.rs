//! Which point of the model is nearest, asked again and again while a view moves a little.

use nalgebra::Point3;

use crate::model::Searchable;

/// Nearest neighbours of a view's points.
///
/// For each point all of the model's points that were near it are remembered, up to a distance. After it has moved, the
/// nearest of them is the nearest of all as long as it is nearer than anything that was farther than that can have come;
/// only then the rows are searched again. Answers are the same as without this memory.
pub(crate) struct Matcher<'a> {
    model: &'a Searchable,
    max_distance: f32,
    remembered: Vec<Remembered>,
}

/// A neighbour within the matching distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Match {
    /// Index of the point of the model.
    pub(crate) index: usize,
    /// Squared distance, m².
    pub(crate) distance_sq: f32,
}

#[derive(Clone)]
struct Remembered {
    place: Point3<f32>,
    /// How far from `place` all points are among the candidates, m.
    complete_within: f32,
    candidates: [u32; CANDIDATES],
}

/// With more, looking at them costs more than it saves.
const CANDIDATES: usize = 4;
/// Without a memory to go by, a search looks as far as this at first, in voxels.
const FIRST_VOXELS: f32 = 1.2;
/// A search sees at least this many voxels beyond the nearest point, or all candidates.
const BEYOND_VOXELS: f32 = 0.3;
/// Distances are rounded; a memory that is this much too short costs nothing.
const ROUNDING_M: f32 = 1e-6;

impl<'a> Matcher<'a> {
    /// For `count` points of a view.
    pub(crate) fn new(model: &'a Searchable, max_distance: f32, count: usize) -> Self {
        let nothing = Remembered {
            place: Point3::origin(),
            complete_within: f32::NEG_INFINITY,
            candidates: [0; CANDIDATES],
        };
        Self {
            model,
            max_distance,
            remembered: vec![nothing; count],
        }
    }

    /// The model's point nearest to the view's point `number`, which is now at `place`.
    pub(crate) fn nearest(&mut self, number: usize, place: &Point3<f32>) -> Option<Match> {
        let remembered = &self.remembered[number];
        let mut nearest = self.closest(&remembered.candidates, place);
        let distance = nearest.distance_sq.sqrt().min(self.max_distance);
        let complete_within = remembered.complete_within - (place - remembered.place).norm();
        if distance >= complete_within {
            let voxel_m = self.model.voxel_m;
            let radius = if complete_within > 0.0 {
                distance + BEYOND_VOXELS * voxel_m
            } else {
                FIRST_VOXELS * voxel_m
            };
            let found = self.search(place, radius);
            nearest = self.closest(&found.candidates, place);
            self.remembered[number] = found;
        }
        (nearest.distance_sq <= self.max_distance * self.max_distance).then_some(nearest)
    }

    fn closest(&self, candidates: &[u32; CANDIDATES], place: &Point3<f32>) -> Match {
        let mut nearest = Match {
            index: 0,
            distance_sq: f32::INFINITY,
        };
        for &candidate in candidates {
            let index = candidate as usize;
            let distance_sq = (place - self.model.points[index]).norm_squared();
            if distance_sq < nearest.distance_sq {
                nearest = Match { index, distance_sq };
            }
        }
        nearest
    }

    /// Looks around, twice as far each time, until it knows the nearest point and some more, or that none is near.
    fn search(&self, place: &Point3<f32>, mut radius: f32) -> Remembered {
        let beyond = BEYOND_VOXELS * self.model.voxel_m;
        let farthest = self.max_distance + beyond;
        loop {
            radius = radius.min(farthest);
            let mut near = Shortlist::default();
            let rows = &self.model.rows;
            rows.within(place, radius, |index, distance_sq| {
                near.add(index, distance_sq)
            });
            let [nearest, after_last] = [0, CANDIDATES].map(|rank| near.distances_sq[rank].sqrt());
            if after_last <= radius || radius >= farthest || radius >= nearest + beyond {
                let [candidates @ .., _] = near.indices;
                return Remembered {
                    place: *place,
                    complete_within: after_last.min(radius) - ROUNDING_M,
                    candidates,
                };
            }
            radius *= 2.0;
        }
    }
}

/// The nearest points so far, nearest first.
struct Shortlist {
    distances_sq: [f32; CANDIDATES + 1],
    indices: [u32; CANDIDATES + 1],
}

impl Default for Shortlist {
    fn default() -> Self {
        Self {
            distances_sq: [f32::INFINITY; CANDIDATES + 1],
            indices: [0; CANDIDATES + 1],
        }
    }
}

impl Shortlist {
    fn add(&mut self, index: u32, distance_sq: f32) {
        let mut rank = CANDIDATES;
        if distance_sq >= self.distances_sq[rank] {
            return;
        }
        while rank > 0 && distance_sq < self.distances_sq[rank - 1] {
            self.distances_sq[rank] = self.distances_sq[rank - 1];
            self.indices[rank] = self.indices[rank - 1];
            rank -= 1;
        }
        self.distances_sq[rank] = distance_sq;
        self.indices[rank] = index;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Vector3;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    #[test]
    fn memory_never_changes_the_answer() {
        let seed = 11;
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut random_point =
            || Point3::new(random.random(), random.random(), random.random()) * 0.1;
        let targets: Vec<Point3<f32>> = (0..500).map(|_| random_point()).collect();
        let mut places: Vec<Point3<f32>> = (0..200).map(|_| random_point() * 1.4).collect();
        let model = Searchable::new(targets.clone(), 0.008).unwrap();
        let mut matcher = Matcher::new(&model, 0.008, places.len());
        for step in 0..60 {
            // A jump now and then, which makes memories useless.
            let step_m = if step % 20 == 19 { 0.05 } else { 0.002 };
            let offset = Vector3::new(0.3, -0.2, 0.1) * (step_m / (1.0 + step as f32));
            for (number, place) in places.iter_mut().enumerate() {
                *place += offset;
                let slow = targets
                    .iter()
                    .map(|target| (target - *place).norm_squared())
                    .min_by(f32::total_cmp)
                    .unwrap();
                let fast = matcher
                    .nearest(number, place)
                    .map(|found| found.distance_sq);
                assert_eq!(fast.is_some(), slow <= 0.008 * 0.008);
                assert!(fast.is_none_or(|fast| (fast - slow).abs() < 1e-9));
            }
        }
    }
}
