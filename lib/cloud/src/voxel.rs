//! A grid of cubes, each holding the mean of the points inside it.

use nalgebra::{Point3, Vector3};

/// Why a point could not be put into a grid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum VoxelError {
    /// The voxel size is not positive and finite.
    #[error("a voxel of {0} m; its side must be positive and finite")]
    Size(f32),
    /// A point beyond the range of voxel indices, which have 21 bits for each axis.
    #[error(
        "point {index} at {point} is not finite or more than {limit_m} m from the origin; drop such points first"
    )]
    OutOfRange {
        /// Index of the point.
        index: usize,
        /// Its position.
        point: Point3<f32>,
        /// Largest distance from the origin along an axis with this voxel size.
        limit_m: f32,
    },
}

/// The mean of the points in each occupied cube of side `size_m`, in the order in which the cubes were first met.
///
/// # Errors
/// [`VoxelError`]: an unusable size, or a point that is not finite or too far from the origin.
pub fn downsample(points: &[Point3<f32>], size_m: f32) -> Result<Vec<Point3<f32>>, VoxelError> {
    let mut grid = Grid::new(size_m)?;
    grid.extend(points)?;
    Ok(grid.means().collect())
}

/// Cubes that points can be added to, view after view.
#[derive(Debug, Clone)]
pub struct Grid {
    size_m: f32,
    cells: Vec<Cell>,
    /// Open addressing: index into `cells`, or [`VACANT`]. The length is a power of two, at most half of it in use.
    slots: Vec<u32>,
}

#[derive(Debug, Clone)]
struct Cell {
    key: u64,
    count: u32,
    sum: Vector3<f64>,
}

impl Cell {
    fn mean(&self) -> Point3<f32> {
        Point3::from((self.sum / f64::from(self.count)).cast::<f32>())
    }
}

/// What the six cubes at a cube's faces hold.
struct Around {
    /// Points of all six and of the cube itself.
    sum: u32,
    /// Points of the fullest of the six.
    most: u32,
}

const VACANT: u32 = u32::MAX;
const BITS: u32 = 21;
const HALF_RANGE: f32 = (1 << (BITS - 1)) as f32;

/// From a cube's key to those of the cubes at its faces.
const NEIGHBOURS: [u64; 6] = {
    let (x, y, z) = (1_u64 << (2 * BITS), 1_u64 << BITS, 1_u64);
    [
        x,
        y,
        z,
        x.wrapping_neg(),
        y.wrapping_neg(),
        z.wrapping_neg(),
    ]
};

impl Grid {
    /// An empty grid of cubes of side `size_m`, one of which has a corner at the origin.
    ///
    /// # Errors
    /// [`VoxelError::Size`].
    pub fn new(size_m: f32) -> Result<Self, VoxelError> {
        if !(size_m.is_finite() && size_m > 0.0) {
            return Err(VoxelError::Size(size_m));
        }
        Ok(Self {
            size_m,
            cells: Vec::new(),
            slots: vec![VACANT; 64],
        })
    }

    /// Adds points: all, or none if one of them is refused.
    ///
    /// # Errors
    /// [`VoxelError`] for a point that is not finite or too far from the origin.
    pub fn extend(&mut self, points: &[Point3<f32>]) -> Result<(), VoxelError> {
        let key = |(index, point)| {
            self.key(point)
                .ok_or_else(|| self.out_of_range(index, point))
        };
        let keys = points
            .iter()
            .enumerate()
            .map(key)
            .collect::<Result<Vec<_>, _>>()?;
        self.reserve(points.len());
        for (key, point) in keys.into_iter().zip(points) {
            let cell = self.find_or_insert(key);
            let cell = &mut self.cells[cell];
            cell.count += 1;
            cell.sum += point.coords.cast::<f64>();
        }
        Ok(())
    }

    /// The mean of each cube's points, in the order in which the cubes were first met.
    pub fn means(&self) -> impl ExactSizeIterator<Item = Point3<f32>> {
        self.cells.iter().map(Cell::mean)
    }

    /// The means of the voxels that are not noise, in the order of [`Grid::means`]. Two kinds of voxels are removed:
    ///
    /// - those with fewer points than `neighbour_share` times the points of one of their six face neighbours: the surface lies in
    ///   that neighbour, and depth noise put some of its points here;
    /// - those that together with their face neighbours hold fewer points than `support_share` times the median of this sum: outliers,
    ///   such as flying pixels at depth edges.
    ///
    /// In a cloud of few views the counts are small, and nearly all voxels stay.
    pub fn means_without_noise(
        &self,
        neighbour_share: f32,
        support_share: f32,
    ) -> Vec<Point3<f32>> {
        let around: Vec<Around> = self.cells.iter().map(|cell| self.around(cell)).collect();
        let mut sums: Vec<u32> = around.iter().map(|around| around.sum).collect();
        let middle = sums.len() / 2;
        let median = match sums.get(middle) {
            Some(_) => *sums.select_nth_unstable(middle).1,
            None => return vec![],
        };
        let is_surface = |cell: &Cell, around: &Around| {
            cell.count as f32 >= neighbour_share * around.most as f32
                && around.sum as f32 >= support_share * median as f32
        };
        let cells = self.cells.iter().zip(&around);
        cells
            .filter(|(cell, around)| is_surface(cell, around))
            .map(|(cell, _)| cell.mean())
            .collect()
    }

    fn around(&self, cell: &Cell) -> Around {
        let none = Around {
            sum: cell.count,
            most: 0,
        };
        NEIGHBOURS.iter().fold(none, |around, step| {
            let neighbour = self.find(cell.key.wrapping_add(*step));
            let count = neighbour.map_or(0, |index| self.cells[index].count);
            Around {
                sum: around.sum + count,
                most: around.most.max(count),
            }
        })
    }

    /// Index, in the order of [`Grid::means`], of the occupied cube around a position; `None` if its cube is empty.
    pub fn cell_of(&self, place: &Point3<f32>) -> Option<usize> {
        self.find(self.key(place)?).ok()
    }

    /// Number of occupied cubes.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether no point was added.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    fn out_of_range(&self, index: usize, point: &Point3<f32>) -> VoxelError {
        VoxelError::OutOfRange {
            index,
            point: *point,
            limit_m: HALF_RANGE * self.size_m,
        }
    }

    fn key(&self, point: &Point3<f32>) -> Option<u64> {
        key(&(point.coords / self.size_m))
    }

    /// `Ok` with the index of the cube with this key, or `Err` with the free slot for it.
    fn find(&self, key: u64) -> Result<usize, usize> {
        let mask = self.slots.len() - 1;
        let mut slot = hash(key) & mask;
        while self.slots[slot] != VACANT {
            let cell = self.slots[slot] as usize;
            if self.cells[cell].key == key {
                return Ok(cell);
            }
            slot = (slot + 1) & mask;
        }
        Err(slot)
    }

    /// Index of the cube with this key, which is made if it is not there.
    fn find_or_insert(&mut self, key: u64) -> usize {
        self.find(key).unwrap_or_else(|slot| {
            self.slots[slot] = self.cells.len() as u32;
            self.cells.push(Cell {
                key,
                count: 0,
                sum: Vector3::zeros(),
            });
            self.cells.len() - 1
        })
    }

    /// Reserves room for this many more cubes.
    fn reserve(&mut self, additional: usize) {
        let wanted = (2 * (self.cells.len() + additional)).next_power_of_two();
        if wanted <= self.slots.len() {
            return;
        }
        self.slots = vec![VACANT; wanted];
        for (index, cell) in self.cells.iter().enumerate() {
            let mut slot = hash(cell.key) & (wanted - 1);
            while self.slots[slot] != VACANT {
                slot = (slot + 1) & (wanted - 1);
            }
            self.slots[slot] = index as u32;
        }
    }
}

/// Key of the cube around a position, given in units of the voxel size; `None` if it is out of range or NaN.
fn key(place: &Vector3<f32>) -> Option<u64> {
    let fits = |coordinate: &f32| (-HALF_RANGE..HALF_RANGE).contains(coordinate);
    place.iter().all(fits).then(|| {
        place.iter().fold(0, |key, &coordinate| {
            key << BITS | (floor(coordinate) + (1 << (BITS - 1))) as u64
        })
    })
}

/// Rounds down. The builds are for baseline x86-64, where `f32::floor` is a slower function call.
fn floor(coordinate: f32) -> i64 {
    let towards_zero = coordinate as i64;
    towards_zero - i64::from(coordinate < towards_zero as f32)
}

/// Fibonacci hashing, which spreads neighbouring cubes over the table.
fn hash(key: u64) -> usize {
    (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize
}

#[cfg(test)]
mod tests;
