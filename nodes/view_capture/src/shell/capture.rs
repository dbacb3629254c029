//! What views are taken with, at rest or in a sweep: turning the wrist, and a cloud with the hand's pose at its stamp.

use super::arm_pose::ArmPose;
use super::clouds::{Clouds, Listening, Shot};
use super::computers::OtherComputers;
use super::time_offset::TimeOffset;
use super::view::{timing, view_of};
use super::wrist::Wrist;
use anyhow::{Context, bail, ensure};
use msg::Time;
use msg::deformable_cobot::{
    RotateWrist, RotateWristReq, RotateWristRes, SweepWrist, SweepWristReq, View,
};
use msg::service::Service;
use node::{CallError, Count, Life, Node, Publisher, Transforms, Tuned};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Mutex;
use view_capture::Parameters;

/// What a view is made of.
pub struct Sources {
    pub transforms: Option<Transforms>,
    pub arm_pose: Option<ArmPose>,
    pub clouds: Clouds,
    pub computers: OtherComputers,
    /// How often `stop_wrist` was called.
    pub stops: Count,
    pub wrist: Wrist,
    pub offset: TimeOffset,
}

/// Takes views for one caller at a time.
pub struct Capture {
    pub(super) node: Node,
    pub(super) parameters: Tuned<Parameters>,
    pub(super) sources: Sources,
    /// Views of a sweep as they come.
    pub(super) captured: Publisher<View>,
    /// Held while views are taken for a caller.
    pub(super) busy: Mutex<()>,
    /// What the latest view saw.
    last_seen: Mutex<Option<Arc<Shot>>>,
}

impl Capture {
    pub fn new(
        node: &Node,
        parameters: Tuned<Parameters>,
        sources: Sources,
        captured: Publisher<View>,
    ) -> Self {
        Self {
            node: node.clone(),
            parameters,
            sources,
            captured,
            busy: Mutex::default(),
            last_seen: Mutex::default(),
        }
    }

    pub(super) async fn check_before_motion(&self) -> anyhow::Result<()> {
        self.sources.computers.check()?;
        if let Some(arm_pose) = &self.sources.arm_pose {
            let checked = arm_pose.check(&self.parameters.now()).await;
            checked.context("not turned")?;
        }
        Ok(())
    }

    /// Turns the wrist and waits until it is at rest, there or where it was stopped.
    pub(super) async fn turn(&self, angle_rad: f64, life: &Life) -> anyhow::Result<RotateWristRes> {
        let request = RotateWristReq { angle: angle_rad };
        let turned = self
            .call::<RotateWrist>("rotate_wrist", request, life)
            .await?;
        ensure!(turned.success, "rotate_wrist: {}", turned.error);
        Ok(turned)
    }

    /// The same at a constant rate.
    pub(super) async fn turn_at(
        &self,
        rate_rad_s: f64,
        angle_rad: f64,
        life: &Life,
    ) -> anyhow::Result<()> {
        let request = SweepWristReq {
            angle: angle_rad,
            rate: rate_rad_s,
        };
        let turned = self
            .call::<SweepWrist>("sweep_wrist", request, life)
            .await?;
        ensure!(turned.success, "sweep_wrist: {}", turned.error);
        Ok(())
    }

    /// Calls a service of the wrist. Where it does not answer, the error names what is known of its computer.
    async fn call<S: Service>(
        &self,
        name: &str,
        request: S::Request,
        life: &Life,
    ) -> anyhow::Result<S::Response> {
        let deadline = Duration::from_secs_f64(self.parameters.now().motion_deadline_s);
        match self.node.call::<S>(name, request, deadline, life).await {
            Ok(response) => Ok(response),
            Err(CallError::GivenUp { reason, .. }) => bail!("{reason}"),
            Err(error) => bail!("{error}{}", self.sources.computers.clause().await),
        }
    }

    /// The view that a cloud is, with the wrist at an angle, and the hand where it was at a moment by the robot's clock.
    pub(super) async fn view_from(
        &self,
        shot: &Arc<Shot>,
        moment: Time,
        angle_rad: f64,
    ) -> anyhow::Result<View> {
        ensure!(
            shot.cloud.width > 0,
            "the camera sees nothing within the depth limits; is the hand in front of it, and do \
             depth_threshold's ~depth_min_m and ~depth_max_m fit?"
        );
        let parameters = self.parameters.now();
        let transforms = self.sources.transforms.as_ref();
        let mut view = view_of(shot, moment, angle_rad, &parameters, transforms).await?;
        self.check_alive(shot).await?;
        view.timing = timing(shot, self.node.clock().now());
        Ok(view)
    }

    /// The first cloud whose image is newer than `moment`.
    pub(super) async fn shot_after(
        &self,
        moment: Time,
        listening: &Listening,
    ) -> anyhow::Result<Arc<Shot>> {
        let patience = Duration::from_secs_f64(self.parameters.now().frame_deadline_s);
        let mut shots = listening.shots.clone();
        let newer = |shot: &Option<Arc<Shot>>| {
            shot.as_ref()
                .is_some_and(|shot| shot.cloud.header.stamp > moment)
        };
        let waited = tokio::time::timeout(patience, shots.wait_for(newer)).await;
        if let Ok(Ok(shot)) = waited {
            return shot.clone().context("no cloud");
        }
        let last = listening.shots.borrow().clone();
        match last {
            Some(last) => bail!(
                "no cloud on 'points' newer than the wrist's rest, or than the one before, came within {patience:.1?} (the \
                 last one is {:.2} s older); is the camera running, and are the clocks in step?",
                (moment - last.cloud.header.stamp).seconds()
            ),
            None => {
                bail!("no cloud ever came on 'points'; are the camera and depth_threshold running?")
            }
        }
    }

    /// Refuses an image that is the last view's once more: no two images of a camera have the same noise. Captures that are
    /// played again may.
    async fn check_alive(&self, shot: &Arc<Shot>) -> anyhow::Result<()> {
        let last = self.last_seen.lock().await.replace(Arc::clone(shot));
        let same = last.is_some_and(|last| last.cloud.data == shot.cloud.data);
        ensure!(
            !(same && self.sources.transforms.is_some()),
            "the camera's image is that of the view before, bit by bit; it is frozen: restart its driver"
        );
        Ok(())
    }
}
