//! The real scans and views that there are, each named once.
//!
//! Nothing is chosen by them: neither a setting nor a threshold, nor which of two models is kept.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use classifier::{Answer, Model};
use icp_registration::{InitialGuess, Registrar};
use nalgebra::Point3;
use roi_crop::{Axis, Cropper, Frame};
use serde::Serialize;
use sim_objects::ObjectClass;

/// What is said of one object.
#[derive(Debug, Clone, Serialize)]
pub struct RealAnswer {
    /// Which file, below the folder.
    pub name: String,
    /// What is right to say; `unknown`: that it is not known.
    pub right: Vec<String>,
    /// `None` where so little is seen that the robot would call the hand empty.
    pub said: Option<Said>,
}

/// An answer.
#[derive(Debug, Clone, Serialize)]
pub struct Said {
    /// The most probable label.
    pub label: String,
    /// Its probability.
    pub probability: f64,
    /// Whether the score reaches the threshold.
    pub known: bool,
    /// How much the cloud is like what the model knows.
    pub score: f64,
    /// Of the model.
    pub threshold: f64,
}

/// How a scene is cut out.
struct Scene {
    up: &'static str,
    keep_above_m: f64,
}

/// Scans and views that hold the object alone, +z up.
const CUT_OUT: Scene = Scene {
    up: "+z",
    keep_above_m: -100.0,
};
/// A can on a box, which fills what is below, in three views by a D435i.
const CAPTURES: (&str, ObjectClass, Scene) = (
    "captures/can_a",
    ObjectClass::MediumCan,
    Scene {
        up: "+y",
        keep_above_m: -0.115,
    },
);
/// Scans are in mm, views in m.
const METRES_PER_SCAN_UNIT: f32 = 0.001;
/// How a note begins the line of what is right.
const RIGHT: &str = "- the product should say:";

/// Names all objects below a folder: `captures/can_a` (views of one can on a box), `scans/OBJECT.ply` (whole surfaces in mm),
/// `elsewhere/NAME/view.ply` (single views, what is right to say in `source.md` beside it).
///
/// # Errors
/// A file is missing or damaged, or the network fails.
pub fn measure(model: &mut Model, folder: &Path) -> Result<Vec<RealAnswer>> {
    let mut answers = captures(model, folder)?;
    for path in sorted(&folder.join("scans"))? {
        let points = read(&path, METRES_PER_SCAN_UNIT)?;
        let object = path.file_stem().unwrap_or_default().to_string_lossy();
        let object: ObjectClass = object.parse()?;
        answers.push(RealAnswer {
            name: format!("scans/{object}"),
            right: vec![object.name().to_owned()],
            said: named(model, &[points], &CUT_OUT)?,
        });
    }
    for path in sorted(&folder.join("elsewhere"))? {
        let note = path.join("source.md");
        let text =
            fs::read_to_string(&note).with_context(|| format!("cannot read {}", note.display()))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        answers.push(RealAnswer {
            name: format!("elsewhere/{name}"),
            right: right(&text).with_context(|| format!("{} lacks '{RIGHT}'", note.display()))?,
            said: named(model, &[read(&path.join("view.ply"), 1.0)?], &CUT_OUT)?,
        });
    }
    Ok(answers)
}

/// Each view of the can alone, and all of them registered without kinematics.
fn captures(model: &mut Model, folder: &Path) -> Result<Vec<RealAnswer>> {
    let (place, truth, scene) = CAPTURES;
    let paths = sorted(&folder.join(place))?;
    let views: Vec<Vec<Point3<f32>>> = paths
        .iter()
        .map(|path| read(path, 1.0))
        .collect::<Result<_>>()?;
    let each = (0..views.len()).map(|index| (format!("view {}", index + 1), &views[index..=index]));
    let all = [(format!("{} views", views.len()), &views[..])];
    let answer = |(name, views): (String, &[Vec<Point3<f32>>])| {
        Ok(RealAnswer {
            name: format!("{place}, {name}"),
            right: vec![truth.name().to_owned()],
            said: named(model, views, &scene)?,
        })
    };
    each.chain(all).map(answer).collect()
}

fn sorted(folder: &Path) -> Result<Vec<PathBuf>> {
    let missing = || format!("cannot read the folder {}", folder.display());
    let entries = fs::read_dir(folder).with_context(missing)?;
    let paths = entries.map(|entry| Ok(entry?.path()));
    let mut paths = paths.collect::<Result<Vec<_>>>().with_context(missing)?;
    ensure!(!paths.is_empty(), "{} is empty", folder.display());
    paths.sort();
    Ok(paths)
}

fn read(path: &Path, metres_per_unit: f32) -> Result<Vec<Point3<f32>>> {
    let points = cloud::read(path)?.points;
    Ok(points.iter().map(|point| point * metres_per_unit).collect())
}

/// `a or b` as a list.
fn right(note: &str) -> Option<Vec<String>> {
    let line = note.lines().find_map(|line| line.strip_prefix(RIGHT))?;
    Some(line.trim().split(" or ").map(str::to_owned).collect())
}

/// What the nodes make of views (m) without kinematics.
fn named(model: &mut Model, views: &[Vec<Point3<f32>>], scene: &Scene) -> Result<Option<Said>> {
    let mut registrar = Registrar::new(icp_registration::Parameters {
        initial_guess: InitialGuess::Identity,
        ..Default::default()
    })?;
    for view in views {
        registrar.add_view(view, None)?;
    }
    let cropper = Cropper::new(roi_crop::Parameters {
        up_axis: scene.up.parse::<Axis>()?,
        keep_above_m: scene.keep_above_m,
        ..Default::default()
    })?;
    let object = cropper.crop(&registrar.cloud(), Frame::Camera)?;
    if !cropper.is_object(object.points.len()) {
        return Ok(None);
    }
    let answer = model.classify(&object.points, &object.up)?;
    let is_trusted = registrar.doubt().is_none();
    Ok(Some(Said::of(answer, is_trusted)))
}

impl Said {
    fn of(answer: Answer, is_trusted: bool) -> Self {
        Self {
            label: answer.label,
            probability: answer.probability,
            known: answer.known && is_trusted,
            score: answer.known_score,
            threshold: answer.known_threshold,
        }
    }
}

impl RealAnswer {
    /// What is to be thought of it.
    pub fn verdict(&self) -> Verdict {
        let names = |label: &str| self.right.iter().any(|right| right == label);
        match &self.said {
            Some(said) if said.known && names(&said.label) => Verdict::Right,
            Some(said) if said.known => Verdict::KnownWrong,
            _ if names("unknown") => Verdict::Right,
            Some(said) if names(&said.label) => Verdict::RightUnknown,
            _ => Verdict::WrongUnknown,
        }
    }
}

/// What is to be thought of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Known and rightly named, or rightly called unknown.
    Right,
    /// The label is right, and yet it is called unknown.
    RightUnknown,
    /// Wrongly named, and called unknown.
    WrongUnknown,
    /// Wrongly named or a stranger, and called known.
    KnownWrong,
}

impl Verdict {
    fn text(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::RightUnknown => "right, but unknown",
            Self::WrongUnknown => "unknown",
            Self::KnownWrong => "known and wrong",
        }
    }
}

/// A table for people, in Markdown.
pub fn to_text(answers: &[RealAnswer]) -> String {
    let mut text = "| object | right is | label | probability | known | score | threshold | |\n\
                    |---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for answer in answers {
        let said = match &answer.said {
            Some(said) => format!(
                "{} | {:.2} | {} | {:.1} | {:.1}",
                said.label,
                said.probability,
                if said.known { "yes" } else { "no" },
                said.score,
                said.threshold
            ),
            None => "too little is seen | | no | | ".to_owned(),
        };
        let (right, verdict) = (answer.right.join(" or "), answer.verdict().text());
        text += &format!("| {} | {right} | {said} | {verdict} |\n", answer.name);
    }
    let count = |verdict| answers.iter().filter(|a| a.verdict() == verdict).count();
    text + &format!(
        "\n{} answers: {} right, {} rightly named but unknown, {} unknown, {} known and wrong\n",
        answers.len(),
        count(Verdict::Right),
        count(Verdict::RightUnknown),
        count(Verdict::WrongUnknown),
        count(Verdict::KnownWrong),
    )
}

#[cfg(test)]
mod tests;
