//! Makes a mesh of the object in the hand: turns it before the camera as far as the wrist goes, and, put back another way by
//! a person, once more.

mod agreement;
mod file;
mod grasp;
mod lower_end;
mod mesh;
mod prompt;
mod record;
mod unseen;

pub use file::Target;
pub use grasp::Grasp;
pub use lower_end::with_lower_end;
pub use mesh::Recorded;
pub use record::{Grasps, Made, Motion, Order, SEEN_MIN, Screen, record};
pub use unseen::Unseen;
