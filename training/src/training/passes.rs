//! Forward and backward passes over many clouds, on all cores.

use anyhow::Result;
use candle_core::{Tensor, backprop::GradStore};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::data::LabelledClouds;
use crate::data::augment::Augmentation;
use crate::network::Network;
use crate::training::tally::Tally;

/// Gradients of the mean loss of some clouds, which are processed in parts in parallel.
pub(crate) fn gradients(
    network: &Network,
    clouds: &LabelledClouds,
    indices: &[usize],
    metres_per_unit: f64,
    (augmentation, mut random): (&Augmentation, Pcg64Mcg),
) -> Result<(GradStore, Tally)> {
    let parts = indices.chunks(network.part_size(clouds.point_count));
    let parts: Vec<_> = parts
        .map(|part| (part, Pcg64Mcg::from_rng(&mut random)))
        .collect();
    let parts: Vec<Result<(GradStore, Tally)>> = parts
        .into_par_iter()
        .map(|(part, random)| {
            let input = clouds.tensor(part, metres_per_unit, Some((augmentation, random)))?;
            let input = input.to_device(&network.device())?;
            let answers = network.forward(&input)?;
            let loss = clouds.summed_loss(&answers, part)?;
            let gradients = (&loss / indices.len() as f64)?.backward()?;
            Ok((gradients, Tally::of(&answers.to_vec2()?, clouds, part)))
        })
        .collect();
    // Add in order, so that rounding does not depend on which part was ready first.
    let mut total = Tally::default();
    let mut summed: Option<GradStore> = None;
    for part in parts {
        let (gradients, tally) = part?;
        total.add(tally);
        match &mut summed {
            Some(summed) => summed.extend(gradients)?,
            None => summed = Some(gradients),
        }
    }
    summed
        .map(|gradients| (gradients, total))
        .ok_or_else(|| anyhow::anyhow!("an empty batch"))
}

/// Logits `[C]` of each cloud.
///
/// # Errors
/// The network fails.
pub fn logits(
    network: &Network,
    clouds: &LabelledClouds,
    metres_per_unit: f64,
) -> Result<Vec<Vec<f32>>> {
    of_each(network, clouds, metres_per_unit, Network::logits)
}

/// Loss and accuracy on some clouds.
pub(crate) fn evaluate(
    network: &Network,
    clouds: &LabelledClouds,
    metres_per_unit: f64,
) -> Result<Tally> {
    let indices: Vec<usize> = (0..clouds.len()).collect();
    let answers = of_each(network, clouds, metres_per_unit, Network::forward)?;
    Ok(Tally::of(&answers, clouds, &indices))
}

fn of_each(
    network: &Network,
    clouds: &LabelledClouds,
    metres_per_unit: f64,
    answer: impl Fn(&Network, &Tensor) -> candle_core::Result<Tensor> + Sync,
) -> Result<Vec<Vec<f32>>> {
    let indices: Vec<usize> = (0..clouds.len()).collect();
    let answers: Vec<Result<Vec<Vec<f32>>>> = indices
        .par_chunks(network.part_size(clouds.point_count))
        .map(|part| {
            let input = clouds.tensor(part, metres_per_unit, None)?;
            let input = input.to_device(&network.device())?;
            Ok(answer(network, &input)?.to_vec2()?)
        })
        .collect();
    let answers: Result<Vec<_>> = answers.into_iter().collect();
    Ok(answers?.concat())
}
