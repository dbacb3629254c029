//! Commands of the electric gripper: verbs, JSON arguments, and the sequence numbers by which they are acknowledged.

use serde::Serialize;

use super::ElectricState;

/// Largest sequence number; the next one is 1 (as in the maker's client, baxter_interface).
const SEQUENCE_MAX: u32 = 0x7fff_ffff;

/// The fields of `baxter_core_msgs/EndEffectorCommand`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ElectricCommand {
    /// Hardware id of the gripper, from its state.
    pub id: u32,
    /// Verb, such as `go`.
    pub command: &'static str,
    /// Arguments as a JSON object; may be empty.
    pub args: String,
    /// Name of the sender: node and verb.
    pub sender: String,
    /// Sequence number of the sender's command, from 1.
    pub sequence: u32,
}

/// The gripper's commands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Verb {
    Reset,
    Calibrate,
    Configure(Configuration),
    /// Move to a position, percent open.
    Go(f64),
    Stop,
}

/// Arguments of `configure`, percent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Configuration {
    pub velocity: f64,
    pub moving_force: f64,
    pub holding_force: f64,
    pub dead_zone: f64,
}

/// Numbers the commands of this node.
#[derive(Debug, Clone)]
pub(super) struct Sender {
    node: String,
    sequence: u32,
}

impl ElectricCommand {
    /// Whether the gripper's state acknowledges this command. Some firmware echoes 0 instead of the sequence number.
    pub(super) fn is_echoed_by(&self, state: &ElectricState) -> bool {
        state.sender == self.sender && [0, self.sequence].contains(&state.sequence)
    }
}

impl Verb {
    pub fn name(self) -> &'static str {
        match self {
            Self::Reset => "reset",
            Self::Calibrate => "calibrate",
            Self::Configure(_) => "configure",
            Self::Go(_) => "go",
            Self::Stop => "stop",
        }
    }

    fn args(self) -> String {
        match self {
            Self::Go(position) => serde_json::json!({ "position": position }).to_string(),
            Self::Configure(configuration) => serde_json::json!(configuration).to_string(),
            _ => String::new(),
        }
    }
}

impl Sender {
    pub fn new(node: &str) -> Self {
        Self {
            node: node.trim_start_matches('/').to_owned(),
            sequence: 0,
        }
    }

    /// Continues after the sequence number of an earlier process of this node. Otherwise the gripper could take a new
    /// command for a repetition of an old one, and the old one's acknowledgement would count for the new command.
    pub fn hear(&mut self, state: &ElectricState) {
        let ours = state.sender.strip_prefix(&self.node);
        if ours.is_some_and(|verb| verb.starts_with('_')) && state.sequence <= SEQUENCE_MAX {
            self.sequence = self.sequence.max(state.sequence);
        }
    }

    pub fn command(&mut self, id: u32, verb: Verb) -> ElectricCommand {
        self.sequence = self.sequence % SEQUENCE_MAX + 1;
        ElectricCommand {
            id,
            command: verb.name(),
            args: verb.args(),
            sender: format!("{}_{}", self.node, verb.name()),
            sequence: self.sequence,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_numbered_and_carry_json() {
        let mut sender = Sender::new("/gripper");
        let go = sender.command(65_538, Verb::Go(12.5));
        assert_eq!((go.command, &go.args[..]), ("go", r#"{"position":12.5}"#));
        assert_eq!(
            (&go.sender[..], go.sequence, go.id),
            ("gripper_go", 1, 65_538)
        );
        let configuration = Configuration {
            velocity: 50.0,
            moving_force: 40.0,
            holding_force: 30.0,
            dead_zone: 5.0,
        };
        let configure = sender.command(1, Verb::Configure(configuration));
        assert!(
            configure.args.contains(r#""moving_force":40.0"#),
            "{}",
            configure.args
        );
        assert_eq!(configure.sequence, 2);
        sender.sequence = SEQUENCE_MAX;
        assert_eq!(sender.command(1, Verb::Stop).sequence, 1);
    }

    #[test]
    fn numbers_go_on_after_those_of_an_earlier_process() {
        let mut sender = Sender::new("gripper");
        let echo = |sender: &str, sequence| ElectricState {
            sender: sender.into(),
            sequence,
            ..Default::default()
        };
        sender.hear(&echo("other_go", 70));
        sender.hear(&echo("gripper2_go", 80));
        sender.hear(&echo("gripper_go", 7));
        let go = sender.command(1, Verb::Go(0.0));
        assert_eq!(go.sequence, 8);
        assert!(!go.is_echoed_by(&echo("gripper_go", 7)));
        assert!(go.is_echoed_by(&echo("gripper_go", 8)) && go.is_echoed_by(&echo("gripper_go", 0)));
        assert!(!go.is_echoed_by(&echo("gripper_stop", 8)));
    }
}
