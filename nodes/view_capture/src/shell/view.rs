//! A view as a message.

use super::clouds::Shot;
use msg::Time;
use msg::deformable_cobot::{StageTime, View};
use msg::timing;
use node::Transforms;
use std::time::Duration;
use view_capture::Parameters;

/// The view of a cloud, with the hand's pose at a moment (that of the stamp, by the robot's clock) where TF is used. It has neither scan id nor index.
///
/// # Errors
/// TF does not reach the stamp within the configured time.
pub async fn view_of(
    shot: &Shot,
    moment: Time,
    angle_rad: f64,
    parameters: &Parameters,
    transforms: Option<&Transforms>,
) -> anyhow::Result<View> {
    let header = &shot.cloud.header;
    let mut view = View {
        kind: View::VIEW,
        header: header.clone(),
        wrist_angle: angle_rad,
        cloud: shot.cloud.clone(),
        ..Default::default()
    };
    if let Some(transforms) = transforms {
        let hand_frame = parameters.side.hand_frame();
        let patience = Duration::from_secs_f64(parameters.transform_deadline_s);
        let hand_from_camera = transforms
            .wait(hand_frame, &header.frame_id, moment, patience)
            .await?;
        view.has_pose = true;
        view.hand_frame = hand_frame.into();
        view.hand_from_camera = msg::transform::from_isometry(&hand_from_camera);
    }
    Ok(view)
}

/// How old the image was when its cloud came, and how long the cloud has since been kept until the wrist was known to rest.
pub fn timing(shot: &Shot, now: Time) -> Vec<StageTime> {
    let between = |begin: Time, end: Time| {
        let elapsed_ns = end.nanos().saturating_sub(begin.nanos()).max(0);
        Duration::from_nanos(elapsed_ns as u64)
    };
    vec![
        timing::stage("capture", between(shot.cloud.header.stamp, shot.arrived)),
        timing::stage("settle", between(shot.arrived, now)),
    ]
}
