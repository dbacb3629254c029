//! Where the mesh goes.

use anyhow::{Result, ensure};
use mesh::Mesh;
use mesh::file::{MILLIMETRE, write_ply};
use nalgebra::Point3;
use sim_dataset::object::Source;
use std::path::{Path, PathBuf};

/// A file that does not hold another object.
#[derive(Debug)]
pub struct Target {
    path: PathBuf,
    force: bool,
}

impl Target {
    /// FOLDER/NAME.ply.
    ///
    /// # Errors
    /// The name cannot be a label, or there is such a file and it is not to be replaced.
    pub fn new(folder: &Path, name: &str, force: bool) -> Result<Self> {
        ensure!(
            folder.is_dir(),
            "--save {}: there is no such folder",
            folder.display()
        );
        let file = PathBuf::from(format!("{name}.ply"));
        let path = match folder.to_str() {
            Some(".") => file.clone(),
            _ => folder.join(&file),
        };
        // The rules are those of the datasets that will be made of it.
        let source = Source::Scan {
            file,
            metres_per_unit: MILLIMETRE,
        };
        ensure!(
            source.name().is_ok_and(|label| label == name),
            "{name:?} cannot name an object; use letters, digits, - and _"
        );
        let target = Self { path, force };
        target.check()?;
        Ok(target)
    }

    fn check(&self) -> Result<()> {
        ensure!(
            self.force || !self.path.exists(),
            "{} exists already; give another name, or --force to replace it",
            self.path.display()
        );
        Ok(())
    }

    /// Writes clouds (m) beside it, NAME.grasp_1.ply and so on, over those of an earlier try; gives the files' paths.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn keep(&self, grasps: &[&[Point3<f32>]]) -> Result<Vec<PathBuf>> {
        let write = |(at, points): (usize, &&[Point3<f32>])| {
            let file = self.path.with_extension(format!("grasp_{}.ply", at + 1));
            cloud::write_ply(&file, points)?;
            Ok(file)
        };
        grasps.iter().enumerate().map(write).collect()
    }

    /// Writes the mesh, whole or not at all; gives the file's path.
    ///
    /// # Errors
    /// The file cannot be written, or a file of the same name has appeared since the recording began.
    pub fn write(&self, mesh: &Mesh) -> Result<&Path> {
        self.check()?;
        write_ply(&self.path, mesh)?;
        Ok(&self.path)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::fs;

    #[test]
    fn names_that_are_no_label_and_files_that_are_there_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let refusal = |name: &str| {
            let error = Target::new(folder.path(), name, false).unwrap_err();
            error.to_string()
        };
        for name in ["", "a/b", "my can", ".can", "../can"] {
            assert!(refusal(name).contains("cannot name an object"), "{name}");
        }
        let target = Target::new(folder.path(), "can", false).unwrap();
        fs::write(folder.path().join("can.ply"), "mine").unwrap();
        assert!(refusal("can").contains("--force"));
        let cuboid = Mesh::cylinder(0.03, 0.0, 0.1, 8);
        assert!(target.write(&cuboid).is_err(), "made meanwhile");
        assert_eq!(fs::read(folder.path().join("can.ply")).unwrap(), b"mine");
        let target = Target::new(folder.path(), "can", true).unwrap();
        target.write(&cuboid).unwrap();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        let points = [Point3::new(0.1, 0.2, 0.3)];
        let kept = target.keep(&[&points[..], &[][..]]).unwrap();
        assert_eq!(cloud::read(&kept[0]).unwrap().points, points);
        assert_eq!(kept[1], folder.path().join("can.grasp_2.ply"));
        let nowhere = Target::new(&folder.path().join("no"), "can", false);
        assert!(nowhere.unwrap_err().to_string().contains("no such folder"));
    }
}
