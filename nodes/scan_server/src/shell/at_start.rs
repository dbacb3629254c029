//! The scan that nobody asks for, of recorded captures.

use super::stages::Graph;
use msg::sensor_msgs::PointCloud2;
use node::{Expect, Level, Node};
use scan_server::{Parameters, Scanner};
use std::convert::Infallible;
use std::time::Duration;
use tokio::sync::watch;

/// Pause between looks for who turns the wrist.
const LOOK_PERIOD: Duration = Duration::from_millis(200);

/// Scans once when the first cloud has come, if configured so; then, and otherwise, waits for ever.
pub async fn scan(node: &Node, parameters: &Parameters, scanner: &Scanner<Graph>) -> Infallible {
    if parameters.scan_at_start
        && let Err(error) = scan_once(node, parameters, scanner).await
    {
        log::error!("no scan at the start: {error:#}");
        node.health()
            .set("scan_at_start", Level::Error, format!("{error:#}"));
    }
    std::future::pending().await
}

async fn scan_once(
    node: &Node,
    parameters: &Parameters,
    scanner: &Scanner<Graph>,
) -> anyhow::Result<()> {
    let (seen, mut is_seen) = watch::channel(false);
    let points = node.subscribe("points", Expect::OPTIONAL_STATE, move |_: PointCloud2| {
        seen.send_replace(true);
    })?;
    let _ = is_seen.wait_for(|seen| *seen).await;
    if !parameters.scan_at_start_moves_arm && has_wrist(node).await? {
        anyhow::bail!(
            "wrist_rotator is in the graph, and the arm must not move where nobody waits for it; \
             call scan_object, or set scan_at_start_moves_arm of scan_server to true"
        );
    }
    scanner.scan(0, &node.life()).await;
    drop(points);
    Ok(())
}

/// Whether `rotate_wrist` turns a wrist, once somebody offers it. A player of captures shows the next one instead, and has
/// nothing that could be stopped.
async fn has_wrist(node: &Node) -> anyhow::Result<bool> {
    while !node.is_served("rotate_wrist")? {
        tokio::time::sleep(LOOK_PERIOD).await;
    }
    node.is_served("stop_wrist")
}
