//! Publishes where the camera sits as a fixed transform.

use camera_mount::CameraMount;
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
    let mut transform = TransformStamped {
        child_frame_id: mount.child_frame.clone(),
        transform: msg::transform::from_isometry(&mount.parent_from_camera()),
        ..Default::default()
    };
    transform.header.frame_id = mount.parent_frame;
    transform.header.stamp = node.clock().now();
    publisher.send(TFMessage {
        transforms: vec![transform],
    });
    node.until_shutdown().await;
    Ok(())
}
