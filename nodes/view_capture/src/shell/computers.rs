//! The other computers: whether their clocks are in step with ours, and whether their nodes answer.

use anyhow::bail;
use msg::Time;
use msg::diagnostic_msgs::DiagnosticArray;
use msg::sensor_msgs::JointState;
use node::{Expect, Level, Node, PeerClock, Peers, Source, Subscriber, Tuned};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use view_capture::Parameters;

const JOINT_STATES: &str = "/robot/joint_states";
/// What the camera's stamps come through.
const POINTS: &str = "points";
const HEALTH_PERIOD: Duration = Duration::from_secs(1);

/// Watches the other computers. Clones share it.
#[derive(Clone)]
pub struct OtherComputers {
    node: Node,
    peers: Peers,
    parameters: Tuned<Parameters>,
    _links: Arc<[Subscriber; 2]>,
}

impl OtherComputers {
    /// Takes the time of joint states, which is by the robot's clock, and of diagnostics, which is by that of their node.
    /// `hand_on` gets the joint states, too.
    pub fn watch(
        node: &Node,
        parameters: &Tuned<Parameters>,
        hand_on: impl Fn(&JointState) + Send + Sync + 'static,
    ) -> anyhow::Result<Self> {
        let peers = node.peers();
        let on_joints = {
            let peers = peers.clone();
            move |state: JointState| {
                peers.note(Source::Topic(JOINT_STATES.into()), state.header.stamp);
                hand_on(&state);
            }
        };
        let on_diagnostics = {
            let peers = peers.clone();
            move |array: DiagnosticArray| {
                // A status is called "node: part".
                let name = array.status.first().map(|status| &status.name);
                if let Some((node, _)) = name.and_then(|name| name.split_once(':')) {
                    peers.note(Source::Node(format!("/{node}")), array.header.stamp);
                }
            }
        };
        Ok(Self {
            node: node.clone(),
            peers,
            parameters: parameters.clone(),
            _links: Arc::new([
                node.subscribe(JOINT_STATES, Expect::SHARED_STATE, on_joints)?,
                node.subscribe("/diagnostics", Expect::SPORADIC, on_diagnostics)?,
            ]),
        })
    }

    /// Takes the stamp of a cloud, which is that of its image.
    pub fn note_cloud(&self, stamp: Time) {
        self.peers.note(Source::Topic(POINTS.into()), stamp);
    }

    /// Refuses where views and wrist angles could not be brought together by their stamps.
    pub fn check(&self) -> anyhow::Result<()> {
        let max_s = self.parameters.now().clock_offset_max_s;
        let Some(worst) = self.worst_clock() else {
            return Ok(());
        };
        if worst.offset.certain_s() > max_s {
            bail!(
                "{worst}, more than {:.0} ms; bring the clocks into step (chronyc makestep)",
                max_s * 1e3
            );
        }
        Ok(())
    }

    /// A clause for an error text: the nodes that do not answer now; empty if all do.
    pub async fn clause(&self) -> String {
        let peers = self.peers.clone();
        // A panic would abort the process.
        let _ = tokio::task::spawn_blocking(move || peers.ask()).await;
        let unreachable = self.unreachable();
        if unreachable.is_empty() {
            String::new()
        } else {
            format!("; {unreachable}")
        }
    }

    /// Tells diagnostics of clocks and nodes, for ever.
    pub async fn report(&self) -> Infallible {
        let mut ticker = tokio::time::interval(HEALTH_PERIOD);
        loop {
            ticker.tick().await;
            self.report_clocks();
            let unreachable = self.unreachable();
            let level = if unreachable.is_empty() {
                Level::Ok
            } else {
                Level::Warn
            };
            self.node.health().set("peers", level, unreachable);
        }
    }

    fn report_clocks(&self) {
        let worst = self.worst_clock();
        let certain_s = worst.as_ref().map_or(0.0, |worst| worst.offset.certain_s());
        let level = if certain_s > self.parameters.now().clock_offset_max_s {
            Level::Error
        } else if certain_s > self.parameters.now().clock_offset_warn_s {
            Level::Warn
        } else {
            Level::Ok
        };
        let text = worst.map(|worst| worst.to_string()).unwrap_or_default();
        self.node.health().set("clocks", level, text);
    }

    fn unreachable(&self) -> String {
        let unreachable = self.peers.unreachable();
        let texts: Vec<_> = unreachable.iter().map(ToString::to_string).collect();
        texts.join("; ")
    }

    /// The clock that is off the most for certain. Images take their time from the camera to here, so that of the camera
    /// counts only where it is ahead.
    fn worst_clock(&self) -> Option<PeerClock> {
        let clocks = self.peers.clocks().into_iter();
        clocks
            .filter(|clock| clock.source != Source::Topic(POINTS.into()) || clock.is_ahead())
            .max_by(|a, b| a.offset.certain_s().total_cmp(&b.offset.certain_s()))
    }
}
