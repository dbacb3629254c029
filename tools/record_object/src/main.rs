//! Makes a mesh of the object in the hand, for a dataset of it: turns it before the camera as far as the wrist goes, and,
//! put back another way by a person, once more.

mod file;
mod grasp;
mod mesh;
mod prompt;

use anyhow::{Context, Result, anyhow};
use clap::Parser;
use file::Target;
use grasp::Grasp;
use icp_registration::{Hidden, Regrasp};
use mesh::Recorded;
use msg::deformable_cobot::ScanObjectGoal;
use nalgebra::Point3;
use node::Node;
use scan::bar::Bar;
use scan::client::Client;
use scan::program;
use scan::recording::Recording;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::ExitCode;

/// Makes a mesh of the object in the hand, from which generate_dataset makes dented ones to train on.
///
/// The wrist turns it through its whole range. Then put it back upside down and press Enter: the second grasp shows what
/// the fingers hid in the first. The mesh goes to NAME.ply, in millimetres, +z up. Ctrl-C ends it and waits until the arm
/// is still.
#[derive(Debug, Parser)]
#[command(
    name = "record_object",
    after_help = "Exit code: 0 done, 1 failed, 2 wrong usage."
)]
struct Arguments {
    /// Name of the object; later it is the label
    name: String,
    /// How often the object is grasped: 1 or 2
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=2))]
    grasps: u32,
    /// Views of each grasp
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..))]
    views: u32,
    /// Views of each grasp during one sweep through so many radians, without a rest, in place of --views; 6 is the whole range
    #[arg(long, value_name = "RAD", conflicts_with = "views")]
    range: Option<f64>,
    /// The folder that the mesh goes to
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    save: PathBuf,
    /// Replace a mesh of that name
    #[arg(long)]
    force: bool,
    /// Print what was made as one JSON object
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    program::run("record_object", record)
}

async fn record(node: Node, arguments: Arguments) -> Result<()> {
    // What cannot be saved is said before the arm moves.
    let target = Target::new(&arguments.save, &arguments.name, arguments.force)?;
    let recording = Recording::listen(&node).await?;
    let mut client = Client::connect(&node).await?;
    let first = look(&mut client, &recording, &arguments).await?;
    program::note(format_args!("first grasp: {first}"));
    let mut points = first.points.clone();
    let mut grasps = vec![first];
    let mut regrasp = None;
    if arguments.grasps == 2 {
        let second = loop {
            prompt::until_enter(&node).await?;
            match look(&mut client, &recording, &arguments).await {
                Ok(second) => break second,
                // What was recorded already is not lost.
                Err(error) => program::note(format_args!(
                    "{error:#}\nthe first grasp is kept; once more:"
                )),
            }
        };
        program::note(format_args!("second grasp: {second}"));
        let found = icp_registration::regrasp(&points, &second.points, &hidden());
        // Nobody should have to hold it twice again for what did not fit once.
        let found = found.or_else(|misfit| {
            let kept = target.keep(&[&points[..], &second.points[..]])?;
            Err(anyhow!(
                "{misfit}\nboth grasps are kept as {}; a mesh of the first alone: \
                 rosrun deformable_cobot generate_dataset --units m --scan {}",
                kept.iter()
                    .map(|file| file.display().to_string())
                    .collect::<Vec<_>>()
                    .join(" and "),
                kept[0].display()
            ))
        })?;
        program::note(agreement(&found));
        points.extend(cloud::transformed(&found.first_from_second, &second.points));
        grasps.push(second);
        regrasp = Some(found);
    }
    finish(&arguments, &target, &points, &grasps, regrasp)
}

/// One grasp, seen from all wrist angles.
async fn look(client: &mut Client, recording: &Recording, arguments: &Arguments) -> Result<Grasp> {
    let bar = Bar::default();
    let goal = match arguments.range {
        Some(range) => ScanObjectGoal { views: 0, range },
        None => ScanObjectGoal {
            views: arguments.views,
            range: 0.0,
        },
    };
    let views_asked = arguments.range.is_none().then_some(arguments.views);
    let end = client.scan(goal, &bar).await;
    bar.clear();
    let answer = end?;
    let scan = recording.of(&answer.scan_id).await?;
    Grasp::of(&scan, answer, views_asked)
}

fn finish(
    arguments: &Arguments,
    target: &Target,
    points: &[Point3<f32>],
    grasps: &[Grasp],
    regrasp: Option<Regrasp>,
) -> Result<()> {
    let recorded = Recorded::of(points).context("no mesh can be made of what was seen")?;
    let file = target.write(&recorded.mesh)?;
    program::note(format_args!("{}: {recorded}", file.display()));
    let (scan, name) = (file.display(), &arguments.name);
    let next =
        format!("rosrun deformable_cobot generate_dataset --scan {scan} --out {name} --count 300");
    if arguments.json {
        let described = json!({
            "file": file,
            "object": name,
            "grasps": grasps.iter().map(Grasp::to_json).collect::<Vec<_>>(),
            "regrasp": regrasp.as_ref().map(regrasp_json),
            "mesh": recorded.to_json(),
            "next": next,
        });
        program::print(format_args!("{described:#}\n"))?;
    } else {
        program::print(format_args!("next: {next}\n"))?;
    }
    Ok(())
}

/// What the fingers hide, as the crop is made for them.
fn hidden() -> Hidden {
    let crop = roi_crop::Parameters::default();
    Hidden {
        below_m: crop.gripper_length_m - crop.grasp_depth_m,
        fingertips_m: crop.gripper_length_m,
        finger_width_m: crop.finger_width_m,
    }
}

fn agreement(found: &Regrasp) -> String {
    let (percent, rmse_mm) = (1e2 * found.fitness, 1e3 * found.rmse_m);
    let how = if found.upside_down {
        "upside down"
    } else {
        "upright, so that its lower end is still unseen"
    };
    format!("the second is the first {how}: {percent:.0} % of the points agree, to {rmse_mm:.1} mm")
}

fn regrasp_json(found: &Regrasp) -> Value {
    json!({
        "upside_down": found.upside_down,
        "fitness": found.fitness,
        "rmse_m": found.rmse_m,
    })
}
