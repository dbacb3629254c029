//! Scans of known shapes come back as those shapes.
#![allow(clippy::unwrap_used)]

mod common;

use common::{ball, distances, rms_and_max, scan_of, without_normals};
use mesh::Mesh;
use mesh::file::{self, Scan};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_objects::{ObjectClass, Variation};
use sim_reconstruct::{NormalSource, Report, Settings, check, mesh_from_scan};

const RADIUS_M: f32 = 0.032;
const NOISE_M: f32 = 0.0001;

fn reconstruct(scan: &Scan) -> (Mesh, Report) {
    let (mesh, report) = mesh_from_scan(scan, &Settings::default()).unwrap();
    println!("{report}");
    check(&mesh).unwrap();
    let share = mesh.vertices.len() as f64 / Settings::default().vertex_count as f64;
    assert!(
        (share - 1.0).abs() <= 0.1,
        "{} vertices",
        mesh.vertices.len()
    );
    assert_is_even(&mesh);
    (mesh, report)
}

/// 4√3 area / Σ edge² is 1 for an equilateral triangle and 0 for a flat one.
fn assert_is_even(mesh: &Mesh) {
    let shapes: Vec<f64> = mesh
        .triangles
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| mesh.vertices[corner as usize].cast::<f64>());
            let edges_sq = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
            2.0 * 3.0_f64.sqrt() * (b - a).cross(&(c - a)).norm() / edges_sq
        })
        .collect();
    let worst = shapes.iter().copied().fold(1.0, f64::min);
    let mean = shapes.iter().sum::<f64>() / shapes.len() as f64;
    assert!(
        worst > 0.2 && mean > 0.95,
        "triangles' shapes: mean {mean}, worst {worst}"
    );
}

fn assert_is_the_ball(mesh: &Mesh) {
    assert!(mesh.is_closed_manifold());
    let miss = |vertex: &nalgebra::Point3<f32>| f64::from(vertex.coords.norm() - RADIUS_M);
    let (rms_m, max_m) = rms_and_max(mesh.vertices.iter().map(miss));
    assert!(
        rms_m < 0.00004 && max_m < 0.0002,
        "RMS {rms_m} m, up to {max_m} m"
    );
    let volume_m3 = 4.0 / 3.0 * std::f64::consts::PI * f64::from(RADIUS_M).powi(3);
    assert!(
        (mesh.volume_m3() / volume_m3 - 1.0).abs() < 0.005,
        "{} m³",
        mesh.volume_m3()
    );
}

#[test]
fn a_noisy_ball_comes_back_with_and_without_normals() {
    let scan = scan_of(&ball(RADIUS_M), 50_000, NOISE_M, 1);
    for scan in [without_normals(&scan), scan] {
        let (mesh, report) = reconstruct(&scan);
        assert_is_the_ball(&mesh);
        let from = report.from_points.unwrap();
        assert_eq!(
            from.normals == NormalSource::Estimated,
            scan.normals.is_none()
        );
        let share = from.points as f64 / 10_000.0;
        assert!(
            (share - 1.0).abs() <= 0.03,
            "thinned to {} points",
            from.points
        );
    }
}

#[test]
fn units_of_the_file_do_not_matter() {
    let scan = scan_of(&ball(RADIUS_M), 20_000, NOISE_M, 2);
    let folder = tempfile::TempDir::new().unwrap();
    for (name, units_per_metre) in [("mm.obj", 1000.0), ("m.obj", 1.0)] {
        let lines = scan.points_m.iter().map(|point| {
            let [x, y, z] =
                [point.x, point.y, point.z].map(|coordinate| coordinate * units_per_metre);
            format!("v {x} {y} {z}\n")
        });
        let path = folder.path().join(name);
        std::fs::write(&path, lines.collect::<String>()).unwrap();
        let scan = file::read(&path, 1.0 / f64::from(units_per_metre)).unwrap();
        assert_is_the_ball(&reconstruct(&scan).0);
    }
}

#[test]
fn a_can_keeps_its_edges() {
    let can = ObjectClass::MediumCan.mesh(&Variation::NONE);
    let scan = scan_of(&can, 50_000, NOISE_M, 3);
    for scan in [without_normals(&scan), scan] {
        let (mesh, report) = reconstruct(&scan);
        assert_eq!(report.boundary_loops, 0);
        let (rms_m, max_m) = distances(&mesh, &can, 5);
        assert!(
            rms_m < 0.00012 && max_m < 0.0015,
            "from the can: RMS {rms_m} m, up to {max_m} m"
        );
        let (rms_m, max_m) = distances(&can, &mesh, 5);
        assert!(
            rms_m < 0.0003 && max_m < 0.002,
            "to the can: RMS {rms_m} m, up to {max_m} m"
        );
        assert!((mesh.volume_m3() / can.volume_m3() - 1.0).abs() < 0.01);
    }
}

/// A cup with a wall of 3 mm, open at the top.
fn cup() -> Mesh {
    let outline_mm = [
        [0.0, 0.0],
        [30.0, 0.0],
        [38.0, 90.0],
        [35.0, 90.0],
        [27.3, 3.0],
        [0.0, 3.0],
    ];
    let mut outline_m = Vec::new();
    for pair in outline_mm.windows(2) {
        let point = |step: usize, axis: usize| {
            pair[0][axis] + (pair[1][axis] - pair[0][axis]) * step as f32 / 20.0
        };
        outline_m.extend((0..20).map(|step| [point(step, 0) / 1000.0, point(step, 1) / 1000.0]));
    }
    outline_m.push([0.0, 0.003]);
    mesh::revolve(&outline_m, 192)
}

#[test]
fn both_walls_of_a_cup_look_away_from_each_other() {
    let cup = cup();
    assert!(cup.is_closed_manifold() && cup.volume_m3() > 0.0);
    let scan = scan_of(&cup, 50_000, NOISE_M, 4);
    for scan in [without_normals(&scan), scan] {
        let (mesh, report) = reconstruct(&scan);
        assert_eq!((report.boundary_loops, report.handles), (0, 0));
        let (rms_m, max_m) = distances(&mesh, &cup, 5);
        assert!(
            rms_m < 0.0003 && max_m < 0.002,
            "RMS {rms_m} m, up to {max_m} m"
        );
        // A flipped wall would lose or double the little volume that there is between the two.
        let share = mesh.volume_m3() / cup.volume_m3();
        assert!((share - 1.0).abs() < 0.05, "{share} of the volume");
    }
}

#[test]
fn an_open_bowl_stays_open_where_there_are_no_points() {
    let mut scan = scan_of(&ball(RADIUS_M), 50_000, NOISE_M, 5);
    let rim_m = 0.012;
    scan.normals = None;
    scan.points_m.retain(|point| point.z < rim_m);
    let (mesh, report) = reconstruct(&scan);
    assert_eq!(report.boundary_loops, 1);
    let top_m = mesh.bounds().1.z;
    let spacing_m = report.from_points.unwrap().spacing_m as f32;
    assert!(
        (top_m - rim_m).abs() < 1.5 * spacing_m,
        "the bowl reaches up to {top_m} m"
    );
    assert!(mesh.volume_m3() > 0.0, "the bowl is inside out");
}

#[test]
fn a_pinhole_is_closed() {
    let mut scan = scan_of(&ball(RADIUS_M), 50_000, NOISE_M, 6);
    let pole = nalgebra::Point3::new(0.0, 0.0, RADIUS_M);
    scan.points_m.retain(|point| (point - pole).norm() > 0.0015);
    scan.normals = None;
    assert_is_the_ball(&reconstruct(&scan).0);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let cup = ObjectClass::MediumCup.mesh(&Variation::NONE);
    let scan = without_normals(&scan_of(&cup, 15_000, NOISE_M, 7));
    let settings = Settings {
        point_count: 5000,
        vertex_count: 3000,
        ..Settings::default()
    };
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| mesh_from_scan(&scan, &settings)).unwrap().0
    });
    assert_eq!(one, three);
}

/// The normals of a scan, each turned over where `turn` says so.
fn turned(scan: &Scan, mut turn: impl FnMut(usize, &Vector3<f32>) -> bool) -> Scan {
    let mut turned = scan.clone();
    for (at, normal) in turned.normals.iter_mut().flatten().enumerate() {
        if turn(at, normal) {
            *normal = -*normal;
        }
    }
    turned
}

#[test]
fn normals_without_a_common_side_are_not_believed() {
    let can = ObjectClass::MediumCan.mesh(&Variation::NONE);
    let scan = scan_of(&can, 30_000, NOISE_M, 3);
    let mut random = Pcg64Mcg::seed_from_u64(4);
    let askew = Scan {
        normals: Some(vec![Vector3::z(); scan.points_m.len()]),
        ..scan.clone()
    };
    // A plane fit leaves all looking the same way, or any.
    for (scan, source) in [
        (scan.clone(), NormalSource::Given),
        (turned(&scan, |_, _| true), NormalSource::GivenInward),
        (
            turned(&scan, |_, normal| normal.x < 0.0),
            NormalSource::EstimatedForSides,
        ),
        (
            turned(&scan, |_, _| random.random_bool(0.5)),
            NormalSource::EstimatedForSides,
        ),
        (askew, NormalSource::EstimatedForAskew),
    ] {
        let (mesh, report) = reconstruct(&scan);
        assert_eq!(
            report.from_points.as_ref().map(|from| from.normals),
            Some(source)
        );
        assert_eq!(
            (report.handles, report.boundary_loops, report.doubt()),
            (0, 0, None),
            "{source}"
        );
        let extent = |mesh: &Mesh| {
            let (min, max) = mesh.bounds();
            max - min
        };
        assert!((extent(&mesh) - extent(&can)).norm() < 0.002, "{source}");
        assert!(
            (mesh.volume_m3() / can.volume_m3() - 1.0).abs() < 0.03,
            "{source}"
        );
    }
}

#[test]
fn a_surface_that_no_object_has_is_refused() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let mut scan = Scan::default();
    for _ in 0..8_000 {
        let mut draw = || random.random_range(-0.03..0.03_f32);
        scan.points_m.push(Point3::new(draw(), draw(), draw()));
    }
    let error = mesh_from_scan(&scan, &Settings::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("handles") && error.contains("no object has"),
        "{error}"
    );
}
