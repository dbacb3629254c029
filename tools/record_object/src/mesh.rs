//! From points to the mesh.

use anyhow::Result;
use mesh::Mesh;
use mesh::file::Scan;
use nalgebra::Point3;
use serde_json::{Value, json};
use sim_reconstruct::{Report, Settings, mesh_from_scan};
use std::fmt;

use crate::lower_end::with_lower_end;
use crate::unseen::Unseen;

/// The recorded object.
#[derive(Debug)]
pub struct Recorded {
    /// In the object's frame: bottom centre, +z up, m.
    pub mesh: Mesh,
    report: Report,
    unseen: Unseen,
}

impl Recorded {
    /// Makes the surface that points (m, +z up) are of.
    ///
    /// # Errors
    /// They are not of one object's surface.
    pub fn of(points: &[Point3<f32>]) -> Result<Self> {
        let scan = Scan {
            points_m: points.to_vec(),
            ..Scan::default()
        };
        let (mesh, report) = mesh_from_scan(&scan, &Settings::default())?;
        Ok(Self {
            unseen: Unseen::of(&mesh),
            mesh: mesh.stood_up(),
            report,
        })
    }

    /// The same of the points of one grasp (hand's frame), with the lower end that the hand hides, straight down.
    ///
    /// # Errors
    /// As [`Recorded::of`].
    pub fn of_one_grasp(points: &[Point3<f32>]) -> Result<Self> {
        let seen = Self::of(points)?;
        let whole = Self::of(&with_lower_end(points))?;
        Ok(Self {
            unseen: seen.unseen,
            ..whole
        })
    }

    /// What the points do not show of it.
    pub fn unseen(&self) -> &Unseen {
        &self.unseen
    }

    fn extent_m(&self) -> [f32; 3] {
        let (min, max) = self.mesh.bounds();
        (max - min).into()
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        json!({
            "extent_m": self.extent_m(),
            "vertices": self.report.vertices,
            "seen_share": self.unseen.seen_share(),
            "holes": self.report.boundary_loops,
            "handles": self.report.handles,
        })
    }
}

impl fmt::Display for Recorded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.extent_m().map(|metres| 1e3 * metres);
        let holes = match self.report.boundary_loops {
            0 => "closed".to_owned(),
            1 => "1 hole".to_owned(),
            count => format!("{count} holes"),
        };
        let vertices = self.report.vertices;
        write!(
            f,
            "{x:.0} x {y:.0} x {z:.0} mm, {vertices} vertices, {holes}; {}",
            self.unseen
        )
    }
}
