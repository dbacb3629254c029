//! Objects in a hand that turns before a camera.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64Mcg;

/// A point of a surface with its outward normal, in the hand frame.
pub type Spot = (Point3<f64>, Vector3<f64>);

/// Seeded; says so.
pub fn random(seed: u64) -> Pcg64Mcg {
    println!("seed {seed}");
    Pcg64Mcg::seed_from_u64(seed)
}

/// The side of an upright cylinder standing at z = 0.1277 m, without lid: nothing tells how it is turned.
pub fn tube(random: &mut Pcg64Mcg, radius_m: f64, count: usize) -> Vec<Spot> {
    let mut spot = || {
        let angle = random.random_range(0.0..std::f64::consts::TAU);
        let normal = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let place = normal * radius_m + Vector3::z() * (0.1277 + random.random_range(0.0..0.12));
        (Point3::from(place), normal)
    };
    (0..count).map(|_| spot()).collect()
}

/// An upright block with three different sides at z = 0.1277 m: all six motions show.
pub fn block(random: &mut Pcg64Mcg, count: usize) -> Vec<Spot> {
    let half = Vector3::new(0.03, 0.045, 0.06);
    let centre = Vector3::new(0.0, 0.0, 0.1277 + half.z);
    let mut spot = || {
        let axis = random.random_range(0..3);
        let side = if random.random() { 1.0 } else { -1.0 };
        let mut place = Vector3::from_fn(|axis, _| random.random_range(-half[axis]..half[axis]));
        place[axis] = side * half[axis];
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.4);
        (
            Point3::from(turned * place + centre),
            turned * (Vector3::ith(axis, side)),
        )
    };
    (0..count).map(|_| spot()).collect()
}

/// Where a camera 0.4 m in front of the object sees it from slightly above, when the wrist is at this angle.
pub fn hand_from_camera(wrist_rad: f64) -> Isometry3<f64> {
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -wrist_rad);
    let eye = Point3::new(0.39, 0.0, 0.1277 + 0.06 + 0.2);
    let target = Point3::new(0.0, 0.0, 0.1277 + 0.06);
    let camera = Isometry3::face_towards(&eye, &target, &-Vector3::z());
    Isometry3::from_parts(Translation3::identity(), turned) * camera
}

/// What the camera sees: the spots that face it, with noise along the line of sight, in the camera's frame.
pub fn view(
    random: &mut Pcg64Mcg,
    spots: &[Spot],
    hand_from_camera: &Isometry3<f64>,
    noise_m: f64,
) -> Vec<Point3<f32>> {
    let noise = Normal::new(0.0, noise_m).unwrap();
    let eye = Point3::from(hand_from_camera.translation.vector);
    let faces = |(place, normal): &&Spot| normal.dot(&(eye - place).normalize()) > 0.15;
    let seen = spots.iter().filter(faces).map(|(place, _)| {
        let point = hand_from_camera.inverse() * place;
        (point * (1.0 + noise.sample(random) / point.coords.norm())).cast::<f32>()
    });
    seen.collect()
}

/// The motion that turns by these angles about the object's middle, then shifts.
pub fn about_object(shift_m: Vector3<f64>, turn_rad: Vector3<f64>) -> Isometry3<f64> {
    let middle = Translation3::new(0.0, 0.0, 0.1877);
    middle * Isometry3::new(shift_m, turn_rad) * middle.inverse()
}

/// How far apart two poses put the corners of the object, m.
pub fn distance_m(a: &Isometry3<f64>, b: &Isometry3<f64>, b_points: &[Point3<f32>]) -> f64 {
    let far = |point: &Point3<f32>| (a * point.cast::<f64>() - b * point.cast::<f64>()).norm();
    b_points.iter().map(far).fold(0.0, f64::max)
}
