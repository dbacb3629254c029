//! The robot's state machine: enabling, stopping, resetting, emergency stop.

use baxter::{EstopButton, EstopSource, RobotState};

/// The state machine. Requests come as the topics `/robot/set_super_{enable,reset,stop}` bring them.
#[derive(Debug, Clone)]
pub struct Assembly {
    state: RobotState,
    reports_ready: bool,
    enabling_s: f64,
    /// Time until the joints are powered, while enabling.
    enabled_in_s: Option<f64>,
}

impl Assembly {
    pub(crate) fn new(enabled: bool, reports_ready: bool, enabling_s: f64) -> Self {
        let state = RobotState {
            ready: enabled && reports_ready,
            enabled,
            stopped: false,
            error: false,
            estop_button: EstopButton::Unpressed,
            estop_source: EstopSource::None,
        };
        Self {
            state,
            reports_ready,
            enabling_s,
            enabled_in_s: None,
        }
    }

    /// As published.
    pub fn state(&self) -> RobotState {
        self.state
    }

    /// May the joints move?
    pub fn allows_motion(&self) -> bool {
        self.state.enabled && !self.state.stopped
    }

    /// Enables, which takes a moment, or disables at once. A stopped robot must be reset before.
    pub fn enable(&mut self, enable: bool) {
        if !enable {
            self.disable();
        } else if !self.state.enabled && !self.state.stopped && self.enabled_in_s.is_none() {
            self.enabled_in_s = Some(self.enabling_s);
        }
    }

    /// Clears stop and error and leaves the robot disabled. In vain while the button is held down.
    pub fn reset(&mut self) {
        if self.state.estop_button == EstopButton::Pressed {
            return;
        }
        self.disable();
        self.state.stopped = false;
        self.state.error = false;
        self.state.estop_button = EstopButton::Unpressed;
        self.state.estop_source = EstopSource::None;
    }

    /// Stops by software. Does not disturb what a held or released button says.
    pub fn stop(&mut self) {
        self.disable();
        self.state.stopped = true;
        if self.state.estop_button == EstopButton::Unpressed {
            self.state.estop_button = EstopButton::Unknown;
            self.state.estop_source = EstopSource::Unknown;
        }
    }

    /// Presses the emergency stop button.
    pub fn press_estop(&mut self) {
        self.disable();
        self.state.stopped = true;
        self.state.estop_button = EstopButton::Pressed;
        self.state.estop_source = EstopSource::User;
    }

    /// Lets the button go; the robot stays stopped until it is reset.
    pub fn release_estop(&mut self) {
        if self.state.estop_button == EstopButton::Pressed {
            self.state.estop_button = EstopButton::Released;
        }
    }

    /// A part fails: stopped, with an error.
    pub fn fail(&mut self) {
        self.disable();
        self.state.stopped = true;
        self.state.error = true;
        self.state.estop_source = EstopSource::Fault;
    }

    /// Sets or clears an error that does not stop the robot.
    pub fn set_error(&mut self, error: bool) {
        self.state.error = error;
    }

    pub(crate) fn step(&mut self, dt_s: f64) {
        let Some(remaining_s) = self.enabled_in_s else {
            return;
        };
        if remaining_s > dt_s {
            self.enabled_in_s = Some(remaining_s - dt_s);
            return;
        }
        self.enabled_in_s = None;
        self.state.enabled = true;
        self.state.ready = self.reports_ready;
    }

    fn disable(&mut self) {
        self.enabled_in_s = None;
        self.state.enabled = false;
        self.state.ready = false;
    }
}

#[cfg(test)]
mod tests;
