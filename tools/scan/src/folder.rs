//! A scan on disk.

mod description;

use crate::deformation::DEVIATION;
use crate::page::page;
use crate::recording::Recorded;
use anyhow::{Context, Result, ensure};
use description::{DescribedView, Description};
use msg::deformable_cobot::{Classification, Deformation};
use msg::sensor_msgs::PointCloud2;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder that is filled beside its place, and put there when it is whole.
pub struct Folder {
    target: PathBuf,
    unfinished: PathBuf,
}

impl Folder {
    /// Prepares to save at `target`. Nothing is written yet.
    ///
    /// # Errors
    /// `target` exists already, is no name for a folder, or its parent does not exist.
    pub fn beside(target: &Path) -> Result<Self> {
        let target = std::path::absolute(target)?;
        ensure!(
            !target.exists(),
            "--save {}: it exists already; name another folder",
            target.display()
        );
        let (parent, name) = (target.parent(), target.file_name());
        let (Some(parent), Some(name)) = (parent, name) else {
            anyhow::bail!("--save {}: this is no name for a folder", target.display());
        };
        ensure!(
            parent.is_dir(),
            "--save {}: there is no folder {}",
            target.display(),
            parent.display()
        );
        let unfinished = parent.join(format!(
            ".{}.{}",
            name.to_string_lossy(),
            std::process::id()
        ));
        Ok(Self { target, unfinished })
    }

    /// Writes the scan's folder, whole or not at all, and returns its path.
    ///
    /// # Errors
    /// A file cannot be written, or the folder was made by somebody else meanwhile.
    pub fn save(
        self,
        scan: &Recorded,
        answer: &Classification,
        deformation: Option<&Deformation>,
    ) -> Result<PathBuf> {
        let at = |what| format!("cannot {what} {}", self.unfinished.display());
        fs::create_dir(&self.unfinished).with_context(|| at("make"))?;
        self.fill(scan, answer, deformation)?;
        // An empty folder would be replaced.
        ensure!(
            !self.target.exists(),
            "{} was made meanwhile",
            self.target.display()
        );
        fs::rename(&self.unfinished, &self.target).with_context(|| at("rename"))?;
        Ok(self.target.clone())
    }

    fn fill(
        &self,
        scan: &Recorded,
        answer: &Classification,
        deformation: Option<&Deformation>,
    ) -> Result<()> {
        let write = |name: &str, cloud: &PointCloud2| -> Result<usize> {
            let points = msg::cloud::to_points(cloud)?.points;
            cloud::write_pcd(self.unfinished.join(name), &points)?;
            Ok(points.len())
        };
        let mut views = Vec::new();
        for (index, view) in scan.views.iter().take(scan.registered.view_count as usize) {
            let file = format!("view_{}.pcd", index + 1);
            let points = write(&file, &view.cloud)?;
            let mut registrations = scan.registered.views.iter();
            let registration = registrations.find(|entry| entry.index == *index);
            views.push(DescribedView::new(file, view, points, registration));
        }
        let mut description = Description::of(scan, answer, deformation);
        description.object_points = self.write_object(scan, deformation)?;
        description.registered_points = write("registered.pcd", &scan.registered.cloud)?;
        description.views = views;
        self.write("scan.yaml", &serde_yaml::to_string(&description)?)?;
        self.write("scan.html", &page(scan, answer, deformation)?)
    }

    /// With a field of deviations where they were measured.
    fn write_object(&self, scan: &Recorded, deformation: Option<&Deformation>) -> Result<usize> {
        let path = self.unfinished.join("object.pcd");
        let measured = deformation.filter(|found| !found.cloud.data.is_empty());
        let points = match measured {
            None => {
                let points = msg::cloud::to_points(&scan.object.cloud)?.points;
                cloud::write_pcd(path, &points)?;
                points
            }
            Some(found) => {
                let points = msg::cloud::to_points(&found.cloud)?.points;
                let deviations = msg::cloud::values(&found.cloud, DEVIATION)?;
                cloud::write_pcd_field(path, &points, DEVIATION, &deviations)?;
                points
            }
        };
        Ok(points.len())
    }

    fn write(&self, name: &str, text: &str) -> Result<()> {
        let path = self.unfinished.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // After a success there is nothing to remove, after a failure perhaps nothing either.
        let _ = fs::remove_dir_all(&self.unfinished);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use msg::cloud::from_points;
    use msg::deformable_cobot::View;
    use msg::std_msgs::Header;
    use nalgebra::Point3;

    fn scan() -> Recorded {
        let cloud = from_points(Header::default(), &[Point3::new(0.1, 0.2, 0.3)]);
        let view = View {
            cloud: cloud.clone(),
            count: 1,
            ..Default::default()
        };
        let mut scan = Recorded {
            views: [(0, view)].into(),
            ..Default::default()
        };
        scan.registered.cloud = cloud.clone();
        scan.registered.view_count = 1;
        scan.object.cloud = cloud;
        scan
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_is_there_whole_or_not_at_all() {
        let parent = tempfile::tempdir().unwrap();
        let target = parent.path().join("can");
        let saved = Folder::beside(&target)
            .unwrap()
            .save(&scan(), &Classification::default(), None)
            .unwrap();
        assert_eq!(saved, target);
        assert_eq!(
            names(&target),
            [
                "object.pcd",
                "registered.pcd",
                "scan.html",
                "scan.yaml",
                "view_1.pcd"
            ]
        );
        let error = Folder::beside(&target).err().unwrap().to_string();
        assert!(error.contains("exists already"), "{error}");

        let mut broken = scan();
        broken.object.cloud.fields.clear();
        let other = parent.path().join("cup");
        assert!(
            Folder::beside(&other)
                .unwrap()
                .save(&broken, &Classification::default(), None)
                .is_err()
        );
        assert_eq!(names(parent.path()), ["can"]);
    }

    #[test]
    fn deviations_are_a_field_of_the_object() {
        let parent = tempfile::tempdir().unwrap();
        let scan = scan();
        let points = [Point3::new(0.1, 0.2, 0.3)];
        let deformation = Deformation {
            cloud: msg::cloud::with_field(Header::default(), &points, DEVIATION, &[-0.004]),
            summary: "dented: 4 mm at 61 mm height".into(),
            ..Default::default()
        };
        let target = Folder::beside(&parent.path().join("can"))
            .unwrap()
            .save(&scan, &Classification::default(), Some(&deformation))
            .unwrap();
        let object = fs::read(target.join("object.pcd")).unwrap();
        assert!(String::from_utf8_lossy(&object).contains("FIELDS x y z deviation"));
        assert!(object.ends_with(&(-0.004f32).to_le_bytes()));
        let described = fs::read_to_string(target.join("scan.yaml")).unwrap();
        assert!(described.contains("summary: 'dented: 4 mm at 61 mm height'"));
    }

    #[test]
    fn a_folder_without_parent_is_refused() {
        let error = Folder::beside(Path::new("/no/such/place"))
            .err()
            .unwrap()
            .to_string();
        assert!(error.contains("there is no folder /no/such"), "{error}");
    }
}
