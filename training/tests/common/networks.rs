//! Networks and clouds by which programs that run a model are compared.

use candle_core::{Device, Tensor};
use candle_nn::ops::log_softmax;
use classifier::{Centring, ModelMetadata};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use training::data::simulate::preprocessing;
use training::network::{Architecture, Head, Network, PaperArchitecture};

pub const SEED: u64 = 20;
pub const CLOUDS: usize = 1000;
pub const INVERSE_TEMPERATURE: f64 = 0.7;

/// A network with what its model file says about it, and a name.
pub type Example = (&'static str, Network, ModelMetadata);

/// The robot's network, and the paper's without and with normals, and with flattened features.
pub fn examples() -> anyhow::Result<Vec<Example>> {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut metadata = preprocessing(128, Centring::Box);
    let classes = metadata.labels.len();
    let network = Network::robot(Architecture::default(), classes, &mut random)?;
    let mut examples = vec![("robot", network, metadata.clone())];
    metadata.point_count = 62;
    let paper = PaperArchitecture::default();
    let with_normals = PaperArchitecture {
        normals: true,
        ..paper
    };
    let flattened = PaperArchitecture {
        features: 32,
        head: Head::Flatten,
        ..paper
    };
    for (name, architecture) in [
        ("paper", paper),
        ("paper-normals", with_normals),
        ("paper-flatten", flattened),
    ] {
        let normals = architecture.normals;
        let points = metadata.point_count;
        let network = Network::paper(architecture, points, classes, &mut random)?;
        let metadata = ModelMetadata {
            normals,
            ..metadata.clone()
        };
        examples.push((name, network, metadata));
    }
    for (_, network, metadata) in &mut examples {
        metadata.network_version = network.version().to_owned();
        unsettle(network, &mut random)?;
    }
    Ok(examples)
}

/// So that the transformer, too, is not what it starts as.
fn unsettle(network: &Network, random: &mut Pcg64Mcg) -> anyhow::Result<()> {
    for variable in network.variables() {
        let noise = (0..variable.elem_count()).map(|_| random.random_range(-0.005..0.005f32));
        let noise = Tensor::from_vec(noise.collect(), variable.shape(), &Device::Cpu)?;
        variable.set(&(variable.as_tensor() + noise)?)?;
    }
    Ok(())
}

/// Inputs as the model file takes them, [B, columns, N].
pub fn inputs(metadata: &ModelMetadata) -> candle_core::Result<Tensor> {
    let mut random = Pcg64Mcg::seed_from_u64(SEED + 1);
    let shape = (CLOUDS, metadata.columns(), metadata.point_count);
    let count = shape.0 * shape.1 * shape.2;
    let values = (0..count).map(|_| random.random_range(-1.0..1.0f32));
    Tensor::from_vec(values.collect(), shape, &Device::Cpu)
}

/// What the training framework answers: log-probabilities [B, C], and how much like the classes the clouds are [B].
pub fn answers(network: &Network, inputs: &Tensor) -> candle_core::Result<(Tensor, Tensor)> {
    let logits = network.logits(&inputs.transpose(1, 2)?.contiguous()?)?;
    let tempered = (&logits * INVERSE_TEMPERATURE)?;
    Ok((log_softmax(&tempered, 1)?, logits.log_sum_exp(1)?))
}
