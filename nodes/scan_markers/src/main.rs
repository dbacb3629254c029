//! Draws scans for RViz.

mod marker;
mod scene;

use msg::deformable_cobot::{Classification, ScanObjectFeedback, View};
use msg::visualization_msgs::MarkerArray;
use node::{Expect, Latch, Node, Publisher, Subscriber};
use scan_markers::Parameters;
use scene::Scene;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

fn main() -> ExitCode {
    node::run("scan_markers", serve)
}

async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters = node.parameters(Parameters::validate)?;
    let renderer = Arc::new(Renderer {
        scene: Mutex::new(Scene::new(parameters, node.transforms()?)),
        clouds: node.publish("scan_markers/clouds", 4, Latch::Yes)?,
        words: node.publish("scan_markers/words", 4, Latch::Yes)?,
    });
    let _links: [Subscriber; 4] = [
        node.subscribe(
            "progress",
            Expect::STATE,
            renderer.on(|scene, report: ScanObjectFeedback| {
                scene.on_progress(&report);
                Ok(())
            }),
        )?,
        node.subscribe(
            "views",
            Expect::EVENTS,
            renderer.on(|scene, view: View| scene.on_view(&view)),
        )?,
        node.subscribe(
            "registered",
            Expect::EVENTS,
            renderer.on(Scene::on_registered),
        )?,
        node.subscribe(
            "classification",
            Expect::EVENTS,
            renderer.on(|scene, answer: Classification| {
                scene.on_answer(&answer);
                Ok(())
            }),
        )?,
    ];
    node.until_shutdown().await;
    Ok(())
}

/// The scene and its publishers.
struct Renderer {
    scene: Mutex<Scene>,
    clouds: Publisher<MarkerArray>,
    words: Publisher<MarkerArray>,
}

impl Renderer {
    /// Draws what a message changes.
    fn on<T, F>(self: &Arc<Self>, draw: F) -> impl Fn(T) + use<T, F>
    where
        F: Fn(&mut Scene, T) -> anyhow::Result<()>,
    {
        let renderer = Arc::clone(self);
        move |message| renderer.change(|scene| draw(scene, message))
    }

    fn change(&self, draw: impl FnOnce(&mut Scene) -> anyhow::Result<()>) {
        let mut scene = self.scene.lock().unwrap_or_else(PoisonError::into_inner);
        if let Err(error) = draw(&mut scene) {
            log::warn!("not drawn: {error:#}");
        }
        // Publish while the scene is locked, so that the last message is the newest picture.
        if let Some(picture) = scene.clouds.news() {
            self.clouds.send(picture);
        }
        if let Some(picture) = scene.words.news() {
            self.words.send(picture);
        }
    }
}
