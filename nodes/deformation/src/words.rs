//! The answer in words.

use nalgebra::{Point3, Vector3};

use crate::answer::Measured;
use crate::dent::Dent;
use crate::synthesis::Unsaid;

/// More dents than these are only counted.
const NAMED: usize = 3;

impl Measured {
    /// One line: "dented: 7 mm at 61 mm height, facing the camera". `up` and `camera` are of the cloud's frame; `None`
    /// where nobody knows where the camera was.
    pub fn words(&self, up: &Vector3<f64>, camera: Option<&Point3<f64>>) -> String {
        if let Some(doubt) = &self.doubt {
            return format!("nothing said of dents: {doubt}");
        }
        let seen = format!("{:.0} % of the surface seen", 100.0 * self.seen_share);
        if self.dents.is_empty() {
            return format!("no dent in sight, {seen}");
        }
        let named = self
            .dents
            .iter()
            .take(NAMED)
            .map(|dent| dent.words(up, camera));
        let mut text = format!("dented: {}", named.collect::<Vec<_>>().join("; "));
        if self.dents.len() > NAMED {
            text += &format!("; {} more", self.dents.len() - NAMED);
        }
        text + &self.unseen_words(up, camera)
    }

    /// "; unseen: 7 mm at 61 mm height, facing away from the camera"; nothing where no deformer was fitted.
    fn unseen_words(&self, up: &Vector3<f64>, camera: Option<&Point3<f64>>) -> String {
        let Ok(synthesis) = &self.synthesis else {
            return String::new();
        };
        if synthesis.unsaid == Some(Unsaid::Seen) {
            return String::new();
        }
        if synthesis.unseen_dents.is_empty() {
            return "; unseen side: not known".into();
        }
        let dents = synthesis.unseen_dents.iter();
        let named: Vec<_> = dents.map(|dent| dent.words(up, camera)).collect();
        format!("; unseen, by its rim: {}", named.join("; "))
    }
}

impl Dent {
    /// "7 mm at 61 mm height, facing the camera".
    pub fn words(&self, up: &Vector3<f64>, camera: Option<&Point3<f64>>) -> String {
        let mut text = format!(
            "{:.0} mm at {:.0} mm height",
            1e3 * self.depth_m,
            1e3 * self.centre_in_object.z
        );
        if let Some(camera) = camera {
            text += &format!(", {}", self.side(up, &(camera - self.centre)));
        }
        text
    }

    fn side(&self, up: &Vector3<f64>, to_camera: &Vector3<f64>) -> &'static str {
        /// Cosine of the angle from up beyond which a dent is on top or below.
        const STEEP: f64 = 0.8;
        let rise = self.direction.dot(up);
        if rise.abs() > STEEP {
            return if rise > 0.0 { "on top" } else { "below" };
        }
        let level = |vector: &Vector3<f64>| vector - up * vector.dot(up);
        let angle_rad = level(&self.direction).angle(&level(to_camera));
        match angle_rad.to_degrees() {
            ..60.0 => "facing the camera",
            ..120.0 => "at the side",
            _ => "facing away from the camera",
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitVector3;

    use super::*;

    fn dent(direction: Vector3<f64>) -> Dent {
        let direction = UnitVector3::new_normalize(direction);
        Dent {
            centre_in_object: Point3::new(0.03, 0.0, 0.0612),
            direction_in_object: direction,
            centre: Point3::new(0.03, 0.0, 0.2),
            direction,
            depth_m: 0.0068,
            depth_sigma_m: 0.0005,
            width_m: 0.02,
            height_m: 0.02,
            area_m2: 4e-4,
            significance: 9.0,
        }
    }

    #[test]
    fn a_dent_is_said_by_depth_height_and_side() {
        let camera = Point3::new(0.5, 0.1, 0.4);
        let words = |direction, camera| dent(direction).words(&Vector3::z(), camera);
        let facing = "7 mm at 61 mm height, facing the camera";
        assert_eq!(words(Vector3::x(), Some(&camera)), facing);
        assert!(words(-Vector3::x(), Some(&camera)).ends_with("away from the camera"));
        assert!(words(Vector3::y(), Some(&camera)).ends_with("at the side"));
        assert!(words(Vector3::z(), Some(&camera)).ends_with("on top"));
        assert_eq!(words(Vector3::x(), None), "7 mm at 61 mm height");
    }
}
