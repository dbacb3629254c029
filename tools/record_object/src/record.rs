//! From the object in the hand to a file with its mesh.

use crate::agreement;
use crate::file::Target;
use crate::grasp::Grasp;
use crate::mesh::Recorded;
use crate::prompt::until_enter;
use anyhow::{Context, Result, anyhow};
use icp_registration::Regrasp;
use msg::deformable_cobot::ScanObjectGoal;
use node::Node;
use scan::bar::Viewer;
use scan::client::Client;
use scan::recording::Recording;
use serde_json::{Value, json};
use std::path::PathBuf;

/// One grasp is enough from this share of the surface on. How it was chosen: docs/teaching.md.
pub const SEEN_MIN: f64 = 0.75;

const NO_MESH: &str = "no mesh can be made of what was seen";

/// How often the object is grasped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grasps {
    /// Once.
    One,
    /// A second time, upside down.
    Two,
    /// A second time only where the first one shows less than [`SEEN_MIN`] of the surface.
    AsNeeded,
}

/// How the wrist turns during a grasp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// It rests at so many views.
    Views(u32),
    /// Without a rest, through so many radians.
    Sweep(f64),
}

/// What is to be recorded.
#[derive(Debug)]
pub struct Order {
    /// Where the mesh goes.
    pub target: Target,
    /// How often the object is grasped.
    pub grasps: Grasps,
    /// How the wrist turns.
    pub motion: Motion,
}

/// Where the user sees how it goes.
pub trait Screen: Viewer {
    /// A scan begins.
    fn begin(&self);
    /// A scan has ended.
    fn end(&self);
    /// Says a line that stays.
    fn note(&self, line: &str);
}

/// What was recorded.
#[derive(Debug)]
pub struct Made {
    /// The mesh's file.
    pub file: PathBuf,
    /// One or two.
    pub grasps: Vec<Grasp>,
    /// How the second one fits to the first.
    pub regrasp: Option<Regrasp>,
    /// The mesh.
    pub mesh: Recorded,
}

impl Made {
    /// For programs.
    pub fn to_json(&self) -> Value {
        json!({
            "file": self.file,
            "grasps": self.grasps.iter().map(Grasp::to_json).collect::<Vec<_>>(),
            "regrasp": self.regrasp.as_ref().map(agreement::to_json),
            "mesh": self.mesh.to_json(),
        })
    }
}

/// Records the object in the hand.
///
/// # Errors
/// What was seen is no whole object, or not one alone; the two grasps do not fit together; the file cannot be written; or the
/// program is asked to end, then once the arm rests.
pub async fn record(node: &Node, order: &Order, screen: &impl Screen) -> Result<Made> {
    let recording = Recording::listen(node).await?;
    let mut client = Client::connect(node).await?;
    let first = look(&mut client, &recording, order.motion, screen).await?;
    screen.note(&format!("first grasp: {first}"));
    screen.say("making a mesh of it");
    let of_first = (order.grasps != Grasps::Two)
        .then(|| Recorded::of_one_grasp(&first.points).context(NO_MESH))
        .transpose()?;
    let mut made = match of_first {
        Some(mesh) if order.grasps == Grasps::One || mesh.unseen().seen_share() >= SEEN_MIN => {
            Made::of_one(first, mesh)
        }
        of_first => {
            if let Some(mesh) = of_first {
                screen.note(&format!(
                    "{}; {:.0} % are needed, so a second grasp must show the rest",
                    mesh.unseen(),
                    1e2 * SEEN_MIN
                ));
            }
            let second = second(node, &mut client, &recording, order, screen).await?;
            Made::of_two(first, second, order, screen)?
        }
    };
    made.file = order.target.write(&made.mesh.mesh)?.to_path_buf();
    screen.note(&format!("{}: {}", made.file.display(), made.mesh));
    Ok(made)
}

impl Made {
    fn of_one(first: Grasp, mesh: Recorded) -> Self {
        Self {
            file: PathBuf::new(),
            grasps: vec![first],
            regrasp: None,
            mesh,
        }
    }

    fn of_two(first: Grasp, second: Grasp, order: &Order, screen: &impl Screen) -> Result<Self> {
        let mut points = first.points.clone();
        let found = icp_registration::regrasp(&points, &second.points, &agreement::hidden());
        // Nobody should have to hold it twice again for what did not fit once.
        let found = found.or_else(|misfit| {
            let kept = order.target.keep(&[&points[..], &second.points[..]])?;
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
        screen.note(&agreement::to_text(&found));
        screen.say("making a mesh of both grasps");
        points.extend(cloud::transformed(&found.first_from_second, &second.points));
        Ok(Self {
            file: PathBuf::new(),
            mesh: Recorded::of(&points).context(NO_MESH)?,
            grasps: vec![first, second],
            regrasp: Some(found),
        })
    }
}

/// The second grasp, as often as it takes.
async fn second(
    node: &Node,
    client: &mut Client,
    recording: &Recording,
    order: &Order,
    screen: &impl Screen,
) -> Result<Grasp> {
    loop {
        screen.note(
            "now the other end: open the gripper (rosservice call /grasp \"{command: open}\"), put the object back upside \
             down, close it, and press Enter",
        );
        until_enter(node).await?;
        match look(client, recording, order.motion, screen).await {
            Ok(second) => {
                screen.note(&format!("second grasp: {second}"));
                return Ok(second);
            }
            // What was recorded already is not lost.
            Err(error) => {
                screen.note(&format!("{error:#}\nthe first grasp is kept; once more:"));
            }
        }
    }
}

/// One grasp, seen from all wrist angles.
async fn look(
    client: &mut Client,
    recording: &Recording,
    motion: Motion,
    screen: &impl Screen,
) -> Result<Grasp> {
    let (goal, views_asked) = match motion {
        Motion::Sweep(range) => (ScanObjectGoal { views: 0, range }, None),
        Motion::Views(views) => (ScanObjectGoal { views, range: 0.0 }, Some(views)),
    };
    screen.begin();
    let end = client.scan(goal, screen).await;
    screen.end();
    let answer = end?;
    let scan = recording.of(&answer.scan_id).await?;
    Grasp::of(&scan, answer, views_asked)
}
