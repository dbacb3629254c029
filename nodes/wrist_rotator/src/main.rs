//! The wrist rotator as a ROS node: services `rotate_wrist` and `stop_wrist`.

mod rotator;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use baxter::Side;
use msg::baxter_core_msgs::{
    AssemblyState, CollisionAvoidanceState, CollisionDetectionState, DigitalIOState,
};
use msg::deformable_cobot::{RotateWrist, RotateWristReq, RotateWristRes};
use msg::sensor_msgs::JointState;
use msg::stamp;
use msg::std_srvs::{Trigger, TriggerRes};
use node::{Expect, Level, Life, Node, Subscriber};
use rotator::Rotator;
use wrist_rotator::{Guard, Parameters};

const HEALTH_PERIOD: Duration = Duration::from_secs(1);

fn main() -> ExitCode {
    node::run("wrist_rotator", run)
}

async fn run(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let rotator = Arc::new(Rotator::new(&node, &parameters)?);
    let _subscribers = listen(&node, &rotator, parameters.side)?;
    let _rotate = node.serve::<RotateWrist>("rotate_wrist", {
        let rotator = Arc::clone(&rotator);
        move |RotateWristReq { angle }, life| {
            let rotator = Arc::clone(&rotator);
            async move { Ok(rotate(&rotator, angle, &life).await) }
        }
    })?;
    let _stop = node.serve::<Trigger>("stop_wrist", {
        let rotator = Arc::clone(&rotator);
        move |_, _| {
            let rotator = Arc::clone(&rotator);
            async move { Ok(stop(&rotator).await) }
        }
    })?;
    tokio::select! {
        () = report_health(&node, &rotator, &parameters) => {}
        () = node.until_shutdown() => {}
    }
    // The links go down only once nothing moves.
    rotator.shut_down().await;
    Ok(())
}

async fn rotate(rotator: &Rotator, target_rad: f64, life: &Life) -> RotateWristRes {
    match rotator.turn(target_rad, life).await {
        Ok(arrived) => {
            let at_rest = stamp::from_epoch(arrived.at_rest);
            RotateWristRes {
                success: true,
                error: String::new(),
                angle: arrived.angle_rad,
                at_rest,
            }
        }
        Err(error) => {
            log::warn!("rotate_wrist to {target_rad:.3} rad: {error}");
            let angle = rotator.angle_rad().unwrap_or(f64::NAN);
            RotateWristRes {
                success: false,
                error: error.to_string(),
                angle,
                ..Default::default()
            }
        }
    }
}

async fn stop(rotator: &Rotator) -> TriggerRes {
    match rotator.stop().await {
        Ok(arrived) => TriggerRes {
            success: true,
            message: format!("at rest at {:.3} rad", arrived.angle_rad),
        },
        Err(error) => {
            log::warn!("stop_wrist: {error}");
            TriggerRes {
                success: false,
                message: error.to_string(),
            }
        }
    }
}

fn listen(node: &Node, rotator: &Arc<Rotator>, side: Side) -> anyhow::Result<Vec<Subscriber>> {
    let limb = side.limb_topics();
    let cuff = side.cuff_topic();
    let avoidance = format!("{limb}/collision_avoidance_state");
    let detection = format!("{limb}/collision_detection_state");
    let on_joints = on(rotator, |rotator, joints: JointState| {
        let stamp = stamp::since_epoch(joints.header.stamp);
        let (names, positions, velocities) = (&joints.name, &joints.position, &joints.velocity);
        rotator
            .monitor()
            .joint_states(names, positions, velocities, stamp, Instant::now());
    });
    let on_state = on(rotator, |rotator, state: AssemblyState| {
        rotator
            .monitor()
            .state(msg::robot::state(&state), Instant::now());
    });
    let on_cuff = on(rotator, |rotator, cuff: DigitalIOState| {
        rotator
            .monitor()
            .cuff(cuff.state == DigitalIOState::PRESSED);
    });
    let on_avoidance = on(rotator, |rotator, state: CollisionAvoidanceState| {
        rotator.monitor().collision_objects(state.collision_object);
    });
    let on_detection = on(rotator, |rotator, state: CollisionDetectionState| {
        rotator.monitor().collision_detected(state.collision_state);
    });
    Ok(vec![
        node.subscribe("/robot/joint_states", Expect::SHARED_STATE, on_joints)?,
        node.subscribe("/robot/state", Expect::STATE, on_state)?,
        node.subscribe(&cuff, Expect::EVENTS, on_cuff)?,
        node.subscribe(&avoidance, Expect::EVENTS, on_avoidance)?,
        node.subscribe(&detection, Expect::EVENTS, on_detection)?,
    ])
}

fn on<T, F: Fn(&Rotator, T)>(rotator: &Arc<Rotator>, act: F) -> impl Fn(T) + use<T, F> {
    let rotator = Arc::clone(rotator);
    move |message| act(&rotator, message)
}

/// Tells diagnostics whether the wrist could be turned now, and if not, why.
async fn report_health(node: &Node, rotator: &Rotator, parameters: &Parameters) {
    let guard = Guard::new(parameters);
    let mut ticker = tokio::time::interval(HEALTH_PERIOD);
    node.health().set_hardware(parameters.side.limb_topics());
    loop {
        ticker.tick().await;
        let checked = guard.check(rotator.monitor().snapshot(), Instant::now());
        match checked {
            Ok(_) => node.health().set("arm", Level::Ok, "may move"),
            Err(refusal) => node.health().set("arm", Level::Warn, refusal.to_string()),
        }
    }
}
