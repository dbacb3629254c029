//! Finds sweeps in what somebody else makes the wrist do, and the views in them.
//!
//! A sweep is a turn in one direction without a rest. It is handed out when it has ended, and only where it was wide enough: a
//! wrist that goes to the begin of a scan, or from view to view, makes no scan by that. All decisions rest on stamps: a
//! recording played twice as fast gives the same views.

use std::collections::VecDeque;
use std::time::Duration;

use baxter::JointSample;

use crate::plan_error::VIEWS_MAX;
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
mod tests;
