//! What counts as a view and as a scan, and what does not.

#![allow(clippy::unwrap_used)]
use super::*;
use crate::rests::{RestRules, Rests};
use baxter::JointSample;
use std::time::Duration;

/// A wrist that is moved, joint states at 100 Hz and clouds at 33 Hz, each delivered when it arrives.
struct Player {
    rests: Rests<u64>,
    sweep: Sweep<u64>,
    now_ms: u64,
    angle_rad: f64,
    joints_late_ms: u64,
    clouds_late_ms: u64,
    on_the_way: Vec<(u64, Message)>,
    views: Vec<ScanView<u64>>,
}

fn rest_rules() -> RestRules {
    RestRules {
        rest_velocity_rad_s: 0.02,
        dwell: Duration::from_millis(30),
        separation_rad: 0.1,
    }
}

#[derive(Clone, Copy)]
enum Message {
    Joint(JointSample),
    Cloud(u64),
}

impl Player {
    fn new() -> Self {
        Self::late(0, 5)
    }

    fn late(joints_late_ms: u64, clouds_late_ms: u64) -> Self {
        let rules = SweepRules {
            view_count: 3,
            separation_rad: 0.1,
        };
        Self {
            rests: Rests::new(rest_rules()),
            sweep: Sweep::new(rules),
            now_ms: 0,
            angle_rad: 0.0,
            joints_late_ms,
            clouds_late_ms,
            on_the_way: Vec::new(),
            views: Vec::new(),
        }
    }

    fn tick(&mut self) {
        self.now_ms += 10;
        let wobble_rad = if self.now_ms.is_multiple_of(20) {
            1e-4
        } else {
            0.0
        };
        let joint = sample(self.now_ms, self.angle_rad + wobble_rad);
        let arrives_ms = self.now_ms + self.joints_late_ms;
        self.on_the_way.push((arrives_ms, Message::Joint(joint)));
        if self.now_ms.is_multiple_of(30) {
            let arrives_ms = self.now_ms + self.clouds_late_ms;
            self.on_the_way
                .push((arrives_ms, Message::Cloud(self.now_ms)));
        }
        self.deliver();
    }

    fn deliver(&mut self) {
        let mut due: Vec<_> = self
            .on_the_way
            .extract_if(.., |(arrives_ms, _)| *arrives_ms <= self.now_ms)
            .collect();
        due.sort_by_key(|(arrives_ms, _)| *arrives_ms);
        for (_, message) in due {
            let view = match message {
                Message::Joint(joint) => self.rests.on_joint(joint),
                Message::Cloud(stamp_ms) => self
                    .rests
                    .on_cloud(Duration::from_millis(stamp_ms), stamp_ms),
            };
            let views = view.map(|view| self.sweep.add(view)).unwrap_or_default();
            self.views.extend(views);
        }
    }

    /// Turns, and rests there.
    fn go(&mut self, target_rad: f64, rest_ms: u64) {
        while (self.angle_rad - target_rad).abs() > 1e-9 {
            let step_rad = (target_rad - self.angle_rad).clamp(-0.012, 0.012);
            self.angle_rad += step_rad;
            self.tick();
        }
        (0..rest_ms / 10).for_each(|_| self.tick());
    }

    /// The angles of each scan so far, in tenths of a radian, in the order in which they were handed out.
    fn tenths(&self) -> Vec<Vec<i32>> {
        let mut scans: Vec<Vec<i32>> = Vec::new();
        for found in &self.views {
            if found.index == 0 {
                scans.push(Vec::new());
            }
            let scan = scans.last_mut().unwrap();
            assert_eq!(scan.len(), found.index);
            scan.push((found.view.angle_rad * 10.0).round() as i32);
        }
        scans
    }

    fn has_begun(&self) -> bool {
        !self.sweep.run.is_empty()
    }
}

fn sample(stamp_ms: u64, angle_rad: f64) -> JointSample {
    JointSample {
        angle_rad,
        velocity_rad_s: None,
        stamp: Duration::from_millis(stamp_ms),
    }
}

/// Its image may be older than the first transform: nobody knows where the hand was.
#[test]
fn a_view_that_is_taken_back_gives_way_to_a_later_cloud_of_the_rest() {
    let mut rests = Rests::new(rest_rules());
    let mut views = Vec::new();
    for now_ms in (0..300).step_by(10) {
        let mut seen = rests.on_joint(sample(now_ms, 0.7));
        if now_ms % 30 == 0 {
            let of_cloud = rests.on_cloud(Duration::from_millis(now_ms), now_ms);
            assert!(seen.is_none() || of_cloud.is_none());
            seen = seen.or(of_cloud);
        }
        if let Some(view) = seen {
            if view.cloud < 150 {
                rests.take_back(Duration::from_millis(view.cloud));
            }
            views.push((view.cloud, view.moved));
        }
    }
    let stamps: Vec<u64> = views.iter().map(|view| view.0).collect();
    assert!(stamps.is_sorted() && stamps.len() > 2, "{stamps:?}");
    assert_eq!(stamps.iter().filter(|stamp| **stamp >= 150).count(), 1);
    assert!(views.iter().all(|view| view.1), "{views:?}");
}

#[test]
fn active_scans_are_found_again() {
    let mut player = Player::new();
    player.go(0.0, 600);
    for _ in 0..3 {
        [-0.6, 0.0, 0.6]
            .into_iter()
            .for_each(|angle_rad| player.go(angle_rad, 600));
    }
    assert_eq!(player.tenths(), vec![vec![-6, 0, 6]; 3]);
}

/// As short as wrist_rotator's own; a view is seen in the rest itself, not while the wrist slows down.
#[test]
fn short_rests_count_whatever_is_late() {
    let views = |joints_late_ms, clouds_late_ms| {
        let mut player = Player::late(joints_late_ms, clouds_late_ms);
        for _ in 0..20 {
            [-0.6, 0.0, 0.6]
                .into_iter()
                .for_each(|angle_rad| player.go(angle_rad, 70));
        }
        player.go(1.0, 600);
        player.views
    };
    let on_time = views(0, 0);
    assert_eq!(on_time.len(), 60);
    for joints_late_ms in (0..=80).step_by(10) {
        for clouds_late_ms in (0..=200).step_by(10) {
            let late = views(joints_late_ms, clouds_late_ms);
            assert_eq!(
                late, on_time,
                "joints {joints_late_ms}, clouds {clouds_late_ms}"
            );
        }
    }
}

#[test]
fn nothing_is_taken_in_motion_or_too_early() {
    let mut player = Player::new();
    for i in 0..300 {
        player.angle_rad = 5e-4 * f64::from(i);
        player.tick();
    }
    (0..3).for_each(|_| player.tick());
    assert!(!player.has_begun());
    (0..10).for_each(|_| player.tick());
    assert!(player.has_begun() && player.views.is_empty());
}

#[test]
fn a_cloud_counts_only_if_the_wrist_was_still_at_rest() {
    let mut rests = Player::new().rests;
    for (stamp_ms, angle_rad) in [(0, 0.0), (300, 0.0), (600, 0.0)] {
        rests.on_joint(sample(stamp_ms, angle_rad));
    }
    assert_eq!(rests.on_cloud(Duration::from_millis(610), 1), None);
    assert_eq!(rests.on_joint(sample(620, 0.5)), None);
    let late = rests.on_cloud(Duration::from_millis(600), 2);
    assert_eq!(
        late.map(|view| view.cloud),
        Some(2),
        "of the rest, though it comes late"
    );
}

#[test]
fn a_reset_does_not_mix_two_scans() {
    let mut player = Player::new();
    player.go(-0.6, 600);
    player.go(0.0, 600);
    player.rests.reset();
    player.sweep.reset();
    [0.6, -0.6, 0.0, 0.6]
        .into_iter()
        .for_each(|angle_rad| player.go(angle_rad, 600));
    // The rest at 0.0 that lasts counts again: nothing is known of the time before the jump.
    assert_eq!(player.tenths(), [vec![-6, 0, 6]]);
}

#[test]
fn other_rules_begin_anew_and_the_same_change_nothing() {
    let mut player = Player::new();
    let rules = player.sweep.rules.clone();
    player.go(-0.6, 600);
    player.go(0.0, 600);
    player.sweep.set_rules(rules.clone());
    player.go(0.6, 600);
    player.go(0.0, 600);
    let view_count = 2;
    player.sweep.set_rules(SweepRules {
        view_count,
        ..rules
    });
    player.go(0.3, 600);
    player.go(0.6, 600);
    assert_eq!(player.tenths(), [vec![-6, 0, 6], vec![3, 6]]);
}

#[test]
fn one_view_makes_a_scan_where_one_is_asked_for() {
    let mut player = Player::new();
    player.sweep.rules.view_count = 1;
    player.go(0.0, 600);
    player.go(0.5, 600);
    player.go(0.0, 600);
    assert_eq!(player.tenths(), [[0], [5], [0]]);
}

#[test]
fn a_twitch_is_neither_a_view_nor_a_scan() {
    let mut player = Player::new();
    for angle_rad in [-0.6, 0.0, 0.6] {
        player.go(angle_rad, 300);
        player.go(angle_rad + 0.02, 0);
        player.go(angle_rad, 300);
    }
    player.go(0.9, 0);
    assert_eq!(player.tenths(), [[-6, 0, 6]]);
    assert!(!player.has_begun());
}

#[test]
fn views_are_handed_out_as_they_come() {
    let mut player = Player::new();
    player.sweep.rules.view_count = 20;
    for step in 0..20_u32 {
        player.go(-1.0 + 0.12 * f64::from(step), 100);
        let expected = if step < 2 { 0 } else { step as usize + 1 };
        assert_eq!(player.views.len(), expected);
    }
}

#[test]
fn a_wrist_that_turns_back_gives_the_scan_up_and_begins_another() {
    let mut player = Player::new();
    player.sweep.rules.view_count = 4;
    [-0.6, 0.0, 0.6, 0.0, -0.6, -1.2]
        .into_iter()
        .for_each(|angle_rad| player.go(angle_rad, 600));
    assert_eq!(player.tenths(), [vec![-6, 0, 6], vec![6, 0, -6, -12]]);
    let scans: Vec<_> = player.views.iter().map(|found| found.scan).collect();
    assert_eq!(scans, [0, 0, 0, 1, 1, 1, 1]);
}
