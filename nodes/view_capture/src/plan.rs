//! The wrist angles of an active scan.

use crate::Parameters;
use thiserror::Error;

/// A scan that cannot be made.
#[derive(Debug, Error, PartialEq)]
pub enum PlanError {
    /// More views than the scan may have.
    #[error("{asked} views were asked for; a scan has 1 to {most}")]
    TooMany {
        /// Views asked for.
        asked: u32,
        /// Views possible.
        most: u32,
    },
}

/// Views of one scan at most: beyond it they lie closer than the wrist's accuracy is worth.
const VIEWS_MAX: u32 = 64;

/// Wrist angles in rad for `views` views (0: as configured), evenly spaced about the centre, each within the joint's
/// range. The step shrinks where the range is too small for it.
pub fn plan(parameters: &Parameters, views: u32) -> Result<Vec<f64>, PlanError> {
    let count = if views == 0 {
        parameters.view_count
    } else {
        views
    };
    if count > VIEWS_MAX {
        return Err(PlanError::TooMany {
            asked: count,
            most: VIEWS_MAX,
        });
    }
    let intervals = f64::from(count - 1);
    let range_rad = parameters.angle_max_rad - parameters.angle_min_rad;
    let span_rad = (intervals * parameters.view_step_rad).min(range_rad);
    let step_rad = if count > 1 { span_rad / intervals } else { 0.0 };
    // Off-centre scans are moved into the range rather than cut.
    let first_rad = (parameters.middle_rad() - span_rad / 2.0).clamp(
        parameters.angle_min_rad,
        parameters.angle_max_rad - span_rad,
    );
    Ok((0..count)
        .map(|i| first_rad + f64::from(i) * step_rad)
        .collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

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
}
