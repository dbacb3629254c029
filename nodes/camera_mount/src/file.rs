//! The file of a camera mount.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::CameraMount;

/// Why a mount was not written. The existing file is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum MountFileError {
    /// No file is named.
    #[error(
        "parameter file is empty: name the file that the mount is to be written to, e.g. config/camera_mount.yaml"
    )]
    NoFile,
    /// The file could not be written.
    #[error("cannot write {}: {source}; the mount of before is still there", .path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
}

/// The text of a new file for a mount.
pub fn content(mount: &CameraMount) -> String {
    let [translation_m, rotation_rpy_rad] = place(mount).map(|(_, value)| value);
    format!(
        "# Where the camera sits on the head, as calibrate_camera_mount found it.\n\
         parent_frame: {}\n\
         child_frame: {}          # root of the camera driver's frames\n\
         translation_m: {translation_m}\n\
         rotation_rpy_rad: {rotation_rpy_rad}   # roll, pitch, yaw; positive pitch looks down\n",
        mount.parent_frame, mount.child_frame,
    )
}

/// Writes a mount's position and rotation into its file, whole or not at all. Everything else in the file stays as the user
/// wrote it. The previous content is kept in a backup beside the file, with `.old` after its name, or `.old.2` and so on.
///
/// # Errors
/// [`MountFileError`]: no file is named, or it cannot be written.
pub fn write(mount: &CameraMount, path: &Path) -> Result<(), MountFileError> {
    if path.as_os_str().is_empty() {
        return Err(MountFileError::NoFile);
    }
    replace(path, mount).map_err(|source| MountFileError::Write {
        path: path.to_owned(),
        source,
    })
}

fn replace(path: &Path, mount: &CameraMount) -> io::Result<()> {
    // Follow symbolic links, as in a catkin workspace built with links, instead of replacing them.
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let before = match std::fs::read_to_string(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        before => Some(before?),
    };
    let edited = before.as_deref().and_then(|text| edited(text, mount));
    if let Some(before) = before {
        let folder = path
            .parent()
            .filter(|folder| !folder.as_os_str().is_empty());
        let mut old = tempfile::NamedTempFile::new_in(folder.unwrap_or(Path::new(".")))?;
        old.write_all(before.as_bytes())?;
        keep(old, &path)?;
    }
    let text = edited.unwrap_or_else(|| content(mount));
    whole_file::write(&path, text.as_bytes())
}

/// Gives the backup the first free name after `path`; replaces no existing file.
fn keep(mut old: tempfile::NamedTempFile, path: &Path) -> io::Result<()> {
    for number in 1.. {
        let mut name = path.to_owned().into_os_string();
        name.push(".old");
        if number > 1 {
            name.push(format!(".{number}"));
        }
        match old.persist_noclobber(name) {
            Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => old = error.file,
            result => return result.map(drop).map_err(|error| error.error),
        }
    }
    Ok(())
}

/// Keys and values that a calibration changes.
fn place(mount: &CameraMount) -> [(&'static str, String); 2] {
    let numbers =
        |values: [f64; 3]| format!("[{}]", values.map(|value| format!("{value:.6}")).join(", "));
    [
        ("translation_m", numbers(mount.translation_m)),
        ("rotation_rpy_rad", numbers(mount.rotation_rpy_rad)),
    ]
}

/// The text of a mount's file with another position and rotation; `None` if these keys cannot be found in it.
fn edited(text: &str, mount: &CameraMount) -> Option<String> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for (key, value) in place(mount) {
        let start = format!("{key}:");
        let Some(index) = lines.iter().position(|line| line.starts_with(&start)) else {
            lines.push(format!("{start} {value}"));
            continue;
        };
        // A value may extend over several lines.
        let is_rest = |line: &&String| line.starts_with([' ', '-', ']']);
        let rest = lines.iter().skip(index + 1).take_while(is_rest).count();
        let old: Vec<String> = lines.drain(index..=index + rest).collect();
        let comments: Vec<&str> = old.iter().filter_map(|line| comment(line)).collect();
        let new = format!("{start} {value}   {}", comments.join(" "));
        lines.insert(index, new.trim_end().to_owned());
    }
    let edited = lines.join("\n") + "\n";
    let read: CameraMount = serde_yaml::from_str(&edited).ok()?;
    (place(&read) == place(mount)).then_some(edited)
}

/// The comment at the end of a line. The values are numbers, so that a "#" always starts a comment.
fn comment(line: &str) -> Option<&str> {
    line.find(" #").map(|at| line[at..].trim())
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
    fn what_is_written_is_read_back_and_all_before_it_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mount.yaml");
        for x_m in [0.1, 0.2, 0.3, 0.4] {
            write(&mount(x_m), &path).unwrap();
        }
        let read = |name: &str| -> CameraMount {
            serde_yaml::from_str(&std::fs::read_to_string(folder.path().join(name)).unwrap())
                .unwrap()
        };
        assert_eq!(read("mount.yaml"), mount(0.4));
        assert_eq!(read("mount.yaml.old"), mount(0.1));
        assert_eq!(read("mount.yaml.old.2"), mount(0.2));
        assert_eq!(read("mount.yaml.old.3"), mount(0.3));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
    }

    #[test]
    fn what_the_user_wrote_stays() {
        let before = "# our robot, measured in May\n\
                      translation_m:\n- 0.5\n- 0.0   # middle\n- 0.1\n\
                      rotation_rpy_rad: [0.0, 0.1,\n  0.0]   # from CAD\n\
                      calibration:\n  view_count: 6   # it is slow\n";
        let after = "# our robot, measured in May\n\
                     translation_m: [0.250000, 0.000000, 0.000000]   # middle\n\
                     rotation_rpy_rad: [0.000000, 0.179770, 0.000000]   # from CAD\n\
                     calibration:\n  view_count: 6   # it is slow\n";
        let moved = CameraMount {
            rotation_rpy_rad: [0.0, 0.17977, 0.0],
            ..mount(0.25)
        };
        assert_eq!(edited(before, &moved).as_deref(), Some(after));
        let nested = "camera_mount:\n  translation_m: [0.0, 0.0, 0.0]\n";
        assert_eq!(edited(nested, &moved), None, "no mount's file");
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
