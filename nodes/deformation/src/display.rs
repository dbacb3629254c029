//! The answer for RViz: the undeformed object, or what analysis by synthesis has made of it, as a ghost of dots, an arrow into each dent with its depth in words, and the scale of
//! the colours by which the cloud shows its deviation.

use deformation::{Library, Placement, Reference};
use msg::deformable_cobot::{Deformation, Dent};
use msg::geometry_msgs::{Point, Point32, Pose, Quaternion, Vector3};
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
const UNSEEN_ARROW: [f32; 4] = [1.0, 0.8, 0.3, 1.0];

/// Deviations in m and colours at the ends of the scale: those of the display "Deviation" in config/scan.rviz.
const SCALE: [(f64, [f32; 4]); 2] = [
    (-0.008, [1.0, 40.0 / 255.0, 30.0 / 255.0, 1.0]),
    (0.002, [60.0 / 255.0, 220.0 / 255.0, 90.0 / 255.0, 1.0]),
];
/// The bar stands on the object's axis, where the turning hand leaves it, so far above the object: m.
const BAR_ABOVE_M: f64 = 0.035;
const BAR_CELL_M: f64 = 0.006;
const BAR_CELLS: usize = 11;

/// The whole picture of an answer; it wipes the one before.
pub fn picture(answer: &Deformation, library: &Library) -> MarkerArray {
    let mut wipe = Marker {
        action: i32::from(Marker::DELETEALL),
        ..Default::default()
    };
    // RViz carries out a deletion without a frame at once, and what it was to delete is drawn after it.
    wipe.header.frame_id.clone_from(&answer.header.frame_id);
    let mut markers = vec![wipe];
    if answer.fits
        && let Ok(reference) = library.get(&answer.label)
        && let Some(object) = placement(answer)
    {
        markers.push(ghost(answer, &reference, &object));
        markers.extend(scale(answer, &reference, &object));
    }
    for (number, dent) in answer.dents.iter().enumerate() {
        markers.push(arrow(answer, number, dent, ARROW));
        markers.push(words(answer, number, dent, ARROW));
    }
    for (number, dent) in answer.unseen_dents.iter().enumerate() {
        let number = answer.dents.len() + number;
        markers.push(arrow(answer, number, dent, UNSEEN_ARROW));
        markers.push(words(answer, number, dent, UNSEEN_ARROW));
    }
    MarkerArray { markers }
}

fn placement(answer: &Deformation) -> Option<Placement> {
    Some(Placement {
        object_from_cloud: to_isometry(&answer.object_pose)?.inverse(),
        width_scale: answer.width_scale,
        height_scale: answer.height_scale,
    })
}

fn ghost(answer: &Deformation, reference: &Reference, object: &Placement) -> Marker {
    let cloud_from_object = object.object_from_cloud.inverse();
    let mut marker = blank(answer, "ghost", 0, Marker::POINTS, GHOST);
    (marker.scale.x, marker.scale.y) = (0.0015, 0.0015);
    if answer.shape.is_empty() {
        let outline = reference.outline();
        marker.points = outline
            .map(|place| from_point(&(cloud_from_object * object.in_object(&place))))
            .collect();
    } else {
        let vertex = |place: &Point32| Point3::new(place.x, place.y, place.z).cast();
        marker.points = answer
            .shape
            .iter()
            .map(|place| from_point(&vertex(place)))
            .collect();
    }
    marker
}

/// A bar of colours, and what its ends mean.
fn scale(answer: &Deformation, reference: &Reference, object: &Placement) -> [Marker; 3] {
    let cloud_from_object = object.object_from_cloud.inverse();
    let on_axis = |z| cloud_from_object * object.in_object(&Point3::new(0.0, 0.0, z));
    let (bottom, top) = (on_axis(0.0), on_axis(reference.height_m()));
    let middle = nalgebra::center(&bottom, &top);
    // Above the object, whichever way up it is.
    let lowest_m = bottom.z.max(top.z) + BAR_ABOVE_M;
    let at = |above_m: f64| from_point(&Point3::new(middle.x, middle.y, lowest_m + above_m));
    let [(low_m, low), (high_m, high)] = SCALE;
    let mut bar = blank(answer, "scale", 0, Marker::CUBE_LIST, high);
    (bar.scale.x, bar.scale.y, bar.scale.z) = (BAR_CELL_M, BAR_CELL_M, BAR_CELL_M);
    for cell in 0..BAR_CELLS {
        bar.points.push(at(cell as f64 * BAR_CELL_M));
        let share = cell as f32 / (BAR_CELLS - 1) as f32;
        let mix = |index: usize| low[index] + share * (high[index] - low[index]);
        bar.colors.push(ColorRGBA {
            r: mix(0),
            g: mix(1),
            b: mix(2),
            a: 1.0,
        });
    }
    let words = |number, above_m, text: String, colour| {
        let mut marker = blank(answer, "scale", number, Marker::TEXT_VIEW_FACING, colour);
        marker.pose.position = at(above_m);
        marker.scale.z = 0.6 * LETTER_M;
        marker.text = text;
        marker
    };
    let bar_m = BAR_CELLS as f64 * BAR_CELL_M;
    let inside = words(1, -0.012, format!("{:.0} mm inside", -1e3 * low_m), low);
    let outside = words(
        2,
        bar_m + 0.006,
        format!("{:.0} mm outside", 1e3 * high_m),
        high,
    );
    [bar, inside, outside]
}

fn arrow(answer: &Deformation, number: usize, dent: &Dent, colour: [f32; 4]) -> Marker {
    let mut marker = blank(answer, "dents", number, Marker::ARROW, colour);
    marker.scale = Vector3 {
        x: 0.004,
        y: 0.009,
        z: 0.012,
    };
    marker.points = vec![outside(dent, ARROW_M), outside(dent, -dent.depth)];
    marker
}

fn words(answer: &Deformation, number: usize, dent: &Dent, colour: [f32; 4]) -> Marker {
    let mut marker = blank(answer, "depths", number, Marker::TEXT_VIEW_FACING, colour);
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
