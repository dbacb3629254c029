//! Joins the shards of a dataset.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Deserialize;
use serde_yaml::Value;
use whole_file::Draft;

use crate::error::{DatasetError, MergeError};
use crate::folder::Folder;
use crate::manifest::Row;
use crate::mesh_file;
use crate::plan::file_name;
use crate::plot;
use crate::record::differences;
use crate::shard::Shard;
use crate::summary::Summary;

/// The part of run.yaml that merging needs.
#[derive(Debug, Deserialize)]
struct Wanted {
    objects: Vec<WantedObject>,
}

#[derive(Debug, Deserialize)]
struct WantedObject {
    name: String,
    meshes: usize,
}

struct Part {
    folder: Folder,
    record: String,
    shard: Shard,
    rows: Vec<Row>,
}

/// Joins all shards of one dataset into the folder that one run would have made. Meshes are linked, or copied to
/// another file system; the parts stay as they are. A merge that was interrupted goes on when started again.
///
/// # Errors
/// The parts are not those of one dataset, one is missing, given twice, or not finished; or `out` is in use.
pub fn merge(out: &Path, parts: &[PathBuf]) -> Result<Summary, DatasetError> {
    let start = Instant::now();
    let parts: Vec<Part> = parts
        .iter()
        .map(|part| read(part))
        .collect::<Result<_, _>>()?;
    let record = one_record(&parts)?;
    check_shards(&parts)?;
    let path = parts[0].folder.record();
    let wanted: Wanted =
        serde_yaml::from_str(record).map_err(|error| DatasetError::damaged(&path, &error))?;

    let out = Folder::at(out);
    check_vacant(&out, record)?;
    let meshes = in_order(&wanted, &parts)?;
    fs::create_dir_all(out.root()).map_err(DatasetError::io("make", out.root()))?;
    out.write_record(record)?;
    out.make_references()?;
    for object in &wanted.objects {
        out.make_object(&object.name)?;
        let reference = parts[0].folder.reference(&object.name);
        // A part that was made before there were any has none.
        if reference.is_file() {
            link(&reference, &out.reference(&object.name))?;
        }
    }
    for (part, row, name) in meshes.iter().filter(|(_, row, _)| row.has_mesh()) {
        let folder = out.object(&row.object);
        fs::create_dir_all(&folder).map_err(DatasetError::io("make", &folder))?;
        let to = folder.join(name);
        link(&part.folder.object(&row.object).join(name), &to)?;
        if !mesh_file::belongs(&to, row) {
            return Err(MergeError::InTheWay { file: to }.into());
        }
    }
    let rows: Vec<Row> = meshes.into_iter().map(|(_, row, _)| row.clone()).collect();
    let plots = plot::draw_all(&out, &rows)?;
    out.write_rows(&rows)?;
    Ok(Summary::new(
        &out,
        &rows,
        Vec::new(),
        plots,
        0,
        start.elapsed(),
    ))
}

fn read(root: &Path) -> Result<Part, DatasetError> {
    let folder = Folder::at(root);
    let record = folder.read_record()?;
    let part = || root.to_path_buf();
    let shard = folder
        .shard()?
        .ok_or_else(|| MergeError::NoPart { part: part() })?;
    let unfinished = || MergeError::Unfinished {
        part: part(),
        shard,
    };
    let rows = folder.rows()?.ok_or_else(unfinished)?;
    Ok(Part {
        folder,
        record,
        shard,
        rows,
    })
}

fn one_record(parts: &[Part]) -> Result<&str, DatasetError> {
    let first = &parts[0];
    for part in parts {
        if part.record != first.record {
            let parse = |part: &Part| -> Result<Value, DatasetError> {
                let path = part.folder.record();
                serde_yaml::from_str(&part.record)
                    .map_err(|error| DatasetError::damaged(&path, &error))
            };
            return Err(MergeError::Differ {
                first: first.folder.root().to_path_buf(),
                second: part.folder.root().to_path_buf(),
                differences: differences(&parse(first)?, &parse(part)?),
            }
            .into());
        }
    }
    Ok(&first.record)
}

fn check_shards(parts: &[Part]) -> Result<(), MergeError> {
    let of = parts[0].shard.of();
    let mut by_number: BTreeMap<usize, &Part> = BTreeMap::new();
    for part in parts {
        let root = || part.folder.root().to_path_buf();
        if part.shard.of() != of {
            return Err(MergeError::Differ {
                first: parts[0].folder.root().to_path_buf(),
                second: root(),
                differences: vec![format!(
                    "shard: {} there, {} here",
                    parts[0].shard, part.shard
                )],
            });
        }
        if let Some(other) = by_number.insert(part.shard.number(), part) {
            return Err(MergeError::Overlap {
                first: other.folder.root().to_path_buf(),
                second: root(),
                shard: part.shard,
            });
        }
    }
    let missing = (1..=of).filter(|number| !by_number.contains_key(number));
    let shards: Vec<String> = missing.map(|number| format!("{number}/{of}")).collect();
    if shards.is_empty() {
        Ok(())
    } else {
        Err(MergeError::Gap { shards })
    }
}

/// Checks that the destination is empty, or holds an interrupted merge of the same parts.
fn check_vacant(out: &Folder, record: &str) -> Result<(), DatasetError> {
    let interrupted = || {
        let same = out.read_record().is_ok_and(|there| there == record);
        same && !out.manifest().exists() && !out.is_unfinished()
    };
    if out.is_vacant()? || interrupted() {
        return Ok(());
    }
    Err(MergeError::Occupied {
        out: out.root().to_path_buf(),
    }
    .into())
}

/// Each mesh of the whole, in the order of one run: which part has it, its row, its file's name.
fn in_order<'a>(
    wanted: &Wanted,
    parts: &'a [Part],
) -> Result<Vec<(&'a Part, &'a Row, String)>, MergeError> {
    let mut by_mesh: BTreeMap<(&str, usize), (&Part, &Row)> = BTreeMap::new();
    for part in parts {
        let rows = part.rows.iter();
        by_mesh.extend(rows.map(|row| ((row.object.as_str(), row.n), (part, row))));
    }
    let mut found = Vec::with_capacity(by_mesh.len());
    for object in &wanted.objects {
        for n in 0..object.meshes {
            let name = file_name(n, object.meshes);
            let mesh = by_mesh.get(&(object.name.as_str(), n));
            let incomplete = |part: &Folder, missing| MergeError::Incomplete {
                part: part.root().to_path_buf(),
                missing,
            };
            let &(part, row) = mesh.ok_or_else(|| {
                let row = format!("a row of {}/{name}", object.name);
                incomplete(&parts[0].folder, row)
            })?;
            if !mesh_file::belongs(&part.folder.object(&object.name).join(&name), row) {
                return Err(incomplete(&part.folder, format!("{}/{name}", object.name)));
            }
            found.push((part, row, name));
        }
    }
    Ok(found)
}

/// Hard-links a file, or copies it where the file system does not allow that.
fn link(from: &Path, to: &Path) -> Result<(), DatasetError> {
    match fs::hard_link(from, to) {
        Ok(()) => Ok(()),
        // From an interrupted merge, or a foreign file; the caller compares digests.
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(()),
        Err(_) => copy(from, to),
    }
}

fn copy(from: &Path, to: &Path) -> Result<(), DatasetError> {
    let mut source = fs::File::open(from).map_err(DatasetError::io("read", from))?;
    let mut write = || -> io::Result<()> {
        let mut draft = Draft::of(to)?;
        io::copy(&mut source, draft.file())?;
        draft.finish()
    };
    write().map_err(DatasetError::io("write", to))
}
