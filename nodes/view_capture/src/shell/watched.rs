//! State of passive mode: the rests and sweeps of the wrist so far, and the clouds that were taken during them.

use super::clouds::Shot;
use baxter::JointSample;
use msg::{Time, stamp};
use std::sync::Arc;
use view_capture::{Motion, Parameters, PassageView, Passages, RestView, Rests};

/// After this many rests without a sweep, a warning in the log suggests `motion: steps`.
const RESTS_WITHOUT_SWEEP: u32 = 3;

/// What was found.
pub enum Event {
    /// The wrist rests: a view.
    Rested(RestView<Arc<Shot>>),
    /// A sweep has ended: its views.
    Swept(Vec<PassageView<Arc<Shot>>>),
    /// ROS time was set.
    Jumped,
}

/// What the joint states and clouds show so far.
pub struct Watched {
    motion: Motion,
    /// Rests since the last sweep.
    rest_count: u32,
    rests: Rests<Arc<Shot>>,
    passages: Passages<Arc<Shot>>,
}

impl Watched {
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            motion: parameters.motion,
            rest_count: 0,
            rests: Rests::new(parameters.rest_rules()),
            passages: Passages::new(parameters.passage_rules()),
        }
    }

    /// Follows parameters that were changed.
    pub fn set_rules(&mut self, parameters: &Parameters) {
        self.passages.set_rules(parameters.passage_rules());
    }

    pub fn on_cloud(&mut self, shot: Arc<Shot>) -> Option<Event> {
        let stamp = stamp::since_epoch(shot.cloud.header.stamp);
        let rested = self.rests.on_cloud(stamp, Arc::clone(&shot));
        let swept = self.passages.on_cloud(stamp, shot);
        self.event(rested, swept)
    }

    pub fn on_joint(&mut self, sample: JointSample) -> Option<Event> {
        let rested = self.rests.on_joint(sample);
        let swept = self.passages.on_joint(&sample);
        self.event(rested, swept)
    }

    fn event(
        &mut self,
        rested: Option<RestView<Arc<Shot>>>,
        swept: Option<Vec<PassageView<Arc<Shot>>>>,
    ) -> Option<Event> {
        if self.motion == Motion::Steps {
            return rested.map(Event::Rested);
        }
        self.rest_count += u32::from(rested.is_some());
        if swept.is_some() {
            self.rest_count = 0;
        } else if rested.is_some() && self.rest_count == RESTS_WITHOUT_SWEEP {
            log::warn!(
                "the wrist has come to rest {RESTS_WITHOUT_SWEEP} times and made no sweep: were the views taken at rest? Then \
                 set motion of view_capture to steps (replay.launch motion:=steps)"
            );
        }
        swept.map(Event::Swept)
    }

    /// Takes back the view of a rest, whose cloud has this stamp.
    pub fn take_back(&mut self, stamp: Time) {
        self.rests.take_back(stamp::since_epoch(stamp));
    }

    /// Begins anew, as after a jump in time.
    pub fn reset(&mut self) {
        self.rest_count = 0;
        self.rests.reset();
        self.passages.reset();
    }
}
