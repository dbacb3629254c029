//! Fuzz test of the decoders: whatever a hostile or broken peer sends, they give a message or an error, and never panic, spin
//! or take much memory.

#![allow(clippy::unwrap_used)]

use std::alloc::System;

use cap::Cap;
use msg::service::Service;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rosrust::Message;

use crate::bounded;
use crate::layout::Layout;
use crate::transforms::TransformBuffer;

/// Memory limit of the process, in bytes. An allocation beyond it fails and ends the process.
const MEMORY_MAX: usize = 64 << 20;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

const INPUTS: usize = 1_000_000;

/// A type that is read, by what is done with the bytes of it.
struct Kind {
    name: String,
    layout: Layout,
    /// Decodes the bytes; whether they were a message.
    decode: fn(&mut [u8]) -> bool,
}

fn kind<T: Message>(decode: fn(&mut [u8]) -> bool) -> Kind {
    Kind {
        name: T::msg_type(),
        layout: Layout::parse(&T::msg_definition()).unwrap(),
        decode,
    }
}

fn message<T: Message>() -> Kind {
    kind::<T>(|bytes| bounded::message::<T>(bytes).is_ok())
}

fn service<S: Service>() -> [Kind; 2] {
    [
        Kind {
            name: format!("{} request", S::msg_type()),
            layout: Layout::parse(&S::request_definition()).unwrap(),
            decode: |bytes| bounded::request::<S>(bytes).is_ok(),
        },
        Kind {
            name: format!("{} response", S::msg_type()),
            layout: Layout::parse(&S::response_definition()).unwrap(),
            decode: |bytes| bounded::response::<S>(bytes).is_ok(),
        },
    ]
}

/// All types that some node or simulator reads.
fn kinds() -> Vec<Kind> {
    use msg::baxter_core_msgs::*;
    use msg::deformable_cobot::*;
    let mut kinds = vec![
        kind::<msg::sensor_msgs::PointCloud2>(|bytes| {
            bounded::message::<msg::sensor_msgs::PointCloud2>(bytes)
                .map(|cloud| msg::cloud::to_points(&cloud.0))
                .is_ok()
        }),
        kind::<msg::tf2_msgs::TFMessage>(|bytes| {
            bounded::message::<msg::tf2_msgs::TFMessage>(bytes)
                .map(|transforms| {
                    let mut buffer = TransformBuffer::default();
                    crate::listener::insert_all(&mut buffer, &transforms.0, false);
                })
                .is_ok()
        }),
        message::<msg::sensor_msgs::JointState>(),
        message::<msg::sensor_msgs::Image>(),
        message::<msg::sensor_msgs::CameraInfo>(),
        message::<msg::std_msgs::Bool>(),
        message::<msg::std_msgs::Float64>(),
        message::<msg::diagnostic_msgs::DiagnosticArray>(),
        message::<AssemblyState>(),
        message::<CollisionAvoidanceState>(),
        message::<CollisionDetectionState>(),
        message::<DigitalIOState>(),
        message::<EndEffectorCommand>(),
        message::<EndEffectorState>(),
        message::<HeadPanCommand>(),
        message::<JointCommand>(),
        message::<View>(),
        message::<RegisteredCloud>(),
        message::<ObjectCloud>(),
        message::<Classification>(),
        message::<ScanObjectFeedback>(),
        message::<ScanObjectActionGoal>(),
        message::<ScanObjectActionFeedback>(),
        message::<ScanObjectActionResult>(),
        message::<msg::actionlib_msgs::GoalID>(),
        message::<msg::actionlib_msgs::GoalStatusArray>(),
        message::<msg::reflex_msgs::Hand>(),
        message::<msg::reflex_msgs::PoseCommand>(),
    ];
    kinds.extend(service::<RotateWrist>());
    kinds.extend(service::<SweepWrist>());
    kinds.extend(service::<ScanObject>());
    kinds.extend(service::<SweepObject>());
    kinds.extend(service::<RegisterViews>());
    kinds.extend(service::<CropCloud>());
    kinds.extend(service::<ClassifyCloud>());
    kinds.extend(service::<LoadModel>());
    kinds.extend(service::<HoldObject>());
    kinds.extend(service::<CalibrateCameraMount>());
    kinds.extend(service::<Grasp>());
    kinds.extend(service::<msg::dynamic_reconfigure::Reconfigure>());
    kinds.extend(service::<msg::std_srvs::Trigger>());
    kinds
}

#[test]
fn a_million_hostile_messages() {
    let seed = 20_261_125;
    println!("seed {seed}");
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let kinds = kinds();
    ALLOCATOR.set_limit(MEMORY_MAX).unwrap();
    let mut taken = 0;
    let mut bytes = Vec::new();
    for number in 0..INPUTS {
        let kind = &kinds[number % kinds.len()];
        bytes.clear();
        kind.layout.example(&mut random, &mut bytes);
        spoil(&mut bytes, &mut random);
        taken += usize::from((kind.decode)(&mut bytes));
    }
    ALLOCATOR.set_limit(usize::MAX).unwrap();
    println!("{taken} of {INPUTS} were messages");
    // If nearly all or none were, the inputs would test nothing.
    assert!((INPUTS / 10..INPUTS * 9 / 10).contains(&taken), "{taken}");
}

#[test]
fn what_is_not_spoilt_is_a_message() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    for kind in kinds() {
        let mut bytes = Vec::new();
        kind.layout.example(&mut random, &mut bytes);
        assert!((kind.decode)(&mut bytes), "{}: {bytes:?}", kind.name);
    }
}

/// Mutates the input: nothing, some bytes, length fields, the end, or everything.
fn spoil(bytes: &mut Vec<u8>, random: &mut Pcg64Mcg) {
    match random.random_range(0..6) {
        0 => {}
        1 => {
            for _ in 0..random.random_range(1..8) {
                if !bytes.is_empty() {
                    let place = random.random_range(0..bytes.len());
                    bytes[place] = random.random();
                }
            }
        }
        2 => bytes.truncate(random.random_range(0..=bytes.len())),
        3 => bytes.extend((0..random.random_range(1..40)).map(|_| random.random::<u8>())),
        4 => {
            // A length prefix, perhaps, that claims far too much.
            if bytes.len() >= 4 {
                let place = random.random_range(0..=bytes.len() - 4);
                let shift = random.random_range(0..32);
                bytes[place..place + 4].copy_from_slice(&(u32::MAX >> shift).to_le_bytes());
            }
        }
        _ => {
            bytes.clear();
            bytes.extend((0..random.random_range(0..200)).map(|_| random.random::<u8>()));
        }
    }
}
