//! Turns on request, one at a time, and says how each ended.

use std::convert::Infallible;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use baxter::{Arrival, Arrived, W2};
use msg::baxter_core_msgs::JointCommand;
use msg::std_msgs::{Float64, UInt64};
use node::{Latch, Life, Node, Publisher};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};
use wrist_rotator::{ConstantPart, Ended, Monitor, Motion, MotionError, Parameters, Step, Turn};

/// How long the master has to say who else commands the arm.
const MASTER_DEADLINE: Duration = Duration::from_secs(1);
/// Pause between such questions during a motion.
const MASTER_PERIOD: Duration = Duration::from_millis(50);
/// How long the robot has to listen to the commands: after a restart of this node its link takes a moment.
const LISTENER_PATIENCE: Duration = Duration::from_secs(2);

/// How long a message that may forbid a turn is waited for before the turn.
const SILENCE_PATIENCE: Duration = Duration::from_secs(1);

/// How long a wrist that is not commanded may take to be seen at rest.
const REST_PATIENCE: Duration = Duration::from_secs(3);
/// Pause between two looks at the newest joint state.
const REST_PERIOD: Duration = Duration::from_millis(5);

/// Why a turn failed.
#[derive(Debug, thiserror::Error)]
pub enum TurnError {
    /// It ended before it began.
    #[error("not moved: {0}")]
    NotBegun(MotionError),
    /// It had to end before its target, and the arm is at rest.
    #[error(transparent)]
    Motion(MotionError),
    /// It had to end before its target, and who knows where the arm is.
    #[error(
        "{0}; no longer commanded, but not seen at rest either: somebody else moves the arm, or joint states are silent"
    )]
    NotAtRest(MotionError),
    /// One turn at a time.
    #[error("not moved: the wrist is already turning, or is being stopped; wait for its end")]
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
}

/// The wrist and all that is known of it.
pub struct Rotator {
    node: Node,
    parameters: Parameters,
    monitor: Mutex<Monitor>,
    command: Publisher<JointCommand>,
    speed_ratio: Publisher<Float64>,
    /// Tells of each order to stop, so that what makes several turns ends, too, when it comes between two of them.
    stop_count: Publisher<UInt64>,
    command_topic: String,
    joint_names: Vec<String>,
    /// Held while a motion is under way.
    turning: tokio::sync::Mutex<()>,
    /// Counts the orders to stop; each ends the motion under way.
    stops: watch::Sender<u64>,
}

impl Rotator {
    pub fn new(node: &Node, parameters: &Parameters) -> anyhow::Result<Self> {
        let limb = parameters.side.limb_topics();
        let command_topic = format!("{limb}/joint_command");
        let stop_count = node.publish("wrist_stops", 1, Latch::Yes)?;
        stop_count.send(UInt64 { data: 0 });
        Ok(Self {
            node: node.clone(),
            parameters: parameters.clone(),
            monitor: Mutex::new(Monitor::new(parameters.side)),
            // An old command is worse than none.
            command: node.publish_prompt(&command_topic, 1)?,
            speed_ratio: node.publish_prompt(&format!("{limb}/set_speed_ratio"), 1)?,
            stop_count,
            command_topic,
            joint_names: parameters.side.joint_names().map(String::from).to_vec(),
            turning: tokio::sync::Mutex::new(()),
            stops: watch::Sender::new(0),
        })
    }

    /// What the robot says of itself; to be held but for a moment.
    pub fn monitor(&self) -> MutexGuard<'_, Monitor> {
        self.monitor.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Last measured angle of W2, rad.
    pub fn angle_rad(&self) -> Option<f64> {
        self.monitor().snapshot().joints[W2].map(|sample| sample.value.angle_rad)
    }

    /// Turns W2 and returns once it is at rest, at the target or wherever the turn had to end, as when `life` ends.
    ///
    /// # Errors
    /// Why it did not reach the target.
    pub async fn turn(
        &self,
        turn: Turn,
        life: &Life,
    ) -> Result<(Arrived, Option<ConstantPart>), TurnError> {
        // Before the lock: an order to stop that comes in between ends this turn.
        let stops = self.stops.subscribe();
        let _turning = self.turning.try_lock().map_err(|_| TurnError::Busy)?;
        let mut end = std::pin::pin!(ended_by(stops, life));
        let mut motion = tokio::select! {
            biased;
            reason = &mut end => return Err(TurnError::NotBegun(reason)),
            motion = self.prepare(turn) => motion?,
        };
        let mut ticker = interval(Duration::from_secs_f64(1.0 / self.parameters.rate_hz));
        ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let carried_out = async {
            let mut is_ordered = true;
            loop {
                tokio::select! {
                    biased;
                    reason = &mut end, if is_ordered => {
                        is_ordered = false;
                        motion.end(reason, Instant::now());
                    }
                    _ = ticker.tick() => {
                        if let Some(ended) = self.step(&mut motion) {
                            return ended;
                        }
                    }
                }
            }
        };
        let ended = tokio::select! {
            biased;
            never = self.watch_other_publishers() => match never {},
            ended = carried_out => ended,
        };
        match ended {
            Ended {
                rest: None,
                result: Err(reason),
                ..
            } => Err(TurnError::NotAtRest(reason)),
            Ended {
                result, constant, ..
            } => match result {
                Ok(arrived) => Ok((arrived, constant)),
                Err(reason) => Err(TurnError::Motion(reason)),
            },
        }
    }

    /// Ends a motion under way, if any, and returns once the wrist is at rest. It may be turned again then.
    ///
    /// # Errors
    /// The robot does not say that the wrist rests.
    pub async fn stop(&self) -> Result<Arrived, String> {
        self.stops.send_modify(|stops| {
            *stops += 1;
            self.stop_count.send(UInt64 { data: *stops });
        });
        let _turning = self.turning.lock().await;
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
        timeout(REST_PATIENCE, rest).await.map_err(|_| {
            format!(
                "not commanded, but not seen at rest within {REST_PATIENCE:.1?}: somebody else moves the arm, or joint \
                 states are silent"
            )
        })
    }

    /// Waits until no motion is under way.
    pub async fn until_free(&self) {
        let _still = self.turning.lock().await;
    }

    /// All that comes before the first command.
    async fn prepare(&self, turn: Turn) -> Result<Motion, TurnError> {
        self.ask_for_other_publishers().await;
        // What forbids the motion is said before anything else is waited for.
        self.until_heard(turn).await?;
        let patience = LISTENER_PATIENCE;
        if !self.command.until_subscribed(patience).await {
            let topic = self.command_topic.clone();
            return Err(TurnError::NobodyListens { topic, patience });
        }
        self.speed_ratio.send(Float64 {
            data: self.parameters.speed_ratio,
        });
        self.motion_of(turn)
    }

    /// Waits until what may forbid the motion is fresh, and refuses it where it forbids it. On a busy computer a message may be
    /// late; while nothing moves there is no danger in that.
    async fn until_heard(&self, turn: Turn) -> Result<(), TurnError> {
        let deadline = Instant::now() + SILENCE_PATIENCE;
        loop {
            match self.motion_of(turn) {
                Err(TurnError::NotBegun(MotionError::Refused(refusal)))
                    if refusal.is_of_silence() && Instant::now() < deadline =>
                {
                    sleep(REST_PERIOD).await;
                }
                other => return other.map(|_| ()),
            }
        }
    }

    /// One tick of the motion; the end, if this was the last.
    fn step(&self, motion: &mut Motion) -> Option<Ended> {
        let step = {
            // The clock is read once the lock is held, which may take long on a busy computer.
            let monitor = self.monitor();
            motion.step(monitor.snapshot(), Instant::now())
        };
        match step {
            Step::Ended(ended) => return Some(ended),
            Step::Command(angles_rad) if motion.may_send(Instant::now()) => {
                self.command.send(JointCommand {
                    mode: JointCommand::POSITION_MODE,
                    command: angles_rad.to_vec(),
                    names: self.joint_names.clone(),
                });
                self.monitor().commanded(angles_rad, Instant::now());
            }
            Step::Command(_) | Step::Wait => {}
        }
        None
    }

    fn motion_of(&self, turn: Turn) -> Result<Motion, TurnError> {
        let monitor = self.monitor();
        let (snapshot, now) = (monitor.snapshot(), Instant::now());
        Motion::start(&self.parameters, snapshot, turn, now).map_err(TurnError::NotBegun)
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

/// What ends a motion from outside.
async fn ended_by(mut stops: watch::Receiver<u64>, life: &Life) -> MotionError {
    tokio::select! {
        biased;
        _ = stops.changed() => MotionError::Stopped,
        reason = life.ended() => MotionError::NobodyWaits(reason),
    }
}

/// Nodes besides this one that publish `topic`; `None` where the master does not say.
fn other_publishers(node: &Node, topic: &str) -> Option<Vec<String>> {
    let own_name = node.name();
    let mut publishers = node.publishers_of(topic).ok()?;
    publishers.retain(|name| *name != own_name);
    Some(publishers)
}
