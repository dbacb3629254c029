//! Single dented specimens of the eight objects; `sim/dataset` makes them by the thousand.

use std::sync::OnceLock;

use mesh::Mesh;
use sim_objects::{Instance, ObjectClass, Variation};

use crate::{DentError, Denter, Settings};

/// Deepest dent that may be asked for; a dent is shallower where the fingers would meet or the surface would fold.
pub const SQUEEZE_MAX_M: f64 = 0.015;

/// An object that cannot be dented so.
#[derive(Debug, thiserror::Error)]
pub enum SqueezeError {
    /// The depth is not a number, negative or too large.
    #[error("squeeze is {squeeze_m} m: expected 0 to {SQUEEZE_MAX_M} m")]
    Range {
        /// The asked depth, m.
        squeeze_m: f64,
    },
    /// No grasp of the object can be pressed.
    #[error(
        "the gripper finds no place on this object that it can press; is it wider than the gripper opens?"
    )]
    NoGrasp,
    /// The object cannot be grasped or deformed.
    #[error(transparent)]
    Dent(#[from] DentError),
}

/// A specimen of a class's traced object in the object frame: dented by `squeeze_m` from each side where `seed` says, its size off the
/// table's by `variation`. A squeeze of 0 changes nothing.
///
/// The [`Denter`] of a class is kept for the next specimen of it.
///
/// # Errors
/// [`SqueezeError::Range`].
pub fn specimen(
    class: ObjectClass,
    variation: &Variation,
    squeeze_m: f64,
    seed: u64,
) -> Result<Mesh, SqueezeError> {
    static DENTERS: Denters = no_denters();
    check(squeeze_m)?;
    let undented = class.mesh(&Variation::NONE);
    let mut mesh = kept_squeezed(&DENTERS, class, undented, squeeze_m, seed)?;
    variation.apply(&mut mesh);
    Ok(mesh)
}

/// An instance of a class's family in the object frame, dented as in [`specimen`]: the middle of the family is dented, and the
/// dent is carried to the instance.
///
/// # Errors
/// [`SqueezeError::Range`].
pub fn dented_instance(
    instance: &Instance,
    squeeze_m: f64,
    seed: u64,
) -> Result<Mesh, SqueezeError> {
    check(squeeze_m)?;
    pressed_instance(instance, squeeze_m, seed)
}

/// As [`dented_instance`], however deep the dent; it is shallower where the fingers would meet or the surface would fold.
///
/// # Errors
/// No grasp of the object can be pressed, or a depth that is no number.
pub fn pressed_instance(
    instance: &Instance,
    squeeze_m: f64,
    seed: u64,
) -> Result<Mesh, SqueezeError> {
    static DENTERS: Denters = no_denters();
    let class = instance.class();
    let undented = Instance::middle(class).mesh();
    let mut mesh = kept_squeezed(&DENTERS, class, undented, squeeze_m, seed)?;
    instance.carry(&mut mesh);
    Ok(mesh)
}

/// One for each class, made when it is first needed.
type Denters = [OnceLock<Denter>; ObjectClass::ALL.len()];

const fn no_denters() -> Denters {
    [const { OnceLock::new() }; ObjectClass::ALL.len()]
}

/// A class's mesh dented by the denter that is kept for it.
fn kept_squeezed(
    denters: &'static Denters,
    class: ObjectClass,
    mesh: Mesh,
    squeeze_m: f64,
    seed: u64,
) -> Result<Mesh, SqueezeError> {
    if squeeze_m == 0.0 {
        return Ok(mesh);
    }
    let place = &denters[class as usize];
    let denter = match place.get() {
        Some(denter) => denter,
        None => {
            let fresh = Denter::new(mesh, &Settings::default())?;
            place.get_or_init(|| fresh)
        }
    };
    squeezed(denter, squeeze_m, seed)
}

/// Any mesh dented by `squeeze_m` from each side where `seed` says. A squeeze of 0 changes nothing.
///
/// # Errors
/// [`SqueezeError`], with the reason.
pub fn squeeze(mesh: Mesh, squeeze_m: f64, seed: u64) -> Result<Mesh, SqueezeError> {
    check(squeeze_m)?;
    if squeeze_m == 0.0 {
        return Ok(mesh);
    }
    let denter = Denter::new(mesh, &Settings::default())?;
    squeezed(&denter, squeeze_m, seed)
}

fn check(squeeze_m: f64) -> Result<(), SqueezeError> {
    if (0.0..=SQUEEZE_MAX_M).contains(&squeeze_m) {
        Ok(())
    } else {
        Err(SqueezeError::Range { squeeze_m })
    }
}

/// Presses the first grasp, in the order of the seed, that the gripper can take and that gives way.
fn squeezed(denter: &Denter, squeeze_m: f64, seed: u64) -> Result<Mesh, SqueezeError> {
    let grasps = denter.grasps();
    for handle in grasps.order(seed) {
        let Ok(grasp) = grasps.grasp(handle) else {
            continue;
        };
        match denter.dent(&grasp, &[squeeze_m]) {
            Ok(dents) => {
                return dents
                    .into_iter()
                    .next()
                    .map(|dent| dent.mesh)
                    .ok_or(SqueezeError::NoGrasp);
            }
            Err(DentError::Folds { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }
    Err(SqueezeError::NoGrasp)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;
    use sim_objects::Instances;

    use super::*;

    #[test]
    fn a_squeeze_of_zero_is_the_specimen_undented() {
        for class in ObjectClass::ALL {
            let variation = Variation::random(3);
            assert_eq!(
                specimen(class, &variation, 0.0, 1).unwrap(),
                class.mesh(&variation)
            );
        }
    }

    #[test]
    fn every_object_is_dented_where_the_seed_says_and_stays_closed() {
        for (class, seed) in ObjectClass::ALL.into_iter().zip(5..) {
            println!("{class}, seed {seed}");
            let dented = |seed| specimen(class, &Variation::NONE, 0.008, seed).unwrap();
            let (whole, first) = (class.mesh(&Variation::NONE), dented(seed));
            assert_eq!(first, dented(seed));
            assert_ne!(first, dented(seed + 100));
            assert!(first.is_closed_manifold());
            // What a cup's mesh encloses is its walls.
            assert!(class.name().ends_with("cup") || first.volume_m3() < whole.volume_m3());
            let moved = |(a, b): (&nalgebra::Point3<f32>, &nalgebra::Point3<f32>)| (a - b).norm();
            let deepest_m = whole
                .vertices
                .iter()
                .zip(&first.vertices)
                .map(moved)
                .fold(0.0, f32::max);
            assert!((0.006..0.0085).contains(&deepest_m), "{deepest_m} m");
            let moved_at_ends = whole
                .vertices
                .iter()
                .zip(&first.vertices)
                .filter(|(v, _)| v.z == 0.0)
                .map(moved);
            assert_eq!(moved_at_ends.fold(0.0, f32::max), 0.0, "the bottom stays");
        }
    }

    #[test]
    fn instances_are_dented_as_their_familys_middle_is() {
        let seed = 21;
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        for class in ObjectClass::ALL {
            let instance = Instance::random(class, Instances::Training, &mut random);
            let whole = dented_instance(&instance, 0.0, 1).unwrap();
            assert_eq!(whole.triangles, instance.mesh().triangles);
            let first = dented_instance(&instance, 0.008, seed).unwrap();
            assert_eq!(first, dented_instance(&instance, 0.008, seed).unwrap());
            assert!(first.is_closed_manifold());
            let pairs = whole.vertices.iter().zip(&first.vertices);
            let deepest_m = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f32::max);
            assert!((0.005..0.01).contains(&deepest_m), "{class}: {deepest_m} m");
        }
        assert!(dented_instance(&Instance::middle(ObjectClass::TinyBall), 0.016, 0).is_err());
    }

    #[test]
    fn an_impossible_squeeze_is_refused_by_value() {
        for squeeze_m in [-0.001, 0.0151, f64::NAN, f64::INFINITY] {
            let refused = specimen(ObjectClass::TinyBall, &Variation::NONE, squeeze_m, 0);
            let text = refused.unwrap_err().to_string();
            assert!(
                text.contains(&squeeze_m.to_string()) && text.contains("0.015"),
                "{text}"
            );
        }
    }
}
