//! Waits for a person.

use anyhow::{Result, bail};
use node::Node;
use std::io::BufRead;
use tokio::sync::oneshot;

/// Returns when Enter is pressed.
///
/// # Errors
/// Nobody can press it, or the program is asked to end.
pub async fn until_enter(node: &Node) -> Result<()> {
    let (sender, pressed) = oneshot::channel();
    // A read cannot be called off; on a thread of its own it does not hold up the program's end.
    std::thread::spawn(move || {
        let mut line = String::new();
        let read = std::io::stdin().lock().read_line(&mut line);
        let _ = sender.send(read.is_ok_and(|count| count > 0));
    });
    let pressed = tokio::select! {
        pressed = pressed => pressed.unwrap_or(false),
        () = node.until_shutdown() => bail!("stopped on request, before the second grasp"),
    };
    if !pressed {
        bail!("nobody can press Enter here; give --grasps 1, or run it on a terminal");
    }
    Ok(())
}
