//! Farthest-point sampling.

use nalgebra::Point3;

use crate::{centroid, is_finite};

/// Why a cloud could not be sampled.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SampleError {
    /// The cloud has fewer points than wanted. Points are not repeated, since that would distort the density.
    #[error(
        "{count} points wanted of a cloud of {available}; look closer, or with a wider depth range"
    )]
    TooFew {
        /// Number of points wanted.
        count: usize,
        /// Number of points in the cloud.
        available: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {index} has a coordinate that is NaN or infinite; drop such points first")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
}

/// Indices of `count` points, each the farthest from those before it; the first is the farthest from the centroid.
/// Of equally far points the one with the lowest index is taken.
///
/// Costs `count` passes over the cloud.
///
/// # Errors
/// [`SampleError`]: the cloud has too few points, or one is not finite.
pub fn farthest_points(points: &[Point3<f32>], count: usize) -> Result<Vec<usize>, SampleError> {
    if points.len() < count {
        return Err(SampleError::TooFew {
            count,
            available: points.len(),
        });
    }
    if let Some(index) = points.iter().position(|point| !is_finite(point)) {
        return Err(SampleError::NotFinite { index });
    }
    let Some(centre) = centroid(points).filter(|_| count > 0) else {
        return Ok(Vec::new());
    };
    let columns = Columns::new(points);
    let mut distances_sq = vec![f32::INFINITY; columns.padded_len()];
    let mut index = columns.farthest_after(&centre, &mut distances_sq);
    // The centroid only determines the first sample; later samples need not be far from it.
    distances_sq.fill(f32::INFINITY);

    let mut indices = Vec::with_capacity(count);
    indices.push(index);
    while indices.len() < count {
        // Never choose a point twice, even if copies of it make all distances 0.
        distances_sq[index] = f32::NEG_INFINITY;
        index = columns.farthest_after(&points[index], &mut distances_sq);
        indices.push(index);
    }
    Ok(indices)
}

/// Points handled together, so that the compiler uses vector instructions.
const LANES: usize = 8;

/// The cloud by coordinate, padded to whole groups of [`LANES`].
struct Columns {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    len: usize,
}

impl Columns {
    fn new(points: &[Point3<f32>]) -> Self {
        let padded_len = points.len().next_multiple_of(LANES);
        let column = |axis: usize| {
            let mut column = Vec::with_capacity(padded_len);
            column.extend(points.iter().map(|point| point[axis]));
            column.resize(padded_len, 0.0);
            column
        };
        Self {
            x: column(0),
            y: column(1),
            z: column(2),
            len: points.len(),
        }
    }

    fn padded_len(&self) -> usize {
        self.x.len()
    }

    /// Lowers each distance to that from `sample` where it is nearer, and returns the index of the largest.
    fn farthest_after(&self, sample: &Point3<f32>, distances_sq: &mut [f32]) -> usize {
        distances_sq[self.len..].fill(f32::NEG_INFINITY);
        let mut largest = [f32::NEG_INFINITY; LANES];
        let groups = self
            .x
            .chunks_exact(LANES)
            .zip(self.y.chunks_exact(LANES))
            .zip(self.z.chunks_exact(LANES));
        for (((x, y), z), distances_sq) in groups.zip(distances_sq.chunks_exact_mut(LANES)) {
            for lane in 0..LANES {
                let (dx, dy, dz) = (x[lane] - sample.x, y[lane] - sample.y, z[lane] - sample.z);
                let distance_sq = dx * dx + dy * dy + dz * dz;
                let nearest = if distance_sq < distances_sq[lane] {
                    distance_sq
                } else {
                    distances_sq[lane]
                };
                distances_sq[lane] = nearest;
                largest[lane] = if nearest > largest[lane] {
                    nearest
                } else {
                    largest[lane]
                };
            }
        }
        let largest = largest.into_iter().fold(f32::NEG_INFINITY, f32::max);
        distances_sq
            .iter()
            .position(|&distance_sq| distance_sq == largest)
            .unwrap_or(0)
    }
}

#[cfg(test)]
mod tests;
