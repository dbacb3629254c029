//! Two opposite pads, fitted to what was seen.
//!
//! The unknowns are the position of the first pad on the surface and the depth of both pads. The second pad is opposite to the
//! first, as in a parallel gripper. They are estimated by Gauss-Newton with Levenberg damping and finite differences, under the
//! robust loss of Geman and McClure. Pose and size of the reference are refined at the same time, to first order, because a dent
//! biases them when they are fitted without it.

use arap::ArapError;
use nalgebra::{Point3, SMatrix, SVector, Vector3};

use crate::fit::{Motion, SCALE_SIGMA};
use crate::reference::{Reference, tangents};
use crate::shell::{Pad, Shell, Spot};

/// Shift of the first pad across and up, both depths, and the eight of [`Motion`].
const UNKNOWNS: usize = 12;
const MOTION: usize = 4;
type Information = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
type Row = SVector<f64, UNKNOWNS>;

/// A point of the cloud on the reference.
#[derive(Debug, Clone)]
pub(super) struct Sight {
    pub spot: Spot,
    /// Of the reference there, a unit vector.
    pub normal: Vector3<f64>,
    /// How far the point lies outside, m.
    pub off_m: f64,
    pub sigma_m: f64,
    /// How `off_m` changes with the pose and the size.
    pub motion: Motion,
}

/// Pads, and how sure their depths are.
#[derive(Debug, Clone)]
pub(super) struct Squeeze {
    pub pads: [Pad; 2],
    /// Standard deviation of each depth, m.
    pub depth_sigma_m: [f64; 2],
    /// Of each vertex of the shell, m.
    pub moved_m: Vec<Vector3<f64>>,
    /// Of the reference.
    pub motion: Motion,
}

const ROUNDS: usize = 8;
/// How often a step that does not help is shortened.
const SHORTENINGS: usize = 3;
/// Differences for the derivatives.
const SHIFT_STEP_M: f64 = 0.003;
const DEPTH_STEP_M: f64 = 0.001;
/// The first pad shifts by at most so much in a round.
const SHIFT_MAX_M: f64 = 0.006;
/// The pads leave a tenth of the distance between them.
const DEPTH_SHARE_MAX: f64 = 0.45;
/// Beyond so many standard deviations a point counts little.
const ROBUST: f64 = 3.0;
/// Neighbouring points err alike: so many count as one.
const ALIKE: f64 = 8.0;
/// What the deformer errs by beside the Hessian's standard deviations: measured on simulated scans.
const MODEL_FACTOR: f64 = 1.55;

/// Standard deviations of the unknowns before anything is seen: m, then rad, m and shares. Nothing says that both depths are
/// alike.
fn expected(reference: &Reference) -> Row {
    const PLACE_M: f64 = 0.03;
    const DEPTH_M: f64 = 0.01;
    const TURN_RAD: f64 = 0.02;
    const SHIFT_M: f64 = 0.002;
    let about_axis = if reference.is_of_revolution {
        1e-5
    } else {
        TURN_RAD
    };
    let pads = [PLACE_M, PLACE_M, DEPTH_M, DEPTH_M];
    let pose = [TURN_RAD, TURN_RAD, about_axis, SHIFT_M, SHIFT_M, SHIFT_M];
    Row::from_iterator(pads.into_iter().chain(pose).chain([SCALE_SIGMA; 2]))
}

/// Begins with the first pad at a dent that was seen, and the second as deep.
///
/// # Errors
/// The shell cannot be deformed so.
pub(super) fn fit(
    reference: &Reference,
    shell: &Shell,
    sights: &[Sight],
    start: &Point3<f64>,
    depth_m: f64,
) -> Result<Squeeze, ArapError> {
    let task = Task {
        reference,
        shell,
        sights,
        start,
        expected: expected(reference),
    };
    let mut best = task.at(start, [depth_m; 2], Motion::zeros())?;
    let mut cost = task.cost(&best);
    let mut damping = 1e-3;
    let mut information = Information::zeros();
    for _ in 0..ROUNDS {
        let (next, gradient) = task.system(&best)?;
        information = next;
        let before = cost;
        for _ in 0..SHORTENINGS {
            let damped =
                information + Information::from_diagonal(&(information.diagonal() * damping));
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&gradient)) else {
                break;
            };
            let next = task.stepped(&best, &step)?;
            let next_cost = task.cost(&next);
            if next_cost < cost {
                (best, cost) = (next, next_cost);
                damping *= 0.2;
                break;
            }
            damping *= 10.0;
        }
        if cost >= before {
            break;
        }
    }
    if let Some(covariance) = information.try_inverse() {
        let sigma = |k: usize| covariance[(k, k)].max(0.0).sqrt();
        best.depth_sigma_m = [2, 3].map(|k| MODEL_FACTOR * sigma(k));
    }
    Ok(best)
}

/// The shell after a step of one unknown.
struct Slope {
    moved_m: Vec<Vector3<f64>>,
    step_m: f64,
}

struct Task<'a> {
    reference: &'a Reference,
    shell: &'a Shell,
    sights: &'a [Sight],
    start: &'a Point3<f64>,
    expected: Row,
}

impl Task<'_> {
    fn on_surface(&self, place: &Point3<f64>, depth_m: f64) -> Pad {
        let outer = &self.reference.outer;
        let sample = outer.samples[outer.nearest(&place.cast())];
        Pad {
            centre: sample.point.cast(),
            normal: sample.normal.cast(),
            depth_m,
        }
    }

    /// The shell with its first pad here.
    fn at(
        &self,
        centre: &Point3<f64>,
        depths_m: [f64; 2],
        motion: Motion,
    ) -> Result<Squeeze, ArapError> {
        let first = self.on_surface(centre, depths_m[0]);
        let second = self.on_surface(&opposite(self.reference, &first.centre), depths_m[1]);
        let pads = [first, second];
        Ok(Squeeze {
            moved_m: self.shell.press(&pads)?.moved(depths_m)?,
            pads,
            motion,
            depth_sigma_m: [f64::INFINITY; 2],
        })
    }

    fn stepped(&self, from: &Squeeze, step: &Row) -> Result<Squeeze, ArapError> {
        let [across, up] = ways(&from.pads[0]);
        let shift = across * step[0] + up * step[1];
        let shift = shift.cap_magnitude(SHIFT_MAX_M);
        let limit_m = DEPTH_SHARE_MAX * (from.pads[0].centre - from.pads[1].centre).norm();
        let depth_m = |k: usize| (from.pads[k].depth_m + step[2 + k]).max(0.0).min(limit_m);
        let motion = from.motion + step.fixed_rows::<8>(MOTION);
        self.at(&(from.pads[0].centre + shift), [0, 1].map(depth_m), motion)
    }

    /// In standard deviations.
    fn residual(&self, sight: &Sight, squeeze: &Squeeze) -> f64 {
        let predicted_m = sight.normal.dot(&sight.spot.of(&squeeze.moved_m));
        (sight.off_m + sight.motion.dot(&squeeze.motion) - predicted_m) / sight.sigma_m
    }

    fn cost(&self, squeeze: &Squeeze) -> f64 {
        let robust = |sight: &Sight| {
            let square = self.residual(sight, squeeze).powi(2);
            square / (1.0 + square / (ROBUST * ROBUST)) / ALIKE
        };
        let unlike = self.unlike(squeeze).component_div(&self.expected);
        self.sights.iter().map(robust).sum::<f64>() + unlike.norm_squared()
    }

    /// The difference of each unknown from its initial value; divided by the prior standard deviations, it is the residual of the prior.
    fn unlike(&self, squeeze: &Squeeze) -> Row {
        let away = squeeze.pads[0].centre - self.start;
        let [across, up] = ways(&squeeze.pads[0]).map(|way| way.dot(&away));
        let pads = [across, up, squeeze.pads[0].depth_m, squeeze.pads[1].depth_m];
        Row::from_iterator(pads.into_iter().chain(squeeze.motion.iter().copied()))
    }

    /// Information and negative gradient.
    fn system(&self, squeeze: &Squeeze) -> Result<(Information, Row), ArapError> {
        let slopes = self.slopes(squeeze)?;
        let (mut information, mut gradient) = (Information::zeros(), Row::zeros());
        for sight in self.sights {
            let residual = self.residual(sight, squeeze);
            let own = sight.spot.of(&squeeze.moved_m);
            let mut row = Row::zeros();
            for (k, Slope { moved_m, step_m }) in slopes.iter().enumerate() {
                row[k] = -sight.normal.dot(&(sight.spot.of(moved_m) - own)) / step_m;
            }
            row.fixed_rows_mut::<8>(MOTION).copy_from(&sight.motion);
            row /= sight.sigma_m;
            let weight = (1.0 + (residual / ROBUST).powi(2)).powi(-2) / ALIKE;
            information.syger(weight, &row, &row, 1.0);
            gradient -= row * (weight * residual);
        }
        information.fill_upper_triangle_with_lower_triangle();
        let unlike = self.unlike(squeeze);
        for k in 0..UNKNOWNS {
            information[(k, k)] += self.expected[k].powi(-2);
            gradient[k] -= unlike[k] * self.expected[k].powi(-2);
        }
        Ok((information, gradient))
    }

    /// One for each of the pads' unknowns.
    fn slopes(&self, squeeze: &Squeeze) -> Result<Vec<Slope>, ArapError> {
        let depths_m = squeeze.pads.map(|pad| pad.depth_m);
        let mut slopes = Vec::with_capacity(MOTION);
        for way in ways(&squeeze.pads[0]) {
            let place = squeeze.pads[0].centre + way * SHIFT_STEP_M;
            let shifted = self.at(&place, depths_m, squeeze.motion)?;
            slopes.push(Slope {
                moved_m: shifted.moved_m,
                step_m: SHIFT_STEP_M,
            });
        }
        let mut press = self.shell.press(&squeeze.pads)?;
        press.moved(depths_m)?;
        for k in 0..2 {
            let mut deeper_m = depths_m;
            deeper_m[k] += DEPTH_STEP_M;
            slopes.push(Slope {
                moved_m: press.moved(deeper_m)?,
                step_m: DEPTH_STEP_M,
            });
        }
        Ok(slopes)
    }
}

fn ways(pad: &Pad) -> [Vector3<f64>; 2] {
    tangents(&pad.normal.cast()).map(|way| way.into_inner().cast())
}

/// The place at the same height that is farthest away: a parallel gripper's other pad.
fn opposite(reference: &Reference, place: &Point3<f64>) -> Point3<f64> {
    const SLICE_M: f64 = 0.001;
    let away_m = |other: &Point3<f64>| (other.x - place.x).hypot(other.y - place.y);
    let samples = reference.outer.samples.iter();
    let slice = samples
        .map(|sample| sample.point.cast::<f64>())
        .filter(|other| (other.z - place.z).abs() < SLICE_M);
    slice
        .max_by(|a, b| away_m(a).total_cmp(&away_m(b)))
        .unwrap_or(*place)
}
