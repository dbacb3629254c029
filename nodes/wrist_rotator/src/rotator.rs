//! Turns on request, one at a time.

use std::convert::Infallible;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use baxter::{Arrival, Arrived, W2};
use msg::baxter_core_msgs::JointCommand;
use msg::std_msgs::Float64;
use node::{Latch, Life, Node, Publisher};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};
use wrist_rotator::{Monitor, Motion, MotionError, Parameters, Refusal, Step};

/// How long the master has to say who else commands the arm.
const MASTER_DEADLINE: Duration = Duration::from_secs(1);
/// Pause between such questions during a motion.
const MASTER_PERIOD: Duration = Duration::from_millis(500);
/// How long the robot has to listen to the commands: after a restart of this node its link takes a moment.
const LISTENER_PATIENCE: Duration = Duration::from_secs(2);

/// How long a wrist that is no longer commanded may take to come to rest.
const REST_PATIENCE: Duration = Duration::from_secs(3);
/// Pause between two looks at the newest joint state.
const REST_PERIOD: Duration = Duration::from_millis(5);

/// Why a turn failed.
#[derive(Debug, thiserror::Error)]
pub enum TurnError {
    /// It must not start.
    #[error("not moved: {0}")]
    Refused(#[from] Refusal),
    /// It had to end before its target.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// One turn at a time.
    #[error("not moved: the wrist is already turning; wait for its end")]
    Busy,
    /// Commands would be lost.
    #[error(
        "not moved: nobody listens to {topic} (waited {patience:.1?}); is the robot there, and can it reach this \
         computer by its ROS_IP?"
    )]
    NobodyListens {
        /// Topic of the commands.
        topic: String,
        /// How long it was waited for.
        patience: Duration,
    },
    /// Nobody waits for the turn any more.
    #[error("motion stopped: {0}")]
    NobodyWaits(String),
    /// Somebody called `stop_wrist`.
    #[error("motion stopped: stop_wrist was called")]
    Stopped,
    /// The robot does not say that the joint is still.
    #[error(
        "no longer commanded, but not seen at rest within {0:.1?}: somebody else moves the arm, or joint states are \
         silent"
    )]
    NotAtRest(Duration),
    /// The node was told to end.
    #[error("motion stopped: the wrist rotator is shutting down")]
    Shutdown,
}

/// The wrist and all that is known of it.
pub struct Rotator {
    node: Node,
    parameters: Parameters,
    monitor: Mutex<Monitor>,
    command: Publisher<JointCommand>,
    speed_ratio: Publisher<Float64>,
    command_topic: String,
    joint_names: Vec<String>,
    /// Held while a motion is under way.
    turning: tokio::sync::Mutex<()>,
    /// Counts the orders to stop; each ends the motion under way.
    stops: watch::Sender<u64>,
    shutdown: watch::Sender<bool>,
}

impl Rotator {
    pub fn new(node: &Node, parameters: &Parameters) -> anyhow::Result<Self> {
        let limb = parameters.side.limb_topics();
        let command_topic = format!("{limb}/joint_command");
        Ok(Self {
            node: node.clone(),
            parameters: parameters.clone(),
            monitor: Mutex::new(Monitor::new(parameters.side)),
            // An old command is worse than none.
            command: node.publish(&command_topic, 1, Latch::No)?,
            speed_ratio: node.publish(&format!("{limb}/set_speed_ratio"), 1, Latch::No)?,
            command_topic,
            joint_names: parameters.side.joint_names().map(String::from).to_vec(),
            turning: tokio::sync::Mutex::new(()),
            stops: watch::Sender::new(0),
            shutdown: watch::Sender::new(false),
        })
    }

    /// What the robot says of itself; to be held but for a moment.
    pub fn monitor(&self) -> MutexGuard<'_, Monitor> {
        self.monitor.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Last measured angle of W2.
    pub fn angle_rad(&self) -> Option<f64> {
        self.monitor().snapshot().joints[W2].map(|sample| sample.value.angle_rad)
    }

    /// Turns W2 to `target_rad` and returns once it is at rest there. Nothing moves without a caller that waits for it.
    pub async fn turn(&self, target_rad: f64, life: &Life) -> Result<Arrived, TurnError> {
        let _turning = self.turning.try_lock().map_err(|_| TurnError::Busy)?;
        let (mut stops, mut shutdown) = (self.stops.subscribe(), self.shutdown.subscribe());
        let ended = tokio::select! {
            // In this order, so that no command follows an order to stop.
            biased;
            _ = shutdown.wait_for(|down| *down) => Err(TurnError::Shutdown),
            _ = stops.changed() => Err(TurnError::Stopped),
            reason = life.ended() => Err(TurnError::NobodyWaits(reason)),
            arrived = self.turn_unless_stopped(target_rad) => arrived,
        };
        if let Err(TurnError::NobodyWaits(_)) = &ended {
            // Whoever handed the request on answers only when the wrist is at rest.
            self.until_rest().await?;
        }
        ended
    }

    async fn turn_unless_stopped(&self, target_rad: f64) -> Result<Arrived, TurnError> {
        self.ask_for_other_publishers().await;
        // What forbids the motion is said before anything is waited for.
        self.motion_to(target_rad)?;
        self.check_listener().await?;
        self.speed_ratio.send(Float64 {
            data: self.parameters.speed_ratio,
        });
        let motion = self.motion_to(target_rad)?;
        tokio::select! {
            biased;
            never = self.watch_other_publishers() => match never {},
            arrived = self.carry_out(motion) => Ok(arrived?),
        }
    }

    /// Ends a motion under way, if any, and returns once the wrist is at rest. It may be turned again then.
    pub async fn stop(&self) -> Result<Arrived, TurnError> {
        self.stops.send_modify(|stops| *stops += 1);
        let _turning = self.turning.lock().await;
        self.until_rest().await
    }

    async fn until_rest(&self) -> Result<Arrived, TurnError> {
        let dwell = Duration::from_secs_f64(self.parameters.dwell_s);
        let mut arrival = Arrival::anywhere(self.parameters.rest_velocity_rad_s, dwell);
        let rest = async {
            loop {
                sleep(REST_PERIOD).await;
                let newest = self.monitor().snapshot().joints[W2];
                if let Some(arrived) = newest.and_then(|sample| arrival.observe(sample.value)) {
                    return arrived;
                }
            }
        };
        let rested = timeout(REST_PATIENCE, rest).await;
        rested.map_err(|_| TurnError::NotAtRest(REST_PATIENCE))
    }

    /// Ends a motion under way, if any, and allows no more.
    pub async fn shut_down(&self) {
        self.shutdown.send_replace(true);
        let _still = self.turning.lock().await;
    }

    /// Commands the motion tick by tick. Where it ends for any reason the robot holds: its commanded angle is never far
    /// ahead of where it is, and no message means stay.
    async fn carry_out(&self, mut motion: Motion) -> Result<Arrived, MotionError> {
        let mut ticker = interval(Duration::from_secs_f64(1.0 / self.parameters.rate_hz));
        ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
        loop {
            ticker.tick().await;
            let step = motion.step(self.monitor().snapshot(), Instant::now());
            match step? {
                Step::Arrived(arrived) => return Ok(arrived),
                Step::Command(angles_rad) => self.command.send(JointCommand {
                    mode: JointCommand::POSITION_MODE,
                    command: angles_rad.to_vec(),
                    names: self.joint_names.clone(),
                }),
            }
        }
    }

    fn motion_to(&self, target_rad: f64) -> Result<Motion, Refusal> {
        let monitor = self.monitor();
        Motion::start(
            &self.parameters,
            monitor.snapshot(),
            target_rad,
            Instant::now(),
        )
    }

    async fn check_listener(&self) -> Result<(), TurnError> {
        let patience = LISTENER_PATIENCE;
        if self.command.until_subscribed(patience).await {
            return Ok(());
        }
        let topic = self.command_topic.clone();
        Err(TurnError::NobodyListens { topic, patience })
    }

    async fn watch_other_publishers(&self) -> Infallible {
        loop {
            sleep(MASTER_PERIOD).await;
            self.ask_for_other_publishers().await;
        }
    }

    async fn ask_for_other_publishers(&self) {
        let (node, topic) = (self.node.clone(), self.command_topic.clone());
        let question = tokio::task::spawn_blocking(move || other_publishers(&node, &topic));
        let answer = timeout(MASTER_DEADLINE, question).await;
        self.monitor()
            .other_publishers(answer.ok().and_then(Result::ok).flatten());
    }
}

/// Nodes besides this one that publish `topic`; `None` where the master does not say.
fn other_publishers(node: &Node, topic: &str) -> Option<Vec<String>> {
    let own_name = node.name();
    let mut publishers = node.publishers_of(topic).ok()?;
    publishers.retain(|name| *name != own_name);
    Some(publishers)
}
