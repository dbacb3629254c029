//! Waits for a person.

use crate::record::Screen;
use anyhow::{Result, bail};
use node::Node;
use std::io::BufRead;
use tokio::sync::oneshot;

/// Asks for the second grasp, and returns when Enter is pressed.
pub async fn until_enter(node: &Node, screen: &impl Screen) -> Result<()> {
    screen.note(
        "now the other end: open the gripper (rosservice call /grasp \"{command: open}\"), put the object back upside \
         down, close it, and press Enter",
    );
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
