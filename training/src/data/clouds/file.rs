//! Labelled clouds in an npz file, which numpy opens.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use candle_core::{Device, Tensor};
use whole_file::Draft;

use super::LabelledClouds;

impl LabelledClouds {
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
    // Files without this entry were made by an earlier version, so by other code.
    let made_by = get(MADE_BY).map_or(Ok(Vec::new()), |bytes| bytes.to_vec1::<u8>())?;
    Ok((clouds, String::from_utf8_lossy(&made_by).into_owned()))
}
