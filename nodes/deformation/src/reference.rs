//! The undeformed shape that a cloud is compared with.

use std::collections::HashSet;

use arap::ArapError;
use mesh::Mesh;
use nalgebra::{Point3, Rotation3, UnitVector3, Vector3};

use crate::layer::{Layer, Sample, samples};
use crate::shell::Shell;
use crate::sites::Sites;

/// An undeformed object, prepared for [`crate::measure`].
///
/// Object frame: origin at the centre of the bottom, +z up, as [`Mesh::stood_up`] leaves it; m.
pub struct Reference {
    pub(crate) id: String,
    /// What can be touched from outside.
    pub(crate) outer: Layer,
    /// The inside of a hollow, as of a cup; only seen through its opening.
    pub(crate) hollow: Option<Layer>,
    pub(crate) sites: Sites,
    pub(crate) height_m: f32,
    /// Mean distance of the outer surface from the axis.
    pub(crate) radius_m: f32,
    /// Turned about z it is the same.
    pub(crate) is_of_revolution: bool,
    /// For analysis by synthesis; or why there is none.
    pub(crate) shell: Result<Shell, ArapError>,
}

/// A mesh that cannot serve as a reference.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ReferenceError {
    /// There are only points.
    #[error("has no faces; make a mesh of the scan first, as generate_dataset does")]
    NoFaces,
    /// Mostly, metres were taken for millimetres or the other way round.
    #[error(
        "is {size_m} m long; expected 0.01 to 1 m: is the file in millimetres, and not in metres or inches?"
    )]
    Size {
        /// Longest side of its box.
        size_m: f32,
    },
    /// Where neighbouring triangles turn opposite ways nobody knows which side is outside.
    #[error(
        "its faces do not agree on which side is outside: {count} edges are run along twice in one direction; \
         orient the faces alike (MeshLab: Re-Orient all faces coherently)"
    )]
    NotOriented {
        /// Such edges.
        count: usize,
    },
    /// Without an inside there is no dent.
    #[error(
        "encloses nothing: {open_edges} of its edges belong to one face only; close the surface, as generate_dataset does"
    )]
    Open {
        /// Edges of one triangle.
        open_edges: usize,
    },
}

const SIZE_M: std::ops::RangeInclusive<f32> = 0.01..=1.0;
/// Area that a sample stands for on an object as large as a can.
const SAMPLE_M2: f64 = 2e-6;
const SAMPLES_MAX: f64 = 60_000.0;

impl Reference {
    /// Prepares a mesh; `id` is what answers call it. Small openings, as scans of a real object have them, do no harm; of
    /// faces that look inward all are turned round.
    ///
    /// # Errors
    /// [`ReferenceError`]: a mesh that no deviation can be measured from.
    pub fn new(id: impl Into<String>, mesh: &Mesh) -> Result<Self, ReferenceError> {
        Self::check(mesh)?;
        let mut mesh = mesh.stood_up();
        if mesh.volume_m3() < 0.0 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let area_m2 = SAMPLE_M2.max(surface_m2(&mesh) / SAMPLES_MAX);
        let all = Layer::new(samples(&mesh, area_m2)).ok_or(ReferenceError::NoFaces)?;
        let (hollow, outer): (Vec<Sample>, Vec<Sample>) = all
            .samples
            .iter()
            .partition(|sample| is_in_hollow(&all, sample));
        let radius_m = mean(outer.iter().map(|s| s.point.x.hypot(s.point.y)));
        let outer = Layer::new(outer).ok_or(ReferenceError::NoFaces)?;
        let hollow = Layer::new(hollow);
        Ok(Self {
            shell: Shell::new(&mesh, &outer, hollow.as_ref()),
            id: id.into(),
            sites: Sites::new(&outer, area_m2 as f32),
            is_of_revolution: is_of_revolution(&all),
            height_m: mesh.bounds().1.z,
            radius_m,
            hollow,
            outer,
        })
    }

    /// Whether a mesh can serve; much quicker than to prepare it.
    ///
    /// # Errors
    /// [`ReferenceError`].
    pub fn check(mesh: &Mesh) -> Result<(), ReferenceError> {
        if mesh.triangles.is_empty() {
            return Err(ReferenceError::NoFaces);
        }
        let (min, max) = mesh.bounds();
        let size_m = (max - min).max();
        if !SIZE_M.contains(&size_m) {
            return Err(ReferenceError::Size { size_m });
        }
        check_sides(mesh)
    }

    /// What answers call it.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Whether it is a solid of revolution about its z axis, so that no cloud can tell how it is turned about it.
    pub fn is_of_revolution(&self) -> bool {
        self.is_of_revolution
    }

    /// Places spread evenly over its outer surface, in its own frame, m.
    pub fn outline(&self) -> impl Iterator<Item = Point3<f64>> {
        self.sites.list.iter().map(|site| site.point.cast())
    }

    /// Height of its top over its bottom, m.
    pub fn height_m(&self) -> f64 {
        f64::from(self.height_m)
    }
}

fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / f32::max(count, 1.0)
}

fn surface_m2(mesh: &Mesh) -> f64 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|index| mesh.vertices[index as usize].cast::<f64>());
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    mesh.triangles.iter().map(area).sum()
}

/// Share of edges that may be faulty: a scanner leaves a hole under the object and a few bad triangles.
const FAULTY_SHARE: f64 = 0.02;

fn check_sides(mesh: &Mesh) -> Result<(), ReferenceError> {
    let mut edges = HashSet::with_capacity(3 * mesh.triangles.len());
    let mut twice = 0;
    for &[a, b, c] in &mesh.triangles {
        for edge in [(a, b), (b, c), (c, a)] {
            twice += usize::from(!edges.insert(edge));
        }
    }
    let allowed = FAULTY_SHARE * edges.len() as f64;
    if twice as f64 > allowed {
        return Err(ReferenceError::NotOriented { count: twice });
    }
    let open_edges = edges
        .iter()
        .filter(|&&(a, b)| !edges.contains(&(b, a)))
        .count();
    if open_edges as f64 > allowed {
        return Err(ReferenceError::Open { open_edges });
    }
    Ok(())
}

/// Whether the surface looks at itself: along the normal there is another part of it.
fn is_in_hollow(all: &Layer, sample: &Sample) -> bool {
    const FROM_M: f32 = 0.006;
    const STEP_M: f32 = 0.003;
    const HIT_M: f32 = 0.003;
    let mut along_m = FROM_M;
    loop {
        let place = sample.point + sample.normal * along_m;
        let Some(near) = all.near(&place) else {
            return false;
        };
        let faces = near.normal.dot(&sample.normal) < -0.2;
        if faces && (near.point - place).norm() < HIT_M {
            return true;
        }
        along_m += STEP_M;
    }
}

/// Whether turning about z leaves the surface where it is, but for what a camera cannot tell.
fn is_of_revolution(all: &Layer) -> bool {
    const SAME_M: f32 = 0.000_5;
    const SAMPLES: usize = 400;
    let step = all.samples.len().div_ceil(SAMPLES);
    [0.4, 1.1, 1.9, 2.6].iter().all(|&angle_rad| {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad);
        let off_m2 = all.samples.iter().step_by(step).map(|sample| {
            let place = turn * sample.point;
            let nearest = all.samples[all.nearest(&place)];
            nearest.normal.dot(&(place - nearest.point)).powi(2)
        });
        mean(off_m2).sqrt() < SAME_M
    })
}

/// The two directions across a normal: about horizontal, and about up.
pub(crate) fn tangents(normal: &Vector3<f32>) -> [UnitVector3<f32>; 2] {
    let beside = Vector3::z().cross(normal);
    let across = UnitVector3::try_new(beside, 0.1)
        .unwrap_or_else(|| UnitVector3::new_normalize(Vector3::y().cross(normal)));
    let up = UnitVector3::new_normalize(normal.cross(&across));
    [across, up]
}
