#![allow(clippy::unwrap_used)]

use msg::sensor_msgs::PointCloud2;
use msg::std_msgs::Header;
use msg::timing;
use nalgebra::{Isometry3, Point3, Translation3};

use super::*;

/// Two sides of a box, 2 mm between points.
fn cloud() -> PointCloud2 {
    let at = |a: u16, b: u16| (0.002 * f32::from(a), 0.002 * f32::from(b));
    let grid = (0..30).flat_map(|a| (0..30).map(move |b| at(a, b)));
    let points: Vec<_> = grid
        .flat_map(|(a, b)| [Point3::new(a, b, 0.3), Point3::new(0.0, a, 0.3 + b)])
        .collect();
    msg::cloud::from_points(Header::default(), &points)
}

fn view(scan_id: &str, index: u32) -> View {
    let mut view = View {
        scan_id: scan_id.into(),
        index,
        count: 3,
        cloud: cloud(),
        ..Default::default()
    };
    view.header.frame_id = "camera".into();
    view.hand_frame = "left_hand".into();
    view.wrist_angle = f64::from(index);
    view.timing.push(timing::stage(
        "capture",
        std::time::Duration::from_millis(5),
    ));
    view
}

fn posed(scan_id: &str, index: u32) -> View {
    let pose = Isometry3::from(Translation3::new(0.0, 0.0, -0.1));
    View {
        has_pose: true,
        hand_from_camera: msg::transform::from_isometry(&pose),
        ..view(scan_id, index)
    }
}

fn progress() -> Progress {
    Progress::new(Parameters::default())
}

/// After the first view of scan a.
fn begun() -> Progress {
    let mut progress = progress();
    progress.on_view(view("a", 0)).unwrap();
    progress
}

#[test]
fn a_scan_grows_view_by_view() {
    let mut progress = progress();
    for index in 0..3 {
        let message = progress.on_view(view("a", index)).unwrap();
        assert_eq!(
            (&message.error[..], message.count, message.views.len()),
            ("", 3, index as usize + 1)
        );
        assert_eq!(
            (message.view_count, message.complete),
            (index + 1, index == 2)
        );
        assert_eq!(
            (&message.header.frame_id[..], message.in_hand_frame),
            ("camera", false)
        );
        assert_eq!(message.views[index as usize].wrist_angle, f64::from(index));
        assert!(message.cloud.width > 1000);
        let stages: Vec<_> = message.timing.iter().map(|time| &time.stage[..]).collect();
        assert_eq!(stages, ["capture", "register"]);
        assert_eq!(
            message.timing[0].elapsed.nanos(),
            5_000_000 * i64::from(index + 1)
        );
    }
}

#[test]
fn kinematics_put_the_cloud_into_the_hand() {
    let message = progress().on_view(posed("a", 0)).unwrap();
    assert_eq!(
        (&message.header.frame_id[..], message.in_hand_frame),
        ("left_hand", true)
    );
}

#[test]
fn views_that_come_again_change_nothing() {
    let mut progress = begun();
    assert!(progress.on_view(view("a", 0)).is_none());
    progress.on_view(view("a", 1)).unwrap();
    progress.on_view(view("a", 2)).unwrap();
    assert!(progress.on_view(view("a", 2)).is_none());
    assert_eq!(progress.on_view(view("b", 0)).unwrap().views.len(), 1);
}

fn end(scan_id: &str, views: u32) -> View {
    View {
        kind: View::END,
        scan_id: scan_id.into(),
        index: views,
        count: views,
        ..Default::default()
    }
}

#[test]
fn a_sweep_is_complete_with_the_view_that_says_so() {
    let mut progress = progress();
    for (index, count) in [(0, 13), (1, 13), (2, 3)] {
        let sent = View {
            count,
            ..posed("a", index)
        };
        let message = progress.on_view(sent).unwrap();
        assert_eq!((message.count, message.complete), (count, index == 2));
    }
}

#[test]
fn a_scan_that_ends_early_is_complete_with_what_it_has() {
    let mut progress = progress();
    progress.on_view(posed("a", 0)).unwrap();
    let running = progress.on_view(posed("a", 1)).unwrap();
    assert!(!running.complete);
    let last = progress.on_view(end("a", 2)).unwrap();
    assert_eq!(
        (&last.error[..], last.count, last.view_count, last.complete),
        ("", 2, 2, true)
    );
    assert_eq!(
        (last.header, last.cloud.data),
        (running.header, running.cloud.data)
    );
    assert!(progress.on_view(end("a", 2)).is_none());
    assert!(progress.on_view(posed("a", 2)).is_none());
}

#[test]
fn an_early_end_after_a_lost_view_is_an_error() {
    let mut progress = begun();
    let message = progress.on_view(end("a", 2)).unwrap();
    assert!(
        message.complete && message.error.contains("view 2 of 2 never came"),
        "{}",
        message.error
    );
    // The latched last word of a scan that this node never saw.
    assert!(self::progress().on_view(end("a", 2)).is_none());
}

#[test]
fn a_failed_scan_is_complete() {
    let mut bad = view("a", 0);
    bad.cloud.fields.remove(1);
    let message = progress().on_view(bad).unwrap();
    assert!(message.complete && message.view_count == 0);
}

#[test]
fn an_error_of_an_earlier_stage_is_passed_on_once() {
    let mut progress = begun();
    let failed = View {
        kind: View::FAILED,
        error: "view_capture: no cloud came".into(),
        ..view("a", 1)
    };
    let message = progress.on_view(failed.clone()).unwrap();
    assert_eq!(
        (&message.error[..], &message.scan_id[..]),
        ("view_capture: no cloud came", "a")
    );
    assert_eq!(message.cloud.width, 0);
    assert!(progress.on_view(failed.clone()).is_none());
    // Also where it is all that is heard of a scan.
    assert!(self::progress().on_view(failed).is_some());
}

#[test]
fn a_bad_view_ends_the_scan_under_its_id() {
    let refusal = |view: View| progress().on_view(view).unwrap().error;
    let empty = msg::cloud::from_points(Header::default(), &[]);
    let message = refusal(View {
        cloud: empty,
        ..view("a", 0)
    });
    assert!(
        message.starts_with("icp_registration: view 1 of 3: the view has no points"),
        "{message}"
    );
    let few = msg::cloud::from_points(Header::default(), &[Point3::new(0.0, 0.0, 0.3); 20]);
    let message = refusal(View {
        cloud: few,
        ..view("a", 0)
    });
    assert!(
        message.contains("only 20 points (min_points is 100)"),
        "{message}"
    );
    let message = refusal(View {
        has_pose: true,
        ..view("a", 0)
    });
    assert!(message.contains("hand_from_camera"), "{message}");
    let mut bad = view("a", 0);
    bad.cloud.fields.remove(1);
    assert!(refusal(bad).contains("no field 'y'"));

    let mut progress = progress();
    progress.on_view(posed("a", 0)).unwrap();
    let error = progress.on_view(view("a", 1)).unwrap().error;
    assert!(error.contains("no kinematic pose"), "{error}");
    assert!(progress.on_view(view("a", 2)).is_none());
}

#[test]
fn a_view_that_never_came_is_missed() {
    let mut progress = begun();
    let error = progress.on_view(view("a", 2)).unwrap().error;
    assert!(error.contains("view 2 of 3 never came"), "{error}");
}

#[test]
fn a_node_started_late_keeps_still_until_it_knows_that_the_scan_goes_on() {
    let mut progress = progress();
    assert!(progress.on_view(view("a", 1)).is_none());
    assert!(progress.on_view(view("a", 1)).is_none());
    let error = progress.on_view(view("a", 2)).unwrap().error;
    assert!(error.contains("view 1 of 3 never came"), "{error}");
    assert!(progress.on_view(view("a", 2)).is_none());
    assert!(progress.on_view(view("b", 0)).is_some());
}

#[test]
fn an_abandoned_scan_takes_no_more_views() {
    let mut progress = begun();
    progress.abandon();
    assert!(progress.on_view(view("a", 1)).is_none());
    assert!(progress.on_view(view("b", 0)).is_some());
}
