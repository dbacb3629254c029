//! Which point of the model is nearest, asked again and again while a view moves a little.

use std::num::NonZeroUsize;

use cloud::Tree;
use nalgebra::Point3;

/// Nearest neighbours of a view's points.
///
/// For each point some neighbours are remembered. While it has moved less than half of what the next one after them is
/// farther than the nearest, the nearest is still among them; the tree is only asked again after that. Answers are the
/// same as without this memory.
pub(crate) struct Matcher<'a> {
    tree: &'a Tree,
    targets: &'a [Point3<f32>],
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
    /// How far from `place` the nearest is known to be among the candidates, m.
    holds_within: f32,
    candidates: [u32; CANDIDATES],
}

/// With more, asking costs more than it saves.
const CANDIDATES: usize = 7;
const ASKED: NonZeroUsize = NonZeroUsize::MIN.saturating_add(CANDIDATES);
/// Distances are rounded; a memory that is this much too short costs nothing.
const ROUNDING_M: f32 = 1e-6;

impl<'a> Matcher<'a> {
    /// For `count` points of a view; `tree` is over `targets`.
    pub(crate) fn new(
        tree: &'a Tree,
        targets: &'a [Point3<f32>],
        max_distance: f32,
        count: usize,
    ) -> Self {
        let unknown = Remembered {
            place: Point3::origin(),
            holds_within: f32::NEG_INFINITY,
            candidates: [0; CANDIDATES],
        };
        let remembered = vec![unknown; count];
        Self {
            tree,
            targets,
            max_distance,
            remembered,
        }
    }

    /// The model's point nearest to the view's point `number`, which is now at `place`.
    pub(crate) fn nearest(&mut self, number: usize, place: &Point3<f32>) -> Option<Match> {
        let remembered = &mut self.remembered[number];
        if (place - remembered.place).norm() >= remembered.holds_within {
            *remembered = ask(self.tree, place, self.max_distance);
        }
        let mut nearest = Match {
            index: 0,
            distance_sq: f32::INFINITY,
        };
        for &candidate in &remembered.candidates {
            let index = candidate as usize;
            let distance_sq = (place - self.targets[index]).norm_squared();
            if distance_sq < nearest.distance_sq {
                nearest = Match { index, distance_sq };
            }
        }
        (nearest.distance_sq <= self.max_distance * self.max_distance).then_some(nearest)
    }
}

fn ask(tree: &Tree, place: &Point3<f32>, max_distance: f32) -> Remembered {
    let mut candidates = [0; CANDIDATES];
    let (mut first, mut after_last) = (f32::INFINITY, f32::INFINITY);
    for (rank, near) in tree.nearest_n(place, ASKED).enumerate() {
        let distance = near.distance_sq.sqrt();
        first = first.min(distance);
        match candidates.get_mut(rank) {
            Some(candidate) => *candidate = near.index as u32,
            None => after_last = distance,
        }
    }
    // As long as nothing can be near enough, it does not matter which is the nearest.
    let holds_within = ((after_last - first) / 2.0).max(first - max_distance) - ROUNDING_M;
    Remembered {
        place: *place,
        holds_within,
        candidates,
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
        let tree = Tree::new(&targets).unwrap();
        let mut matcher = Matcher::new(&tree, &targets, 0.008, places.len());
        for step in 0..60 {
            let offset = Vector3::new(0.3, -0.2, 0.1) * (0.002 / (1.0 + step as f32));
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
