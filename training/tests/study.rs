//! A whole study, a small one.
#![allow(clippy::unwrap_used)]

use std::cell::RefCell;
use std::fs;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use sim_dataset::generate::generate;
use sim_dataset::object::Source;
use sim_objects::ObjectClass;
use training::network::backend::Backend;
use training::settings::Settings;
use training::study::{StudyOrder, study};

#[test]
fn a_study_reports_all_and_trains_nothing_twice() {
    let folder = tempfile::tempdir().unwrap();
    let dataset = folder.path().join("dataset");
    let objects = [ObjectClass::MediumBall, ObjectClass::LargeCup];
    let order = sim_dataset::order::Order {
        sources: objects.map(Source::Parametric).to_vec(),
        out: dataset.clone(),
        count: NonZeroUsize::new(18),
        seed: 5,
        jobs: NonZeroUsize::MIN,
        shard: None,
        settings: Default::default(),
    };
    generate(&order, &AtomicBool::new(false), &|_| ()).unwrap();

    let mut settings = Settings::of_paper();
    settings.training.epochs = 2;
    settings.meshes.kept_points = 32;
    let mut order = StudyOrder {
        settings,
        datasets: vec![dataset],
        features: vec![8, 12],
        points: vec![16],
        output: folder.path().join("study"),
        backend: Backend::Cpu,
    };
    let trained = |order: &StudyOrder| {
        let trained = RefCell::new(Vec::new());
        let begin = |features, points, is_new| {
            if is_new {
                trained.borrow_mut().push((features, points));
            }
        };
        study(order, begin, |_| ()).unwrap();
        trained.into_inner()
    };
    assert_eq!(trained(&order), [(8, 16), (12, 16)]);
    order.points.push(24);
    assert_eq!(trained(&order), [(8, 24), (12, 24)]);

    let read = |name: &str| fs::read(order.output.join(name)).unwrap();
    let lines = |name| String::from_utf8(read(name)).unwrap().lines().count();
    // A line of titles; then 4 cells, of 2 epochs, of 2 × 2 answers.
    assert_eq!(
        ["cells.csv", "curves.csv", "confusions.csv"].map(lines),
        [5, 9, 17]
    );
    for plot in [
        "curves-N16",
        "curves-N24",
        "sizes",
        "confusion-F8-N16",
        "confusion-F12-N24",
    ] {
        assert!(
            read(&format!("{plot}.png")).starts_with(b"\x89PNG"),
            "{plot}"
        );
    }
    let page = String::from_utf8(read("report.html")).unwrap();
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 7);
    assert_eq!(page.matches("src=").count(), 7);

    // Other settings are another study; the cells of this one do not count for it.
    order.settings.training.epochs = 3;
    assert_eq!(trained(&order).len(), 4);
}
