//! Scans of which no mesh can be made are refused by name.
#![allow(clippy::unwrap_used)]

mod common;

use common::{ball, scan_of};
use mesh::file::Scan;
use nalgebra::{Point3, Vector3};
use sim_reconstruct::{ReconstructError, Settings, mesh_from_scan};

fn refusal(scan: &Scan) -> ReconstructError {
    let error = mesh_from_scan(scan, &Settings::default()).unwrap_err();
    println!("{error}");
    error
}

fn cloud(points_m: Vec<Point3<f32>>) -> Scan {
    Scan {
        points_m,
        ..Scan::default()
    }
}

#[test]
fn too_few_points_and_many_at_one_place() {
    let scan = scan_of(&ball(0.03), 99, 0.0, 1);
    assert_eq!(refusal(&scan), ReconstructError::TooFewPoints { count: 99 });
    let copies = cloud(vec![Point3::new(0.1, 0.2, 0.3); 5000]);
    assert_eq!(
        refusal(&copies),
        ReconstructError::TooFewPoints { count: 1 }
    );
    assert_eq!(
        refusal(&Scan::default()),
        ReconstructError::TooFewPoints { count: 0 }
    );
}

#[test]
fn points_in_a_plane_or_on_a_line() {
    let grid = (0..1000).map(|at| Point3::new((at % 40) as f32, (at / 40) as f32, 0.0) * 0.001);
    assert!(matches!(
        refusal(&cloud(grid.collect())),
        ReconstructError::Flat { .. }
    ));
    let line = (0..1000).map(|at| Point3::new(1.0, 2.0, 3.0) * (at as f32 * 1e-4));
    assert!(matches!(
        refusal(&cloud(line.collect())),
        ReconstructError::Flat { .. }
    ));
}

#[test]
fn what_is_not_finite_or_not_there() {
    let mut scan = scan_of(&ball(0.03), 1000, 0.0, 2);
    scan.normals.as_mut().unwrap().pop();
    assert_eq!(
        refusal(&scan),
        ReconstructError::Normals {
            normals: 999,
            points: 1000
        }
    );
    scan.normals = None;
    scan.triangles = vec![[0, 1, 1000]];
    assert!(matches!(
        refusal(&scan),
        ReconstructError::Corners {
            triangle: 0,
            vertices: 1000,
            ..
        }
    ));
    scan.points_m[7].y = f32::NAN;
    assert_eq!(refusal(&scan), ReconstructError::NotFinite { index: 7 });
}

#[test]
fn points_whose_normals_point_nowhere_do_not_count() {
    let mut scan = scan_of(&ball(0.03), 2000, 0.0, 3);
    let normals = scan.normals.as_mut().unwrap();
    normals[..1950].fill(Vector3::zeros());
    assert_eq!(refusal(&scan), ReconstructError::TooFewPoints { count: 50 });
}

#[test]
fn a_mesh_of_nothing_but_flat_triangles() {
    let mut scan = cloud(
        (0..300)
            .map(|at| Point3::new(at as f32, 0.0, 0.0))
            .collect(),
    );
    scan.triangles = (0..298).map(|at| [at, at + 1, at + 2]).collect();
    assert!(matches!(refusal(&scan), ReconstructError::Unmended(_)));
}

#[test]
fn settings_out_of_range() {
    let default = Settings::default();
    let scan = scan_of(&ball(0.03), 1000, 0.0, 4);
    let bad = [
        (
            Settings {
                point_count: 99,
                ..default.clone()
            },
            "point_count is 99",
        ),
        (
            Settings {
                vertex_count: 0,
                ..default.clone()
            },
            "vertex_count is 0",
        ),
        (
            Settings {
                depth: 4,
                ..default.clone()
            },
            "depth is 4",
        ),
        (
            Settings {
                depth: 13,
                ..default.clone()
            },
            "depth is 13",
        ),
        (
            Settings {
                screening: f64::NAN,
                ..default.clone()
            },
            "screening is NaN",
        ),
        (
            Settings {
                reach: 0.5,
                ..default.clone()
            },
            "reach is 0.5",
        ),
    ];
    for (settings, said) in bad {
        let message = mesh_from_scan(&scan, &settings).unwrap_err().to_string();
        assert!(message.contains(said), "{message}");
    }
}
