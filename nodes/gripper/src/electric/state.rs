//! What an electric gripper says of itself.

/// Something that the gripper knows or does not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Flag {
    /// It is so.
    True,
    /// It is not.
    False,
    /// The gripper does not know.
    #[default]
    Unknown,
}

impl From<u8> for Flag {
    /// As in `EndEffectorState`.
    fn from(value: u8) -> Self {
        match value {
            0 => Self::False,
            1 => Self::True,
            _ => Self::Unknown,
        }
    }
}

/// What counts of `EndEffectorState`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ElectricState {
    /// To be echoed in commands.
    pub id: u32,
    /// Has power.
    pub enabled: Flag,
    /// Knows the ends of its travel.
    pub calibrated: Flag,
    /// Calibrated, and without error.
    pub ready: Flag,
    /// Fingers move.
    pub moving: Flag,
    /// Fingers were stopped by something.
    pub gripping: Flag,
    /// Fingers met nothing to the end of the travel.
    pub missed: Flag,
    /// Needs a reset.
    pub error: Flag,
    /// Percent open.
    pub position: f64,
    /// Sender of the last command taken.
    pub sender: String,
    /// Its number; some firmware leaves it at 0.
    pub sequence: u32,
}
