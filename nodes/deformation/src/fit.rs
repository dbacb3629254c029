//! Where the reference is in the cloud, dents and fingers aside.
//!
//! Point-to-plane distances (Chen and Medioni, 1992) under Geman and McClure's loss, whose scale shrinks from one step to
//! the next (graduated non-convexity: Yang, Antonante, Tzoumas and Carlone, "Graduated non-convexity for robust spatial
//! perception", RA-L 2020), by Gauss-Newton. Beside the pose two scales are free within what specimens of one make
//! differ by.

use nalgebra::{Point3, SMatrix, SVector, Translation3, UnitQuaternion, Vector3};

use crate::layer::Sample;
use crate::observation::{Cameras, Observation};
use crate::placement::Placement;
use crate::reference::Reference;
use crate::starts::starts;

/// Rotation about the axes through the object's middle, translation, and relative width and height.
const UNKNOWNS: usize = 8;
type Information = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
pub(crate) type Motion = SVector<f64, UNKNOWNS>;

/// A placement, and how sure it is.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    pub placement: Placement,
    /// Mean of the truncated squares, as a share of the largest; 0 is perfect.
    pub misfit: f64,
    /// Standard deviations about and along the object's axes, rad and m; infinite where the shape leaves the motion open.
    pub rotation_sigma: Vector3<f64>,
    pub translation_sigma: Vector3<f64>,
}

/// Distance at which a point counts as fully wrong.
const TRUNCATION_M: f64 = 0.004;
const WIDE_M: f64 = 0.010;
const NARROW_M: f64 = 0.0015;
const COARSE_STEPS: usize = 7;
const FINE_STEPS: usize = 12;
const COARSE_POINTS: usize = 250;
const FINE_POINTS: usize = 900;
/// Spread of the sizes of one make.
pub(crate) const SCALE_SIGMA: f64 = 0.006;
/// Noise of a point, m.
const POINT_SIGMA_M: f64 = 0.0008;
/// Neighbouring points err alike: so many count as one.
const ALIKE: f64 = 8.0;

/// Looks for the best placement; `None` where nothing of the cloud comes near to the reference.
pub(crate) fn fit(reference: &Reference, seen: &Observation<'_>) -> Option<Fit> {
    let coarse = thinned(seen.points, COARSE_POINTS);
    let mut found: Vec<_> = starts(reference, seen)
        .into_iter()
        .filter_map(|start| descend(reference, seen, &coarse, start, WIDE_M, COARSE_STEPS))
        .collect();
    found.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
    let fine = thinned(seen.points, FINE_POINTS);
    let best = found.into_iter().take(2).filter_map(|start| {
        let start = start.placement;
        descend(reference, seen, &fine, start, 0.5 * WIDE_M, FINE_STEPS)
    });
    best.min_by(|a, b| a.misfit.total_cmp(&b.misfit))
}

fn thinned(points: &[Point3<f32>], count: usize) -> Vec<Point3<f64>> {
    let step = points.len().div_ceil(count).max(1);
    points.iter().step_by(step).map(|p| p.cast()).collect()
}

fn descend(
    reference: &Reference,
    seen: &Observation<'_>,
    points: &[Point3<f64>],
    start: Placement,
    wide_m: f64,
    steps: usize,
) -> Option<Fit> {
    let mut placement = start;
    let mut system = System::default();
    for step in 0..steps {
        let share = step as f64 / (steps - 1) as f64;
        let scale_m = wide_m * (NARROW_M / wide_m).powf(share);
        system = System::of(reference, seen, points, &placement, scale_m);
        system.apply(reference, &mut placement)?;
    }
    let misfit = system.misfit / points.len().max(1) as f64;
    let [rotation_sigma, translation_sigma] = system.sigmas(reference);
    Some(Fit {
        placement,
        misfit,
        rotation_sigma,
        translation_sigma,
    })
}

/// The normal equations of one step.
#[derive(Default)]
struct System {
    information: Information,
    gradient: Motion,
    misfit: f64,
    placement_scales: [f64; 2],
}

impl System {
    fn of(
        reference: &Reference,
        seen: &Observation<'_>,
        points: &[Point3<f64>],
        placement: &Placement,
        scale_m: f64,
    ) -> Self {
        let mut system = Self {
            placement_scales: [placement.width_scale.ln(), placement.height_scale.ln()],
            ..Self::default()
        };
        let cameras = cameras(seen, placement);
        let weight_scale = 1.0 / (POINT_SIGMA_M * POINT_SIGMA_M * ALIKE);
        for point in points {
            let place = placement.on_reference(point);
            let Some(sample) = facing(reference, &cameras, &place) else {
                system.misfit += 1.0;
                continue;
            };
            let normal: Vector3<f64> = sample.normal.cast();
            let off_m = normal.dot(&(place - sample.point.cast::<f64>()));
            system.misfit += (off_m / TRUNCATION_M).powi(2).min(1.0);
            let ratio = scale_m * scale_m / (scale_m * scale_m + off_m * off_m);
            let weight = weight_scale * ratio * ratio;
            let row = motion_row(reference, &place, &normal);
            system.information.syger(weight, &row, &row, 1.0);
            system.gradient -= row * (weight * off_m);
        }
        system.information.fill_upper_triangle_with_lower_triangle();
        system
    }

    /// Information with what is known beforehand, so that every motion has some.
    fn regular(&self, reference: &Reference) -> (Information, Motion) {
        const TURN_SIGMA_RAD: f64 = 0.2;
        const SHIFT_SIGMA_M: f64 = 0.02;
        let (mut information, mut gradient) = (self.information, self.gradient);
        for axis in 0..3 {
            information[(axis, axis)] += TURN_SIGMA_RAD.powi(-2);
            information[(3 + axis, 3 + axis)] += SHIFT_SIGMA_M.powi(-2);
        }
        if reference.is_of_revolution {
            information[(2, 2)] += 1e9;
        }
        for (index, log_scale) in self.placement_scales.into_iter().enumerate() {
            information[(6 + index, 6 + index)] += SCALE_SIGMA.powi(-2);
            gradient[6 + index] -= SCALE_SIGMA.powi(-2) * log_scale;
        }
        (information, gradient)
    }

    fn apply(&self, reference: &Reference, placement: &mut Placement) -> Option<()> {
        let (information, gradient) = self.regular(reference);
        let step = information.cholesky()?.solve(&gradient);
        *placement = moved(reference, placement, &step);
        Some(())
    }

    fn sigmas(&self, reference: &Reference) -> [Vector3<f64>; 2] {
        let (mut information, _) = self.regular(reference);
        if reference.is_of_revolution {
            information[(2, 2)] = 1e9;
        }
        let Some(covariance) = information.try_inverse() else {
            return [Vector3::repeat(f64::INFINITY); 2];
        };
        let sigma = |index: usize| covariance[(index, index)].max(0.0).sqrt();
        let mut rotation = Vector3::from_fn(|axis, _| sigma(axis));
        if reference.is_of_revolution {
            rotation.z = f64::INFINITY;
        }
        [rotation, Vector3::from_fn(|axis, _| sigma(3 + axis))]
    }
}

/// A placement after a step of the unknowns that [`motion_row`] has.
pub(crate) fn moved(reference: &Reference, placement: &Placement, step: &Motion) -> Placement {
    const TURN_MAX_RAD: f64 = 0.3;
    let mut turn: Vector3<f64> = step.fixed_rows::<3>(0).into_owned();
    if turn.norm() > TURN_MAX_RAD {
        turn *= TURN_MAX_RAD / turn.norm();
    }
    let middle = Translation3::from(middle(reference).coords);
    let motion = Translation3::from(step.fixed_rows::<3>(3).into_owned())
        * middle
        * UnitQuaternion::from_scaled_axis(turn)
        * middle.inverse();
    let scale_max = 5.0 * SCALE_SIGMA;
    let scaled = |scale: f64, step: f64| (scale.ln() + step).clamp(-scale_max, scale_max).exp();
    Placement {
        object_from_cloud: motion * placement.object_from_cloud,
        width_scale: scaled(placement.width_scale, step[6]),
        height_scale: scaled(placement.height_scale, step[7]),
    }
}

/// How a point's distance from the reference changes with each unknown of a step.
pub(crate) fn motion_row(
    reference: &Reference,
    place: &Point3<f64>,
    normal: &Vector3<f64>,
) -> Motion {
    let turn = (place - middle(reference)).cross(normal);
    let wider = -(normal.x * place.x + normal.y * place.y);
    let higher = -normal.z * place.z;
    Motion::from([
        turn.x, turn.y, turn.z, normal.x, normal.y, normal.z, wider, higher,
    ])
}

fn middle(reference: &Reference) -> Point3<f64> {
    Point3::new(0.0, 0.0, 0.5 * f64::from(reference.height_m))
}

/// Viewpoints in the frame of the reference.
pub(crate) fn cameras(seen: &Observation<'_>, placement: &Placement) -> Cameras {
    Cameras::new(
        seen.viewpoints
            .iter()
            .map(|place| placement.on_reference(place)),
    )
}

/// The sample of the reference nearest to a place (approximately), on the side that a camera sees: the outside, or else the inside of
/// a hollow.
fn facing<'a>(
    reference: &'a Reference,
    cameras: &Cameras,
    place: &Point3<f64>,
) -> Option<&'a Sample> {
    let outer = reference.outer.near(&place.cast())?;
    match &reference.hollow {
        Some(hollow) if !cameras.see(outer, place) => hollow
            .near(&place.cast())
            .filter(|inner| cameras.see(inner, place)),
        _ => Some(outer),
    }
}
