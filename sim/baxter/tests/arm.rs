//! The laws of the arm: when it moves, how fast, and when it stops.
#![allow(clippy::unwrap_used, missing_docs)]

use baxter::Side;
use sim_baxter::{CommandError, Kinematics, Parameters, Robot};

const POSITION: i32 = 1;
const VELOCITY: i32 = 2;
const RAW_POSITION: i32 = 4;
const W2: usize = 6;
const W2_VELOCITY_MAX_RAD_S: f64 = 4.0;

/// A robot whose W2 starts at 0.
fn robot(mut parameters: Parameters) -> Robot {
    parameters.scan_pose.left_arm_rad.left_w2 = 0.0;
    parameters.validate().unwrap();
    let kinematics = Kinematics::baxter().unwrap();
    Robot::new(&parameters, &kinematics).unwrap()
}

fn names() -> Vec<String> {
    Side::Left.joint_names().map(String::from).to_vec()
}

fn command_w2(robot: &mut Robot, mode: i32, value: f64) -> Result<(), CommandError> {
    robot.command_arm(Side::Left, mode, &["left_w2".to_owned()], &[value])
}

fn w2(robot: &Robot) -> f64 {
    robot.arm(Side::Left).angles_rad()[W2]
}

fn w2_velocity(robot: &Robot) -> f64 {
    robot.arm(Side::Left).velocities_rad_s()[W2]
}

/// Commands W2 at 100 Hz for a while; returns the largest speed seen, rad/s.
fn drive(robot: &mut Robot, mode: i32, value: f64, duration_s: f64) -> f64 {
    let mut fastest = 0.0_f64;
    for _ in 0..(duration_s * 100.0) as usize {
        let _ = command_w2(robot, mode, value);
        for _ in 0..10 {
            robot.step(1e-3);
            fastest = fastest.max(w2_velocity(robot).abs());
        }
    }
    fastest
}

#[test]
fn does_not_move_unless_enabled() {
    let mut robot = robot(Parameters {
        enabled: false,
        ..Default::default()
    });
    assert_eq!(
        command_w2(&mut robot, POSITION, 0.5),
        Err(CommandError::NotEnabled)
    );
    drive(&mut robot, POSITION, 0.5, 1.0);
    assert_eq!(w2(&robot), 0.0);
    robot.assembly.enable(true);
    drive(&mut robot, POSITION, 0.5, 2.0);
    assert!((w2(&robot) - 0.5).abs() < 1e-3);
}

#[test]
fn position_mode_keeps_to_the_speed_ratio_and_raw_mode_to_the_joint_limit() {
    let mut robot = robot(Parameters::default());
    let fastest = drive(&mut robot, POSITION, 2.0, 3.0);
    assert!((w2(&robot) - 2.0).abs() < 1e-3);
    assert!(
        fastest <= 0.3 * W2_VELOCITY_MAX_RAD_S + 1e-9 && fastest > 1.1,
        "{fastest}"
    );
    robot.arm_mut(Side::Left).set_speed_ratio(7.0);
    assert_eq!(robot.arm(Side::Left).speed_ratio(), 1.0);
    robot.arm_mut(Side::Left).set_speed_ratio(f64::NAN);
    robot.arm_mut(Side::Left).set_speed_ratio(0.1);
    let fastest = drive(&mut robot, POSITION, -2.0, 2.0);
    assert!(fastest <= 0.1 * W2_VELOCITY_MAX_RAD_S + 1e-9, "{fastest}");
    let fastest = drive(&mut robot, RAW_POSITION, -2.0, 2.0);
    assert!(
        fastest <= W2_VELOCITY_MAX_RAD_S + 1e-9 && fastest > 3.0,
        "{fastest}"
    );
}

#[test]
fn velocity_mode_moves_at_the_velocity_and_stops_at_the_joint_limit() {
    let mut robot = robot(Parameters::default());
    drive(&mut robot, VELOCITY, 0.5, 1.0);
    assert!((w2_velocity(&robot) - 0.5).abs() < 1e-9);
    let fastest = drive(&mut robot, VELOCITY, 99.0, 3.0);
    assert!(fastest <= W2_VELOCITY_MAX_RAD_S + 1e-9);
    assert!((w2(&robot) - 3.059).abs() < 1e-3);
}

#[test]
fn angles_beyond_the_joint_limits_are_clipped() {
    let mut robot = robot(Parameters::default());
    drive(&mut robot, POSITION, 5.0, 5.0);
    assert!((w2(&robot) - 3.059).abs() < 1e-3 && w2(&robot) <= 3.059);
}

#[test]
fn a_command_takes_effect_after_the_controller_delay() {
    let mut robot = robot(Parameters::default());
    command_w2(&mut robot, POSITION, 0.5).unwrap();
    robot.step(0.004);
    assert_eq!(w2(&robot), 0.0);
    robot.step(0.003);
    assert!(w2(&robot) > 0.0);
}

#[test]
fn holds_its_angles_when_the_commander_falls_silent() {
    let mut robot = robot(Parameters::default());
    drive(&mut robot, POSITION, 2.0, 0.5);
    robot.step(0.19);
    assert!(w2_velocity(&robot) > 1.0, "still obeys within 0.2 s");
    robot.step(0.1);
    let held = w2(&robot);
    assert!(held < 1.5 && w2_velocity(&robot) == 0.0);
    robot.step(2.0);
    assert_eq!(w2(&robot), held);

    robot.arm_mut(Side::Left).set_command_timeout(0.05);
    drive(&mut robot, POSITION, -2.0, 0.5);
    robot.step(0.1);
    assert_eq!(w2_velocity(&robot), 0.0, "the timeout can be shortened");
}

#[test]
fn an_emergency_stop_in_mid_motion_stops_and_forgets_the_old_target() {
    let mut robot = robot(Parameters::default());
    drive(&mut robot, POSITION, 2.0, 0.5);
    robot.assembly.press_estop();
    let pressed_at = w2(&robot);
    drive(&mut robot, POSITION, 2.0, 0.1);
    let stopped_at = w2(&robot);
    assert!(w2_velocity(&robot) == 0.0 && stopped_at - pressed_at < 0.03);
    robot.assembly.release_estop();
    robot.assembly.reset();
    robot.assembly.enable(true);
    robot.step(1.0);
    assert!(robot.assembly.allows_motion());
    assert_eq!(
        w2(&robot),
        stopped_at,
        "no jump to the old target once enabled again"
    );
}

#[test]
fn a_held_cuff_stops_the_arm() {
    let mut robot = robot(Parameters::default());
    drive(&mut robot, POSITION, 2.0, 0.5);
    robot.hold_cuff(Side::Left, true);
    assert_eq!(
        command_w2(&mut robot, POSITION, 2.0),
        Err(CommandError::CuffHeld)
    );
    robot.step(0.1);
    assert_eq!(w2_velocity(&robot), 0.0);
}

#[test]
fn malformed_commands_are_refused_by_name_and_change_nothing() {
    let mut robot = robot(Parameters::default());
    let mut refusal = |mode, names: &[&str], values: &[f64]| {
        let names: Vec<String> = names.iter().map(|name| name.to_string()).collect();
        robot
            .command_arm(Side::Left, mode, &names, values)
            .unwrap_err()
    };
    assert_eq!(refusal(3, &["left_w2"], &[0.1]), CommandError::Mode(3));
    let unequal = CommandError::UnequalLengths {
        names: 2,
        values: 1,
    };
    assert_eq!(refusal(POSITION, &["left_w1", "left_w2"], &[0.1]), unequal);
    let unknown = CommandError::UnknownJoint("right_w2".into());
    assert_eq!(
        refusal(POSITION, &["left_w1", "right_w2"], &[0.1, 0.1]),
        unknown
    );
    let twice = CommandError::NamedTwice("left_w2".into());
    assert_eq!(
        refusal(POSITION, &["left_w2", "left_w2"], &[0.1, 0.2]),
        twice
    );
    let error = refusal(POSITION, &["left_w1", "left_w2"], &[0.1, f64::NAN]);
    assert!(matches!(error, CommandError::NotFinite { joint, .. } if joint == "left_w2"));
    let before = robot.arm(Side::Left).angles_rad();
    robot.step(0.1);
    assert_eq!(robot.arm(Side::Left).angles_rad(), before);
}

#[test]
fn names_are_looked_up_in_any_order() {
    let mut robot = robot(Parameters::default());
    let start = robot.arm(Side::Left).angles_rad();
    let (mut names, mut values) = (names(), start.to_vec());
    values[W2] = 0.3;
    names.reverse();
    values.reverse();
    for _ in 0..100 {
        robot
            .command_arm(Side::Left, POSITION, &names, &values)
            .unwrap();
        robot.step(0.01);
    }
    let end = robot.arm(Side::Left).angles_rad();
    assert!((end[W2] - 0.3).abs() < 1e-3);
    assert_eq!(end[..W2], start[..W2]);
}

#[test]
fn joint_states_are_the_17_names_in_order_with_a_little_seeded_noise() {
    let mut one = robot(Parameters::default());
    let mut two = one.clone();
    let states = one.joint_states();
    assert_eq!(states, two.joint_states(), "same seed, same noise");
    assert_eq!(states.names.len(), 17);
    assert!(states.names.is_sorted());
    assert_eq!(
        (states.names[0], states.names[16]),
        ("head_nod", "torso_t0")
    );
    assert_eq!(states.positions[16], -12.566);
    assert_eq!(states.velocities.len(), 17);
    let e0 = states
        .names
        .iter()
        .position(|name| *name == "left_e0")
        .unwrap();
    let error_rad = (states.positions[e0] - -1.435).abs();
    assert!(error_rad > 0.0 && error_rad < 5e-4, "{error_rad}");

    let silent = Parameters {
        position_noise_rad: 0.0,
        ..Default::default()
    };
    let exact = robot(silent).joint_states();
    assert_eq!(exact.positions[e0], -1.435);
    assert_eq!(
        one.finger_joint_states(Side::Left).unwrap().names,
        ["l_gripper_l_finger_joint"]
    );
}

#[test]
fn head_turns_within_its_range_and_only_while_enabled() {
    let mut robot = robot(Parameters::default());
    robot.command_head(9.0, 1.0);
    robot.step(0.5);
    assert!(robot.head_pan().1);
    robot.step(3.0);
    assert!((robot.head_pan().0 - 1.3963).abs() < 1e-3 && !robot.head_pan().1);
    robot.assembly.stop();
    robot.command_head(0.0, 1.0);
    robot.step(3.0);
    assert!((robot.head_pan().0 - 1.3963).abs() < 1e-3);
}

#[test]
fn endpoint_is_the_fingertips() {
    let robot = robot(Parameters::default());
    let tip = robot.base_from_gripper(Side::Left).translation.vector;
    assert!((tip.z - (0.461 + 0.1577)).abs() < 2e-3, "{tip:?}");
}
