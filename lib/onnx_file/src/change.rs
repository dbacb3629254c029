//! Reads a model back, and changes it.

use prost::Message;

use crate::proto::{self, EntryProto, ModelProto, TensorProto};
use crate::{Dimension, ModelBuilder, value_info};

/// Why a file cannot be changed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// The bytes are no ONNX model.
    #[error("no ONNX model: {0}")]
    Damaged(String),
    /// The model has parts that would be lost.
    #[error("written by {0:?}; only a model file that `train` or `teach` wrote can be changed")]
    Foreign(String),
}

impl ModelBuilder {
    /// The model of a file that a builder wrote. Encoded again, it has the same bytes.
    ///
    /// # Errors
    /// The bytes are no model, or one with parts that a builder does not write.
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        let damaged = |reason: String| DecodeError::Damaged(reason);
        let mut model = ModelProto::decode(bytes).map_err(|error| damaged(error.to_string()))?;
        // What this crate does not know of was dropped while decoding.
        if model.encode_to_vec() != bytes {
            return Err(DecodeError::Foreign(model.producer_name));
        }
        let graph = model.graph.take();
        let graph = graph.ok_or_else(|| damaged("it has no graph".to_owned()))?;
        Ok(Self { model, graph })
    }

    /// The value of a metadata entry.
    pub fn metadata_of(&self, key: &str) -> Option<&str> {
        let mut entries = self.model.metadata_props.iter();
        let entry = entries.find(|entry| entry.key == key)?;
        Some(&entry.value)
    }

    /// Sets a metadata entry, which may be there already.
    pub fn set_metadata(&mut self, key: &str, value: &str) {
        let entries = &mut self.model.metadata_props;
        match entries.iter_mut().find(|entry| entry.key == key) {
            Some(entry) => value.clone_into(&mut entry.value),
            None => entries.push(EntryProto {
                key: key.to_owned(),
                value: value.to_owned(),
            }),
        }
    }

    /// Shape and values, row-major, of a float32 constant; `None` where there is none of that name.
    pub fn constant_f32_of(&self, name: &str) -> Option<(Vec<usize>, Vec<f32>)> {
        let tensor = self.graph.initializer.iter().find(|t| t.name == name)?;
        let shape: Option<Vec<usize>> = tensor.dims.iter().map(|&n| n.try_into().ok()).collect();
        let shape = shape?;
        let count = shape
            .iter()
            .try_fold(1_usize, |product, &n| product.checked_mul(n))?;
        let bytes = tensor.raw_data.chunks_exact(size_of::<f32>());
        let is_whole = bytes.remainder().is_empty() && bytes.len() == count;
        let values =
            bytes.map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        (tensor.data_type == proto::FLOAT && is_whole).then(|| (shape, values.collect()))
    }

    /// Puts other values in place of a float32 constant's; the shape may differ, too.
    ///
    /// # Panics
    /// If `values` does not fill `shape`, or there is no constant of that name.
    pub fn replace_constant_f32(&mut self, name: &str, shape: &[usize], values: &[f32]) {
        let is_old = |tensor: &TensorProto| tensor.name == name;
        let old = self.graph.initializer.iter().position(is_old);
        assert!(old.is_some(), "there is no constant {name}");
        self.constant_f32(name, shape, values);
        if let Some(old) = old {
            self.graph.initializer.swap_remove(old);
        }
    }

    /// Declares another shape of an output.
    ///
    /// # Panics
    /// If there is no output of that name.
    pub fn reshape_output(&mut self, name: &str, shape: &[Dimension]) {
        let output = self.graph.output.iter_mut().find(|o| o.name == name);
        assert!(output.is_some(), "there is no output {name}");
        if let Some(output) = output {
            *output = value_info(name, shape);
        }
    }

    /// Whether a node computes this.
    pub fn has_node(&self, output: &str) -> bool {
        let nodes = &self.graph.node;
        nodes
            .iter()
            .any(|node| node.output.iter().any(|o| o == output))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn adding_model() -> ModelBuilder {
        let mut model = ModelBuilder::new("add");
        model.input("x", &[Dimension::Free("batch"), Dimension::Fixed(2)]);
        model.constant_f32("some", &[2], &[1.0, 2.0]);
        model.constant_i64("whole", &[1], &[7]);
        model.node("Add", &["x", "some"], "y", &[]);
        model.output("y", &[Dimension::Free("batch"), Dimension::Fixed(2)]);
        model.metadata("key", "value");
        model
    }

    #[test]
    fn a_decoded_model_has_the_same_bytes_again() {
        let bytes = adding_model().encode();
        let model = ModelBuilder::decode(&bytes).unwrap();
        assert_eq!(model.metadata_of("key"), Some("value"));
        assert_eq!(model.metadata_of("other"), None);
        assert_eq!(
            model.constant_f32_of("some"),
            Some((vec![2], vec![1.0, 2.0]))
        );
        assert_eq!(model.constant_f32_of("whole"), None);
        assert_eq!(model.constant_f32_of("none"), None);
        assert!(model.has_node("y") && !model.has_node("x"));
        assert_eq!(model.encode(), bytes);
    }

    #[test]
    fn changes_are_in_the_file() {
        let mut model = ModelBuilder::decode(&adding_model().encode()).unwrap();
        model.replace_constant_f32("some", &[3], &[3.0, 4.0, 5.0]);
        model.reshape_output("y", &[Dimension::Fixed(3)]);
        model.set_metadata("key", "other");
        model.set_metadata("more", "new");
        let changed = ModelBuilder::decode(&model.encode()).unwrap();
        let (shape, values) = changed.constant_f32_of("some").unwrap();
        assert_eq!((shape, values), (vec![3], vec![3.0, 4.0, 5.0]));
        assert_eq!(changed.metadata_of("key"), Some("other"));
        assert_eq!(changed.metadata_of("more"), Some("new"));
        assert_eq!(changed.graph.initializer.len(), 2);
        assert_eq!(changed.graph.output.len(), 1);
    }

    #[test]
    fn what_another_program_wrote_is_refused_by_name() {
        assert!(matches!(
            ModelBuilder::decode(b"no model"),
            Err(DecodeError::Damaged(_))
        ));
        let mut bytes = adding_model().encode();
        // Field 6 of ModelProto, doc_string, which is not written here.
        bytes.extend([0x32, 1, b'd']);
        let refused = ModelBuilder::decode(&bytes).unwrap_err();
        assert_eq!(refused, DecodeError::Foreign("deformable_cobot".to_owned()));
    }
}
