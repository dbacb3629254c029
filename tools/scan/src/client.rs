//! The client's side of the action `scan_object`.

use crate::bar::Bar;
use anyhow::{Result, bail, ensure};
use msg::actionlib_msgs::{GoalID, GoalStatus, GoalStatusArray};
use msg::deformable_cobot::{
    Classification, ScanObjectActionFeedback, ScanObjectActionGoal, ScanObjectActionResult,
    ScanObjectFeedback, ScanObjectGoal,
};
use node::{Expect, Latch, Node, Publisher, Subscriber};
use std::time::Duration;
use tokio::sync::mpsc;

/// How long the server may take to be found.
const SERVER_PATIENCE: Duration = Duration::from_secs(10);
/// Statuses come five times a second; a server that is silent for so long is gone.
const SILENCE_MAX: Duration = Duration::from_secs(5);
/// How often the silence is looked at.
const SILENCE_PERIOD: Duration = Duration::from_millis(500);
/// How long a cancelled goal may take to end: the arm comes to rest first.
const CANCEL_PATIENCE: Duration = Duration::from_secs(20);

enum Event {
    Feedback(Box<ScanObjectActionFeedback>),
    Result(Box<ScanObjectActionResult>),
}

/// A connection to the server, for one goal after the other.
pub struct Client {
    node: Node,
    /// Of the newest goal; the others begin with the node's name, too, which is its own.
    id: GoalID,
    goal_count: usize,
    goal: Publisher<ScanObjectActionGoal>,
    cancel: Publisher<GoalID>,
    status: Subscriber,
    events: mpsc::UnboundedReceiver<Event>,
    _links: [Subscriber; 2],
}

impl Client {
    /// Connects to the server, so that nothing of what it says later is lost.
    pub async fn connect(node: &Node) -> Result<Self> {
        let (sender, events) = mpsc::unbounded_channel();
        let feedback = node.subscribe("scan_object/feedback", Expect::COMMANDS, {
            let sender = sender.clone();
            move |message: ScanObjectActionFeedback| {
                let _ = sender.send(Event::Feedback(Box::new(message)));
            }
        })?;
        let result = node.subscribe("scan_object/result", Expect::COMMANDS, {
            move |message: ScanObjectActionResult| {
                let _ = sender.send(Event::Result(Box::new(message)));
            }
        })?;
        let status =
            node.subscribe("scan_object/status", Expect::STATE, |_: GoalStatusArray| {})?;
        let client = Self {
            node: node.clone(),
            id: GoalID::default(),
            goal_count: 0,
            goal: node.publish("scan_object/goal", 1, Latch::No)?,
            cancel: node.publish("scan_object/cancel", 1, Latch::No)?,
            status,
            events,
            _links: [feedback, result],
        };
        let found = tokio::time::timeout(SERVER_PATIENCE, client.until_connected()).await;
        ensure!(
            found.is_ok(),
            "nobody offers the action scan_object (waited {SERVER_PATIENCE:.0?}); is view_capture running?"
        );
        Ok(client)
    }

    async fn until_connected(&self) {
        self.goal.until_subscribed(SERVER_PATIENCE).await;
        self.cancel.until_subscribed(SERVER_PATIENCE).await;
        for link in &self._links {
            link.until_connected(SERVER_PATIENCE).await;
        }
        while self.status.age().is_none() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    /// Scans with so many views (0: as configured), shown on the bar. Where the program is asked to end, it asks the
    /// server to end the scan, and returns when the arm is still.
    pub async fn scan(&mut self, views: u32, bar: &Bar) -> Result<Classification> {
        self.send(views);
        let node = self.node.clone();
        tokio::select! {
            end = self.follow(|report| bar.show(report)) => end,
            () = node.until_shutdown() => {
                bar.say("stopping the arm");
                self.cancel();
                self.end_of_cancelled().await
            }
        }
    }

    fn send(&mut self, views: u32) {
        self.goal_count += 1;
        self.id = GoalID {
            stamp: self.node.clock().now(),
            id: format!("{}-{}", self.node.name(), self.goal_count),
        };
        let mut message = ScanObjectActionGoal {
            goal_id: self.id.clone(),
            goal: ScanObjectGoal { views },
            ..Default::default()
        };
        message.header.stamp = self.id.stamp;
        self.goal.send(message);
    }

    fn cancel(&self) {
        self.cancel.send(GoalID {
            stamp: msg::Time::default(),
            id: self.id.id.clone(),
        });
    }

    /// The answer; an error where the goal ended without. Calls `show` with each report until then.
    async fn follow(&mut self, show: impl Fn(&ScanObjectFeedback)) -> Result<Classification> {
        loop {
            match tokio::time::timeout(SILENCE_PERIOD, self.events.recv()).await {
                Ok(Some(Event::Feedback(message))) if self.is_mine(&message.status) => {
                    show(&message.feedback);
                }
                Ok(Some(Event::Result(message))) if self.is_mine(&message.status) => {
                    return answer(*message);
                }
                Ok(Some(_)) => self.check_server()?,
                Ok(None) => bail!("the links are closed"),
                Err(_) => self.check_server()?,
            }
        }
    }

    /// Waits for the end of a goal that was cancelled; it may have had its answer before.
    async fn end_of_cancelled(&mut self) -> Result<Classification> {
        match tokio::time::timeout(CANCEL_PATIENCE, self.follow(|_| {})).await {
            Ok(end) => end,
            Err(_) => bail!(
                "view_capture did not end the scan within {CANCEL_PATIENCE:.0?}; the arm may still move"
            ),
        }
    }

    fn check_server(&self) -> Result<()> {
        let is_silent = self.status.age().is_none_or(|age| age > SILENCE_MAX);
        ensure!(
            !is_silent,
            "view_capture has been silent for {SILENCE_MAX:.0?}; its message is on the console that it runs on"
        );
        Ok(())
    }

    fn is_mine(&self, status: &GoalStatus) -> bool {
        status.goal_id.id == self.id.id
    }
}

fn answer(message: ScanObjectActionResult) -> Result<Classification> {
    if message.status.status == GoalStatus::SUCCEEDED {
        return Ok(message.result.classification);
    }
    let (error, text) = (message.result.error, message.status.text);
    match (&error[..], &text[..]) {
        ("", "") => bail!("view_capture gave no reason"),
        ("", text) => bail!("{text}"),
        (error, text) if error.contains(text) => bail!("{error}"),
        (error, text) => bail!("{error}: {text}"),
    }
}
