//! Carries out grasps, one at a time.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use baxter::{Aged, RobotState, StateRefusal, StateRules};
use gripper::{GraspError, Grasped, Hand, Parameters, Step, Task};
use msg::Message;
use node::{Health, Level, Life, Publisher};
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval};

/// Period of steps: the maker's client repeats its commands at 100 Hz.
const TICK: Duration = Duration::from_millis(10);
const HEALTH_PERIOD: Duration = Duration::from_secs(1);
/// Time limit for the gripper to subscribe to the commands, which takes a moment after a restart of this node.
const LISTENER_PATIENCE: Duration = Duration::from_secs(2);

/// How a grasp ended.
pub enum Ending {
    /// Successfully.
    Well(Grasped),
    /// Refused before anything moved.
    Refused(GraspError),
    /// Failed after the motion began.
    Failed(GraspError),
}

/// Connects a hand to its topics.
pub struct Shell<H: Hand, M: Message> {
    hand: Mutex<H>,
    robot: Mutex<Option<Aged<RobotState>>>,
    state_rules: StateRules,
    commands: Publisher<M>,
    encode: fn(H::Command) -> M,
    /// Locked while a grasp is running.
    grasping: tokio::sync::Mutex<()>,
    shutdown: watch::Sender<bool>,
}

impl<H: Hand, M: Message> Shell<H, M> {
    pub fn new(
        hand: H,
        parameters: &Parameters,
        commands: Publisher<M>,
        encode: fn(H::Command) -> M,
    ) -> Arc<Self> {
        Arc::new(Self {
            hand: Mutex::new(hand),
            robot: Mutex::default(),
            state_rules: parameters.state_rules(),
            commands,
            encode,
            grasping: tokio::sync::Mutex::new(()),
            shutdown: watch::Sender::new(false),
        })
    }

    /// Locks the hand; release the lock soon.
    pub fn hand(&self) -> MutexGuard<'_, H> {
        self.hand.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a message of `/robot/state`.
    pub fn hear_robot(&self, value: RobotState) {
        let received = Instant::now();
        *self.robot.lock().unwrap_or_else(PoisonError::into_inner) = Some(Aged { value, received });
    }

    /// Carries out `task` and returns once it has ended. The fingers are stopped if the caller closes its connection.
    pub async fn grasp(&self, task: Task, life: &Life) -> Ending {
        let Ok(_grasping) = self.grasping.try_lock() else {
            return Ending::Refused(GraspError::Busy);
        };
        if let Err(refusal) = self.prepare(task).await {
            return Ending::Refused(refusal);
        }
        let mut shutdown = self.shutdown.subscribe();
        let ended = tokio::select! {
            // Checked in this order, so that no command is sent after a stop.
            biased;
            _ = shutdown.wait_for(|down| *down) => Err(GraspError::Shutdown),
            _ = life.ended() => Err(GraspError::CallerGone),
            ended = self.carry_out() => ended,
        };
        match ended {
            Ok(grasped) => Ending::Well(grasped),
            Err(error) => {
                let halt = self.hand().halt();
                halt.into_iter().for_each(|command| self.send(command));
                Ending::Failed(error)
            }
        }
    }

    /// Ends a running grasp, if any, and refuses further ones.
    pub async fn stop(&self) {
        self.shutdown.send_replace(true);
        let _still = self.grasping.lock().await;
    }

    /// Reports to diagnostics whether the gripper could be used now, and if not, why.
    pub async fn report_health(&self, health: &Health) {
        let mut ticker = interval(HEALTH_PERIOD);
        loop {
            ticker.tick().await;
            match self.check() {
                Ok(()) => health.set("gripper", Level::Ok, "may move"),
                Err(error) => health.set("gripper", Level::Warn, error.to_string()),
            }
        }
    }

    fn check(&self) -> Result<(), GraspError> {
        let now = Instant::now();
        self.check_robot(now)?;
        self.hand().check(now)
    }

    fn check_robot(&self, now: Instant) -> Result<(), StateRefusal> {
        let last = *self.robot.lock().unwrap_or_else(PoisonError::into_inner);
        self.state_rules.check(last.as_ref(), now)
    }

    async fn prepare(&self, task: Task) -> Result<(), GraspError> {
        // Check first, so that a refusal is reported without waiting.
        self.check()?;
        self.hand().begin(task, Instant::now())?;
        if !self.commands.until_subscribed(LISTENER_PATIENCE).await {
            return Err(GraspError::NobodyListens {
                topic: self.commands.topic().into(),
                waited_s: LISTENER_PATIENCE.as_secs_f64(),
            });
        }
        self.check()?;
        self.hand().begin(task, Instant::now())
    }

    async fn carry_out(&self) -> Result<Grasped, GraspError> {
        let mut ticker = interval(TICK);
        ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
        loop {
            ticker.tick().await;
            let now = Instant::now();
            self.check_robot(now)?;
            let step = self.hand().step(now)?;
            match step {
                Step::Send(command) => self.send(command),
                Step::Wait => {}
                Step::Done(grasped) => return Ok(grasped),
            }
        }
    }

    fn send(&self, command: H::Command) {
        self.commands.send((self.encode)(command));
    }
}
