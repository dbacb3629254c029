//! The folder of a dataset, whole or a part.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde_yaml::Value;

use crate::error::DatasetError;
use crate::journal::Journal;
use crate::manifest::{Row, from_csv, to_csv};
pub use crate::object::REFERENCES;
use crate::record::differences;
use crate::shard::Shard;

const MANIFEST: &str = "manifest.csv";
const JOURNAL: &str = "manifest.unfinished.csv";
const RECORD: &str = "run.yaml";
const SHARD: &str = "shard.yaml";

/// Rows by object and number.
pub type Rows = BTreeMap<(String, usize), Row>;

/// Rows by their keys; of two with the same, the later.
pub fn keyed(rows: Vec<Row>) -> Rows {
    let key = |row: &Row| (row.object.clone(), row.n);
    rows.into_iter().map(|row| (key(&row), row)).collect()
}

/// The folder of a dataset.
#[derive(Debug, Clone)]
pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// The dataset folder of this name; the file system is not touched.
    pub fn at(root: &Path) -> Self {
        Self {
            root: root.to_path_buf(),
        }
    }

    /// Path of the folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The folder of an object's meshes.
    pub fn object(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// An object as it is before anything dents it.
    pub fn reference(&self, name: &str) -> PathBuf {
        self.root.join(REFERENCES).join(format!("{name}.ply"))
    }

    /// Makes the folder of the undented objects, and removes drafts of files that a killed run left in it.
    ///
    /// # Errors
    /// The folder cannot be made or cleaned.
    pub fn make_references(&self) -> Result<(), DatasetError> {
        self.make_object(REFERENCES)
    }

    /// Makes an object's folder, and removes drafts of files that a killed run left in it.
    ///
    /// # Errors
    /// The folder cannot be made or cleaned.
    pub fn make_object(&self, name: &str) -> Result<(), DatasetError> {
        let folder = self.object(name);
        fs::create_dir_all(&folder).map_err(DatasetError::io("make", &folder))?;
        sweep(&folder)
    }

    /// Path of manifest.csv, which has one row a mesh and exists once the dataset is finished.
    pub fn manifest(&self) -> PathBuf {
        self.root.join(MANIFEST)
    }

    /// Path of run.yaml: everything that determines the dataset.
    pub fn record(&self) -> PathBuf {
        self.root.join(RECORD)
    }

    /// Whether a run in this folder has not finished.
    pub fn is_unfinished(&self) -> bool {
        self.root.join(JOURNAL).exists()
    }

    /// Begins or resumes a dataset. The folder is locked for other runs until the journal is dropped.
    ///
    /// # Errors
    /// The folder holds something else, another run has locked it, or a file cannot be written.
    pub fn open(&self, record: &str, shard: Option<Shard>) -> Result<Journal, DatasetError> {
        // First of all: nothing may be made or removed in a folder that is not ours.
        self.refuse_foreign()?;
        fs::create_dir_all(&self.root).map_err(DatasetError::io("make", &self.root))?;
        let journal = Journal::open(&self.root.join(JOURNAL))?;
        if let Err(error) = self.claim(record, shard) {
            // Leave no journal behind in a folder that was refused.
            if journal.is_empty() {
                journal.remove()?;
            }
            return Err(error);
        }
        Ok(journal)
    }

    /// Compares with the folder's record, or writes it if there is none.
    fn claim(&self, record: &str, shard: Option<Shard>) -> Result<(), DatasetError> {
        if self.record().exists() {
            self.compare(record, shard)?;
            return sweep(&self.root);
        }
        self.refuse_foreign()?;
        sweep(&self.root)?;
        let path = self.root.join(SHARD);
        if let Some(shard) = shard {
            write(&path, format!("shard: {shard}\n").as_bytes())?;
        } else if path.exists() {
            fs::remove_file(&path).map_err(DatasetError::io("remove", &path))?;
        }
        // Last, since a folder with a record counts as a dataset of ours.
        write(&self.record(), record.as_bytes())
    }

    fn compare(&self, record: &str, shard: Option<Shard>) -> Result<(), DatasetError> {
        let path = self.record();
        let parse = |text: &str| -> Result<Value, DatasetError> {
            serde_yaml::from_str(text).map_err(|error| DatasetError::damaged(&path, &error))
        };
        let mut found = differences(&parse(&self.read_record()?)?, &parse(record)?);
        let (there, here) = (self.shard()?, shard);
        if there != here {
            let name = |shard: Option<Shard>| shard.map_or("none".to_owned(), String::from);
            found.push(format!("shard: {} there, {} here", name(there), name(here)));
        }
        if found.is_empty() {
            return Ok(());
        }
        Err(DatasetError::Differs {
            folder: self.root.clone(),
            differences: found,
        })
    }

    /// The text of run.yaml.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn read_record(&self) -> Result<String, DatasetError> {
        let path = self.record();
        fs::read_to_string(&path).map_err(DatasetError::io("read", &path))
    }

    /// Writes run.yaml.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_record(&self, record: &str) -> Result<(), DatasetError> {
        write(&self.record(), record.as_bytes())
    }

    /// Which shard of a dataset this folder holds; `None` for a whole dataset.
    ///
    /// # Errors
    /// shard.yaml cannot be read.
    pub fn shard(&self) -> Result<Option<Shard>, DatasetError> {
        let path = self.root.join(SHARD);
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(DatasetError::io("read", &path)(error)),
        };
        let parsed: BTreeMap<String, Shard> =
            serde_yaml::from_str(&text).map_err(|error| DatasetError::damaged(&path, &error))?;
        let shard = parsed.get("shard").copied();
        shard
            .map(Some)
            .ok_or_else(|| DatasetError::damaged(&path, &"it names no shard"))
    }

    /// Rows of the finished dataset; `None` while it is not finished.
    ///
    /// # Errors
    /// The manifest cannot be read.
    pub fn rows(&self) -> Result<Option<Vec<Row>>, DatasetError> {
        let path = self.manifest();
        match fs::read(&path) {
            Ok(text) => {
                let rows = from_csv(&text).map_err(|error| DatasetError::damaged(&path, &error))?;
                Ok(Some(rows))
            }
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(DatasetError::io("read", &path)(error)),
        }
    }

    /// Writes manifest.csv.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_rows(&self, rows: &[Row]) -> Result<(), DatasetError> {
        let path = self.manifest();
        let text = to_csv(rows, true).map_err(|error| DatasetError::damaged(&path, &error))?;
        write(&path, &text)
    }

    /// Removes manifest.csv: the dataset is no longer finished.
    ///
    /// # Errors
    /// The file cannot be removed.
    pub fn remove_rows(&self) -> Result<(), DatasetError> {
        let path = self.manifest();
        fs::remove_file(&path).map_err(DatasetError::io("remove", &path))
    }

    /// Refuses a folder without a record that holds anything but the leftovers of a run killed before it wrote its record.
    fn refuse_foreign(&self) -> Result<(), DatasetError> {
        if self.record().exists() || !self.root.exists() {
            return Ok(());
        }
        let ours = |name: &str| {
            name == JOURNAL || name == SHARD || name.starts_with(whole_file::UNFINISHED)
        };
        match list(&self.root)?.into_iter().find(|(name, _)| !ours(name)) {
            None => Ok(()),
            Some((found, _)) => Err(DatasetError::Foreign {
                folder: self.root.clone(),
                found,
            }),
        }
    }

    /// Whether the folder does not exist yet, or is empty.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn is_vacant(&self) -> Result<bool, DatasetError> {
        Ok(!self.root.exists() || list(&self.root)?.is_empty())
    }
}

/// Removes drafts of files that a killed run left.
fn sweep(folder: &Path) -> Result<(), DatasetError> {
    for (name, path) in list(folder)? {
        if name.starts_with(whole_file::UNFINISHED) {
            fs::remove_file(&path).map_err(DatasetError::io("remove", &path))?;
        }
    }
    Ok(())
}

fn list(folder: &Path) -> Result<Vec<(String, PathBuf)>, DatasetError> {
    let entries = fs::read_dir(folder).map_err(DatasetError::io("read", folder))?;
    let mut found = Vec::new();
    for entry in entries {
        let entry = entry.map_err(DatasetError::io("read", folder))?;
        found.push((entry.file_name().to_string_lossy().into(), entry.path()));
    }
    found.sort();
    Ok(found)
}

/// Writes a file whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
    whole_file::write(path, bytes).map_err(DatasetError::io("write", path))
}
