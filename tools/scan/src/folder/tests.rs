#![allow(clippy::unwrap_used)]
use super::*;
use msg::cloud::from_points;
use msg::deformable_cobot::View;
use msg::std_msgs::Header;
use nalgebra::Point3;

fn scan() -> Recorded {
    let cloud = from_points(Header::default(), &[Point3::new(0.1, 0.2, 0.3)]);
    let view = View {
        cloud: cloud.clone(),
        count: 1,
        ..Default::default()
    };
    let mut scan = Recorded {
        views: [(0, view)].into(),
        ..Default::default()
    };
    scan.registered.cloud = cloud.clone();
    scan.registered.view_count = 1;
    scan.object.cloud = cloud;
    scan
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_folder_is_there_whole_or_not_at_all() {
    let parent = tempfile::tempdir().unwrap();
    let target = parent.path().join("can");
    let saved = Folder::beside(&target)
        .unwrap()
        .save(&scan(), &Classification::default(), None)
        .unwrap();
    assert_eq!(saved, target);
    assert_eq!(
        names(&target),
        [
            "object.pcd",
            "registered.pcd",
            "scan.html",
            "scan.yaml",
            "view_1.pcd"
        ]
    );
    let error = Folder::beside(&target).err().unwrap().to_string();
    assert!(error.contains("exists already"), "{error}");

    let mut broken = scan();
    broken.object.cloud.fields.clear();
    let other = parent.path().join("cup");
    assert!(
        Folder::beside(&other)
            .unwrap()
            .save(&broken, &Classification::default(), None)
            .is_err()
    );
    assert_eq!(names(parent.path()), ["can"]);
}

#[test]
fn deviations_are_a_field_of_the_object() {
    let parent = tempfile::tempdir().unwrap();
    let scan = scan();
    let points = [Point3::new(0.1, 0.2, 0.3)];
    let deformation = Deformation {
        cloud: msg::cloud::with_field(Header::default(), &points, DEVIATION, &[-0.004]),
        summary: "dented: 4 mm at 61 mm height".into(),
        ..Default::default()
    };
    let target = Folder::beside(&parent.path().join("can"))
        .unwrap()
        .save(&scan, &Classification::default(), Some(&deformation))
        .unwrap();
    let object = fs::read(target.join("object.pcd")).unwrap();
    assert!(String::from_utf8_lossy(&object).contains("FIELDS x y z deviation"));
    assert!(object.ends_with(&(-0.004f32).to_le_bytes()));
    let described = fs::read_to_string(target.join("scan.yaml")).unwrap();
    assert!(described.contains("summary: 'dented: 4 mm at 61 mm height'"));
}

#[test]
fn a_folder_without_parent_is_refused() {
    let error = Folder::beside(Path::new("/no/such/place"))
        .err()
        .unwrap()
        .to_string();
    assert!(error.contains("there is no folder /no/such"), "{error}");
}
