//! How the object in the files is deformed.

use std::time::{Duration, Instant};

use deformation::{Dent, Library, Measured, Observation, Parameters, measure};
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

use crate::Classified;

/// What was measured of the object, or why nothing was.
#[derive(Debug)]
pub struct Deformed {
    /// What it was compared with; empty: nothing.
    pub reference: String,
    /// Whether that is the same however it is turned about its z axis.
    pub turn_is_open: bool,
    /// The answer, or why there is none.
    pub measured: Result<Measured, String>,
    /// All in words.
    pub summary: String,
    /// Time for it.
    pub time: Duration,
}

/// Compares the object with the undeformed one of its label. `viewpoint` is where the camera was in each file's frame, m.
pub fn measure_deformation(
    classified: &Classified,
    library: &Library,
    viewpoint: Option<Point3<f64>>,
) -> Deformed {
    let start = Instant::now();
    let mut deformed = Deformed {
        reference: String::new(),
        turn_is_open: false,
        measured: Err(String::new()),
        summary: String::new(),
        time: Duration::ZERO,
    };
    let accepted = classified.views.iter().filter(|view| view.accepted);
    let viewpoints: Vec<_> = viewpoint
        .into_iter()
        .flat_map(|place| accepted.clone().map(move |view| view.transform * place))
        .collect();
    deformed.measured = deformed.compare(classified, library, &viewpoints);
    deformed.summary = match &deformed.measured {
        Ok(found) => found.words(&up(classified), viewpoints.last()),
        Err(reason) => format!("nothing said of dents: {reason}"),
    };
    deformed.time = start.elapsed();
    deformed
}

fn up(classified: &Classified) -> Vector3<f64> {
    classified.object.up
}

impl Deformed {
    fn compare(
        &mut self,
        classified: &Classified,
        library: &Library,
        viewpoints: &[Point3<f64>],
    ) -> Result<Measured, String> {
        let answer = &classified.answer;
        if !answer.known {
            return Err(format!(
                "the object is unknown; it is most like {}",
                answer.label
            ));
        }
        let reference = library
            .get(&answer.label)
            .map_err(|error| program::describe(&error))?;
        reference.id().clone_into(&mut self.reference);
        self.turn_is_open = reference.is_of_revolution();
        let seen = Observation {
            points: &classified.object.points,
            up: up(classified),
            viewpoints,
            in_hand_frame: false,
        };
        measure(&reference, &seen, &Parameters::default()).map_err(|doubt| doubt.to_string())
    }

    /// By the names of the message `Deformation`.
    pub fn to_json(&self) -> Value {
        let found = match &self.measured {
            Ok(found) => found,
            Err(reason) => {
                return json!({
                    "reason": reason, "reference": self.reference, "fits": false, "dents": [],
                    "summary": self.summary,
                });
            }
        };
        let reason = found.doubt.as_ref().map(ToString::to_string);
        json!({
            "reason": reason.unwrap_or_default(),
            "reference": self.reference,
            "fits": found.fits(),
            "dents": found.dents.iter().map(dent).collect::<Vec<_>>(),
            "largest_depth": found.largest_depth_m(),
            "significance": found.significance,
            "seen_share": found.seen_share,
            "undented_rms": found.undented_rms_m,
            "unseen_dents": found.unseen_dents().iter().map(dent).collect::<Vec<_>>(),
            "unseen_reason": found.unsaid().map(ToString::to_string).unwrap_or_default(),
            "turn_is_open": self.turn_is_open,
            "width_scale": found.placement.width_scale,
            "height_scale": found.placement.height_scale,
            "summary": self.summary,
        })
    }
}

fn dent(dent: &Dent) -> Value {
    json!({
        "centre": dent.centre.coords.as_slice(),
        "direction": dent.direction.as_slice(),
        "centre_in_object": dent.centre_in_object.coords.as_slice(),
        "direction_in_object": dent.direction_in_object.as_slice(),
        "depth": dent.depth_m,
        "depth_sigma": dent.depth_sigma_m,
        "width": dent.width_m,
        "height": dent.height_m,
        "area": dent.area_m2,
        "significance": dent.significance,
    })
}
