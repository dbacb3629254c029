//! Views in, one cloud and the evidence out.

use cloud::{transformed, voxel};
use nalgebra::{Isometry3, Point3};
use parameter::ParameterError;

use crate::align::Alignment;
use crate::axis_turn::{AxisTurn, FirstView};
use crate::change::{Sameness, same_object};
use crate::check::{check_points, check_pose};
use crate::coverage::Coverage;
use crate::error::RegistrationError;
use crate::evidence::ViewEvidence;
use crate::judge::judge;
use crate::model::Model;
use crate::mount::{Displacement, MountError};
use crate::observability::Certainty;
use crate::parameters::{InitialGuess, Parameters};
use crate::trust::Count;
use crate::visibility::{Sight, Sights};
use crate::{correction, point_to_point};

/// Registers the views of a scan one after the other.
#[derive(Debug, Clone)]
pub struct Registrar {
    parameters: Parameters,
    model: Model,
    mount: MountError,
    sights: Sights,
    coverage: Coverage,
    count: Count,
    in_hand_frame: bool,
    first: Option<FirstView>,
}

/// Where the search put a view: the evidence, and how exactly its place is known where kinematics gave the start.
type Found = (ViewEvidence, Option<Certainty>);

/// Why a view is refused that fits nowhere.
const MISPLACED: &str = "neither object nor gripper is where the views before saw them; is the camera mount off, or did the arm move?";

impl Registrar {
    /// Without views.
    ///
    /// # Errors
    /// A parameter out of its range.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let voxel_m = parameters.voxel_m as f32;
        let model = Model::new(voxel_m).map_err(|_| {
            ParameterError::new("voxel_m", parameters.voxel_m, "a positive length in m")
        })?;
        Ok(Self {
            model,
            mount: MountError::default(),
            sights: Sights::new(parameters.region(), parameters.gripper_length_m),
            coverage: Coverage::default(),
            count: Count::default(),
            in_hand_frame: false,
            first: None,
            parameters,
        })
    }

    /// Adds a view: points in m in the camera's optical frame, and hand_from_camera by kinematics.
    ///
    /// This is the registration of the paper (Sec. VI-C.3: iterated closest points, Besl and McKay 1992), from a start that
    /// kinematics give. With Pₖ the points of view k, Aₖ its hand_from_camera by kinematics, and M the model, that is all
    /// views before:
    ///
    /// 1. start: Tₖ = A₁ · X⁻¹ A₁⁻¹Aₖ X, where X is the mount's error as the views before told it (A X = X B, Shiu and Ahmad
    ///    1989);
    /// 2. search: the small motion ξ, along determined directions only (Zhang, Kaess and Singh 2016), with the least
    ///    Σᵢ (nᵢ·(exp(ξ) Tₖ pᵢ − mᵢ))² over points pᵢ ∈ Pₖ with their nearest mᵢ ∈ M and its normal nᵢ (Chen and Medioni 1992),
    ///    matched anew after each step;
    /// 3. judgement: enough of the points fit, and ξ is within bounds, else the view is refused;
    /// 4. visibility: the view sees what the views before saw, else the object has changed and the scan ends;
    /// 5. fusion: M ← M ∪ exp(ξ) Tₖ Pₖ, thinned to one point a voxel, and X from all (Aₖ, exp(ξ) Tₖ).
    ///
    /// A view that is refused or fails leaves the cloud as it was.
    ///
    /// # Errors
    /// Points without a surface, a pose that is no pose, or an object that is not the one that the views before saw.
    pub fn add_view(
        &mut self,
        points: &[Point3<f32>],
        hand_from_camera: Option<Isometry3<f64>>,
    ) -> Result<ViewEvidence, RegistrationError> {
        check_points(points, self.parameters.min_points)?;
        let kinematic = self.kinematic(hand_from_camera)?;
        if self.model.is_empty() {
            return self.begin(points, kinematic);
        }
        let start = kinematic.map_or_else(Isometry3::identity, |pose| self.mount.start(&pose));
        let (mut evidence, certainty) = self.search(points, start)?;
        let seen = kinematic.map(|_| self.see(points, &start, &mut evidence));
        let sight = seen.transpose()?;
        self.count.add(&evidence);
        if !evidence.accepted {
            evidence.transform = start;
            return Ok(evidence);
        }
        self.fuse(points, &evidence.transform, sight)?;
        if let (Some(pose), Some(certainty)) = (kinematic, certainty) {
            self.mount.learn(&pose, &evidence.transform, certainty);
        }
        Ok(evidence)
    }

    /// The first view makes the frame.
    fn begin(
        &mut self,
        points: &[Point3<f32>],
        kinematic: Option<Isometry3<f64>>,
    ) -> Result<ViewEvidence, RegistrationError> {
        self.in_hand_frame = kinematic.is_some();
        let start = kinematic.unwrap_or_else(Isometry3::identity);
        let sight = kinematic.map(|_| self.sights.sight(points, &start));
        self.fuse(points, &start, sight.transpose()?)?;
        if let Some(pose) = kinematic {
            self.first = FirstView::of(&self.model)?;
            self.mount.begin(&pose);
        }
        let evidence = ViewEvidence::first_view(start, points.len());
        self.count.add(&evidence);
        Ok(evidence)
    }

    fn search(
        &self,
        points: &[Point3<f32>],
        start: Isometry3<f64>,
    ) -> Result<Found, RegistrationError> {
        let unmatched = || (ViewEvidence::unmatched(start), None);
        let sample = self.sample(points, &start)?;
        let Some(model) = self.model.searchable() else {
            return Ok(unmatched());
        };
        let alignment: Option<Alignment> = if self.in_hand_frame {
            let normals = self.model.normals();
            let normals = normals.map_err(RegistrationError::TooLarge)?;
            correction::correct(&sample, model, normals, &self.parameters)
        } else {
            point_to_point::align(&sample, model, &self.parameters)
        };
        let is_kinematic = self.in_hand_frame;
        Ok(alignment.map_or_else(unmatched, |found| {
            let evidence = judge(&sample, start, &found, is_kinematic, &self.parameters);
            (evidence, found.certainty)
        }))
    }

    /// Compares what the view sees with what the views before saw. Gives what it sees from where the search put it.
    fn see(
        &self,
        points: &[Point3<f32>],
        start: &Isometry3<f64>,
        evidence: &mut ViewEvidence,
    ) -> Result<Sight, RegistrationError> {
        let sight = self.sights.sight(points, &evidence.transform)?;
        let found = self.sights.compare(&sight);
        let from_start = || Ok(self.sights.compare(&self.sights.sight(points, start)?));
        evidence.comparison = found;
        match same_object(&found, from_start, evidence.correction_m, &self.parameters)? {
            Sameness::Misplaced if evidence.accepted => evidence.refuse(MISPLACED),
            Sameness::Misplaced | Sameness::Same => {}
        }
        Ok(sight)
    }

    /// The view's points that are matched, where the start pose puts them.
    fn sample(
        &self,
        points: &[Point3<f32>],
        start: &Isometry3<f64>,
    ) -> Result<Vec<Point3<f32>>, RegistrationError> {
        let mut placed = transformed(start, points);
        if self.in_hand_frame {
            let region = self.parameters.region();
            placed.retain(|point| region.holds(point));
        }
        let thinned = voxel::downsample(&placed, self.parameters.voxel_m as f32)
            .map_err(RegistrationError::TooLarge)?;
        let step = thinned.len().div_ceil(self.parameters.sample_count).max(1);
        Ok(thinned.into_iter().step_by(step).collect())
    }

    /// Adds the points to the model, and what they show to what was seen; without a sight the common frame is a camera's.
    fn fuse(
        &mut self,
        points: &[Point3<f32>],
        transform: &Isometry3<f64>,
        sight: Option<Sight>,
    ) -> Result<(), RegistrationError> {
        let mut placed = transformed(transform, points);
        self.model
            .extend(&placed)
            .map_err(RegistrationError::TooLarge)?;
        if let Some(sight) = sight {
            self.sights.push(sight);
            let region = self.parameters.region();
            placed.retain(|point| region.holds(point));
            let camera = Point3::from(transform.translation.vector).cast();
            self.coverage.add(&placed, &camera);
        }
        Ok(())
    }

    /// The pose to start from; `None` for that of the first view.
    fn kinematic(
        &self,
        hand_from_camera: Option<Isometry3<f64>>,
    ) -> Result<Option<Isometry3<f64>>, RegistrationError> {
        let pose = match self.parameters.initial_guess {
            InitialGuess::Kinematic => hand_from_camera,
            InitialGuess::Identity => None,
        };
        pose.as_ref().map_or(Ok(()), check_pose)?;
        if !self.model.is_empty() && pose.is_some() != self.in_hand_frame {
            return Err(RegistrationError::MixedPoses {
                has_pose: pose.is_some(),
            });
        }
        Ok(pose)
    }

    /// By how much a view that was registered would still have to be turned about the hand's axis to lie on the first view.
    ///
    /// # Errors
    /// Points too far away.
    pub fn axis_turn(
        &self,
        points: &[Point3<f32>],
        transform: &Isometry3<f64>,
    ) -> Result<AxisTurn, RegistrationError> {
        let sample = self.sample(points, transform)?;
        let turn = |first: &FirstView| first.turn_of(&sample, &self.parameters);
        self.first.as_ref().map_or(Ok(AxisTurn::default()), turn)
    }

    /// All accepted views in the common frame, one point a voxel, m.
    pub fn cloud(&self) -> Vec<Point3<f32>> {
        self.model.points().to_vec()
    }

    /// Does now what the next view would otherwise wait for. Nothing else changes.
    pub fn prepare(&self) {
        self.model.searchable();
        if self.in_hand_frame {
            // The next view reports it where it fails.
            let _ = self.model.normals();
        }
    }

    /// Over what angle about the hand's axis the accepted views together have seen the surface of what it holds, rad; 0
    /// without kinematics.
    pub fn coverage_rad(&self) -> f64 {
        self.coverage.angle_rad()
    }

    /// Whether the common frame is the hand's; otherwise it is the first view's camera.
    pub fn in_hand_frame(&self) -> bool {
        self.in_hand_frame
    }

    /// How many views are in the cloud, and how many were refused.
    pub fn count(&self) -> &Count {
        &self.count
    }

    /// How far the hand is from where kinematics and the camera mount put it; `None` before a second view told.
    pub fn displacement(&self) -> Option<Displacement> {
        self.mount.displacement()
    }

    /// Why the cloud is not to be trusted; `None` where it is.
    pub fn doubt(&self) -> Option<String> {
        let limits = &self.parameters;
        let displaced = || limits.displaced(&self.displacement()?);
        self.count.doubt(limits).or_else(displaced)
    }
}
