//! How dents differ by the energy that they minimise: as rigid as possible, or Eq. 3 of the paper letter by letter.
//!
//! Names of mesh files (PLY or OBJ, mm, clean and closed) are arguments; without any, the eight parametric objects are dented.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use mesh::Mesh;
use mesh::file::MILLIMETRE;
use sim_deform::{Denter, Energy, Settings};
use sim_objects::{ObjectClass, Variation};

/// Grasps of each object.
const GRASPS: usize = 5;
const DEPTH_M: f64 = 0.008;

fn main() -> Result<()> {
    let files: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    println!(
        "{GRASPS} grasps each, pressed by {:.0} mm; distances between the two shapes' vertices, mm\n\
         | object | vertices | root mean square where either is dented by 1 mm | largest | fingers miss their place by | applied: rigid, laplacian |\n\
         |---|---|---|---|---|---|",
        1e3 * DEPTH_M
    );
    if files.is_empty() {
        for class in ObjectClass::ALL {
            compare(class.name(), class.mesh(&Variation::NONE))?;
        }
    }
    for file in files {
        let name = file.file_stem().and_then(|name| name.to_str());
        compare(name.context("a file without a name")?, read(&file)?)?;
    }
    Ok(())
}

fn read(file: &Path) -> Result<Mesh> {
    Ok(mesh::file::read(file, MILLIMETRE)?.mesh())
}

fn compare(name: &str, mesh: Mesh) -> Result<()> {
    let denter = |energy| {
        let settings = Settings {
            energy,
            ..Settings::default()
        };
        Denter::new(mesh.clone(), &settings)
    };
    let [rigid, laplacian] = [denter(Energy::Rigid)?, denter(Energy::Laplacian)?];
    let grasps = rigid.grasps();
    let order = grasps.order(1).into_iter();
    let grasps = order.filter_map(|handle| grasps.grasp(handle).ok());
    let (mut squares, mut count, mut largest_mm, mut missed_mm) = (0.0, 0, 0.0_f64, 0.0_f64);
    let mut applied_mm = [0.0; 2];
    for grasp in grasps.take(GRASPS) {
        let dent = |denter: &Denter| -> Result<_> {
            let dents = denter.dent(&grasp, &[DEPTH_M])?;
            dents.into_iter().next().context("no dent")
        };
        let dents = [dent(&rigid)?, dent(&laplacian)?];
        let places = dents[0].mesh.vertices.iter().zip(&dents[1].mesh.vertices);
        for ((one, other), rest) in places.zip(&mesh.vertices) {
            let apart_mm = 1e3 * f64::from((one - other).norm());
            largest_mm = largest_mm.max(apart_mm);
            if [one, other]
                .iter()
                .any(|place| (*place - rest).norm() > 1e-3)
            {
                squares += apart_mm * apart_mm;
                count += 1;
            }
        }
        let targets_m: Vec<_> = mesh.vertices.iter().map(|place| place.cast()).collect();
        let targets_m = grasp.targets_m(&targets_m, dents[1].applied_m);
        for (target, &vertex) in targets_m.iter().zip(&grasp.pressed()) {
            let place = dents[1].mesh.vertices[vertex as usize].cast::<f64>();
            missed_mm = missed_mm.max(1e3 * (place - target).norm());
        }
        for (sum, dent) in applied_mm.iter_mut().zip(&dents) {
            *sum += 1e3 * dent.applied_m / GRASPS as f64;
        }
    }
    println!(
        "| {name} | {} | {:.2} | {largest_mm:.2} | {missed_mm:.2} | {:.1}, {:.1} |",
        mesh.vertices.len(),
        (squares / f64::from(count.max(1))).sqrt(),
        applied_mm[0],
        applied_mm[1],
    );
    Ok(())
}
