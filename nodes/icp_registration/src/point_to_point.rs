//! Registers without knowing more than that the views overlap: iterated closest points (Besl and McKay 1992), as the
//! paper's reference implementation does.

use cloud::voxel;
use nalgebra::{Isometry3, Point3, Vector3};

use crate::align::{Alignment, Fit, Placed};
use crate::closed_form::Pairs;
use crate::matching::Matcher;
use crate::model::Searchable;
use crate::parameters::Parameters;

/// Lays points onto the model from where they are: first thinned ones, which settle nearly where all will, then all.
/// `None` if fewer than three points match.
pub(crate) fn align(
    points: &[Point3<f32>],
    model: &Searchable,
    parameters: &Parameters,
) -> Option<Alignment> {
    let max_distance = parameters.identity_max_correspondence_m as f32;
    let mut limits = Limits {
        max_iterations: parameters.identity_max_iterations,
        relative_stop: parameters.identity_relative_stop.max(COARSE_STOP),
    };
    let coarse = coarse(points, model, parameters).and_then(|(points, model)| {
        Search::new(&points, &model, max_distance).run(Isometry3::identity(), limits)
    });
    let (start, spent) = coarse.map_or((Isometry3::identity(), 0), |found| {
        (found.motion, found.iterations)
    });

    limits.max_iterations = (limits.max_iterations - spent).max(1);
    limits.relative_stop = parameters.identity_relative_stop;
    let found = Search::new(points, model, max_distance).run(start, limits)?;
    Some(Alignment {
        iterations: found.iterations + spent,
        ..found
    })
}

/// Sides of the cubes for the first search, in voxels of the model.
const COARSE_VOXELS: f32 = 3.0;
/// The first search ends when a step changes less than this share.
const COARSE_STOP: f64 = 1e-4;
/// Fewer points than these are quick enough without a first search.
const COARSE_MIN_POINTS: usize = 500;

fn coarse(
    points: &[Point3<f32>],
    model: &Searchable,
    parameters: &Parameters,
) -> Option<(Vec<Point3<f32>>, Searchable)> {
    let side_m = COARSE_VOXELS * parameters.voxel_m as f32;
    let thinned = |points| voxel::downsample(points, side_m).ok();
    let model = Searchable::new(thinned(&model.points)?, side_m)?;
    (points.len() >= COARSE_MIN_POINTS).then_some((thinned(points)?, model))
}

#[derive(Clone, Copy)]
struct Limits {
    max_iterations: usize,
    relative_stop: f64,
}

struct Search<'a> {
    points: &'a [Point3<f32>],
    model: &'a Searchable,
    matcher: Matcher<'a>,
    centre: Point3<f64>,
}

impl<'a> Search<'a> {
    fn new(points: &'a [Point3<f32>], model: &'a Searchable, max_distance: f32) -> Self {
        let matcher = Matcher::new(model, max_distance, points.len());
        let centre = cloud::centroid(points)
            .unwrap_or_else(Point3::origin)
            .cast();
        Self {
            points,
            model,
            matcher,
            centre,
        }
    }

    /// Matches and moves until a step changes fitness and RMSE by less than a share. Steps that follow each other in
    /// one direction are drawn out (as in Besl and McKay's accelerated form), which on smooth objects saves most.
    fn run(&mut self, start: Isometry3<f64>, limits: Limits) -> Option<Alignment> {
        let mut motion = start;
        let mut steps = Steps::default();
        let (mut fit, mut pairs) = self.match_points(&motion);
        for iterations in 1..=limits.max_iterations {
            let before = (motion, fit);
            motion = pairs.motion()?;
            (fit, pairs) = self.match_points(&motion);
            let is_same =
                |now: f64, before: f64| (now - before).abs() <= limits.relative_stop * before.abs();
            let converged =
                is_same(fit.fitness, before.1.fitness) && is_same(fit.rmse_m, before.1.rmse_m);
            if converged || iterations == limits.max_iterations {
                return Some(Alignment {
                    motion,
                    fit,
                    iterations,
                    converged,
                    degenerate_directions: 0,
                    certainty: None,
                });
            }
            if let Some(farther) = steps.draw_out(&before.0, &motion, &self.centre) {
                motion = farther;
                (fit, pairs) = self.match_points(&motion);
            }
        }
        None
    }

    fn match_points(&mut self, motion: &Isometry3<f64>) -> (Fit, Pairs) {
        let placed = Placed::by(motion);
        let mut pairs = Pairs::default();
        let (mut inliers, mut sum_sq) = (0, 0.0);
        for (number, point) in self.points.iter().enumerate() {
            if let Some(found) = self.matcher.nearest(number, &placed.place(point)) {
                inliers += 1;
                sum_sq += f64::from(found.distance_sq);
                pairs.add(point, &self.model.points[found.index]);
            }
        }
        (Fit::new(inliers, self.points.len(), sum_sq), pairs)
    }
}

/// Remembers the last step, to see whether the next goes on in its direction.
#[derive(Default)]
struct Steps {
    last: Option<(Vector3<f64>, Vector3<f64>)>,
}

/// How far a step is drawn out at most, in steps.
const FARTHEST: f64 = 5.0;
/// Cosine between two steps in one direction.
const SAME_DIRECTION: f64 = 0.95;

impl Steps {
    /// Where a series of steps like the last two would end, if they go in one direction and shrink.
    fn draw_out(
        &mut self,
        before: &Isometry3<f64>,
        now: &Isometry3<f64>,
        centre: &Point3<f64>,
    ) -> Option<Isometry3<f64>> {
        let step = now * before.inverse();
        let place = before * centre;
        // A turn counts by what it moves at a hand's breadth.
        let turn = step.rotation.scaled_axis() * TURN_RADIUS_M;
        let shift = step * place - place;
        let last = self.last.replace((turn, shift))?;
        let dot = turn.dot(&last.0) + shift.dot(&last.1);
        let (length, last_length) = (
            (turn.norm_squared() + shift.norm_squared()).sqrt(),
            (last.0.norm_squared() + last.1.norm_squared()).sqrt(),
        );
        if dot < SAME_DIRECTION * length * last_length || length <= 0.0 {
            return None;
        }
        let ratio = length / last_length;
        let factor = if ratio < 1.0 {
            (ratio / (1.0 - ratio)).min(FARTHEST)
        } else {
            FARTHEST
        };
        // The next two steps are plain ones again.
        self.last = None;
        let rotation = nalgebra::UnitQuaternion::from_scaled_axis(turn * (factor / TURN_RADIUS_M));
        let place = now * centre;
        let target = place + shift * factor;
        let farther = Isometry3::from_parts((target - rotation * place).into(), rotation);
        Some(farther * now)
    }
}

const TURN_RADIUS_M: f64 = 0.05;
