//! Publishes the camera's pose as a static transform, and calibrates it on request.

mod shell;

use camera_mount::CameraMount;
use msg::Time;
use msg::geometry_msgs::TransformStamped;
use msg::tf2_msgs::TFMessage;
use node::{Latch, Node};
use std::process::ExitCode;

fn main() -> ExitCode {
    node::run("camera_mount", publish)
}

async fn publish(node: Node) -> anyhow::Result<()> {
    let mount = node.parameters(CameraMount::validate)?;
    let publisher = node.publish("/tf_static", 1, Latch::Yes)?;
    publisher.send(static_transform(&mount, node.clock().now()));
    let _calibration = shell::Service::offer(&node, mount, publisher)?;
    node.until_shutdown().await;
    Ok(())
}

fn static_transform(mount: &CameraMount, stamp: Time) -> TFMessage {
    let mut transform = TransformStamped {
        child_frame_id: mount.child_frame.clone(),
        transform: msg::transform::from_isometry(&mount.parent_from_camera()),
        ..Default::default()
    };
    transform.header.frame_id = mount.parent_frame.clone();
    transform.header.stamp = stamp;
    TFMessage {
        transforms: vec![transform],
    }
}
