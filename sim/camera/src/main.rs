//! The simulated camera as a ROS node: the topics of a D435i's depth stream, rendered from TF or played from captures.
//!
//! The service `hold_object` puts another object into the hand. Where captures are played there is no robot: the service
//! `rotate_wrist` then stands in for the wrist, and each call shows the next capture.

mod exposure;
mod messages;
mod scan_watch;
mod world;

use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use baxter::{Gap, Side};
use exposure::Source;
use gripper::{FINGERS, HandKind, ReflexParameters};
use msg::Time;
use msg::baxter_core_msgs::EndEffectorState;
use msg::deformable_cobot::{
    HoldObject, HoldObjectReq, HoldObjectRes, RotateWrist, RotateWristReq, RotateWristRes,
};
use msg::reflex_msgs;
use msg::sensor_msgs::{CameraInfo, Image};
use msg::std_msgs::Float64;
use node::transforms::TransformError;
use node::{Expect, Latch, Level, Node, Publisher, Server, Subscriber};
use scan_watch::ScanWatch;
use sim_camera::{Grip, Held, Parameters, Playback};
use tokio::sync::mpsc::{Receiver, channel};
use tokio::time::{MissedTickBehavior, interval};
use world::World;

/// Exposures under way: one being rendered, one waiting for its transforms.
const EXPOSURES_MAX: usize = 2;
/// Images kept for a slow subscriber.
const IMAGES_MAX: usize = 4;

fn main() -> ExitCode {
    node::run("sim_camera", run)
}

async fn run(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let (source, _links) = set_up(&node, &parameters)?;
    let frames = node.publish("/tf_static", 1, Latch::Yes)?;
    frames.send(messages::camera_frames(node.clock().now()));

    let (shutter, exposures) = channel(EXPOSURES_MAX);
    let camera = Camera {
        images: node.publish("camera/depth/image_rect_raw", IMAGES_MAX, Latch::No)?,
        infos: node.publish("camera/depth/camera_info", IMAGES_MAX, Latch::No)?,
        node: node.clone(),
        source,
        stamp_offset_ns: (parameters.stamp_offset_s * 1e9) as i64,
    };
    tokio::spawn(camera.develop(exposures));
    let mut ticker = interval(Duration::from_secs_f64(1.0 / parameters.rate_hz));
    ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let expose = async {
        loop {
            ticker.tick().await;
            // Full where rendering is too slow: a camera drops frames, too.
            let _ = shutter.try_send(node.clock().now());
        }
    };
    tokio::select! {
        () = expose => {}
        () = node.until_shutdown() => {}
    }
    Ok(())
}

/// What the camera sees, and the links that change it.
fn set_up(
    node: &Node,
    parameters: &Parameters,
) -> anyhow::Result<(Source, (Server, Option<Subscriber>))> {
    if let Some(folder) = parameters.captures_folder() {
        let playback = Playback::open(folder, parameters.capture_frame())?;
        log::info!(
            "playing {} captures of {}",
            playback.captures().len(),
            folder.display()
        );
        let playback = Arc::new(Mutex::new(playback));
        let service = offer_rotate_wrist(node, &playback)?;
        return Ok((Source::Recorded(playback), (service, None)));
    }
    let (kind, side) = (parameters.hand, parameters.side);
    let (squeeze_m, seed) = (parameters.squeeze_m, parameters.seed.into());
    let object = parameters.held().mesh(squeeze_m, seed)?;
    let world = Arc::new(Mutex::new(World::new(kind, object)));
    let service = offer_hold_object(node, &world, kind, side)?;
    let fingers = match kind {
        HandKind::Electric => follow_electric(node, &world, side, parameters.gap)?,
        HandKind::Reflex => follow_reflex(node, &world, side)?,
    };
    let source = Source::simulated(world, node.transforms()?, parameters)?;
    Ok((source, (service, Some(fingers))))
}

/// Draws the fingers of the electric gripper where it says that they are.
fn follow_electric(
    node: &Node,
    world: &Arc<Mutex<World>>,
    side: Side,
    gap: Gap,
) -> anyhow::Result<Subscriber> {
    let topic = format!("{}/state", side.gripper_topics());
    follow_fingers(node, world, &topic, move |state: EndEffectorState| {
        gap.width_m(f64::from(state.position) / 100.0)
    })
}

/// Draws the fingers of a ReFlex hand as far apart as its motors say.
fn follow_reflex(node: &Node, world: &Arc<Mutex<World>>, side: Side) -> anyhow::Result<Subscriber> {
    let reflex = ReflexParameters::default();
    let topic = format!("{}/hand_state", reflex.topics_on(side));
    follow_fingers(node, world, &topic, move |hand: reflex_msgs::Hand| {
        let fingers = &hand.motor[..FINGERS];
        let sum_rad: f64 = fingers.iter().map(|motor| motor.joint_angle).sum();
        reflex.width_m(sum_rad / FINGERS as f64)
    })
}

fn follow_fingers<T: msg::Message>(
    node: &Node,
    world: &Arc<Mutex<World>>,
    topic: &str,
    width_m: impl Fn(T) -> f64 + Send + Sync + 'static,
) -> anyhow::Result<Subscriber> {
    let world = Arc::clone(world);
    node.subscribe(topic, Expect::OPTIONAL_STATE, move |state| {
        let mut world = world.lock().unwrap_or_else(PoisonError::into_inner);
        world.set_width(width_m(state));
    })
}

fn offer_hold_object(
    node: &Node,
    world: &Arc<Mutex<World>>,
    kind: HandKind,
    side: Side,
) -> anyhow::Result<Server> {
    let (world, side) = (Arc::clone(world), side.name());
    // The simulated hand closes on what is put into it.
    let hand = node.publish(&format!("/sim_baxter/{side}_object_width_m"), 1, Latch::Yes)?;
    let tell = move |world: &World| {
        let data = world.grasp_width_m().unwrap_or(0.0);
        hand.send(Float64 { data });
    };
    tell(&world.lock().unwrap_or_else(PoisonError::into_inner));
    let watch = ScanWatch::listen(node)?;
    let hold = move |request: HoldObjectReq| {
        let result = held(kind, &request).and_then(|held| {
            if !request.during_scan {
                watch.refuse_during_scan()?;
            }
            let mut world = world.lock().unwrap_or_else(PoisonError::into_inner);
            world.hold(held);
            tell(&world);
            log::info!("holding '{}'", request.object);
            Ok(())
        });
        let error = result
            .err()
            .map(|error| error.to_string())
            .unwrap_or_default();
        HoldObjectRes {
            success: error.is_empty(),
            error,
        }
    };
    let hold = Arc::new(hold);
    node.serve::<HoldObject>("hold_object", move |request, _| {
        let hold = Arc::clone(&hold);
        node::compute(move || hold(request))
    })
}

fn held(kind: HandKind, request: &HoldObjectReq) -> anyhow::Result<World> {
    let Ok(held) = request.object.parse::<Held>();
    anyhow::ensure!(
        request.turn.is_finite(),
        "turn is {}; expected an angle in rad",
        request.turn
    );
    let grip = Grip {
        upside_down: request.upside_down,
        turn_rad: request.turn,
    };
    let object = held.mesh(request.squeeze, request.seed)?;
    Ok(World::new(kind, object.map(|object| grip.place(&object))))
}

fn offer_rotate_wrist(node: &Node, playback: &Arc<Mutex<Playback>>) -> anyhow::Result<Server> {
    let (playback, clock) = (Arc::clone(playback), node.clock());
    node.serve::<RotateWrist>("rotate_wrist", move |RotateWristReq { angle }, _| {
        let mut playback = playback.lock().unwrap_or_else(PoisonError::into_inner);
        log::info!("showing {}", playback.advance().path.display());
        std::future::ready(Ok(RotateWristRes {
            success: true,
            error: String::new(),
            angle,
            at_rest: clock.now(),
        }))
    })
}

struct Camera {
    node: Node,
    source: Source,
    images: Publisher<Image>,
    infos: Publisher<CameraInfo>,
    /// How much later than the middle of its exposure an image's stamp is.
    stamp_offset_ns: i64,
}

impl Camera {
    /// Publishes an image and its camera_info for each exposure; the image only while somebody wants it.
    async fn develop(mut self, mut exposures: Receiver<Time>) {
        let mut seeing = true;
        while let Some(moment) = exposures.recv().await {
            let stamp = Time::from_nanos(moment.nanos() + self.stamp_offset_ns);
            if self.images.is_subscribed() {
                let seen = self.source.expose(moment).await;
                self.report(seeing, seen.as_ref().err());
                seeing = seen.is_ok();
                if let Ok(image) = seen {
                    self.images.send(messages::image(stamp, &image));
                }
            }
            let info = messages::camera_info(stamp, &sim_camera::D435I);
            self.infos.send(info);
        }
    }

    /// Tells diagnostics how it goes, and the log when that changes.
    fn report(&self, seeing_before: bool, trouble: Option<&TransformError>) {
        let health = self.node.health();
        match trouble {
            Some(trouble) => {
                if seeing_before {
                    log::warn!("no image: {trouble}");
                }
                health.set("image", Level::Warn, trouble.to_string());
            }
            None => {
                if !seeing_before {
                    log::info!("images again");
                }
                health.set("image", Level::Ok, "as it should be");
            }
        }
    }
}
