//! The electric gripper: opening, calibration, and what it says of itself.

use crate::gripper_command::{Action, Configuration, GripperCommand, GripperCommandError};

/// Percent of the travel per second at one percent of the velocity: full travel in 0.4 s at the default 50 %.
const TRAVEL_PER_S: f64 = 5.0;

/// What `/robot/end_effector/left_gripper/state` says.
#[derive(Debug, Clone, PartialEq)]
pub struct GripperState {
    /// To be echoed in commands.
    pub id: u32,
    /// Powered, as the robot.
    pub enabled: bool,
    /// Knows its travel; moves only then.
    pub calibrated: bool,
    /// Calibrated and not busy calibrating.
    pub ready: bool,
    /// Fingers move.
    pub moving: bool,
    /// Something stops the fingers: moving force exceeded.
    pub gripping: bool,
    /// Closed to the end of the travel without meeting anything.
    pub missed: bool,
    /// Calibration failed.
    pub error: bool,
    /// Percent open.
    pub position: f64,
    /// Percent of the gripper's force.
    pub force: f64,
    /// Last command obeyed or refused.
    pub command: String,
    /// Its sender.
    pub sender: String,
    /// Its number.
    pub sequence: u32,
}

/// What the fingers are doing.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Motion {
    None,
    /// To that percentage.
    Going(f64),
    /// Calibration opens fully first ...
    CalibrateOpening,
    /// ... then closes fully.
    CalibrateClosing,
}

/// An electric gripper with two parallel fingers.
#[derive(Debug, Clone)]
pub struct Gripper {
    closed_gap_m: f64,
    /// Travel of one finger.
    stroke_m: f64,
    configuration: Configuration,
    motion: Motion,
    /// Thickness of what is between the fingers.
    object_width_m: Option<f64>,
    state: GripperState,
}

impl Gripper {
    /// Id of an electric gripper.
    pub const ID: u32 = 65_538;

    pub(crate) fn new(closed_gap_m: f64, stroke_m: f64, calibrated: bool) -> Self {
        let state = GripperState {
            id: Self::ID,
            enabled: false,
            calibrated,
            ready: calibrated,
            moving: false,
            gripping: false,
            missed: false,
            error: false,
            position: 100.0,
            force: 0.0,
            command: String::new(),
            sender: String::new(),
            sequence: 0,
        };
        let (configuration, motion) = (Configuration::default(), Motion::None);
        Self {
            closed_gap_m,
            stroke_m,
            configuration,
            motion,
            object_width_m: None,
            state,
        }
    }

    /// As published.
    pub fn state(&self) -> &GripperState {
        &self.state
    }

    /// Position of either finger's joint, metres; 0 is closed.
    pub fn finger_position_m(&self) -> f64 {
        self.stroke_m * self.state.position / 100.0
    }

    /// Gap between the paddles, metres.
    pub fn opening_m(&self) -> f64 {
        self.closed_gap_m + 2.0 * self.finger_position_m()
    }

    /// See [`crate::Hand::hold`].
    pub(crate) fn hold(&mut self, object_width_m: Option<f64>) {
        if self.object_width_m == object_width_m {
            return;
        }
        self.set_object_width(object_width_m);
        if object_width_m.is_some() {
            self.motion = Motion::None;
            self.state.position = self.contact_position().clamp(0.0, 100.0);
            self.grip((0.0..100.0).contains(&self.contact_position()));
        }
    }

    /// Puts something of that thickness (metres) between the fingers, or takes it away.
    pub fn set_object_width(&mut self, object_width_m: Option<f64>) {
        self.object_width_m = object_width_m;
        if object_width_m.is_none() {
            self.grip(false);
        }
    }

    /// Takes a command. Clients repeat theirs at 100 Hz until it is echoed, so a repeated one changes nothing.
    ///
    /// # Errors
    /// Not for this gripper; not understood; motion while uncalibrated. All but the first are echoed in the state.
    pub fn command(&mut self, command: &GripperCommand) -> Result<(), GripperCommandError> {
        let state = &mut self.state;
        if command.id != state.id {
            return Err(GripperCommandError::OtherId {
                asked: command.id,
                own: state.id,
            });
        }
        let repeated = state.sender == command.sender
            && state.sequence == command.sequence
            && state.command == command.command;
        if repeated {
            return Ok(());
        }
        state.command.clone_from(&command.command);
        state.sender.clone_from(&command.sender);
        state.sequence = command.sequence;
        match command.action()? {
            Action::Go(_) if !self.state.calibrated => {
                Err(GripperCommandError::NotCalibrated(command.command.clone()))
            }
            action => {
                self.start(action);
                Ok(())
            }
        }
    }

    pub(crate) fn step(&mut self, dt_s: f64, enabled: bool) {
        self.state.enabled = enabled;
        if !enabled {
            self.motion = Motion::None;
        }
        match self.motion {
            Motion::None => {}
            Motion::Going(target) => {
                if self.travel(target, dt_s) {
                    self.motion = Motion::None;
                }
            }
            Motion::CalibrateOpening => {
                if self.travel(100.0, dt_s) {
                    self.motion = Motion::CalibrateClosing;
                }
            }
            Motion::CalibrateClosing => {
                if self.travel(0.0, dt_s) {
                    self.finish_calibration();
                }
            }
        }
        self.state.moving = self.motion != Motion::None;
        self.state.ready = self.state.calibrated && !self.state.error;
    }

    fn start(&mut self, action: Action) {
        match action {
            Action::Nothing => {}
            Action::Configure(configuration) => self.configuration = configuration,
            Action::Reset => self.state.error = false,
            Action::Stop => self.motion = Motion::None,
            Action::Go(target) => self.motion = Motion::Going(target),
            Action::ClearCalibration => self.forget_calibration(),
            Action::Reboot => {
                self.forget_calibration();
                self.state.error = false;
                self.configuration = Configuration::default();
            }
            Action::Calibrate => {
                self.forget_calibration();
                self.motion = Motion::CalibrateOpening;
            }
        }
    }

    fn forget_calibration(&mut self) {
        self.motion = Motion::None;
        self.state.calibrated = false;
        self.state.gripping = false;
        self.state.missed = false;
        self.state.force = 0.0;
    }

    fn finish_calibration(&mut self) {
        self.motion = Motion::None;
        // An object in the way hides the end of the travel.
        self.state.error = self.state.gripping;
        self.state.calibrated = !self.state.gripping;
        self.state.missed = false;
    }

    /// Moves the fingers towards `target` percent. True when they can go no further.
    fn travel(&mut self, target: f64, dt_s: f64) -> bool {
        let step_max = TRAVEL_PER_S * self.configuration.velocity * dt_s;
        let wanted =
            self.state.position + (target - self.state.position).clamp(-step_max, step_max);
        let contact = self.contact_position();
        // Opening leaves an object alone, even one thicker than the gap.
        let stopped = wanted < self.state.position && wanted <= contact;
        if stopped {
            self.state.position = self.state.position.min(contact);
        } else {
            self.state.position = wanted;
        }
        self.grip(stopped);
        self.state.missed = !stopped && target == 0.0 && self.state.position == 0.0;
        stopped || self.state.position == target
    }

    fn grip(&mut self, gripping: bool) {
        self.state.gripping = gripping;
        self.state.force = if gripping {
            self.configuration.holding_force
        } else {
            0.0
        };
    }

    /// Percent open at which the fingers touch the object; negative infinity without one.
    fn contact_position(&self) -> f64 {
        let percent = |width_m: f64| (width_m - self.closed_gap_m) / (2.0 * self.stroke_m) * 100.0;
        self.object_width_m.map_or(f64::NEG_INFINITY, percent)
    }
}
