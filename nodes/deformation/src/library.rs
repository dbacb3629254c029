//! References by label: files of a folder.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use mesh::file::{self, FileError, MILLIMETRE};

use crate::reference::{Reference, ReferenceError};

/// Undeformed objects by label.
///
/// Each is prepared when it is first asked for, and again when its file has changed. A file that is put into the folder
/// later is found, too.
pub struct Library {
    folder: PathBuf,
    prepared: Mutex<BTreeMap<String, Prepared>>,
}

/// A reference, and when its file was written.
struct Prepared {
    reference: Arc<Reference>,
    written: Option<SystemTime>,
}

/// No reference for a label.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// The folder cannot be listed.
    #[error("references: the folder {} cannot be read; name one with LABEL.ply or LABEL.obj, or leave it empty", path.display())]
    Folder {
        /// As the user named it.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The system does not say where the program is.
    #[error("cannot tell where this program is; name the folder of references")]
    Program(#[source] std::io::Error),
    /// Nobody has put one there.
    #[error(
        "no reference for the label '{label}': put {label}.ply, in millimetres, into {}",
        named(folder)
    )]
    NoReference {
        /// What was asked for.
        label: String,
        /// Where it is looked for; empty: nowhere.
        folder: PathBuf,
    },
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// Its mesh cannot serve.
    #[error("the reference {} {source}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Why not.
        source: ReferenceError,
    },
}

impl Library {
    /// Lists the folder; an empty path means that there are none.
    ///
    /// # Errors
    /// [`LibraryError::Folder`].
    pub fn open(folder: impl AsRef<Path>) -> Result<Self, LibraryError> {
        let library = Self {
            folder: folder.as_ref().to_owned(),
            prepared: Mutex::default(),
        };
        library.files()?;
        Ok(library)
    }

    /// Labels that have a reference now, in alphabetical order.
    pub fn labels(&self) -> Vec<String> {
        self.files().unwrap_or_default().into_keys().collect()
    }

    /// The reference of a label.
    ///
    /// # Errors
    /// There is none, or it cannot be used.
    pub fn get(&self, label: &str) -> Result<Arc<Reference>, LibraryError> {
        let path = self.path(label)?;
        let written = fs::metadata(&path).and_then(|file| file.modified()).ok();
        if let Some(prepared) = self.prepared().get(label)
            && prepared.written == written
        {
            return Ok(Arc::clone(&prepared.reference));
        }
        // Unlocked meanwhile: who asks for another one does not wait.
        let mesh = file::read(&path, MILLIMETRE)?.mesh();
        let reference = Reference::new(path.display().to_string(), &mesh);
        let reference = Arc::new(reference.map_err(unusable(&path))?);
        let prepared = Prepared {
            reference: Arc::clone(&reference),
            written,
        };
        self.prepared().insert(label.to_owned(), prepared);
        Ok(reference)
    }

    /// Whether a label's file can serve; much quicker than [`Library::get`].
    ///
    /// # Errors
    /// There is none, or it cannot be used.
    pub fn check(&self, label: &str) -> Result<(), LibraryError> {
        let path = self.path(label)?;
        let mesh = file::read(&path, MILLIMETRE)?.mesh();
        Reference::check(&mesh).map_err(unusable(&path))
    }

    fn path(&self, label: &str) -> Result<PathBuf, LibraryError> {
        self.files()?
            .remove(label)
            .ok_or_else(|| LibraryError::NoReference {
                label: label.to_owned(),
                folder: self.folder.clone(),
            })
    }

    /// The folder's meshes by label.
    fn files(&self) -> Result<BTreeMap<String, PathBuf>, LibraryError> {
        let mut files = BTreeMap::new();
        if self.folder == Path::new("") {
            return Ok(files);
        }
        let in_folder = |source| LibraryError::Folder {
            path: self.folder.clone(),
            source,
        };
        for entry in fs::read_dir(&self.folder).map_err(in_folder)? {
            let path = entry.map_err(in_folder)?.path();
            let extension = path.extension().and_then(OsStr::to_str);
            let is_mesh = matches!(extension, Some("ply" | "obj"));
            if let (true, Some(label)) = (is_mesh, path.file_stem().and_then(OsStr::to_str)) {
                files.insert(label.to_owned(), path);
            }
        }
        Ok(files)
    }

    fn prepared(&self) -> MutexGuard<'_, BTreeMap<String, Prepared>> {
        self.prepared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A folder of references, or how to name one.
fn named(folder: &Path) -> String {
    match folder == Path::new("") {
        true => "a folder, and name it with the parameter references".to_owned(),
        false => folder.display().to_string(),
    }
}

fn unusable(path: &Path) -> impl FnOnce(ReferenceError) -> LibraryError {
    let path = path.to_owned();
    move |source| LibraryError::Unusable { path, source }
}

/// The shipped references: `config/references` of the checkout or of the installed package that the program is in.
///
/// # Errors
/// [`LibraryError::Program`]. Whether the folder is there, [`Library::open`] says.
pub fn shipped_references() -> Result<PathBuf, LibraryError> {
    let executable = std::env::current_exe().map_err(LibraryError::Program)?;
    // target/release/PROGRAM in the checkout, lib/deformable_cobot/PROGRAM where it is installed.
    let root = executable.ancestors().nth(3).unwrap_or(Path::new("/"));
    let checkout = root.join("config/references");
    Ok(if checkout.is_dir() {
        checkout
    } else {
        root.join("share/deformable_cobot/config/references")
    })
}

#[cfg(test)]
mod tests;
