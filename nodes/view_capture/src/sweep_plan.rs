//! One sweep: from where to where, and whether its images are sharp.

use crate::Parameters;
use crate::plan_error::{PlanError, VIEWS_MAX};

/// One sweep of the wrist.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepPlan {
    /// Where it begins, rad.
    pub from_rad: f64,
    /// Where it ends, rad.
    pub to_rad: f64,
    /// Views, the first and the last included.
    pub count: u32,
}

impl SweepPlan {
    /// How far the wrist turns, rad.
    pub fn range_rad(&self) -> f64 {
        (self.to_rad - self.from_rad).abs()
    }

    /// 1 where angles grow, -1 where they shrink.
    pub fn direction(&self) -> f64 {
        (self.to_rad - self.from_rad).signum()
    }

    /// Whether the wrist passes an angle, rad.
    pub fn is_within(&self, angle_rad: f64) -> bool {
        (self.from_rad.min(self.to_rad)..=self.from_rad.max(self.to_rad)).contains(&angle_rad)
    }

    /// From view to view, rad.
    pub fn step_rad(&self) -> f64 {
        self.range_rad() / f64::from(self.count.max(2) - 1)
    }
}

/// If the wrist is this near to the beginning of a range, rad, the range is moved to where the wrist is: a sweep of 0.2 rad may
/// suffice for a sure answer, so that to turn back before that would double the time.
const NEAR_RAD: f64 = 0.2;

impl SweepPlan {
    /// The same range, moved so that it begins where the wrist is, as far as the joint goes; `None` where that is too far away.
    pub fn from_here(&self, parameters: &Parameters, wrist_rad: f64) -> Option<Self> {
        let moved_rad = wrist_rad - self.from_rad;
        let to_rad = (self.to_rad + moved_rad)
            .max(parameters.angle_min_rad)
            .min(parameters.angle_max_rad);
        (moved_rad.abs() <= NEAR_RAD).then_some(Self {
            from_rad: wrist_rad,
            to_rad,
            count: self.count,
        })
    }
}

/// Smallest range of a sweep, rad.
const RANGE_MIN_RAD: f64 = 0.05;

/// A sweep through `range_rad` about the centre, moved into the joint's range, from the end that is nearer to where the
/// wrist is.
///
/// # Errors
/// A range that the wrist does not have; a rate at which images are blurred; no kinematics.
pub fn plan_sweep(
    parameters: &Parameters,
    range_rad: f64,
    wrist_rad: f64,
) -> Result<SweepPlan, PlanError> {
    if !parameters.use_tf {
        return Err(PlanError::NoKinematics);
    }
    let (lowest_rad, highest_rad) = (parameters.angle_min_rad, parameters.angle_max_rad);
    let max_rad = highest_rad - lowest_rad;
    let min_rad = RANGE_MIN_RAD;
    if !(min_rad..=max_rad).contains(&range_rad) {
        return Err(PlanError::Range {
            range_rad,
            min_rad,
            max_rad,
        });
    }
    check_blur(parameters)?;
    let first_rad = parameters.middle_rad() - range_rad / 2.0;
    let low_rad = first_rad.min(highest_rad - range_rad).max(lowest_rad);
    let high_rad = (low_rad + range_rad).min(highest_rad);
    let is_nearer_low = (wrist_rad - low_rad).abs() <= (wrist_rad - high_rad).abs();
    let (from_rad, to_rad) = if is_nearer_low {
        (low_rad, high_rad)
    } else {
        (high_rad, low_rad)
    };
    let intervals = (range_rad / parameters.view_spacing_rad).round().max(1.0);
    Ok(SweepPlan {
        from_rad,
        to_rad,
        count: (intervals as u32).saturating_add(1).min(VIEWS_MAX as u32),
    })
}

/// Is the image sharp at the rate of a sweep?
fn check_blur(parameters: &Parameters) -> Result<(), PlanError> {
    let (rate_rad_s, exposure_s) = (parameters.sweep_rate_rad_s, parameters.exposure_s);
    let radius_m = parameters.blur_radius_m;
    let blur_m = rate_rad_s * exposure_s * radius_m;
    if blur_m <= parameters.blur_max_m {
        return Ok(());
    }
    Err(PlanError::Blur {
        rate_rad_s,
        radius_m,
        exposure_s,
        blur_mm: blur_m * 1e3,
        max_mm: parameters.blur_max_m * 1e3,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn close(angles: &[f64], expected: &[f64]) -> bool {
        angles
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn a_sweep_begins_at_the_nearer_end_and_stays_in_the_joints_range() {
        let parameters = Parameters {
            centre_angle_rad: 1.25,
            ..Default::default()
        };
        let sweep = |range_rad, wrist_rad| plan_sweep(&parameters, range_rad, wrist_rad).unwrap();
        let ends = |plan: SweepPlan| [plan.from_rad, plan.to_rad];
        assert!(close(&ends(sweep(1.2, 0.0)), &[0.65, 1.85]));
        assert!(close(&ends(sweep(1.2, 1.5)), &[1.85, 0.65]));
        assert_eq!(sweep(1.2, 0.0).count, 13);
        assert!(close(&ends(sweep(5.0, 2.9)), &[3.0, -2.0]));
        assert!(close(&ends(sweep(6.0, f64::NAN)), &[3.0, -3.0]));
        for range_rad in [6.1, 0.01, -1.0, f64::NAN, f64::INFINITY] {
            let error = plan_sweep(&parameters, range_rad, 0.0).unwrap_err();
            assert!(
                error.to_string().contains("the wrist has 0.05 to 6 rad"),
                "{error}"
            );
        }
    }

    #[test]
    fn a_range_whose_beginning_is_near_begins_where_the_wrist_is() {
        let parameters = Parameters {
            centre_angle_rad: 1.25,
            ..Default::default()
        };
        let moved = |range_rad, wrist_rad| {
            let plan = plan_sweep(&parameters, range_rad, wrist_rad).unwrap();
            let moved = plan.from_here(&parameters, wrist_rad);
            moved.map(|plan| [plan.from_rad, plan.to_rad])
        };
        assert!(close(&moved(1.2, 0.8).unwrap(), &[0.8, 2.0]));
        assert!(close(&moved(1.2, 0.5).unwrap(), &[0.5, 1.7]));
        assert!(close(&moved(1.2, 1.7).unwrap(), &[1.7, 0.5]));
        assert_eq!(
            [0.4, 0.9, f64::NAN].map(|wrist_rad| moved(1.2, wrist_rad)),
            [None; 3]
        );
        // No farther than the joint goes, also where the wrist was pushed beyond.
        assert!(close(&moved(6.0, -2.9).unwrap(), &[-2.9, 3.0]));
        assert!(close(&moved(6.0, 3.05).unwrap(), &[3.05, -2.95]));
    }

    #[test]
    fn a_rate_that_blurs_is_refused_with_its_numbers() {
        let blurred = Parameters {
            exposure_s: 0.05,
            ..Default::default()
        };
        let text = plan_sweep(&blurred, 1.2, 0.0).unwrap_err().to_string();
        let words = [
            "1.15 rad/s",
            "2.59 mm",
            "0.05 s",
            "2.00 mm (blur_max_m)",
            "sweep_rate_rad_s",
        ];
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    }
}
