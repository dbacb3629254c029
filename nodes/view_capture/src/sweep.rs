//! Finds the views of a scan in a motion that somebody else commands.
//!
//! A scan is a run of rests in one direction with as many distinct angles as it has views. A rest that reverses the
//! direction begins a new run at the turning point. Nothing is handed out before the run is complete, so that a wrist
//! that returns to its start does not begin a scan that never ends. All decisions rest on stamps: a recording played
//! twice as fast gives the same views.

use std::collections::VecDeque;
use std::time::Duration;

use baxter::{Arrival, JointSample};

/// Clouds that are kept until the joint states of their time have come: 0.13 s at 30 Hz.
const CLOUDS_KEPT: usize = 4;

/// When a view counts.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRules {
    /// Views of a scan.
    pub view_count: usize,
    /// Speed of the wrist that still counts as rest, rad/s.
    pub rest_velocity_rad_s: f64,
    /// Shortest rest of which a view is taken.
    pub dwell: Duration,
    /// Least angle between views, rad.
    pub separation_rad: f64,
}

/// A view: what was seen at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken<C> {
    /// Wrist angle, rad.
    pub angle_rad: f64,
    /// The cloud.
    pub cloud: C,
}

/// Follows the wrist and the clouds.
#[derive(Debug)]
pub struct Sweep<C> {
    rules: SweepRules,
    arrival: Arrival,
    rest: Option<Rest>,
    clouds: VecDeque<(Duration, C)>,
    run: Vec<Taken<C>>,
    /// Where the last scan ended, until the wrist leaves: a twitch there begins no other.
    ended_rad: Option<f64>,
}

/// The last rest that was long enough, by the stamps of the joint states in it.
#[derive(Debug, Clone, Copy)]
struct Rest {
    angle_rad: f64,
    since: Duration,
    until: Duration,
    viewed: bool,
}

impl<C: Clone> Sweep<C> {
    /// Starts with nothing seen.
    pub fn new(rules: SweepRules) -> Self {
        Self {
            arrival: Arrival::anywhere(rules.rest_velocity_rad_s, rules.dwell),
            rules,
            rest: None,
            clouds: VecDeque::with_capacity(CLOUDS_KEPT),
            run: Vec::new(),
            ended_rad: None,
        }
    }

    /// Forgets everything, as after a jump in time.
    pub fn reset(&mut self) {
        *self = Self::new(self.rules.clone());
    }

    /// Follows other rules from now on, and forgets what was seen by the old ones.
    pub fn obey(&mut self, rules: SweepRules) {
        if rules != self.rules {
            *self = Self::new(rules);
        }
    }

    /// Notes a cloud with the stamp of its image; gives the views of a scan when this completes one.
    pub fn on_cloud(&mut self, stamp: Duration, cloud: C) -> Option<Vec<Taken<C>>> {
        if self.clouds.len() == CLOUDS_KEPT {
            self.clouds.pop_front();
        }
        self.clouds.push_back((stamp, cloud));
        self.look()
    }

    /// Notes the state of the wrist; gives the views of a scan when this completes one.
    pub fn on_joint(&mut self, sample: JointSample) -> Option<Vec<Taken<C>>> {
        let separation_rad = self.rules.separation_rad;
        self.ended_rad = self
            .ended_rad
            .filter(|ended_rad| (sample.angle_rad - ended_rad).abs() < separation_rad);
        let arrived = self.arrival.observe(sample)?;
        match &mut self.rest {
            Some(rest) if rest.since == arrived.at_rest => rest.until = sample.stamp,
            other => {
                *other = Some(Rest {
                    angle_rad: arrived.angle_rad,
                    since: arrived.at_rest,
                    until: sample.stamp,
                    viewed: self.ended_rad.is_some(),
                });
            }
        }
        self.look()
    }

    /// Takes the first cloud of the rest, unless it has been taken.
    fn look(&mut self) -> Option<Vec<Taken<C>>> {
        let rest = self.rest.as_mut().filter(|rest| !rest.viewed)?;
        let lasted = rest.since..=rest.until;
        let (_, cloud) = self
            .clouds
            .iter()
            .find(|(stamp, _)| lasted.contains(stamp))?;
        rest.viewed = true;
        let view = Taken {
            angle_rad: rest.angle_rad,
            cloud: cloud.clone(),
        };
        self.add(view)
    }

    fn add(&mut self, view: Taken<C>) -> Option<Vec<Taken<C>>> {
        if let Some(last) = self.run.last_mut() {
            let turn_rad = view.angle_rad - last.angle_rad;
            if turn_rad.abs() < self.rules.separation_rad {
                // The same rest again after a twitch: the newer look counts.
                *last = view;
                return None;
            }
            let first_rad = self.run[0].angle_rad;
            let last_rad = self.run[self.run.len() - 1].angle_rad;
            if self.run.len() > 1 && (last_rad - first_rad) * turn_rad < 0.0 {
                self.run.drain(..self.run.len() - 1);
            }
        }
        self.run.push(view);
        if self.run.len() < self.rules.view_count {
            return None;
        }
        // The last angle may be where the next run turns, but its cloud is of this scan.
        self.ended_rad = Some(self.run[self.run.len() - 1].angle_rad);
        Some(std::mem::take(&mut self.run))
    }
}

#[cfg(test)]
mod tests;
