//! The views of one sweep: each is handed on as it comes, unless the later stages are still at those before it.

use super::{Scanner, Stages};
use crate::answers::Answers;
use anyhow::{bail, ensure};
use msg::deformable_cobot::View;
use node::Life;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::oneshot;
use tokio::time::{Instant, sleep_until};

/// Views that are with the later stages at once, at most: one that is registered, one that is classified, one between. Where
/// the stages are slower than the camera, views are left out, evenly, since each answer makes room for one; and none is
/// old when its answer comes.
const UNDER_WAY_MAX: u32 = 3;
/// How long views may be on their way to this node after the wrist has come to rest.
const LATE_MAX: Duration = Duration::from_secs(2);

/// The views of a sweep so far.
struct Handed<'a> {
    scan_id: &'a str,
    planned: u32,
    /// Those that came.
    heard: u32,
    /// Those that the later stages have.
    handed_on: u32,
    left_out: u32,
    /// Those with an answer.
    answered: u32,
    /// Whether the last one was handed on.
    is_complete: bool,
}

/// Why a sweep ends before its last view.
enum Stop {
    Sure,
    Failed(anyhow::Error),
}

impl<S: Stages> Scanner<S> {
    /// Has the wrist swept through a range and hands the views on, until the last one, or until the answer is sure enough. The
    /// arm rests when this returns.
    pub(super) async fn views_of_sweep(
        &self,
        scan_id: &str,
        range_rad: f64,
        count: u32,
        answers: &mut Answers,
        life: &Life,
    ) -> anyhow::Result<()> {
        let mut captured = self.stages.captured();
        let (stop, stopped) = oneshot::channel::<String>();
        let sweep_life = life.and_until(async {
            match stopped.await {
                Ok(reason) => reason,
                Err(_) => std::future::pending().await,
            }
        });
        let mut handed = Handed::none(scan_id, count);
        let mut sweep = pin!(self.stages.sweep(range_rad, count, scan_id, &sweep_life));
        let (mut swept, mut late) = (None, Instant::now());
        self.progress.turning(0, f64::NAN);
        let early = loop {
            if swept.is_some_and(|taken| handed.heard >= taken) {
                break None;
            }
            tokio::select! {
                biased;
                view = captured.recv() => match view {
                    Ok(view) if view.scan_id == scan_id && life.end().is_none() => {
                        self.hand_on(&view, &mut handed, answers);
                    }
                    Ok(_) => {}
                    Err(RecvError::Lagged(count)) => self.leave_out(count as u32, &mut handed),
                    Err(RecvError::Closed) => bail!("views come no more"),
                },
                answer = answers.next() => {
                    handed.answered = handed.answered.max(answer.view_count);
                    match answers.suffice() {
                        Ok(true) if !handed.is_complete => break Some(Stop::Sure),
                        Ok(_) => {}
                        Err(error) => break Some(Stop::Failed(error)),
                    }
                }
                // It ends when `life` does, too.
                taken = &mut sweep, if swept.is_none() => {
                    swept = Some(taken?);
                    late = Instant::now() + LATE_MAX;
                }
                () = sleep_until(late), if swept.is_some() => bail!(
                    "{} of {} views came; does view_capture reach this node?",
                    handed.heard,
                    swept.unwrap_or_default()
                ),
            }
        };
        if early.is_some() && swept.is_none() {
            // Fails where the sweep has just ended.
            let _ = stop.send("the answer is there".into());
            // What it says of its end is no news.
            let _ = sweep.await;
        }
        if let Some(Stop::Failed(error)) = early {
            return Err(error);
        }
        ensure!(handed.handed_on > 0, "the sweep gave no view and no reason");
        if !handed.is_complete {
            log::info!(
                "scan {scan_id}: {} of {count} views suffice",
                handed.handed_on
            );
            self.stages.publish_end(scan_id, handed.handed_on);
        }
        if handed.left_out > 0 {
            log::warn!(
                "scan {scan_id}: {} of {} views were left out: the later stages were busy",
                handed.left_out,
                handed.heard
            );
        }
        Ok(())
    }

    fn hand_on(&self, view: &Arc<View>, handed: &mut Handed<'_>, answers: &mut Answers) {
        let is_last = view.index + 1 == view.count;
        let under_way = handed.handed_on.saturating_sub(handed.answered);
        if under_way >= UNDER_WAY_MAX && !is_last {
            return self.leave_out(1, handed);
        }
        handed.heard += 1;
        let index = handed.handed_on;
        let count = if is_last {
            index + 1
        } else {
            handed.planned.max(index + 2)
        };
        handed.handed_on += 1;
        handed.is_complete = is_last;
        self.progress.turning(index, f64::NAN);
        self.progress.taken(view.cloud.width * view.cloud.height);
        answers.note_view(view.wrist_angle);
        self.stages.publish(View {
            scan_id: handed.scan_id.into(),
            index,
            count,
            ..(**view).clone()
        });
    }

    fn leave_out(&self, count: u32, handed: &mut Handed<'_>) {
        handed.heard += count;
        handed.left_out += count;
        self.progress.left_out(handed.left_out);
    }
}

impl<'a> Handed<'a> {
    fn none(scan_id: &'a str, planned: u32) -> Self {
        Self {
            scan_id,
            planned,
            heard: 0,
            handed_on: 0,
            left_out: 0,
            answered: 0,
            is_complete: false,
        }
    }
}
