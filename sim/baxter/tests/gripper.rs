//! The electric gripper as its clients know it.
#![allow(clippy::unwrap_used, missing_docs)]

use baxter::Side;
use sim_baxter::{Gripper, GripperCommand, GripperCommandError, Kinematics, Parameters, Robot};

const ID: u32 = 65_538;

/// A robot and a client that counts its commands.
struct Client {
    robot: Robot,
    sequence: u32,
}

impl Client {
    fn new(calibrated: bool) -> Self {
        let parameters = Parameters {
            gripper_calibrated: calibrated,
            ..Default::default()
        };
        let kinematics = Kinematics::baxter().unwrap();
        Self {
            robot: Robot::new(&parameters, &kinematics).unwrap(),
            sequence: 0,
        }
    }

    fn gripper(&mut self) -> &mut Gripper {
        self.robot.hand_mut(Side::Left).electric_mut().unwrap()
    }

    /// Sends the command, repeats it at 100 Hz for two seconds as the maker's client does.
    fn send(&mut self, command: &str, args: &str) -> Result<(), GripperCommandError> {
        self.sequence += 1;
        let command = GripperCommand {
            id: ID,
            command: command.into(),
            args: args.into(),
            sender: format!("client_{command}"),
            sequence: self.sequence,
        };
        let answer = self.gripper().command(&command);
        for _ in 0..200 {
            let _ = self.gripper().command(&command);
            self.robot.step(0.01);
        }
        let state = self.gripper().state();
        assert_eq!(
            (&state.sender, state.sequence),
            (&command.sender, command.sequence),
            "echo"
        );
        answer
    }
}

#[test]
fn moves_only_once_calibrated() {
    let mut client = Client::new(false);
    let refusal = client.send("go", r#"{"position": 20}"#).unwrap_err();
    assert!(
        matches!(refusal, GripperCommandError::NotCalibrated(_)),
        "{refusal}"
    );
    assert_eq!(client.gripper().state().position, 100.0);
    client.send("calibrate", "").unwrap();
    assert!(client.gripper().state().calibrated && client.gripper().state().ready);
    client.send("go", r#"{"position": 20}"#).unwrap();
    assert!((client.gripper().state().position - 20.0).abs() < 1e-9);
}

#[test]
fn opening_follows_the_position() {
    let mut client = Client::new(true);
    assert!((client.gripper().opening_m() - 0.0957).abs() < 1e-4);
    client.send("go", r#"{"position": 0}"#).unwrap();
    assert!((client.gripper().opening_m() - 0.054).abs() < 1e-9);
    assert!(
        client.gripper().state().missed,
        "nothing between the fingers"
    );
}

#[test]
fn grips_what_is_between_its_fingers_and_says_so() {
    let mut client = Client::new(true);
    client.gripper().set_object_width(Some(0.066));
    client
        .send("configure", r#"{"velocity": 80, "holding_force": 12}"#)
        .unwrap();
    client.send("grip", "").unwrap();
    let state = client.gripper().state();
    assert!(state.gripping && !state.missed && !state.moving);
    assert_eq!(state.force, 12.0);
    assert!((client.gripper().opening_m() - 0.066).abs() < 1e-9);
    client.send("release", "{}").unwrap();
    assert!(!client.gripper().state().gripping);
    assert_eq!(client.gripper().state().position, 100.0);
}

#[test]
fn calibration_with_something_in_the_way_ends_in_an_error_until_reset() {
    let mut client = Client::new(true);
    client.gripper().set_object_width(Some(0.066));
    client.send("calibrate", "").unwrap();
    let state = client.gripper().state();
    assert!(state.error && !state.calibrated && !state.ready);
    client.gripper().set_object_width(None);
    client.send("reset", "").unwrap();
    client.send("calibrate", "").unwrap();
    assert!(client.gripper().state().ready);
}

#[test]
fn a_disabled_robot_has_a_dead_gripper() {
    let mut client = Client::new(true);
    client.robot.assembly.enable(false);
    client.send("grip", "").unwrap();
    let state = client.gripper().state();
    assert!(!state.enabled && state.position == 100.0);
}

#[test]
fn malformed_commands_are_refused_by_name() {
    let mut client = Client::new(true);
    let mut refusal =
        |command: &str, args: &str| client.send(command, args).unwrap_err().to_string();
    assert!(refusal("jump", "").contains("jump"));
    assert!(refusal("go", "").contains("go"));
    assert!(refusal("go", r#"{"position": 101}"#).contains("position is 101"));
    assert!(refusal("configure", r#"{"velocity": "fast"}"#).contains("fast"));
    let other = GripperCommand {
        id: 1,
        command: "grip".into(),
        args: String::new(),
        sender: "x".into(),
        sequence: 1,
    };
    let refusal = client.gripper().command(&other).unwrap_err();
    assert!(matches!(
        refusal,
        GripperCommandError::OtherId { asked: 1, own: ID }
    ));
}
