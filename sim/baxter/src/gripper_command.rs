//! Commands of the electric gripper and their JSON arguments.

use serde::Deserialize;

/// What the gripper is asked, as `EndEffectorCommand` brings it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GripperCommand {
    /// Which gripper; that of its state message.
    pub id: u32,
    /// Verb, such as `go`.
    pub command: String,
    /// JSON object or empty.
    pub args: String,
    /// Who asks.
    pub sender: String,
    /// Counts the sender's commands.
    pub sequence: u32,
}

/// Speed and forces, percent of the gripper's own maximum.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(default)]
pub(crate) struct Configuration {
    pub velocity: f64,
    pub moving_force: f64,
    pub holding_force: f64,
    pub dead_zone: f64,
}

impl Default for Configuration {
    fn default() -> Self {
        Self {
            velocity: 50.0,
            moving_force: 40.0,
            holding_force: 30.0,
            dead_zone: 5.0,
        }
    }
}

/// A command understood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Action {
    Nothing,
    Configure(Configuration),
    Reboot,
    Reset,
    Calibrate,
    ClearCalibration,
    /// Percent open.
    Go(f64),
    Stop,
}

/// Why a gripper command is not obeyed.
#[derive(Debug, thiserror::Error)]
pub enum GripperCommandError {
    /// For another gripper.
    #[error("gripper command ignored: it is for id {asked}, this gripper is {own}")]
    OtherId {
        /// Id in the command.
        asked: u32,
        /// Id of this gripper.
        own: u32,
    },
    /// No such verb.
    #[error("gripper command refused: `{0}` is not a command of the electric gripper")]
    Unknown(String),
    /// Arguments that are not the verb's JSON.
    #[error("gripper command `{command}` refused: arguments `{args}`: {error}")]
    Arguments {
        /// Verb.
        command: String,
        /// Its arguments.
        args: String,
        /// What is wrong with them.
        error: serde_json::Error,
    },
    /// A percentage outside 0..100.
    #[error("gripper command `{command}` refused: {name} is {value}; allowed are 0 to 100")]
    OutOfRange {
        /// Verb.
        command: String,
        /// Argument.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Motion asked of an uncalibrated gripper.
    #[error("gripper command `{0}` refused: the gripper is not calibrated; send `calibrate` first")]
    NotCalibrated(String),
}

impl GripperCommand {
    pub(crate) fn action(&self) -> Result<Action, GripperCommandError> {
        Ok(match self.command.as_str() {
            "no_op" | "set" | "prepare_to_grip" => Action::Nothing,
            "configure" => Action::Configure(self.configuration()?),
            "reboot" => Action::Reboot,
            "reset" => Action::Reset,
            "calibrate" => Action::Calibrate,
            "clear_calibration" => Action::ClearCalibration,
            "grip" => Action::Go(0.0),
            "release" => Action::Go(100.0),
            "go" => Action::Go(self.position()?),
            "stop" => Action::Stop,
            other => return Err(GripperCommandError::Unknown(other.to_owned())),
        })
    }

    fn position(&self) -> Result<f64, GripperCommandError> {
        #[derive(Deserialize)]
        struct Arguments {
            position: f64,
        }
        let arguments: Arguments = self.arguments(&self.args)?;
        self.percent("position", arguments.position)
    }

    fn configuration(&self) -> Result<Configuration, GripperCommandError> {
        let args = if self.args.trim().is_empty() {
            "{}"
        } else {
            &self.args
        };
        let configuration: Configuration = self.arguments(args)?;
        self.percent("velocity", configuration.velocity)?;
        self.percent("moving_force", configuration.moving_force)?;
        self.percent("holding_force", configuration.holding_force)?;
        self.percent("dead_zone", configuration.dead_zone)?;
        Ok(configuration)
    }

    fn arguments<'a, T: Deserialize<'a>>(&self, args: &'a str) -> Result<T, GripperCommandError> {
        serde_json::from_str(args).map_err(|error| GripperCommandError::Arguments {
            command: self.command.clone(),
            args: self.args.clone(),
            error,
        })
    }

    fn percent(&self, name: &'static str, value: f64) -> Result<f64, GripperCommandError> {
        if (0.0..=100.0).contains(&value) {
            return Ok(value);
        }
        Err(GripperCommandError::OutOfRange {
            command: self.command.clone(),
            name,
            value,
        })
    }
}
