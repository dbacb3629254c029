//! Labelled clouds as the network gets them, in memory and as a file that numpy opens.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use candle_core::{Device, Tensor};

/// Something taken of a cloud, and what the cloud shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen<T> {
    /// Index of the class.
    pub label: u32,
    /// Views that made the cloud; 0: it is the whole surface.
    pub view_count: u32,
    /// Whether a gripper held the object; else it stood on something.
    pub held: bool,
    /// What was taken.
    pub taken: T,
}

impl<T> Seen<T> {
    /// Something else taken of the same cloud.
    pub fn with<U>(&self, taken: U) -> Seen<U> {
        Seen {
            label: self.label,
            view_count: self.view_count,
            held: self.held,
            taken,
        }
    }
}

/// Clouds of one point count with what they show.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    /// N, the points of each cloud.
    pub point_count: usize,
    /// `[M, N, 3]` row-major, in metres, up along the model's up axis, moved to the origin.
    pub points: Vec<f32>,
    /// `[M]` class indices.
    pub labels: Vec<u32>,
    /// `[M]` how many views made each cloud.
    pub view_counts: Vec<u32>,
    /// `[M]` 1 where a gripper held the object, 0 where it stood on something.
    pub held: Vec<u32>,
}

impl Samples {
    /// No clouds yet.
    pub fn new(point_count: usize) -> Self {
        Self {
            point_count,
            ..Self::default()
        }
    }

    /// Number of clouds, M.
    pub fn len(&self) -> usize {
        self.labels.len()
    }

    /// Whether there is no cloud.
    pub fn is_empty(&self) -> bool {
        self.labels.is_empty()
    }

    /// The points of one cloud, `[N, 3]`.
    pub fn cloud(&self, index: usize) -> &[f32] {
        let length = 3 * self.point_count;
        &self.points[index * length..(index + 1) * length]
    }

    /// Adds one cloud, which is the network's input, `[3, N]` in units of `metres_per_unit`.
    pub fn push(&mut self, seen: &Seen<Vec<f32>>, metres_per_unit: f64) {
        for point in 0..self.point_count {
            let coordinate =
                |axis: usize| seen.taken[axis * self.point_count + point] * metres_per_unit as f32;
            self.points.extend([0, 1, 2].map(coordinate));
        }
        self.labels.push(seen.label);
        self.view_counts.push(seen.view_count);
        self.held.push(u32::from(seen.held));
    }

    /// One cloud as the network's input, `[3, N]` in units of `metres_per_unit`.
    pub fn input(&self, index: usize, metres_per_unit: f64) -> Vec<f32> {
        let cloud = self.cloud(index);
        let axis = |axis: usize| cloud.iter().skip(axis).step_by(3);
        (0..3)
            .flat_map(axis)
            .map(|metres| metres / metres_per_unit as f32)
            .collect()
    }

    /// Adds all clouds of `other`, which have as many points each.
    pub fn append(&mut self, other: Samples) {
        self.points.extend(other.points);
        self.labels.extend(other.labels);
        self.view_counts.extend(other.view_counts);
        self.held.extend(other.held);
    }
}

const ARRAYS: [&str; 5] = ["points", "labels", "view_counts", "held", "split"];

/// Writes training and validation clouds to one npz file: `points` float32 `[M, N, 3]` in metres, `labels`,
/// `view_counts`, `held` and `split` (0 training, 1 validation) uint32 `[M]`.
///
/// # Errors
/// The file cannot be written; then nothing of it is left.
pub fn write_npz(path: &Path, train: &Samples, validation: &Samples) -> Result<()> {
    let mut all = train.clone();
    all.append(validation.clone());
    let count = all.len();
    let mut split = vec![0u32; train.len()];
    split.resize(count, 1);
    let tensors = [
        Tensor::from_vec(all.points, (count, all.point_count, 3), &Device::Cpu)?,
        Tensor::from_vec(all.labels, count, &Device::Cpu)?,
        Tensor::from_vec(all.view_counts, count, &Device::Cpu)?,
        Tensor::from_vec(all.held, count, &Device::Cpu)?,
        Tensor::from_vec(split, count, &Device::Cpu)?,
    ];
    let folder = path.parent().context("a dataset file needs a folder")?;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let unfinished = path.with_extension("npz.unfinished");
    let named: Vec<(&str, Tensor)> = ARRAYS.into_iter().zip(tensors).collect();
    Tensor::write_npz(&named, &unfinished)
        .map_err(anyhow::Error::from)
        .and_then(|()| Ok(std::fs::rename(&unfinished, path)?))
        .inspect_err(|_| drop(std::fs::remove_file(&unfinished)))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// Reads what [`write_npz`] wrote: training and validation clouds.
///
/// # Errors
/// The file cannot be read, or is not such a file.
pub fn read_npz(path: &Path) -> Result<(Samples, Samples)> {
    read(path).with_context(|| {
        format!(
            "cannot read the dataset {}; delete it to have it made again",
            path.display()
        )
    })
}

fn read(path: &Path) -> Result<(Samples, Samples)> {
    let arrays = Tensor::read_npz_by_name(path, &ARRAYS)?;
    let (count, point_count, three) = arrays[0].dims3()?;
    ensure!(three == 3, "points have {three} coordinates");
    let points = arrays[0].flatten_all()?.to_vec1::<f32>()?;
    let column = |index: usize| -> Result<Vec<u32>> {
        let values = arrays[index].to_vec1::<u32>()?;
        ensure!(
            values.len() == count,
            "{} has {} rows, points has {count}",
            ARRAYS[index],
            values.len()
        );
        Ok(values)
    };
    let columns = [column(1)?, column(2)?, column(3)?];
    let split = column(4)?;
    let mut parts = (Samples::new(point_count), Samples::new(point_count));
    for index in 0..count {
        let part = if split[index] == 0 {
            &mut parts.0
        } else {
            &mut parts.1
        };
        part.points
            .extend(&points[index * 3 * point_count..(index + 1) * 3 * point_count]);
        part.labels.push(columns[0][index]);
        part.view_counts.push(columns[1][index]);
        part.held.push(columns[2][index]);
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn samples(count: u32) -> Samples {
        let mut samples = Samples::new(2);
        for label in 0..count {
            let seen = Seen {
                label,
                view_count: 3,
                held: true,
                taken: vec![1.0, 2.0, 3.0, 4.0, 5.0, label as f32],
            };
            samples.push(&seen, 0.5);
        }
        samples
    }

    #[test]
    fn input_is_transposed_and_put_back_to_metres() {
        assert_eq!(samples(8).cloud(7), [0.5, 1.5, 2.5, 1.0, 2.0, 3.5]);
        assert_eq!(samples(8).input(7, 0.5), [1.0, 2.0, 3.0, 4.0, 5.0, 7.0]);
    }

    #[test]
    fn files_read_back_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("made/clouds.npz");
        write_npz(&path, &samples(5), &samples(2)).unwrap();
        assert_eq!(read_npz(&path).unwrap(), (samples(5), samples(2)));
        assert_eq!(
            std::fs::read_dir(path.parent().unwrap()).unwrap().count(),
            1
        );
    }

    #[test]
    fn a_truncated_or_foreign_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clouds.npz");
        write_npz(&path, &samples(5), &samples(2)).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for bytes in [&bytes[..bytes.len() / 2], b"text"] {
            std::fs::write(&path, bytes).unwrap();
            let message = read_npz(&path).unwrap_err().to_string();
            assert!(message.contains("clouds.npz"), "{message}");
        }
        assert!(read_npz(Path::new("/nowhere/clouds.npz")).is_err());
    }
}
