//! The simulated Baxter as a ROS node: the robot's own topics with their own types, and a few private ones that play people
//! and mishaps.
//!
//! | private topic | type | effect |
//! |---|---|---|
//! | `~press_estop` | Bool | presses the emergency stop (true) or lets it go (false) |
//! | `~report_error` | Bool | an error that does not stop the robot |
//! | `~hold_left_cuff`, `~hold_right_cuff` | Bool | a hand on the cuff |
//! | `~left_collision_object` | String | what collision avoidance sees near the left arm; empty for nothing |
//! | `~left_impact` | Bool | what collision detection feels on the left arm |
//! | `~jam_left_wrist` | Bool | blocks the left W2 where it is |
//! | `~silence` | String | the topic that falls silent: joint_states, state, cuff, collision_avoidance, collision_detection; empty for none |
//! | `~step_clock` | Float64 | sets the robot's clock so many seconds ahead |
//! | `~left_object_width_m`, `~right_object_width_m` | Float64 | puts something so thick into the hand, which closes on it; 0 takes it away |
//!
//! Where the environment variable `DEFORMABLE_COBOT_RECORD` names a folder, the robot writes there what it was told and did, and
//! what of it was against the contract of motion (module `record`).

mod hand_publishers;
mod publishers;
mod record;
mod subscribers;

use std::process::ExitCode;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use anyhow::Context;
use msg::Time;
use node::Node;
use record::Record;
use sim_baxter::{Kinematics, Parameters, Robot};
use tokio::time::{MissedTickBehavior, interval};

/// Longest time made up for after this process was held up. A robot does not move without its controller.
const CATCH_UP_MAX: Duration = Duration::from_millis(100);

fn main() -> ExitCode {
    node::run("sim_baxter", run)
}

async fn run(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let kinematics = Kinematics::baxter()?;
    let robot = Robot::new(&parameters, &kinematics).context("cannot start in scan_pose")?;
    let publishers = publishers::Publishers::new(&node, &robot)?;
    let simulation = Simulation::new(robot);
    let _subscribers = subscribers::listen(&node, &simulation)?;
    let mut record = Record::from_environment()?;
    let mut ticker = interval(Duration::from_secs_f64(1.0 / parameters.rate_hz));
    ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let publish = async {
        for tick in 0_u64.. {
            ticker.tick().await;
            let stamp = simulation.stamp(node.clock().now());
            let silenced = simulation.silenced();
            let mut robot = simulation.now();
            publishers.publish_due(&mut robot, stamp, tick, &silenced);
            record.write(&mut robot);
        }
    };
    tokio::select! {
        () = publish => {}
        () = node.until_shutdown() => {}
    }
    record.write(&mut simulation.now());
    Ok(())
}

/// A robot in real time. Clones share it.
#[derive(Clone)]
struct Simulation {
    shared: Arc<Mutex<(Robot, Instant)>>,
    clock_offset_ns: Arc<AtomicI64>,
    silenced: Arc<Mutex<String>>,
}

impl Simulation {
    fn new(robot: Robot) -> Self {
        Self {
            shared: Arc::new(Mutex::new((robot, Instant::now()))),
            clock_offset_ns: Arc::default(),
            silenced: Arc::default(),
        }
    }

    /// Sets the robot's clock so far ahead of this computer's; negative: behind.
    fn step_clock(&self, offset_s: f64) {
        // Saturates, and takes NaN for 0.
        self.clock_offset_ns
            .store((offset_s * 1e9) as i64, Ordering::Relaxed);
    }

    /// Publishes no more of that; empty: publishes everything.
    fn silence(&self, what: String) {
        *self.silenced.lock().unwrap_or_else(PoisonError::into_inner) = what;
    }

    fn silenced(&self) -> String {
        let silenced = self.silenced.lock();
        silenced.unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The robot's time when this computer's is `now`.
    fn stamp(&self, now: Time) -> Time {
        let offset_ns = self.clock_offset_ns.load(Ordering::Relaxed);
        Time::from_nanos(now.nanos().saturating_add(offset_ns).max(0))
    }

    /// The robot as it is now.
    fn now(&self) -> Now<'_> {
        let mut guard = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let (robot, time) = &mut *guard;
        let elapsed = time.elapsed();
        *time += elapsed;
        robot.step(elapsed.min(CATCH_UP_MAX).as_secs_f64());
        Now { guard }
    }
}

/// The robot, held still while in use.
struct Now<'a> {
    guard: MutexGuard<'a, (Robot, Instant)>,
}

impl std::ops::Deref for Now<'_> {
    type Target = Robot;
    fn deref(&self) -> &Robot {
        &self.guard.0
    }
}

impl std::ops::DerefMut for Now<'_> {
    fn deref_mut(&mut self) -> &mut Robot {
        &mut self.guard.0
    }
}
