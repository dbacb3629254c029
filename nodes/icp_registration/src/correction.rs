//! Corrects a start that the kinematics gave.

use nalgebra::{Isometry3, Matrix6, Point3, Vector3, Vector6};

use crate::align::{Alignment, Fit, Placed};
use crate::matching::Matcher;
use crate::model::Searchable;
use crate::observability::{Certainty, Freedom, Twists};
use crate::parameters::{Metric, Parameters};

/// Step 2 of [`Registrar::add_view`](crate::Registrar::add_view): the small motion ξ with the least Σᵢ rᵢ², where
/// rᵢ = nᵢ·(mᵢ − exp(ξ) Tₖ pᵢ).
///
/// Each iteration is a Gauss-Newton step. With Jᵢ the `effect` of ξ, that is how far each motion moves pᵢ along nᵢ, it sums up
/// H = Σ JᵢJᵢᵀ (`information`) and g = Σ Jᵢrᵢ (`pull`) over the pairs that fit best, solves H ξ = g, moves the points, and
/// matches them anew. It moves along determined directions only (solution remapping, Zhang, Kaess and Singh 2016): the
/// eigenvectors of the mean of JᵢJᵢᵀ whose eigenvalues are large enough at the start. `None` if the view has no extent or
/// matches no surface.
pub(crate) fn correct(
    points: &[Point3<f32>],
    model: &Searchable,
    normals: &[Option<Vector3<f32>>],
    parameters: &Parameters,
) -> Option<Alignment> {
    let surface = Surface {
        points: &model.points,
        normals,
    };
    let twists = Twists::around(points)?;
    let max_distance = parameters.max_correspondence_m as f32;
    let mut matcher = Matcher::new(model, max_distance, points.len());
    let mut equations = Equations::new(&twists, parameters, points.len());
    let mut motion = Isometry3::identity();
    let mut fit = equations.gather(points, &motion, &surface, &mut matcher);
    // Decided once: what is weak at the start must not become strong by sliding along it.
    let freedom = Freedom::new(&equations.mean_information()?, parameters.degenerate_below);

    let mut converged = false;
    let mut iterations = 0;
    while iterations < parameters.max_iterations && !converged {
        iterations += 1;
        let amounts = freedom.solve(&equations.information, &equations.pull);
        motion = twists.motion(&amounts) * motion;
        fit = equations.gather(points, &motion, &surface, &mut matcher);
        converged = amounts.norm() < STILL_M;
    }
    let information = freedom.determined(&equations.mean_information()?);
    Some(Alignment {
        motion,
        fit,
        iterations,
        converged,
        degenerate_directions: freedom.degenerate_directions,
        certainty: Some(Certainty {
            twists,
            information,
        }),
    })
}

/// A step shorter than this ends the search, m: a twentieth of the camera's depth step.
const STILL_M: f64 = 2e-5;

/// The linear equations of one step, and the memory that they are made in.
struct Equations<'a> {
    twists: &'a Twists,
    max_aside_sq: f32,
    kept_fraction: f64,
    metric: Metric,
    rows: Vec<Row>,
    /// What the surfaces determine, whatever the metric: points that slide along a surface would seem to hold it.
    surface_information: Matrix6<f64>,
    information: Matrix6<f64>,
    pull: Vector6<f64>,
    used: usize,
}

/// The model's points with their normals, where it is flat.
struct Surface<'a> {
    points: &'a [Point3<f32>],
    normals: &'a [Option<Vector3<f32>>],
}

struct Row {
    place: Point3<f32>,
    normal: Vector3<f32>,
    /// From the point to its neighbour, m.
    offset: Vector3<f32>,
    /// What the metric makes small, m.
    misfit: f32,
}

impl<'a> Equations<'a> {
    fn new(twists: &'a Twists, parameters: &Parameters, capacity: usize) -> Self {
        Self {
            twists,
            max_aside_sq: parameters.aside_max_sq(),
            kept_fraction: parameters.kept_fraction,
            metric: parameters.metric,
            rows: Vec::with_capacity(capacity),
            surface_information: Matrix6::zeros(),
            information: Matrix6::zeros(),
            pull: Vector6::zeros(),
            used: 0,
        }
    }

    /// Matches the points where the motion puts them, and sums up the pairs that fit best.
    fn gather(
        &mut self,
        points: &[Point3<f32>],
        motion: &Isometry3<f64>,
        surface: &Surface,
        matcher: &mut Matcher,
    ) -> Fit {
        let placed = Placed::by(motion);
        self.rows.clear();
        let (mut inliers, mut sum_sq) = (0, 0.0);
        for (number, point) in points.iter().enumerate() {
            let place = placed.place(point);
            let Some(found) = matcher.nearest(number, &place) else {
                continue;
            };
            inliers += 1;
            sum_sq += f64::from(found.distance_sq);
            let Some(normal) = surface.normals[found.index] else {
                continue;
            };
            let offset = surface.points[found.index] - place;
            let gap = offset.dot(&normal);
            if found.distance_sq - gap * gap <= self.max_aside_sq {
                let misfit = match self.metric {
                    Metric::Plane => gap.abs(),
                    Metric::Point => offset.norm(),
                };
                self.rows.push(Row {
                    place,
                    normal,
                    offset,
                    misfit,
                });
            }
        }
        self.sum_up();
        Fit::new(inliers, points.len(), sum_sq)
    }

    fn sum_up(&mut self) {
        self.used = (self.rows.len() as f64 * self.kept_fraction).ceil() as usize;
        if self.used < self.rows.len() {
            self.rows
                .select_nth_unstable_by(self.used, |a, b| a.misfit.total_cmp(&b.misfit));
        }
        self.surface_information = Matrix6::zeros();
        self.information = Matrix6::zeros();
        self.pull = Vector6::zeros();
        for row in &self.rows[..self.used] {
            let effect = self.twists.effect(&row.place, &row.normal);
            self.surface_information.syger(1.0, &effect, &effect, 1.0);
            match self.metric {
                Metric::Plane => self.pull += effect * f64::from(row.offset.dot(&row.normal)),
                Metric::Point => {
                    for axis in 0..3 {
                        let effect = self.twists.effect(&row.place, &Vector3::ith(axis, 1.0));
                        self.information.syger(1.0, &effect, &effect, 1.0);
                        self.pull += effect * f64::from(row.offset[axis]);
                    }
                }
            }
        }
        self.surface_information
            .fill_upper_triangle_with_lower_triangle();
        match self.metric {
            Metric::Plane => self.information = self.surface_information,
            Metric::Point => self.information.fill_upper_triangle_with_lower_triangle(),
        }
    }

    /// `None` with fewer pairs than unknowns.
    fn mean_information(&self) -> Option<Matrix6<f64>> {
        (self.used >= 6).then(|| self.surface_information / self.used as f64)
    }
}
