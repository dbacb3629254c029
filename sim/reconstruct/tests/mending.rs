//! Each defect, put into a sound mesh, is mended and counted.
#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use mesh::Mesh;
use mesh::file::{self, Scan};
use nalgebra::Point3;
use sim_objects::{ObjectClass, Variation};
use sim_reconstruct::{Defect, Mended, Settings, check, mesh_from_scan};

fn can() -> Mesh {
    ObjectClass::MediumCan.mesh(&Variation::NONE)
}

fn mend(mesh: &Mesh) -> (Mesh, Mended) {
    let (mesh, report) = mesh_from_scan(&Scan::from(mesh.clone()), &Settings::default()).unwrap();
    println!("{report}");
    check(&mesh).unwrap();
    assert!(mesh.volume_m3() > 0.0);
    (mesh, report.mended)
}

#[test]
fn a_sound_mesh_stays_as_it_is() {
    let (mesh, mended) = mend(&can());
    assert_eq!((mesh, mended), (can(), Mended::default()));
}

#[test]
fn corners_given_one_by_one_are_joined() {
    let can = can();
    let corners = can.triangles.iter().flatten();
    let soup = Mesh {
        vertices: corners
            .map(|&corner| can.vertices[corner as usize])
            .collect(),
        triangles: (0..can.triangles.len() as u32)
            .map(|at| [3 * at, 3 * at + 1, 3 * at + 2])
            .collect(),
    };
    assert_eq!(check(&soup), Err(Defect::Parts(can.triangles.len())));
    let (mesh, mended) = mend(&soup);
    assert_eq!(mesh.vertices.len(), can.vertices.len());
    assert!(mesh.is_closed_manifold());
    assert_eq!(
        mended.vertices_joined,
        soup.vertices.len() - can.vertices.len()
    );
}

#[test]
fn degenerate_and_duplicate_triangles_go() {
    let mut mesh = can();
    let [a, b, c] = mesh.triangles[100];
    mesh.triangles.extend([[a, b, a], [b, c, a], [c, b, a]]);
    assert!(matches!(check(&mesh), Err(Defect::Corners { .. })));
    let (mended_mesh, mended) = mend(&mesh);
    assert_eq!(mended_mesh, can());
    assert_eq!((mended.degenerate, mended.duplicate), (1, 2));
}

#[test]
fn triangles_without_area_are_folded_into_their_neighbours() {
    // A needle: an edge's two ends nearly at one place.
    let mut mesh = can();
    let [a, b, _] = mesh.triangles[1000];
    mesh.vertices[b as usize] = mesh.vertices[a as usize] + nalgebra::Vector3::new(1e-9, 0.0, 0.0);
    let (closed, mended) = mend(&mesh);
    assert!(closed.is_closed_manifold() && mended.degenerate + mended.vertices_joined >= 1);

    // A cap: a new vertex on the middle of an edge, of which one side's triangle does not know.
    let mut mesh = can();
    let [a, b, c] = mesh.triangles[1000];
    let middle = nalgebra::center(&mesh.vertices[a as usize], &mesh.vertices[b as usize]);
    let new = mesh.vertices.len() as u32;
    mesh.vertices.push(middle);
    mesh.triangles[1000] = [a, new, c];
    mesh.triangles.extend([[new, b, c], [a, b, new]]);
    assert!(matches!(check(&mesh), Err(Defect::Flat { .. })));
    let (closed, mended) = mend(&mesh);
    assert!(closed.is_closed_manifold());
    assert_eq!(
        (mended.degenerate, closed.vertices.len()),
        (1, can().vertices.len() + 1)
    );
}

#[test]
fn a_fin_on_an_edge_is_cut_off() {
    let mut mesh = can();
    let [a, b, _] = mesh.triangles[500];
    mesh.vertices.push(mesh.vertices[a as usize] * 1.2);
    mesh.triangles.push([a, b, mesh.vertices.len() as u32 - 1]);
    assert!(matches!(check(&mesh), Err(Defect::Edge { .. })));
    let (mended_mesh, mended) = mend(&mesh);
    assert_eq!(mended_mesh.triangles.len(), can().triangles.len());
    assert!(
        mended_mesh.is_closed_manifold() && mended.edges_cut == 1 && mended.components_dropped == 1
    );
}

#[test]
fn two_bodies_that_touch_in_a_vertex_are_parted() {
    let mut mesh = can();
    let top = mesh
        .vertices
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.z.total_cmp(&b.1.z))
        .unwrap()
        .0;
    let tip = mesh.vertices[top];
    let first = mesh.vertices.len() as u32;
    let aside = |x: f32, y: f32| tip + nalgebra::Vector3::new(x, y, 0.01);
    mesh.vertices
        .extend([aside(0.0, 0.01), aside(0.01, -0.01), aside(-0.01, -0.01)]);
    let (tip, [p, q, r]) = (top as u32, [first, first + 1, first + 2]);
    mesh.triangles
        .extend([[tip, q, p], [tip, r, q], [tip, p, r], [p, q, r]]);
    assert_eq!(check(&mesh), Err(Defect::Fans { vertex: tip }));
    let (mended_mesh, mended) = mend(&mesh);
    assert_eq!(mended_mesh.triangles.len(), can().triangles.len());
    assert_eq!((mended.vertices_split, mended.components_dropped), (1, 1));
}

#[test]
fn triangles_and_whole_meshes_that_are_inside_out_are_turned() {
    let mut mesh = can();
    for corners in mesh.triangles.iter_mut().skip(300).take(40) {
        corners.swap(0, 1);
    }
    assert!(matches!(check(&mesh), Err(Defect::Edge { .. })));
    let (mended_mesh, mended) = mend(&mesh);
    assert!(mended_mesh.is_closed_manifold() && mended.turned == 40);

    let mut mesh = can();
    mesh.triangles
        .iter_mut()
        .for_each(|corners| corners.swap(0, 1));
    let (_, mended) = mend(&mesh);
    assert_eq!(mended.turned, mesh.triangles.len());
}

#[test]
fn a_band_with_one_side_is_cut_open() {
    let steps = 40;
    let mut mesh = Mesh::default();
    for step in 0..steps {
        let turn = step as f32 / steps as f32 * std::f32::consts::TAU;
        for side in [-0.01, 0.01] {
            let radius = 0.05 + side * (turn / 2.0).cos();
            let height = side * (turn / 2.0).sin();
            mesh.vertices.push(Point3::new(
                radius * turn.cos(),
                radius * turn.sin(),
                height,
            ));
        }
    }
    for step in 0..steps {
        let [a, b] = [2 * step, 2 * step + 1];
        let [c, d] = if step + 1 < steps {
            [a + 2, b + 2]
        } else {
            [1, 0]
        };
        mesh.triangles.extend([[a, b, c], [c, b, d]]);
    }
    let (mesh, report) = mesh_from_scan(&Scan::from(mesh), &Settings::default()).unwrap();
    println!("{report}");
    check(&mesh).unwrap();
    assert_eq!(
        (
            report.mended.edges_cut,
            report.mended.vertices_split,
            mesh.triangles.len()
        ),
        (1, 2, 80)
    );
}

#[test]
fn smaller_components_and_unused_vertices_go() {
    let mut mesh = can();
    mesh.append(&Mesh::cuboid(
        Point3::new(0.1, 0.1, 0.1),
        Point3::new(0.11, 0.11, 0.11),
    ));
    assert_eq!(check(&mesh), Err(Defect::Parts(2)));
    mesh.vertices.insert(0, Point3::new(1.0, 1.0, 1.0));
    mesh.triangles
        .iter_mut()
        .flatten()
        .for_each(|corner| *corner += 1);
    assert_eq!(check(&mesh), Err(Defect::Unused { vertex: 0 }));
    let (mended_mesh, mended) = mend(&mesh);
    assert_eq!(mended_mesh, can());
    assert_eq!(
        (
            mended.components_dropped,
            mended.component_triangles,
            mended.unused
        ),
        (1, 12, 9)
    );
}

#[test]
#[ignore = "needs real data: DEFORMABLE_COBOT_REAL names the folder, ../shared/real by default"]
fn real_scans_become_clean_as_meshes_and_as_points() {
    let folder = std::env::var_os("DEFORMABLE_COBOT_REAL").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real"),
        PathBuf::from,
    );
    let folder = folder.join("scans");
    for class in ObjectClass::ALL {
        let mut scan = file::read(folder.join(format!("{class}.ply")), file::MILLIMETRE).unwrap();
        let (mesh, report) = mesh_from_scan(&scan, &Settings::default()).unwrap();
        println!("{class}: {report}");
        check(&mesh).unwrap();
        let kept = mesh.vertices.len() as f64 / scan.points_m.len() as f64;
        assert!(kept > 0.99, "{class}: {kept} of the vertices");
        if class == ObjectClass::SmallCup {
            assert_ne!(
                report.mended,
                Mended::default(),
                "its defects were not found"
            );
        }

        scan.triangles.clear();
        scan.normals = None;
        let (from_points, report) = mesh_from_scan(&scan, &Settings::default()).unwrap();
        println!("{class}: {report}");
        check(&from_points).unwrap();
        let share = from_points.vertices.len() as f64 / 10_000.0;
        assert!(
            (share - 1.0).abs() <= 0.1,
            "{class}: {} vertices",
            from_points.vertices.len()
        );
        let (old, new) = (mesh.bounds(), from_points.bounds());
        for miss in [new.0 - old.0, new.1 - old.1] {
            assert!(miss.amax() < 0.002, "{class}: its box moved by {miss} m");
        }
    }
}
