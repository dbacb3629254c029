//! Sets of points of a regular lattice, as sorted keys: sets combine by merging, and neighbours are near in memory.

use std::cmp::Ordering;

/// Bits of one coordinate in a key: three fit into 64.
const BITS: u32 = 21;
const MASK: u64 = (1 << BITS) - 1;
/// Added to each coordinate, so that the neighbours of 0 have a key, too.
const BIAS: i32 = 2;

/// A lattice place (x, y, z) as one number that sorts by x, then y, then z.
pub(super) fn key(place: [i32; 3]) -> u64 {
    let [x, y, z] = place.map(|coordinate| (coordinate + BIAS) as u64 & MASK);
    x << (2 * BITS) | y << BITS | z
}

/// The place of a key.
pub(super) fn place(key: u64) -> [i32; 3] {
    [2 * BITS, BITS, 0].map(|shift| (key >> shift & MASK) as i32 - BIAS)
}

/// What to add to a key to move by one along x, y or z.
pub(super) const STEPS: [u64; 3] = [1 << (2 * BITS), 1 << BITS, 1];

/// Two sorted sets in one.
pub(super) fn union(a: &[u64], b: impl Iterator<Item = u64>) -> Vec<u64> {
    let mut all = Vec::with_capacity(a.len() + a.len() / 2);
    let (mut a, mut b) = (a.iter().copied().peekable(), b.peekable());
    loop {
        let next = match (a.peek(), b.peek()) {
            (Some(x), Some(y)) => match x.cmp(y) {
                Ordering::Less => a.next(),
                Ordering::Greater => b.next(),
                Ordering::Equal => {
                    a.next();
                    b.next()
                }
            },
            (Some(_), None) => a.next(),
            (None, _) => b.next(),
        };
        match next {
            Some(key) => all.push(key),
            None => return all,
        }
    }
}

/// All places whose coordinates differ by at most one from those of a place of the set.
pub(super) fn dilated(set: &[u64]) -> Vec<u64> {
    STEPS.iter().fold(set.to_vec(), |set, step| {
        let lower = union(&set, set.iter().map(|key| key - step));
        union(&lower, set.iter().map(|key| key + step))
    })
}

/// The corners of cells; a cell has the place of its smallest corner.
pub(super) fn corners(cells: &[u64]) -> Vec<u64> {
    STEPS.iter().fold(cells.to_vec(), |set, step| {
        union(&set, set.iter().map(|key| key + step))
    })
}

/// The eight halves, on the lattice twice as fine, of each cell.
pub(super) fn children(cells: &[u64]) -> Vec<u64> {
    let doubled = |&cell: &u64| key(place(cell).map(|coordinate| 2 * coordinate));
    corners(&cells.iter().map(doubled).collect::<Vec<_>>())
}

/// A sorted set of lattice points with an index for look-ups.
pub(super) struct Lattice {
    keys: Vec<u64>,
    /// Where each (x, y) begins, for all of them within the box around the set, and where the last ends.
    rows: Vec<u32>,
    first: [i32; 2],
    width: i32,
}

impl Lattice {
    /// Makes a sorted set of keys without repeats ready for looking up.
    pub fn new(keys: Vec<u64>) -> Self {
        let mut low = [i32::MAX; 2];
        let mut high = [i32::MIN; 2];
        for &key in &keys {
            let [x, y, _] = place(key);
            low = [low[0].min(x), low[1].min(y)];
            high = [high[0].max(x), high[1].max(y)];
        }
        if keys.is_empty() {
            (low, high) = ([0; 2], [0; 2]);
        }
        let width = high[1] - low[1] + 1;
        let mut lattice = Self {
            keys,
            rows: vec![0; (width * (high[0] - low[0] + 1)) as usize + 1],
            first: low,
            width,
        };
        let rows: Vec<usize> = lattice
            .keys
            .iter()
            .filter_map(|&key| lattice.row(key))
            .collect();
        for row in rows {
            lattice.rows[row + 1] += 1;
        }
        for row in 1..lattice.rows.len() {
            lattice.rows[row] += lattice.rows[row - 1];
        }
        lattice
    }

    /// Sorted keys; indices count along these.
    pub fn keys(&self) -> &[u64] {
        &self.keys
    }

    /// Index of a place; `None` where it is not in the set. The place above (z + 1), if in the set, has the next.
    pub fn find(&self, key: u64) -> Option<u32> {
        let row = self.row(key)?;
        let (start, end) = (self.rows[row] as usize, self.rows[row + 1] as usize);
        let at = self.keys[start..end].binary_search(&key).ok()?;
        Some((start + at) as u32)
    }

    /// Number of the row (x, y) that a key belongs to.
    fn row(&self, key: u64) -> Option<usize> {
        let [x, y, _] = place(key);
        let (x, y) = (x - self.first[0], y - self.first[1]);
        let is_inside = x >= 0 && (0..self.width).contains(&y);
        let row = is_inside.then(|| (x * self.width + y) as usize)?;
        (row + 1 < self.rows.len()).then_some(row)
    }
}
