//! The interface of the package: its ROS messages as Rust types, and their conversion to and from points, poses, times
//! and what the robot says of itself.
//!
//! `rosrust_msg` makes the types from the definitions beside this crate and from those that ROS installs
//! (`.cargo/config.toml` says where); this crate names the ones in use.

pub mod cloud;
pub mod progress;
pub mod robot;
pub mod service;
pub mod stamp;
pub mod timing;
pub mod transform;
pub mod view;

pub use rosrust::{Duration, Message, Time};
pub use rosrust_msg::{
    actionlib_msgs, baxter_core_msgs, deformable_cobot, diagnostic_msgs, dynamic_reconfigure,
    geometry_msgs, reflex_msgs, rosgraph_msgs, sensor_msgs, std_msgs, std_srvs, tf2_msgs,
    visualization_msgs,
};
