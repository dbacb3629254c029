#![allow(clippy::unwrap_used)]
use super::*;

fn example() -> ModelMetadata {
    ModelMetadata {
        labels: vec!["can".to_owned(), "ball".to_owned()],
        point_count: 100,
        metres_per_unit: 0.1,
        centring: Centring::Box,
        normals: true,
        network_version: "1".to_owned(),
        run_id: "run".to_owned(),
        known_threshold: 0.5,
        known_by: KnownBy::Features,
        trained_on: Some("nothing".to_owned()),
    }
}

fn read(entries: &[(&'static str, String)]) -> Result<ModelMetadata, MetadataError> {
    ModelMetadata::from_lookup(|key| {
        let entry = entries.iter().find(|(name, _)| *name == key);
        entry.map(|(_, value)| value.clone())
    })
}

#[test]
fn entries_read_back_the_same() {
    let without_normals = ModelMetadata {
        normals: false,
        known_by: KnownBy::Network,
        trained_on: None,
        ..example()
    };
    for metadata in [example(), without_normals] {
        assert_eq!(read(&metadata.to_entries()).unwrap(), metadata);
    }
}

#[test]
fn each_missing_key_is_named() {
    let all = example().to_entries();
    for (missing, _) in all
        .iter()
        .filter(|entry| ![NORMALS, KNOWN_BY, TRAINED_ON].contains(&entry.0))
    {
        let rest: Vec<_> = all.iter().filter(|e| e.0 != *missing).cloned().collect();
        assert_eq!(read(&rest), Err(MetadataError::Missing { key: missing }));
    }
}

#[test]
fn each_wrong_value_is_named() {
    let wrong = [
        ("labels", "can"),
        ("labels", "can,can"),
        ("labels", "can,,ball"),
        ("point_count", "0"),
        ("point_count", "many"),
        ("metres_per_unit", "0"),
        ("metres_per_unit", "NaN"),
        ("metres_per_unit", "inf"),
        ("centring", "middle"),
        ("normals", "true"),
        ("up_axis", "z"),
        ("up_axis", "-z"),
        ("network_version", " "),
        ("run_id", ""),
        ("known_threshold", "high"),
        ("known_threshold", "NaN"),
    ];
    for (key, value) in wrong {
        let mut entries = example().to_entries();
        for entry in entries.iter_mut().filter(|entry| entry.0 == key) {
            entry.1 = value.to_owned();
        }
        let message = read(&entries).unwrap_err().to_string();
        assert!(message.contains(key), "{message}");
        assert!(message.contains(&format!("{value:?}")), "{message}");
    }
}
