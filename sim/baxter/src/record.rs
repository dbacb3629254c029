//! What the robot was told and did, written to a folder for tests to read.
//!
//! `PID.csv` has a row for each period in which an arm moved or had a setpoint: the time of day (s since the epoch), the arm, and
//! the setpoint (rad; empty for none), the angle (rad) and the velocity (rad/s) of its W2. `PID.violations` has a line for each
//! violation of the contract of motion.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use anyhow::Context;
use baxter::{Side, W2};
use sim_baxter::Robot;

/// Names the folder.
const VARIABLE: &str = "DEFORMABLE_COBOT_RECORD";
/// Speed that is worth a row, rad/s.
const MOVING_RAD_S: f64 = 1e-3;

/// The files; none where nobody asked for them.
pub struct Record(Option<Files>);

struct Files {
    rows: File,
    violations: File,
}

impl Record {
    /// In the folder that the environment names, if any.
    ///
    /// # Errors
    /// No files can be made there.
    pub fn from_environment() -> anyhow::Result<Self> {
        let Some(folder) = std::env::var_os(VARIABLE).map(PathBuf::from) else {
            return Ok(Self(None));
        };
        let files = Files::create(&folder);
        let files = files.with_context(|| format!("{VARIABLE} is {}", folder.display()))?;
        Ok(Self(Some(files)))
    }

    /// Writes what is new.
    pub fn write(&mut self, robot: &mut Robot) {
        let violations = robot.take_violations();
        for violation in &violations {
            log::error!("contract of motion: {violation}");
        }
        let Some(files) = &mut self.0 else { return };
        if let Err(error) = files.write(robot, &violations) {
            log::error!("the record ends: {error}");
            self.0 = None;
        }
    }
}

impl Files {
    fn create(folder: &Path) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let file = |extension: &str| {
            let name = format!("{}.{extension}", std::process::id());
            File::create(folder.join(name))
        };
        let mut rows = file("csv")?;
        writeln!(rows, "time_s,arm,setpoint_rad,angle_rad,velocity_rad_s")?;
        let violations = file("violations")?;
        Ok(Self { rows, violations })
    }

    fn write(&mut self, robot: &Robot, violations: &[String]) -> std::io::Result<()> {
        let since_epoch = SystemTime::UNIX_EPOCH.elapsed().unwrap_or_default();
        let time_s = since_epoch.as_secs_f64();
        for side in Side::BOTH {
            let arm = robot.arm(side);
            let (angle_rad, velocity_rad_s) = (arm.angles_rad()[W2], arm.velocities_rad_s()[W2]);
            let setpoint_rad = arm.position_goals_rad()[W2];
            if setpoint_rad.is_none() && velocity_rad_s.abs() < MOVING_RAD_S {
                continue;
            }
            let setpoint = setpoint_rad.map(|angle_rad| angle_rad.to_string());
            writeln!(
                self.rows,
                "{time_s:.6},{},{},{angle_rad:.6},{velocity_rad_s:.6}",
                side.name(),
                setpoint.unwrap_or_default()
            )?;
        }
        for violation in violations {
            writeln!(self.violations, "{violation}")?;
        }
        Ok(())
    }
}
