//! The answer.

use nalgebra::Vector3;

use crate::dent::Dent;
use crate::dents;
use crate::field::Field;
use crate::fit::{Fit, fit};
use crate::observation::Observation;
use crate::parameters::Parameters;
use crate::placement::Placement;
use crate::reference::Reference;
use crate::synthesis::{Synthesis, Unsaid, synthesise};

/// How an object differs from its reference.
#[derive(Debug, Clone)]
pub struct Measured {
    /// How the reference lies in the cloud's frame.
    pub placement: Placement,
    /// Standard deviations about the object's axes, rad; infinite where the shape leaves a turn open.
    pub rotation_sigma_rad: Vector3<f64>,
    /// Along them, m.
    pub translation_sigma_m: Vector3<f64>,
    /// The deepest first.
    pub dents: Vec<Dent>,
    /// Share of the outer surface that was seen, 0 to 1. What was not seen may be dented.
    pub seen_share: f64,
    /// Root mean square of the deviations where nothing is dented, m.
    pub undented_rms_m: f64,
    /// Largest significance of anything that lies inside, dent or not, in standard deviations.
    pub significance: f64,
    /// Why nothing can be said of dents; then there are none.
    pub doubt: Option<Doubt>,
    /// Deviation of each point of the cloud along the reference's normal, m, negative inside; NaN for what is not on the
    /// outer surface.
    pub deviations_m: Vec<f32>,
    /// What the deformer says, fitted to the cloud; or why it does not.
    pub synthesis: Result<Synthesis, Unsaid>,
}

impl Measured {
    /// Whether enough was seen, and the reference lies in it.
    pub fn fits(&self) -> bool {
        self.doubt.is_none()
    }

    /// Dents of places that no camera saw.
    pub fn unseen_dents(&self) -> &[Dent] {
        match &self.synthesis {
            Ok(synthesis) => &synthesis.unseen_dents,
            Err(_) => &[],
        }
    }

    /// Why there are none.
    pub fn unsaid(&self) -> Option<&Unsaid> {
        match &self.synthesis {
            Ok(synthesis) => synthesis.unsaid.as_ref(),
            Err(unsaid) => Some(unsaid),
        }
    }

    /// Of the deepest dent that was seen, m; 0 without one.
    pub fn largest_depth_m(&self) -> f64 {
        self.dents.first().map_or(0.0, |dent| dent.depth_m)
    }
}

/// Why nothing is said.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Doubt {
    /// The cloud is of something else, or the reference is of another object.
    #[error(
        "the reference does not fit: {:.0} % of the cloud lies on it", 100.0 * share
    )]
    DoesNotFit {
        /// Share of the points that lie on the reference.
        share: f64,
    },
    /// A corner of the object is not enough to say how it is turned.
    #[error("too little was seen: {:.0} % of the surface", 100.0 * share)]
    TooLittleSeen {
        /// Share of the outer surface that was seen.
        share: f64,
    },
}

/// Share of the points that must lie on the reference, dents and what the fingers left aside.
const FITS_FROM: f64 = 0.5;

/// Compares a cloud with a reference.
///
/// # Errors
/// [`Doubt`], where not even a placement can be given.
pub fn measure(
    reference: &Reference,
    seen: &Observation<'_>,
    parameters: &Parameters,
) -> Result<Measured, Doubt> {
    let fit = fit(reference, seen).ok_or(Doubt::DoesNotFit { share: 0.0 })?;
    let field = Field::new(reference, seen, &fit.placement, parameters);
    let seen_share = seen_share(reference, &field);
    let doubt = doubt(&fit, seen_share, parameters);
    let significance = field.of_site.iter().map(|average| average.significance());
    let patches = match doubt {
        None => dents::patches(reference, &field, parameters),
        Some(_) => Vec::new(),
    };
    let synthesis = synthesise(reference, &field, &fit.placement, &patches, parameters);
    Ok(Measured {
        significance: significance.fold(0.0, f64::max),
        dents: patches
            .iter()
            .map(|patch| Dent::of(patch, &fit.placement))
            .collect(),
        placement: fit.placement,
        rotation_sigma_rad: fit.rotation_sigma,
        translation_sigma_m: fit.translation_sigma,
        seen_share,
        undented_rms_m: field.rms_m,
        doubt,
        deviations_m: deviations(&field),
        synthesis,
    })
}

fn deviations(field: &Field) -> Vec<f32> {
    let off = |deviation: &Option<_>| {
        deviation
            .as_ref()
            .map_or(f32::NAN, |deviation: &crate::field::Deviation| {
                deviation.off_m as f32
            })
    };
    field.of_point.iter().map(off).collect()
}

fn seen_share(reference: &Reference, field: &Field) -> f64 {
    let (mut seen_m2, mut all_m2) = (0.0, 0.0);
    for (site, average) in reference.sites.list.iter().zip(&field.of_site) {
        let area_m2 = f64::from(site.area_m2);
        all_m2 += area_m2;
        if average.is_seen() {
            seen_m2 += area_m2;
        }
    }
    seen_m2 / all_m2
}

fn doubt(fit: &Fit, seen_share: f64, parameters: &Parameters) -> Option<Doubt> {
    let share = 1.0 - fit.misfit;
    if share < FITS_FROM {
        return Some(Doubt::DoesNotFit { share });
    }
    (seen_share < parameters.seen_share_min).then_some(Doubt::TooLittleSeen { share: seen_share })
}
