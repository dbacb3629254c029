//! Finds sweeps in what somebody else makes the wrist do, and the views in them.
//!
//! A sweep is a turn in one direction without a rest. It is handed out when it has ended, and only where it was wide enough: a
//! wrist that goes to the begin of a scan, or from view to view, makes no scan by that. All decisions rest on stamps: a
//! recording played twice as fast gives the same views.

use std::collections::VecDeque;
use std::time::Duration;

use baxter::JointSample;

use crate::plan::VIEWS_MAX;
use crate::wrist_track::WristTrack;

/// Clouds that wait for the joint states of their time, at most: 0.13 s at 30 Hz.
const CLOUDS_KEPT: usize = 4;
/// Slowest rate of a sweep, rad/s.
const RATE_MIN_RAD_S: f64 = 0.05;

/// What makes a sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassageRules {
    /// Least turn, rad.
    pub range_min_rad: f64,
    /// Turn from view to view, rad.
    pub spacing_rad: f64,
}

/// An image of a wrist that turns.
#[derive(Debug, Clone, PartialEq)]
pub struct PassageView<C> {
    /// Wrist angle at the image's stamp, rad.
    pub angle_rad: f64,
    /// Rate there, rad/s.
    pub rate_rad_s: f64,
    /// The cloud.
    pub cloud: C,
}

/// Follows joint states and clouds; gives the views of each sweep at its end.
#[derive(Debug)]
pub struct Passages<C> {
    rules: PassageRules,
    track: WristTrack,
    clouds: VecDeque<(Duration, C)>,
    run: Vec<PassageView<C>>,
}

impl<C> Passages<C> {
    /// Starts with nothing seen.
    pub fn new(rules: PassageRules) -> Self {
        Self {
            rules,
            track: WristTrack::default(),
            clouds: VecDeque::with_capacity(CLOUDS_KEPT),
            run: Vec::new(),
        }
    }

    /// Follows other rules from now on.
    pub fn set_rules(&mut self, rules: PassageRules) {
        self.rules = rules;
    }

    /// Forgets everything, as after a jump in time.
    pub fn reset(&mut self) {
        *self = Self::new(self.rules);
    }

    /// Notes a cloud with the stamp of its image.
    pub fn on_cloud(&mut self, stamp: Duration, cloud: C) -> Option<Vec<PassageView<C>>> {
        if self.clouds.len() == CLOUDS_KEPT {
            self.clouds.pop_front();
        }
        self.clouds.push_back((stamp, cloud));
        self.follow()
    }

    /// Notes the state of the wrist.
    pub fn on_joint(&mut self, sample: &JointSample) -> Option<Vec<PassageView<C>>> {
        self.track.note(sample, None);
        self.follow()
    }

    /// Looks at the clouds whose joint states have come.
    fn follow(&mut self) -> Option<Vec<PassageView<C>>> {
        let mut ended = None;
        while let Some((stamp, _)) = self.clouds.front()
            && self.track.reaches(*stamp)
            && let Some((stamp, cloud)) = self.clouds.pop_front()
        {
            let Some(angle_rad) = self.track.at(stamp) else {
                continue;
            };
            let rate_rad_s = self.track.rate_at(stamp);
            let view = PassageView {
                angle_rad,
                rate_rad_s,
                cloud,
            };
            ended = self.add(view).or(ended);
        }
        ended
    }

    /// Takes an image; gives the sweep that it shows to have ended.
    fn add(&mut self, view: PassageView<C>) -> Option<Vec<PassageView<C>>> {
        let is_turning = view.rate_rad_s.abs() >= RATE_MIN_RAD_S;
        let goes_on = self
            .run
            .last()
            .is_none_or(|last| last.rate_rad_s * view.rate_rad_s > 0.0);
        let ended = (!is_turning || !goes_on).then(|| self.end()).flatten();
        if !is_turning {
            return ended;
        }
        let is_due = self.run.first().is_none_or(|first| {
            let turned_rad = (view.angle_rad - first.angle_rad).abs();
            turned_rad >= self.run.len() as f64 * self.rules.spacing_rad
        });
        if is_due && self.run.len() < VIEWS_MAX {
            self.run.push(view);
        }
        ended
    }

    /// The run as a sweep, where it is wide enough.
    fn end(&mut self) -> Option<Vec<PassageView<C>>> {
        let run = std::mem::take(&mut self.run);
        let (first, last) = (run.first()?, run.last()?);
        let turned_rad = (last.angle_rad - first.angle_rad).abs();
        (turned_rad >= self.rules.range_min_rad).then_some(run)
    }
}

#[cfg(test)]
mod tests {
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
}
