//! Which views of a sweep a calibration uses.
//!
//! Joint states and images may be stamped by two clocks. While the wrist turns at a constant rate, a difference of the clocks
//! turns all views of a sweep alike, about the wrist's axis, and the views agree with each other. Views at other rates, as on a ramp
//! or on the way back, are turned by another angle. An error of the mount asks for no such turn, so that these views hardly move the
//! mount that is found; but their surfaces lie on each other less well, and that is what a calibration is judged by.

/// Least share of the usual rate that a view must have.
const RATE_SHARE_MIN: f64 = 0.95;

/// Numbers of at most `count` views, evenly spread over those that were taken at the sweep's own rate, by the rates of all
/// views in their order (rad/s, with sign). Where fewer than `count` were, as where a busy machine delays joint states or images,
/// those of all rates count. None where nothing turned.
pub fn steady_views(rates_rad_s: &[f64], count: usize) -> Vec<usize> {
    // The range is longer than the way to its beginning, which the wrist goes in the other direction.
    let mut sorted: Vec<f64> = rates_rad_s.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(&usual_rad_s) = sorted.get(sorted.len() / 2) else {
        return Vec::new();
    };
    if usual_rad_s == 0.0 || usual_rad_s.is_nan() {
        return Vec::new();
    }
    let is_steady = |rate_rad_s: f64| {
        let share = rate_rad_s / usual_rad_s;
        (RATE_SHARE_MIN..=1.0 / RATE_SHARE_MIN).contains(&share)
    };
    let steady: Vec<usize> = (0..)
        .zip(rates_rad_s)
        .filter(|(_, rate_rad_s)| is_steady(**rate_rad_s))
        .map(|(number, _)| number)
        .collect();
    if steady.len() >= count {
        evenly_spread(&steady, count)
    } else {
        evenly_spread(&Vec::from_iter(0..rates_rad_s.len()), count)
    }
}

/// At most `count` of the numbers, the first and the last among them.
fn evenly_spread(numbers: &[usize], count: usize) -> Vec<usize> {
    let count = count.min(numbers.len());
    (0..count)
        .filter_map(|place| numbers.get(place * (numbers.len() - 1) / (count - 1).max(1)))
        .copied()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_on_ramps_and_on_the_way_to_the_beginning_are_left_out() {
        let mut rates = vec![0.02, -0.5, -1.15, -1.15, -0.3];
        rates.extend([0.1, 0.7]);
        rates.extend([1.15; 9]);
        rates.extend([0.6, 0.0]);
        assert_eq!(steady_views(&rates, 3), [7, 11, 15]);
        assert_eq!(steady_views(&rates, 9), [7, 8, 9, 10, 11, 12, 13, 14, 15]);
        assert_eq!(steady_views(&rates, 1), [7]);
        assert!(steady_views(&rates, 0).is_empty());
    }

    #[test]
    fn too_few_views_of_one_rate_are_joined_by_the_others() {
        // What a machine that was busy left of a sweep.
        let rates = [-1.15, 1.15, 1.15, 0.4, 0.9, 1.4];
        assert_eq!(steady_views(&rates, 4), [0, 1, 3, 5]);
        assert_eq!(steady_views(&rates, 8), [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn a_wrist_that_does_not_turn_has_no_steady_views() {
        assert!(steady_views(&[], 4).is_empty());
        assert!(steady_views(&[0.0; 5], 4).is_empty());
        assert!(steady_views(&[f64::NAN; 5], 4).is_empty());
    }
}
