//! The layers after the pooled features, out of and into a model file.

use nalgebra::{DMatrix, DVector};
use onnx_file::{DecodeError, Dimension, ModelBuilder};

/// Name of the network's pooled features in a model file, float32 `[B, F]`.
pub const FEATURES: &str = "point_2.output.summary";
const LAYERS: [&str; 2] = ["head_1", "head_2"];
const INVERSE_TEMPERATURE: &str = "inverse_temperature";
/// Name of the output that has a column for each class.
const OUTPUT: &str = "log_probabilities";

/// Why the layers cannot be taken out of a model file.
#[derive(Debug, thiserror::Error)]
pub enum HeadError {
    /// The file cannot be read or changed.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// It is another network.
    #[error(
        "the network has no {0}; only the robot's network can be taught, which `train` makes without --network paper"
    )]
    Missing(&'static str),
}

/// One dense layer: x · weight + bias.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// `[inputs, outputs]`
    pub weight: DMatrix<f64>,
    /// `[outputs]`
    pub bias: DVector<f64>,
}

/// The two layers that make logits of pooled features. The first is followed by max(0, x). The logit of "none of the
/// classes" is 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// From features to hidden values.
    pub hidden: Layer,
    /// From hidden values to the logits of the classes.
    pub last: Layer,
}

impl Head {
    /// The layers of a model file's network.
    ///
    /// # Errors
    /// The network is not the robot's.
    pub fn of(model: &ModelBuilder) -> Result<Self, HeadError> {
        if !model.has_node(FEATURES) {
            return Err(HeadError::Missing("pooled features"));
        }
        let [hidden, last] = LAYERS.map(|name| layer_of(model, name));
        let head = Self {
            hidden: hidden.ok_or(HeadError::Missing("hidden layer"))?,
            last: last.ok_or(HeadError::Missing("last layer"))?,
        };
        if head.hidden.bias.len() != head.last.weight.nrows() {
            return Err(HeadError::Missing("layers that fit each other"));
        }
        Ok(head)
    }

    /// Puts the layers into a model file; the number of classes may be another one.
    ///
    /// # Panics
    /// If the model is not one that [`Head::of`] read.
    pub fn put_into(&self, model: &mut ModelBuilder) {
        for (layer, name) in [&self.hidden, &self.last].into_iter().zip(LAYERS) {
            let (inputs, outputs) = layer.weight.shape();
            // Row-major in the file, column-major here.
            let weight: Vec<f32> = layer.weight.transpose().iter().map(|&w| w as f32).collect();
            let bias: Vec<f32> = layer.bias.iter().map(|&b| b as f32).collect();
            model.replace_constant_f32(&format!("{name}.weight"), &[inputs, outputs], &weight);
            model.replace_constant_f32(&format!("{name}.bias"), &[outputs], &bias);
        }
        let shape = [Dimension::Free("batch"), Dimension::Fixed(self.classes())];
        model.reshape_output(OUTPUT, &shape);
    }

    /// Number of features that it takes.
    pub fn features(&self) -> usize {
        self.hidden.weight.nrows()
    }

    /// Number of classes.
    pub fn classes(&self) -> usize {
        self.last.bias.len()
    }

    /// Hidden values `[M, H]` of features `[M, F]`.
    pub fn hidden_of(&self, features: &DMatrix<f64>) -> DMatrix<f64> {
        self.hidden.of(features).map(|value| value.max(0.0))
    }

    /// Logits `[M, C]` of features `[M, F]`.
    pub fn logits(&self, features: &DMatrix<f64>) -> DMatrix<f64> {
        self.last.of(&self.hidden_of(features))
    }

    /// With one more class, to which nothing is alike yet.
    pub fn with_class(&self) -> Self {
        let mut head = self.clone();
        let (rows, classes) = head.last.weight.shape();
        head.last.weight = head.last.weight.resize(rows, classes + 1, 0.0);
        head.last.bias = head.last.bias.resize_vertically(classes + 1, 0.0);
        head
    }

    /// Without a class.
    ///
    /// # Panics
    /// If there is no such class.
    pub fn without_class(&self, class: usize) -> Self {
        let mut head = self.clone();
        head.last.weight = head.last.weight.remove_column(class);
        head.last.bias = head.last.bias.remove_row(class);
        head
    }
}

impl Layer {
    /// With these outputs, in this order.
    ///
    /// # Panics
    /// If there is no such output.
    pub fn with_order(&self, order: &[usize]) -> Self {
        Self {
            weight: self.weight.select_columns(order),
            bias: self.bias.select_rows(order),
        }
    }

    pub(crate) fn of(&self, inputs: &DMatrix<f64>) -> DMatrix<f64> {
        let mut outputs = inputs * &self.weight;
        for (mut column, bias) in outputs.column_iter_mut().zip(self.bias.iter()) {
            column.add_scalar_mut(*bias);
        }
        outputs
    }
}

fn layer_of(model: &ModelBuilder, name: &str) -> Option<Layer> {
    let (shape, weight) = model.constant_f32_of(&format!("{name}.weight"))?;
    let (_, bias) = model.constant_f32_of(&format!("{name}.bias"))?;
    let &[inputs, outputs] = shape.as_slice() else {
        return None;
    };
    let weight = weight.into_iter().map(f64::from);
    (bias.len() == outputs).then(|| Layer {
        weight: DMatrix::from_row_iterator(inputs, outputs, weight),
        bias: DVector::from_iterator(outputs, bias.into_iter().map(f64::from)),
    })
}

/// The bytes of the same model with [`FEATURES`] among its outputs.
///
/// # Errors
/// The network is not the robot's.
pub fn with_features(model: &ModelBuilder) -> Result<Vec<u8>, HeadError> {
    let width = Head::of(model)?.features();
    let mut model = model.clone();
    model.output(
        FEATURES,
        &[Dimension::Free("batch"), Dimension::Fixed(width)],
    );
    Ok(model.encode())
}

/// The factor 1/T of the logits in a model file.
///
/// # Errors
/// The network has none.
pub fn inverse_temperature_of(model: &ModelBuilder) -> Result<f64, HeadError> {
    let values = model.constant_f32_of(INVERSE_TEMPERATURE);
    let first = values.and_then(|(_, values)| values.first().copied());
    first
        .map(f64::from)
        .ok_or(HeadError::Missing("temperature"))
}

/// Puts another factor 1/T into a model file.
///
/// # Panics
/// If the model is not one that [`inverse_temperature_of`] read.
pub fn set_inverse_temperature(model: &mut ModelBuilder, factor: f64) {
    model.replace_constant_f32(INVERSE_TEMPERATURE, &[1], &[factor as f32]);
}
