//! What the world has of each object: instances that differ in form and size as standards and makers let them.

mod cups;
mod measure;
mod outlines;

use mesh::{Mesh, revolve};
use rand::{Rng, RngExt};

use crate::class::ObjectClass;
use crate::profile::{SEGMENTS, steps, subdivided_in};
use crate::variation::Variation;

/// Which instances of a family may be drawn, so that a classifier is tested on other objects than it was trained on. The ranges
/// of a family's first two measures are cut into fifths each; of these 25 cells five are held out, one in each row and column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instances {
    /// Those to learn from.
    Training,
    /// Those to test on.
    Test,
}

/// Parts of a measure's range.
const CELLS: usize = 5;

impl Instances {
    /// Where a family's first two measures are in their ranges (0 to 1) says whose an instance is.
    fn of(shares: [f32; 2]) -> Self {
        let [first, second] = shares.map(|share| ((share * CELLS as f32) as usize).min(CELLS - 1));
        if (first + 2 * second).is_multiple_of(CELLS) {
            Self::Test
        } else {
            Self::Training
        }
    }
}

/// One undented object of a class, as it may stand in a shop: a form of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Instance {
    class: ObjectClass,
    /// Closed outline (radius, height), m, from the axis at the bottom, outward and up, to the axis again. Point by point it
    /// corresponds to that of the family's middle.
    outline_m: Vec<[f32; 2]>,
}

impl Instance {
    /// An instance of a class's family.
    pub fn random(class: ObjectClass, instances: Instances, random: &mut impl Rng) -> Self {
        let first = loop {
            let shares = [0; 2].map(|_| random.random());
            if Instances::of(shares) == instances {
                break shares;
            }
        };
        let mut first = first.into_iter();
        Self::drawn(class, &mut || {
            first.next().unwrap_or_else(|| random.random())
        })
    }

    /// The one whose measures are all in the middle of their ranges.
    pub fn middle(class: ObjectClass) -> Self {
        Self::drawn(class, &mut || 0.5)
    }

    /// The one whose measures are where `share` (0 to 1) says, in the order of the outline's function.
    fn drawn(class: ObjectClass, share: &mut impl FnMut() -> f32) -> Self {
        let middle_mm = outlines::outline_mm(class, &mut |[least, most]| 0.5 * (least + most));
        let mut draw = |[least, most]: [f32; 2]| least + share() * (most - least);
        let outline_mm = outlines::outline_mm(class, &mut draw);
        Self {
            class,
            outline_m: subdivided_in(&outline_mm, &steps(&middle_mm)),
        }
    }

    /// Whose family it is of.
    pub fn class(&self) -> ObjectClass {
        self.class
    }

    /// Width and height, m.
    pub fn size_m(&self) -> [f32; 2] {
        let most = |axis: usize| {
            let places = self.outline_m.iter();
            places.map(|place| place[axis]).fold(0.0, f32::max)
        };
        [2.0 * most(0), most(1)]
    }

    /// The same form in another size.
    pub fn scaled(&self, size: &Variation) -> Self {
        let scaled = |&[radius_m, height_m]: &[f32; 2]| {
            [size.width_scale * radius_m, size.height_scale * height_m]
        };
        Self {
            class: self.class,
            outline_m: self.outline_m.iter().map(scaled).collect(),
        }
    }

    /// Its surface in the object frame.
    pub fn mesh(&self) -> Mesh {
        revolve(&self.outline_m, SEGMENTS)
    }

    /// Makes a mesh of the family's middle, dented or not, one of this instance: every ring of vertices becomes as wide as this
    /// one's, and is moved to its height. A dent goes with it.
    pub fn carry(&self, mesh: &mut Mesh) {
        let middle = Self::middle(self.class);
        let mut vertices = mesh.vertices.iter_mut();
        for (own, from) in self.outline_m.iter().zip(&middle.outline_m) {
            let is_on_axis = from[0] <= 0.0;
            let (count, scale) = if is_on_axis {
                (1, 1.0)
            } else {
                (SEGMENTS, own[0] / from[0])
            };
            for vertex in vertices.by_ref().take(count) {
                vertex.x *= scale;
                vertex.y *= scale;
                vertex.z += own[1] - from[1];
            }
        }
    }
}

impl ObjectClass {
    /// Least and largest width, and least and largest height, of the instances of its family, m.
    pub fn size_range_m(self) -> [[f32; 2]; 2] {
        outlines::size_range_mm(self).map(|range| range.map(|length_mm| length_mm / 1000.0))
    }
}

/// By which share a width and height (m) are outside of the ranges of the family that is nearest to them in size, whatever its
/// form: the larger one of both; 0 inside.
pub(crate) fn difference(size_m: [f32; 2]) -> f32 {
    let from = |class: ObjectClass| {
        let ranges = class.size_range_m();
        let pairs = size_m.into_iter().zip(ranges);
        pairs
            .map(|(length_m, range_m)| beyond(length_m, range_m))
            .fold(0.0, f32::max)
    };
    ObjectClass::ALL
        .into_iter()
        .map(from)
        .fold(f32::MAX, f32::min)
}

/// By which share a length is outside of a range.
pub(crate) fn beyond(length_m: f32, [least_m, most_m]: [f32; 2]) -> f32 {
    (length_m / most_m - 1.0)
        .max(1.0 - length_m / least_m)
        .max(0.0)
}

#[cfg(test)]
mod tests;
