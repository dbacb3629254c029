//! One image, of the simulated world or of a recorded one.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use msg::Time;
use nalgebra::Isometry3;
use node::Transforms;
use node::transforms::TransformError;
use sim_camera::{
    D435I, DepthImage, InverseDepth, Mount, Noise, Parameters, Placement, Playback, Renderer,
    integrate, moments,
};

use crate::messages;
use crate::world::World;

/// How long an exposure waits for the transforms of its moment.
const PATIENCE: Duration = Duration::from_millis(200);
const BASE_FRAME: &str = "base";

/// What the camera sees.
pub enum Source {
    /// A rendered scene; boxed because it is much larger than the other.
    Simulated(Box<Simulated>),
    /// Captures, one of which is shown.
    Recorded(Arc<Mutex<Playback>>),
}

/// A scene, and what turns it into images.
pub struct Simulated {
    world: Arc<Mutex<World>>,
    /// Frames of the arm begin so.
    side: &'static str,
    transforms: Transforms,
    mount: Mount,
    renderer: Renderer,
    noise: Option<Noise>,
    exposure_s: f64,
}

impl Source {
    /// A camera that looks at `world` from its mount on the robot.
    pub fn simulated(
        world: Arc<Mutex<World>>,
        transforms: Transforms,
        parameters: &Parameters,
    ) -> anyhow::Result<Self> {
        let noise = parameters
            .noise
            .then(|| Noise::new(parameters.noise_model.clone(), parameters.seed.into()))
            .transpose()?;
        let renderer = Renderer::new(D435I);
        Ok(Self::Simulated(Box::new(Simulated {
            world,
            side: parameters.side.name(),
            transforms,
            mount: parameters.mount.clone(),
            renderer,
            noise,
            exposure_s: parameters.exposure_s,
        })))
    }

    /// What is seen in an exposure whose middle is at the moment `stamp`.
    pub async fn expose(&mut self, stamp: Time) -> Result<DepthImage, TransformError> {
        match self {
            Self::Simulated(simulated) => simulated.expose(stamp).await,
            Self::Recorded(playback) => {
                let playback = playback.lock().unwrap_or_else(PoisonError::into_inner);
                Ok(playback.current().depth_image(&D435I))
            }
        }
    }
}

impl Simulated {
    async fn expose(&mut self, middle: Time) -> Result<DepthImage, TransformError> {
        if self.exposure_s == 0.0 {
            self.render(middle).await?;
            return Ok(self.measured(None));
        }
        let mut seen = Vec::new();
        for share in moments() {
            let after_ns = (share * self.exposure_s * 1e9) as i64;
            self.render(Time::from_nanos(middle.nanos() + after_ns))
                .await?;
            seen.push(self.renderer.last().clone());
        }
        Ok(self.measured(Some(&integrate(&seen))))
    }

    /// What the camera makes of an image; of the last one rendered, where there is none.
    fn measured(&mut self, image: Option<&InverseDepth>) -> DepthImage {
        let clean = image.unwrap_or(self.renderer.last());
        match &mut self.noise {
            Some(noise) => noise.apply(clean, &D435I),
            None => clean.to_depth_image(),
        }
    }

    /// Renders what is before the camera at a moment.
    async fn render(&mut self, stamp: Time) -> Result<(), TransformError> {
        let parent = &self.mount.parent_frame;
        let of_arm = |frame: &str| format!("{}_{frame}", self.side);
        let parent_from_hand = self
            .transforms
            .wait(parent, &of_arm("hand"), stamp, PATIENCE)
            .await?;
        let world = self.world.lock().unwrap_or_else(PoisonError::into_inner);
        let scene = world.scene();
        let optical_from_parent =
            (self.mount.parent_from_camera() * messages::camera_from_optical()).inverse();
        // Arm and wall are only background: without their transforms they are left out.
        let pose = |frame: &str| -> Option<Isometry3<f64>> {
            let parent_from_frame = self.transforms.lookup(parent, frame, stamp).ok()?;
            Some(optical_from_parent * parent_from_frame)
        };
        let placement = Placement {
            camera_from_hand: optical_from_parent * parent_from_hand,
            camera_from_links: scene
                .links
                .iter()
                .map(|link| pose(&of_arm(&link.frame)))
                .collect(),
            camera_from_base: pose(BASE_FRAME),
        };
        self.renderer.render(scene, &placement);
        Ok(())
    }
}
