//! The file that holds a mount.

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::CameraMount;

/// Why a mount was not written; the file of before is as it was.
#[derive(Debug, thiserror::Error)]
pub enum MountFileError {
    /// No file is named.
    #[error(
        "parameter file is empty: name the file that the mount is to be written to, e.g. config/camera_mount.yaml"
    )]
    NoFile,
    /// The disk says no.
    #[error("cannot write {}: {source}; the mount of before is still there", .path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// The content of a mount's file.
pub fn content(mount: &CameraMount) -> String {
    let numbers = |values: [f64; 3]| values.map(|value| format!("{value:.6}")).join(", ");
    format!(
        "# Where the camera sits on the head, as calibrate_camera_mount found it.\n\
         parent_frame: {}\n\
         child_frame: {}          # root of the camera driver's frames\n\
         translation_m: [{}]\n\
         rotation_rpy_rad: [{}]   # roll, pitch, yaw; positive pitch looks down\n",
        mount.parent_frame,
        mount.child_frame,
        numbers(mount.translation_m),
        numbers(mount.rotation_rpy_rad),
    )
}

/// Writes a mount, whole or not at all. What the file held before is kept beside it, with `.old` after its name.
///
/// # Errors
/// Names the file and why.
pub fn write(mount: &CameraMount, path: &Path) -> Result<(), MountFileError> {
    if path.as_os_str().is_empty() {
        return Err(MountFileError::NoFile);
    }
    replace(path, &content(mount)).map_err(|source| MountFileError::Write {
        path: path.to_owned(),
        source,
    })
}

fn replace(path: &Path, content: &str) -> std::io::Result<()> {
    // A link, as in a workspace that was built with links, stays one.
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let mut file = tempfile::NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))?;
    file.write_all(content.as_bytes())?;
    file.as_file().sync_all()?;
    if path.exists() {
        let mut old = path.clone().into_os_string();
        old.push(".old");
        std::fs::copy(&path, old)?;
        file.as_file()
            .set_permissions(std::fs::metadata(&path)?.permissions())?;
    }
    file.persist(&path)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn mount(x_m: f64) -> CameraMount {
        CameraMount {
            translation_m: [x_m, 0.0, 0.0],
            ..Default::default()
        }
    }

    #[test]
    fn what_is_written_is_read_back_and_the_old_one_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mount.yaml");
        write(&mount(0.1), &path).unwrap();
        write(&mount(0.2), &path).unwrap();
        let read = |path: &Path| -> CameraMount {
            serde_yaml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
        };
        assert_eq!(read(&path), mount(0.2));
        assert_eq!(read(&folder.path().join("mount.yaml.old")), mount(0.1));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_folder_that_is_missing_is_named() {
        let path = Path::new("/nonexistent/mount.yaml");
        let error = write(&mount(0.1), path).unwrap_err().to_string();
        assert!(error.contains("/nonexistent/mount.yaml"), "{error}");
        assert!(matches!(
            write(&mount(0.1), Path::new("")),
            Err(MountFileError::NoFile)
        ));
    }
}
