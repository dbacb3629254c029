//! The client's side of the action `scan_object`.

use crate::bar::Viewer;
use crate::goal::{Goal, Send};
use anyhow::{Result, bail, ensure};
use msg::actionlib_msgs::{GoalID, GoalStatus, GoalStatusArray};
use msg::deformable_cobot::{
    Classification, ScanObjectActionFeedback, ScanObjectActionGoal, ScanObjectActionResult,
    ScanObjectGoal,
};
use node::{Expect, Node, Publisher, Subscriber};
use std::time::{Duration, Instant};
use tokio::sync::mpsc;

/// How long the server may take to be found.
const SERVER_PATIENCE: Duration = Duration::from_secs(10);
/// How often is looked whether something is to be sent again.
const TICK: Duration = Duration::from_millis(100);

enum Event {
    Status(GoalStatusArray),
    Feedback(Box<ScanObjectActionFeedback>),
    Result(Box<ScanObjectActionResult>),
}

/// A connection to the server, for one goal after the other.
pub struct Client {
    node: Node,
    goal_count: usize,
    goal: Publisher<ScanObjectActionGoal>,
    cancel: Publisher<GoalID>,
    events: mpsc::UnboundedReceiver<Event>,
    links: [Subscriber; 3],
}

impl Client {
    /// Connects to the server.
    ///
    /// # Errors
    /// There is none, or the program is asked to end.
    pub async fn connect(node: &Node) -> Result<Self> {
        let (sender, events) = mpsc::unbounded_channel();
        let on_status = hand_on(sender.clone(), Event::Status);
        let on_feedback = hand_on(sender.clone(), |message| Event::Feedback(Box::new(message)));
        let on_result = hand_on(sender, |message| Event::Result(Box::new(message)));
        let mut client = Self {
            node: node.clone(),
            goal_count: 0,
            goal: node.publish_prompt("scan_object/goal", 1)?,
            cancel: node.publish_prompt("scan_object/cancel", 1)?,
            events,
            links: [
                node.subscribe("scan_object/status", Expect::STATE, on_status)?,
                node.subscribe("scan_object/feedback", Expect::COMMANDS, on_feedback)?,
                node.subscribe("scan_object/result", Expect::COMMANDS, on_result)?,
            ],
        };
        let found = tokio::select! {
            () = node.until_shutdown() => bail!("stopped before the scan began"),
            found = tokio::time::timeout(SERVER_PATIENCE, client.until_connected()) => found,
        };
        ensure!(
            found.is_ok(),
            "nobody offers the action scan_object (waited {SERVER_PATIENCE:.0?}); is scan_server running?"
        );
        Ok(client)
    }

    /// Any node may subscribe or publish, so that this saves sending again, but assures of nothing.
    async fn until_connected(&mut self) {
        self.goal.until_subscribed(SERVER_PATIENCE).await;
        self.cancel.until_subscribed(SERVER_PATIENCE).await;
        for link in &self.links {
            link.until_connected(SERVER_PATIENCE).await;
        }
        while !matches!(self.events.recv().await, Some(Event::Status(_))) {}
    }

    /// Makes the scan that is asked for, and shows how it goes. Where the program is asked to end, it asks the
    /// server to end the scan, and returns when the arm is still.
    ///
    /// # Errors
    /// Why there is no answer.
    pub async fn scan(
        &mut self,
        goal: ScanObjectGoal,
        viewer: &impl Viewer,
    ) -> Result<Classification> {
        let message = self.next_goal(goal);
        let id = message.goal_id.id.clone();
        let mut goal = Goal::new(&id, Instant::now());
        let mut ticker = tokio::time::interval(TICK);
        let node = self.node.clone();
        loop {
            match goal.due(Instant::now())? {
                Some(Send::Goal) => self.goal.send(message.clone()),
                Some(Send::Cancel) => self.cancel.send(GoalID {
                    id: id.clone(),
                    ..Default::default()
                }),
                None => {}
            }
            let event = tokio::select! {
                event = self.events.recv() => event,
                _ = ticker.tick() => continue,
                () = node.until_shutdown(), if !goal.is_cancelled() => {
                    viewer.say("stopping the arm");
                    goal.cancel(Instant::now());
                    continue;
                }
            };
            match event {
                Some(Event::Status(statuses)) => goal.on_status(&statuses, Instant::now()),
                Some(Event::Feedback(message)) if message.status.goal_id.id == id => {
                    if !goal.is_cancelled() {
                        viewer.show(&message.feedback);
                    }
                }
                Some(Event::Result(message)) if message.status.goal_id.id == id => {
                    return answer(*message);
                }
                Some(_) => {}
                None => bail!("the links are closed"),
            }
        }
    }

    fn next_goal(&mut self, goal: ScanObjectGoal) -> ScanObjectActionGoal {
        self.goal_count += 1;
        let mut message = ScanObjectActionGoal {
            goal,
            ..Default::default()
        };
        message.goal_id.id = format!("{}-{}", self.node.name(), self.goal_count);
        message.goal_id.stamp = self.node.clock().now();
        message.header.stamp = message.goal_id.stamp;
        message
    }
}

fn hand_on<T>(sender: mpsc::UnboundedSender<Event>, wrap: impl Fn(T) -> Event) -> impl Fn(T) {
    move |message| {
        // Fails only while the program ends.
        let _ = sender.send(wrap(message));
    }
}

fn answer(message: ScanObjectActionResult) -> Result<Classification> {
    if message.status.status == GoalStatus::SUCCEEDED {
        return Ok(message.result.classification);
    }
    let (error, text) = (message.result.error, message.status.text);
    match (&error[..], &text[..]) {
        ("", "") => bail!("scan_server gave no reason"),
        ("", text) => bail!("{text}"),
        (error, text) if error.contains(text) => bail!("{error}"),
        (error, text) => bail!("{error}: {text}"),
    }
}
