//! How much of an object's surface one grasp shows.

use mesh::Mesh;
use mesh::triangle::area_normal;
use nalgebra::{Point3, Vector3};
use std::fmt;

/// A hole that faces along the object's axis to within 45° is an end's.
const END_COS: f64 = 0.7;
/// A hole with less than this share of the surface is not worth a word.
const WORTH_A_WORD: f64 = 0.005;

/// Where a mesh of what was seen is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    LowerEnd,
    /// Where a cup is open, too. The hand does not hide it.
    UpperEnd,
    Side,
}

/// What of an object's surface a mesh of what was seen lacks: the caps that would close its holes.
#[derive(Debug, Clone, PartialEq)]
pub struct Unseen {
    area_m2: f64,
    holes: Vec<(Place, f64)>,
}

impl Unseen {
    /// Of a mesh that is open where nothing was seen (+z up).
    pub fn of(mesh: &Mesh) -> Self {
        let (min, max) = mesh.bounds();
        let middle_m = f64::from(0.5 * (min.z + max.z));
        let hole = |vertices: Vec<u32>| {
            let rim = vertices.iter();
            let rim: Vec<Point3<f64>> = rim
                .map(|&vertex| mesh.vertices[vertex as usize].cast())
                .collect();
            let (centre, normal) = cap(&rim);
            let area_m2 = normal.norm();
            let is_end = normal.z.abs() > END_COS * area_m2;
            let place = match (is_end, centre.z < middle_m) {
                (true, true) => Place::LowerEnd,
                (true, false) => Place::UpperEnd,
                (false, _) => Place::Side,
            };
            (place, area_m2)
        };
        let holes = mesh.half_edges().boundaries().into_iter().map(hole);
        Self {
            area_m2: mesh.area_m2(),
            holes: holes.collect(),
        }
    }

    /// Share of the surface that was seen, of all but an open upper end: that is no hand's doing.
    pub fn seen_share(&self) -> f64 {
        let hidden_m2 = self.hole_m2(Place::LowerEnd) + self.hole_m2(Place::Side);
        self.area_m2 / (self.area_m2 + hidden_m2).max(f64::MIN_POSITIVE)
    }

    fn hole_m2(&self, place: Place) -> f64 {
        let there = self.holes.iter().filter(|hole| hole.0 == place);
        there.map(|hole| hole.1).sum()
    }
}

/// The middle of a rim, and area times normal of the fan from there.
fn cap(rim: &[Point3<f64>]) -> (Point3<f64>, Vector3<f64>) {
    let count = rim.len().max(1) as f64;
    let centre = Point3::from(rim.iter().map(|at| at.coords).sum::<Vector3<f64>>() / count);
    let following = rim.iter().cycle().skip(1);
    let fan = rim.iter().zip(following);
    let twice: Vector3<f64> = fan.map(|(a, b)| area_normal([centre, *a, *b])).sum();
    (centre, 0.5 * twice)
}

impl fmt::Display for Unseen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| (100.0 * share).round();
        write!(
            f,
            "{} % of the surface was seen",
            percent(self.seen_share())
        )?;
        let whole_m2 = self.area_m2 + self.holes.iter().map(|hole| hole.1).sum::<f64>();
        let mut words = Vec::new();
        for (place, name) in [
            (Place::LowerEnd, "its lower end"),
            (Place::Side, "its side where the fingers held it"),
            (Place::UpperEnd, "its upper end, which may be open"),
        ] {
            let share = self.hole_m2(place) / whole_m2.max(f64::MIN_POSITIVE);
            if share >= WORTH_A_WORD {
                words.push(format!("{name} ({} %)", percent(share)));
            }
        }
        if !words.is_empty() {
            write!(f, "; unseen: {}", words.join(", "))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A can of 30 mm and 90 mm without the triangles whose middle is at such a place.
    fn without(is_cut: impl Fn(Point3<f64>) -> bool) -> Unseen {
        let mut can = Mesh::cylinder(0.03, 0.0, 0.09, 96).subdivided();
        can = can.subdivided().subdivided();
        let all = can.triangles.clone();
        let middle = |corners: &[u32; 3]| {
            let [a, b, c] = can.corners(corners).map(|corner| corner.coords);
            Point3::from((a + b + c) / 3.0)
        };
        let kept = all.into_iter().filter(|corners| !is_cut(middle(corners)));
        let triangles = kept.collect();
        Unseen::of(&Mesh { triangles, ..can })
    }

    #[test]
    fn what_is_hidden_is_measured_and_named() {
        assert_eq!(
            without(|_| false).to_string(),
            "100 % of the surface was seen"
        );
        // The ends have an eighth of the area each.
        let lower = without(|at| at.z < 1e-6);
        assert!((lower.seen_share() - 0.875).abs() < 0.002, "{lower:?}");
        assert_eq!(
            lower.to_string(),
            "88 % of the surface was seen; unseen: its lower end (12 %)"
        );
        let cup = without(|at| at.z > 0.09 - 1e-6);
        assert!((cup.seen_share() - 1.0).abs() < 1e-9, "{cup:?}");
        assert!(
            cup.to_string()
                .contains("its upper end, which may be open (12 %)")
        );
        let held = without(|at| (0.02..0.04).contains(&at.z) && at.x.abs() < 0.01);
        assert!((0.93..0.98).contains(&held.seen_share()), "{held:?}");
        assert!(
            held.to_string()
                .contains("its side where the fingers held it")
        );
    }
}
