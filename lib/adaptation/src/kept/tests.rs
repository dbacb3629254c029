#![allow(clippy::unwrap_used)]
use super::*;

fn example() -> Kept {
    let rows = |count: usize, scale: f32| {
        let mut rows = FeatureRows::new(3);
        for k in 0..count {
            rows.push(&[scale * k as f32, 1.0, -scale]);
        }
        rows
    };
    let block = |label: Option<&str>, count| Block {
        label: label.map(str::to_owned),
        fit: rows(count, 0.37),
        check: rows(count / 2, 0.11),
    };
    Kept {
        model: "digest".to_owned(),
        made: "by a test".to_owned(),
        width: 3,
        blocks: vec![
            block(Some("can"), 9),
            block(Some("new\nline"), 1),
            block(None, 4),
        ],
    }
}

#[test]
fn a_file_reads_back_nearly_the_same_and_then_exactly() {
    let kept = example();
    let read = Kept::decode(&kept.encode().unwrap()).unwrap();
    for (before, after) in kept.blocks.iter().zip(&read.blocks) {
        assert_eq!(before.label, after.label);
        let pairs = before.fit.values.iter().zip(&after.fit.values);
        assert!(
            pairs
                .clone()
                .all(|(a, b)| (a - b).abs() < 3.0 / 510.0 + 1e-6)
        );
        assert_eq!(before.check.len(), after.check.len());
    }
    assert_eq!(Kept::decode(&read.encode().unwrap()).unwrap(), read);
    assert_eq!(read.of("can").unwrap().fit.len(), 9);
    assert!(read.of("cup").is_none() && read.strangers().is_some());
}

#[test]
fn each_spoiled_file_is_refused_or_read_without_a_panic() {
    let bytes = example().encode().unwrap();
    assert_eq!(Kept::decode(b"ply\n"), Err(KeptError::Version));
    for length in VERSION.len() + 1..bytes.len() {
        assert!(matches!(
            Kept::decode(&bytes[..length]),
            Err(KeptError::Damaged(_))
        ));
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(Kept::decode(&longer).is_err());
    for place in 0..bytes.len() {
        let mut spoiled = bytes.clone();
        spoiled[place] ^= 0x55;
        let _ = Kept::decode(&spoiled);
    }
}

#[test]
fn thinning_keeps_the_order_and_the_count() {
    let mut rows = FeatureRows::new(1);
    (0..10).for_each(|k| rows.push(&[k as f32]));
    assert_eq!(rows.thinned(5).values, [0.0, 2.0, 4.0, 6.0, 8.0]);
    assert_eq!(rows.thinned(20), rows);
    assert_eq!(
        rows.parts(4).map(|part| part.len()).collect::<Vec<_>>(),
        [4, 4, 2]
    );
}
