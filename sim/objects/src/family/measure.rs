//! What outlines are made of, in millimetres.

/// Least and largest measure.
pub(super) type Range = [f32; 2];
/// Radius and height of its points, from the axis at the bottom, outward and up, to the axis again.
pub(super) type Outline = Vec<[f32; 2]>;
