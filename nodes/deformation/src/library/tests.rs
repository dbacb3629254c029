#![allow(clippy::unwrap_used)]
use mesh::Mesh;

use super::*;

fn folder_with(mesh: &Mesh) -> (tempfile::TempDir, Library) {
    let folder = tempfile::tempdir().unwrap();
    file::write_ply(folder.path().join("thing.ply"), mesh).unwrap();
    std::fs::write(folder.path().join("notes.txt"), "not a mesh").unwrap();
    let library = Library::open(folder.path()).unwrap();
    (folder, library)
}

fn refusal(mesh: &Mesh) -> String {
    let (_folder, library) = folder_with(mesh);
    let text = library.get("thing").map(|_| ()).unwrap_err().to_string();
    if let Err(quick) = library.check("thing") {
        assert_eq!(quick.to_string(), text);
    }
    text
}

#[test]
fn a_file_is_the_reference_of_its_name() {
    let (_folder, library) = folder_with(&Mesh::cylinder(0.03, 0.0, 0.1, 64).subdivided());
    assert_eq!(library.labels(), ["thing"]);
    let reference = library.get("thing").unwrap();
    assert!(reference.id().ends_with("thing.ply"));
    assert!((reference.height_m() - 0.1).abs() < 1e-6);
    assert!(Arc::ptr_eq(&reference, &library.get("thing").unwrap()));
}

#[test]
fn labels_without_a_file_are_named_with_the_remedy() {
    let (_folder, library) = folder_with(&Mesh::cylinder(0.03, 0.0, 0.1, 64));
    for label in ["teapot", "", "../thing", "notes"] {
        let text = library.get(label).map(|_| ()).unwrap_err().to_string();
        let remedy = format!(
            "put {label}.ply, in millimetres, into {}",
            library.folder.display()
        );
        assert!(text.contains(&remedy), "{text}");
    }
    let none = Library::open("").unwrap();
    let text = none.get("thing").map(|_| ()).unwrap_err().to_string();
    assert!(
        text.contains("name it with the parameter references"),
        "{text}"
    );
}

#[test]
fn meshes_that_cannot_serve_are_refused_with_the_remedy() {
    let can = Mesh::cylinder(0.03, 0.0, 0.1, 64).subdivided();
    let scaled = |factor: f32| {
        let mut mesh = can.clone();
        mesh.vertices.iter_mut().for_each(|v| v.coords *= factor);
        mesh
    };
    // Metres in a file that is read as millimetres.
    assert!(refusal(&scaled(0.001)).contains("millimetres"));
    assert!(refusal(&scaled(100.0)).contains("millimetres"));
    let mut cloud = can.clone();
    cloud.triangles.clear();
    assert!(refusal(&cloud).contains("no faces"));
    let mut open = can.clone();
    open.triangles.truncate(can.triangles.len() / 2);
    assert!(refusal(&open).contains("close the surface"));
    let mut mixed = can.clone();
    mixed
        .triangles
        .iter_mut()
        .step_by(2)
        .for_each(|t| t.swap(0, 1));
    assert!(refusal(&mixed).contains("outside"));
    let flat = Mesh {
        vertices: vec![Default::default(), nalgebra::Point3::new(0.1, 0.0, 0.0)],
        triangles: vec![[0, 1, 0]],
    };
    assert!(!refusal(&flat).is_empty());
    let (_folder, library) = folder_with(&open);
    assert!(library.check("thing").is_err());
}

#[test]
fn a_file_that_comes_later_or_changes_is_found() {
    let can = |height_m| Mesh::cylinder(0.03, 0.0, height_m, 64).subdivided();
    let (folder, library) = folder_with(&can(0.1));
    library.get("thing").unwrap();
    assert!(library.get("other").is_err());
    file::write_ply(folder.path().join("other.ply"), &can(0.12)).unwrap();
    assert!((library.get("other").unwrap().height_m() - 0.12).abs() < 1e-6);
    file::write_ply(folder.path().join("thing.ply"), &can(0.08)).unwrap();
    // As if it were written later than a file system's clock can tell.
    let file = fs::File::open(folder.path().join("thing.ply")).unwrap();
    let later = SystemTime::now() + std::time::Duration::from_secs(2);
    file.set_modified(later).unwrap();
    assert!((library.get("thing").unwrap().height_m() - 0.08).abs() < 1e-6);
    assert_eq!(library.labels(), ["other", "thing"]);
}

#[test]
fn a_mesh_inside_out_is_turned_and_a_small_hole_does_no_harm() {
    let can = Mesh::cylinder(0.03, 0.0, 0.1, 64).subdivided();
    let mut inside_out = can.clone();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    inside_out.triangles.pop();
    let (_folder, library) = folder_with(&inside_out);
    assert!(library.get("thing").is_ok());
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let text = Library::open("/no/such/folder")
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(text.contains("/no/such/folder"), "{text}");
}
