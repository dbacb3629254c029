//! The answer for RViz: the undeformed object as a ghost of dots, and an arrow into each dent with its depth in words.

use deformation::{Library, Placement, Reference};
use msg::deformable_cobot::{Deformation, Dent};
use msg::geometry_msgs::{Point, Pose, Quaternion, Vector3};
use msg::std_msgs::ColorRGBA;
use msg::transform::{from_point, to_isometry};
use msg::visualization_msgs::{Marker, MarkerArray};
use nalgebra::Point3;

/// From an arrow's tail to the surface, m.
const ARROW_M: f64 = 0.06;
/// Height of a letter, m.
const LETTER_M: f64 = 0.02;
const GHOST: [f32; 4] = [0.75, 0.8, 1.0, 0.35];
const ARROW: [f32; 4] = [1.0, 0.25, 0.2, 1.0];

/// The whole picture of an answer; it wipes the one before.
pub fn picture(answer: &Deformation, library: &Library) -> MarkerArray {
    let mut markers = vec![Marker {
        action: i32::from(Marker::DELETEALL),
        ..Default::default()
    }];
    if answer.fits {
        markers.extend(
            library
                .get(&answer.label)
                .ok()
                .and_then(|r| ghost(answer, &r)),
        );
    }
    for (number, dent) in answer.dents.iter().enumerate() {
        markers.push(arrow(answer, number, dent));
        markers.push(words(answer, number, dent));
    }
    MarkerArray { markers }
}

fn ghost(answer: &Deformation, reference: &Reference) -> Option<Marker> {
    let placement = Placement {
        object_from_cloud: to_isometry(&answer.object_pose)?.inverse(),
        width_scale: answer.width_scale,
        height_scale: answer.height_scale,
    };
    let cloud_from_object = placement.object_from_cloud.inverse();
    let mut marker = blank(answer, "ghost", 0, Marker::POINTS, GHOST);
    (marker.scale.x, marker.scale.y) = (0.0015, 0.0015);
    marker.points = reference
        .outline()
        .map(|place| from_point(&(cloud_from_object * placement.in_object(&place))))
        .collect();
    Some(marker)
}

fn arrow(answer: &Deformation, number: usize, dent: &Dent) -> Marker {
    let mut marker = blank(answer, "dents", number, Marker::ARROW, ARROW);
    marker.scale = Vector3 {
        x: 0.004,
        y: 0.009,
        z: 0.012,
    };
    marker.points = vec![outside(dent, ARROW_M), outside(dent, -dent.depth)];
    marker
}

fn words(answer: &Deformation, number: usize, dent: &Dent) -> Marker {
    let mut marker = blank(answer, "depths", number, Marker::TEXT_VIEW_FACING, ARROW);
    marker.pose.position = outside(dent, ARROW_M + LETTER_M);
    marker.scale.z = LETTER_M;
    marker.text = format!("{:.0} mm", 1e3 * dent.depth);
    marker
}

/// A point at this distance from a dent's centre, along its outward direction.
fn outside(dent: &Dent, distance_m: f64) -> Point {
    let (centre, way) = (&dent.centre, &dent.direction);
    from_point(&Point3::new(
        centre.x + distance_m * way.x,
        centre.y + distance_m * way.y,
        centre.z + distance_m * way.z,
    ))
}

/// Without a stamp: it holds wherever the hand is.
fn blank(answer: &Deformation, name: &str, number: usize, kind: u8, colour: [f32; 4]) -> Marker {
    let [r, g, b, a] = colour;
    let mut marker = Marker {
        ns: name.into(),
        id: number as i32,
        type_: i32::from(kind),
        action: i32::from(Marker::ADD),
        pose: Pose {
            orientation: Quaternion {
                w: 1.0,
                ..Default::default()
            },
            ..Default::default()
        },
        color: ColorRGBA { r, g, b, a },
        frame_locked: true,
        ..Default::default()
    };
    marker.header.frame_id.clone_from(&answer.header.frame_id);
    marker
}
