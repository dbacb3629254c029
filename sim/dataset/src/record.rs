//! run.yaml: everything that determines a dataset. Nothing in it depends on the machine, the time or the shard.

use serde::Serialize;
use serde_yaml::Value;

use crate::object::Object;
use crate::plan::ObjectPlan;
use crate::settings::Settings;

/// The commit that this program was built from, with `-dirty` where files had changed; `unknown` outside git.
pub const COMMIT: &str = env!("DATASET_COMMIT");

/// Everything that determines a dataset.
#[derive(Debug, Serialize)]
pub struct Record {
    /// Version of this program.
    version: &'static str,
    commit: &'static str,
    seed: u64,
    objects: Vec<ObjectRecord>,
    settings: Settings,
}

#[derive(Debug, Serialize)]
struct ObjectRecord {
    name: String,
    source: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    scan_sha256: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    metres_per_unit: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mending: Option<sim_reconstruct::Report>,
    mesh_sha256: String,
    vertices: usize,
    triangles: usize,
    grasps: usize,
    refused_handles: usize,
    meshes: usize,
}

impl Record {
    /// The record of a dataset made of these objects by these plans.
    pub fn new(objects: &[Object], plans: &[ObjectPlan], seed: u64, settings: &Settings) -> Self {
        let record = |(object, plan): (&Object, &ObjectPlan)| ObjectRecord {
            name: object.name.clone(),
            source: object.source.clone(),
            scan_sha256: object.scan_sha256.clone(),
            metres_per_unit: object.metres_per_unit,
            mending: object.mending.clone(),
            mesh_sha256: object.mesh_sha256.clone(),
            vertices: object.counts[0],
            triangles: object.counts[1],
            grasps: plan.units.len(),
            refused_handles: plan.refused_handles,
            meshes: plan.meshes,
        };
        Self {
            version: env!("CARGO_PKG_VERSION"),
            commit: COMMIT,
            seed,
            objects: objects.iter().zip(plans).map(record).collect(),
            settings: settings.clone(),
        }
    }

    /// The text of run.yaml.
    ///
    /// # Errors
    /// A value cannot be formatted; this does not happen with records made by [`Record::new`].
    pub fn to_yaml(&self) -> Result<String, serde_yaml::Error> {
        serde_yaml::to_string(self)
    }
}

/// Lists the differences of two records as "path: value there, value here".
pub fn differences(there: &Value, here: &Value) -> Vec<String> {
    let mut found = Vec::new();
    compare("", Some(there), Some(here), &mut found);
    found
}

fn compare(path: &str, there: Option<&Value>, here: Option<&Value>, found: &mut Vec<String>) {
    if there == here {
        return;
    }
    match (there, here) {
        (Some(Value::Mapping(a)), Some(Value::Mapping(b))) => {
            let new = b.keys().filter(|key| !a.contains_key(key));
            for key in a.keys().chain(new) {
                let name = key.as_str().unwrap_or("?");
                let separator = if path.is_empty() { "" } else { "." };
                let path = format!("{path}{separator}{name}");
                compare(&path, a.get(key), b.get(key), found);
            }
        }
        (Some(Value::Sequence(a)), Some(Value::Sequence(b))) if a.len() == b.len() => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                compare(&format!("{path}[{index}]"), Some(a), Some(b), found);
            }
        }
        _ => found.push(format!(
            "{path}: {} there, {} here",
            short(there),
            short(here)
        )),
    }
}

/// One line for a value; of an object in the list of objects, its name.
fn short(value: Option<&Value>) -> String {
    match value {
        None => "nothing".to_owned(),
        Some(Value::Sequence(items)) => {
            let items: Vec<String> = items.iter().map(|item| short(Some(item))).collect();
            format!("[{}]", items.join(", "))
        }
        Some(Value::Mapping(mapping)) => short(mapping.get("name")),
        Some(scalar) => serde_yaml::to_string(scalar)
            .unwrap_or_default()
            .trim_end()
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn differences_are_named_by_path() {
        let parse = |text| serde_yaml::from_str::<Value>(text).unwrap();
        let there = parse("{seed: 1, objects: [{name: a, meshes: 3}], settings: {x: 1.5}, old: 2}");
        let here =
            parse("{seed: 2, objects: [{name: a, meshes: 4}], settings: {x: 1.5}, new: [1, 2]}");
        assert_eq!(
            differences(&there, &here),
            [
                "seed: 1 there, 2 here",
                "objects[0].meshes: 3 there, 4 here",
                "old: 2 there, nothing here",
                "new: nothing there, [1, 2] here"
            ]
        );
        let more = parse("{seed: 1, objects: [{name: a}, {name: b}], settings: {x: 1.5}, old: 2}");
        assert_eq!(
            differences(&there, &more),
            ["objects: [a] there, [a, b] here"]
        );
        assert!(differences(&there, &there).is_empty());
    }
}
