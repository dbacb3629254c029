//! A scan: turn, look, hand on, until all views are taken or the answer is sure enough; then the answer.

mod sweep;

use crate::answers::Answers;
use crate::goals::Outcome;
use crate::parameters::Parameters;
use crate::progress::{Progress, State};
use crate::stages::{Stages, Wish};
use anyhow::{Context, bail, ensure};
use baxter::WristPlan;
use msg::deformable_cobot::{Classification, ScanObjectRes, View};
use msg::view::new_scan_id;
use node::Life;
use std::time::Duration;
use tokio::sync::{Mutex, broadcast};
use tokio::time::Instant;

/// How long the wrist waits for the running answer, where that may end the scan. It takes a tenth of this; without it the
/// scan goes on.
const RUNNING_ANSWER_PATIENCE: Duration = Duration::from_millis(500);

/// Answers kept for a scan that looks for its own.
const ANSWERS_KEPT: usize = 64;

/// A scan that has ended.
#[derive(Debug)]
pub struct Scanned {
    /// How it ended.
    pub outcome: Outcome,
    /// What its caller is told.
    pub answer: ScanObjectRes,
}

/// Makes one scan at a time.
pub struct Scanner<S> {
    stages: S,
    parameters: Parameters,
    progress: Progress,
    answers: broadcast::Sender<Classification>,
    busy: Mutex<()>,
}

impl<S: Stages> Scanner<S> {
    /// Ready for the first scan.
    pub fn new(stages: S, parameters: Parameters) -> Self {
        Self {
            stages,
            parameters,
            progress: Progress::new(),
            answers: broadcast::Sender::new(ANSWERS_KEPT),
            busy: Mutex::default(),
        }
    }

    /// How far the scan has come.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Takes an answer of the classifier, to whatever scan.
    pub fn note_answer(&self, answer: Classification) {
        self.progress.note_answer(&answer);
        // Nobody waits for an answer between scans.
        let _ = self.answers.send(answer);
    }

    /// Makes the scan that is asked for, and waits for the answer:
    ///
    /// 1. plan: the angles at which the wrist comes to rest, or the range of a sweep;
    /// 2. wait until somebody registers views;
    /// 3. for each view: turn, look, hand the view on; and end early where the answer so far is sure enough;
    /// 4. wait for the answer to all views;
    /// 5. tell everybody how the scan ended: the later stages, whoever follows its progress, and the caller.
    ///
    /// The scan is given up when `life` ends. The arm rests when this returns.
    pub async fn scan(&self, wish: impl Into<Wish>, life: &Life) -> Scanned {
        let Ok(_busy) = self.busy.try_lock() else {
            return refused("a scan is already running; call again when it has ended");
        };
        let (wish, life) = (wish.into(), &self.stages.until_wrist_stopped(life));
        let plan = match self.stages.plan(wish, life).await {
            Ok(plan) => plan,
            Err(error) => return refused(&format!("no scan: {error:#}")),
        };
        let scan_id = new_scan_id();
        log::info!("scan {scan_id}: {plan:?}");
        self.progress.begin(&scan_id, plan.count());
        let mut answers = Answers::new(&self.answers, &scan_id, self.parameters.early_end(wish));
        let result = self
            .views_to_label(&scan_id, &plan, &mut answers, life)
            .await;
        let since = self.progress.since();
        let (state, outcome) = match (&result, life.end()) {
            (Ok(_), _) => (State::Done, Outcome::Succeeded),
            (Err(_), None) => (State::Failed, Outcome::Aborted),
            (Err(_), Some(_)) => (State::Stopped, Outcome::Preempted),
        };
        self.progress.set(state);
        let answer = match result {
            Ok(answer) => answered(answer),
            Err(error) => self.failed(&scan_id, error, outcome, since).await,
        };
        Scanned { outcome, answer }
    }

    async fn views_to_label(
        &self,
        scan_id: &str,
        plan: &WristPlan,
        answers: &mut Answers,
        life: &Life,
    ) -> anyhow::Result<Classification> {
        life.during(self.stages.until_registered()).await?;
        match plan {
            WristPlan::Rests(angles_rad) => {
                self.views_at_rest(scan_id, angles_rad, answers, life)
                    .await?;
            }
            WristPlan::Sweep { range_rad, count } => {
                self.views_of_sweep(scan_id, *range_rad, *count, answers, life)
                    .await?;
            }
        }
        self.progress.set(State::Classifying);
        life.during(self.label(answers)).await
    }

    async fn views_at_rest(
        &self,
        scan_id: &str,
        angles_rad: &[f64],
        answers: &mut Answers,
        life: &Life,
    ) -> anyhow::Result<()> {
        let count = angles_rad.len() as u32;
        for (index, &angle_rad) in (0..).zip(angles_rad) {
            self.progress.turning(index, angle_rad);
            let captured = self.stages.capture(angle_rad, life).await;
            let view = captured.with_context(|| format!("view {} of {count}", index + 1))?;
            self.progress.taken(view.cloud.width * view.cloud.height);
            answers.note_view(view.wrist_angle);
            self.stages.publish(View {
                scan_id: scan_id.into(),
                index,
                count,
                ..view
            });
            let taken = index + 1;
            if taken < count && life.during(self.is_sure(answers, taken)).await? {
                log::info!("scan {scan_id}: {taken} of {count} views suffice");
                self.stages.publish_end(scan_id, taken);
                break;
            }
        }
        Ok(())
    }

    /// Whether the answer to the views so far ends the scan; an error if a later stage has already failed.
    async fn is_sure(&self, answers: &mut Answers, views: u32) -> anyhow::Result<bool> {
        let patience = if answers.may_end_scan() {
            RUNNING_ANSWER_PATIENCE
        } else {
            Duration::ZERO
        };
        answers.about(views, patience).await;
        answers.suffice()
    }

    /// The answer to all views.
    async fn label(&self, answers: &mut Answers) -> anyhow::Result<Classification> {
        let patience = Duration::from_secs_f64(self.parameters.answer_deadline_s);
        let Some(answer) = answers.last(patience).await else {
            let silent = match &self.stages.silent_stages()[..] {
                [] => "all stages are running".into(),
                stages => format!("not running: {}", stages.join(", ")),
            };
            bail!("no answer within {patience:.1?} of the last view; {silent}");
        };
        ensure!(answer.error.is_empty(), "{}", answer.error);
        Ok(answer.clone())
    }

    /// Tells the later stages at once, and the caller what the stages say of themselves, too.
    async fn failed(
        &self,
        scan_id: &str,
        error: anyhow::Error,
        outcome: Outcome,
        since: Instant,
    ) -> ScanObjectRes {
        let error = format!("{error:#}");
        self.stages
            .publish_failure(scan_id, format!("scan_server: {error}"));
        let diagnosis = match outcome {
            Outcome::Aborted => self.stages.diagnosis(since).await,
            Outcome::Succeeded | Outcome::Preempted => String::new(),
        };
        let error = format!("scan {scan_id}: {error}{diagnosis}");
        log::error!("{error}");
        let result = Classification {
            scan_id: scan_id.into(),
            error: error.clone(),
            ..Default::default()
        };
        ScanObjectRes { error, result }
    }
}

/// A scan that never began.
fn refused(error: &str) -> Scanned {
    log::warn!("{error}");
    Scanned {
        outcome: Outcome::Aborted,
        answer: ScanObjectRes {
            error: error.into(),
            ..Default::default()
        },
    }
}

fn answered(answer: Classification) -> ScanObjectRes {
    let name = match &answer.label[..] {
        "" => "the hand is empty",
        label => label,
    };
    log::info!(
        "scan {}: {name} ({:.3})",
        answer.scan_id,
        answer.probability
    );
    ScanObjectRes {
        error: String::new(),
        result: answer,
    }
}
