#![allow(clippy::unwrap_used)]
use msg::cloud::{from_points, with_field};
use msg::deformable_cobot::ViewRegistration;
use msg::std_msgs::Header;
use msg::transform::from_isometry;

use super::*;

/// A scan with as many points a view, and its deformation.
fn scan(points: usize, views: u32) -> (Recorded, Deformation) {
    let line = |k: usize| Point3::new(0.1, 1e-6 * k as f32, 0.2);
    let all: Vec<_> = (0..points).map(line).collect();
    let mut scan = Recorded::default();
    for index in 0..views {
        let view = View {
            cloud: from_points(Header::default(), &all),
            ..Default::default()
        };
        scan.views.insert(index, view);
        scan.registered.views.push(ViewRegistration {
            index,
            accepted: true,
            transform: from_isometry(&Isometry3::identity()),
            ..Default::default()
        });
    }
    scan.object.cloud = from_points(Header::default(), &all);
    let deformation = Deformation {
        cloud: with_field(Header::default(), &all, DEVIATION, &vec![-0.003; all.len()]),
        largest_depth: 0.0071,
        dents: vec![Dent::default()],
        summary: "dented: 7 mm".into(),
        fits: true,
        ..Default::default()
    };
    (scan, deformation)
}

fn shown(page: &str) -> serde_json::Value {
    let (_, rest) = page.split_once("type=\"application/json\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_page_holds_object_views_and_dents_and_nothing_ends_its_data_early() {
    let (scan, deformation) = scan(10, 2);
    let answer = Classification {
        label: "</script>{{three}}".into(),
        known: true,
        ..Default::default()
    };
    let page = page(&scan, &answer, Some(&deformation)).unwrap();
    let shown = shown(&page);
    assert_eq!(shown["title"], "</script>{{three}}");
    assert_eq!(shown["summary"], "dented: 7 mm");
    assert_eq!(shown["views"].as_array().unwrap().len(), 2);
    assert_eq!(shown["dents"].as_array().unwrap().len(), 1);
    assert_eq!(shown["deviation_reach"], 0.008);
    let bytes = BASE64_STANDARD.decode(shown["deviation"].as_str().unwrap());
    assert_eq!(bytes.unwrap().len(), 4 * 10);
    assert!(page.contains("THREE=") && !page.contains("<script src"));
    assert!(!page.contains("{{page}}") && !page.contains("{{scan}}"));
}

#[test]
fn the_largest_scan_makes_a_page_below_3_mb() {
    let (scan, deformation) = scan(200_000, 12);
    let page = page(&scan, &Classification::default(), Some(&deformation)).unwrap();
    assert!(page.len() < 3_000_000, "{}", page.len());
}

#[test]
fn without_a_deformation_the_page_is_of_one_colour() {
    let (scan, _) = scan(10, 1);
    let page = page(&scan, &Classification::default(), None).unwrap();
    let shown = shown(&page);
    assert!(shown["deviation"].is_null());
    assert_eq!(shown["title"], "empty hand");
}
