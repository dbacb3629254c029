use super::*;

const TICK: Duration = Duration::from_millis(100);

fn statuses(named: &[(&str, u8)]) -> GoalStatusArray {
    let mut array = GoalStatusArray::default();
    for (id, status) in named {
        let mut entry = GoalStatus {
            status: *status,
            ..Default::default()
        };
        entry.goal_id.id = (*id).into();
        array.status_list.push(entry);
    }
    array
}

/// A goal and its server, which says each 0.1 s what `said` gives for the seconds since the start; all that the goal
/// sends, with the time in s, and its end.
fn follow(
    cancelled_s: Option<f64>,
    said: impl Fn(f64) -> Option<GoalStatusArray>,
) -> (Vec<(f64, Send)>, Option<GoalError>) {
    let begun = Instant::now();
    let mut goal = Goal::new("mine", begun);
    let mut sent = Vec::new();
    for tick in 0..600_u32 {
        let (now, now_s) = (begun + tick * TICK, f64::from(tick) / 10.0);
        if cancelled_s.is_some_and(|cancelled_s| now_s >= cancelled_s) {
            goal.cancel(now);
        }
        if let Some(statuses) = said(now_s) {
            goal.on_status(&statuses, now);
        }
        match goal.due(now) {
            Ok(due) => sent.extend(due.map(|send| (now_s, send))),
            Err(error) => return (sent, Some(error)),
        }
    }
    (sent, None)
}

#[test]
fn a_goal_is_sent_again_until_the_server_names_it() {
    let (sent, end) = follow(None, |now_s| {
        Some(match now_s {
            0.0..1.2 => statuses(&[("another", GoalStatus::ACTIVE)]),
            _ => statuses(&[("mine", GoalStatus::ACTIVE)]),
        })
    });
    assert_eq!(sent, [0.0, 0.5, 1.0].map(|now_s| (now_s, Send::Goal)));
    assert_eq!(end, None);
    let (_, end) = follow(None, |_| Some(statuses(&[])));
    assert_eq!(end, Some(GoalError::NotTaken));
}

#[test]
fn a_result_that_was_lost_is_asked_for_by_the_same_goal() {
    let (sent, end) = follow(None, |now_s| {
        Some(match now_s {
            ..0.1 => statuses(&[]),
            0.1..3.0 => statuses(&[("mine", GoalStatus::ACTIVE)]),
            _ => statuses(&[("mine", GoalStatus::SUCCEEDED)]),
        })
    });
    assert_eq!(sent[..3], [0.0, 3.0, 3.5].map(|now_s| (now_s, Send::Goal)));
    assert_eq!(end, Some(GoalError::NoResult));
}

#[test]
fn a_cancellation_is_sent_again_until_the_server_follows_it() {
    let (sent, end) = follow(Some(2.0), |now_s| {
        Some(match now_s {
            ..0.1 => statuses(&[]),
            0.1..3.2 => statuses(&[("mine", GoalStatus::ACTIVE)]),
            _ => statuses(&[("mine", GoalStatus::PREEMPTING)]),
        })
    });
    let cancels = [2.0, 2.5, 3.0].map(|now_s| (now_s, Send::Cancel));
    assert_eq!(sent[1..], cancels);
    assert_eq!(end, Some(GoalError::NotEnded));
    let (_, end) = follow(Some(1.0), |_| {
        Some(statuses(&[("mine", GoalStatus::RECALLING)]))
    });
    assert_eq!(end, Some(GoalError::Recalled));
}

#[test]
fn a_server_that_is_silent_or_forgets_is_named() {
    let (_, end) = follow(None, |now_s| {
        (now_s < 1.0).then(|| statuses(&[("mine", GoalStatus::ACTIVE)]))
    });
    assert_eq!(end, Some(GoalError::Silent));
    let (_, end) = follow(None, |now_s| {
        Some(match now_s {
            0.0..1.0 => statuses(&[("mine", GoalStatus::ACTIVE)]),
            _ => statuses(&[]),
        })
    });
    assert_eq!(end, Some(GoalError::Forgotten));
}
