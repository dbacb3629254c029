//! What was measured, as a message.

use std::time::Instant;

use deformation::{Dent, Library, Measured, Observation, Parameters, measure};
use msg::deformable_cobot::{Deformation, Dent as DentMessage};
use msg::geometry_msgs::{Point, Point32};
use msg::sensor_msgs::PointCloud2;
use msg::timing;
use msg::transform::{from_isometry, from_point, from_vector};
use nalgebra::{Point3, Vector3};

/// An object's cloud, and which label it has.
pub struct Question<'a> {
    pub label: &'a str,
    pub cloud: &'a PointCloud2,
    pub up: Vector3<f64>,
    pub viewpoints: &'a [Point],
    pub in_hand_frame: bool,
}

/// Fills an answer whose header, scan and views are set.
pub fn answer_into(
    reply: &mut Deformation,
    question: &Question<'_>,
    library: &Library,
    parameters: &Parameters,
) {
    let start = Instant::now();
    reply.label = question.label.to_owned();
    let result = fill(reply, question, library, parameters);
    if let Err(error) = result {
        reply.reason = format!("{error:#}");
    }
    if reply.summary.is_empty() {
        reply.summary = format!("nothing said of dents: {}", reply.reason);
    }
    reply
        .timing
        .push(timing::stage("deformation", start.elapsed()));
}

fn fill(
    reply: &mut Deformation,
    question: &Question<'_>,
    library: &Library,
    parameters: &Parameters,
) -> anyhow::Result<()> {
    let points = msg::cloud::to_points(question.cloud)?.points;
    let reference = library.get(question.label)?;
    reference.id().clone_into(&mut reply.reference);
    let viewpoints: Vec<Point3<f64>> = question
        .viewpoints
        .iter()
        .map(|place| Point3::new(place.x, place.y, place.z))
        .collect();
    let up = question.up.try_normalize(1e-6).unwrap_or_else(Vector3::z);
    let seen = Observation {
        points: &points,
        up,
        viewpoints: &viewpoints,
        in_hand_frame: question.in_hand_frame,
    };
    let found = measure(&reference, &seen, parameters)?;
    reply.summary = found.words(&up, viewpoints.last());
    reply.cloud = msg::cloud::with_field(
        question.cloud.header.clone(),
        &points,
        "deviation",
        &found.deviations_m,
    );
    describe(reply, &found);
    reply.turn_is_open = reference.is_of_revolution();
    Ok(())
}

fn describe(reply: &mut Deformation, found: &Measured) {
    let placement = &found.placement;
    reply.fits = found.fits();
    reply.reason = found
        .doubt
        .as_ref()
        .map(ToString::to_string)
        .unwrap_or_default();
    reply.object_pose = from_isometry(&placement.object_from_cloud.inverse());
    reply.width_scale = placement.width_scale;
    reply.height_scale = placement.height_scale;
    reply.rotation_sigma = from_vector(&found.rotation_sigma_rad);
    reply.translation_sigma = from_vector(&found.translation_sigma_m);
    reply.dents = found.dents.iter().map(dent).collect();
    reply.largest_depth = found.largest_depth_m();
    reply.significance = found.significance;
    reply.seen_share = found.seen_share;
    reply.undented_rms = found.undented_rms_m;
    reply.unseen_dents = found.unseen_dents().iter().map(dent).collect();
    reply.unseen_reason = found.unsaid().map(ToString::to_string).unwrap_or_default();
    if let Ok(synthesis) = &found.synthesis {
        reply.shape = synthesis.vertices.iter().map(point).collect();
        reply.shape_triangles = synthesis.triangles.concat();
        reply.shape_rms = synthesis.rms_m;
    }
}

fn point(place: &Point3<f64>) -> Point32 {
    Point32 {
        x: place.x as f32,
        y: place.y as f32,
        z: place.z as f32,
    }
}

fn dent(dent: &Dent) -> DentMessage {
    DentMessage {
        centre_in_object: from_point(&dent.centre_in_object),
        direction_in_object: from_vector(&dent.direction_in_object),
        centre: from_point(&dent.centre),
        direction: from_vector(&dent.direction),
        depth: dent.depth_m,
        depth_sigma: dent.depth_sigma_m,
        width: dent.width_m,
        height: dent.height_m,
        area: dent.area_m2,
        significance: dent.significance,
    }
}
