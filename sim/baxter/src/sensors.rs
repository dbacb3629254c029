//! What the robot reports of its joints.

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

/// One joint_states message's worth: rad, rad/s, Nm (metres for fingers). All lists have one length.
#[derive(Debug, Clone, PartialEq)]
pub struct JointStates {
    /// Joint names.
    pub names: Vec<&'static str>,
    /// Positions.
    pub positions: Vec<f64>,
    /// Velocities.
    pub velocities: Vec<f64>,
    /// Efforts; the simulation has none.
    pub efforts: Vec<f64>,
}

impl JointStates {
    pub(crate) fn new(joints: impl IntoIterator<Item = (&'static str, f64, f64)>) -> Self {
        let mut states = Self {
            names: vec![],
            positions: vec![],
            velocities: vec![],
            efforts: vec![],
        };
        for (name, position, velocity) in joints {
            states.names.push(name);
            states.positions.push(position);
            states.velocities.push(velocity);
            states.efforts.push(0.0);
        }
        states
    }
}

/// Encoders with a little noise.
#[derive(Debug, Clone)]
pub(crate) struct Encoders {
    random: Pcg64Mcg,
    position_noise_rad: f64,
    velocity_noise_rad_s: f64,
}

impl Encoders {
    pub fn new(seed: u64, position_noise_rad: f64, velocity_noise_rad_s: f64) -> Self {
        let random = Pcg64Mcg::seed_from_u64(seed);
        Self {
            random,
            position_noise_rad,
            velocity_noise_rad_s,
        }
    }

    /// Position and velocity as read.
    pub fn read(&mut self, position_rad: f64, velocity_rad_s: f64) -> (f64, f64) {
        let mut normal = |sigma: f64| {
            let unit: f64 = StandardNormal.sample(&mut self.random);
            sigma * unit
        };
        let position_noise = normal(self.position_noise_rad);
        let velocity_noise = normal(self.velocity_noise_rad_s);
        (
            position_rad + position_noise,
            velocity_rad_s + velocity_noise,
        )
    }
}
