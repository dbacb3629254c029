//! The objects to be dented: scans or parametric ones.

use std::path::{Path, PathBuf};

use mesh::Mesh;
use sim_deform::Denter;
use sim_objects::{ObjectClass, Variation};

use crate::digest::hex_digest;
use crate::error::DatasetError;
use crate::settings::Settings;

/// The folder of the undented objects, OBJECT.ply; no object may have its name.
pub const REFERENCES: &str = "references";

/// Range of an object's longest extent, m. A mesh outside of it was most likely read with the wrong unit.
const SIZE_RANGE_M: std::ops::RangeInclusive<f32> = 0.01..=1.0;

/// Where an object comes from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A scan in a file: points or a mesh.
    Scan {
        /// The file.
        file: PathBuf,
        /// Length of its unit, m.
        metres_per_unit: f64,
    },
    /// One of the eight parametric objects, as in the table of sizes.
    Parametric(ObjectClass),
}

/// An object, ready to be dented.
pub struct Object {
    /// Name of the object and of its folder.
    pub name: String,
    /// What it was made from: the scan's file name, or `parametric`.
    pub source: String,
    /// SHA-256 of the scan's bytes.
    pub scan_sha256: Option<String>,
    /// Length of the scan's unit, m.
    pub metres_per_unit: Option<f64>,
    /// Report of the reconstruction, for a scan.
    pub mending: Option<sim_reconstruct::Report>,
    /// SHA-256 of the undented mesh.
    pub mesh_sha256: String,
    /// Numbers of vertices and triangles, the same in each of its meshes.
    pub counts: [usize; 2],
    /// Makes its dents.
    pub denter: Denter,
}

impl Source {
    /// The object's name: a scan's is its file's stem.
    ///
    /// # Errors
    /// The stem cannot name a folder.
    pub fn name(&self) -> Result<String, DatasetError> {
        let file = match self {
            Source::Parametric(class) => return Ok(class.name().to_owned()),
            Source::Scan { file, .. } => file,
        };
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let allowed = |c: char| c.is_alphanumeric() || ['-', '_', '.'].contains(&c);
        let taken = name == REFERENCES
            || [".csv", ".yaml", ".png"]
                .iter()
                .any(|end| name.ends_with(end));
        if name.is_empty() || name.starts_with('.') || taken || !name.chars().all(allowed) {
            return Err(DatasetError::BadName { name: name.into() });
        }
        Ok(name.into())
    }

    /// Reads or makes the object's mesh and prepares to dent it.
    ///
    /// # Errors
    /// The scan cannot be read, or no mesh that can be dented can be made of it.
    pub fn load(&self, settings: &Settings) -> Result<Object, DatasetError> {
        let name = self.name()?;
        let mut object = match self {
            Source::Parametric(class) => {
                let mesh = class.mesh(&Variation::NONE);
                Object::new(name, "parametric".to_owned(), mesh, settings)?
            }
            Source::Scan {
                file,
                metres_per_unit,
            } => Self::load_scan(name, file, *metres_per_unit, settings)?,
        };
        if let Source::Scan {
            metres_per_unit, ..
        } = self
        {
            object.metres_per_unit = Some(*metres_per_unit);
        }
        Ok(object)
    }

    fn load_scan(
        name: String,
        file: &Path,
        metres_per_unit: f64,
        settings: &Settings,
    ) -> Result<Object, DatasetError> {
        let scan = mesh::file::read(file, metres_per_unit)?;
        let bytes = std::fs::read(file).map_err(DatasetError::io("read", file))?;
        let (mesh, mending) = sim_reconstruct::mesh_from_scan(&scan, &settings.reconstruct)
            .map_err(|source| DatasetError::Reconstruct {
                object: name.clone(),
                source,
            })?;
        let file_name = file.file_name().unwrap_or_default().to_string_lossy();
        Ok(Object {
            scan_sha256: Some(hex_digest(&bytes)),
            mending: Some(mending),
            ..Object::new(name, file_name.into(), mesh, settings)?
        })
    }
}

impl Object {
    fn new(
        name: String,
        source: String,
        mesh: Mesh,
        settings: &Settings,
    ) -> Result<Self, DatasetError> {
        let (min, max) = mesh.bounds();
        let size_m = (max - min).max();
        if !SIZE_RANGE_M.contains(&size_m) {
            return Err(DatasetError::Size {
                object: name,
                size_m,
            });
        }
        let mesh_sha256 = mesh_digest(&mesh);
        let counts = [mesh.vertices.len(), mesh.triangles.len()];
        let denter = Denter::new(mesh, &settings.dent).map_err(|source| DatasetError::Dent {
            object: name.clone(),
            source,
        })?;
        Ok(Self {
            name,
            source,
            scan_sha256: None,
            metres_per_unit: None,
            mending: None,
            mesh_sha256,
            counts,
            denter,
        })
    }
}

impl Object {
    /// For a scan, a property of its mesh that no graspable object has, in words (see [`sim_reconstruct::Report::doubt`]).
    pub fn doubt(&self) -> Option<String> {
        let found = self.mending.as_ref()?.doubt()?;
        Some(format!(
            "{} has {found}: look at its meshes before they are used",
            self.name
        ))
    }
}

/// Digest of the vertices' and triangles' bytes: shows whether two machines made the same mesh of a scan.
fn mesh_digest(mesh: &Mesh) -> String {
    let coordinates = mesh.vertices.iter().flat_map(|vertex| vertex.iter());
    let mut bytes: Vec<u8> = coordinates.flat_map(|c| c.to_le_bytes()).collect();
    let indices = mesh.triangles.iter().flatten();
    bytes.extend(indices.flat_map(|index| index.to_le_bytes()));
    hex_digest(&bytes)
}
