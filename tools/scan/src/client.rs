//! The client's side of the action `scan_object`.

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
    Feedback(ScanObjectFeedback),
    Result(Box<ScanObjectActionResult>),
}

/// A connection to the server, good for one goal.
pub struct Client {
    id: String,
    stamp: msg::Time,
    goal: Publisher<ScanObjectActionGoal>,
    cancel: Publisher<GoalID>,
    status: Subscriber,
    events: mpsc::UnboundedReceiver<Event>,
    _links: [Subscriber; 2],
}

impl Client {
    /// Connects to the server, so that nothing of what it says later is lost.
    pub async fn connect(node: &Node) -> Result<Self> {
        let (id, stamp) = (format!("{}-1", node.name()), node.clock().now());
        let (sender, events) = mpsc::unbounded_channel();
        let feedback = node.subscribe("scan_object/feedback", Expect::COMMANDS, {
            let (sender, id) = (sender.clone(), id.clone());
            move |message: ScanObjectActionFeedback| {
                if message.status.goal_id.id == id {
                    let _ = sender.send(Event::Feedback(message.feedback));
                }
            }
        })?;
        let result = node.subscribe("scan_object/result", Expect::COMMANDS, {
            let id = id.clone();
            move |message: ScanObjectActionResult| {
                if message.status.goal_id.id == id {
                    let _ = sender.send(Event::Result(Box::new(message)));
                }
            }
        })?;
        let status =
            node.subscribe("scan_object/status", Expect::STATE, |_: GoalStatusArray| {})?;
        let client = Self {
            id,
            stamp,
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

    /// Asks for a scan of so many views; 0: as configured.
    pub fn send(&self, views: u32) {
        let mut message = ScanObjectActionGoal {
            goal_id: self.goal_id(),
            goal: ScanObjectGoal { views },
            ..Default::default()
        };
        message.header.stamp = self.stamp;
        self.goal.send(message);
    }

    /// Asks the server to end the scan.
    pub fn cancel(&self) {
        self.cancel.send(GoalID {
            stamp: msg::Time::default(),
            id: self.id.clone(),
        });
    }

    /// The answer; an error where the goal ended without. Calls `show` with each report until then.
    pub async fn follow(&mut self, show: impl Fn(&ScanObjectFeedback)) -> Result<Classification> {
        loop {
            match tokio::time::timeout(SILENCE_PERIOD, self.events.recv()).await {
                Ok(Some(Event::Feedback(report))) => show(&report),
                Ok(Some(Event::Result(message))) => return answer(*message),
                Ok(None) => bail!("the links are closed"),
                Err(_) => self.check_server()?,
            }
        }
    }

    /// Waits for the end of a goal that was cancelled; it may have had its answer before.
    pub async fn end_of_cancelled(&mut self) -> Result<Classification> {
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

    fn goal_id(&self) -> GoalID {
        GoalID {
            stamp: self.stamp,
            id: self.id.clone(),
        }
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
