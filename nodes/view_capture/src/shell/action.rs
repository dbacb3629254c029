//! The action `scan_object`: actionlib's five topics around [`Goals`].

use super::active::Scanned;
use super::progress::Progress;
use msg::Time;
use msg::actionlib_msgs::{GoalID, GoalStatus, GoalStatusArray};
use msg::deformable_cobot::{
    ScanObjectActionFeedback, ScanObjectActionGoal, ScanObjectActionResult, ScanObjectFeedback,
    ScanObjectResult,
};
use msg::std_msgs::Header;
use node::{Clock, Expect, Latch, Node, Publisher, Subscriber};
use std::convert::Infallible;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::watch;
use tokio::time::MissedTickBehavior;
use view_capture::{GoalId, GoalState, Goals};

/// How often all statuses are told, as in actionlib.
const STATUS_PERIOD: Duration = Duration::from_millis(200);

/// The server of the action.
pub struct Action {
    core: Arc<Core>,
    _links: [Subscriber; 2],
}

struct Core {
    clock: Arc<Clock>,
    name: String,
    goals: Mutex<Goals<u32>>,
    /// Changes with the goals.
    news: watch::Sender<()>,
    status: Publisher<GoalStatusArray>,
    feedback: Publisher<ScanObjectActionFeedback>,
    result: Publisher<ScanObjectActionResult>,
}

impl Action {
    /// Takes goals from now on.
    pub fn listen(node: &Node) -> anyhow::Result<Self> {
        let core = Arc::new(Core {
            clock: node.clock(),
            name: node.name(),
            goals: Mutex::new(Goals::new()),
            news: watch::Sender::new(()),
            status: node.publish("scan_object/status", 8, Latch::No)?,
            feedback: node.publish("scan_object/feedback", 8, Latch::No)?,
            result: node.publish("scan_object/result", 16, Latch::No)?,
        });
        let goal = node.subscribe("scan_object/goal", Expect::COMMANDS, {
            let core = Arc::clone(&core);
            move |message: ScanObjectActionGoal| core.on_goal(message)
        })?;
        let cancel = node.subscribe("scan_object/cancel", Expect::COMMANDS, {
            let core = Arc::clone(&core);
            move |message: GoalID| core.on_cancel(message)
        })?;
        node.clock().on_jump({
            let core = Arc::clone(&core);
            move || core.goals().forget_stamps()
        });
        Ok(Self {
            core,
            _links: [goal, cancel],
        })
    }

    /// Works on the goals, one after the other. `scan` makes a scan of so many views; it ends soon once [`Stop::ordered`] is.
    pub async fn serve(
        &self,
        progress: Option<&Progress>,
        scan: impl AsyncFn(u32, Stop) -> Scanned,
    ) -> Infallible {
        let feedback = async {
            match progress {
                Some(progress) => progress.follow(|report| self.core.tell(report)).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            never = self.core.tell_statuses() => never,
            never = feedback => never,
            never = self.work(scan) => never,
        }
    }

    async fn work(&self, scan: impl AsyncFn(u32, Stop) -> Scanned) -> Infallible {
        let mut news = self.core.news.subscribe();
        loop {
            let started = self.core.goals().start();
            let Some((id, views)) = started else {
                let _ = news.changed().await;
                continue;
            };
            log::info!("goal {}: {views} views", id.id);
            self.core.publish_statuses();
            let stop = Stop {
                core: Arc::clone(&self.core),
            };
            let scanned = scan(views, stop).await;
            self.core.finish(scanned);
        }
    }
}

/// Whether the running goal is to be given up.
pub struct Stop {
    core: Arc<Core>,
}

impl Stop {
    /// Waits until it is; gives the reason.
    pub async fn ordered(&self) -> &'static str {
        let mut news = self.core.news.subscribe();
        while !self.core.goals().is_preempting() {
            let _ = news.changed().await;
        }
        "the scan was stopped on request"
    }
}

impl Core {
    fn goals(&self) -> MutexGuard<'_, Goals<u32>> {
        self.goals.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn on_goal(&self, message: ScanObjectActionGoal) {
        let id = self.completed(message.goal_id);
        let ended = self.goals().receive(id, message.goal.views, Instant::now());
        self.changed(ended);
    }

    fn on_cancel(&self, message: GoalID) {
        let cancelled = GoalId {
            id: message.id,
            stamp_ns: message.stamp.nanos(),
        };
        let ended = self.goals().cancel(&cancelled, Instant::now());
        self.changed(ended);
    }

    /// A goal from the command line has neither name nor stamp.
    fn completed(&self, id: GoalID) -> GoalId {
        static GOALS: AtomicU32 = AtomicU32::new(1);
        let now = self.clock.now();
        let stamp_ns = match id.stamp.nanos() {
            0 => now.nanos(),
            stamp_ns => stamp_ns,
        };
        let id = match &id.id[..] {
            "" => {
                let number = GOALS.fetch_add(1, Ordering::Relaxed);
                format!("{}-{number}-{}.{:09}", self.name, now.sec, now.nsec)
            }
            name => name.into(),
        };
        GoalId { id, stamp_ns }
    }

    fn changed(&self, ended: Vec<GoalState>) {
        for state in ended {
            log::info!("goal {}: {}", state.id.id, state.text);
            let error = format!("no scan: the goal was {}", state.text);
            let result = ScanObjectResult {
                error,
                ..Default::default()
            };
            self.send_result(&state, result);
        }
        self.publish_statuses();
        self.news.send_replace(());
    }

    fn finish(&self, scanned: Scanned) {
        let answer = scanned.answer;
        let text = answer.error.clone();
        let state = self.goals().finish(scanned.outcome, &text, Instant::now());
        if let Some(state) = state {
            let result = ScanObjectResult {
                error: answer.error,
                classification: answer.result,
            };
            self.send_result(&state, result);
        }
        self.publish_statuses();
    }

    fn send_result(&self, state: &GoalState, result: ScanObjectResult) {
        self.result.send(ScanObjectActionResult {
            header: self.header(),
            status: status(state),
            result,
        });
    }

    fn tell(&self, feedback: ScanObjectFeedback) {
        let Some(running) = self.goals().running().cloned() else {
            return;
        };
        self.feedback.send(ScanObjectActionFeedback {
            header: self.header(),
            status: status(&running),
            feedback,
        });
    }

    async fn tell_statuses(&self) -> Infallible {
        let mut ticker = tokio::time::interval(STATUS_PERIOD);
        ticker.set_missed_tick_behavior(MissedTickBehavior::Skip);
        loop {
            ticker.tick().await;
            self.publish_statuses();
        }
    }

    fn publish_statuses(&self) {
        let list = self.goals().list(Instant::now());
        self.status.send(GoalStatusArray {
            header: self.header(),
            status_list: list.iter().map(status).collect(),
        });
    }

    fn header(&self) -> Header {
        Header {
            stamp: self.clock.now(),
            ..Default::default()
        }
    }
}

fn status(state: &GoalState) -> GoalStatus {
    GoalStatus {
        goal_id: GoalID {
            stamp: Time::from_nanos(state.id.stamp_ns),
            id: state.id.id.clone(),
        },
        status: state.status as u8,
        text: state.text.clone(),
    }
}
