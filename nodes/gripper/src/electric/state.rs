//! State of an electric gripper.

/// A three-valued flag.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Flag {
    /// Yes.
    True,
    /// No.
    False,
    /// The gripper does not know.
    #[default]
    Unknown,
}

impl From<u8> for Flag {
    /// Constants of `baxter_core_msgs/EndEffectorState`.
    fn from(value: u8) -> Self {
        match value {
            0 => Self::False,
            1 => Self::True,
            _ => Self::Unknown,
        }
    }
}

/// The relevant fields of `baxter_core_msgs/EndEffectorState`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ElectricState {
    /// Hardware id, which commands must repeat.
    pub id: u32,
    /// Whether it has power.
    pub enabled: Flag,
    /// Whether it knows the ends of its travel.
    pub calibrated: Flag,
    /// Whether it is calibrated and without error.
    pub ready: Flag,
    /// Whether the fingers move.
    pub moving: Flag,
    /// Whether something stopped the fingers.
    pub gripping: Flag,
    /// Whether the fingers reached the end of the travel without meeting anything.
    pub missed: Flag,
    /// Whether it needs a reset.
    pub error: Flag,
    /// Position, percent open (0 to 100).
    pub position: f64,
    /// Sender of the last accepted command.
    pub sender: String,
    /// Sequence number of that command; some firmware leaves it at 0.
    pub sequence: u32,
}
