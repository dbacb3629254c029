#![allow(clippy::unwrap_used)]
use super::*;

const RULES: PassageRules = PassageRules {
    range_min_rad: 1.0,
    spacing_rad: 0.1,
};

/// A wrist with joint states at 100 Hz and clouds at 33 Hz, which come so late.
struct Player {
    passages: Passages<u64>,
    now_ms: u64,
    angle_rad: f64,
    late_ms: u64,
    sweeps: Vec<Vec<PassageView<u64>>>,
}

impl Player {
    fn new(late_ms: u64) -> Self {
        Self {
            passages: Passages::new(RULES),
            now_ms: 0,
            angle_rad: 0.0,
            late_ms,
            sweeps: vec![],
        }
    }

    fn tick(&mut self) {
        self.now_ms += 10;
        let sample = JointSample {
            angle_rad: self.angle_rad,
            velocity_rad_s: None,
            stamp: Duration::from_millis(self.now_ms),
        };
        self.sweeps.extend(self.passages.on_joint(&sample));
        if self.now_ms.is_multiple_of(30) && self.now_ms > self.late_ms {
            let stamp_ms = self.now_ms - self.late_ms;
            let stamp = Duration::from_millis(stamp_ms);
            self.sweeps.extend(self.passages.on_cloud(stamp, stamp_ms));
        }
    }

    /// Turns by 0.01 rad in each of these ticks, without a rest.
    fn turn(&mut self, ticks: usize) {
        for _ in 0..ticks {
            self.angle_rad += 0.01;
            self.tick();
        }
    }

    fn go(&mut self, target_rad: f64) {
        while (self.angle_rad - target_rad).abs() > 1e-9 {
            self.angle_rad += (target_rad - self.angle_rad).clamp(-0.01, 0.01);
            self.tick();
        }
        (0..40).for_each(|_| self.tick());
    }
}

#[test]
fn a_sweep_is_found_in_either_direction_and_a_step_is_none() {
    for late_ms in [0, 30, 60] {
        let mut player = Player::new(late_ms);
        (0..40).for_each(|_| player.tick());
        [0.6, 1.2, 0.0, 1.2]
            .into_iter()
            .for_each(|to_rad| player.go(to_rad));
        assert_eq!(player.sweeps.len(), 2, "late by {late_ms} ms");
        for (sweep, direction) in player.sweeps.iter().zip([-1.0, 1.0]) {
            assert!((11..=13).contains(&sweep.len()), "{}", sweep.len());
            for pair in sweep.windows(2) {
                let turned_rad = direction * (pair[1].angle_rad - pair[0].angle_rad);
                assert!((0.05..0.15).contains(&turned_rad), "{turned_rad}");
                assert!(pair[0].rate_rad_s * direction > 0.0);
            }
        }
    }
}

#[test]
fn a_wrist_that_turns_back_at_once_makes_two_sweeps() {
    let mut player = Player::new(0);
    player.turn(130);
    player.go(-0.2);
    assert_eq!(player.sweeps.len(), 2);
}

#[test]
fn a_reset_does_not_mix_two_pasts() {
    let mut player = Player::new(0);
    player.turn(90);
    player.passages.reset();
    player.go(1.6);
    assert!(player.sweeps.is_empty());
}
