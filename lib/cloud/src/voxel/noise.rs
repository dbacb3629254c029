//! Cubes that hold noise, by what their neighbours hold.

use nalgebra::Point3;

use super::{BITS, Cell, FACES, Grid, VACANT};

/// From a cube's key to those of the cubes at its faces; three from each stands the opposite one.
const NEIGHBOURS: [u64; FACES] = {
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

/// What the six cubes at a cube's faces hold.
struct Around {
    /// Points of all six and of the cube itself.
    sum: u32,
    /// Points of the fullest of the six.
    most: u32,
}

impl Grid {
    /// The means of the voxels that are not noise, in the order of [`Grid::means`]. Two kinds of voxels are removed:
    ///
    /// - those with fewer points than `neighbour_share` times the points of one of their six face neighbours: the surface lies in
    ///   that neighbour, and depth noise put some of its points here;
    /// - those that together with their face neighbours hold fewer points than `support_share` times the median of this sum: outliers,
    ///   such as flying pixels at depth edges.
    ///
    /// In a cloud of few views the counts are small, and nearly all voxels stay.
    ///
    /// Which cubes are neighbours is looked up once, so that to ask again after each of many views costs little.
    pub fn means_without_noise(
        &mut self,
        neighbour_share: f32,
        support_share: f32,
    ) -> Vec<Point3<f32>> {
        self.link();
        let cells = self.cells.iter().zip(&self.beside);
        let around: Vec<Around> = cells
            .map(|(cell, beside)| self.around(cell, beside))
            .collect();
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

    /// Looks up the neighbours of the cubes that were added since the last time.
    fn link(&mut self) {
        for index in self.beside.len()..self.cells.len() {
            let key = self.cells[index].key;
            let beside = NEIGHBOURS.map(|step| {
                let found = self.find(key.wrapping_add(step));
                found.map_or(VACANT, |neighbour| neighbour as u32)
            });
            for (face, neighbour) in beside.iter().enumerate() {
                if let Some(back) = self.beside.get_mut(*neighbour as usize) {
                    back[(face + FACES / 2) % FACES] = index as u32;
                }
            }
            self.beside.push(beside);
        }
    }

    fn around(&self, cell: &Cell, beside: &[u32; FACES]) -> Around {
        let none = Around {
            sum: cell.count,
            most: 0,
        };
        beside.iter().fold(none, |around, neighbour| {
            let neighbour = self.cells.get(*neighbour as usize);
            let count = neighbour.map_or(0, |neighbour| neighbour.count);
            Around {
                sum: around.sum + count,
                most: around.most.max(count),
            }
        })
    }
}
