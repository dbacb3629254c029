//! The electric gripper's client against the simulated gripper, in simulated time.
#![allow(clippy::unwrap_used, missing_docs)]

use std::time::{Duration, Instant};

use baxter::Side;
use gripper::{
    Electric, ElectricCommand, ElectricState, Flag, GraspError, Grasped, Hand, Outcome, Parameters,
    Step, Task,
};
use sim_baxter::{GripperCommand, Kinematics, Robot};

const TICK: Duration = Duration::from_millis(10);

/// A robot, a client, and what passed between them.
struct World {
    robot: Robot,
    client: Electric,
    now: Instant,
    sent: Vec<ElectricCommand>,
    /// Whether the gripper's messages arrive.
    audible: bool,
}

fn flag(value: bool) -> Flag {
    u8::from(value).into()
}

impl World {
    fn new(parameters: &Parameters, calibrated: bool) -> Self {
        let simulated = sim_baxter::Parameters {
            gripper_calibrated: calibrated,
            ..Default::default()
        };
        let robot = Robot::new(&simulated, &Kinematics::baxter().unwrap()).unwrap();
        Self {
            robot,
            client: Electric::new(parameters, "/gripper"),
            now: Instant::now(),
            sent: Vec::new(),
            audible: true,
        }
    }

    /// A calibrated gripper that has just been told to close.
    fn closing() -> Self {
        let mut world = Self::new(&Parameters::default(), true);
        world.hear();
        let task = Task::new("close", 0.0, 0.0).unwrap();
        world.client.begin(task, world.now).unwrap();
        world
    }

    /// Of the simulated fingers, percent open.
    fn position(&self) -> f64 {
        let hand = self.robot.hand(Side::Left);
        hand.electric().unwrap().state().position
    }

    fn hear(&mut self) {
        let state = self.robot.hand(Side::Left).electric().unwrap().state();
        let heard = ElectricState {
            id: state.id,
            enabled: flag(state.enabled),
            calibrated: flag(state.calibrated),
            ready: flag(state.ready),
            moving: flag(state.moving),
            gripping: flag(state.gripping),
            missed: flag(state.missed),
            error: flag(state.error),
            position: state.position,
            sender: state.sender.clone(),
            sequence: state.sequence,
        };
        if self.audible {
            self.client.hear(heard, self.now);
        }
    }

    fn grasp(&mut self, command: &str, width_m: f64) -> Result<Grasped, GraspError> {
        self.hear();
        let task = Task::new(command, width_m, 0.0)?;
        self.client.begin(task, self.now)?;
        self.finish()
    }

    fn finish(&mut self) -> Result<Grasped, GraspError> {
        for _ in 0..2000 {
            match self.client.step(self.now)? {
                Step::Done(grasped) => return Ok(grasped),
                Step::Send(command) => self.obey(command),
                Step::Wait => {}
            }
            self.robot.step(TICK.as_secs_f64());
            self.now += TICK;
            self.hear();
        }
        panic!("no end in 20 s");
    }

    fn obey(&mut self, command: ElectricCommand) {
        let gripper = self.robot.hand_mut(Side::Left).electric_mut().unwrap();
        // What is refused shows in the state.
        let _ = gripper.command(&GripperCommand {
            id: command.id,
            command: command.command.into(),
            args: command.args.clone(),
            sender: command.sender.clone(),
            sequence: command.sequence,
        });
        if self.sent.last() != Some(&command) {
            self.sent.push(command);
        }
    }

    fn verbs(&mut self) -> Vec<&'static str> {
        let sent = std::mem::take(&mut self.sent);
        sent.iter().map(|command| command.command).collect()
    }
}

#[test]
fn an_unknown_gripper_is_calibrated_first_and_only_then() {
    let mut world = World::new(&Parameters::default(), false);
    assert_eq!(world.grasp("open", 0.0).unwrap().outcome, Outcome::Reached);
    assert_eq!(world.verbs(), ["calibrate", "configure", "go"]);
    assert_eq!(world.grasp("close", 0.0).unwrap().outcome, Outcome::Missed);
    assert_eq!(world.verbs(), ["configure", "go"]);
}

#[test]
fn an_object_is_gripped_wherever_the_fingers_meet_it() {
    let mut world = World::new(&Parameters::default(), true);
    world.robot.hand_mut(Side::Left).hold(Some(0.066));
    let gripped = world.grasp("close", 0.0).unwrap();
    assert_eq!(gripped.outcome, Outcome::Gripped);
    assert!((gripped.width_m - 0.066).abs() < 1e-6);
    let wider = world.grasp("width", 0.08).unwrap();
    assert_eq!(
        wider.outcome,
        Outcome::Reached,
        "what it gripped before does not count"
    );
    let narrower = world.grasp("width", 0.06).unwrap();
    assert_eq!(narrower.outcome, Outcome::Gripped, "not as far as 60 mm");
    assert_eq!(world.grasp("open", 0.0).unwrap().outcome, Outcome::Reached);
}

#[test]
fn an_error_is_reset_and_a_calibration_that_ends_in_one_fails() {
    let mut world = World::new(&Parameters::default(), false);
    world.robot.hand_mut(Side::Left).hold(Some(0.066));
    assert_eq!(
        world.grasp("close", 0.0),
        Err(GraspError::CalibrationFailed)
    );
    world.robot.hand_mut(Side::Left).hold(None);
    world.verbs();
    assert_eq!(world.grasp("close", 0.0).unwrap().outcome, Outcome::Missed);
    assert_eq!(world.verbs(), ["reset", "calibrate", "configure", "go"]);
}

#[test]
fn silence_is_an_error_by_name_before_and_during_a_grasp() {
    let mut world = World::new(&Parameters::default(), true);
    let close = Task::new("close", 0.0, 0.0).unwrap();
    let absent = world.client.begin(close, world.now).unwrap_err();
    assert!(
        absent.to_string().contains("left_gripper/state"),
        "{absent}"
    );
    world.hear();
    world.client.begin(close, world.now).unwrap();
    world.audible = false;
    let begun = world.now;
    assert!(matches!(world.finish(), Err(GraspError::Silent { .. })));
    assert!(world.now - begun < Duration::from_secs(1));
}

#[test]
fn a_gripper_without_power_of_another_kind_or_uncalibrated_is_refused() {
    let mut parameters = Parameters::default();
    parameters.electric.calibrate = false;
    let mut world = World::new(&parameters, false);
    assert_eq!(world.grasp("close", 0.0), Err(GraspError::NotCalibrated));
    world.robot.assembly.enable(false);
    world.robot.step(0.01);
    assert_eq!(world.grasp("close", 0.0), Err(GraspError::NotEnabled));
    let suction = ElectricState {
        id: 65_537,
        ..Default::default()
    };
    world.client.hear(suction, world.now);
    let refusal = world.client.check(world.now).unwrap_err();
    assert!(refusal.to_string().contains("suction"), "{refusal}");
    assert!(world.sent.is_empty());
}

#[test]
fn a_halt_stops_the_fingers_where_they_are() {
    let mut world = World::closing();
    while world.position() > 60.0 {
        if let Step::Send(command) = world.client.step(world.now).unwrap() {
            world.obey(command);
        }
        world.robot.step(TICK.as_secs_f64());
        world.now += TICK;
        world.hear();
    }
    let stop = world.client.halt().unwrap();
    assert_eq!(stop.command, "stop");
    world.obey(stop);
    world.robot.step(1.0);
    assert!(world.position() > 50.0);
    assert_eq!(
        world.client.step(world.now),
        Ok(Step::Wait),
        "the task is over"
    );
}

#[test]
fn a_gripper_that_takes_a_command_but_does_not_end_it_is_named() {
    let mut world = World::closing();
    // Acknowledges everything, moves nothing.
    let error = loop {
        match world.client.step(world.now) {
            Ok(Step::Send(command)) => {
                let state = ElectricState {
                    id: command.id,
                    enabled: Flag::True,
                    calibrated: Flag::True,
                    position: 100.0,
                    sender: command.sender,
                    sequence: command.sequence,
                    ..Default::default()
                };
                world.client.hear(state, world.now);
            }
            Ok(Step::Wait) => {
                let last = ElectricState {
                    id: 65_538,
                    enabled: Flag::True,
                    calibrated: Flag::True,
                    position: 100.0,
                    ..Default::default()
                };
                world.client.hear(last, world.now);
            }
            Ok(Step::Done(grasped)) => panic!("{grasped:?}"),
            Err(error) => break error,
        }
        world.now += TICK;
    };
    assert!(
        matches!(error, GraspError::NotEnded { command: "go", .. }),
        "{error}"
    );
}
