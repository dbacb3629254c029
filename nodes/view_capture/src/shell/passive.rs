//! Scans found in what somebody else makes the robot do.

use super::output::{Output, Place, Pose, Shot, new_scan_id};
use baxter::JointSample;
use msg::sensor_msgs::{JointState, PointCloud2};
use msg::{robot, stamp};
use node::{Expect, Node, Transforms, Tuned};
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::mpsc;
use view_capture::{Parameters, Sweep, Taken};

type Views = Vec<Taken<Arc<Shot>>>;

/// Joint states kept while a cloud is looked at: in passive mode each counts, not only the newest.
const JOINT_STATES: Expect = Expect {
    queue: 100,
    ..Expect::STATE
};

/// Watches until shutdown.
pub async fn watch(
    node: &Node,
    parameters: Tuned<Parameters>,
    transforms: Option<Transforms>,
    output: Output,
) -> anyhow::Result<()> {
    let sweep = Arc::new(Mutex::new(Sweep::new(parameters.now().sweep_rules())));
    let (found, mut scans) = mpsc::unbounded_channel();
    let _points = node.subscribe("points", Expect::STATE, {
        let (sweep, clock, found) = (Arc::clone(&sweep), node.clock(), found.clone());
        move |cloud: PointCloud2| {
            let stamp = stamp::since_epoch(cloud.header.stamp);
            let arrived = clock.now();
            let views = lock(&sweep).on_cloud(stamp, Arc::new(Shot { cloud, arrived }));
            hand_on(&found, views);
        }
    })?;
    let _joints = node.subscribe("/robot/joint_states", JOINT_STATES, {
        let (sweep, parameters) = (Arc::clone(&sweep), parameters.clone());
        let joint = parameters.now().side.wrist_joint();
        move |state: JointState| {
            let Some(sample) = sample_of(&state, joint) else {
                return;
            };
            let mut sweep = lock(&sweep);
            sweep.obey(parameters.now().sweep_rules());
            hand_on(&found, sweep.on_joint(sample));
        }
    })?;
    node.clock().on_jump(move || lock(&sweep).reset());
    loop {
        tokio::select! {
            () = node.until_shutdown() => return Ok(()),
            Some(views) = scans.recv() => {
                publish(&parameters.now(), transforms.as_ref(), &output, views).await;
            }
        }
    }
}

fn hand_on(found: &mpsc::UnboundedSender<Views>, views: Option<Views>) {
    if let Some(views) = views {
        // Fails only while the node shuts down.
        let _ = found.send(views);
    }
}

/// What a message says of `joint`, where that is an angle; most messages on the topic are about others.
pub fn sample_of(state: &JointState, joint: &str) -> Option<JointSample> {
    robot::joint_sample(state, joint).filter(|sample| sample.angle_rad.is_finite())
}

async fn publish(
    parameters: &Parameters,
    transforms: Option<&Transforms>,
    output: &Output,
    views: Views,
) {
    let (scan_id, count) = (new_scan_id(), views.len() as u32);
    log::info!("scan {scan_id}: {count} views seen");
    for (index, view) in (0..).zip(views) {
        let place = Place {
            scan_id: scan_id.clone(),
            index,
            count,
        };
        let shot = &view.cloud;
        match Pose::at(parameters, transforms, &shot.cloud).await {
            Ok(pose) => output.view(place, view.angle_rad, pose, shot),
            Err(error) => {
                let error = format!("view_capture: view {} of {count}: {error:#}", index + 1);
                log::error!("scan {scan_id}: {error}");
                return output.failure(place, error);
            }
        }
    }
}

fn lock<T>(sweep: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    sweep.lock().unwrap_or_else(PoisonError::into_inner)
}
