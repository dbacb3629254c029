//! A grid of cubes, each holding the mean of the points inside it.

mod noise;

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
    /// For the first of `cells`: the cubes at their faces, as indices into `cells`, or [`VACANT`].
    beside: Vec<[u32; FACES]>,
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

const FACES: usize = 6;
const VACANT: u32 = u32::MAX;
const BITS: u32 = 21;
const HALF_RANGE: f32 = (1 << (BITS - 1)) as f32;

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
            beside: Vec::new(),
        })
    }

    /// Adds points: all, or none if one of them is refused.
    ///
    /// # Errors
    /// [`VoxelError`] for a point that is not finite or too far from the origin.
    pub fn extend(&mut self, points: &[Point3<f32>]) -> Result<(), VoxelError> {
        let mut keys = Vec::with_capacity(points.len());
        for (index, point) in points.iter().enumerate() {
            let key = self.key(point);
            keys.push(key.ok_or_else(|| self.out_of_range(index, point))?);
        }
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
