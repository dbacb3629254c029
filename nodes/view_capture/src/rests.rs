//! Finds the moments at which a wrist that somebody else turns is at rest, and what the camera saw then.
//!
//! All decisions rest on stamps: a recording played twice as fast gives the same views.

use std::collections::VecDeque;
use std::time::Duration;

use baxter::{Arrival, JointSample};

/// Clouds that are kept until the joint states of their time have come: 0.13 s at 30 Hz.
const CLOUDS_KEPT: usize = 4;

/// What counts as a rest.
#[derive(Debug, Clone, PartialEq)]
pub struct RestRules {
    /// Speed of the wrist that still counts as rest, rad/s.
    pub rest_velocity_rad_s: f64,
    /// Shortest rest of which a view is taken.
    pub dwell: Duration,
    /// Least angle between views, rad.
    pub separation_rad: f64,
}

/// What was seen during one rest.
#[derive(Debug, Clone, PartialEq)]
pub struct RestView<C> {
    /// Wrist angle, rad.
    pub angle_rad: f64,
    /// The cloud; its image was taken during the rest.
    pub cloud: C,
    /// Whether the wrist has been farther away than the separation since the rest before; else it is a twitch of the same
    /// rest.
    pub moved: bool,
}

/// Follows joint states and clouds; gives one view for each rest.
#[derive(Debug)]
pub struct Rests<C> {
    rules: RestRules,
    arrival: Arrival,
    rest: Option<Rest>,
    clouds: VecDeque<(Duration, C)>,
    /// Where the last view was taken, until the wrist has left.
    viewed_rad: Option<f64>,
}

/// The last rest that was long enough, by the stamps of the joint states in it.
#[derive(Debug, Clone, Copy)]
struct Rest {
    angle_rad: f64,
    since: Duration,
    until: Duration,
    moved: bool,
    viewed: bool,
}

impl<C: Clone> Rests<C> {
    /// Starts with nothing seen.
    pub fn new(rules: RestRules) -> Self {
        Self {
            arrival: Arrival::anywhere(rules.rest_velocity_rad_s, rules.dwell),
            rules,
            rest: None,
            clouds: VecDeque::with_capacity(CLOUDS_KEPT),
            viewed_rad: None,
        }
    }

    /// Forgets everything, as after a jump in time.
    pub fn reset(&mut self) {
        *self = Self::new(self.rules.clone());
    }

    /// Notes a cloud with the stamp of its image; gives the view of a rest where it is the first one.
    pub fn on_cloud(&mut self, stamp: Duration, cloud: C) -> Option<RestView<C>> {
        if self.clouds.len() == CLOUDS_KEPT {
            self.clouds.pop_front();
        }
        self.clouds.push_back((stamp, cloud));
        self.view()
    }

    /// Notes the state of the wrist; gives the view of a rest where its first cloud has come before.
    pub fn on_joint(&mut self, sample: JointSample) -> Option<RestView<C>> {
        let separation_rad = self.rules.separation_rad;
        self.viewed_rad = self
            .viewed_rad
            .filter(|viewed_rad| (sample.angle_rad - viewed_rad).abs() < separation_rad);
        let arrived = self.arrival.observe(sample)?;
        match &mut self.rest {
            Some(rest) if rest.since == arrived.at_rest => rest.until = sample.stamp,
            other => {
                *other = Some(Rest {
                    angle_rad: arrived.angle_rad,
                    since: arrived.at_rest,
                    until: sample.stamp,
                    moved: self.viewed_rad.is_none(),
                    viewed: false,
                });
            }
        }
        self.view()
    }

    /// Takes back a view whose cloud, of this stamp, is of no use: while the wrist rests, a later cloud becomes the view.
    pub fn take_back(&mut self, stamp: Duration) {
        self.clouds.retain(|(other, _)| *other > stamp);
        if let Some(rest) = self.rest.as_mut().filter(|rest| rest.since <= stamp) {
            rest.viewed = false;
            self.viewed_rad = None;
        }
    }

    /// The first cloud of the rest, unless it was given before.
    fn view(&mut self) -> Option<RestView<C>> {
        let rest = self.rest.as_mut().filter(|rest| !rest.viewed)?;
        let lasted = rest.since..=rest.until;
        let (_, cloud) = self
            .clouds
            .iter()
            .find(|(stamp, _)| lasted.contains(stamp))?;
        rest.viewed = true;
        self.viewed_rad = Some(rest.angle_rad);
        Some(RestView {
            angle_rad: rest.angle_rad,
            cloud: cloud.clone(),
            moved: rest.moved,
        })
    }
}
