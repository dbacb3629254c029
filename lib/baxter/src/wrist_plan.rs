//! How a scan turns the wrist.

/// How a scan turns the wrist, and so how many views it has.
#[derive(Debug, Clone, PartialEq)]
pub enum WristPlan {
    /// To each angle (rad), where it comes to rest for a view.
    Rests(Vec<f64>),
    /// Through a range, with views while it turns.
    Sweep {
        /// How far, rad.
        range_rad: f64,
        /// Views, if none is left out.
        count: u32,
    },
}

impl WristPlan {
    /// Number of views, if none is left out.
    pub fn count(&self) -> u32 {
        match self {
            Self::Rests(angles_rad) => angles_rad.len() as u32,
            Self::Sweep { count, .. } => *count,
        }
    }
}
