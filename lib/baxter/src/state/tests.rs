use super::*;

const RULES: StateRules = StateRules {
    age_max: Duration::from_millis(500),
    require_ready: true,
    tolerate_error: false,
};

fn refusal(rules: StateRules, value: RobotState) -> Option<StateRefusal> {
    let received = Instant::now();
    rules.check(Some(&Aged { value, received }), received).err()
}

#[test]
fn numbers_of_the_message_survive_the_way_through_the_types() {
    for number in 0..=u8::MAX {
        assert_eq!(u8::from(EstopButton::from(number)), number);
        assert_eq!(u8::from(EstopSource::from(number)), number);
    }
}

#[test]
fn each_bad_state_is_refused_by_its_name() {
    let healthy = RobotState::HEALTHY;
    assert_eq!(refusal(RULES, healthy), None);
    let stopped = true;
    let (enabled, ready) = (false, false);
    for (state, expected) in [
        (RobotState { enabled, ..healthy }, StateRefusal::NotEnabled),
        (RobotState { stopped, ..healthy }, StateRefusal::Stopped),
        (RobotState { ready, ..healthy }, StateRefusal::NotReady),
    ] {
        assert_eq!(refusal(RULES, state), Some(expected));
    }
    let pressed = RobotState {
        enabled: false,
        stopped: true,
        estop_button: EstopButton::Pressed,
        estop_source: EstopSource::Other(77),
        ..healthy
    };
    let text = refusal(RULES, pressed).map(|refusal| refusal.to_string());
    assert!(text.is_some_and(|text| text.contains("button pressed, source 77")));
}

#[test]
fn ready_and_error_are_policies() {
    let lenient = StateRules {
        require_ready: false,
        tolerate_error: true,
        ..RULES
    };
    let faulty = RobotState {
        ready: false,
        error: true,
        ..RobotState::HEALTHY
    };
    assert_eq!(refusal(lenient, faulty), None);
    assert_eq!(refusal(RULES, faulty), Some(StateRefusal::Error));
}

#[test]
fn silence_is_refused_with_its_age() {
    let now = Instant::now();
    assert_eq!(RULES.check(None, now), Err(StateRefusal::Absent));
    let last = Aged::new(RobotState::HEALTHY, now);
    let later = now + Duration::from_millis(510);
    let (age_s, max_s) = (0.51, 0.5);
    assert_eq!(
        RULES.check(Some(&last), later),
        Err(StateRefusal::Stale { age_s, max_s })
    );
}
