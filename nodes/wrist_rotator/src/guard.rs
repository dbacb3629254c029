//! The rules by which the arm must not move.

use std::time::{Duration, Instant};

use baxter::{Aged, JOINTS_PER_ARM, Side, Silence, StateRefusal, StateRules, fresh};

use crate::monitor::Snapshot;
use crate::parameters::{Parameters, Surroundings};
use crate::refusal::{RATE_MIN_RAD_S, Refusal};

/// Velocity from which on a joint counts as moving when a turn is to start, rad/s: well above what a resting joint reports.
const MOVING_RAD_S: f64 = 0.1;

/// The rules by which motion is refused.
#[derive(Debug, Clone)]
pub struct Guard {
    joint_names: [&'static str; JOINTS_PER_ARM],
    state_rules: StateRules,
    joints_age_max: Duration,
    surroundings_age_max: Duration,
    side: Side,
    waived: Vec<Surroundings>,
    angle_min_rad: f64,
    angle_max_rad: f64,
    rate_max_rad_s: f64,
}

impl Guard {
    /// With the ages, limits and policies of `parameters`.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            joint_names: parameters.side.joint_names(),
            state_rules: StateRules {
                age_max: Duration::from_secs_f64(parameters.state_age_max_s),
                require_ready: parameters.require_ready,
                tolerate_error: parameters.tolerate_error,
            },
            joints_age_max: Duration::from_secs_f64(parameters.joints_age_max_s),
            surroundings_age_max: Duration::from_secs_f64(parameters.surroundings_age_max_s),
            side: parameters.side,
            waived: parameters.waived.clone(),
            angle_min_rad: parameters.angle_min_rad,
            angle_max_rad: parameters.angle_max_rad,
            rate_max_rad_s: parameters.velocity_max_rad_s,
        }
    }

    /// May a motion to `target_rad` start? Then these are the angles to start from, rad, in the robot's order.
    ///
    /// # Errors
    /// The first rule that forbids it.
    pub fn check_start(
        &self,
        snapshot: &Snapshot,
        target_rad: f64,
        now: Instant,
    ) -> Result<[f64; JOINTS_PER_ARM], Refusal> {
        self.check_target(target_rad)?;
        let angles_rad = self.check(snapshot, now)?;
        if snapshot.other_publishers.is_none() {
            return Err(Refusal::PublishersUnknown);
        }
        self.check_rest(snapshot)?;
        Ok(angles_rad)
    }

    /// A turn begins with a setpoint at the measured angles, which would be a jump back for an arm that moves.
    fn check_rest(&self, snapshot: &Snapshot) -> Result<(), Refusal> {
        let joints = snapshot.joints.iter();
        let velocities = joints.map(|sample| sample.as_ref()?.value.velocity_rad_s);
        for (joint, velocity_rad_s) in self.joint_names.into_iter().zip(velocities) {
            if let Some(velocity_rad_s) = velocity_rad_s.filter(|rate| rate.abs() > MOVING_RAD_S) {
                return Err(Refusal::StillMoving {
                    joint,
                    velocity_rad_s,
                });
            }
        }
        Ok(())
    }

    /// May a motion go on? Then these are the measured angles, rad, in the robot's order. A master that does not answer is
    /// no reason to stop: it takes no part in the motion.
    ///
    /// # Errors
    /// The first rule that forbids it.
    pub fn check(
        &self,
        snapshot: &Snapshot,
        now: Instant,
    ) -> Result<[f64; JOINTS_PER_ARM], Refusal> {
        self.state_rules.check(snapshot.state.as_ref(), now)?;
        let angles_rad = self.check_joints(snapshot, now)?;
        check_publishers(snapshot)?;
        self.check_surroundings(snapshot, now)?;
        Ok(angles_rad)
    }

    /// May the wrist turn at a rate? `None`: at the usual one.
    ///
    /// # Errors
    /// [`Refusal::RateOutOfRange`].
    pub fn check_rate(&self, rate_rad_s: Option<f64>) -> Result<(), Refusal> {
        let max_rad_s = self.rate_max_rad_s;
        match rate_rad_s {
            Some(rate_rad_s) if !(RATE_MIN_RAD_S..=max_rad_s).contains(&rate_rad_s) => {
                Err(Refusal::RateOutOfRange {
                    rate_rad_s,
                    max_rad_s,
                })
            }
            _ => Ok(()),
        }
    }

    fn check_target(&self, angle_rad: f64) -> Result<(), Refusal> {
        if !angle_rad.is_finite() {
            return Err(Refusal::TargetNotFinite { angle_rad });
        }
        let (min_rad, max_rad) = (self.angle_min_rad, self.angle_max_rad);
        if angle_rad < min_rad || angle_rad > max_rad {
            return Err(Refusal::TargetOutsideLimits {
                angle_rad,
                min_rad,
                max_rad,
            });
        }
        Ok(())
    }

    fn check_joints(
        &self,
        snapshot: &Snapshot,
        now: Instant,
    ) -> Result<[f64; JOINTS_PER_ARM], Refusal> {
        let mut angles_rad = [0.0; JOINTS_PER_ARM];
        let named = || self.joint_names.into_iter().zip(&snapshot.joints);
        let absent = |(name, sample): (&'static str, &Option<_>)| sample.is_none().then_some(name);
        let joints: Vec<_> = named().filter_map(absent).collect();
        if !joints.is_empty() {
            return Err(Refusal::JointsAbsent { joints });
        }
        for (angle, (joint, sample)) in angles_rad.iter_mut().zip(named()) {
            let Some(sample) = sample else { continue };
            let sample = fresh(Some(sample), self.joints_age_max, now);
            let sample = sample.map_err(|silence| joint_silent(joint, silence))?;
            let angle_rad = sample.angle_rad;
            if !angle_rad.is_finite() {
                return Err(Refusal::JointNotFinite { joint, angle_rad });
            }
            *angle = angle_rad;
        }
        Ok(angles_rad)
    }

    /// Does the robot take commands at all, as far as is known? If not, none must be sent: it would be obeyed whenever the
    /// robot takes commands again.
    ///
    /// # Errors
    /// Why not. Silence is no reason here.
    pub fn check_commands_taken(&self, snapshot: &Snapshot, now: Instant) -> Result<(), Refusal> {
        match self.state_rules.check(snapshot.state.as_ref(), now) {
            Ok(()) | Err(StateRefusal::Absent | StateRefusal::Stale { .. }) => {}
            Err(refusal) => return Err(refusal.into()),
        }
        match &snapshot.cuff_held {
            Some(Aged { value: true, .. }) => Err(Refusal::CuffHeld),
            _ => Ok(()),
        }
    }

    fn check_surroundings(&self, snapshot: &Snapshot, now: Instant) -> Result<(), Refusal> {
        if self.heard(Surroundings::Cuff, &snapshot.cuff_held, now)? == Some(&true) {
            return Err(Refusal::CuffHeld);
        }
        let avoidance = Surroundings::CollisionAvoidance;
        let objects = self.heard(avoidance, &snapshot.collision_objects, now)?;
        if let Some(objects) = objects.filter(|objects| !objects.is_empty()) {
            let what = objects.join(", ");
            return Err(Refusal::Collision { what });
        }
        let detection = Surroundings::CollisionDetection;
        if self.heard(detection, &snapshot.collision_detected, now)? == Some(&true) {
            let what = "impact detected".to_owned();
            return Err(Refusal::Collision { what });
        }
        Ok(())
    }

    /// What was last heard of `what`, however old where that is waived.
    fn heard<'a, T>(
        &self,
        what: Surroundings,
        last: &'a Option<Aged<T>>,
        now: Instant,
    ) -> Result<Option<&'a T>, Refusal> {
        if self.waived.contains(&what) {
            return Ok(last.as_ref().map(|last| &last.value));
        }
        let heard = fresh(last.as_ref(), self.surroundings_age_max, now);
        heard.map(Some).map_err(|silence| Refusal::Unheard {
            what,
            topic: what.topic(self.side),
            silence,
        })
    }
}

fn joint_silent(joint: &'static str, silence: Silence) -> Refusal {
    match silence {
        Silence::Never => Refusal::JointsAbsent {
            joints: vec![joint],
        },
        Silence::Stale { age_s, max_s } => Refusal::JointsStale {
            joint,
            age_s,
            max_s,
        },
    }
}

fn check_publishers(snapshot: &Snapshot) -> Result<(), Refusal> {
    match &snapshot.other_publishers {
        Some(nodes) if !nodes.is_empty() => Err(Refusal::OtherPublisher {
            nodes: nodes.clone(),
        }),
        _ => Ok(()),
    }
}
