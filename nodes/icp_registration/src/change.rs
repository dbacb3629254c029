//! Whether a view shows the object that the views before showed, where they showed it.

use crate::error::RegistrationError;
use crate::parameters::Parameters;
use crate::visibility::Comparison;

/// What a comparison with the views before says of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sameness {
    /// It shows the same object and gripper.
    Same,
    /// It fits the views before in no pose that was tried, gripper and all.
    Misplaced,
}

/// Compares a view with the views before: `found` in the pose that the search found, `start` in the one that kinematics and
/// mount gave, which is asked for only where the gripper is not where it was.
///
/// The gripper is the same in all views, so that it tells a pose that is wrong (it is contradicted, too) from an object that
/// has changed (only the object is contradicted), and from one that has moved in the fingers (the pose that fits the object
/// does not fit the gripper). If the hand was empty and still is, only the fingers are visible, which is not enough to detect
/// a change: either nothing has changed, or the pose is wrong.
///
/// # Errors
/// The object is gone, is another, moved in the fingers, or was put in meanwhile.
pub(crate) fn same_object(
    found: &Comparison,
    start: impl FnOnce() -> Result<Comparison, RegistrationError>,
    correction_m: f64,
    limits: &Parameters,
) -> Result<Sameness, RegistrationError> {
    let differs = |comparison: &Comparison| comparison.object.largest() > limits.max_change;
    let fits_gripper =
        |comparison: &Comparison| comparison.gripper.largest() <= limits.max_gripper_change;
    if found.was_empty && found.is_empty {
        let is_misplaced = differs(found) && !fits_gripper(found);
        return Ok(if is_misplaced {
            Sameness::Misplaced
        } else {
            Sameness::Same
        });
    }
    let pose = if fits_gripper(found) {
        *found
    } else {
        let start = start()?;
        match (fits_gripper(&start), differs(found)) {
            (true, false) if differs(&start) => {
                let moved_m = correction_m;
                return Err(RegistrationError::Slipped { moved_m });
            }
            (true, _) => start,
            (false, true) => return Ok(Sameness::Misplaced),
            (false, false) => return Ok(Sameness::Same),
        }
    };
    if !differs(&pose) {
        return Ok(Sameness::Same);
    }
    let [gone, new] = [pose.object.gone, pose.object.new];
    Err(match (pose.was_empty, pose.is_empty) {
        (false, true) => RegistrationError::Dropped { gone },
        (true, false) => RegistrationError::PutIn { new },
        (false, false) | (true, true) => RegistrationError::Swapped { gone, new },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::Change;

    fn sameness(comparison: Comparison) -> Result<Sameness, RegistrationError> {
        same_object(
            &comparison,
            || Ok(comparison),
            0.004,
            &Parameters::default(),
        )
    }

    /// A pose that is a little off moves the fingers, which are all that is seen.
    #[test]
    fn fingers_that_hold_nothing_are_no_other_object() {
        let moved = Change {
            gone: 0.02,
            new: 0.17,
        };
        let empty = Comparison {
            object: moved,
            gripper: Change::default(),
            was_empty: true,
            is_empty: true,
        };
        assert_eq!(sameness(empty), Ok(Sameness::Same));
        let gripper = Change {
            gone: 0.5,
            new: 0.0,
        };
        assert_eq!(
            sameness(Comparison { gripper, ..empty }),
            Ok(Sameness::Misplaced)
        );
        let held = Comparison {
            was_empty: false,
            is_empty: false,
            ..empty
        };
        assert!(matches!(
            sameness(held),
            Err(RegistrationError::Swapped { .. })
        ));
    }
}
