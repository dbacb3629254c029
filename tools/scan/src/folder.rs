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
mod tests;
