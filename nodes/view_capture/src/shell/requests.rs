//! Views on request: turn, wait for rest, look; or look while the wrist turns.

use super::capture::Capture;
use super::clouds::Listening;
use anyhow::{Context, bail};
use baxter::WristPlan;
use msg::deformable_cobot::{
    CaptureViewsReq, CaptureViewsRes, PlanViewsReq, PlanViewsRes, RotateWristRes, View,
};
use node::Life;
use view_capture::{Parameters, PlanError, check, plan, plan_scan};

impl Capture {
    /// Answers `plan_views`.
    pub fn plan(&self, request: PlanViewsReq) -> PlanViewsRes {
        match plan_scan(&self.parameters.now(), request.views, request.range) {
            Ok(WristPlan::Rests(angles)) => PlanViewsRes {
                count: angles.len() as u32,
                angles,
                ..Default::default()
            },
            Ok(WristPlan::Sweep { range_rad, count }) => PlanViewsRes {
                range: range_rad,
                count,
                ..Default::default()
            },
            Err(error) => PlanViewsRes {
                error: error.to_string(),
                ..Default::default()
            },
        }
    }

    /// Answers `capture_views`; the arm rests then, also where `life` has ended before. A stop of the wrist ends the request,
    /// also where it comes while the camera looks.
    pub async fn capture(&self, request: CaptureViewsReq, life: Life) -> CaptureViewsRes {
        let stopped = self.sources.stops.until_changed();
        let life = life.and_until(async {
            stopped.await;
            "stop_wrist was called".to_owned()
        });
        let (mut views, mut count) = (Vec::new(), 0);
        let taken = self
            .take_views(&request, &life, &mut views, &mut count)
            .await;
        let error = taken.map_or_else(|error| format!("{error:#}"), |()| String::new());
        if !error.is_empty() {
            log::warn!("capture_views: {error}");
        }
        CaptureViewsRes {
            error,
            views,
            count,
        }
    }

    async fn take_views(
        &self,
        request: &CaptureViewsReq,
        life: &Life,
        views: &mut Vec<View>,
        taken_count: &mut u32,
    ) -> anyhow::Result<()> {
        let Ok(_busy) = self.busy.try_lock() else {
            bail!("views are being taken for another caller; call again when that has ended");
        };
        if request.range != 0.0 {
            return self.sweep(request, life, views, taken_count).await;
        }
        let angles_rad = angles(&self.parameters.now(), request)?;
        let listening = self.sources.clouds.listen();
        let count = angles_rad.len();
        for (index, angle_rad) in (0..).zip(angles_rad) {
            let taken = self.take_view(angle_rad, &listening, life).await;
            let mut view = match count {
                1 => taken?,
                _ => taken.with_context(|| format!("view {} of {count}", index + 1))?,
            };
            (view.index, view.count) = (index, count as u32);
            views.push(view);
            *taken_count += 1;
        }
        Ok(())
    }

    async fn take_view(
        &self,
        angle_rad: f64,
        listening: &Listening,
        life: &Life,
    ) -> anyhow::Result<View> {
        // Check the arm pose before the wrist turns: the camera must see the object.
        life.during(self.check_before_motion()).await?;
        let turned = self.turn(angle_rad, life).await?;
        life.during(self.look(&turned, listening)).await
    }

    /// The view of the first image that was taken after the wrist has come to rest.
    async fn look(&self, turned: &RotateWristRes, listening: &Listening) -> anyhow::Result<View> {
        let shot = self.shot_after(turned.at_rest, listening).await?;
        let moment = shot.cloud.header.stamp;
        self.view_from(&shot, moment, turned.angle).await
    }
}

/// The wrist angles that are asked for, rad.
fn angles(parameters: &Parameters, request: &CaptureViewsReq) -> Result<Vec<f64>, PlanError> {
    if request.angles.is_empty() {
        return plan(parameters, request.views);
    }
    check(parameters, &request.angles)?;
    Ok(request.angles.clone())
}
