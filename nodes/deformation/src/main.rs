//! Says of each scan how the object is deformed, and of any cloud on request.

mod display;
mod pace;
mod pairs;
mod reply;

use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use deformation::{Library, Parameters};
use msg::deformable_cobot::{
    Classification, Deformation, MeasureDeformation, MeasureDeformationReq, MeasureDeformationRes,
    ObjectCloud,
};
use msg::sensor_msgs::PointCloud2;
use msg::visualization_msgs::MarkerArray;
use nalgebra::Vector3;
use node::{Expect, Health, Latch, Level, Node, Publisher, Subscriber};
use pace::Pace;
use pairs::Pairs;
use reply::{Question, answer_into};

fn main() -> ExitCode {
    node::run("deformation", serve)
}

async fn serve(node: Node) -> anyhow::Result<()> {
    let parameters = node.parameters(Parameters::validate)?;
    let library = Arc::new(Library::open(&parameters.references)?);
    let desk = Arc::new(Desk {
        answers: node.publish("deformation", 16, Latch::Yes)?,
        clouds: node.publish("deformation/cloud", 4, Latch::Yes)?,
        markers: node.publish("deformation/markers", 4, Latch::Yes)?,
        health: node.health().clone(),
        library: Arc::clone(&library),
        parameters,
        pairs: Mutex::new((Pairs::default(), Pace::new(Instant::now()))),
    });
    let health = node.health().clone();
    std::thread::spawn(move || check(&library, &health));
    let _links: [Subscriber; 2] = [
        node.subscribe("object", Expect::EVENTS, {
            let desk = Arc::clone(&desk);
            move |object: ObjectCloud| desk.take(|pairs| pairs.on_object(object))
        })?,
        node.subscribe("classification", Expect::EVENTS, {
            let desk = Arc::clone(&desk);
            move |answer: Classification| desk.take(|pairs| pairs.on_answer(answer))
        })?,
    ];
    let _service = node.serve::<MeasureDeformation>("measure_deformation", move |request, _| {
        let desk = Arc::clone(&desk);
        async move {
            let result = node::compute(move || desk.measure(&request)).await?;
            Ok(MeasureDeformationRes { result })
        }
    })?;
    node.until_shutdown().await;
    Ok(())
}

/// Says which references cannot be used. Each is prepared when it is first needed.
fn check(library: &Library, health: &Health) {
    let labels = library.labels();
    let mut faults = Vec::new();
    for label in &labels {
        if let Err(error) = library.check(label) {
            log::error!("{error}");
            faults.push(error.to_string());
        }
    }
    if labels.is_empty() {
        let text = "none; name the folder with the parameter references";
        health.set("references", Level::Warn, text);
    } else if faults.is_empty() {
        health.set("references", Level::Ok, labels.join(", "));
    } else {
        health.set("references", Level::Warn, faults.join("; "));
    }
}

/// Where objects and their names meet, and answers leave.
struct Desk {
    answers: Publisher<Deformation>,
    clouds: Publisher<PointCloud2>,
    markers: Publisher<MarkerArray>,
    health: Health,
    library: Arc<Library>,
    parameters: Parameters,
    pairs: Mutex<(Pairs, Pace)>,
}

impl Desk {
    /// For data of one's own.
    fn measure(&self, request: &MeasureDeformationReq) -> Deformation {
        let mut result = Deformation {
            header: request.cloud.header.clone(),
            complete: true,
            ..Default::default()
        };
        let question = Question {
            label: &request.label,
            cloud: &request.cloud,
            up: Vector3::new(request.up.x, request.up.y, request.up.z),
            viewpoints: &request.viewpoints,
            in_hand_frame: request.in_hand_frame,
        };
        answer_into(&mut result, &question, &self.library, &self.parameters);
        result
    }

    fn take(&self, note: impl FnOnce(&mut Pairs) -> Option<(ObjectCloud, Classification)>) {
        let mut pairs = self.pairs.lock().unwrap_or_else(PoisonError::into_inner);
        let (pairs, pace) = &mut *pairs;
        let Some((object, answer)) = note(pairs) else {
            return;
        };
        let begun = Instant::now();
        if !answer.complete && !pace.is_due(begun) {
            return;
        }
        // Answered while it is locked, so that answers leave in the order of the views.
        let reply = self.reply(&object, answer);
        pace.note(begun.elapsed(), Instant::now());
        self.report(&reply);
        if !reply.cloud.data.is_empty() {
            self.clouds.send(reply.cloud.clone());
        }
        self.markers.send(display::picture(&reply, &self.library));
        self.answers.send(reply);
    }

    fn reply(&self, object: &ObjectCloud, answer: Classification) -> Deformation {
        let mut reply = Deformation {
            header: object.header.clone(),
            scan_id: answer.scan_id,
            error: answer.error,
            view_count: answer.view_count,
            complete: answer.complete,
            label: answer.label,
            timing: answer.timing,
            ..Default::default()
        };
        if !reply.error.is_empty() {
            return reply;
        }
        if object.empty || !answer.known {
            reply.reason = if object.empty {
                "the hand holds nothing".into()
            } else {
                format!("the object is unknown; it is most like {}", reply.label)
            };
            reply.summary = format!("nothing said of dents: {}", reply.reason);
            return reply;
        }
        let label = std::mem::take(&mut reply.label);
        let question = Question {
            label: &label,
            cloud: &object.cloud,
            up: Vector3::new(object.up.x, object.up.y, object.up.z),
            viewpoints: &object.viewpoints,
            in_hand_frame: object.in_hand_frame,
        };
        answer_into(&mut reply, &question, &self.library, &self.parameters);
        reply
    }

    /// Says it in the log, and in diagnostics whether the label is to be doubted.
    fn report(&self, reply: &Deformation) {
        if !reply.error.is_empty() {
            return;
        }
        log::info!("scan {}: {}", reply.scan_id, reply.summary);
        if reply.reference.is_empty() {
            return;
        }
        let (level, text) = if reply.fits {
            (
                Level::Ok,
                format!("scan {} fits {}", reply.scan_id, reply.reference),
            )
        } else {
            (
                Level::Warn,
                format!(
                    "scan {} is said to be {}, but {}",
                    reply.scan_id, reply.label, reply.reason
                ),
            )
        };
        self.health.set("fit", level, text);
    }
}
