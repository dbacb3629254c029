//! Writes ONNX model files: a small float32 graph, its constants and its metadata. Reads back and changes those that it
//! wrote.
//!
//! Only what a small network needs is here. A model is built node by node and then encoded:
//!
//! ```
//! use onnx_file::{Dimension, ModelBuilder};
//!
//! let mut model = ModelBuilder::new("halve");
//! model.input("whole", &[Dimension::Free("batch"), Dimension::Fixed(2)]);
//! model.constant_f32("half", &[1], &[0.5]);
//! model.node("Mul", &["whole", "half"], "halved", &[]);
//! model.output("halved", &[Dimension::Free("batch"), Dimension::Fixed(2)]);
//! model.metadata("unit", "metres");
//! let bytes = model.encode();
//! # assert!(!bytes.is_empty());
//! ```
//!
//! [`ModelBuilder::decode`] reads an existing model, so that it can be changed: for example, its weights can be replaced.

mod change;
mod proto;

pub use change::DecodeError;

use prost::Message;
use proto::{
    AttributeProto, DimensionProto, DimensionValue, EntryProto, GraphProto, ModelProto, NodeProto,
    OperatorSetProto, ShapeProto, TensorProto, TensorTypeProto, TypeProto, ValueInfoProto,
};

/// Version of ONNX's operator set that the models use. Both ONNX Runtime and OpenVINO read it, and in it the axes of
/// `ReduceMax` are still an attribute.
const OPERATOR_SET: i64 = 17;
/// Version of the file format that belongs to [`OPERATOR_SET`].
const FORMAT_VERSION: i64 = 8;

/// One dimension of an input or output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension<'a> {
    /// Always this size.
    Fixed(usize),
    /// Any size, under a name that inputs and outputs may share.
    Free(&'a str),
}

/// Value of a node's attribute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Attribute<'a> {
    /// One integer, as `axis`.
    Int(i64),
    /// Several integers, as `perm`.
    Ints(&'a [i64]),
}

/// Builds one model. Names connect it: each node's output is an input of later nodes.
#[derive(Debug, Clone)]
pub struct ModelBuilder {
    model: ModelProto,
    graph: GraphProto,
}

impl ModelBuilder {
    /// An empty model whose graph has this name.
    pub fn new(graph_name: &str) -> Self {
        let model = ModelProto {
            ir_version: FORMAT_VERSION,
            producer_name: "deformable_cobot".to_owned(),
            producer_version: env!("CARGO_PKG_VERSION").to_owned(),
            opset_import: vec![OperatorSetProto {
                domain: String::new(),
                version: OPERATOR_SET,
            }],
            ..ModelProto::default()
        };
        let graph = GraphProto {
            name: graph_name.to_owned(),
            ..GraphProto::default()
        };
        Self { model, graph }
    }

    /// Adds a float32 input.
    pub fn input(&mut self, name: &str, shape: &[Dimension]) {
        self.graph.input.push(value_info(name, shape));
    }

    /// Adds a float32 output; some node must produce it.
    pub fn output(&mut self, name: &str, shape: &[Dimension]) {
        self.graph.output.push(value_info(name, shape));
    }

    /// Adds a float32 constant, row-major.
    ///
    /// # Panics
    /// If `values` does not fill `shape`.
    pub fn constant_f32(&mut self, name: &str, shape: &[usize], values: &[f32]) {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        self.constant(name, shape, values.len(), proto::FLOAT, bytes.collect());
    }

    /// Adds an int64 constant, row-major.
    ///
    /// # Panics
    /// If `values` does not fill `shape`.
    pub fn constant_i64(&mut self, name: &str, shape: &[usize], values: &[i64]) {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        self.constant(name, shape, values.len(), proto::INT64, bytes.collect());
    }

    /// Adds a node of the standard operator set with one output.
    pub fn node(
        &mut self,
        operator: &str,
        inputs: &[&str],
        output: &str,
        attributes: &[(&str, Attribute)],
    ) {
        self.graph.node.push(NodeProto {
            input: inputs.iter().map(|&name| name.to_owned()).collect(),
            output: vec![output.to_owned()],
            name: output.to_owned(),
            op_type: operator.to_owned(),
            attribute: attributes.iter().map(attribute).collect(),
        });
    }

    /// Adds a metadata entry.
    pub fn metadata(&mut self, key: &str, value: &str) {
        self.model.metadata_props.push(EntryProto {
            key: key.to_owned(),
            value: value.to_owned(),
        });
    }

    /// The bytes of the model file.
    pub fn encode(mut self) -> Vec<u8> {
        self.model.graph = Some(self.graph);
        self.model.encode_to_vec()
    }

    fn constant(
        &mut self,
        name: &str,
        shape: &[usize],
        count: usize,
        data_type: i32,
        raw_data: Vec<u8>,
    ) {
        let expected: usize = shape.iter().product();
        assert_eq!(
            expected, count,
            "constant {name}: shape {shape:?} needs {expected} values, not {count}"
        );
        self.graph.initializer.push(TensorProto {
            dims: shape.iter().map(|&size| size as i64).collect(),
            data_type,
            name: name.to_owned(),
            raw_data,
        });
    }
}

fn attribute((name, value): &(&str, Attribute)) -> AttributeProto {
    let name = (*name).to_owned();
    match value {
        Attribute::Int(value) => AttributeProto {
            name,
            i: Some(*value),
            ints: Vec::new(),
            kind: proto::ATTRIBUTE_INT,
        },
        Attribute::Ints(values) => AttributeProto {
            name,
            i: None,
            ints: values.to_vec(),
            kind: proto::ATTRIBUTE_INTS,
        },
    }
}

fn value_info(name: &str, shape: &[Dimension]) -> ValueInfoProto {
    let dimensions = shape.iter().map(|dimension| DimensionProto {
        value: Some(match dimension {
            Dimension::Fixed(size) => DimensionValue::Size(*size as i64),
            Dimension::Free(name) => DimensionValue::Name((*name).to_owned()),
        }),
    });
    let tensor = TensorTypeProto {
        elem_type: proto::FLOAT,
        shape: Some(ShapeProto {
            dim: dimensions.collect(),
        }),
    };
    ValueInfoProto {
        name: name.to_owned(),
        kind: Some(TypeProto {
            tensor_type: Some(tensor),
        }),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn doubling_model() -> ModelBuilder {
        let mut model = ModelBuilder::new("double");
        model.input("x", &[Dimension::Free("batch"), Dimension::Fixed(3)]);
        model.constant_f32("two", &[1], &[2.0]);
        model.node("Mul", &["x", "two"], "y", &[]);
        model.node("LogSoftmax", &["y"], "z", &[("axis", Attribute::Int(0))]);
        model.output("z", &[Dimension::Free("batch"), Dimension::Fixed(3)]);
        model.metadata("key", "value");
        model
    }

    #[test]
    fn decoding_gives_back_what_was_written() {
        let model = ModelProto::decode(doubling_model().encode().as_slice()).unwrap();
        assert_eq!(model.opset_import[0].version, OPERATOR_SET);
        assert_eq!(model.metadata_props[0].value, "value");
        let graph = model.graph.unwrap();
        assert_eq!(graph.node[1].op_type, "LogSoftmax");
        assert_eq!(graph.initializer[0].raw_data, 2.0f32.to_le_bytes());
        let tensor = graph.input[0].kind.as_ref().unwrap().tensor_type.as_ref();
        let dimensions = &tensor.unwrap().shape.as_ref().unwrap().dim;
        assert_eq!(dimensions[1].value, Some(DimensionValue::Size(3)));
    }

    #[test]
    fn a_zero_attribute_is_written_out() {
        // A reader tells "axis 0" from "no axis" by the field's presence.
        let model = ModelProto::decode(doubling_model().encode().as_slice()).unwrap();
        assert_eq!(model.graph.unwrap().node[1].attribute[0].i, Some(0));
    }

    #[test]
    #[should_panic(expected = "constant w: shape [2, 2] needs 4 values, not 3")]
    fn a_constant_must_fill_its_shape() {
        ModelBuilder::new("g").constant_f32("w", &[2, 2], &[1.0, 2.0, 3.0]);
    }
}
