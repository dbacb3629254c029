#![allow(clippy::unwrap_used)]
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::*;

fn random(seed: u64) -> Pcg64Mcg {
    println!("seed {seed}");
    Pcg64Mcg::seed_from_u64(seed)
}

/// Measures at random, and each at one end of its range.
fn some(class: ObjectClass, random: &mut Pcg64Mcg) -> Vec<Instance> {
    (0..90)
        .map(|number| {
            Instance::drawn(class, &mut || {
                let share: f32 = random.random();
                if number < 30 { share } else { share.round() }
            })
        })
        .collect()
}

#[test]
fn no_two_families_meet() {
    for (index, one) in ObjectClass::ALL.into_iter().enumerate() {
        for other in &ObjectClass::ALL[..index] {
            let pairs = one.size_range_m().into_iter().zip(other.size_range_m());
            let gap = pairs
                .map(|([least, most], [less, more])| (less / most).max(least / more) - 1.0)
                .fold(f32::MIN, f32::max);
            // Two tolerances of a single object lie between them.
            assert!(gap > 0.02, "{one} and {other}: {gap}");
        }
    }
}

#[test]
fn the_papers_objects_are_members_of_their_families() {
    for class in ObjectClass::ALL {
        for (length_m, range_m) in class.size_m().into_iter().zip(class.size_range_m()) {
            assert_eq!(beyond(length_m, range_m), 0.0, "{class}: {length_m}");
        }
    }
}

#[test]
fn instances_are_closed_bodies_of_the_size_that_their_family_allows() {
    let mut random = random(11);
    for class in ObjectClass::ALL {
        let mut sizes = Vec::new();
        for instance in some(class, &mut random) {
            let mesh = instance.mesh();
            assert!(
                mesh.is_closed_manifold() && mesh.volume_m3() > 0.0,
                "{class}"
            );
            let (min, max) = mesh.bounds();
            let [width_m, height_m] = instance.size_m();
            assert!((max.x - min.x - width_m).abs() < 1e-6 && (max.z - height_m).abs() < 1e-6);
            assert!(min.z.abs() < 1e-6, "{class} does not stand on its bottom");
            for (length_m, range_m) in instance.size_m().into_iter().zip(class.size_range_m()) {
                assert!(beyond(length_m, range_m) < 1e-5, "{class}: {length_m}");
            }
            assert!(
                !crosses_itself(&instance.outline_m),
                "{class}: {instance:?}"
            );
            sizes.push([width_m, height_m]);
        }
        for (axis, [least_m, most_m]) in class.size_range_m().into_iter().enumerate() {
            let reached = |edge_m: f32| sizes.iter().any(|size| (size[axis] - edge_m).abs() < 1e-5);
            assert!(reached(least_m) && reached(most_m), "{class}");
        }
    }
}

/// Whether the outline intersects itself: two of its segments that are not adjacent cross.
fn crosses_itself(outline_m: &[[f32; 2]]) -> bool {
    let side = |a: [f32; 2], b: [f32; 2], c: [f32; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let parts: Vec<_> = outline_m
        .windows(2)
        .map(|pair| (pair[0], pair[1]))
        .collect();
    let cross =
        |(a, b), (c, d)| side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
    let mut pairs = (0..parts.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.any(|(i, j)| cross(parts[i], parts[j]))
}

#[test]
fn what_is_tested_is_not_what_is_learned() {
    let (mut random, mut tested) = (random(12), 0);
    for class in ObjectClass::ALL {
        for instances in [Instances::Training, Instances::Test] {
            for _ in 0..200 {
                let instance = Instance::random(class, instances, &mut random);
                let [width_m, height_m] = instance.size_m();
                let [[narrow_m, wide_m], [low_m, high_m]] = class.size_range_m();
                let width = (width_m - narrow_m) / (wide_m - narrow_m);
                // Of a ball, the second measure is what its height differs from its width.
                let second = match class {
                    ObjectClass::MediumBall => (1000.0 * (width_m - height_m) - 1.0) / 8.0,
                    ObjectClass::TinyBall | ObjectClass::SmallBall => {
                        (height_m / width_m - 1.0) / (high_m / wide_m - 1.0)
                    }
                    _ => (height_m - low_m) / (high_m - low_m),
                };
                // Rounding may put one that is on a border on its other side.
                let is_inside = |share: f32| (5.0 * share - (5.0 * share).round()).abs() > 0.01;
                if is_inside(width) && is_inside(second) {
                    assert_eq!(Instances::of([width, second]), instances, "{class}");
                    tested += 1;
                }
            }
        }
    }
    assert!(tested > 2500, "{tested}");
}

#[test]
fn a_mesh_of_the_middle_becomes_one_of_an_instance() {
    let mut random = random(13);
    for class in ObjectClass::ALL {
        for instance in some(class, &mut random) {
            let mut mesh = Instance::middle(class).mesh();
            instance.carry(&mut mesh);
            let own = instance.mesh();
            assert_eq!(mesh.triangles, own.triangles, "{class}");
            let apart = mesh.vertices.iter().zip(&own.vertices);
            let most_m = apart.map(|(a, b)| (a - b).norm()).fold(0.0, f32::max);
            assert!(most_m < 1e-6, "{class}: {most_m} m");
        }
    }
}
