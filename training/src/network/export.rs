//! Writes a trained network as an ONNX file.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use classifier::{INPUT_NAME, KNOWN_SCORE_NAME, MAX_MODEL_BYTES, ModelMetadata, OUTPUT_NAME};
use onnx_file::{Attribute, Dimension, ModelBuilder};

use crate::network::{Linear, Network, PRODUCT_SCALE, RobotNetwork, SQUARE_MIN, wave_numbers};

mod paper;

/// Writes the model file under its final name only once it is complete.
///
/// # Errors
/// As for [`encode`], or the file cannot be written.
pub fn write_model(
    path: &Path,
    network: &Network,
    inverse_temperature: f64,
    metadata: &ModelMetadata,
) -> Result<u64> {
    let bytes = encode(network, inverse_temperature, metadata)?;
    write_whole(path, &bytes)?;
    Ok(bytes.len() as u64)
}

/// Writes a file whole or not at all, and makes its folder.
///
/// # Errors
/// The folder cannot be made or the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let make_folder = || path.parent().map_or(Ok(()), std::fs::create_dir_all);
    make_folder()
        .and_then(|()| whole_file::write(path, bytes))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// The bytes of the model file. Its probabilities are those of the logits times `inverse_temperature`.
///
/// # Errors
/// The network is larger than a model file may be, or a weight is not finite.
pub fn encode(
    network: &Network,
    inverse_temperature: f64,
    metadata: &ModelMetadata,
) -> Result<Vec<u8>> {
    let batch = Dimension::Free("batch");
    let mut graph = Graph(ModelBuilder::new("deformable_object_classifier"));
    let [columns, points] = [metadata.columns(), metadata.point_count].map(Dimension::Fixed);
    graph.0.input(INPUT_NAME, &[batch, columns, points]);
    for layer in network.layers() {
        graph.constants(layer)?;
    }
    graph.0.node(
        "Transpose",
        &[INPUT_NAME],
        "clouds",
        &[("perm", Attribute::Ints(&[0, 2, 1]))],
    );
    let logits = match network {
        Network::Robot(network) => graph.robot(network),
        Network::Paper(network) => graph.paper(network),
    };
    graph.answers(&logits, inverse_temperature);
    let classes = Dimension::Fixed(network.classes());
    graph.0.output(OUTPUT_NAME, &[batch, classes]);
    graph.0.output(KNOWN_SCORE_NAME, &[batch]);
    for (key, value) in metadata.to_entries() {
        graph.0.metadata(key, &value);
    }
    let bytes = graph.0.encode();
    ensure!(
        bytes.len() as u64 <= MAX_MODEL_BYTES,
        "the model has {} bytes, but a model file has at most {MAX_MODEL_BYTES}; choose fewer features",
        bytes.len()
    );
    Ok(bytes)
}

struct Graph(ModelBuilder);

impl Graph {
    fn constants(&mut self, layer: &Linear) -> Result<()> {
        for (kind, tensor) in [("weight", &layer.weight), ("bias", &layer.bias)] {
            let values = tensor.flatten_all()?.to_vec1::<f32>()?;
            ensure!(
                values.iter().all(|value| value.is_finite()),
                "{} of {} is not finite",
                kind,
                layer.name
            );
            self.0
                .constant_f32(&format!("{}.{kind}", layer.name), tensor.dims(), &values);
        }
        Ok(())
    }

    fn layer(&mut self, layer: &Linear, input: &str) -> String {
        let (product, sum) = (
            format!("{}.product", layer.name),
            format!("{}.sum", layer.name),
        );
        self.0.node(
            "MatMul",
            &[input, &format!("{}.weight", layer.name)],
            &product,
            &[],
        );
        self.0.node(
            "Add",
            &[&product, &format!("{}.bias", layer.name)],
            &sum,
            &[],
        );
        sum
    }

    fn relu_layer(&mut self, layer: &Linear, input: &str) -> String {
        let sum = self.layer(layer, input);
        let output = format!("{}.output", layer.name);
        self.0.node("Relu", &[&sum], &output, &[]);
        output
    }

    /// The model's outputs: log-probabilities at the fitted temperature, and the known score (negative energy).
    fn answers(&mut self, logits: &str, inverse_temperature: f64) {
        let model = &mut self.0;
        model.constant_f32("inverse_temperature", &[1], &[inverse_temperature as f32]);
        model.node("Mul", &[logits, "inverse_temperature"], "tempered", &[]);
        let classes = [("axis", Attribute::Int(1))];
        model.node("LogSoftmax", &["tempered"], OUTPUT_NAME, &classes);
        // Log-sum-exp as a difference of logit and log-softmax, since OpenVINO's ReduceLogSumExp overflows.
        model.node("LogSoftmax", &[logits], "untempered", &classes);
        let largest = [
            ("axes", Attribute::Ints(&[1])),
            ("keepdims", Attribute::Int(0)),
        ];
        model.node("ReduceMax", &[logits], "largest", &largest);
        model.node("ReduceMax", &["untempered"], "largest_untempered", &largest);
        let difference = ["largest", "largest_untempered"];
        model.node("Sub", &difference, KNOWN_SCORE_NAME, &[]);
    }

    /// The robot's network, up to its logits.
    fn robot(&mut self, network: &RobotNetwork) -> String {
        self.constants_of_products();
        let placed = self.transformed(network, "clouds");
        let products = self.products(&placed);
        let summary = self.pooled_features(&network.points, &products);
        let hidden = self.relu_layer(&network.head[0], &summary);
        self.layer(&network.head[1], &hidden)
    }

    /// The spatial transformer: transforms the points into the frame that it predicts.
    fn transformed(&mut self, network: &RobotNetwork, clouds: &str) -> String {
        let products = self.products(clouds);
        let summary = self.pooled_features(&network.transform_points, &products);
        let hidden = self.relu_layer(&network.transform_head[0], &summary);
        let turn = self.layer(&network.transform_head[1], &hidden);
        let turn = self.reshape(&turn, &[-1, 3, 3]);
        let shift = self.layer(&network.transform_shift, &hidden);
        let shift = self.reshape(&shift, &[-1, 1, 3]);
        self.0.node("MatMul", &[clouds, &turn], "turned", &[]);
        self.0.node("Add", &["turned", &shift], "placed", &[]);
        "placed".to_owned()
    }

    fn reshape(&mut self, input: &str, shape: &[i64]) -> String {
        let [constant, output] = ["shape", "reshaped"].map(|part| format!("{input}.{part}"));
        self.0.constant_i64(&constant, &[shape.len()], shape);
        self.0.node("Reshape", &[input, &constant], &output, &[]);
        output
    }

    fn constants_of_products(&mut self) {
        self.0
            .constant_f32("product_scale", &[1], &[PRODUCT_SCALE as f32]);
        self.0.constant_i64("next_coordinate", &[3], &[1, 2, 0]);
        // Columns: the squared distance from the origin, and from the up axis.
        let sums = [1.0, 1.0, 1.0, 1.0, 1.0, 0.0];
        self.0.constant_f32("sums_of_squares", &[3, 2], &sums);
        self.0
            .constant_f32("square_min", &[1], &[SQUARE_MIN as f32]);
        let numbers = wave_numbers();
        let shape = [2, numbers.len() / 2];
        self.0.constant_f32("wave_numbers", &shape, &numbers);
        self.0.constant_i64("last_axis", &[1], &[2]);
    }

    /// The columns that the shared layers see: [B, N, 3] to [B, N, 12].
    fn products(&mut self, points: &str) -> String {
        let parts = [
            "scaled",
            "squares",
            "rolled",
            "mixed",
            "squared_norm",
            "cubes",
            "products",
        ];
        let [scaled, squares, rolled, mixed, norm, cubes, output] =
            parts.map(|part| format!("{points}.{part}"));
        let last = [("axis", Attribute::Int(2))];
        let keep = [("keepdims", Attribute::Int(1))];
        let model = &mut self.0;
        model.node("Mul", &[points, "product_scale"], &scaled, &[]);
        model.node("Mul", &[&scaled, &scaled], &squares, &[]);
        model.node("Gather", &[&scaled, "next_coordinate"], &rolled, &last);
        model.node("Mul", &[&scaled, &rolled], &mixed, &[]);
        model.node("ReduceSum", &[&squares, "last_axis"], &norm, &keep);
        model.node("Mul", &[&scaled, &norm], &cubes, &[]);
        let parts = ["sums", "floored", "distances", "phases", "sines", "cosines"];
        let [sums, floored, distances, phases, sines, cosines] =
            parts.map(|part| format!("{points}.{part}"));
        model.node("MatMul", &[&squares, "sums_of_squares"], &sums, &[]);
        model.node("Add", &[&sums, "square_min"], &floored, &[]);
        model.node("Sqrt", &[&floored], &distances, &[]);
        model.node("MatMul", &[&distances, "wave_numbers"], &phases, &[]);
        model.node("Sin", &[&phases], &sines, &[]);
        model.node("Cos", &[&phases], &cosines, &[]);
        let columns = [&scaled, &squares, &mixed, &cubes, &sines, &cosines];
        model.node("Concat", &columns.map(String::as_str), &output, &last);
        output
    }

    /// Two shared layers and the maximum and mean over the points: [B, N, 3] to [B, 2 F].
    fn pooled_features(&mut self, layers: &[Linear; 2], clouds: &str) -> String {
        let features = self.relu_layer(&layers[0], clouds);
        let features = self.relu_layer(&layers[1], &features);
        let axes = [
            ("axes", Attribute::Ints(&[1])),
            ("keepdims", Attribute::Int(0)),
        ];
        let [max, mean, both] = ["max", "mean", "summary"].map(|part| format!("{features}.{part}"));
        self.0.node("ReduceMax", &[&features], &max, &axes);
        self.0.node("ReduceMean", &[&features], &mean, &axes);
        self.0.node(
            "Concat",
            &[&max, &mean],
            &both,
            &[("axis", Attribute::Int(1))],
        );
        both
    }
}
