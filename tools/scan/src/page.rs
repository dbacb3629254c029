//! A scan as one page that any browser opens from disk, without a network.
//!
//! three.js comes along, minified: `page/package.json` says which version and how page/three.js is made of it.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use msg::cloud::{to_points, values};
use msg::deformable_cobot::{Classification, Deformation, Dent, View};
use msg::transform::to_isometry;
use nalgebra::{Isometry3, Point3, Vector3};
use serde::Serialize;

use crate::answer;
use crate::deformation::DEVIATION;
use crate::recording::Recorded;

const PAGE: &str = include_str!("../page/page.html");
const SCRIPT: &str = include_str!("../page/page.js");
const THREE: &str = include_str!("../page/three.js");

/// More points are thinned out, so that a page stays below 3 MB: 16 bytes each, a third more in base64.
const OBJECT_POINTS: usize = 30_000;
/// Of all views together, 12 bytes each.
const VIEW_POINTS: usize = 60_000;
/// Of a view, what lies nearer to the object than this is shown, m.
const AROUND_M: f32 = 0.25;
/// The colours reach at least so far, m.
const REACH_MIN_M: f64 = 0.004;

/// What page.js reads.
#[derive(Serialize)]
struct Scan<'a> {
    title: &'a str,
    scan_id: &'a str,
    answer: String,
    summary: &'a str,
    stamp_s: f64,
    facts: Vec<(&'static str, String)>,
    up: [f64; 3],
    look_from: [f64; 3],
    /// x, y, z of each point.
    object: String,
    /// Of each of these points.
    deviation: Option<String>,
    deviation_reach: f64,
    dents: Vec<ShownDent>,
    /// Places all over the shape that analysis by synthesis gives; empty without it.
    shape: String,
    views: Vec<ShownView>,
}

#[derive(Serialize)]
struct ShownDent {
    centre: [f64; 3],
    direction: [f64; 3],
    depth: String,
    at_height: String,
    extent: String,
}

#[derive(Serialize)]
struct ShownView {
    name: String,
    points: String,
}

/// The whole page.
///
/// # Errors
/// A cloud that cannot be read.
pub fn page(
    scan: &Recorded,
    answer: &Classification,
    deformation: Option<&Deformation>,
) -> Result<String> {
    let measured = deformation.filter(|deformation| !deformation.cloud.data.is_empty());
    let cloud = measured.map_or(&scan.object.cloud, |deformation| &deformation.cloud);
    let points = to_points(cloud).context("object")?.points;
    let step = points.len().div_ceil(OBJECT_POINTS).max(1);
    let deviation = measured.map(|found| values(&found.cloud, DEVIATION));
    let deviation = deviation.transpose().context("deformation")?;
    let object = &scan.object;
    let centre = cloud::bounds(&points).map_or_else(Point3::origin, |bounds| bounds.centre());
    let up = Vector3::new(object.up.x, object.up.y, object.up.z);
    let shown = Scan {
        title: match (&answer.label[..], answer.known) {
            ("", _) => "empty hand",
            (label, true) => label,
            (_, false) => "unknown object",
        },
        scan_id: &answer.scan_id,
        answer: answer::to_text(answer),
        summary: deformation.map_or("", |deformation| &deformation.summary),
        stamp_s: object.header.stamp.seconds(),
        facts: facts(answer, deformation, object.cloud.width),
        up: up.try_normalize(1e-6).unwrap_or_else(Vector3::z).into(),
        look_from: look_from(scan, &centre).into(),
        object: encoded(
            points
                .iter()
                .step_by(step)
                .flat_map(|point| [point.x, point.y, point.z]),
        ),
        deviation: deviation.map(|all| encoded(all.iter().step_by(step).copied())),
        deviation_reach: deformation.map_or(0.0, reach_m),
        dents: deformation.map_or_else(Vec::new, |found| {
            let unseen = found.unseen_dents.iter().map(unseen_dent);
            found.dents.iter().map(dent).chain(unseen).collect()
        }),
        shape: deformation.map_or_else(String::new, |found| {
            encoded(
                found
                    .shape
                    .iter()
                    .flat_map(|place| [place.x, place.y, place.z]),
            )
        }),
        views: views(scan, &centre)?,
    };
    let json = serde_json::to_string(&shown)?.replace('<', "\\u003c");
    // From the last place to the first, so that nothing that is put in is taken for a place.
    Ok(PAGE
        .replacen("{{page}}", SCRIPT, 1)
        .replacen("{{three}}", THREE, 1)
        .replacen("{{scan}}", &json, 1))
}

fn facts(
    answer: &Classification,
    deformation: Option<&Deformation>,
    points: u32,
) -> Vec<(&'static str, String)> {
    let mut facts = vec![
        ("scan", answer.scan_id.clone()),
        ("points", points.to_string()),
        ("model", answer.model_id.clone()),
    ];
    if let Some(found) = deformation.filter(|found| found.fits) {
        facts.extend([
            ("compared with", found.reference.clone()),
            (
                "surface seen",
                format!("{:.0} %; the rest may be dented", 100.0 * found.seen_share),
            ),
            (
                "undented part",
                format!("within {:.1} mm (RMS)", 1e3 * found.undented_rms),
            ),
        ]);
    }
    facts
}

/// The colours' end: a whole number of mm that the deepest dent lies within.
fn reach_m(deformation: &Deformation) -> f64 {
    let deepest_m = deformation.largest_depth.max(REACH_MIN_M);
    (1e3 * deepest_m).ceil() / 1e3
}

/// Towards where the camera was last; without that, from the side.
fn look_from(scan: &Recorded, centre: &Point3<f32>) -> Vector3<f64> {
    let last = scan.object.viewpoints.last();
    let way = last.map(|place| Point3::new(place.x, place.y, place.z) - centre.cast::<f64>());
    way.and_then(|way| way.try_normalize(1e-6))
        .unwrap_or_else(|| Vector3::new(1.0, 1.0, 0.5))
}

fn dent(dent: &Dent) -> ShownDent {
    let millimetres = |m: f64| format!("{:.0} mm", 1e3 * m);
    ShownDent {
        centre: [dent.centre.x, dent.centre.y, dent.centre.z],
        direction: [dent.direction.x, dent.direction.y, dent.direction.z],
        depth: format!("{:.1} ± {:.1} mm", 1e3 * dent.depth, 1e3 * dent.depth_sigma),
        at_height: millimetres(dent.centre_in_object.z),
        extent: format!("{:.0} × {}", 1e3 * dent.width, millimetres(dent.height)),
    }
}

fn unseen_dent(unseen: &Dent) -> ShownDent {
    ShownDent {
        extent: "not seen".into(),
        ..dent(unseen)
    }
}

/// Each view where registration put it.
fn views(scan: &Recorded, centre: &Point3<f32>) -> Result<Vec<ShownView>> {
    let placed: BTreeMap<u32, Isometry3<f64>> = scan
        .registered
        .views
        .iter()
        .filter(|view| view.accepted)
        .filter_map(|view| Some((view.index, to_isometry(&view.transform)?)))
        .collect();
    let most = VIEW_POINTS / placed.len().max(1);
    let shown = |(index, view): (&u32, &View)| -> Option<Result<ShownView>> {
        let place = placed.get(index)?.cast::<f32>();
        let name = format!(
            "view {}, wrist at {:.0}°",
            index + 1,
            view.wrist_angle.to_degrees()
        );
        let points = to_points(&view.cloud).with_context(|| name.clone());
        Some(points.map(|decoded| {
            let near: Vec<Point3<f32>> = decoded
                .points
                .iter()
                .map(|point| place * point)
                .filter(|point| (point - centre).norm() < AROUND_M)
                .collect();
            let step = near.len().div_ceil(most.max(1)).max(1);
            ShownView {
                name,
                points: encoded(
                    near.iter()
                        .step_by(step)
                        .flat_map(|point| [point.x, point.y, point.z]),
                ),
            }
        }))
    };
    scan.views.iter().filter_map(shown).collect()
}

fn encoded(values: impl Iterator<Item = f32>) -> String {
    let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
    BASE64_STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests;
