use super::*;
use crate::{D435I, deproject};
use nalgebra::{Translation3, UnitQuaternion};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sim_objects::{ObjectClass, Variation};

const SMALL_CAMERA: Intrinsics = Intrinsics {
    width: 96,
    height: 72,
    fx: 70.0,
    fy: 71.0,
    cx: 47.3,
    cy: 36.1,
};

fn scene_of(mesh: Mesh) -> Scene {
    Scene {
        hand: mesh,
        links: Vec::new(),
        wall_x_m: None,
    }
}

fn placement_of(camera_from_hand: Isometry3<f64>) -> Placement {
    Placement {
        camera_from_hand,
        camera_from_links: Vec::new(),
        camera_from_base: None,
    }
}

/// The direction that a pixel looks in, with z = 1.
fn ray(camera: &Intrinsics, u: usize, v: usize) -> Vector3<f64> {
    deproject(camera, [u as f64, v as f64], 1.0).coords
}

#[test]
fn a_sphere_is_where_the_ray_meets_it() {
    let (radius_m, camera) = (0.05_f64, D435I);
    let rings = 512;
    let outline: Vec<[f32; 2]> = (0..=rings)
        .map(|k| (std::f64::consts::PI * k as f64 / rings as f64).sin_cos())
        .map(|(sin, cos)| [(radius_m * sin) as f32, (-radius_m * cos) as f32])
        .map(|[r, z]| [if r < 1e-6 { 0.0 } else { r }, z])
        .collect();
    let centre = Vector3::new(0.03, -0.02, 0.4);
    let scene = scene_of(mesh::revolve(&outline, 1024));
    let mut renderer = Renderer::new(camera.clone());
    let image = renderer.render(&scene, &placement_of(Translation3::from(centre).into()));
    let mut hits = 0;
    for v in 0..camera.height as usize {
        for u in 0..camera.width as usize {
            // |t ray - centre| = radius, with t the depth because the ray's z is 1.
            let ray = ray(&camera, u, v);
            let (a, b) = (ray.norm_squared(), ray.dot(&centre));
            let discriminant = b * b - a * (centre.norm_squared() - radius_m * radius_m);
            let per_m = f64::from(image.row(v)[u]);
            // The polyhedron is inscribed: within a hair of the silhouette the two may disagree.
            if discriminant.abs() < 2e-5 {
                continue;
            }
            assert_eq!(discriminant > 0.0, per_m > 0.0, "pixel {u} {v}");
            if discriminant > 0.0 {
                let depth_m = (b - discriminant.sqrt()) / a;
                assert!(
                    (1.0 / per_m - depth_m).abs() < 5e-5,
                    "pixel {u} {v}: {} {depth_m}",
                    1.0 / per_m
                );
                hits += 1;
            }
        }
    }
    assert!(hits > 7000, "{hits}");
}

#[test]
fn the_wall_is_a_plane() {
    let camera = D435I;
    let base_from_camera = crate::scan_base_from_camera();
    let placement =
        Placement::in_base(&base_from_camera, &Translation3::new(0.0, 0.0, -9.0).into());
    let scene = Scene {
        wall_x_m: Some(1.7),
        ..scene_of(Mesh::default())
    };
    let mut renderer = Renderer::new(camera.clone());
    let image = renderer.render(&scene, &placement);
    for v in (0..camera.height as usize).step_by(7) {
        for u in (0..camera.width as usize).step_by(5) {
            let along = base_from_camera.rotation * ray(&camera, u, v);
            let depth_m = (1.7 - base_from_camera.translation.x) / along.x;
            assert!(
                (1.0 / f64::from(image.row(v)[u]) - depth_m).abs() < 1e-5,
                "pixel {u} {v}"
            );
        }
    }
}

fn is_empty(image: &InverseDepth) -> bool {
    image.per_m.iter().all(|&per_m| per_m == 0.0)
}

#[test]
fn a_wall_behind_the_camera_is_not_seen() {
    let placement = Placement::in_base(&crate::scan_base_from_camera(), &Isometry3::identity());
    let scene = Scene {
        wall_x_m: Some(-3.0),
        ..scene_of(Mesh::default())
    };
    let mut renderer = Renderer::new(D435I);
    assert!(is_empty(renderer.render(&scene, &placement)));
}

#[test]
fn a_second_view_shows_nothing_of_the_first() {
    let scene = Scene::holding(&ObjectClass::MediumCan.mesh(&Variation::NONE));
    let near = Placement::in_base(
        &crate::scan_base_from_camera(),
        &crate::scan_base_from_hand(0.0),
    );
    let gone = placement_of(Translation3::new(0.0, 0.0, -2.0).into());
    let mut renderer = Renderer::new(D435I);
    let first = renderer.render(&scene, &near).clone();
    assert!(is_empty(renderer.render(&scene, &gone)));
    assert_eq!(*renderer.render(&scene, &near), first);
}

/// Nearest inverse depth along a pixel's ray, of all triangles one by one (Möller and Trumbore, 1997).
fn cast(mesh: &Mesh, camera_from_mesh: &Isometry3<f64>, ray: &Vector3<f64>) -> f64 {
    let corner =
        |index: u32| (camera_from_mesh * mesh.vertices[index as usize].cast::<f64>()).coords;
    let mut nearest = 0.0_f64;
    for &[a, b, c] in &mesh.triangles {
        let (origin, edge_1, edge_2) = (corner(a), corner(b) - corner(a), corner(c) - corner(a));
        let p = ray.cross(&edge_2);
        let determinant = edge_1.dot(&p);
        let from_corner = -origin;
        let s = from_corner.dot(&p) / determinant;
        let q = from_corner.cross(&edge_1);
        let t = ray.dot(&q) / determinant;
        let depth_m = edge_2.dot(&q) / determinant;
        if s >= 0.0 && t >= 0.0 && s + t <= 1.0 && depth_m >= f64::from(NEAR_M) {
            nearest = nearest.max(1.0 / depth_m);
        }
    }
    nearest
}

#[test]
fn every_pixel_is_that_of_a_ray_cast() {
    let seed = 20;
    println!("seed {seed}");
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut mesh = Mesh::cylinder(0.05, 0.0, 0.12, 12);
    mesh.append(&Mesh::cuboid(
        Point3::new(-0.09, -0.01, -0.05),
        Point3::new(0.09, 0.02, 0.03),
    ));
    let scene = scene_of(mesh);
    let mut renderer = Renderer::new(SMALL_CAMERA);
    for view in 0..60 {
        let mut draw = |range: std::ops::Range<f64>| rng.random_range(range);
        let turn =
            UnitQuaternion::from_euler_angles(draw(-3.0..3.0), draw(-1.5..1.5), draw(-3.0..3.0));
        // From far away to so near that parts are cut off by the near plane.
        let place = Translation3::new(draw(-0.08..0.08), draw(-0.08..0.08), draw(0.02..0.5));
        let camera_from_hand = place * turn;
        let image = renderer.render(&scene, &placement_of(camera_from_hand));
        let mut different = 0;
        for v in 0..SMALL_CAMERA.height as usize {
            for u in 0..SMALL_CAMERA.width as usize {
                let expected = cast(&scene.hand, &camera_from_hand, &ray(&SMALL_CAMERA, u, v));
                let rendered = f64::from(image.row(v)[u]);
                different +=
                    usize::from((rendered - expected).abs() > 1e-4 * expected.max(rendered));
            }
        }
        // A ray that grazes an edge may go either way in the last bit.
        assert!(different <= 4, "view {view}: {different} pixels differ");
    }
}

#[test]
fn a_closed_object_has_no_cracks() {
    let can = sim_deform::specimen(ObjectClass::MediumCan, &Variation::NONE, 0.01, 4);
    let scene = scene_of(can.unwrap_or_default());
    let placement = Placement::in_base(
        &crate::scan_base_from_camera(),
        &crate::scan_base_from_hand(0.3),
    );
    let mut renderer = Renderer::new(D435I);
    let image = renderer.render(
        &scene,
        &Placement {
            camera_from_base: None,
            ..placement
        },
    );
    assert!(image.per_m.iter().any(|&per_m| per_m > 0.0));
    for v in 0..image.height {
        // A dented can is still one run of pixels in nearly every row; a crack would split it.
        let row = image.row(v);
        let runs = row
            .windows(2)
            .filter(|pair| pair[0] == 0.0 && pair[1] > 0.0)
            .count();
        assert!(runs <= 1, "row {v} has {runs} runs");
    }
}
