use nalgebra::{Isometry3, Point3, Translation3, Vector3};

use super::scene;
use crate::{InitialGuess, Parameters, RegisterError, Registrar, RegistrationError, register};

fn block() -> Vec<Point3<f32>> {
    scene::block(&mut scene::random(41), 3000)
        .iter()
        .map(|(place, _)| place.cast())
        .collect()
}

/// The same answer for a first and for a later view; the cloud stays as it was.
fn refusal(points: &[Point3<f32>]) -> RegistrationError {
    let mut registrar = Registrar::new(Parameters::default()).unwrap();
    let first = registrar.add_view(points, None).unwrap_err();
    assert!(registrar.cloud().is_empty());
    registrar.add_view(&block(), None).unwrap();
    let before = registrar.cloud();
    assert_eq!(registrar.add_view(points, None).unwrap_err(), first);
    assert_eq!(registrar.cloud(), before);
    first
}

#[test]
fn views_without_a_shape_are_refused_by_name() {
    assert_eq!(refusal(&[]), RegistrationError::Empty);
    assert_eq!(
        refusal(&[Point3::new(0.1, 0.2, 0.3)]),
        RegistrationError::TooFew {
            count: 1,
            needed: 100
        }
    );
    let line: Vec<_> = (0..200)
        .map(|step| Point3::new(0.001, 0.002, -0.001) * step as f32)
        .collect();
    assert_eq!(refusal(&line), RegistrationError::Collinear { count: 200 });
    assert_eq!(
        refusal(&[Point3::new(0.1, 0.2, 0.3); 200]),
        RegistrationError::Collinear { count: 200 }
    );
    let flat: Vec<_> = (0..400)
        .map(|step| [(step % 20) as f32 * 0.001, (step / 20) as f32 * 0.001])
        .map(|[x, y]| Point3::new(x, y, 0.3 + 0.4 * x - 0.2 * y))
        .collect();
    assert_eq!(refusal(&flat), RegistrationError::Planar { count: 400 });
    let mut bad = block();
    bad[7].y = f32::NAN;
    assert_eq!(refusal(&bad), RegistrationError::NotFinite { index: 7 });
    bad[7].y = 1e4;
    assert!(matches!(refusal(&bad), RegistrationError::TooLarge(_)));
}

#[test]
fn bad_or_mixed_poses_are_refused() {
    let block = block();
    let mut registrar = Registrar::new(Parameters::default()).unwrap();
    let bad = Isometry3::from_parts(Translation3::new(0.0, f64::NAN, 0.0), Default::default());
    assert_eq!(
        registrar.add_view(&block, Some(bad)),
        Err(RegistrationError::BadPose)
    );
    registrar
        .add_view(&block, Some(Isometry3::identity()))
        .unwrap();
    let mixed = registrar.add_view(&block, None).unwrap_err();
    assert!(
        mixed
            .to_string()
            .contains("this view has no kinematic pose"),
        "{mixed}"
    );
    let mut registrar = Registrar::new(Parameters::default()).unwrap();
    registrar.add_view(&block, None).unwrap();
    let mixed = registrar
        .add_view(&block, Some(Isometry3::identity()))
        .unwrap_err();
    assert!(
        mixed.to_string().contains("this view has a kinematic pose"),
        "{mixed}"
    );
}

#[test]
fn identity_as_configured_does_not_look_at_poses() {
    let block = block();
    let parameters = Parameters {
        initial_guess: InitialGuess::Identity,
        ..Parameters::default()
    };
    let far = Isometry3::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros());
    let (registrar, evidence) =
        register(parameters, [(&block[..], Some(far)), (&block[..], None)]).unwrap();
    assert!(!registrar.in_hand_frame());
    assert_eq!(evidence[0].transform, Isometry3::identity());
    assert!(evidence[1].accepted);
}

#[test]
fn registering_at_once_names_the_view() {
    let block = block();
    let error = register(Parameters::default(), [(&block[..], None), (&[], None)]).unwrap_err();
    assert!(matches!(
        error,
        RegisterError::View {
            index: 1,
            source: RegistrationError::Empty
        }
    ));
    assert_eq!(error.to_string(), "view 1");
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let refusal = |yaml: &str| {
        let parameters: Parameters = serde_yaml::from_str(yaml).unwrap();
        Registrar::new(parameters).unwrap_err().to_string()
    };
    assert!(refusal("voxel_m: 0").contains("voxel_m is 0; it must be from 0.0002 to 0.05 m"));
    assert!(refusal("kept_fraction: 1.5").contains("kept_fraction is 1.5"));
    assert!(refusal("max_iterations: 0").contains("max_iterations is 0"));
    assert!(refusal("min_fitness: .nan").contains("min_fitness is NaN"));
    let unknown = serde_yaml::from_str::<Parameters>("voxel: 1")
        .unwrap_err()
        .to_string();
    assert!(unknown.contains("voxel"), "{unknown}");
    assert!(serde_yaml::from_str::<Parameters>("initial_guess: hope").is_err());
    let identity: Parameters = serde_yaml::from_str("initial_guess: identity").unwrap();
    assert_eq!(identity.initial_guess, InitialGuess::Identity);
}
