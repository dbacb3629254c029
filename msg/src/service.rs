//! Definitions of the package's services.
//!
//! The types of a service do not carry their definitions as those of a message do, but whoever decodes what arrives over
//! the network needs them to check lengths first.

use rosrust::{Message, ServicePair};
use rosrust_msg::deformable_cobot::*;
use rosrust_msg::dynamic_reconfigure::{Config, Reconfigure};
use rosrust_msg::std_srvs::Trigger;

/// A service whose request and response definitions are known.
pub trait Service: ServicePair {
    /// Text of the request, with the messages that it uses, as in `gendeps --cat`.
    fn request_definition() -> String;
    /// The same for the response.
    fn response_definition() -> String;
}

macro_rules! services {
    ($($name:ident ($($message:ty),*);)*) => {$(
        impl Service for $name {
            fn request_definition() -> String {
                definition(part(include_str!(concat!("../deformable_cobot/srv/", stringify!($name), ".srv")), 0),
                    &[$((<$message>::msg_type(), <$message>::msg_definition())),*])
            }
            fn response_definition() -> String {
                definition(part(include_str!(concat!("../deformable_cobot/srv/", stringify!($name), ".srv")), 1),
                    &[$((<$message>::msg_type(), <$message>::msg_definition())),*])
            }
        }
    )*};
}

services! {
    RotateWrist();
    SweepWrist();
    ScanObject(Classification);
    SweepObject(Classification);
    CaptureViews(View);
    PlanViews();
    RegisterViews(View, RegisteredCloud);
    CropCloud(RegisteredCloud, ObjectCloud);
    ClassifyCloud(rosrust_msg::sensor_msgs::PointCloud2, rosrust_msg::geometry_msgs::Vector3, Classification);
    LoadModel();
    MeasureDeformation(rosrust_msg::sensor_msgs::PointCloud2, rosrust_msg::geometry_msgs::Vector3, rosrust_msg::geometry_msgs::Point, Deformation);
    HoldObject();
    CalibrateCameraMount(rosrust_msg::geometry_msgs::Transform, rosrust_msg::geometry_msgs::Vector3, rosrust_msg::geometry_msgs::Quaternion);
    Grasp();
}

impl Service for Trigger {
    fn request_definition() -> String {
        String::new()
    }
    fn response_definition() -> String {
        "bool success\nstring message\n".into()
    }
}

impl Service for Reconfigure {
    fn request_definition() -> String {
        definition(
            "dynamic_reconfigure/Config config\n",
            &[(Config::msg_type(), Config::msg_definition())],
        )
    }
    fn response_definition() -> String {
        Self::request_definition()
    }
}

fn part(source: &'static str, index: usize) -> &'static str {
    source.split("---\n").nth(index).unwrap_or_default()
}

fn definition(text: &str, messages: &[(String, String)]) -> String {
    let separator = "=".repeat(80);
    // Names without a package mean this one, which the reader cannot know of a bare text.
    let mut whole = format!("{text}\n");
    for (name, body) in messages {
        whole += &format!("{separator}\nMSG: {name}\n{body}\n");
    }
    whole
}
