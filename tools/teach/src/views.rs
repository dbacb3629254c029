//! An object from recorded views of it.

use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use icp_registration::{InitialGuess, Parameters, Registrar};
use mesh::file::Scan;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion};
use record_object::with_lower_end;
use roi_crop::{Cropper, Frame};
use serde::Deserialize;
use sim_reconstruct::check_one_object;

use crate::look::Watch;

/// Fewer views do not show an object from all sides.
const VIEWS_MIN: usize = 3;
/// Less than this of a turn is no object, but a part of one; as `record_object` has it.
const SEEN_MIN_RAD: f64 = 0.9 * TAU;
/// Directions about the object's axis that are told apart.
const SECTORS: usize = 36;
/// Why there is no object.
const EMPTY: &str = "the hand is empty in these views; put the object into it and scan again";
/// What `scan --save` writes beside its views.
const DESCRIPTION: &str = "scan.yaml";

#[derive(Deserialize)]
struct Description {
    views: Vec<DescribedView>,
}

#[derive(Deserialize)]
struct DescribedView {
    file: PathBuf,
    hand_from_camera: Option<Pose>,
}

#[derive(Deserialize)]
struct Pose {
    translation_m: [f64; 3],
    /// x, y, z, w
    rotation: [f64; 4],
}

/// Registers views and gives the object's points, m, +z up. Views that `scan --save` wrote start at the hand's poses in the
/// scan.yaml beside them; the gripper is cut away, and the lower end that it hides is added. Others are taken
/// to lie already in one frame, of the object alone.
///
/// # Errors
/// A file that holds no cloud, too few views, too little of the object, or more than one object.
pub fn object_of(
    files: &[PathBuf],
    metres_per_unit: f64,
    watch: &Watch,
) -> Result<Vec<Point3<f32>>> {
    ensure!(
        files.len() >= VIEWS_MIN,
        "{} views are too few to show an object from all sides; at least {VIEWS_MIN} are needed",
        files.len()
    );
    let poses = poses_of(files)?;
    let parameters = Parameters {
        initial_guess: match poses {
            Some(_) => InitialGuess::Kinematic,
            None => InitialGuess::Identity,
        },
        ..Parameters::default()
    };
    let mut registrar = Registrar::new(parameters)?;
    let mut accepted = 0;
    for (index, file) in files.iter().enumerate() {
        watch.go_on()?;
        let mut cloud = cloud::read(file)?;
        let scale = metres_per_unit as f32;
        cloud.points.iter_mut().for_each(|point| *point *= scale);
        let pose = poses.as_ref().map(|poses| poses[index]);
        let found = registrar.add_view(&cloud.points, pose);
        let found = found.with_context(|| file.display().to_string())?;
        if !found.accepted {
            let (file, reason) = (file.display(), found.reason);
            program::note(format_args!("teach: {file} is left out: {reason}"));
        }
        accepted += usize::from(found.accepted);
        (watch.finished)();
    }
    ensure!(
        accepted >= VIEWS_MIN,
        "only {accepted} of {} views fit together, and {VIEWS_MIN} are needed; do they overlap, and is the unit right \
         (--units)?",
        files.len()
    );
    let points = match poses {
        None => {
            let points = registrar.cloud();
            check(&points)?;
            points
        }
        Some(_) => {
            let cropper = Cropper::new(roi_crop::Parameters::default())?;
            let crop = cropper.crop(&registrar.cloud(), Frame::Hand { opening_m: None });
            let crop = crop.context(EMPTY)?;
            ensure!(cropper.is_object(crop.points.len()), EMPTY);
            check(&crop.points)?;
            with_lower_end(&crop.points)
        }
    };
    Ok(points)
}

/// Refuses what is not one object that was seen from all sides.
fn check(points: &[Point3<f32>]) -> Result<()> {
    check_one_object(&Scan {
        points_m: points.to_vec(),
        ..Scan::default()
    })?;
    let seen_rad = seen_rad(points);
    ensure!(
        seen_rad >= SEEN_MIN_RAD,
        "the views show {:.0}° of 360° about the object, and {:.0}° are needed; add views of the other side",
        seen_rad.to_degrees(),
        SEEN_MIN_RAD.to_degrees()
    );
    Ok(())
}

/// Hand poses of all views; `None` where none is described.
fn poses_of(files: &[PathBuf]) -> Result<Option<Vec<Isometry3<f64>>>> {
    let mut descriptions: HashMap<PathBuf, Option<Description>> = HashMap::new();
    let (mut poses, mut missing) = (Vec::new(), None);
    for file in files {
        let folder = file.parent().unwrap_or(Path::new(""));
        let path = folder.join(DESCRIPTION);
        if !descriptions.contains_key(&path) {
            descriptions.insert(path.clone(), read(&path)?);
        }
        let description = descriptions.get(&path).and_then(Option::as_ref);
        let views = description.map_or(&[][..], |description| &description.views);
        let described = views
            .iter()
            .find(|view| Some(view.file.as_os_str()) == file.file_name());
        match described.and_then(|view| view.hand_from_camera.as_ref()) {
            Some(pose) => poses.push(
                pose.isometry()
                    .with_context(|| path.display().to_string())?,
            ),
            None => missing = Some(file),
        }
    }
    match missing {
        Some(file) if !poses.is_empty() => bail!(
            "{} has no pose of the hand in the {DESCRIPTION} beside it, and other views have one",
            file.display()
        ),
        Some(_) => Ok(None),
        None => Ok(Some(poses)),
    }
}

fn read(path: &Path) -> Result<Option<Description>> {
    if !path.is_file() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(path);
    let text = text.with_context(|| format!("cannot read {}", path.display()))?;
    let description = serde_yaml::from_str(&text);
    Ok(Some(description.with_context(|| {
        format!("{} is not as scan --save writes it", path.display())
    })?))
}

impl Pose {
    fn isometry(&self) -> Result<Isometry3<f64>> {
        let [x, y, z, w] = self.rotation;
        let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-3);
        let turn = turn.context("a rotation that is none")?;
        Ok(Isometry3::from_parts(
            Translation3::from(self.translation_m),
            turn,
        ))
    }
}

/// Over what angle about the vertical axis through the middle the points lie, rad.
fn seen_rad(points: &[Point3<f32>]) -> f64 {
    let Some(bounds) = cloud::bounds(points) else {
        return 0.0;
    };
    let centre = bounds.centre();
    let sector = |point: &Point3<f32>| {
        let angle_rad = f64::from((point.y - centre.y).atan2(point.x - centre.x));
        (angle_rad.rem_euclid(TAU) / TAU * SECTORS as f64) as usize % SECTORS
    };
    let seen: HashSet<usize> = points.iter().map(sector).collect();
    TAU * seen.len() as f64 / SECTORS as f64
}
