//! On real camera data, where it is at hand.

use std::env;
use std::path::{Path, PathBuf};
use std::time::Instant;

use nalgebra::Point3;

use crate::{Parameters, register};

#[test]
#[ignore = "needs real data: DEFORMABLE_COBOT_REAL names the folder, ../shared/real by default"]
fn three_views_of_a_real_can_come_together() {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    let real = env::var_os("DEFORMABLE_COBOT_REAL").map_or_else(beside, PathBuf::from);
    let read = |number| {
        cloud::read(real.join(format!("captures/can_a/out_{number}.ply")))
            .unwrap()
            .points
    };
    let views: Vec<Vec<Point3<f32>>> = (1..=3).map(read).collect();
    let run = || {
        register(
            Parameters::default(),
            views.iter().map(|view| (&view[..], None)),
        )
        .unwrap()
    };
    let (registrar, evidence) = run();
    for evidence in &evidence[1..] {
        println!("{evidence:#?}");
        assert!(evidence.accepted && evidence.fitness > 0.9 && evidence.rmse_m < 0.004);
    }
    println!("{} points", registrar.cloud().len());
    for _ in 0..5 {
        let start = Instant::now();
        run();
        println!("three views in {:?}", start.elapsed());
    }
}
