//! Views while the wrist turns: each is an image whose stamp lies in the motion, with the hand's pose at that stamp.

use std::time::Duration;

use anyhow::Context;
use msg::deformable_cobot::{CaptureViewsReq, View};
use msg::stamp;
use node::Life;
use tokio::sync::{oneshot, watch};
use view_capture::{Spacing, plan_sweep};

use super::capture::Capture;
use super::clouds::Listening;

impl Capture {
    /// Turns the wrist through a range and takes views meanwhile, also on the way to the beginning where the wrist is within the
    /// range: the first view needs no motion. The arm rests when this returns.
    pub(super) async fn sweep(
        &self,
        request: &CaptureViewsReq,
        life: &Life,
        views: &mut Vec<View>,
        count: &mut u32,
    ) -> anyhow::Result<()> {
        let listening = self.sources.clouds.listen();
        let parameters = self.parameters.now();
        let clock_steps = self.sources.wrist.clock_steps();
        let patience = Duration::from_secs_f64(parameters.transform_deadline_s);
        let wrist_rad = life.during(self.sources.wrist.angle_now(patience)).await?;
        let mut plan = plan_sweep(&parameters, request.range, wrist_rad)?;
        self.sources.offset.check()?;
        // Check the arm pose before the wrist turns: the camera must see the object.
        life.during(self.check_before_motion()).await?;
        let mut hand_out = |view| {
            self.sources.wrist.check_clock_since(clock_steps)?;
            self.hand_out(request, view, views);
            Ok(())
        };
        let mut spacing = Spacing::new(&plan);
        let taken = async {
            if let Some(from_here) = plan.from_here(&parameters, wrist_rad) {
                plan = from_here;
                spacing = Spacing::new(&plan);
            } else if plan.is_within(wrist_rad) {
                spacing = Spacing::from_within(&plan);
                let to_rad = plan.from_rad;
                self.turn_and_look(to_rad, &mut spacing, &listening, life, &mut hand_out)
                    .await?;
                spacing.begin_range();
            } else {
                self.turn(plan.from_rad, life).await?;
            }
            self.turn_and_look(plan.to_rad, &mut spacing, &listening, life, &mut hand_out)
                .await
        }
        .await;
        *count = spacing.taken();
        let planned = plan.count;
        // What a clock that was set leads to is a consequence.
        let taken = taken.or_else(|error| {
            let clock = self.sources.wrist.check_clock_since(clock_steps);
            clock.and(Err(error))
        });
        taken.with_context(|| format!("sweep, after {count} of {planned} views"))?;
        if *count < planned {
            log::info!(
                "{} of {planned} views were left out: no image came in time",
                planned - *count
            );
        }
        Ok(())
    }

    /// Turns the wrist to an angle and takes views at the same time. Returns when the wrist is at rest and, at the end of the
    /// sweep, the last view has been taken. If either fails, the other is ended.
    async fn turn_and_look(
        &self,
        to_rad: f64,
        spacing: &mut Spacing,
        listening: &Listening,
        life: &Life,
        hand_out: impl FnMut(View) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let (blind, is_blind) = oneshot::channel::<String>();
        let (arrived, is_arrived) = watch::channel(false);
        let turn_life = life.and_until(async {
            match is_blind.await {
                Ok(reason) => reason,
                Err(_) => std::future::pending().await,
            }
        });
        let rate_rad_s = self.parameters.now().sweep_rate_rad_s;
        let is_approach = spacing.is_approach();
        let turning = async {
            let turned = self.turn_at(rate_rad_s, to_rad, &turn_life).await;
            arrived.send_replace(is_approach || turned.is_err());
            turned
        };
        let looking = async {
            let mut is_arrived = is_arrived.clone();
            let looked = tokio::select! {
                biased;
                _ = is_arrived.wait_for(|arrived| *arrived) => return Ok(()),
                looked = self.look_during(spacing, listening, hand_out) => looked,
            };
            if let Err(error) = &looked {
                // Fails where the turn has ended already.
                let _ = blind.send(format!("{error:#}"));
            }
            looked
        };
        let (turned, looked) = tokio::join!(turning, looking);
        // A turn that ended for want of views says only that it was stopped.
        looked.and(turned)
    }

    /// Hands out views from now on until the last one of the sweep.
    async fn look_during(
        &self,
        spacing: &mut Spacing,
        listening: &Listening,
        mut hand_out: impl FnMut(View) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let patience = Duration::from_secs_f64(self.parameters.now().transform_deadline_s);
        let mut newest = self.node.clock().now();
        loop {
            // While a pose is waited for, images that come are left out but for the newest.
            let shot = self.shot_after(newest, listening).await?;
            newest = shot.cloud.header.stamp;
            let moment = self.sources.offset.moment_of(newest);
            let state = self
                .sources
                .wrist
                .state_at(stamp::since_epoch(moment), patience);
            let (angle_rad, wrist_rate) = state.await?;
            let Some(place) = spacing.take(angle_rad) else {
                continue;
            };
            let view = self.view_from(&shot, moment, angle_rad).await?;
            hand_out(View {
                wrist_rate,
                index: place.index,
                count: if place.is_last {
                    place.index + 1
                } else {
                    spacing.planned().max(place.index + 2)
                },
                ..view
            })?;
            if place.is_last {
                return Ok(());
            }
        }
    }

    /// Publishes the view where the request names a scan; otherwise the view goes into the answer.
    fn hand_out(&self, request: &CaptureViewsReq, view: View, views: &mut Vec<View>) {
        if request.scan_id.is_empty() {
            return views.push(view);
        }
        self.captured.send(View {
            scan_id: request.scan_id.clone(),
            ..view
        });
    }
}
