//! What a RealSense D435i on the robot's head would see of an object in the gripper.
//!
//! A [`Scene`] (object, gripper, arm, wall) in a [`Placement`] is rendered into inverse depth, and a
//! [`Noise`] makes of that what a stereo camera would measure. [`Playback`] makes depth images of
//! recorded clouds instead. No ROS here: the node is in `main.rs`, and training uses this library.
//!
//! Frames: optical (x right, y down, z forward), `left_hand` and Baxter's `base`; metres throughout.

mod gripper;
mod held;
mod image;
mod integration;
mod intrinsics;
mod mount;
mod noise;
mod parameters;
mod placement;
mod playback;
mod raster;
mod reflex;
mod scene;
mod stereo;

pub use held::{Grip, Held, HeldError};
pub use image::{DepthImage, InverseDepth};
pub use integration::{integrate, moments};
pub use intrinsics::{D435I, Intrinsics, deproject, project};
pub use mount::Mount;
pub use noise::{Noise, NoiseParameters};
pub use parameters::{CapturesFrame, Parameters};
pub use placement::{Placement, scan_base_from_camera, scan_base_from_hand};
pub use playback::{Capture, CaptureFrame, Playback, PlaybackError};
pub use raster::Renderer;
pub use scene::{Link, OBJECT_BOTTOM_Z_M, Scene};
