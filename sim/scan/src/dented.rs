//! Specimens of the eight objects as grippers leave them.

use mesh::Mesh;
use rand::{Rng, RngExt};
use sim_deform::{Flattening, SqueezeError};
use sim_objects::{Instance, ObjectClass, Variation};

use crate::parameters::ScanParameters;

/// One specimen of a class's traced object in the object frame (bottom centre, +z up): a little off its size, and most times
/// dented.
///
/// # Errors
/// [`SqueezeError::Range`] for dents deeper than can be made.
pub fn dented(
    class: ObjectClass,
    parameters: &ScanParameters,
    random: &mut impl Rng,
) -> Result<Mesh, SqueezeError> {
    let variation = Variation::random(random.random());
    handled(class, parameters, random, |squeeze_m, seed| {
        sim_deform::specimen(class, &variation, squeeze_m, seed)
    })
}

/// An instance of a class's family, most times dented.
///
/// # Errors
/// As [`dented`].
pub fn dented_instance(
    instance: &Instance,
    parameters: &ScanParameters,
    random: &mut impl Rng,
) -> Result<Mesh, SqueezeError> {
    handled(instance.class(), parameters, random, |squeeze_m, seed| {
        sim_deform::dented_instance(instance, squeeze_m, seed)
    })
}

/// What `dent` makes with a depth (m) and a seed; some cans and cups are pressed flat on one side, too.
fn handled(
    class: ObjectClass,
    parameters: &ScanParameters,
    random: &mut impl Rng,
    dent: impl FnOnce(f64, u64) -> Result<Mesh, SqueezeError>,
) -> Result<Mesh, SqueezeError> {
    let is_dented = !random.random_bool(parameters.undented_share);
    let squeeze_m = if is_dented {
        random.random_range(parameters.squeeze_m[0]..=parameters.squeeze_m[1])
    } else {
        0.0
    };
    let mut mesh = dent(squeeze_m, random.random())?;
    if class.is_hollow() && random.random_bool(parameters.flattened_share) {
        let [shallow_m, deep_m] = parameters.flattening_m;
        let depth_m = random.random_range(shallow_m..=deep_m) as f32;
        Flattening::random(depth_m, mesh.bounds().1.z, random).apply(&mut mesh);
    }
    Ok(mesh)
}
