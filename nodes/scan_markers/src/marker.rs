//! Markers for RViz (visualization_msgs).

use msg::geometry_msgs::{Pose, Quaternion};
use msg::std_msgs::ColorRGBA;
use msg::transform::from_point;
use msg::visualization_msgs::{Marker, MarkerArray};
use nalgebra::Point3;
use scan_markers::Words;
use std::collections::BTreeMap;

/// Height of a letter, m.
const LETTER_M: f64 = 0.04;

/// The set of markers to show, and those that RViz has to delete.
#[derive(Default)]
pub struct Board {
    drawn: BTreeMap<(String, i32), Marker>,
    /// The markers to delete, with their frames. RViz carries out a deletion without a frame_id at once, ahead of additions that it
    /// still holds back for their transform, and would draw those afterwards.
    wiped: BTreeMap<(String, i32), String>,
    is_new: bool,
}

impl Board {
    /// Adds a marker, or replaces the one with the same namespace and id.
    pub fn draw(&mut self, marker: Marker) {
        let key = (marker.ns.clone(), marker.id);
        if self.drawn.get(&key) == Some(&marker) {
            return;
        }
        self.is_new = true;
        self.wiped.remove(&key);
        self.drawn.insert(key, marker);
    }

    /// Deletes the markers of a namespace.
    pub fn wipe(&mut self, name: &str) {
        self.wipe_all(|(ns, _)| ns == name);
    }

    /// Deletes all markers.
    pub fn clear(&mut self) {
        self.wipe_all(|_| true);
    }

    fn wipe_all(&mut self, concerns: impl Fn(&(String, i32)) -> bool) {
        let keys: Vec<_> = self
            .drawn
            .keys()
            .filter(|key| concerns(key))
            .cloned()
            .collect();
        for key in keys {
            self.is_new = true;
            let frame = self.drawn.remove(&key).map(|marker| marker.header.frame_id);
            self.wiped.insert(key, frame.unwrap_or_default());
        }
    }

    /// The message with all markers, if they have changed since the last call.
    pub fn news(&mut self) -> Option<MarkerArray> {
        std::mem::take(&mut self.is_new).then(|| self.message())
    }

    /// All markers, not only changes, so that the latched last message is the whole picture.
    fn message(&self) -> MarkerArray {
        let wiped = self.wiped.iter().map(|((ns, id), frame)| {
            let mut marker = Marker {
                ns: ns.clone(),
                id: *id,
                action: i32::from(Marker::DELETE),
                ..Default::default()
            };
            marker.header.frame_id.clone_from(frame);
            marker
        });
        MarkerArray {
            markers: wiped.chain(self.drawn.values().cloned()).collect(),
        }
    }
}

/// A cloud, as squares of side `size_m`.
pub fn points(
    (name, id): (&str, u32),
    frame: &str,
    cloud: &[Point3<f64>],
    size_m: f64,
    colour: [f32; 3],
) -> Marker {
    let mut marker = blank(name, id, frame, Marker::POINTS, colour);
    (marker.scale.x, marker.scale.y) = (size_m, size_m);
    marker.points = cloud.iter().map(from_point).collect();
    marker
}

/// A line of text that always faces the viewer.
pub fn text((name, id): (&str, u32), frame: &str, place: &Point3<f64>, words: &Words) -> Marker {
    let mut marker = blank(name, id, frame, Marker::TEXT_VIEW_FACING, words.colour);
    marker.pose.position = from_point(place);
    marker.scale.z = LETTER_M;
    marker.text.clone_from(&words.text);
    marker
}

/// A line through these points.
pub fn line(
    (name, id): (&str, u32),
    frame: &str,
    path: &[Point3<f64>],
    colour: [f32; 3],
) -> Marker {
    let mut marker = blank(name, id, frame, Marker::LINE_STRIP, colour);
    marker.scale.x = 0.008;
    marker.points = path.iter().map(from_point).collect();
    marker
}

fn blank(name: &str, id: u32, frame: &str, kind: u8, [r, g, b]: [f32; 3]) -> Marker {
    let orientation = Quaternion {
        w: 1.0,
        ..Default::default()
    };
    // With stamp 0 RViz uses the newest transform, and with frame_locked it does so for every rendered image.
    let mut marker = Marker {
        ns: name.into(),
        id: id as i32,
        type_: i32::from(kind),
        action: i32::from(Marker::ADD),
        pose: Pose {
            orientation,
            ..Default::default()
        },
        color: ColorRGBA { r, g, b, a: 1.0 },
        frame_locked: true,
        ..Default::default()
    };
    marker.header.frame_id = frame.into();
    marker
}

#[cfg(test)]
mod tests {
    use super::*;

    fn actions(board: &Board) -> Vec<(String, i32, i32)> {
        let markers = board.message().markers;
        markers
            .into_iter()
            .map(|marker| (marker.ns, marker.id, marker.action))
            .collect()
    }

    #[test]
    fn the_last_message_is_the_whole_picture() {
        let mut board = Board::default();
        let mark = |name, id| blank(name, id, "base", Marker::POINTS, [1.0; 3]);
        board.draw(mark("views", 0));
        board.draw(mark("views", 1));
        board.draw(mark("answer", 0));
        board.wipe("views");
        board.draw(mark("views", 0));
        let expected = [("views", 1, 2), ("answer", 0, 0), ("views", 0, 0)];
        assert_eq!(
            actions(&board),
            expected.map(|(name, id, action)| (name.to_owned(), id, action))
        );
        board.clear();
        assert!(actions(&board).iter().all(|(.., action)| *action == 2));
    }
}
