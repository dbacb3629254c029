#![allow(clippy::unwrap_used)]
use super::*;

const S: i64 = 1_000_000_000;

fn id(name: &str, stamp_s: i64) -> GoalId {
    GoalId {
        id: name.into(),
        stamp_ns: stamp_s * S,
    }
}

/// Goals, and the time that does not pass unless a test says so.
struct Bench {
    goals: Goals<u32>,
    now: Instant,
}

impl Bench {
    fn new() -> Self {
        Self {
            goals: Goals::new(),
            now: Instant::now(),
        }
    }

    fn running(name: &str, stamp_s: i64) -> Self {
        let mut bench = Self::new();
        bench.receive(name, stamp_s);
        bench.start();
        bench
    }

    fn receive(&mut self, name: &str, stamp_s: i64) -> Vec<(String, Status)> {
        statuses(self.goals.receive(id(name, stamp_s), 3, self.now))
    }

    fn cancel(&mut self, name: &str, stamp_s: i64) -> Vec<(String, Status)> {
        statuses(self.goals.cancel(&id(name, stamp_s), self.now))
    }

    fn finish(&mut self, outcome: Outcome) -> (String, Status) {
        let state = self.goals.finish(outcome, "", self.now).unwrap();
        (state.id.id, state.status)
    }

    fn start(&mut self) -> Option<String> {
        self.goals.start().map(|(id, _)| id.id)
    }

    fn statuses(&mut self) -> Vec<(String, Status)> {
        statuses(self.goals.list(self.now))
    }
}

fn statuses(states: Vec<GoalState>) -> Vec<(String, Status)> {
    let named = |state: GoalState| (state.id.id, state.status);
    states.into_iter().map(named).collect()
}

fn is(name: &str, status: Status) -> (String, Status) {
    (name.into(), status)
}

#[test]
fn a_goal_waits_runs_ends_and_is_forgotten() {
    let mut bench = Bench::new();
    assert!(bench.receive("a", 10).is_empty());
    assert_eq!(bench.statuses(), [is("a", Status::Pending)]);
    assert_eq!(bench.start().as_deref(), Some("a"));
    assert_eq!(bench.start(), None, "one at a time");
    assert_eq!(bench.statuses(), [is("a", Status::Active)]);
    assert_eq!(bench.finish(Outcome::Succeeded), is("a", Status::Succeeded));
    assert!(
        bench
            .goals
            .finish(Outcome::Succeeded, "", bench.now)
            .is_none(),
        "ends once"
    );
    assert_eq!(bench.statuses(), [is("a", Status::Succeeded)]);
    bench.now += REMEMBERED;
    assert!(bench.statuses().is_empty());
}

#[test]
fn a_new_goal_preempts_the_running_one_and_replaces_the_waiting_one() {
    let mut bench = Bench::running("a", 10);
    assert!(!bench.goals.is_preempting());
    assert!(bench.receive("b", 11).is_empty());
    assert!(bench.goals.is_preempting());
    assert_eq!(bench.receive("c", 12), [is("b", Status::Recalled)]);
    assert_eq!(bench.start(), None, "a is not at its end yet");
    assert_eq!(bench.finish(Outcome::Preempted), is("a", Status::Preempted));
    assert_eq!(bench.start().as_deref(), Some("c"));
    assert!(!bench.goals.is_preempting());
}

#[test]
fn a_goal_that_ends_well_while_it_is_preempted_has_succeeded() {
    let mut bench = Bench::running("a", 10);
    bench.cancel("a", 0);
    assert_eq!(bench.finish(Outcome::Succeeded), is("a", Status::Succeeded));
}

#[test]
fn a_waiting_goal_is_cancelled_by_name_by_stamp_and_with_all() {
    for (name, stamp_s, is_cancelled) in [
        ("", 0, true),
        ("a", 0, false),
        ("b", 0, true),
        ("", 11, true),
        ("", 10, false),
        ("a", 11, true),
    ] {
        let mut bench = Bench::running("a", 10);
        bench.receive("b", 11);
        let recalled = vec![is("b", Status::Recalled); usize::from(is_cancelled)];
        assert_eq!(bench.cancel(name, stamp_s), recalled, "{name} {stamp_s}");
        bench.finish(Outcome::Preempted);
        assert_eq!(bench.start().is_some(), !is_cancelled);
    }
}

#[test]
fn a_running_goal_is_cancelled_by_name_by_stamp_and_with_all() {
    for (name, stamp_s, is_cancelled) in [
        ("", 0, true),
        ("a", 0, true),
        ("other", 0, false),
        ("", 10, true),
        ("", 9, false),
        ("other", 10, true),
    ] {
        let mut bench = Bench::running("a", 10);
        assert!(bench.cancel(name, stamp_s).is_empty());
        assert_eq!(
            bench.goals.is_preempting(),
            is_cancelled,
            "{name} {stamp_s}"
        );
    }
}

#[test]
fn a_cancellation_may_overtake_its_goal() {
    let mut bench = Bench::new();
    bench.cancel("late", 0);
    assert_eq!(bench.statuses(), [is("late", Status::Recalling)]);
    assert_eq!(bench.receive("late", 10), [is("late", Status::Recalled)]);
    assert_eq!(bench.start(), None);
    bench.cancel("", 20);
    assert_eq!(bench.receive("old", 15), [is("old", Status::Recalled)]);
    assert!(bench.receive("young", 21).is_empty());
    bench.start();
    bench.goals.forget_stamps();
    assert!(bench.receive("after a jump back", 3).is_empty());
    assert!(bench.goals.is_preempting());
}

#[test]
fn goals_count_once_and_in_the_order_of_their_stamps() {
    let mut bench = Bench::running("a", 10);
    assert!(bench.receive("a", 10).is_empty());
    assert!(
        !bench.goals.is_preempting(),
        "the same goal again does not preempt itself"
    );
    assert_eq!(bench.receive("older", 9), [is("older", Status::Recalled)]);
    assert!(!bench.goals.is_preempting());
    bench.finish(Outcome::Aborted);
    assert_eq!(bench.receive("a", 10), [], "nor does it run again");
    assert_eq!(bench.start(), None);
}

#[test]
fn a_server_that_ends_takes_no_more_goals() {
    let mut bench = Bench::new();
    bench.receive("a", 1);
    let ended = bench.goals.close("the node is shutting down", bench.now);
    assert_eq!((ended.len(), ended[0].status), (1, Status::Recalled));
    assert_eq!(bench.receive("b", 2), [("b".to_owned(), Status::Recalled)]);
    assert_eq!(bench.goals.start(), None);
}
