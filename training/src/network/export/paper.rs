//! The paper's network as a graph.

use onnx_file::Attribute;

use super::Graph;
use crate::network::{Head, Linear, PaperNetwork};

impl Graph {
    /// The paper's network, up to its logits.
    pub(super) fn paper(&mut self, network: &PaperNetwork) -> String {
        let normals = network.architecture.normals;
        let coordinates = if normals { self.split() } else { "clouds" };
        let summary = self.largest_features(&network.transform_points, "clouds");
        let turn = self.layer(&network.transform_head, &summary);
        let turn = self.reshape(&turn, &[-1, 3, 3]);
        self.0.node("MatMul", &[coordinates, &turn], "turned", &[]);
        let placed = if normals { self.join() } else { "turned" };
        let seen = match network.architecture.head {
            Head::Pool => self.largest_features(&network.points, placed),
            Head::Flatten => {
                let features = self.relu_layer(&network.points[0], placed);
                let features = self.relu_layer(&network.points[1], &features);
                let count = network.head.weight.dims()[0] as i64;
                self.reshape(&features, &[-1, count])
            }
        };
        self.layer(&network.head, &seen)
    }

    /// Coordinates and normals of the clouds.
    fn split(&mut self) -> &'static str {
        let last = [("axis", Attribute::Int(2))];
        for (name, columns) in [("coordinates", [0, 1, 2]), ("normals", [3, 4, 5])] {
            let indices = format!("{name}.columns");
            self.0.constant_i64(&indices, &[3], &columns);
            self.0.node("Gather", &["clouds", &indices], name, &last);
        }
        "coordinates"
    }

    fn join(&mut self) -> &'static str {
        let last = [("axis", Attribute::Int(2))];
        self.0
            .node("Concat", &["turned", "normals"], "placed", &last);
        "placed"
    }

    /// Two shared layers and the largest of each feature over the points: [B, N, C] to [B, F].
    fn largest_features(&mut self, layers: &[Linear; 2], clouds: &str) -> String {
        let features = self.relu_layer(&layers[0], clouds);
        let features = self.layer(&layers[1], &features);
        let axes = [
            ("axes", Attribute::Ints(&[1])),
            ("keepdims", Attribute::Int(0)),
        ];
        let [max, summary] = ["max", "summary"].map(|part| format!("{features}.{part}"));
        self.0.node("ReduceMax", &[&features], &max, &axes);
        self.0.node("Relu", &[&max], &summary, &[]);
        summary
    }
}
