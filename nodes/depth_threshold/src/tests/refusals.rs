use super::{Image, intrinsics};
use crate::{DepthImage, Parameters, Thresholder};

/// The message for an image that is wrong in one way.
fn refusal(change: impl FnOnce(&mut DepthImage)) -> String {
    let image = Image::millimetres(4, &[500; 12]);
    let mut view = image.view();
    change(&mut view);
    let mut thresholder = Thresholder::new(Parameters::default()).unwrap();
    thresholder
        .points(&view, &intrinsics(view.width, view.height))
        .unwrap_err()
        .to_string()
}

#[test]
fn bad_images_are_refused_by_name() {
    assert!(refusal(|image| image.encoding = "8UC1").contains("encoding \"8UC1\""));
    assert!(refusal(|image| image.encoding = "rgb8").contains("encoding \"rgb8\""));
    assert!(refusal(|image| image.step = 7).contains("step 7"));
    assert!(refusal(|image| image.encoding = "32FC1").contains("step 8"));
    assert!(refusal(|image| image.data = &image.data[1..]).contains("23 bytes of data"));
    assert!(refusal(|image| image.step = 9).contains("24 bytes of data"));
    assert!(refusal(|image| image.height = u32::MAX).contains("bytes of data"));
    assert!(refusal(|image| image.width = u32::MAX).contains("step 8"));
    assert!(refusal(|image| image.height = 0).contains("4×0"));
}

#[test]
fn camera_info_of_another_stream_is_refused() {
    let image = Image::millimetres(4, &[500; 12]);
    let mut thresholder = Thresholder::new(Parameters::default()).unwrap();
    let message = thresholder
        .points(&image.view(), &intrinsics(8, 6))
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("4×3") && message.contains("8×6"),
        "{message}"
    );
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let refusal = |yaml: &str| {
        let parameters: Parameters = serde_yaml::from_str(yaml).unwrap();
        Thresholder::new(parameters).unwrap_err().to_string()
    };
    assert!(refusal("depth_max_m: .nan").contains("depth_max_m is NaN"));
    assert!(
        refusal("depth_min_m: 0.8")
            .contains("depth_min_m is 0.8; it must be from 0 to 0.7 m (depth_max_m)")
    );
    assert!(refusal("decimation: 9").contains("decimation is 9"));
    assert!(refusal("edge_jump_m: -0.1").contains("edge_jump_m is -0.1"));
    let unknown = serde_yaml::from_str::<Parameters>("depth_maximum: 1")
        .unwrap_err()
        .to_string();
    assert!(unknown.contains("depth_maximum"), "{unknown}");
}
