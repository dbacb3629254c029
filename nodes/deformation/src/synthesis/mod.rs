//! Analysis by synthesis (Yuille and Kersten, "Vision as Bayesian inference: analysis by synthesis?", Trends in Cognitive
//! Sciences 2006): the deformer that makes dents, as-rigid-as-possible (Sorkine and Alexa, SGP 2007), is fitted to the cloud
//! with the two pads of a parallel gripper as unknowns.
//!
//! The shape that results also has the parts that no camera saw. What is known of a pad there is what the seen rim of its
//! dent and the bulge beside it say. A depth is claimed only where the Hessian says that it is known.

mod squeeze;

use arap::ArapError;
use nalgebra::Point3;

use crate::dent::Dent;
use crate::dents::Patch;
use crate::field::Field;
use crate::fit;
use crate::parameters::Parameters;
use crate::placement::Placement;
use crate::reference::Reference;
use crate::shell::Shell;
use squeeze::{Sight, Squeeze};

/// The object as two pads have made it.
#[derive(Debug, Clone)]
pub struct Synthesis {
    /// Dents whose bottoms no camera saw, where they are sure. Their width, height and area are 0.
    pub unseen_dents: Vec<Dent>,
    /// Why there are none.
    pub unsaid: Option<Unsaid>,
    /// The whole outside in the frame of the cloud, m.
    pub vertices: Vec<Point3<f64>>,
    /// Indices into the vertices, three each, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Root mean square of the cloud's distances from it, strays counted as 4 mm.
    pub rms_m: f64,
}

/// Why nothing is said of dents that no camera saw.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unsaid {
    /// The parameter `synthesis` is false.
    #[error("analysis by synthesis is switched off")]
    Off,
    /// No pad is known of that could be opposite.
    #[error("no dent is in sight from which it would follow")]
    NoDent,
    /// As far as is known two pads pressed, and both places were seen.
    #[error("both sides that a gripper would press were seen")]
    Seen,
    /// The seen surface hardly depends on it.
    #[error("what was seen leaves its depth open by {:.1} mm", 1e3 * sigma_m)]
    Open {
        /// Standard deviation of the depth, m.
        sigma_m: f64,
    },
    /// What was seen fits an undented one as well.
    #[error("what was seen does not tell it from undented")]
    Shallow,
    /// The mesh does not allow it.
    #[error("the reference cannot be deformed: {0}")]
    Deformer(#[from] ArapError),
}

/// Points of the cloud that are used.
const POINTS: usize = 900;
/// What a coarse mesh leaves.
const MESH_SIGMA_M: f64 = 0.0005;
/// A pad's place counts as seen from this share on.
const SEEN_FROM: f64 = 0.5;
/// A depth is claimed up to this standard deviation.
const CLAIMED_SIGMA_M: f64 = 0.0025;
/// And from so many of them on.
const CLAIMED_FROM: f64 = 2.0;
/// A point farther off is no measure of the shape.
const STRAY_M: f64 = 0.004;

/// Fits the deformer, beginning at the deepest dent that was seen.
///
/// # Errors
/// [`Unsaid`], where there is no synthesis at all.
pub(crate) fn synthesise(
    reference: &Reference,
    field: &Field,
    placement: &Placement,
    dents: &[Patch],
    parameters: &Parameters,
) -> Result<Synthesis, Unsaid> {
    if !parameters.synthesis {
        return Err(Unsaid::Off);
    }
    let deepest = dents.first().ok_or(Unsaid::NoDent)?;
    let shell = reference.shell.as_ref().map_err(Clone::clone)?;
    let sights = sights(reference, shell, field);
    let squeeze = squeeze::fit(reference, shell, &sights, &deepest.centre, deepest.depth_m)?;
    let placement = fit::moved(reference, placement, &squeeze.motion);
    let cloud_from_object = placement.object_from_cloud.inverse();
    let vertices = shell.vertices_m.iter().zip(&squeeze.moved_m);
    let claims = [0, 1].map(|k| claim(reference, field, &squeeze, k, parameters));
    let unsaid = claims.iter().filter_map(|claim| claim.clone().err());
    let dents = [0, 1].into_iter().filter(|&k| claims[k].is_ok());
    let unseen_dents: Vec<Dent> = dents.map(|k| dent(&squeeze, k, &placement)).collect();
    Ok(Synthesis {
        unsaid: unsaid
            .reduce(|one, other| if one == Unsaid::Seen { other } else { one })
            .filter(|_| unseen_dents.is_empty()),
        unseen_dents,
        vertices: vertices
            .map(|(place, moved)| cloud_from_object * placement.in_object(&(place + moved)))
            .collect(),
        triangles: shell.triangles.clone(),
        rms_m: rms_m(&sights, &squeeze),
    })
}

fn sights(reference: &Reference, shell: &Shell, field: &Field) -> Vec<Sight> {
    let step = field.of_point.len().div_ceil(POINTS).max(1);
    let thinned = field.of_point.iter().zip(&field.places).step_by(step);
    let sight = |(deviation, place): (&Option<_>, &Point3<f64>)| {
        let deviation: &crate::field::Deviation = deviation.as_ref()?;
        let outer = &reference.outer;
        let normal = outer.samples[outer.nearest(&place.cast())].normal.cast();
        Some(Sight {
            spot: shell.spot(&(place - normal * deviation.off_m)),
            normal,
            off_m: deviation.off_m,
            sigma_m: deviation.sigma_m.hypot(MESH_SIGMA_M),
            motion: fit::motion_row(reference, place, &normal),
        })
    };
    thinned.filter_map(sight).collect()
}

/// Whether a pad's dent is one that was not seen and is known nevertheless.
fn claim(
    reference: &Reference,
    field: &Field,
    squeeze: &Squeeze,
    k: usize,
    parameters: &Parameters,
) -> Result<(), Unsaid> {
    let (pad, sigma_m) = (&squeeze.pads[k], squeeze.depth_sigma_m[k]);
    if seen_share(reference, field, &pad.centre) >= SEEN_FROM {
        return Err(Unsaid::Seen);
    }
    if sigma_m > CLAIMED_SIGMA_M {
        return Err(Unsaid::Open { sigma_m });
    }
    if pad.depth_m < parameters.depth_min_m.max(CLAIMED_FROM * sigma_m) {
        return Err(Unsaid::Shallow);
    }
    Ok(())
}

/// Share of the sites around a place that were seen.
fn seen_share(reference: &Reference, field: &Field, centre: &Point3<f64>) -> f64 {
    const AROUND_M: f32 = 0.008;
    let sites = reference.sites.list.iter().zip(&field.of_site);
    let around = sites.filter(|(site, _)| (site.point - centre.cast::<f32>()).norm() < AROUND_M);
    let (seen, all) = around.fold((0.0, 0.0), |(seen, all), (_, average)| {
        (seen + f64::from(u8::from(average.is_seen())), all + 1.0)
    });
    seen / f64::max(all, 1.0)
}

fn dent(squeeze: &Squeeze, k: usize, placement: &Placement) -> Dent {
    let (pad, sigma_m) = (&squeeze.pads[k], squeeze.depth_sigma_m[k]);
    Dent {
        depth_m: pad.depth_m,
        depth_sigma_m: sigma_m,
        significance: pad.depth_m / sigma_m,
        ..Dent::at(&pad.centre, pad.normal, placement)
    }
}

fn rms_m(sights: &[Sight], squeeze: &Squeeze) -> f64 {
    let square_m2 = |sight: &Sight| {
        let predicted_m = sight.normal.dot(&sight.spot.of(&squeeze.moved_m));
        let off_m = sight.off_m + sight.motion.dot(&squeeze.motion) - predicted_m;
        off_m.powi(2).min(STRAY_M * STRAY_M)
    };
    let sum_m2: f64 = sights.iter().map(square_m2).sum();
    (sum_m2 / f64::max(sights.len() as f64, 1.0)).sqrt()
}

#[cfg(test)]
mod tests;
