//! Reads a dataset folder that `generate_dataset` made, and checks that it is complete.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use mesh::{Mesh, file::MILLIMETRE};
use sim_dataset::digest::hex_digest;
use sim_dataset::folder::{Folder, REFERENCES};
use sim_dataset::manifest::{Row, from_csv};
use sim_dataset::plan::file_name;
use sim_objects::ObjectClass;

/// One mesh of a dataset.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// A PLY file in millimetres.
    pub path: PathBuf,
    /// Index of its object in [`MeshDataset::labels`].
    pub label: u32,
    /// Number of its grasp, unique in the dataset. Meshes of one grasp differ only in the depth of the dent.
    pub grasp: usize,
    /// The vertices that the two fingers pressed.
    pub handles: [u32; 2],
    sha256: String,
}

/// The meshes of one or several dataset folders.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshDataset {
    /// Names of the objects: the paper's eight in their order, then others by name.
    pub labels: Vec<String>,
    /// The meshes, in the order of the folders and of their manifests.
    pub meshes: Vec<MeshFile>,
    /// Digest of all manifests, which hold the digests of all meshes.
    pub digest: String,
    /// SHA-256 of each folder's manifest.
    pub manifests: Vec<String>,
}

impl MeshDataset {
    /// Reads the manifests, and checks that the folders hold the meshes listed there and no others.
    ///
    /// # Errors
    /// A folder is no dataset, is unfinished or damaged, lacks a mesh or has a foreign file.
    pub fn open(folders: &[PathBuf]) -> Result<Self> {
        let (mut texts, mut manifests) = (Vec::new(), Vec::new());
        let mut rows: Vec<(usize, Made)> = Vec::new();
        let mut known = HashMap::new();
        for (index, folder) in folders.iter().enumerate() {
            let text = manifest(folder)?;
            let made = meshes(folder, &text)?;
            refuse_foreign(folder, &made)?;
            refuse_known(folder, &made, &known)?;
            let objects = made.iter().map(|(_, row)| row.object.clone());
            known.extend(objects.map(|object| (object, folder.as_path())));
            rows.extend(made.into_iter().map(|made| (index, made)));
            manifests.push(hex_digest(&text));
            texts.extend(text);
        }
        let labels = sorted_labels(rows.iter().map(|(_, (_, row))| row.object.as_str()));
        let mut grasps = HashMap::new();
        let files = rows.iter().filter_map(|(folder, (path, row))| {
            let key = (folder, &row.object, row.handle_1, row.handle_2);
            let unused = grasps.len();
            Some(MeshFile {
                path: path.clone(),
                label: labels.iter().position(|label| *label == row.object)? as u32,
                grasp: *grasps.entry(key).or_insert(unused),
                handles: [row.handle_1, row.handle_2],
                sha256: row.sha256.clone()?,
            })
        });
        Ok(Self {
            meshes: files.collect(),
            digest: hex_digest(&texts),
            manifests,
            labels,
        })
    }
}

impl MeshFile {
    /// The mesh, in metres.
    ///
    /// # Errors
    /// The file cannot be read, or its digest is not the manifest's.
    pub fn read(&self) -> Result<Mesh> {
        let path = self.path.display();
        let bytes = fs::read(&self.path).with_context(|| format!("cannot read {path}"))?;
        let mesh = mesh::file::read(&self.path, MILLIMETRE)?.mesh();
        ensure!(
            hex_digest(&bytes) == self.sha256,
            "{path} is not the mesh that manifest.csv was written for; make the dataset again"
        );
        ensure!(
            !mesh.triangles.is_empty(),
            "{path} has no triangles; make the dataset again"
        );
        Ok(mesh)
    }
}

/// The text of a finished dataset's manifest.
fn manifest(folder: &Path) -> Result<Vec<u8>> {
    let name = folder.display();
    ensure!(
        folder.is_dir(),
        "there is no dataset folder {name}; make one: generate_dataset --out {name} ..."
    );
    let path = Folder::at(folder).manifest();
    if path.is_file() {
        return fs::read(&path).with_context(|| format!("cannot read {}", path.display()));
    }
    let remedy = match Folder::at(folder).is_unfinished() {
        true => "it is unfinished: give generate_dataset the same command again",
        false => "it is no dataset: make one with generate_dataset",
    };
    bail!("{name} has no manifest.csv; {remedy}")
}

/// A row with its mesh's path.
type Made = (PathBuf, Row);

/// The rows that have a mesh, after a check that each mesh file exists.
fn meshes(folder: &Path, text: &[u8]) -> Result<Vec<Made>> {
    let manifest = Folder::at(folder).manifest();
    let rows = from_csv(text)
        .with_context(|| format!("{} is damaged; make the dataset again", manifest.display()))?;
    let mut counts: HashMap<String, usize> = HashMap::new();
    for row in &rows {
        *counts.entry(row.object.clone()).or_default() += 1;
    }
    let path = |row: &Row| {
        let object = Folder::at(folder).object(&row.object);
        object.join(file_name(row.n, counts[&row.object]))
    };
    let made = rows.into_iter().filter(Row::has_mesh);
    let made: Vec<Made> = made.map(|row| (path(&row), row)).collect();
    ensure!(
        !made.is_empty(),
        "{} names no mesh; make the dataset again",
        manifest.display()
    );
    let missing = made.iter().find(|(path, _)| !path.is_file());
    if let Some((path, _)) = missing {
        bail!(
            "{} is missing, which manifest.csv names; make the dataset again",
            path.display()
        );
    }
    Ok(made)
}

/// Refuses mesh files that the manifest does not list: a user may have meant to add them.
fn refuse_foreign(folder: &Path, made: &[Made]) -> Result<()> {
    let known: HashSet<&PathBuf> = made.iter().map(|(path, _)| path).collect();
    let of_objects = |path: &&PathBuf| path.is_dir() && !path.ends_with(REFERENCES);
    for object in list(folder)?.iter().filter(of_objects) {
        let files = list(object)?;
        if let Some(foreign) = files.iter().find(|path| !known.contains(path)) {
            bail!(
                "{} is not in manifest.csv; move it away, or make a dataset of it with generate_dataset",
                foreign.display()
            );
        }
    }
    Ok(())
}

/// Refuses an object whose name another folder has: both would become one label.
fn refuse_known(folder: &Path, made: &[Made], known: &HashMap<String, &Path>) -> Result<()> {
    for (_, row) in made {
        if let Some(other) = known.get(&row.object) {
            bail!(
                "{} and {} both hold {}; give one of the objects another name, or make one dataset if it is the same",
                other.display(),
                folder.display(),
                row.object
            );
        }
    }
    Ok(())
}

fn list(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries =
        fs::read_dir(folder).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    let mut paths: Vec<PathBuf> =
        entries.with_context(|| format!("cannot read {}", folder.display()))?;
    paths.sort();
    Ok(paths)
}

/// The paper's eight in their order, then others by name.
pub fn sorted_labels<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let place = |name: &str| {
        ObjectClass::ALL
            .iter()
            .position(|class| class.name() == name)
    };
    let last = ObjectClass::ALL.len();
    let names = names.map(|name| ((place(name).unwrap_or(last), name), ()));
    let sorted: BTreeMap<(usize, &str), ()> = names.collect();
    sorted
        .into_keys()
        .map(|(_, name)| name.to_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_objects_come_first_and_in_their_order() {
        let names = ["zebra", "tiny-ball", "apple", "medium-can", "zebra"];
        let expected = ["medium-can", "tiny-ball", "apple", "zebra"];
        assert_eq!(sorted_labels(names.into_iter()), expected);
    }
}
