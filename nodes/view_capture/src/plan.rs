//! How an active scan turns the wrist: to one angle after the other, or in one sweep.

use crate::Parameters;
use crate::parameters::Motion;
use crate::sweep_plan::plan_sweep;
use baxter::WristPlan;
use thiserror::Error;

/// A scan that cannot be made.
#[derive(Debug, Error, PartialEq)]
pub enum PlanError {
    /// More views than the scan may have.
    #[error("{asked} views were asked for; a scan has 1 to {most}")]
    TooMany {
        /// Views asked for.
        asked: usize,
        /// Views possible.
        most: usize,
    },
    /// An angle that the wrist must not have.
    #[error(
        "an angle of {angle_rad} rad was asked for; the wrist may go from {min_rad} to {max_rad} rad"
    )]
    OutOfRange {
        /// Angle asked for, rad.
        angle_rad: f64,
        /// Smallest angle, rad.
        min_rad: f64,
        /// Largest angle, rad.
        max_rad: f64,
    },
    /// A range that the wrist cannot turn through.
    #[error(
        "a sweep through {range_rad} rad was asked for; the wrist has {min_rad} to {max_rad} rad"
    )]
    Range {
        /// Range asked for, rad.
        range_rad: f64,
        /// Smallest range, rad.
        min_rad: f64,
        /// Largest range, rad.
        max_rad: f64,
    },
    /// A sweep without kinematics.
    #[error(
        "a sweep needs the hand's pose in each image, and use_tf is false: ask for views at rest"
    )]
    NoKinematics,
    /// A rate at which images are blurred.
    #[error(
        "at {rate_rad_s} rad/s the surface {radius_m} m from the wrist's axis moves by {blur_mm:.2} mm during an exposure \
         of {exposure_s} s, more than {max_mm:.2} mm (blur_max_m): lower sweep_rate_rad_s, or the camera's exposure and \
         exposure_s with it"
    )]
    Blur {
        /// Rate of the sweep, rad/s.
        rate_rad_s: f64,
        /// Distance of the surface from the axis, m.
        radius_m: f64,
        /// Exposure, s.
        exposure_s: f64,
        /// How far the surface moves, mm.
        blur_mm: f64,
        /// How far it may, mm.
        max_mm: f64,
    },
}

/// Views of one scan at most: beyond it they lie closer than the wrist's accuracy is worth.
pub(crate) const VIEWS_MAX: usize = 64;

/// The scan that somebody asks for: `range_rad` of one sweep, or so many `views` at rest; 0: as configured.
///
/// # Errors
/// What cannot be made; see [`PlanError`].
pub fn plan_scan(
    parameters: &Parameters,
    views: u32,
    range_rad: f64,
) -> Result<WristPlan, PlanError> {
    let sweeps_by_itself = parameters.motion == Motion::Sweep && views == 0 && parameters.use_tf;
    let range_rad = match range_rad {
        0.0 if sweeps_by_itself => parameters.sweep_range_rad,
        0.0 => return plan(parameters, views).map(WristPlan::Rests),
        range_rad => range_rad,
    };
    let sweep = plan_sweep(parameters, range_rad, parameters.middle_rad())?;
    Ok(WristPlan::Sweep {
        range_rad,
        count: sweep.count,
    })
}

/// Wrist angles in rad for `views` views (0: as configured), evenly spaced about the centre, each within the joint's
/// range. The step shrinks where the range is too small for it.
///
/// # Errors
/// More views than a scan may have.
pub fn plan(parameters: &Parameters, views: u32) -> Result<Vec<f64>, PlanError> {
    let count = if views == 0 {
        parameters.view_count
    } else {
        views
    };
    check_count(count as usize)?;
    let (min_rad, max_rad) = (parameters.angle_min_rad, parameters.angle_max_rad);
    let intervals = f64::from(count - 1);
    let span_rad = (intervals * parameters.view_step_rad).min(max_rad - min_rad);
    let step_rad = if count > 1 { span_rad / intervals } else { 0.0 };
    let first_rad = parameters.middle_rad() - span_rad / 2.0;
    // Off-centre scans are moved into the range rather than cut. Not by `clamp`, which panics where rounding puts the
    // last start below the first, as where the span is the whole range.
    let first_rad = first_rad.min(max_rad - span_rad).max(min_rad);
    Ok((0..count)
        .map(|i| (first_rad + f64::from(i) * step_rad).min(max_rad))
        .collect())
}

/// Looks over wrist angles that somebody asks for, rad.
///
/// # Errors
/// The first that is outside the joint's range or not a number; more than a scan may have.
pub fn check(parameters: &Parameters, angles_rad: &[f64]) -> Result<(), PlanError> {
    check_count(angles_rad.len())?;
    let (min_rad, max_rad) = (parameters.angle_min_rad, parameters.angle_max_rad);
    match angles_rad
        .iter()
        .find(|angle_rad| !(min_rad..=max_rad).contains(*angle_rad))
    {
        None => Ok(()),
        Some(&angle_rad) => Err(PlanError::OutOfRange {
            angle_rad,
            min_rad,
            max_rad,
        }),
    }
}

fn check_count(asked: usize) -> Result<(), PlanError> {
    let most = VIEWS_MAX;
    if asked <= most {
        Ok(())
    } else {
        Err(PlanError::TooMany { asked, most })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use rand::{RngExt, SeedableRng};

    fn close(angles: &[f64], expected: &[f64]) -> bool {
        angles.len() == expected.len()
            && angles
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn views_spread_about_the_centre() {
        let parameters = Parameters::default();
        assert!(close(&plan(&parameters, 0).unwrap(), &[-0.6, 0.0, 0.6]));
        assert!(close(&plan(&parameters, 1).unwrap(), &[0.0]));
        assert!(close(&plan(&parameters, 2).unwrap(), &[-0.3, 0.3]));
    }

    #[test]
    fn many_views_stay_within_the_range() {
        let parameters = Parameters::default();
        let angles = plan(&parameters, 36).unwrap();
        assert_eq!(angles.len(), 36);
        assert!(angles.iter().all(|angle| angle.abs() <= 3.0 + 1e-12));
        assert!((angles[35] - 3.0).abs() < 1e-12 && (angles[0] + 3.0).abs() < 1e-12);
        assert_eq!(
            plan(&parameters, 65),
            Err(PlanError::TooMany {
                asked: 65,
                most: 64
            })
        );
    }

    #[test]
    fn a_scan_near_the_limit_is_moved_inside() {
        let parameters = Parameters {
            centre_angle_rad: 2.9,
            ..Default::default()
        };
        assert!(close(&plan(&parameters, 3).unwrap(), &[1.8, 2.4, 3.0]));
    }

    fn is_sweep(parameters: &Parameters, views: u32, range_rad: f64) -> bool {
        let plan = plan_scan(parameters, views, range_rad).unwrap();
        matches!(plan, WristPlan::Sweep { .. })
    }

    #[test]
    fn who_asks_for_views_gets_rests_and_who_asks_for_a_range_a_sweep() {
        let sweeping = Parameters {
            motion: Motion::Sweep,
            ..Default::default()
        };
        let stepping = Parameters {
            motion: Motion::Steps,
            ..Default::default()
        };
        assert!(is_sweep(&sweeping, 0, 0.0) && is_sweep(&stepping, 0, 1.0));
        assert!(!is_sweep(&sweeping, 3, 0.0) && !is_sweep(&stepping, 0, 0.0));
        let blind = Parameters {
            use_tf: false,
            ..sweeping
        };
        assert!(!is_sweep(&blind, 0, 0.0));
        assert_eq!(plan_scan(&blind, 0, 1.0), Err(PlanError::NoKinematics));
    }

    #[test]
    fn a_range_that_is_used_up_is_no_panic() {
        let seed = rand::random();
        println!("seed {seed}");
        let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(seed);
        let exact = Parameters {
            centre_angle_rad: -0.6,
            angle_min_rad: -1.7,
            angle_max_rad: 0.4,
            ..Default::default()
        };
        assert_eq!(plan(&exact, 5).unwrap().len(), 5);
        for _ in 0..10_000 {
            let (one, other) = (
                random.random_range(-7.0..7.0),
                random.random_range(-7.0..7.0),
            );
            let (min_rad, max_rad) = (f64::min(one, other), f64::max(one, other));
            let parameters = Parameters {
                angle_min_rad: min_rad,
                angle_max_rad: max_rad,
                centre_angle_rad: random.random_range(min_rad..=max_rad),
                view_step_rad: (max_rad - min_rad).max(0.01) / f64::from(random.random_range(1..9)),
                ..Default::default()
            };
            let angles = plan(&parameters, random.random_range(1..=64)).unwrap();
            assert_eq!(check(&parameters, &angles), Ok(()), "{parameters:?}");
        }
    }

    #[test]
    fn angles_outside_the_range_are_named() {
        let parameters = Parameters::default();
        assert_eq!(check(&parameters, &[-3.0, 3.0]), Ok(()));
        for bad in [3.1, f64::NAN, f64::NEG_INFINITY] {
            let error = check(&parameters, &[0.0, bad]).unwrap_err().to_string();
            assert!(error.contains(&format!("{bad} rad")), "{error}");
        }
        assert!(check(&parameters, &[0.0; 65]).is_err());
    }
}
