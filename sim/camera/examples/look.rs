//! Renders the eight objects, dented and in the gripper, as the robot's camera would see them.
//!
//! `cargo run --release -p sim_camera --example look -- FOLDER [W2_RAD]` writes one 16-bit PGM (millimetres) an
//! object and prints how long a frame takes.

use std::path::PathBuf;
use std::time::Instant;

use sim_camera::{
    D435I, Noise, NoiseParameters, Placement, Renderer, Scene, scan_base_from_camera,
    scan_base_from_hand,
};
use sim_objects::{ObjectClass, Variation};

const FRAMES: u32 = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .ok_or("usage: look FOLDER [W2_RAD]")?,
    );
    std::fs::create_dir_all(&folder)?;
    let camera = D435I;
    let wrist_rad: f64 = std::env::args()
        .nth(2)
        .map_or(Ok(1.25), |text| text.parse())?;
    let mut renderer = Renderer::new(camera.clone());
    for (seed, class) in (1..).zip(ObjectClass::ALL) {
        let object = sim_deform::specimen(class, &Variation::random(seed), 0.010, seed)?;
        let scene = Scene::holding(&object);
        let placement =
            Placement::in_base(&scan_base_from_camera(), &scan_base_from_hand(wrist_rad));
        let mut noise = Noise::new(NoiseParameters::default(), seed)?;
        let start = Instant::now();
        for _ in 0..FRAMES {
            renderer.render(&scene, &placement);
        }
        let render_ms = start.elapsed().as_secs_f64() * 1e3 / f64::from(FRAMES);
        let clean = renderer.render(&scene, &placement);
        let start = Instant::now();
        (0..FRAMES).for_each(|_| drop(noise.apply(clean, &camera)));
        let noise_ms = start.elapsed().as_secs_f64() * 1e3 / f64::from(FRAMES);
        println!(
            "{class:12} {:6} triangles: render {render_ms:.2} ms, noise {noise_ms:.2} ms",
            scene.hand.triangles.len()
        );

        let image = noise.apply(clean, &camera);
        let mut bytes = format!("P5\n{} {}\n65535\n", image.width, image.height).into_bytes();
        bytes.extend(
            image
                .depth_mm
                .iter()
                .flat_map(|depth_mm| depth_mm.to_be_bytes()),
        );
        std::fs::write(folder.join(format!("{class}.pgm")), bytes)?;
    }
    Ok(())
}
