//! What one grasp shows of the object.

use ::mesh::file::Scan;
use anyhow::{Result, ensure};
use msg::deformable_cobot::Classification;
use nalgebra::Point3;
use scan::answer;
use scan::recording::Recorded;
use serde_json::{Value, json};
use sim_reconstruct::check_one_object;
use std::f64::consts::TAU;
use std::fmt;

/// Less than this of a turn is no object, but a part of one.
const COVERAGE_MIN_RAD: f64 = 0.9 * TAU;

/// The object in one grasp.
#[derive(Debug)]
pub struct Grasp {
    /// In the hand's frame, m.
    pub points: Vec<Point3<f32>>,
    views: usize,
    refused_views: usize,
    turned_rad: f64,
    coverage_rad: f64,
    /// What the running model takes it for.
    answer: Classification,
}

impl Grasp {
    /// Of a scan that was to have so many views (a sweep has as many as it takes).
    ///
    /// # Errors
    /// It does not show one object alone, from all sides.
    pub fn of(scan: &Recorded, answer: Classification, views_asked: Option<u32>) -> Result<Self> {
        let views = &scan.registered.views;
        ensure!(
            scan.registered.in_hand_frame,
            "the graph does not know where the hand is (no kinematics), so that views from all sides do not fit together; \
             launch it with a robot"
        );
        ensure!(!scan.object.empty, "the hand is empty");
        let views_asked = views_asked.unwrap_or(scan.registered.view_count);
        ensure!(
            scan.registered.view_count == views_asked,
            "the scan ended after {} of {views_asked} views; set stop_when_confident of scan_server to 0",
            scan.registered.view_count
        );
        let angles = views.iter().map(|view| view.wrist_angle);
        let (least, most) = angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), at| {
            (least.min(at), most.max(at))
        });
        let grasp = Self {
            points: msg::cloud::to_points(&scan.object.cloud)?.points,
            views: views.len(),
            refused_views: views.iter().filter(|view| !view.accepted).count(),
            turned_rad: (most - least).max(0.0),
            coverage_rad: scan.registered.coverage,
            answer,
        };
        ensure!(
            grasp.coverage_rad >= COVERAGE_MIN_RAD,
            "{grasp}; at least {:.0}° are needed: turn farther, or take more --views",
            COVERAGE_MIN_RAD.to_degrees()
        );
        check_one_object(&Scan {
            points_m: grasp.points.clone(),
            ..Scan::default()
        })?;
        Ok(grasp)
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        json!({
            "views": self.views,
            "refused_views": self.refused_views,
            "turned_rad": self.turned_rad,
            "coverage_rad": self.coverage_rad,
            "points": self.points.len(),
            "answer": answer::to_json(&self.answer),
        })
    }
}

impl fmt::Display for Grasp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (turned, seen) = (self.turned_rad.to_degrees(), self.coverage_rad.to_degrees());
        let views = self.views;
        write!(
            f,
            "turned by {turned:.0}°, {views} views show {seen:.0}° of 360°"
        )?;
        if self.refused_views > 0 {
            write!(
                f,
                "; registration refused {} of them, which are left out",
                self.refused_views
            )?;
        }
        write!(
            f,
            "; the running model says: {}",
            answer::to_text(&self.answer)
        )
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use msg::cloud::from_points;
    use msg::deformable_cobot::ViewRegistration;
    use msg::std_msgs::Header;

    fn scan() -> Recorded {
        let mut scan = Recorded::default();
        let view = |wrist_angle| ViewRegistration {
            wrist_angle,
            accepted: wrist_angle > -2.0,
            ..Default::default()
        };
        scan.registered.views = [-3.0, 0.0, 3.0].map(view).into();
        scan.registered.view_count = 3;
        scan.registered.in_hand_frame = true;
        scan.registered.coverage = TAU;
        scan.object.cloud = from_points(Header::default(), &[Point3::new(0.1, 0.2, 0.3)]);
        scan
    }

    #[test]
    fn a_grasp_says_what_was_seen() {
        let grasp = Grasp::of(&scan(), Classification::default(), Some(3)).unwrap();
        assert_eq!(
            grasp.to_string(),
            "turned by 344°, 3 views show 360° of 360°; registration refused 1 of them, which are left out; \
             the running model says: the hand is empty, by 0 views"
        );
    }

    #[test]
    fn what_shows_no_whole_object_is_refused_with_the_remedy() {
        let refusal = |change: fn(&mut Recorded), words: &str| {
            let mut scan = scan();
            change(&mut scan);
            let text = Grasp::of(&scan, Classification::default(), Some(3))
                .unwrap_err()
                .to_string();
            assert!(text.contains(words), "{text}");
        };
        refusal(
            |scan| scan.registered.coverage = 3.0,
            "at least 324° are needed",
        );
        refusal(|scan| scan.registered.coverage = 3.0, "more --views");
        refusal(
            |scan| scan.registered.in_hand_frame = false,
            "no kinematics",
        );
        refusal(|scan| scan.registered.view_count = 2, "2 of 3 views");
        refusal(|scan| scan.object.empty = true, "the hand is empty");
        let two = |scan: &mut Recorded| {
            let near = |k: usize| Point3::new(0.004 * k as f32, 0.1 * (k / 20) as f32, 0.3);
            let points: Vec<_> = (0..40).map(near).collect();
            scan.object.cloud = from_points(Header::default(), &points);
        };
        refusal(two, "2 objects are in view");
    }
}
