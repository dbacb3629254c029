//! The node: topics, service and action around the scan in the library.

mod action;
mod at_start;
mod diagnostics;
mod stages;

use action::Action;
use msg::deformable_cobot::{
    Classification, ScanObject, ScanObjectReq, SweepObject, SweepObjectReq, SweepObjectRes,
};
use msg::robot;
use msg::sensor_msgs::JointState;
use node::{Expect, Latch, Node};
use scan_server::{Parameters, Scanner, Wish};
use stages::Graph;
use std::sync::Arc;

/// Sets the node up and serves until shutdown; then the scan under way has ended and the arm rests.
pub async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters: Parameters = node.parameters(Parameters::validate)?;
    let graph = Graph::new(&node, &parameters)?;
    let scanner = Arc::new(Scanner::new(graph, parameters.clone()));
    let joint_states = Expect {
        silence_max: None,
        ..Expect::SHARED_STATE
    };
    let _joints = node.subscribe("/robot/joint_states", joint_states, {
        let (scanner, joint) = (Arc::clone(&scanner), parameters.side.wrist_joint());
        move |state: JointState| {
            if let Some(sample) = robot::joint_sample(&state, joint) {
                scanner.progress().note_angle(sample.angle_rad);
            }
        }
    })?;
    let _answers = node.subscribe("classification", Expect::EVENTS, {
        let scanner = Arc::clone(&scanner);
        move |answer: Classification| scanner.note_answer(answer)
    })?;
    let progress = node.publish("progress", 4, Latch::Yes)?;
    let action = Action::listen(&node)?;
    let _service = node.serve::<ScanObject>("scan_object", {
        let scanner = Arc::clone(&scanner);
        move |ScanObjectReq { views }, life| {
            let scanner = Arc::clone(&scanner);
            let wish = Wish {
                views,
                range_rad: 0.0,
            };
            async move { Ok(scanner.scan(wish, &life).await.answer) }
        }
    })?;
    let _sweep = node.serve::<SweepObject>("sweep_object", {
        let scanner = Arc::clone(&scanner);
        move |SweepObjectReq { range }, life| {
            let scanner = Arc::clone(&scanner);
            let wish = Wish {
                views: 0,
                range_rad: range,
            };
            async move {
                let answer = scanner.scan(wish, &life).await.answer;
                Ok(SweepObjectRes {
                    error: answer.error,
                    result: answer.result,
                })
            }
        }
    })?;
    tokio::select! {
        () = action.serve(&scanner) => Ok(()),
        never = scanner.progress().follow(|report| progress.send(report)) => match never {},
        never = at_start::scan(&node, &parameters, &scanner) => match never {},
    }
}
