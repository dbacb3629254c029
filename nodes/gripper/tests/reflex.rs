//! The ReFlex hand's client against the simulated hand, in simulated time.
#![allow(clippy::unwrap_used, missing_docs)]

use std::time::{Duration, Instant};

use baxter::Side;
use gripper::{
    FINGERS, FingerState, GraspError, Grasped, Hand, Outcome, Parameters, Reflex, Step, Task,
};
use sim_baxter::{HandKind, Kinematics, Robot};

const TICK: Duration = Duration::from_millis(10);

struct World {
    robot: Robot,
    client: Reflex,
    now: Instant,
    /// Whether the driver hears commands.
    obeying: bool,
}

impl World {
    fn new() -> Self {
        let simulated = sim_baxter::Parameters {
            left_hand: HandKind::Reflex,
            ..Default::default()
        };
        Self {
            robot: Robot::new(&simulated, &Kinematics::baxter().unwrap()).unwrap(),
            client: Reflex::new(&Parameters::default()),
            now: Instant::now(),
            obeying: true,
        }
    }

    fn fingers(&self) -> [FingerState; FINGERS] {
        let motors = self.robot.hand(Side::Left).reflex().unwrap().motors();
        std::array::from_fn(|index| FingerState {
            angle_rad: motors[index].angle_rad,
            load: motors[index].load,
        })
    }

    fn grasp(&mut self, command: &str, width_m: f64, force: f64) -> Result<Grasped, GraspError> {
        self.client.hear(self.fingers(), self.now);
        self.client
            .begin(Task::new(command, width_m, force)?, self.now)?;
        for _ in 0..1000 {
            match self.client.step(self.now)? {
                Step::Done(grasped) => return Ok(grasped),
                Step::Send(pose) if self.obeying => {
                    let [f1, f2, f3] = pose.fingers_rad;
                    let hand = self.robot.hand_mut(Side::Left).reflex_mut().unwrap();
                    hand.command([f1, f2, f3, pose.preshape_rad]);
                }
                _ => {}
            }
            self.robot.step(TICK.as_secs_f64());
            self.now += TICK;
            self.client.hear(self.fingers(), self.now);
        }
        panic!("no end in 10 s");
    }
}

#[test]
fn an_empty_hand_misses_and_an_object_is_gripped_with_the_force_asked_for() {
    let mut world = World::new();
    assert_eq!(
        world.grasp("close", 0.0, 0.0).unwrap().outcome,
        Outcome::Missed
    );
    assert_eq!(
        world.grasp("open", 0.0, 0.0).unwrap().outcome,
        Outcome::Reached
    );
    world.robot.hand_mut(Side::Left).hold(Some(0.07));
    for force in [0.3, 0.6, 0.9] {
        assert_eq!(
            world.grasp("open", 0.0, 0.0).unwrap().outcome,
            Outcome::Reached
        );
        let gripped = world.grasp("close", 0.0, force).unwrap();
        assert_eq!(gripped.outcome, Outcome::Gripped);
        assert!((gripped.width_m - 0.07).abs() < 2e-3);
        let loads = world.fingers().map(|finger| finger.load);
        let asked = 350.0 * force;
        let near = 0.98 * asked..1.2 * asked;
        assert!(
            loads.iter().all(|load| near.contains(load)),
            "{loads:?} at {force}"
        );
    }
    assert_eq!(
        world.grasp("close", 0.0, 0.9).unwrap().outcome,
        Outcome::Gripped,
        "still there"
    );
    assert_eq!(
        world.grasp("width", 0.1, 0.0).unwrap().outcome,
        Outcome::Reached
    );
    assert!(matches!(
        world.grasp("width", 0.3, 0.0),
        Err(GraspError::WidthOutside { .. })
    ));
}

#[test]
fn a_hand_that_does_not_follow_is_no_grip() {
    let mut world = World::new();
    world.obeying = false;
    let error = world.grasp("close", 0.0, 0.0).unwrap_err();
    assert!(
        matches!(error, GraspError::NotFollowing { finger: 1, .. }),
        "{error}"
    );
}

#[test]
fn one_finger_alone_holds_nothing() {
    let mut client = Reflex::new(&Parameters::default());
    let mut now = Instant::now();
    let mut angles_rad = [0.0; FINGERS];
    client.hear([FingerState::default(); FINGERS], now);
    client
        .begin(Task::new("close", 0.0, 0.0).unwrap(), now)
        .unwrap();
    let error = loop {
        match client.step(now) {
            Ok(Step::Send(pose)) => angles_rad = pose.fingers_rad,
            Ok(Step::Wait) => {}
            other => break other.unwrap_err(),
        }
        // The third finger meets something at 1 rad.
        let load = if angles_rad[2] > 1.0 {
            900.0 * (angles_rad[2] - 1.0)
        } else {
            0.0
        };
        let free = |angle_rad| FingerState {
            angle_rad,
            load: 0.0,
        };
        let stopped = FingerState {
            angle_rad: angles_rad[2].min(1.0),
            load,
        };
        client.hear([free(angles_rad[0]), free(angles_rad[1]), stopped], now);
        now += TICK;
    };
    assert_eq!(error, GraspError::OneFinger { finger: 3 });
}

#[test]
fn a_halt_keeps_the_fingers_where_they_are() {
    let mut world = World::new();
    world.client.hear(world.fingers(), world.now);
    assert_eq!(world.client.halt(), None, "nothing is under way");
    world
        .client
        .begin(Task::new("close", 0.0, 0.0).unwrap(), world.now)
        .unwrap();
    world.client.step(world.now).unwrap();
    let halted = world.client.halt().unwrap();
    assert_eq!(
        halted.fingers_rad,
        world.fingers().map(|finger| finger.angle_rad)
    );
    let broken = FingerState {
        angle_rad: f64::NAN,
        load: 0.0,
    };
    world
        .client
        .hear([broken; FINGERS], world.now + Duration::from_secs(1));
    let late = world.now + Duration::from_secs(1);
    assert!(
        matches!(world.client.check(late), Err(GraspError::Silent { .. })),
        "NaN is no news"
    );
}
