//! Which steps are measured.

use sim_scan::{DISPARITY_SIGMA_PX, EDGE_MIXING, ScanParameters};

use super::disturb::{Camera, Shift};

/// One thing in several steps.
#[derive(Debug, Clone)]
pub struct Curve {
    /// What it is.
    pub name: &'static str,
    /// The range that was trained on.
    pub trained: String,
    /// Nearest first.
    pub steps: Vec<Step>,
}

/// How far it is.
#[derive(Debug, Clone)]
pub struct Step {
    /// In words.
    pub name: String,
    /// Whether this step of the curve lies within the range of the training data.
    pub is_trained: bool,
    /// What is done.
    pub shift: Shift,
}

impl Curve {
    fn new<T: Copy>(
        name: &'static str,
        trained: String,
        values: &[T],
        step: impl Fn(T) -> (String, bool, Shift),
    ) -> Self {
        let steps = values.iter().map(|&value| {
            let (name, is_trained, shift) = step(value);
            Step {
                name,
                is_trained,
                shift,
            }
        });
        Self {
            name,
            trained,
            steps: steps.collect(),
        }
    }

    /// One whose steps are lengths in mm.
    fn in_mm(
        name: &'static str,
        trained_mm: [f64; 2],
        values_mm: &[f64],
        shift: fn(f64) -> Shift,
    ) -> Self {
        let [least, most] = trained_mm;
        let trained = if least == most {
            "none".to_owned()
        } else {
            format!("{least} to {most} mm")
        };
        Self::new(name, trained, values_mm, |mm| {
            let is_trained = least < most && (least..=most).contains(&mm);
            (format!("{mm} mm"), is_trained, shift(1e-3 * mm))
        })
    }

    /// One whose steps are angles in degrees, none of which was trained on.
    fn in_degrees(name: &'static str, values_deg: &[f64], shift: fn(f64) -> Shift) -> Self {
        Self::new(name, "none".to_owned(), values_deg, |degrees| {
            (format!("{degrees}°"), false, shift(degrees.to_radians()))
        })
    }
}

/// All of them.
pub fn all() -> Vec<Curve> {
    let trained = ScanParameters::default();
    let in_mm = |range_m: [f64; 2]| range_m.map(|length_m| (1e4 * length_m).round() / 10.0);
    let distance_mm = in_mm(trained.distance_m);
    let flank_mm = if trained.flank_lost_share > 0.0 {
        in_mm(trained.flank_lost_m)
    } else {
        [0.0; 2]
    };
    let nothing = Curve::new("Nothing is shifted", "all of it".to_owned(), &[()], |()| {
        ("as in training".to_owned(), true, Shift::None)
    });
    vec![
        nothing,
        mount(&trained),
        Curve::in_degrees(
            "Joints are off, view by view",
            &[0.25, 0.5, 1.0, 2.0],
            Shift::Joints,
        ),
        Curve::in_degrees(
            "The clocks differ: the wrist has yet to turn (at 0.5 rad/s, 1° is 35 ms)",
            &[0.5, 1.0, 2.0, 4.0],
            Shift::Late,
        ),
        in_shares(
            "Standard deviation of disparity, px",
            DISPARITY_SIGMA_PX,
            &[0.14, 0.28, 0.42],
            Shift::Noise,
        ),
        in_shares(
            "Bleeding edges: chance",
            EDGE_MIXING,
            &[0.35, 0.7, 1.0],
            Shift::Bleeding,
        ),
        Curve::in_mm(
            "One flank is missing",
            flank_mm,
            &[2.0, 4.0, 6.0, 8.0, 12.0],
            Shift::Flank,
        ),
        Curve::in_mm(
            "Three holes by glare: radius",
            [0.0; 2],
            &[3.0, 6.0, 12.0],
            Shift::Glare,
        ),
        Curve::in_mm(
            "Distance of the camera",
            distance_mm,
            &[200.0, 250.0, 400.0, 700.0, 850.0, 1000.0],
            Shift::Distance,
        ),
        cameras(),
        Curve::in_mm(
            "The crop's plane is higher",
            [0.0; 2],
            &[-5.0, -2.0, 2.0, 5.0],
            Shift::Plane,
        ),
        Curve::in_mm(
            "Depth of the dent",
            in_mm(trained.squeeze_m),
            &[14.0, 17.0, 20.0],
            Shift::Dent,
        ),
    ]
}

fn mount(trained: &ScanParameters) -> Curve {
    let most_deg = trained.mount_error_rad.to_degrees();
    let most_mm = 1e3 * trained.mount_error_m;
    Curve::new(
        "The camera mount is off",
        format!("up to {most_deg:.0}° and {most_mm:.0} mm"),
        &[[1.0, 5.0], [2.0, 10.0], [3.0, 15.0], [4.0, 20.0]],
        |[degrees, mm]| {
            let shift = Shift::Mount {
                turn_rad: f64::to_radians(degrees),
                move_m: 1e-3 * mm,
            };
            // 0.035 rad are 2.005°.
            let is_trained = degrees <= most_deg && mm <= most_mm;
            (format!("{degrees}° and {mm} mm"), is_trained, shift)
        },
    )
}

fn in_shares(
    name: &'static str,
    [least, most]: [f64; 2],
    values: &[f64],
    shift: fn(f64) -> Shift,
) -> Curve {
    Curve::new(name, format!("{least} to {most}"), values, |value| {
        (format!("{value}"), value <= most, shift(value))
    })
}

fn cameras() -> Curve {
    let cameras = [
        ("D435i, 1280 x 720", Camera::Full1280),
        ("D435i aligned to colour, 320 x 240", Camera::Aligned320),
        ("Kinect of 2010, 640 x 480, at 0.8 to 1.0 m", Camera::Kinect),
    ];
    let trained = "D435i, 848 x 480".to_owned();
    Curve::new("Another camera", trained, &cameras, |(name, camera)| {
        (name.to_owned(), false, Shift::Camera(camera))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_marked_as_trained_on_is_within_the_range() {
        let marked = |name: &str| -> Vec<String> {
            let curves = all();
            let curve = curves.iter().find(|curve| curve.name.starts_with(name));
            let steps = curve.map(|curve| curve.steps.clone()).unwrap_or_default();
            let trained = steps.into_iter().filter(|step| step.is_trained);
            trained.map(|step| step.name).collect()
        };
        assert_eq!(marked("The camera mount"), ["1° and 5 mm", "2° and 10 mm"]);
        assert_eq!(marked("Standard deviation"), ["0.14"]);
        assert_eq!(marked("Distance"), ["400 mm"]);
        assert_eq!(marked("Depth of the dent"), ["14 mm"]);
        assert!(marked("One flank").is_empty() && marked("The crop").is_empty());
    }
}
