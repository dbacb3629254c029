use super::*;

#[test]
fn what_is_left_follows_the_pace_of_what_was_computed() {
    use Part::{Dent, Load, Look, Mesh, Record};
    let mut state = State::new(&[Record, Mesh, Dent, Look, Load]);
    assert_eq!((state.over_s(), state.left_s(0.0)), (0.0, 26.0));
    state.begin(Record, 4, 0.0);
    assert_eq!(state.left_s(4.0), 6.0 + 16.0);
    state.done = 2;
    assert_eq!((state.over_s(), state.left_s(20.0)), (5.0, 20.0 + 16.0));
    // Neither the robot's time nor a mesh that is there already says anything of the others' pace.
    state.begin(Mesh, 1, 50.0);
    assert_eq!(state.left_s(0.0), 16.0);
    state.begin(Dent, 10, 0.1);
    assert_eq!((state.over_s(), state.left_s(0.0)), (13.0, 13.0));
    state.done = 5;
    assert_eq!(state.left_s(4.0), 4.0 + 11.0);
    state.begin(Look, 1, 8.0);
    assert_eq!(state.left_s(0.0), 4.0 * 10.0 + 1.0);
    state.begin(Load, 1, 40.0);
    assert_eq!(state.left_s(7.0), 0.0);
}

#[test]
fn a_time_is_said_no_finer_than_it_is_known() {
    let said = [0.4, 7.3, 43.0].map(left);
    assert_eq!(said, ["almost done", "about 7 s left", "about 45 s left"]);
}
