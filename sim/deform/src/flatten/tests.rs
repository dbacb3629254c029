use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use sim_objects::{ObjectClass, Variation};

use super::*;
use crate::intersect::SelfIntersections;

#[test]
fn a_can_gets_a_facet_and_keeps_its_girth() {
    let flattening = Flattening {
        towards_rad: 0.0,
        depth_m: 0.011,
        middle_m: 0.06,
        reach_m: 0.05,
    };
    let mut mesh = Mesh::cylinder(0.033, 0.0, 0.12, 256);
    mesh = mesh.subdivided();
    // A ring of the wall at the facet's middle.
    let ring: Vec<usize> = (0..mesh.vertices.len())
        .filter(|&i| (mesh.vertices[i].z - 0.06).abs() < 1e-6)
        .collect();
    flattening.apply(&mut mesh);
    let points = ring.iter().map(|&i| mesh.vertices[i]);
    let (mut around, mut widest_m, mut farthest_m) = (Vec::new(), 0.0f32, 0.0f32);
    for point in points {
        around.push(point);
        widest_m = widest_m.max(2.0 * point.y.abs());
        farthest_m = farthest_m.max(point.x);
    }
    around.sort_by(|a, b| a.y.atan2(a.x).total_cmp(&b.y.atan2(b.x)));
    let next = around.iter().skip(1).chain(around.first());
    let girth_m: f32 = around.iter().zip(next).map(|(a, b)| (a - b).norm()).sum();
    let before_m = std::f32::consts::TAU * 0.033;
    assert!(
        (girth_m / before_m - 1.0).abs() < 0.005,
        "{girth_m} m of {before_m} m"
    );
    assert!((0.022..0.0235).contains(&farthest_m), "{farthest_m} m");
    assert!((0.068..0.072).contains(&widest_m), "{widest_m} m");
    assert!(mesh.vertices.iter().any(|v| v.x > 0.0329), "the ends stay");
}

#[test]
fn cans_do_not_pass_through_themselves_and_their_ends_stay() {
    for seed in 0..20 {
        println!("seed {seed}");
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        for class in [ObjectClass::MediumCan, ObjectClass::FoodCan] {
            let whole = class.mesh(&Variation::NONE);
            let height_m = whole.bounds().1.z;
            let mut mesh = whole.clone();
            let depth_m = random.random_range(0.004..0.014);
            Flattening::random(depth_m, height_m, &mut random).apply(&mut mesh);
            assert_ne!(mesh, whole);
            let pairs = mesh.vertices.iter().zip(&whole.vertices);
            let mut ends = pairs.filter(|(_, v)| v.z < 0.001 || v.z > height_m - 0.001);
            assert!(ends.all(|(now, before)| now == before), "{class}");
            let vertices_m: Vec<_> = mesh.vertices.iter().map(|v| v.cast()).collect();
            let added = SelfIntersections::of(&whole).new_pairs(&vertices_m);
            assert_eq!(added, Vec::<[u32; 2]>::new(), "{class}");
        }
    }
}
