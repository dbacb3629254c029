//! Places spread over a reference's outer surface, at which deviations are averaged, and who is beside whom.

use nalgebra::{Point3, Vector3};

use crate::layer::Layer;

/// Distance between neighbouring sites.
const SPACING_M: f32 = 0.003;
/// Sites nearer than this are neighbours, if the surface does not turn a corner between them.
pub(crate) const NEIGHBOUR_M: f32 = 0.005_5;
const SAME_SIDE: f32 = 0.4;

/// One place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Site {
    pub point: Point3<f32>,
    /// Of unit length, outward.
    pub normal: Vector3<f32>,
    /// Part of the surface that it stands for.
    pub area_m2: f32,
    /// Root mean square of the angle by which the surface turns within [`NEIGHBOUR_M`], rad, at most 1.
    pub bend: f32,
}

pub(crate) struct Sites {
    pub list: Vec<Site>,
    /// Of each of the layer's samples.
    pub of_sample: Vec<u32>,
    /// Neighbours of site `i` are `beside[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    beside: Vec<u32>,
}

impl Sites {
    /// Sites of a layer whose samples stand for `sample_m2` each.
    pub(crate) fn new(layer: &Layer, sample_m2: f32) -> Self {
        let mut list = Vec::new();
        let mut of_sample = vec![u32::MAX; layer.samples.len()];
        let mut nearest_m = vec![f32::MAX; layer.samples.len()];
        for index in 0..layer.samples.len() {
            if nearest_m[index] < SPACING_M {
                continue;
            }
            let sample = layer.samples[index];
            let number = list.len() as u32;
            for other in layer.within(&sample.point, 1.8 * SPACING_M) {
                let found = &layer.samples[other];
                let distance_m = (found.point - sample.point).norm();
                if distance_m < nearest_m[other] && found.normal.dot(&sample.normal) > SAME_SIDE {
                    (nearest_m[other], of_sample[other]) = (distance_m, number);
                }
            }
            (nearest_m[index], of_sample[index]) = (0.0, number);
            list.push(Site {
                point: sample.point,
                normal: sample.normal,
                area_m2: 0.0,
                bend: bend(layer, index),
            });
        }
        for &site in &of_sample {
            list[site as usize].area_m2 += sample_m2;
        }
        let (starts, beside) = neighbours(&list);
        Self {
            list,
            of_sample,
            starts,
            beside,
        }
    }

    /// Sites beside one, without itself.
    pub(crate) fn beside(&self, site: usize) -> impl Iterator<Item = usize> {
        let range = self.starts[site] as usize..self.starts[site + 1] as usize;
        self.beside[range].iter().map(|&index| index as usize)
    }
}

fn bend(layer: &Layer, index: usize) -> f32 {
    let own = layer.samples[index];
    let (mut sum, mut count) = (0.0, 0.0);
    for other in layer.within(&own.point, NEIGHBOUR_M) {
        // 1 - cos of the angle is half its square.
        sum += 2.0 * (1.0 - layer.samples[other].normal.dot(&own.normal));
        count += 1.0;
    }
    (sum / f32::max(count, 1.0)).max(0.0).sqrt().min(1.0)
}

fn neighbours(list: &[Site]) -> (Vec<u32>, Vec<u32>) {
    let points: Vec<_> = list.iter().map(|site| site.point).collect();
    let tree = cloud::Tree::new(&points);
    let (mut starts, mut beside) = (vec![0], Vec::new());
    for (index, site) in list.iter().enumerate() {
        let found = tree
            .iter()
            .flat_map(|tree| tree.within(&site.point, NEIGHBOUR_M));
        let mut found: Vec<u32> = found
            .filter(|other| {
                other.index != index && list[other.index].normal.dot(&site.normal) > SAME_SIDE
            })
            .map(|other| other.index as u32)
            .collect();
        found.sort_unstable();
        beside.extend(found);
        starts.push(beside.len() as u32);
    }
    (starts, beside)
}
