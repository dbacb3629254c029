//! Views in, one cloud and the evidence out.

use cloud::{transformed, voxel};
use nalgebra::{Isometry3, Point3};
use parameter::ParameterError;

use crate::align::Alignment;
use crate::check::check_points;
use crate::coverage::Coverage;
use crate::error::{RegisterError, RegistrationError};
use crate::evidence::{StopReason, ViewEvidence};
use crate::model::Model;
use crate::mount::MountError;
use crate::observability::Certainty;
use crate::parameters::{InitialGuess, Parameters};
use crate::{correction, point_to_point};

/// Registers the views of a scan one after the other.
#[derive(Debug, Clone)]
pub struct Registrar {
    parameters: Parameters,
    model: Model,
    mount: MountError,
    coverage: Coverage,
    in_hand_frame: bool,
}

impl Registrar {
    /// Checks the parameters.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let voxel_m = parameters.voxel_m as f32;
        let model = Model::new(voxel_m).map_err(|_| {
            ParameterError::new("voxel_m", parameters.voxel_m, "a positive length in m")
        })?;
        Ok(Self {
            parameters,
            model,
            mount: MountError::default(),
            coverage: Coverage::default(),
            in_hand_frame: false,
        })
    }

    /// Forgets all views.
    pub fn reset(&mut self) {
        // The grid of a registrar that exists was made before with the same size.
        if let Ok(model) = Model::new(self.parameters.voxel_m as f32) {
            self.model = model;
        }
        self.mount = MountError::default();
        self.coverage = Coverage::default();
        self.in_hand_frame = false;
    }

    /// Adds a view: points in m in the camera's frame, and where the kinematics say that the hand was.
    ///
    /// A view that fails leaves the cloud as it was.
    pub fn add_view(
        &mut self,
        points: &[Point3<f32>],
        hand_from_camera: Option<Isometry3<f64>>,
    ) -> Result<ViewEvidence, RegistrationError> {
        check_points(points, self.parameters.min_points)?;
        let kinematic = self.start_pose(hand_from_camera)?;
        let in_hand_frame = kinematic.is_some();
        let start = kinematic.map_or_else(Isometry3::identity, |pose| self.mount.start(&pose));
        if self.model.is_empty() {
            self.extend(points, &start)?;
            self.in_hand_frame = in_hand_frame;
            if let Some(pose) = kinematic {
                self.mount.begin(&pose);
                self.cover(points, &start);
            }
            return Ok(ViewEvidence::first_view(start, points.len()));
        }
        let (evidence, certainty) = self.align(points, start)?;
        // Without kinematics a refused view has no place in the cloud.
        if evidence.accepted || in_hand_frame {
            self.extend(points, &evidence.transform)?;
        }
        if in_hand_frame {
            self.cover(points, &evidence.transform);
        }
        if let (true, Some(pose), Some(certainty)) = (evidence.accepted, kinematic, certainty) {
            self.mount.learn(&pose, &evidence.transform, certainty);
        }
        Ok(evidence)
    }

    /// All views in the common frame, one point a voxel, m.
    pub fn cloud(&self) -> Vec<Point3<f32>> {
        self.model.points()
    }

    /// Over what angle about the hand's axis the views together have seen the surface of what it holds, rad; 0 without
    /// kinematics.
    pub fn coverage_rad(&self) -> f64 {
        self.coverage.angle_rad()
    }

    /// Whether the common frame is the hand's; otherwise it is the first view's camera.
    pub fn in_hand_frame(&self) -> bool {
        self.in_hand_frame
    }

    /// The pose to start from; `None` for that of the first view.
    fn start_pose(
        &self,
        hand_from_camera: Option<Isometry3<f64>>,
    ) -> Result<Option<Isometry3<f64>>, RegistrationError> {
        let pose = match self.parameters.initial_guess {
            InitialGuess::Kinematic => hand_from_camera,
            InitialGuess::Identity => None,
        };
        let numbers = pose.iter().flat_map(|pose| {
            pose.translation
                .vector
                .iter()
                .chain(pose.rotation.coords.iter())
        });
        if !numbers.into_iter().all(|number| number.is_finite()) {
            return Err(RegistrationError::BadPose);
        }
        if !self.model.is_empty() && pose.is_some() != self.in_hand_frame {
            return Err(RegistrationError::MixedPoses {
                has_pose: pose.is_some(),
            });
        }
        Ok(pose)
    }

    fn extend(
        &mut self,
        points: &[Point3<f32>],
        transform: &Isometry3<f64>,
    ) -> Result<(), RegistrationError> {
        self.model
            .extend(&transformed(transform, points))
            .map_err(RegistrationError::TooLarge)
    }

    fn align(
        &self,
        points: &[Point3<f32>],
        start: Isometry3<f64>,
    ) -> Result<(ViewEvidence, Option<Certainty>), RegistrationError> {
        let sample = self.sample(points, &start)?;
        let Some(model) = self.model.searchable() else {
            return Ok((ViewEvidence::unmatched(start), None));
        };
        let alignment = if self.in_hand_frame {
            let normals = self
                .model
                .normals(&model.points)
                .map_err(RegistrationError::TooLarge)?;
            correction::correct(&sample, &model, &normals, &self.parameters)
        } else {
            point_to_point::align(&sample, &model, &self.parameters)
        };
        Ok(match alignment {
            None => (ViewEvidence::unmatched(start), None),
            Some(alignment) => {
                let evidence = self.judge(&sample, start, &alignment);
                (evidence, alignment.certainty)
            }
        })
    }

    /// The view's points that are matched, where the start pose puts them.
    fn sample(
        &self,
        points: &[Point3<f32>],
        start: &Isometry3<f64>,
    ) -> Result<Vec<Point3<f32>>, RegistrationError> {
        let mut placed = transformed(start, points);
        if self.in_hand_frame {
            placed.retain(|point| self.turns_with_hand(point));
        }
        let thinned = voxel::downsample(&placed, self.parameters.voxel_m as f32)
            .map_err(RegistrationError::TooLarge)?;
        let step = thinned.len().div_ceil(self.parameters.sample_count).max(1);
        Ok(thinned.into_iter().step_by(step).collect())
    }

    /// Whether a point of the hand frame belongs to gripper or object.
    fn turns_with_hand(&self, point: &Point3<f32>) -> bool {
        let radius_m = self.parameters.rigid_radius_m as f32;
        point.z > self.parameters.rigid_above_m as f32
            && point.xy().coords.norm_squared() < radius_m * radius_m
    }

    fn cover(&mut self, points: &[Point3<f32>], hand_from_camera: &Isometry3<f64>) {
        let camera = Point3::from(hand_from_camera.translation.vector).cast();
        let mut placed = transformed(hand_from_camera, points);
        placed.retain(|point| self.turns_with_hand(point));
        self.coverage.add(&placed, &camera);
    }

    /// Accepts the alignment or says why not.
    fn judge(
        &self,
        sample: &[Point3<f32>],
        start: Isometry3<f64>,
        alignment: &Alignment,
    ) -> ViewEvidence {
        let middle: Point3<f64> = cloud::centroid(sample)
            .unwrap_or_else(Point3::origin)
            .cast();
        let correction_m = (alignment.motion * middle - middle).norm();
        let correction_rad = alignment.motion.rotation.angle();
        let reason = self.refusal(alignment, correction_m, correction_rad);
        let accepted = reason.is_none();
        let stop_reason = match (accepted, alignment.converged) {
            (false, _) => StopReason::Refused,
            (true, true) => StopReason::Converged,
            (true, false) => StopReason::IterationLimit,
        };
        ViewEvidence {
            transform: if accepted {
                alignment.motion * start
            } else {
                start
            },
            accepted,
            reason: reason.unwrap_or_default(),
            stop_reason,
            fitness: alignment.fit.fitness,
            rmse_m: alignment.fit.rmse_m,
            inliers: alignment.fit.inliers,
            iterations: alignment.iterations,
            correction_m,
            correction_rad,
            degenerate_directions: alignment.degenerate_directions,
        }
    }

    fn refusal(
        &self,
        alignment: &Alignment,
        correction_m: f64,
        correction_rad: f64,
    ) -> Option<String> {
        let limits = &self.parameters;
        let (fitness, min_fitness) = (alignment.fit.fitness, limits.min_fitness);
        if fitness < min_fitness {
            return Some(format!(
                "only a share of {fitness:.2} of its points fits, below min_fitness {min_fitness}"
            ));
        }
        if !self.in_hand_frame {
            return None;
        }
        if correction_m > limits.max_correction_m {
            let (moved_mm, limit_mm) = (1e3 * correction_m, 1e3 * limits.max_correction_m);
            return Some(format!(
                "it would be moved by {moved_mm:.1} mm, max_correction_m allows {limit_mm:.1} mm"
            ));
        }
        if correction_rad > limits.max_correction_rad {
            let (turned, limit) = (
                correction_rad.to_degrees(),
                limits.max_correction_rad.to_degrees(),
            );
            return Some(format!(
                "it would be turned by {turned:.1}°, max_correction_rad allows {limit:.1}°"
            ));
        }
        None
    }
}

/// Registers all views of a scene at once.
///
/// Returns the common cloud (m) and the evidence of each view; or the index of the view that cannot be registered, and
/// why.
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
