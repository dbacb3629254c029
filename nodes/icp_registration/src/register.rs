//! All views at once.

use nalgebra::{Isometry3, Point3};

use crate::error::RegisterError;
use crate::evidence::ViewEvidence;
use crate::parameters::Parameters;
use crate::registrar::Registrar;

/// Registers all views of a scene at once.
///
/// Returns the registrar, which has the common cloud, and the evidence of each view.
///
/// # Errors
/// A parameter out of its range, or the index of the view that cannot be registered, and why.
pub fn register<'a>(
    parameters: Parameters,
    views: impl IntoIterator<Item = (&'a [Point3<f32>], Option<Isometry3<f64>>)>,
) -> Result<(Registrar, Vec<ViewEvidence>), RegisterError> {
    let mut registrar = Registrar::new(parameters)?;
    let evidence = views
        .into_iter()
        .enumerate()
        .map(|(index, (points, pose))| {
            registrar
                .add_view(points, pose)
                .map_err(|source| RegisterError::View { index, source })
        })
        .collect::<Result<_, _>>()?;
    Ok((registrar, evidence))
}
