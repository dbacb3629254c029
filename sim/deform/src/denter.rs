//! Makes one dent: from the asked depth to a deformed mesh without new self-intersections (paper Sec. IV-B 5–8).

use mesh::Mesh;
use nalgebra::Point3;

use crate::Settings;
use crate::deformer::{Deformer, Gripped};
use crate::grasp::{Grasp, GraspError, Grasps, Lining};
use crate::intersect::SelfIntersections;
use crate::loss::{Loss, LossOfSource, LossWeightError};
use arap::{ArapError, Stop};

#[cfg(test)]
mod tests;

/// Resolution of the bisection for the deepest intensity without self-intersections.
const INTENSITY_STEP_M: f64 = 0.000_25;

/// Dents one object. Holds what is computed once for it: grasps, factors and search trees.
pub struct Denter {
    source: Mesh,
    vertices_m: Vec<Point3<f64>>,
    grasps: Grasps,
    deformer: Deformer,
    lining: Lining,
    intersections: SelfIntersections,
    loss: LossOfSource,
}

/// A dented object, with the depths, loss and energy of its deformation.
#[derive(Debug, Clone, PartialEq)]
pub struct Dent {
    /// The deformed mesh; its triangles are the source's.
    pub mesh: Mesh,
    /// How far each finger was to press, in metres.
    pub asked_m: f64,
    /// How far it pressed: less where the fingers would meet or the surface would fold through itself.
    pub applied_m: f64,
    /// Loss of Eq. 5.
    pub loss: Loss,
    /// Energy of Eq. 3, m², before an inner wall is laid behind the outer one. That of [`crate::Energy::Laplacian`] has no one unit:
    /// it is of lengths in mm, over 10⁶.
    pub energy_m2: f64,
    /// Iterations of the deformation that made this mesh.
    pub iterations: usize,
    /// Why the iterations ended.
    pub stop: Stop,
    /// Deformations tried for this dent, this one included; 0 if an earlier dent had already found the deepest.
    pub tries: usize,
}

/// An object or a grasp that cannot be dented.
#[derive(Debug, thiserror::Error)]
pub enum DentError {
    /// The object cannot be grasped.
    #[error(transparent)]
    Grasp(#[from] GraspError),
    /// The object cannot be deformed.
    #[error(transparent)]
    Arap(#[from] ArapError),
    /// The loss has a weight out of range.
    #[error(transparent)]
    Loss(#[from] LossWeightError),
    /// An intensity is not a number or not above zero.
    #[error("intensity {asked_m} m: expected a number above 0")]
    Intensity {
        /// What was asked for.
        asked_m: f64,
    },
    /// The surface would pass through itself however little it were pressed.
    #[error(
        "handles {} and {}: the surface passes through itself when pressed by {tried_m:.5} m",
        handles[0], handles[1]
    )]
    Folds {
        /// The grasp's handles.
        handles: [u32; 2],
        /// The smallest intensity that was tried, in metres.
        tried_m: f64,
    },
}

impl Denter {
    /// Finds the grasps, factors the deformation's system, and builds the trees of a source mesh.
    ///
    /// # Errors
    /// Settings out of range, or a mesh that cannot be grasped or deformed.
    pub fn new(mesh: Mesh, settings: &Settings) -> Result<Self, DentError> {
        settings.loss.validate()?;
        let grasps = Grasps::new(&mesh, &settings.grasp)?;
        Ok(Self {
            deformer: Deformer::new(&mesh, grasps.held(), settings.energy, settings.arap)?,
            lining: Lining::new(&mesh, &grasps, settings.grasp.wall_max_m),
            intersections: SelfIntersections::of(&Mesh {
                vertices: in_millimetres(&mesh.vertices).collect(),
                triangles: mesh.triangles.clone(),
            }),
            loss: LossOfSource::new(&mesh, &settings.loss),
            vertices_m: mesh.vertices.iter().map(|v| v.cast()).collect(),
            grasps,
            source: mesh,
        })
    }

    /// Where the object can be grasped.
    pub fn grasps(&self) -> &Grasps {
        &self.grasps
    }

    /// The undented mesh.
    pub fn source(&self) -> &Mesh {
        &self.source
    }

    /// The search for self-intersections, with those that the source itself has; its vertices are in millimetres.
    pub fn intersections(&self) -> &SelfIntersections {
        &self.intersections
    }

    /// Dents one grasp at each asked intensity, in the order given (each deformation starts from the one before).
    ///
    /// No dent has a self-intersection that the source did not have: where one would appear, the intensity is lowered until
    /// there is none. What was found to be too deep stays so for the intensities that follow.
    ///
    /// # Errors
    /// [`DentError::Intensity`], or [`DentError::Folds`] where no depth is free.
    pub fn dent(&self, grasp: &Grasp, asked_m: &[f64]) -> Result<Vec<Dent>, DentError> {
        let mut press = Press {
            denter: self,
            grasp,
            grip: self.deformer.grip(&grasp.pressed())?,
            free: None,
            folded_m: None,
            tries: 0,
        };
        asked_m.iter().map(|&asked_m| press.dent(asked_m)).collect()
    }
}

/// One grasp being pressed, and how deep it can be.
struct Press<'a> {
    denter: &'a Denter,
    grasp: &'a Grasp,
    grip: Gripped<'a>,
    /// The last deformation without new self-intersections; shallower than `folded_m`.
    free: Option<Pressed>,
    /// The shallowest intensity so far that made the surface pass through itself.
    folded_m: Option<f64>,
    tries: usize,
}

/// A deformation without new self-intersections.
#[derive(Clone)]
struct Pressed {
    intensity_m: f64,
    vertices_m: Vec<Point3<f32>>,
    energy_m2: f64,
    iterations: usize,
    stop: Stop,
}

impl Press<'_> {
    fn dent(&mut self, asked_m: f64) -> Result<Dent, DentError> {
        if !(asked_m.is_finite() && asked_m > 0.0) {
            return Err(DentError::Intensity { asked_m });
        }
        self.tries = 0;
        self.press_to(asked_m.min(self.grasp.intensity_max_m))?;
        let pressed = self.free.clone().ok_or_else(|| DentError::Folds {
            handles: self.grasp.handles,
            tried_m: self.folded_m.unwrap_or(asked_m),
        })?;
        Ok(Dent {
            loss: self.denter.loss.of(&pressed.vertices_m),
            mesh: Mesh {
                vertices: pressed.vertices_m,
                triangles: self.denter.source.triangles.clone(),
            },
            asked_m,
            applied_m: pressed.intensity_m,
            energy_m2: pressed.energy_m2,
            iterations: pressed.iterations,
            stop: pressed.stop,
            tries: self.tries,
        })
    }

    /// Sets `free` to the deformation at this intensity, or to the deepest one below it without new self-intersections.
    fn press_to(&mut self, intensity_m: f64) -> Result<(), DentError> {
        let is_done = self
            .free
            .as_ref()
            .is_some_and(|free| free.intensity_m == intensity_m);
        if !is_done && self.folded_m.is_none_or(|folded_m| intensity_m < folded_m) {
            self.attempt(intensity_m)?;
        }
        while let Some(folded_m) = self.folded_m.filter(|&folded_m| folded_m <= intensity_m) {
            let free_m = self.free.as_ref().map_or(0.0, |free| free.intensity_m);
            if folded_m - free_m <= INTENSITY_STEP_M {
                break;
            }
            self.attempt(0.5 * (free_m + folded_m))?;
        }
        Ok(())
    }

    /// Deforms to an intensity (Eq. 4) and checks whether this adds self-intersections to the source's.
    fn attempt(&mut self, intensity_m: f64) -> Result<(), DentError> {
        self.tries += 1;
        let targets_m = self.grasp.targets_m(&self.denter.vertices_m, intensity_m);
        let mut deformed = self.grip.deform(&targets_m)?;
        self.denter.lining.lay(&mut deformed.vertices_m);
        let vertices_m: Vec<Point3<f32>> = deformed.vertices_m.iter().map(|v| v.cast()).collect();
        let stored_mm: Vec<Point3<f64>> = in_millimetres(&vertices_m).map(|v| v.cast()).collect();
        if self.denter.intersections.new_pairs(&stored_mm).is_empty() {
            self.free = Some(Pressed {
                intensity_m,
                vertices_m,
                energy_m2: deformed.energy_m2,
                iterations: deformed.iterations,
                stop: deformed.stop,
            });
        } else {
            self.folded_m = Some(intensity_m);
            self.free.take_if(|free| free.intensity_m >= intensity_m);
        }
        Ok(())
    }
}

/// The vertices as a dataset's file holds them: whether sliver triangles intersect can depend on this rounding alone.
fn in_millimetres(vertices_m: &[Point3<f32>]) -> impl Iterator<Item = Point3<f32>> {
    vertices_m.iter().map(|vertex| vertex * 1000.0)
}
