//! Parameters of the node.

use crate::moved::MovedToScanServer;
use crate::passage::PassageRules;
use crate::pose_check::PoseRules;
use crate::rests::RestRules;
use crate::sweep::SweepRules;
use baxter::{REST_DWELL_S, REST_VELOCITY_RAD_S, Side};
use parameter::{DEPTH_RANGE_M, ParameterError, Tunable, check_ranges, tunables};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Share of `sweep_range_rad` that makes a turn a sweep in passive mode: the ends of a motion are slow, and no views.
const SWEEP_SHARE_MIN: f64 = 0.75;

/// Who turns the wrist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// This node asks `rotate_wrist` for each angle.
    Active,
    /// Somebody else does, or a recording; this node watches the joint states.
    Passive,
}

/// How the wrist turns during a scan on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// In one sweep, with views while it turns.
    Sweep,
    /// To one angle after the other, where it comes to rest for a view, as in the paper.
    Steps,
}

/// What `~` may hold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// Who turns the wrist: active or passive.
    pub mode: Mode,
    /// Arm whose hand holds the object: left or right.
    pub side: Side,
    /// TF frame whose +z is up.
    pub base_frame: String,
    /// How far the gripper may lean from straight up before a scan, rad (active mode, with TF).
    pub tilt_max_rad: f64,
    /// Nearest depth at which the object may be from the camera, m (active mode, with TF).
    pub depth_min_m: f64,
    /// Farthest depth at which it may be, m (active mode, with TF).
    pub depth_max_m: f64,
    /// Where the object is on the hand's axis: from, m.
    pub object_z_min_m: f64,
    /// Where the object is on the hand's axis: to, m.
    pub object_z_max_m: f64,
    /// Whether TF knows where the camera is from the hand; without it views carry no pose.
    pub use_tf: bool,
    /// Views of a scan by steps unless the caller says otherwise.
    pub view_count: u32,
    /// Angle of the left wrist in the middle of the views, rad; the right arm mirrors the left.
    pub centre_angle_rad: f64,
    /// Wrist turn between views, rad; smaller where the range is not enough.
    pub view_step_rad: f64,
    /// How a scan turns the wrist where its caller asks for neither views nor a range: sweep or steps. In passive mode, how it
    /// is turned.
    pub motion: Motion,
    /// How far a sweep turns, rad.
    pub sweep_range_rad: f64,
    /// How fast a sweep turns, rad/s; at most velocity_max_rad_s of wrist_rotator.
    pub sweep_rate_rad_s: f64,
    /// Turn between the views of a sweep, rad.
    pub view_spacing_rad: f64,
    /// Longest exposure of the camera, s.
    pub exposure_s: f64,
    /// Distance of the object's surface from the wrist's axis, m; how far it moves during an exposure is limited.
    pub blur_radius_m: f64,
    /// How far it may move during an exposure, m.
    pub blur_max_m: f64,
    /// Largest difference between the clocks of joint states and images that sweeps have shown, s; beyond it none is made.
    pub time_offset_max_s: f64,
    /// Smallest wrist angle, rad.
    pub angle_min_rad: f64,
    /// Largest wrist angle, rad.
    pub angle_max_rad: f64,
    /// Time for one turn of the wrist, s.
    pub motion_deadline_s: f64,
    /// Time for a cloud to come after the wrist is at rest, s.
    pub frame_deadline_s: f64,
    /// Time for TF to reach the stamp of a cloud, s.
    pub transform_deadline_s: f64,
    /// Offset of another computer's clock from which on diagnostics warn, s.
    pub clock_offset_warn_s: f64,
    /// Offset of another computer's clock from which on no view is taken, s (active mode).
    pub clock_offset_max_s: f64,
    /// Speed of the wrist that still counts as rest, rad/s (passive mode).
    pub rest_velocity_rad_s: f64,
    /// Shortest rest of which a view is taken, s (passive mode).
    pub rest_dwell_s: f64,
    /// Least turn from one view to the next, rad (passive mode).
    pub separation_rad: f64,
    #[serde(skip_serializing)]
    pub(crate) answer_deadline_s: MovedToScanServer,
    #[serde(skip_serializing)]
    pub(crate) scan_at_start: MovedToScanServer,
    #[serde(skip_serializing)]
    pub(crate) stop_when_confident: MovedToScanServer,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            mode: Mode::Active,
            side: Side::Left,
            base_frame: "base".into(),
            tilt_max_rad: 15.0_f64.to_radians(),
            depth_min_m: *DEPTH_RANGE_M.start(),
            depth_max_m: *DEPTH_RANGE_M.end(),
            object_z_min_m: 0.1277,
            object_z_max_m: 0.22,
            use_tf: true,
            view_count: 3,
            centre_angle_rad: 0.0,
            view_step_rad: 0.6,
            motion: Motion::Sweep,
            sweep_range_rad: 1.2,
            sweep_rate_rad_s: 1.15,
            view_spacing_rad: 0.1,
            // A D435i exposes at most as long as an image takes at 30 Hz.
            exposure_s: 0.033,
            blur_radius_m: 0.045,
            blur_max_m: 0.002,
            time_offset_max_s: 0.05,
            angle_min_rad: -3.0,
            angle_max_rad: 3.0,
            motion_deadline_s: 15.0,
            frame_deadline_s: 2.0,
            transform_deadline_s: 1.0,
            clock_offset_warn_s: 0.02,
            clock_offset_max_s: 0.1,
            rest_velocity_rad_s: REST_VELOCITY_RAD_S,
            rest_dwell_s: REST_DWELL_S,
            separation_rad: 0.1,
            answer_deadline_s: MovedToScanServer,
            scan_at_start: MovedToScanServer,
            stop_when_confident: MovedToScanServer,
        }
    }
}

impl Parameters {
    /// What may change from one scan to the next.
    pub const TUNABLES: &[Tunable<Self>] = tunables! { Self;
        view_count: u32, 1..=64, "", "Views of a scan unless the caller says otherwise";
        view_step_rad: f64, 0.001..=3.2, "rad", "Wrist turn between views";
        sweep_range_rad: f64, 0.05..=6.2, "rad", "How far a sweep turns";
        sweep_rate_rad_s: f64, 0.05..=4.0, "rad/s", "How fast a sweep turns";
        view_spacing_rad: f64, 0.02..=3.2, "rad", "Turn between the views of a sweep";
    };

    /// Checks that every parameter is in its range.
    ///
    /// # Errors
    /// Names the first parameter that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        for tunable in Self::TUNABLES {
            tunable.check(self)?;
        }
        let (min, max) = (self.angle_min_rad, self.angle_max_rad);
        let (nearest_rad, farthest_rad) = match self.side {
            Side::Left => (min, max),
            Side::Right => (-max, -min),
        };
        check_ranges! { self;
            angle_max_rad: min..=7.0, "rad";
            centre_angle_rad: nearest_rad..=farthest_rad, "rad";
            exposure_s: 0.0..=1.0, "s";
            blur_radius_m: 0.0..=1.0, "m";
            blur_max_m: 0.0..=1.0, "m";
            time_offset_max_s: 0.0..=1.0, "s";
            tilt_max_rad: 0.0..=3.2, "rad";
            depth_max_m: 0.0..=65.0, "m";
            depth_min_m: 0.0..=self.depth_max_m, "m (depth_max_m)";
            object_z_max_m: 0.0..=2.0, "m";
            object_z_min_m: 0.0..=self.object_z_max_m, "m (object_z_max_m)";
            motion_deadline_s: 0.01..=600.0, "s";
            frame_deadline_s: 0.01..=600.0, "s";
            transform_deadline_s: 0.01..=600.0, "s";
            clock_offset_warn_s: 1e-3..=10.0, "s";
            clock_offset_max_s: 1e-3..=10.0, "s";
            rest_velocity_rad_s: 1e-4..=1.0, "rad/s";
            rest_dwell_s: 0.01..=10.0, "s";
            separation_rad: 1e-3..=3.2, "rad";
        }
        Ok(())
    }

    /// Angle of this side's wrist in the middle of the views, rad.
    pub fn middle_rad(&self) -> f64 {
        match self.side {
            Side::Left => self.centre_angle_rad,
            Side::Right => -self.centre_angle_rad,
        }
    }

    /// Where the hand must be before a scan.
    pub fn pose_rules(&self) -> PoseRules {
        PoseRules {
            tilt_max_rad: self.tilt_max_rad,
            depth_min_m: self.depth_min_m,
            depth_max_m: self.depth_max_m,
            object_z_m: [self.object_z_min_m, self.object_z_max_m],
        }
    }

    /// What counts as a rest in passive mode.
    pub fn rest_rules(&self) -> RestRules {
        RestRules {
            rest_velocity_rad_s: self.rest_velocity_rad_s,
            dwell: Duration::from_secs_f64(self.rest_dwell_s),
            separation_rad: self.separation_rad,
        }
    }

    /// What makes a scan in passive mode by sweeps.
    pub fn passage_rules(&self) -> PassageRules {
        PassageRules {
            range_min_rad: SWEEP_SHARE_MIN * self.sweep_range_rad,
            spacing_rad: self.view_spacing_rad,
        }
    }

    /// What makes a scan in passive mode.
    pub fn sweep_rules(&self) -> SweepRules {
        SweepRules {
            view_count: self.view_count as usize,
            separation_rad: self.separation_rad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parameter::refused_name;

    #[test]
    fn defaults_are_valid_and_bad_values_named() {
        assert_eq!(Parameters::default().validate(), Ok(()));
        let bad = |change: fn(&mut Parameters)| refused_name(Parameters::validate, change);
        assert_eq!(bad(|p| p.view_count = 0), Some("view_count"));
        assert_eq!(bad(|p| p.centre_angle_rad = 4.0), Some("centre_angle_rad"));
        assert_eq!(bad(|p| p.view_step_rad = f64::NAN), Some("view_step_rad"));
        assert_eq!(bad(|p| p.frame_deadline_s = -1.0), Some("frame_deadline_s"));
        assert_eq!(bad(|p| p.angle_max_rad = -4.0), Some("angle_max_rad"));
    }

    #[test]
    fn what_moved_to_another_node_is_named() {
        for key in ["answer_deadline_s", "scan_at_start", "stop_when_confident"] {
            let read: Result<Parameters, _> = serde_yaml::from_str(&format!("{key}: 1"));
            let error = read
                .err()
                .map(|error| error.to_string())
                .unwrap_or_default();
            // Which one it is, the node's reader of parameters adds.
            assert!(error.contains("scan_server"), "{key}: {error}");
        }
        let written = serde_yaml::to_string(&Parameters::default()).unwrap_or_default();
        assert!(written.contains("view_count") && !written.contains("scan_at_start"));
    }
}
