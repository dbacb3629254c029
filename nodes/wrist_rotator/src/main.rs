//! The wrist rotator as a ROS node: services `rotate_wrist` and `stop_wrist`.

mod rotator;

use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use baxter::Side;
use msg::baxter_core_msgs::{
    AssemblyState, CollisionAvoidanceState, CollisionDetectionState, DigitalIOState,
};
use msg::deformable_cobot::{
    RotateWrist, RotateWristReq, RotateWristRes, SweepWrist, SweepWristReq, SweepWristRes,
};
use msg::sensor_msgs::JointState;
use msg::std_srvs::{Trigger, TriggerRes};
use msg::{Time, stamp};
use node::{Expect, Level, Life, Node, Subscriber};
use rotator::Rotator;
use wrist_rotator::{ConstantPart, Guard, Parameters, Surroundings, Turn};

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
            let turn = Turn {
                target_rad: angle,
                rate_rad_s: None,
            };
            async move {
                let turned = rotate("rotate_wrist", &rotator, turn, &life).await;
                Ok(RotateWristRes {
                    success: turned.success,
                    error: turned.error,
                    angle: turned.angle,
                    at_rest: turned.at_rest,
                })
            }
        }
    })?;
    let _sweep = node.serve::<SweepWrist>("sweep_wrist", {
        let rotator = Arc::clone(&rotator);
        move |SweepWristReq { angle, rate }, life| {
            let rotator = Arc::clone(&rotator);
            let turn = Turn {
                target_rad: angle,
                rate_rad_s: Some(rate),
            };
            async move { Ok(rotate("sweep_wrist", &rotator, turn, &life).await) }
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
    // Each life ends; the links go down only once nothing moves.
    rotator.until_free().await;
    Ok(())
}

async fn rotate(service: &str, rotator: &Rotator, turn: Turn, life: &Life) -> SweepWristRes {
    match rotator.turn(turn, life).await {
        Ok((arrived, constant)) => {
            let at_rest = stamp::from_epoch(arrived.at_rest);
            let moment = |of: fn(ConstantPart) -> Duration| {
                constant.map_or_else(Time::default, |part| stamp::from_epoch(of(part)))
            };
            SweepWristRes {
                success: true,
                error: String::new(),
                angle: arrived.angle_rad,
                at_rest,
                constant_from: moment(|part| part.from),
                constant_until: moment(|part| part.until),
            }
        }
        Err(error) => {
            log::warn!("{service} to {:.3} rad: {error}", turn.target_rad);
            let angle = rotator.angle_rad().unwrap_or(f64::NAN);
            SweepWristRes {
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
        Err(message) => {
            log::warn!("stop_wrist: {message}");
            TriggerRes {
                success: false,
                message,
            }
        }
    }
}

fn listen(node: &Node, rotator: &Arc<Rotator>, side: Side) -> anyhow::Result<Vec<Subscriber>> {
    let on_joints = on(rotator, |rotator, joints: JointState| {
        let stamp = stamp::since_epoch(joints.header.stamp);
        let (names, positions, velocities) = (&joints.name, &joints.position, &joints.velocity);
        rotator
            .monitor()
            .joint_states(names, positions, velocities, stamp, Instant::now());
    });
    let on_state = on(rotator, |rotator, state: AssemblyState| {
        let state = msg::robot::state(&state);
        rotator.monitor().state(state, Instant::now());
    });
    let on_cuff = on(rotator, |rotator, cuff: DigitalIOState| {
        let held = cuff.state == DigitalIOState::PRESSED;
        rotator.monitor().cuff(held, Instant::now());
    });
    let on_avoidance = on(rotator, |rotator, state: CollisionAvoidanceState| {
        let objects = state.collision_object;
        rotator.monitor().collision_objects(objects, Instant::now());
    });
    let on_detection = on(rotator, |rotator, state: CollisionDetectionState| {
        let detected = state.collision_state;
        rotator
            .monitor()
            .collision_detected(detected, Instant::now());
    });
    let topic = |what: Surroundings| what.topic(side);
    let (cuff, avoidance, detection) = (
        topic(Surroundings::Cuff),
        topic(Surroundings::CollisionAvoidance),
        topic(Surroundings::CollisionDetection),
    );
    Ok(vec![
        node.subscribe("/robot/joint_states", Expect::SHARED_STATE, on_joints)?,
        node.subscribe("/robot/state", Expect::STATE, on_state)?,
        node.subscribe(&cuff, Expect::OPTIONAL_STATE, on_cuff)?,
        node.subscribe(&avoidance, Expect::OPTIONAL_STATE, on_avoidance)?,
        node.subscribe(&detection, Expect::OPTIONAL_STATE, on_detection)?,
    ])
}

fn on<T, F: Fn(&Rotator, T)>(rotator: &Arc<Rotator>, act: F) -> impl Fn(T) + use<T, F> {
    let rotator = Arc::clone(rotator);
    move |message| act(&rotator, message)
}

/// Tells diagnostics whether the wrist could be turned now, and if not, why.
async fn report_health(node: &Node, rotator: &Rotator, parameters: &Parameters) {
    let guard = Guard::new(parameters);
    for what in &parameters.waived {
        let text = format!(
            "moves without hearing {} (~waived)",
            what.topic(parameters.side)
        );
        log::warn!("{text}");
        node.health().set(what.name(), Level::Warn, text);
    }
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
