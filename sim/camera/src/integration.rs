//! What a camera measures whose exposure lasts while the scene moves.
//!
//! The projector of a D435i moves with the camera, so that its pattern stays sharp on a surface that moves along itself;
//! what changes is where surfaces are. A pixel that sees one surface all the time measures the mean of its disparities; one
//! that an edge passes over measures the surface that it saw for longer.

use crate::image::InverseDepth;

/// Moments of an exposure that are rendered.
pub const MOMENTS: usize = 5;

/// Difference in inverse depth that still is one surface: 12 mm at 0.4 m.
const SAME_SURFACE: f32 = 0.03;

/// The moments, as shares of the exposure before (negative) or after its middle.
pub fn moments() -> [f64; MOMENTS] {
    std::array::from_fn(|moment| (moment as f64 + 0.5) / MOMENTS as f64 - 0.5)
}

/// One image of what was seen at evenly spaced moments of the exposure. Without any it is empty.
///
/// # Panics
/// Where the images are not of one size.
pub fn integrate(images: &[InverseDepth]) -> InverseDepth {
    let Some(first) = images.first() else {
        return InverseDepth::empty(0, 0);
    };
    let mut whole = InverseDepth::empty(first.width, first.height);
    assert!(
        images
            .iter()
            .all(|image| image.per_m.len() == whole.per_m.len()),
        "images of one size"
    );
    let mut seen = Vec::with_capacity(images.len());
    for (pixel, value) in whole.per_m.iter_mut().enumerate() {
        seen.clear();
        seen.extend(images.iter().map(|image| image.per_m[pixel]));
        *value = pixel_value(&mut seen);
    }
    whole
}

fn pixel_value(seen: &mut [f32]) -> f32 {
    let first = seen[0];
    if seen.iter().all(|value| *value == first) {
        return first;
    }
    seen.sort_by(f32::total_cmp);
    let median = seen[seen.len() / 2];
    let is_same = |value: &&f32| (**value - median).abs() <= SAME_SURFACE * median;
    let (sum, count) = seen
        .iter()
        .filter(is_same)
        .fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    sum / count as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(per_m: &[f32]) -> InverseDepth {
        InverseDepth {
            width: per_m.len(),
            height: 1,
            per_m: per_m.to_vec(),
        }
    }

    #[test]
    fn a_surface_is_averaged_and_an_edge_is_one_of_its_sides() {
        let images = [
            image(&[2.5, 2.50, 2.5, 2.5, 0.0]),
            image(&[2.5, 2.52, 2.5, 0.0, 0.0]),
            image(&[2.5, 2.54, 1.0, 0.0, 0.0]),
        ];
        let whole = integrate(&images).per_m;
        for (value, expected) in whole.iter().zip([2.5, 2.52, 2.5, 0.0, 0.0]) {
            assert!((value - expected).abs() < 1e-6, "{whole:?}");
        }
    }

    #[test]
    fn the_moments_lie_evenly_about_the_middle() {
        let sum: f64 = moments().iter().sum();
        assert!(sum.abs() < 1e-12);
        assert!(
            moments()
                .windows(2)
                .all(|pair| (pair[1] - pair[0] - 0.2).abs() < 1e-12)
        );
    }

    #[test]
    fn one_moment_is_no_blur() {
        let sharp = image(&[0.0, 1.0, 2.0]);
        assert_eq!(integrate(std::slice::from_ref(&sharp)), sharp);
    }
}
