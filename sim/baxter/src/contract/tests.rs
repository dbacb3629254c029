use super::*;

fn violations(angles_rad: &[f64], pause: impl Fn(usize) -> f64) -> String {
    let mut contract = Contract::new(Side::Left);
    let mut time_s = 1.0;
    let mut arm_rad = [0.0; JOINTS_PER_ARM];
    for (index, angle_rad) in angles_rad.iter().enumerate() {
        let mut setpoint = Setpoint::default();
        setpoint[6] = Some(*angle_rad);
        contract.receive(setpoint, &arm_rad, time_s);
        arm_rad[6] = *angle_rad;
        time_s += pause(index);
    }
    contract.forbid(None, true, time_s + 1.0);
    contract.take_violations().join("; ")
}

/// From rest to rest with a cosine: at most 0.79 rad/s, 2.5 rad/s².
fn smooth() -> Vec<f64> {
    let turned = |tick: i32| 0.25 - 0.25 * (std::f64::consts::PI * f64::from(tick) / 100.0).cos();
    (0..=100).map(turned).collect()
}

#[test]
fn smooth_setpoints_are_none_even_where_they_arrive_in_bursts() {
    assert_eq!(violations(&smooth(), |_| 0.01), "");
    let bursts = |index| if index % 10 == 9 { 0.1 } else { 0.0 };
    let periodic = |index| if index < 50 { 0.01 } else { bursts(index) };
    assert_eq!(violations(&smooth(), periodic), "");
}

#[test]
fn jumps_and_abrupt_ends_are_named() {
    let mut jump = smooth();
    jump.extend([0.52; 5]);
    let text = violations(&jump, |_| 0.01);
    assert!(text.contains("left_w2 is not smooth"), "{text}");
    let text = violations(&smooth()[..50], |_| 0.01);
    assert!(text.contains("left_w2 ends at speed"), "{text}");
    let text = violations(&[0.2; 5], |_| 0.01);
    assert!(text.contains("begins 0.200 rad from the arm"), "{text}");
    let text = violations(&[3.2; 5], |_| 0.01);
    assert!(text.contains("commanded to 3.200 rad"), "{text}");
}

#[test]
fn going_on_at_speed_after_a_pause_is_a_jump() {
    let text = violations(&smooth(), |index| if index == 50 { 0.15 } else { 0.01 });
    assert!(text.contains("is not smooth"), "{text}");
}

#[test]
fn what_forbids_motion_ends_it() {
    let mut contract = Contract::new(Side::Left);
    let setpoint = [Some(0.0); JOINTS_PER_ARM];
    let arm_rad = [0.0; JOINTS_PER_ARM];
    contract.forbid(Some("the cuff is held"), false, 1.0);
    contract.receive(setpoint, &arm_rad, 1.4);
    assert_eq!(contract.take_violations(), Vec::<String>::new());
    contract.forbid(Some("the cuff is held"), false, 1.5);
    contract.receive(setpoint, &arm_rad, 1.6);
    assert_eq!(
        contract.take_violations(),
        ["left arm: commanded although the cuff is held"]
    );
}

/// The robot forgets its last setpoint while the cuff is held, and the arm comes to rest behind it.
#[test]
fn after_a_cuff_was_held_the_next_motion_begins_where_the_arm_is() {
    let begin = |pause_s: f64| {
        let mut contract = Contract::new(Side::Left);
        let mut time_s = 1.0;
        let setpoint = |angle_rad: f64| {
            let mut setpoint = Setpoint::default();
            setpoint[6] = Some(angle_rad);
            setpoint
        };
        let mut arm_rad = [0.0; JOINTS_PER_ARM];
        for angle_rad in &smooth()[..50] {
            contract.receive(setpoint(*angle_rad), &arm_rad, time_s);
            arm_rad[6] = *angle_rad;
            time_s += 0.01;
        }
        contract.forbid(Some("the cuff is held"), false, time_s);
        arm_rad[6] -= 0.025;
        time_s += pause_s;
        contract.forbid(None, true, time_s);
        for _ in 0..20 {
            contract.receive(setpoint(arm_rad[6]), &arm_rad, time_s);
            time_s += 0.01;
        }
        contract.forbid(None, true, time_s + 1.0);
        contract.take_violations().join("; ")
    };
    assert_eq!(begin(0.15), "");
    let text = begin(0.02);
    assert!(text.contains("left_w2 is not smooth"), "{text}");
}
