//! Spatial hashing: points sorted into cubes, to find neighbours within one cube's side.

use nalgebra::{Point3, Vector3};

/// Indices of points by the cube that they are in.
pub(crate) struct Cells {
    side_m: f32,
    /// Points of hash bucket `b` are `indices[starts[b]..starts[b + 1]]`.
    starts: Vec<u32>,
    indices: Vec<u32>,
}

impl Cells {
    /// Sorts finite points into cubes of this side.
    pub(crate) fn new(points: &[Point3<f32>], side_m: f32) -> Self {
        let bucket_count = (2 * points.len()).next_power_of_two().max(64);
        let mut cells = Self {
            side_m,
            starts: vec![0; bucket_count + 1],
            indices: vec![0; points.len()],
        };
        let buckets: Vec<usize> = points
            .iter()
            .map(|point| cells.bucket(&cells.cube(point)))
            .collect();
        // Counting sort: count each bucket, sum up to the buckets' ends, then fill each bucket from its end downward.
        buckets.iter().for_each(|&bucket| cells.starts[bucket] += 1);
        let mut end = 0;
        for start in &mut cells.starts {
            end += *start;
            *start = end;
        }
        for (index, &bucket) in buckets.iter().enumerate().rev() {
            cells.starts[bucket] -= 1;
            cells.indices[cells.starts[bucket] as usize] = index as u32;
        }
        cells
    }

    /// Every point of the 27 cubes around a position, each once. Hash collisions may add points from other cubes.
    pub(crate) fn around(&self, place: &Point3<f32>) -> impl Iterator<Item = usize> {
        let centre = self.cube(place);
        let mut buckets = [0; 27];
        for (number, bucket) in buckets.iter_mut().enumerate() {
            // The cube itself first: there the nearest points are.
            let number = (number + 13) % 27;
            let step = |divisor: usize| (number / divisor % 3) as i32 - 1;
            let offset = Vector3::new(step(1), step(3), step(9));
            *bucket = self.bucket(&centre.zip_map(&offset, i32::wrapping_add));
        }
        // Two of the cubes may share a bucket; return its points only once.
        (0..27)
            .filter(move |&number| !buckets[..number].contains(&buckets[number]))
            .map(move |number| buckets[number])
            .flat_map(|bucket| {
                &self.indices[self.starts[bucket] as usize..self.starts[bucket + 1] as usize]
            })
            .map(|&index| index as usize)
    }

    fn cube(&self, point: &Point3<f32>) -> Vector3<i32> {
        point
            .coords
            .map(|coordinate| (coordinate / self.side_m).floor() as i32)
    }

    fn bucket(&self, cube: &Vector3<i32>) -> usize {
        let mix = |hash: u64, &coordinate: &i32| {
            (hash ^ u64::from(coordinate as u32)).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        };
        (cube.iter().fold(0, mix) >> 32) as usize & (self.starts.len() - 2)
    }
}
