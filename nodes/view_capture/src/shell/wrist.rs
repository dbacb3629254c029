//! Where the wrist is, and was a short while ago, by the joint states.

use std::time::{Duration, Instant};

use anyhow::{Context, bail, ensure};
use msg::robot;
use msg::sensor_msgs::JointState;
use tokio::sync::watch;
use view_capture::{ClockSteps, WristTrack};

/// The track of one wrist. Clones share it.
#[derive(Clone)]
pub struct Wrist {
    joint: &'static str,
    track: watch::Sender<WristTrack>,
}

impl Wrist {
    /// Nothing is known of it yet.
    pub fn new(joint: &'static str) -> Self {
        Self {
            joint,
            track: watch::Sender::new(WristTrack::default()),
        }
    }

    /// Takes joint states, of this wrist or of other joints.
    pub fn listener(&self) -> impl Fn(&JointState) + Send + Sync + use<> {
        let wrist = self.clone();
        move |state| {
            if let Some(sample) = robot::joint_sample(state, wrist.joint) {
                wrist
                    .track
                    .send_modify(|track| track.note(&sample, Some(Instant::now())));
            }
        }
    }

    /// The newest angle, rad; waited for if none has come yet.
    pub async fn angle_now(&self, patience: Duration) -> anyhow::Result<f64> {
        let mut track = self.track.subscribe();
        let known = track.wait_for(|track| track.newest_rad().is_some());
        let known = tokio::time::timeout(patience, known).await;
        let angle_rad = known
            .ok()
            .and_then(Result::ok)
            .and_then(|track| track.newest_rad());
        angle_rad.with_context(|| {
            format!(
                "no angle of {} on /robot/joint_states within {patience:.1?}; is the robot running?",
                self.joint
            )
        })
    }

    /// How often the clock of the joint states was set until now.
    pub fn clock_steps(&self) -> ClockSteps {
        self.track.borrow().clock_steps()
    }

    /// Refuses where the clock was set since: angles and images then do not belong together by their stamps.
    pub fn check_clock_since(&self, before: ClockSteps) -> anyhow::Result<()> {
        let ClockSteps { count, last_s } = self.clock_steps();
        ensure!(
            count == before.count,
            "the clock of {}'s joint states was set by {last_s:.2} s meanwhile; ask again, and keep the clocks in step (chronyc)",
            self.joint
        );
        Ok(())
    }

    /// Angle and rate at a moment of ROS time, rad and rad/s, waited for until joint states reach it.
    pub async fn state_at(
        &self,
        moment: Duration,
        patience: Duration,
    ) -> anyhow::Result<(f64, f64)> {
        let mut track = self.track.subscribe();
        let reached = track.wait_for(|track| track.reaches(moment));
        let Ok(Ok(reached)) = tokio::time::timeout(patience, reached).await else {
            bail!(
                "no angle of {} as new as the image came within {patience:.1?}; are joint states still published, and are \
                 the clocks in step?",
                self.joint
            );
        };
        let angle_rad = reached.at(moment);
        let state = angle_rad.map(|angle_rad| (angle_rad, reached.rate_at(moment)));
        state.with_context(|| {
            format!(
                "the angles of {} do not go back to the image's stamp; are the clocks in step?",
                self.joint
            )
        })
    }
}
