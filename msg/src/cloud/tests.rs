#![allow(clippy::unwrap_used)]
use super::*;

fn sample() -> PointCloud2 {
    from_points(
        Header::default(),
        &[Point3::new(0.1, -0.2, 0.3), Point3::new(1.0, 2.0, 3.0)],
    )
}

#[test]
fn written_points_are_read_back() {
    let decoded = to_points(&sample()).unwrap();
    assert_eq!(
        decoded.points,
        [Point3::new(0.1, -0.2, 0.3), Point3::new(1.0, 2.0, 3.0)]
    );
    assert_eq!(decoded.invalid, 0);
}

#[test]
fn a_field_beside_the_coordinates_is_where_it_says() {
    let points = [Point3::new(0.1, -0.2, 0.3), Point3::new(1.0, 2.0, 3.0)];
    let cloud = with_field(Header::default(), &points, "deviation", &[0.5, f32::NAN]);
    assert_eq!(to_points(&cloud).unwrap().points, points);
    let field = cloud.fields.last().unwrap();
    assert_eq!((&field.name[..], field.offset), ("deviation", 12));
    let read = values(&cloud, "deviation").unwrap();
    assert!(read[0] == 0.5 && read[1].is_nan() && read.len() == 2);
    let plain = from_points(Header::default(), &points);
    assert!(matches!(
        values(&plain, "deviation"),
        Err(CloudError::MissingField("deviation", _))
    ));
}

#[test]
fn invalid_entries_are_counted_not_kept() {
    let points = [
        Point3::origin(),
        Point3::new(f32::NAN, 0.0, 1.0),
        Point3::new(0.0, 0.0, 1.0),
    ];
    let decoded = to_points(&from_points(Header::default(), &points)).unwrap();
    assert_eq!((decoded.points.len(), decoded.invalid), (1, 2));
}

#[test]
fn an_empty_cloud_is_no_error_here() {
    assert!(
        to_points(&from_points(Header::default(), &[]))
            .unwrap()
            .points
            .is_empty()
    );
}

#[test]
fn unexpected_layouts_are_refused_by_name() {
    let mut cloud = sample();
    cloud.fields.remove(2);
    assert_eq!(
        to_points(&cloud),
        Err(CloudError::MissingField("z", "x, y".into()))
    );
    let mut cloud = sample();
    cloud.fields[1].datatype = PointField::FLOAT64;
    assert_eq!(
        to_points(&cloud),
        Err(CloudError::FieldType("y", PointField::FLOAT64, 1))
    );
    let mut cloud = sample();
    cloud.fields[0].offset = u32::MAX;
    assert!(matches!(
        to_points(&cloud),
        Err(CloudError::FieldOffset { field: "x", .. })
    ));
    let mut cloud = sample();
    cloud.width = 1 << 30;
    assert!(matches!(to_points(&cloud), Err(CloudError::Size { .. })));
    let mut cloud = sample();
    cloud.is_bigendian = true;
    assert_eq!(to_points(&cloud), Err(CloudError::BigEndian));
}

#[test]
fn ordered_clouds_with_padded_rows_are_read() {
    let mut cloud = sample();
    cloud.height = 2;
    cloud.width = 1;
    cloud.row_step = 16;
    assert_eq!(to_points(&cloud).unwrap().points.len(), 2);
}
