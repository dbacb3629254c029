//! Labelled clouds as the network gets them, in memory and as a file that numpy opens.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use candle_core::{Device, Tensor};
use rand_pcg::Pcg64Mcg;
use whole_file::Draft;

use super::augment::{Augmentation, augment};

/// What a cloud is for. The numbers are those of the file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Split {
    /// Learned from.
    #[default]
    Train = 0,
    /// Chooses the best epoch.
    Validation = 1,
    /// Seen only when all is decided.
    Test = 2,
}

/// Something taken of a cloud, and what the cloud shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen<T> {
    /// Index of the class; the number of classes for what is none of them.
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

/// M clouds of one point count, with what they show.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LabelledClouds {
    /// N, points of each cloud, in the order of farthest-point sampling: fewer of them are what the node would choose.
    pub point_count: usize,
    /// Values of a point: 3, or 6 with its normal.
    pub columns: usize,
    /// `[M, N, columns]` row-major: coordinates in metres, up along the model's up axis, moved to the origin; then the unit
    /// normal, if any.
    pub values: Vec<f32>,
    /// `[M]` class indices.
    pub labels: Vec<u32>,
    /// `[M]` how many views made each cloud; 0 for a whole surface.
    pub view_counts: Vec<u32>,
    /// `[M]` 1 where a gripper held the object, 0 where it stood on something or is seen from all sides.
    pub held: Vec<u32>,
    /// `[M]` numbers of [`Split`].
    pub split: Vec<u32>,
}

impl LabelledClouds {
    /// No clouds yet; `columns` is 3, or 6 with normals.
    pub fn new(point_count: usize, columns: usize) -> Self {
        Self {
            point_count,
            columns,
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

    /// The values of one cloud, `[N, columns]`.
    ///
    /// # Panics
    /// Where there is no such cloud.
    pub fn cloud(&self, index: usize) -> &[f32] {
        let length = self.columns * self.point_count;
        &self.values[index * length..(index + 1) * length]
    }

    /// Adds one cloud, which is the network's input, `[columns, N]`: coordinates in units of `metres_per_unit`, then normals.
    pub fn push(&mut self, seen: &Seen<Vec<f32>>, metres_per_unit: f64, split: Split) {
        for point in 0..self.point_count {
            self.values.extend((0..self.columns).map(|column| {
                let scale = if column < 3 {
                    metres_per_unit as f32
                } else {
                    1.0
                };
                seen.taken[column * self.point_count + point] * scale
            }));
        }
        self.labels.push(seen.label);
        self.view_counts.push(seen.view_count);
        self.held.push(u32::from(seen.held));
        self.split.push(split as u32);
    }

    /// Adds all clouds of `other`, which have the same shape.
    pub fn append(&mut self, other: Self) {
        self.values.extend(other.values);
        self.labels.extend(other.labels);
        self.view_counts.extend(other.view_counts);
        self.held.extend(other.held);
        self.split.extend(other.split);
    }

    /// The clouds of one split, each of its first `point_count` points.
    pub fn part(&self, split: Split, point_count: usize) -> Self {
        let wanted = |index: &usize| self.split[*index] == split as u32;
        let chosen: Vec<usize> = (0..self.len()).filter(wanted).collect();
        let of_chosen = |column: &[u32]| chosen.iter().map(|&index| column[index]).collect();
        let values = chosen
            .iter()
            .flat_map(|&index| &self.cloud(index)[..self.columns * point_count]);
        Self {
            point_count,
            columns: self.columns,
            values: values.copied().collect(),
            labels: of_chosen(&self.labels),
            view_counts: of_chosen(&self.view_counts),
            held: of_chosen(&self.held),
            split: of_chosen(&self.split),
        }
    }

    /// Some clouds as the network takes them, `[B, N, columns]` in units; changed at random if asked for.
    ///
    /// # Errors
    /// Candle fails.
    pub fn tensor(
        &self,
        indices: &[usize],
        metres_per_unit: f64,
        change: Option<(&Augmentation, Pcg64Mcg)>,
    ) -> Result<Tensor> {
        let length = self.columns * self.point_count;
        let mut values = Vec::with_capacity(indices.len() * length);
        indices
            .iter()
            .for_each(|&index| values.extend_from_slice(self.cloud(index)));
        if let Some((augmentation, mut random)) = change {
            let clouds = values.chunks_exact_mut(length);
            clouds.for_each(|cloud| augment(cloud, self.columns, augmentation, &mut random));
        }
        let units_per_metre = (1.0 / metres_per_unit) as f32;
        for point in values.chunks_exact_mut(self.columns) {
            point[..3].iter_mut().for_each(|v| *v *= units_per_metre);
        }
        let shape = (indices.len(), self.point_count, self.columns);
        Ok(Tensor::from_vec(values, shape, &Device::Cpu)?)
    }

    /// Sum of the negative log-probabilities, `[B, C]`, of the true classes.
    ///
    /// # Errors
    /// Candle fails.
    pub fn summed_loss(&self, log_probabilities: &Tensor, indices: &[usize]) -> Result<Tensor> {
        let labels: Vec<u32> = indices.iter().map(|&index| self.labels[index]).collect();
        let labels = Tensor::from_vec(labels, (indices.len(), 1), log_probabilities.device())?;
        Ok(log_probabilities.gather(&labels, 1)?.sum_all()?.neg()?)
    }

    /// Writes an npz file: `points` float32 `[M, N, 3]` in metres, `normals` like them if there are any, and uint32 `[M]`
    /// `labels`, `view_counts`, `held` and `split` (0 training, 1 validation, 2 test); `made_by` has the bytes of the digest of
    /// the code that made them.
    ///
    /// # Errors
    /// The file cannot be written; then nothing of it is left.
    pub fn write(&self, path: &Path, made_by: &str) -> Result<()> {
        let write = || -> Result<()> {
            let all = Tensor::from_slice(&self.values, self.shape(), &Device::Cpu)?;
            let mut arrays = vec![("points", all.narrow(2, 0, 3)?.contiguous()?)];
            if self.columns > 3 {
                arrays.push(("normals", all.narrow(2, 3, 3)?.contiguous()?));
            }
            for (name, column) in COLUMNS.into_iter().zip(self.columns_of_clouds()) {
                arrays.push((name, Tensor::from_slice(column, self.len(), &Device::Cpu)?));
            }
            arrays.push((MADE_BY, Tensor::new(made_by.as_bytes(), &Device::Cpu)?));
            std::fs::create_dir_all(path.parent().context("a file of clouds needs a folder")?)?;
            let draft = Draft::of(path)?;
            Tensor::write_npz(&arrays, draft.path())?;
            Ok(draft.finish()?)
        };
        write().with_context(|| format!("cannot write {}", path.display()))
    }

    /// Reads what [`LabelledClouds::write`] wrote, and which code made it.
    ///
    /// # Errors
    /// The file cannot be read, or is not such a file.
    pub fn read(path: &Path) -> Result<(Self, String)> {
        parse(path).with_context(|| {
            let path = path.display();
            format!("cannot read the clouds {path}; --fresh makes them again")
        })
    }

    /// The clouds in a file, if there is one and this very code made it.
    ///
    /// # Errors
    /// As [`LabelledClouds::read`].
    pub fn read_own(path: &Path, code: &str) -> Result<Option<Self>> {
        if !path.is_file() {
            return Ok(None);
        }
        let (clouds, made_by) = Self::read(path)?;
        Ok((made_by == code).then_some(clouds))
    }

    fn shape(&self) -> (usize, usize, usize) {
        (self.len(), self.point_count, self.columns)
    }

    fn columns_of_clouds(&self) -> [&[u32]; 4] {
        [&self.labels, &self.view_counts, &self.held, &self.split]
    }
}

/// Arrays with one number a cloud.
const COLUMNS: [&str; 4] = ["labels", "view_counts", "held", "split"];
const MADE_BY: &str = "made_by";

fn parse(path: &Path) -> Result<(LabelledClouds, String)> {
    let arrays = Tensor::read_npz(path)?;
    let find = |name: &str| arrays.iter().find(|(found, _)| found == name);
    let get = |name: &str| find(name).map(|(_, array)| array);
    let points = get("points").context("it has no points")?;
    let (count, point_count, three) = points.dims3()?;
    ensure!(three == 3, "points have {three} coordinates");
    let all = match get("normals") {
        Some(normals) => Tensor::cat(&[points, normals], 2)?,
        None => points.clone(),
    };
    let column = |name: &str| -> Result<Vec<u32>> {
        let values = get(name).with_context(|| format!("it has no {name}"))?;
        let values = values.to_vec1::<u32>()?;
        let found = values.len();
        ensure!(found == count, "{found} {name} of {count} clouds");
        Ok(values)
    };
    let [labels, view_counts, held, split] = COLUMNS.map(column);
    let clouds = LabelledClouds {
        point_count,
        columns: all.dims3()?.2,
        values: all.flatten_all()?.to_vec1()?,
        labels: labels?,
        view_counts: view_counts?,
        held: held?,
        split: split?,
    };
    // Files of before it was written were made by other code in any case.
    let made_by = get(MADE_BY).map_or(Ok(Vec::new()), |bytes| bytes.to_vec1::<u8>())?;
    Ok((clouds, String::from_utf8_lossy(&made_by).into_owned()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn clouds(columns: usize) -> LabelledClouds {
        let mut clouds = LabelledClouds::new(2, columns);
        for label in 0..7 {
            let taken = [
                1.0,
                2.0,
                3.0,
                4.0,
                5.0,
                label as f32,
                0.0,
                0.0,
                0.0,
                0.0,
                1.0,
                1.0,
            ];
            let seen = Seen {
                label,
                view_count: 3,
                held: true,
                taken: taken[..2 * columns].to_vec(),
            };
            let split = if label < 5 { Split::Train } else { Split::Test };
            clouds.push(&seen, 0.5, split);
        }
        clouds
    }

    #[test]
    fn input_is_transposed_and_put_into_metres() {
        assert_eq!(clouds(3).cloud(6), [0.5, 1.5, 2.5, 1.0, 2.0, 3.0]);
        let with_normals = [0.5, 1.5, 2.5, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 0.0, 0.0, 1.0];
        assert_eq!(clouds(6).cloud(6), with_normals);
        let tensor = clouds(6).tensor(&[6], 0.5, None).unwrap();
        let units = tensor.flatten_all().unwrap().to_vec1::<f32>().unwrap();
        assert_eq!(
            units,
            [1.0, 3.0, 5.0, 0.0, 0.0, 1.0, 2.0, 4.0, 6.0, 0.0, 0.0, 1.0]
        );
    }

    #[test]
    fn a_part_has_the_clouds_of_its_split_and_their_first_points() {
        let part = clouds(3).part(Split::Test, 1);
        assert_eq!((part.len(), part.point_count), (2, 1));
        assert_eq!(part.labels, [5, 6]);
        assert_eq!(part.cloud(1), [0.5, 1.5, 2.5]);
        assert!(clouds(3).part(Split::Validation, 2).is_empty());
    }

    #[test]
    fn files_read_back_the_same() {
        let folder = tempfile::tempdir().unwrap();
        for columns in [3, 6] {
            let path = folder.path().join("made/clouds.npz");
            clouds(columns).write(&path, "code").unwrap();
            let read = LabelledClouds::read(&path).unwrap();
            assert_eq!(read, (clouds(columns), "code".to_owned()));
            let entries = std::fs::read_dir(path.parent().unwrap()).unwrap();
            assert_eq!(entries.count(), 1);
        }
    }

    #[test]
    fn what_other_code_made_is_not_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clouds.npz");
        assert_eq!(LabelledClouds::read_own(&path, "code").unwrap(), None);
        clouds(3).write(&path, "code").unwrap();
        let own = LabelledClouds::read_own(&path, "code").unwrap();
        assert_eq!(own, Some(clouds(3)));
        assert_eq!(LabelledClouds::read_own(&path, "other").unwrap(), None);
    }

    #[test]
    fn a_truncated_or_foreign_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("clouds.npz");
        clouds(3).write(&path, "code").unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for bytes in [&bytes[..bytes.len() / 2], b"text"] {
            std::fs::write(&path, bytes).unwrap();
            let message = LabelledClouds::read(&path).unwrap_err().to_string();
            assert!(message.contains("clouds.npz"), "{message}");
        }
        assert!(LabelledClouds::read(Path::new("/nowhere/clouds.npz")).is_err());
    }
}
