//! Which points are near a place.

use nalgebra::{Point2, Point3};

/// Points sorted into rows along x, and along each row by x.
///
/// Made for a surface with points at about equal distances, asked for those within a few such distances: then only a
/// few rows are looked at, and of each only the part that is near. Asking allocates nothing.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    side_m: f32,
    /// Smallest y and z.
    corner: Point2<f32>,
    /// Rows along y and z.
    counts: [usize; 2],
    /// Row `n` is `spots[starts[n]..starts[n + 1]]`.
    starts: Vec<u32>,
    spots: Vec<Spot>,
}

#[derive(Debug, Clone, Copy)]
struct Spot {
    place: Point3<f32>,
    index: u32,
}

/// Points spread over a large volume get wider rows rather than more than this many a point.
const MAX_ROWS_PER_POINT: usize = 16;

impl Rows {
    /// Sorts finite points into rows that are this wide, or wider. `None` for no points.
    pub(crate) fn new(points: &[Point3<f32>], side_m: f32) -> Option<Self> {
        let bounds = cloud::bounds(points)?;
        let extent = bounds.extent().yz();
        let max_rows = (MAX_ROWS_PER_POINT * points.len()) as f32;
        let side_m = (extent.x * extent.y / max_rows)
            .sqrt()
            .max(extent.max() / max_rows)
            .max(side_m);
        let count = |extent: f32| (extent / side_m) as usize + 1;
        let mut rows = Self {
            side_m,
            corner: bounds.min.yz(),
            counts: [count(extent.x), count(extent.y)],
            starts: Vec::new(),
            spots: Vec::new(),
        };
        rows.sort(points);
        Some(rows)
    }

    /// A counting sort by row, then each row by x.
    fn sort(&mut self, points: &[Point3<f32>]) {
        let row_of =
            |point: &Point3<f32>| self.row(point.y, 0) + self.counts[0] * self.row(point.z, 1);
        let rows: Vec<usize> = points.iter().map(row_of).collect();
        let mut starts = vec![0; self.counts[0] * self.counts[1] + 1];
        rows.iter().for_each(|&row| starts[row] += 1);
        let mut end = 0;
        for start in &mut starts {
            end += *start;
            *start = end;
        }
        let nowhere = Spot {
            place: Point3::origin(),
            index: 0,
        };
        let mut spots = vec![nowhere; points.len()];
        for (index, (&place, &row)) in points.iter().zip(&rows).enumerate().rev() {
            starts[row] -= 1;
            let index = index as u32;
            spots[starts[row] as usize] = Spot { place, index };
        }
        for ends in starts.windows(2) {
            spots[ends[0] as usize..ends[1] as usize]
                .sort_unstable_by(|a, b| a.place.x.total_cmp(&b.place.x));
        }
        (self.starts, self.spots) = (starts, spots);
    }

    /// Calls with the index and the squared distance (m²) of every point within this distance of a place, in no order.
    pub(crate) fn within(
        &self,
        place: &Point3<f32>,
        radius_m: f32,
        mut found: impl FnMut(u32, f32),
    ) {
        let radius_sq = radius_m * radius_m;
        let (first_x, last_x) = (place.x - radius_m, place.x + radius_m);
        let rows = |coordinate: f32, axis| {
            self.row(coordinate - radius_m, axis)..=self.row(coordinate + radius_m, axis)
        };
        for z in rows(place.z, 1) {
            for y in rows(place.y, 0) {
                let row = y + self.counts[0] * z;
                let row = &self.spots[self.starts[row] as usize..self.starts[row + 1] as usize];
                let first = row.partition_point(|spot| spot.place.x < first_x);
                for spot in row[first..]
                    .iter()
                    .take_while(|spot| spot.place.x <= last_x)
                {
                    let distance_sq = (place - spot.place).norm_squared();
                    if distance_sq <= radius_sq {
                        found(spot.index, distance_sq);
                    }
                }
            }
        }
    }

    /// Number along y (0) or z (1) of the row at, or nearest to, a coordinate.
    fn row(&self, coordinate: f32, axis: usize) -> usize {
        // Conversion of a negative number gives 0.
        let number = ((coordinate - self.corner[axis]) / self.side_m) as usize;
        number.min(self.counts[axis] - 1)
    }
}

#[cfg(test)]
mod tests;
