//! What was seen, and from where.

use nalgebra::{Point3, Vector3};

use crate::layer::Sample;
use crate::parameters::Parameters;

/// An object's cloud.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// Points in m, in any frame: the hand's, or a camera's.
    pub points: &'a [Point3<f32>],
    /// Unit vector of that frame which points up.
    pub up: Vector3<f64>,
    /// Where the camera was at each view, in that frame, the last one last; none where nobody knows.
    pub viewpoints: &'a [Point3<f64>],
    /// Whether the frame is the hand's, whose z axis the object is about.
    pub in_hand_frame: bool,
}

/// Smallest cosine of the angle between a surface's normal and the direction to the camera at which it is measured.
const GRAZING: f64 = 0.12;

/// Viewpoints, in the frame of the reference.
#[derive(Debug, Clone)]
pub(crate) struct Cameras {
    places: Vec<Point3<f64>>,
}

impl Cameras {
    pub(crate) fn new(places: impl IntoIterator<Item = Point3<f64>>) -> Self {
        Self {
            places: places.into_iter().collect(),
        }
    }

    /// Cosine of the angle at which the camera that looks at a place most squarely does, and its distance, m; `None` where
    /// all look at it from behind or nearly along it. Where nobody knows the viewpoints: square, from where people hold a
    /// D435i.
    pub(crate) fn best_view(
        &self,
        place: &Point3<f64>,
        normal: &Vector3<f64>,
    ) -> Option<(f64, f64)> {
        const USUAL: (f64, f64) = (0.8, 0.4);
        if self.places.is_empty() {
            return Some(USUAL);
        }
        let views = self.places.iter().map(|camera| {
            let to_camera = camera - place;
            let distance_m = to_camera.norm();
            (to_camera.dot(normal) / distance_m.max(1e-6), distance_m)
        });
        let best = views.max_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(cosine, _)| *cosine > GRAZING)
    }

    /// Whether a camera looks at this side of a sample.
    pub(crate) fn see(&self, sample: &Sample, place: &Point3<f64>) -> bool {
        self.best_view(place, &sample.normal.cast()).is_some()
    }
}

/// Standard deviation of a point's distance from a surface, along the surface's normal, m.
///
/// Stereo's error lies along the ray and grows with the square of the distance (Keselman et al., "Intel RealSense
/// stereoscopic depth cameras", CVPRW 2017, Sec. 4); what a pixel or a matching window is wide counts across it.
pub(crate) fn sigma_m((cosine, distance_m): (f64, f64), parameters: &Parameters) -> f64 {
    /// Part of a pixel by which an edge is misplaced: 1 / 418 rad.
    const LATERAL_RAD: f64 = 0.5 / 418.0;
    let along_m = parameters.depth_sigma_at_1m_m * distance_m * distance_m;
    let across_m = LATERAL_RAD * distance_m;
    let sine_sq = 1.0 - cosine * cosine;
    (along_m * along_m * cosine * cosine + across_m * across_m * sine_sq).sqrt()
}
