//! The five topics of the action `scan_object`, as actionlib has them.

use super::stages::Graph;
use msg::Time;
use msg::actionlib_msgs::{GoalID, GoalStatus, GoalStatusArray};
use msg::deformable_cobot::{
    ScanObjectActionFeedback, ScanObjectActionGoal, ScanObjectActionResult, ScanObjectFeedback,
    ScanObjectResult,
};
use msg::std_msgs::Header;
use node::{Clock, Expect, Latch, Node, Publisher, Subscriber};
use scan_server::{GoalId, GoalServer, GoalState, Scanner, Topics, Wish};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// The server of the action.
pub struct Action {
    node: Node,
    server: Arc<GoalServer<Publishers>>,
    _links: [Subscriber; 2],
}

struct Publishers {
    clock: Arc<Clock>,
    status: Publisher<GoalStatusArray>,
    feedback: Publisher<ScanObjectActionFeedback>,
    result: Publisher<ScanObjectActionResult>,
}

impl Action {
    /// Takes goals from now on.
    pub fn listen(node: &Node) -> anyhow::Result<Self> {
        let server = Arc::new(GoalServer::new(Publishers {
            clock: node.clock(),
            status: node.publish("scan_object/status", 8, Latch::No)?,
            feedback: node.publish("scan_object/feedback", 8, Latch::No)?,
            result: node.publish_prompt("scan_object/result", 16)?,
        }));
        let goal = node.subscribe("scan_object/goal", Expect::COMMANDS, {
            let (server, name, clock) = (Arc::clone(&server), node.name(), node.clock());
            move |message: ScanObjectActionGoal| {
                let id = completed(message.goal_id, &name, clock.now());
                let wish = Wish {
                    views: message.goal.views,
                    range_rad: message.goal.range,
                };
                server.on_goal(id, wish);
            }
        })?;
        let cancel = node.subscribe("scan_object/cancel", Expect::COMMANDS, {
            let server = Arc::clone(&server);
            move |message: GoalID| {
                server.on_cancel(&GoalId {
                    id: message.id,
                    stamp_ns: message.stamp.nanos(),
                });
            }
        })?;
        node.clock().on_jump({
            let server = Arc::clone(&server);
            move || server.forget_stamps()
        });
        Ok(Self {
            node: node.clone(),
            server,
            _links: [goal, cancel],
        })
    }

    /// Works on the goals, one after the other, until the node is told to end and all goals have.
    pub async fn serve(&self, scanner: &Scanner<Graph>) {
        let tell = |report| {
            if let Some(goal) = self.server.running() {
                self.server.topics().tell(&goal, report);
            }
        };
        let shutdown = self.node.life();
        tokio::select! {
            () = self.server.serve(scanner, &shutdown) => {}
            never = scanner.progress().follow(tell) => match never {},
        }
    }
}

/// A goal from the command line has neither name nor stamp.
fn completed(id: GoalID, server: &str, now: Time) -> GoalId {
    static GOALS: AtomicU32 = AtomicU32::new(1);
    let stamp_ns = match id.stamp.nanos() {
        0 => now.nanos(),
        stamp_ns => stamp_ns,
    };
    let id = match &id.id[..] {
        "" => {
            let number = GOALS.fetch_add(1, Ordering::Relaxed);
            format!("{server}-{number}-{}.{:09}", now.sec, now.nsec)
        }
        name => name.into(),
    };
    GoalId { id, stamp_ns }
}

impl Topics for Publishers {
    fn publish_statuses(&self, goals: &[GoalState]) {
        self.status.send(GoalStatusArray {
            header: self.header(),
            status_list: goals.iter().map(status).collect(),
        });
    }

    fn publish_result(&self, goal: &GoalState, result: &ScanObjectResult) {
        self.result.send(ScanObjectActionResult {
            header: self.header(),
            status: status(goal),
            result: result.clone(),
        });
    }

    async fn until_nobody_listens(&self) -> String {
        self.result.until_unheard().await;
        format!("nobody listens to {} any more", self.result.topic())
    }
}

impl Publishers {
    fn tell(&self, goal: &GoalState, feedback: ScanObjectFeedback) {
        self.feedback.send(ScanObjectActionFeedback {
            header: self.header(),
            status: status(goal),
            feedback,
        });
    }

    fn header(&self) -> Header {
        Header {
            stamp: self.clock.now(),
            ..Default::default()
        }
    }
}

fn status(goal: &GoalState) -> GoalStatus {
    GoalStatus {
        goal_id: GoalID {
            stamp: Time::from_nanos(goal.id.stamp_ns),
            id: goal.id.id.clone(),
        },
        status: goal.status as u8,
        text: goal.text.clone(),
    }
}
