//! Which meshes are learned from, and which are tested on.

use anyhow::{Result, ensure};
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;

use super::clouds::Split;
use super::mesh_dataset::MeshDataset;

/// What each mesh is for, at random within each class: `test_share` of them is tested on, and `validation_share` of the
/// others chooses the epoch. The meshes of one grasp stay together: they are so alike that one would tell the answer to the
/// other.
pub(crate) fn split(
    dataset: &MeshDataset,
    test_share: f64,
    validation_share: f64,
    random: &mut Pcg64Mcg,
) -> Result<Vec<Split>> {
    let mut split = vec![Split::Train; dataset.meshes.len()];
    for (label, name) in dataset.labels.iter().enumerate() {
        let of_class = |index: &usize| dataset.meshes[*index].label == label as u32;
        let meshes: Vec<usize> = (0..dataset.meshes.len()).filter(of_class).collect();
        let mut grasps: Vec<&[usize]> = meshes
            .chunk_by(|&a, &b| dataset.meshes[a].grasp == dataset.meshes[b].grasp)
            .collect();
        ensure!(
            grasps.len() >= 3,
            "{name} has too few meshes: {} of {} grasps, and 3 grasps are needed, for training, validation and test; \
             make more with generate_dataset --count",
            meshes.len(),
            grasps.len()
        );
        grasps.shuffle(random);
        let (test, others) = cut(&grasps, test_share);
        let (validation, _) = cut(others, validation_share);
        for (part, grasps) in [(Split::Test, test), (Split::Validation, validation)] {
            for &index in grasps.iter().copied().flatten() {
                split[index] = part;
            }
        }
    }
    Ok(split)
}

/// Cuts off groups that hold this share of all, at least one group; at least one stays.
fn cut<'a, 'b>(groups: &'b [&'a [usize]], share: f64) -> (&'b [&'a [usize]], &'b [&'a [usize]]) {
    let whole: usize = groups.iter().map(|group| group.len()).sum();
    let mut held = 0.0;
    let reaching = groups.iter().position(|group| {
        let half = group.len() as f64 / 2.0;
        held += 2.0 * half;
        held - half >= share * whole as f64
    });
    groups.split_at(reaching.unwrap_or(groups.len()).clamp(1, groups.len() - 1))
}
