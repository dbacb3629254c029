//! What `scan.yaml` says of a scan.

use crate::deformation::to_json;
use crate::recording::Recorded;
use msg::deformable_cobot::{Classification, Deformation, View, ViewRegistration};
use msg::geometry_msgs::Transform;
use serde::Serialize;
use std::collections::BTreeMap;

/// scan.yaml.
#[derive(Debug, Serialize)]
pub(super) struct Description<'a> {
    scan_id: &'a str,
    label: &'a str,
    known: bool,
    #[serde(skip_serializing_if = "str::is_empty")]
    reason: &'a str,
    known_score: f64,
    known_threshold: f64,
    probability: f64,
    probabilities: BTreeMap<&'a str, f64>,
    model_id: &'a str,
    provider: &'a str,
    /// Frame of registered.pcd and object.pcd.
    frame: &'a str,
    pub object_points: usize,
    pub registered_points: usize,
    /// As `scan --json` has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    deformation: Option<serde_json::Value>,
    pub views: Vec<DescribedView<'a>>,
}

#[derive(Debug, Serialize)]
pub(super) struct DescribedView<'a> {
    file: String,
    frame: &'a str,
    stamp_s: f64,
    wrist_angle_rad: f64,
    points: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    hand_from_camera: Option<Pose>,
    #[serde(skip_serializing_if = "Option::is_none")]
    registered: Option<Registered<'a>>,
}

/// Where the view's points went.
#[derive(Debug, Serialize)]
struct Registered<'a> {
    accepted: bool,
    #[serde(skip_serializing_if = "str::is_empty")]
    reason: &'a str,
    fitness: f64,
    rmse_m: f64,
    /// Maps the view's points into registered.pcd.
    transform: Pose,
}

#[derive(Debug, Serialize)]
struct Pose {
    translation_m: [f64; 3],
    /// x, y, z, w
    rotation: [f64; 4],
}

impl<'a> Description<'a> {
    /// Without its views and the counts of points.
    pub fn of(
        scan: &'a Recorded,
        answer: &'a Classification,
        deformation: Option<&Deformation>,
    ) -> Self {
        let labels = answer.labels.iter().map(String::as_str);
        Self {
            scan_id: &answer.scan_id,
            label: &answer.label,
            known: answer.known,
            reason: &answer.reason,
            known_score: answer.known_score,
            known_threshold: answer.known_threshold,
            probability: answer.probability,
            probabilities: labels.zip(answer.probabilities.iter().copied()).collect(),
            model_id: &answer.model_id,
            provider: &answer.provider,
            frame: &scan.registered.header.frame_id,
            object_points: 0,
            registered_points: 0,
            deformation: deformation.map(to_json),
            views: Vec::new(),
        }
    }
}

impl<'a> DescribedView<'a> {
    pub fn new(
        file: String,
        view: &'a View,
        points: usize,
        registration: Option<&'a ViewRegistration>,
    ) -> Self {
        Self {
            file,
            frame: &view.header.frame_id,
            stamp_s: view.header.stamp.seconds(),
            wrist_angle_rad: view.wrist_angle,
            points,
            hand_from_camera: view.has_pose.then(|| pose(&view.hand_from_camera)),
            registered: registration.map(|entry| Registered {
                accepted: entry.accepted,
                reason: &entry.reason,
                fitness: entry.fitness,
                rmse_m: entry.rmse,
                transform: pose(&entry.transform),
            }),
        }
    }
}

fn pose(transform: &Transform) -> Pose {
    let (shift, turn) = (&transform.translation, &transform.rotation);
    Pose {
        translation_m: [shift.x, shift.y, shift.z],
        rotation: [turn.x, turn.y, turn.z, turn.w],
    }
}
