//! The action's server without its topics: takes goals and cancellations, has the scans made, and tells how they end.

use crate::goals::{GoalId, GoalState, Goals};
use crate::scanner::{Scanned, Scanner};
use crate::stages::{Stages, Wish};
use msg::deformable_cobot::ScanObjectResult;
use node::Life;
use std::collections::HashMap;
use std::convert::Infallible;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::watch;
use tokio::time::MissedTickBehavior;

/// How often all statuses are told, as in actionlib.
const STATUS_PERIOD: Duration = Duration::from_millis(200);

/// What the clients of the action hear.
pub trait Topics: Send + Sync + 'static {
    /// The statuses of all goals.
    fn publish_statuses(&self, goals: &[GoalState]);
    /// The end of a goal.
    fn publish_result(&self, goal: &GoalState, result: &ScanObjectResult);
    /// Waits until no client listens to results any more; says so in words.
    fn until_nobody_listens(&self) -> impl Future<Output = String> + Send;
}

/// Works on goals one after the other.
pub struct GoalServer<T> {
    topics: T,
    goals: Mutex<Goals<Wish>>,
    /// Of the goals that ended a short while ago, by their names.
    results: Mutex<HashMap<String, (GoalState, ScanObjectResult)>>,
    /// Changes with the goals.
    news: watch::Sender<()>,
}

impl<T: Topics> GoalServer<T> {
    /// Without goals.
    pub fn new(topics: T) -> Self {
        Self {
            topics,
            goals: Mutex::new(Goals::new()),
            results: Mutex::default(),
            news: watch::Sender::new(()),
        }
    }

    /// What the clients hear by.
    pub fn topics(&self) -> &T {
        &self.topics
    }

    /// Takes a goal. A client that lost the result of one sends it again; it then gets the result again.
    pub fn on_goal(&self, id: GoalId, wish: impl Into<Wish>) {
        let ended_before = self.results().get(&id.id).cloned();
        if let Some((goal, result)) = ended_before {
            return self.topics.publish_result(&goal, &result);
        }
        let ended = self.goals().receive(id, wish.into(), Instant::now());
        self.changed(ended);
    }

    /// Cancels goals, as [`Goals::cancel`] does.
    pub fn on_cancel(&self, cancelled: &GoalId) {
        let ended = self.goals().cancel(cancelled, Instant::now());
        self.changed(ended);
    }

    /// Forgets stamps, which mean nothing after ROS time was set back.
    pub fn forget_stamps(&self) {
        self.goals().forget_stamps();
    }

    /// The goal that is worked on.
    pub fn running(&self) -> Option<GoalState> {
        self.goals().running().cloned()
    }

    /// Works on the goals until `shutdown` has ended; then all goals have.
    pub async fn serve<S: Stages>(self: &Arc<Self>, scanner: &Scanner<S>, shutdown: &Life) {
        tokio::select! {
            never = self.tell_statuses() => match never {},
            () = self.work(scanner, shutdown) => {}
        }
    }

    async fn work<S: Stages>(self: &Arc<Self>, scanner: &Scanner<S>, shutdown: &Life) {
        let mut news = self.news.subscribe();
        loop {
            news.mark_unchanged();
            if let Some(reason) = shutdown.end() {
                let ended = self.goals().close(&reason, Instant::now());
                return self.changed(ended);
            }
            let started = self.goals().start();
            if let Some((id, wish)) = started {
                log::info!("goal {}: {wish:?}", id.id);
                self.publish_statuses();
                let scanned = scanner.scan(wish, &self.life()).await;
                self.finish(scanned);
                continue;
            }
            tokio::select! {
                _ = news.changed() => {}
                _ = shutdown.ended() => {}
            }
        }
    }

    /// Of the goal that is worked on: until it is cancelled or preempted, or nobody waits for its result.
    fn life(self: &Arc<Self>) -> Life {
        let server = Arc::clone(self);
        Life::until(async move {
            tokio::select! {
                () = server.until_preempting() => "the scan was stopped on request".to_owned(),
                reason = server.topics.until_nobody_listens() => reason,
            }
        })
    }

    async fn until_preempting(&self) {
        let mut news = self.news.subscribe();
        while !self.goals().is_preempting() {
            // The sender lives as long as this does.
            let _ = news.changed().await;
        }
    }

    fn changed(&self, ended: Vec<GoalState>) {
        for goal in ended {
            log::info!("goal {}: {}", goal.id.id, goal.text);
            let error = format!("no scan: {}", goal.text);
            let result = ScanObjectResult {
                error,
                ..Default::default()
            };
            self.end(goal, result);
        }
        self.publish_statuses();
        self.news.send_replace(());
    }

    fn finish(&self, scanned: Scanned) {
        let answer = scanned.answer;
        let ended = self
            .goals()
            .finish(scanned.outcome, &answer.error, Instant::now());
        if let Some(goal) = ended {
            let result = ScanObjectResult {
                error: answer.error,
                classification: answer.result,
            };
            self.end(goal, result);
        }
        self.publish_statuses();
    }

    fn end(&self, goal: GoalState, result: ScanObjectResult) {
        let named = (goal.clone(), result.clone());
        self.results().insert(goal.id.id.clone(), named);
        self.topics.publish_result(&goal, &result);
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
        self.results()
            .retain(|id, _| list.iter().any(|goal| goal.id.id == *id));
        self.topics.publish_statuses(&list);
    }

    fn goals(&self) -> MutexGuard<'_, Goals<Wish>> {
        self.goals.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn results(&self) -> MutexGuard<'_, HashMap<String, (GoalState, ScanObjectResult)>> {
        self.results.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
