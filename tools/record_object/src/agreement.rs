//! How two grasps fit together.

use icp_registration::{Hidden, Regrasp};
use serde_json::{Value, json};

/// The region that the gripper's fingers occlude, from the default parameters of `roi_crop`.
pub fn hidden() -> Hidden {
    let crop = roi_crop::Parameters::default();
    Hidden {
        below_m: crop.gripper_length_m - crop.grasp_depth_m,
        fingertips_m: crop.gripper_length_m,
        finger_width_m: crop.finger_width_m,
    }
}

/// In words.
pub fn to_text(found: &Regrasp) -> String {
    let (percent, rmse_mm) = (1e2 * found.fitness, 1e3 * found.rmse_m);
    let how = if found.upside_down {
        "upside down"
    } else {
        "upright, so that its lower end is still unseen"
    };
    format!("the second is the first {how}: {percent:.0} % of the points agree, to {rmse_mm:.1} mm")
}

/// For programs.
pub fn to_json(found: &Regrasp) -> Value {
    json!({
        "upside_down": found.upside_down,
        "fitness": found.fitness,
        "rmse_m": found.rmse_m,
    })
}
