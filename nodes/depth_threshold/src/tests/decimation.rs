use super::{Image, intrinsics, keep_all};
use crate::Parameters;
use crate::decimation::decimate;
use crate::image::Depths;

#[test]
fn decimation_takes_the_lower_median_of_what_is_valid() {
    let depths = [500, 0, 10, 40, 504, 502, 30, 20];
    let parameters = Parameters {
        decimation: 2,
        ..keep_all()
    };
    let points = Image::millimetres(4, &depths).points(parameters);
    assert_eq!(
        points.iter().map(|point| point.z).collect::<Vec<_>>(),
        [0.502, 0.02]
    );
    // The decimated pixel (1, 0) with all four intrinsics halved.
    let camera = intrinsics(4, 2);
    assert!(
        (f64::from(points[1].x) - (1.0 - camera.cx / 2.0) / (camera.fx / 2.0) * 0.02).abs() < 1e-8
    );
}

#[test]
fn decimation_from_four_on_takes_the_mean_rounded_down() {
    let mut depths = [0; 16];
    depths[3] = 500;
    depths[9] = 501;
    let parameters = Parameters {
        decimation: 4,
        ..keep_all()
    };
    assert_eq!(
        Image::millimetres(4, &depths).depths(parameters.clone()),
        [0.5]
    );
    assert!(
        Image::millimetres(4, &[0; 16])
            .depths(parameters)
            .is_empty()
    );
}

#[test]
fn decimation_pads_to_multiples_of_four() {
    let mut depths = Depths::default();
    Image::millimetres(11, &[500; 11 * 7])
        .view()
        .decode(&mut depths)
        .unwrap();
    let mut decimated = Depths::default();
    decimate(&depths, 2, &mut decimated);
    assert_eq!((decimated.width, decimated.height), (8, 4));
    assert_eq!(
        decimated.row(2),
        [500.0, 500.0, 500.0, 500.0, 500.0, 0.0, 0.0, 0.0]
    );
    assert_eq!(decimated.row(3), [0.0; 8]);
    // A picture smaller than one square has no pixel left.
    assert!(
        Image::millimetres(3, &[500; 9])
            .depths(Parameters {
                decimation: 8,
                ..keep_all()
            })
            .is_empty()
    );
}
