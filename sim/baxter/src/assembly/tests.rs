use super::*;

#[test]
fn enabling_takes_a_moment_and_disabling_none() {
    let mut robot = Assembly::new(false, true, 0.3);
    robot.enable(true);
    robot.step(0.2);
    robot.enable(true);
    assert!(!robot.state().enabled);
    robot.step(0.11);
    assert!(robot.state().enabled && robot.state().ready);
    robot.enable(false);
    assert!(!robot.state().enabled && !robot.state().ready);
}

#[test]
fn a_stopped_robot_is_enabled_only_after_a_reset() {
    let mut robot = Assembly::new(true, true, 0.3);
    robot.stop();
    assert_eq!(robot.state().estop_button, EstopButton::Unknown);
    robot.enable(true);
    robot.step(1.0);
    assert!(!robot.state().enabled && robot.state().stopped);
    robot.reset();
    assert!(!robot.state().stopped && !robot.state().enabled);
    assert_eq!(robot.state().estop_source, EstopSource::None);
    robot.enable(true);
    robot.step(1.0);
    assert!(robot.allows_motion());
}

#[test]
fn a_held_button_defies_reset_and_a_released_one_waits_for_it() {
    let mut robot = Assembly::new(true, true, 0.3);
    robot.press_estop();
    robot.reset();
    assert!(robot.state().stopped);
    assert_eq!(robot.state().estop_source, EstopSource::User);
    robot.release_estop();
    assert_eq!(robot.state().estop_button, EstopButton::Released);
    assert!(robot.state().stopped);
    robot.reset();
    assert_eq!(robot.state().estop_button, EstopButton::Unpressed);
    assert!(!robot.state().stopped);
}

#[test]
fn a_stop_revokes_an_enabling_under_way() {
    let mut robot = Assembly::new(false, true, 0.3);
    robot.enable(true);
    robot.stop();
    robot.step(1.0);
    assert!(!robot.state().enabled);
}

#[test]
fn an_error_may_stand_while_enabled_but_a_failure_stops() {
    let mut robot = Assembly::new(true, false, 0.3);
    robot.set_error(true);
    assert!(robot.allows_motion() && !robot.state().ready);
    robot.fail();
    assert!(!robot.allows_motion() && robot.state().error);
    assert_eq!(robot.state().estop_source, EstopSource::Fault);
}
