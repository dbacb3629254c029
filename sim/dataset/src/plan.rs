//! The plan of a dataset: units of work and meshes, whose numbers depend on the sources, the count and the seed alone.

use std::num::NonZeroUsize;
use std::ops::Range;

use sim_deform::grasp::Grasp;

use crate::error::DatasetError;
use crate::object::Object;
use crate::shard::Shard;

/// Least number of digits of a mesh's number in its file name.
const DIGITS_MIN: usize = 4;

/// One grasp of one object with its intensities.
pub struct Unit {
    /// Index of the object.
    pub object: usize,
    /// Number of the unit within the object, from 0.
    pub number: usize,
    /// Where the fingers press.
    pub grasp: Grasp,
    /// Numbers of its meshes, from 0 within the object; the first has the first intensity.
    pub meshes: Range<usize>,
}

/// The units of one object.
pub struct ObjectPlan {
    /// The units, in the random order that the seed gives.
    pub units: Vec<Unit>,
    /// Number of meshes of all units.
    pub meshes: usize,
    /// Number of handles before the last unit's, in the order of the seed, at which the gripper cannot press.
    pub refused_handles: usize,
}

impl ObjectPlan {
    /// Takes the first feasible grasps in the order of the seed; infeasible ones get no number. `count` is the number of
    /// meshes; `None`: as many as the paper's sampling ratio gives.
    ///
    /// # Errors
    /// There are too few grasps for the count.
    pub fn new(
        index: usize,
        object: &Object,
        intensities: usize,
        count: Option<NonZeroUsize>,
        seed: u64,
    ) -> Result<Self, DatasetError> {
        let grasps = object.denter.grasps();
        let wanted = match count {
            Some(count) => count.get().div_ceil(intensities),
            None => grasps.default_count(),
        };
        let mut refused_handles = 0;
        let mut accepted = Vec::with_capacity(wanted);
        for handle in grasps.order(seed) {
            if accepted.len() == wanted {
                break;
            }
            match grasps.grasp(handle) {
                Ok(grasp) => accepted.push(grasp),
                Err(_) => refused_handles += 1,
            }
        }
        let meshes_max = accepted.len() * intensities;
        let meshes = count.map_or(meshes_max, NonZeroUsize::get);
        if meshes > meshes_max || meshes == 0 {
            return Err(DatasetError::CountTooLarge {
                object: object.name.clone(),
                grasps: accepted.len(),
                meshes_max,
                count: meshes,
            });
        }
        let unit = |(number, grasp)| {
            let first = number * intensities;
            Unit {
                object: index,
                number,
                grasp,
                meshes: first..meshes.min(first + intensities),
            }
        };
        Ok(Self {
            units: accepted.into_iter().enumerate().map(unit).collect(),
            meshes,
            refused_handles,
        })
    }

    /// The units of one shard; of all without one.
    pub fn units(&self, shard: Option<Shard>) -> impl Iterator<Item = &Unit> {
        self.units
            .iter()
            .filter(move |unit| shard.is_none_or(|shard| shard.holds(unit.number)))
    }
}

/// File name of mesh `n` out of `meshes`: all names of an object have the same length, so that they sort by number.
pub fn file_name(n: usize, meshes: usize) -> String {
    let digits = (meshes - 1).to_string().len().max(DIGITS_MIN);
    format!("{n:0digits$}.ply")
}

#[cfg(test)]
mod tests {
    use super::file_name;

    #[test]
    fn names_of_one_object_are_equally_long() {
        assert_eq!(file_name(7, 1), "0007.ply");
        assert_eq!(file_name(7, 10_000), "0007.ply");
        assert_eq!(file_name(7, 10_001), "00007.ply");
        assert_eq!(file_name(10_000, 10_001), "10000.ply");
    }
}
