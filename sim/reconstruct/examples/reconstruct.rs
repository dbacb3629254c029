//! Makes a mesh of a scan: `reconstruct SCAN MESH.ply [METRES_PER_UNIT] [--points] [--no-normals] [--count=N]`.
//!
//! Prints one JSON object with the report and the times of the parts. With `--points` a mesh's triangles are left out,
//! so that its vertices are taken as a raw scan; with `--no-normals` its normals are found anew; `--count` says how many
//! points it is thinned to and how many vertices come out.

use std::time::Instant;

use mesh::file;
use sim_reconstruct::{Settings, mesh_from_scan};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (flags, paths): (Vec<String>, Vec<String>) = std::env::args()
        .skip(1)
        .partition(|argument| argument.starts_with("--"));
    let [source, target, rest @ ..] = &paths[..] else {
        return Err(
            "usage: reconstruct SCAN MESH.ply [METRES_PER_UNIT] [--points] [--no-normals]".into(),
        );
    };
    let metres_per_unit = rest
        .first()
        .map_or(Ok(file::MILLIMETRE), |text| text.parse())?;
    let mut scan = file::read(source, metres_per_unit)?;
    if flags.iter().any(|flag| flag == "--points") {
        scan.triangles.clear();
    }
    if flags.iter().any(|flag| flag == "--no-normals") {
        scan.normals = None;
    }
    let mut settings = Settings::default();
    if let Some(count) = flags.iter().find_map(|flag| flag.strip_prefix("--count=")) {
        settings.point_count = count.parse()?;
        settings.vertex_count = settings.point_count;
    }
    let start = Instant::now();
    let (mesh, report) = mesh_from_scan(&scan, &settings)?;
    let total = start.elapsed().as_secs_f64();
    file::write_ply(target, &mesh)?;
    eprintln!("{report}");
    let seconds = report.from_points.as_ref().map(|from| from.seconds);
    println!(
        "{}",
        serde_json::json!({ "report": report, "seconds": seconds, "total_seconds": total })
    );
    Ok(())
}
