//! How an active scan turns the wrist: to one angle after the other, or in one sweep.

use crate::Parameters;
use crate::parameters::Motion;
use crate::plan_error::{PlanError, VIEWS_MAX};
use crate::sweep_plan::plan_sweep;
use baxter::WristPlan;

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
mod tests;
