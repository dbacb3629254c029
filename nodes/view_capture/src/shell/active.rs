//! Scans on request: turn, wait for rest, look, again, until all views are taken or the answer is sure enough.

use super::answers::Answers;
use super::output::{Output, Place, Pose, Shot, new_scan_id};
use super::progress::{Progress, State};
use super::stance::Stance;
use super::surroundings::Surroundings;
use super::troubles::Troubles;
use super::wrist::Wrist;
use anyhow::{Context, bail, ensure};
use msg::Time;
use msg::deformable_cobot::{Classification, ScanObjectRes};
use node::{CallError, Life, Node, Transforms, Tuned};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{Mutex, broadcast, watch};
use view_capture::{Outcome, Parameters, plan};

/// How long a scan waits for somebody to look at its views: a node that has just started again is soon there.
const LISTENER_PATIENCE: Duration = Duration::from_secs(5);

/// How long the wrist waits for the running answer, where that may end the scan. It takes a tenth of this; without it the
/// scan goes on.
const RUNNING_ANSWER_PATIENCE: Duration = Duration::from_millis(500);

/// What a scan listens to.
#[derive(Clone)]
pub struct Sources {
    pub transforms: Option<Transforms>,
    pub stance: Option<Stance>,
    pub shots: watch::Receiver<Option<Arc<Shot>>>,
    pub answers: broadcast::Sender<Classification>,
    pub troubles: Troubles,
    pub surroundings: Surroundings,
}

/// A scan that has ended.
pub struct Scanned {
    /// How.
    pub outcome: Outcome,
    /// What its caller is told.
    pub answer: ScanObjectRes,
}

/// Makes one scan at a time. Clones share it.
#[derive(Clone)]
pub struct Scanner {
    wrist: Wrist,
    progress: Progress,
    parameters: Tuned<Parameters>,
    output: Output,
    sources: Sources,
    busy: Arc<Mutex<()>>,
    /// What the latest view saw.
    last_seen: Arc<Mutex<Option<Arc<Shot>>>>,
}

impl Scanner {
    pub fn new(
        node: &Node,
        parameters: Tuned<Parameters>,
        output: Output,
        progress: &Progress,
        sources: Sources,
    ) -> Self {
        Self {
            wrist: Wrist::new(node),
            progress: progress.clone(),
            parameters,
            output,
            sources,
            busy: Arc::default(),
            last_seen: Arc::default(),
        }
    }

    /// Makes a scan of `views` views (0: as configured) and waits for the answer. It is given up when `life` ends; the arm is
    /// still when this returns.
    pub async fn scan(&self, views: u32, life: &Life) -> Scanned {
        let Ok(_busy) = self.busy.try_lock() else {
            return refused("a scan is already running; call again when it has ended");
        };
        let angles_rad = match plan(&self.parameters.now(), views) {
            Ok(angles) => angles,
            Err(error) => return refused(error.to_string()),
        };
        let (scan_id, count) = (new_scan_id(), angles_rad.len() as u32);
        log::info!("scan {scan_id}: {count} views");
        self.progress.begin(&scan_id, count);
        let stopped = async {
            let reason = life.ended().await;
            self.wrist.until_at_rest().await;
            reason
        };
        let scanned = tokio::select! {
            biased;
            reason = stopped => Err(reason),
            result = self.scan_views(&scan_id, &angles_rad, life) => match life.end() {
                Some(reason) if result.is_err() => Err(reason),
                _ => Ok(result),
            },
        };
        let (state, outcome, result) = match scanned {
            Ok(Ok(answer)) => (State::Done, Outcome::Succeeded, Ok(answer)),
            Ok(Err(error)) => (State::Failed, Outcome::Aborted, Err(error)),
            Err(reason) => {
                let error = self.give_up(&scan_id, count, &reason);
                (State::Stopped, Outcome::Preempted, Err(error))
            }
        };
        self.progress.is(state);
        Scanned {
            outcome,
            answer: report(&scan_id, result),
        }
    }

    /// Tells the later stages that no more views come.
    fn give_up(&self, scan_id: &str, count: u32, reason: &str) -> anyhow::Error {
        let place = Place {
            scan_id: scan_id.into(),
            index: 0,
            count,
        };
        self.output
            .failure(place, format!("view_capture: {reason}"));
        anyhow::anyhow!("{reason}")
    }

    /// Waits until no scan is under way.
    pub async fn until_idle(&self) {
        let _idle = self.busy.lock().await;
    }

    /// Scans once when the first cloud has come, if configured so; otherwise never ends.
    pub async fn scan_at_start(&self) -> Infallible {
        let mut shots = self.sources.shots.clone();
        if self.parameters.now().scan_at_start && shots.wait_for(Option::is_some).await.is_ok() {
            self.scan(0, &Life::until(std::future::pending())).await;
        }
        std::future::pending().await
    }

    async fn scan_views(
        &self,
        scan_id: &str,
        angles_rad: &[f64],
        life: &Life,
    ) -> anyhow::Result<Classification> {
        let mut answers = Answers::new(&self.sources.answers, scan_id);
        let count = angles_rad.len() as u32;
        self.output.wait_for_listener(LISTENER_PATIENCE).await?;
        self.check_stance().await?;
        for (index, &angle_rad) in (0..).zip(angles_rad) {
            let place = Place {
                scan_id: scan_id.into(),
                index,
                count,
            };
            if let Err(error) = self.take_view(place.clone(), angle_rad, life).await {
                let error = error.context(format!("view {} of {count}", index + 1));
                self.output
                    .failure(place, format!("view_capture: {error:#}"));
                return Err(error);
            }
            let taken = index + 1;
            if taken < count && self.is_sure(&mut answers, taken).await? {
                log::info!("scan {scan_id}: {taken} of {count} views suffice");
                self.output.end_early(scan_id, taken);
                break;
            }
        }
        self.progress.is(State::Thinking);
        let patience = Duration::from_secs_f64(self.parameters.now().answer_deadline_s);
        let answer = answers.last(patience).await;
        let Some(answer) = answer else {
            return Err(self.no_answer(patience).await);
        };
        ensure!(answer.error.is_empty(), "{}", answer.error);
        Ok(answer.clone())
    }

    /// Nothing is turned where nothing would be seen.
    async fn check_stance(&self) -> anyhow::Result<()> {
        let Some(stance) = &self.sources.stance else {
            return Ok(());
        };
        if let Err(error) = stance.check(&self.parameters.now()).await {
            let troubles = self.sources.troubles.clause().await;
            bail!("not begun: {error:#}{troubles}");
        }
        Ok(())
    }

    /// Whether the answer to the views so far ends the scan; an error if a later stage has already failed.
    async fn is_sure(&self, answers: &mut Answers, views: u32) -> anyhow::Result<bool> {
        let patience = if self.parameters.now().may_end_early() {
            RUNNING_ANSWER_PATIENCE
        } else {
            Duration::ZERO
        };
        let Some(answer) = answers.about(views, patience).await else {
            return Ok(false);
        };
        ensure!(
            !answer.complete || answer.error.is_empty(),
            "{}",
            answer.error
        );
        let is_answer = answer.error.is_empty() && answer.known;
        Ok(is_answer && self.parameters.now().is_sure(answer.probability))
    }

    async fn take_view(&self, place: Place, angle_rad: f64, life: &Life) -> anyhow::Result<()> {
        self.sources.surroundings.check()?;
        let deadline = Duration::from_secs_f64(self.parameters.now().motion_deadline_s);
        self.progress.turning(&place, angle_rad);
        let turned = match self.wrist.turn(angle_rad, deadline, life).await {
            Ok(turned) => turned,
            Err(error) if error.is::<CallError>() => {
                bail!("{error}{}", self.sources.surroundings.clause().await)
            }
            Err(error) => return Err(error),
        };
        self.progress.is(State::Looking);
        let shot = self.shot_after(turned.at_rest).await?;
        let cloud = &shot.cloud;
        ensure!(
            cloud.width > 0,
            "the camera sees nothing within the depth limits; is the hand in front of it, and do \
             depth_threshold's ~depth_min_m and ~depth_max_m fit?"
        );
        let pose = Pose::at(
            &self.parameters.now(),
            self.sources.transforms.as_ref(),
            cloud,
        )
        .await?;
        self.check_alive(&shot).await?;
        self.progress.taken(cloud.width * cloud.height);
        self.output.view(place, turned.angle, pose, &shot);
        Ok(())
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

    /// The first cloud whose image was taken after `moment`.
    async fn shot_after(&self, moment: Time) -> anyhow::Result<Arc<Shot>> {
        let patience = Duration::from_secs_f64(self.parameters.now().frame_deadline_s);
        let mut shots = self.sources.shots.clone();
        let newer = |shot: &Option<Arc<Shot>>| {
            shot.as_ref()
                .is_some_and(|shot| shot.cloud.header.stamp > moment)
        };
        let shot = async { shots.wait_for(newer).await.ok()?.clone() };
        if let Ok(shot) = tokio::time::timeout(patience, shot).await {
            return shot.context("no cloud");
        }
        let last = self
            .sources
            .shots
            .borrow()
            .as_ref()
            .map(|shot| shot.cloud.header.stamp);
        let troubles = self.sources.troubles.clause().await;
        match last {
            Some(stamp) => bail!(
                "no cloud on 'points' newer than the wrist's rest came within {patience:.1?} (the \
                 last one is {:.2} s older); is the camera running, and are the clocks in \
                 step?{troubles}",
                (moment - stamp).seconds()
            ),
            None => bail!(
                "no cloud ever came on 'points'; are the camera and depth_threshold \
                 running?{troubles}"
            ),
        }
    }

    async fn no_answer(&self, patience: Duration) -> anyhow::Error {
        let troubles = self.sources.troubles.clause().await;
        let silent = match &self.sources.troubles.silent_stages()[..] {
            [] => "all stages are running".into(),
            stages => format!("not running: {}", stages.join(", ")),
        };
        anyhow::anyhow!("no answer within {patience:.1?} of the last view; {silent}{troubles}")
    }
}

/// A scan that never began.
fn refused(error: impl Into<String>) -> Scanned {
    let error = error.into();
    let answer = ScanObjectRes {
        error,
        ..Default::default()
    };
    Scanned {
        outcome: Outcome::Aborted,
        answer,
    }
}

fn report(scan_id: &str, result: anyhow::Result<Classification>) -> ScanObjectRes {
    match result {
        Ok(answer) => {
            let name = match &answer.label[..] {
                "" => "the hand is empty",
                label => label,
            };
            log::info!("scan {scan_id}: {name} ({:.3})", answer.probability);
            ScanObjectRes {
                error: String::new(),
                result: answer,
            }
        }
        Err(error) => {
            let error = format!("scan {scan_id}: {error:#}");
            log::error!("{error}");
            let result = Classification {
                scan_id: scan_id.into(),
                error: error.clone(),
                ..Default::default()
            };
            ScanObjectRes { error, result }
        }
    }
}
