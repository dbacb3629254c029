//! What was cut away, and where: for RViz.

use msg::Duration;
use msg::deformable_cobot::ObjectCloud;
use msg::geometry_msgs::{Point, Pose, Quaternion, Vector3};
use msg::sensor_msgs::PointCloud2;
use msg::std_msgs::ColorRGBA;
use msg::visualization_msgs::Marker;
use nalgebra::Point3;
use node::{Latch, Node, Publisher};
use roi_crop::{Bounds, Cropper};

/// Publishes the region and what was removed.
pub struct Display {
    region: Publisher<Marker>,
    removed: Publisher<PointCloud2>,
}

impl Display {
    pub fn new(node: &Node) -> anyhow::Result<Self> {
        Ok(Self {
            region: node.publish("object/region", 2, Latch::Yes)?,
            removed: node.publish("object/removed", 2, Latch::Yes)?,
        })
    }

    /// Whether somebody looks at what was removed.
    pub fn is_watched(&self) -> bool {
        self.removed.is_subscribed()
    }

    /// Shows how the object was cut out of `registered`, which may be absent while nobody watches.
    pub fn show(&self, cropper: &Cropper, registered: Option<&PointCloud2>, object: &ObjectCloud) {
        if !object.error.is_empty() {
            return;
        }
        if object.in_hand_frame {
            let frame = object.header.frame_id.clone();
            self.region.send(cylinder(frame, cropper.bounds()));
        }
        let points = |cloud| Some(msg::cloud::to_points(cloud).ok()?.points);
        if let Some(all) = registered.and_then(points)
            && let Some(kept) = points(&object.cloud)
        {
            let removed = without(&all, &kept);
            self.removed
                .send(msg::cloud::from_points(object.header.clone(), &removed));
        }
    }
}

/// Points of `all` that are not in `kept`, which is a part of it in the same order.
fn without(all: &[Point3<f32>], kept: &[Point3<f32>]) -> Vec<Point3<f32>> {
    let mut kept = kept.iter().peekable();
    let is_removed = |point: &&Point3<f32>| kept.next_if_eq(point).is_none();
    all.iter().filter(is_removed).copied().collect()
}

/// Without a stamp: it holds wherever the hand is.
fn cylinder(frame: String, bounds: Bounds) -> Marker {
    let mut marker = Marker {
        ns: "region".into(),
        type_: Marker::CYLINDER as i32,
        action: Marker::ADD as i32,
        pose: Pose {
            position: Point {
                z: (bounds.bottom_m + bounds.top_m) / 2.0,
                ..Default::default()
            },
            orientation: Quaternion {
                w: 1.0,
                ..Default::default()
            },
        },
        scale: Vector3 {
            x: 2.0 * bounds.radius_m,
            y: 2.0 * bounds.radius_m,
            z: bounds.top_m - bounds.bottom_m,
        },
        color: ColorRGBA {
            r: 0.3,
            g: 0.6,
            b: 1.0,
            a: 0.25,
        },
        frame_locked: true,
        lifetime: Duration::default(),
        ..Default::default()
    };
    marker.header.frame_id = frame;
    marker
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_not_removed() {
        let point = |x: u8| Point3::new(f32::from(x), 0.0, 0.0);
        let all: Vec<_> = [1, 2, 2, 3, 4].map(point).into();
        assert_eq!(without(&all, &[2, 4].map(point)), [1, 2, 3].map(point));
        assert_eq!(without(&all, &[]), all);
        assert!(without(&all, &all).is_empty());
    }
}
