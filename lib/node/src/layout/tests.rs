#![allow(clippy::unwrap_used)]
use super::parse::LayoutError;
use super::*;
use rosrust::Message;

fn layout_of<T: Message>() -> Layout {
    Layout::parse(&T::msg_definition()).unwrap()
}

fn encoded<T: Message>(message: &T) -> Vec<u8> {
    message.encode_vec().unwrap()[4..].to_vec()
}

#[test]
fn layouts_agree_with_the_encoder() {
    let view = msg::deformable_cobot::View {
        scan_id: "a scan".into(),
        timing: vec![Default::default(); 3],
        ..Default::default()
    };
    let mut bytes = encoded(&view);
    let layout = layout_of::<msg::deformable_cobot::View>();
    layout.check(&mut bytes).unwrap();
    assert_eq!(bytes, encoded(&view));
    bytes.pop();
    assert!(layout.check(&mut bytes).is_err());
    for definition in [
        <msg::deformable_cobot::RegisterViews as msg::service::Service>::request_definition(),
        <msg::deformable_cobot::ClassifyCloud as msg::service::Service>::response_definition(),
    ] {
        Layout::parse(&definition).unwrap();
    }
}

#[test]
fn a_forged_joint_state_is_an_error_not_an_allocation() {
    // An empty header, then 4294967295 names in a message of 28 bytes.
    let mut forged = vec![0; 16];
    forged.extend_from_slice(&u32::MAX.to_le_bytes());
    forged.extend_from_slice(&[0; 8]);
    let error = layout_of::<msg::sensor_msgs::JointState>()
        .check(&mut forged)
        .unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::InvalidData);
}

#[test]
fn fixed_fields_are_joined_and_arrays_kept() {
    let text = "uint8 A=3\nfloat64 x # m\nstring name\nPart[2] parts\n".to_owned()
        + &"=".repeat(80)
        + "\nMSG: p/Part\nint16 a\ntime[] t\n";
    let byte = Layout(vec![Item::Fixed(1)]);
    let times = Item::Array(Layout(vec![Item::Fixed(8)]));
    let expected = Layout(vec![
        Item::Fixed(8),
        Item::Array(byte),
        Item::Fixed(2),
        times.clone(),
        Item::Fixed(2),
        times,
    ]);
    assert_eq!(Layout::parse(&text), Ok(expected));
}

#[test]
fn nonsense_definitions_are_refused() {
    assert!(matches!(
        Layout::parse("float64"),
        Err(LayoutError::Line(_))
    ));
    assert!(matches!(
        Layout::parse("What x"),
        Err(LayoutError::UnknownType(_))
    ));
    let recursive = format!("A a\n{}\nMSG: p/A\nA a\n", "=".repeat(80));
    assert!(matches!(
        Layout::parse(&recursive),
        Err(LayoutError::Recursive(_))
    ));
}

#[test]
fn truth_is_zero_or_one() {
    let layout = Layout::parse("bool a\nbool[2] b\nuint8 c\nbool[] d").unwrap();
    let mut bytes = [2, 0, 255, 7, 3, 0, 0, 0, 1, 9, 0];
    layout.check(&mut bytes).unwrap();
    assert_eq!(bytes, [1, 0, 1, 7, 3, 0, 0, 0, 1, 1, 0]);
}

#[test]
fn many_small_elements_are_too_many() {
    let layout = Layout::parse("string[] names").unwrap();
    let count = ELEMENTS_MAX + 1;
    let mut sent = (count as u32).to_le_bytes().to_vec();
    sent.resize(4 + 4 * count, 0);
    let error = layout.check(&mut sent).unwrap_err();
    assert!(error.to_string().contains("65537 elements"), "{error}");
}

#[test]
fn elements_without_bytes_cannot_spin() {
    let text = format!("E[] many\n{}\nMSG: std_msgs/E\n", "=".repeat(80));
    let layout = Layout::parse(&text).unwrap();
    layout.check(&mut u32::MAX.to_le_bytes()).unwrap();
}
