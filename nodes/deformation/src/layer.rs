//! Points all over a surface, and the nearest of them to any place.

use cloud::Tree;
use mesh::Mesh;
use nalgebra::{Point3, Vector3};

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    /// In m.
    pub point: Point3<f32>,
    /// Of unit length, to the outside.
    pub normal: Vector3<f32>,
}

/// Points that stand for as much area each, spread evenly: systematic sampling of the area, and within a triangle the
/// sequence R2 of M. Roberts ("The unreasonable effectiveness of quasirandom sequences", 2018). None for a mesh without
/// area.
pub(crate) fn samples(mesh: &Mesh, area_m2: f64) -> Vec<Sample> {
    const R2: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    let mut samples = Vec::new();
    let mut left_m2 = 0.5 * area_m2;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|index| mesh.vertices[index as usize].cast::<f64>());
        let across = (b - a).cross(&(c - a));
        let Some(normal) = across.try_normalize(1e-12) else {
            continue;
        };
        left_m2 += 0.5 * across.norm();
        while left_m2 >= area_m2 {
            left_m2 -= area_m2;
            let number = samples.len() as f64 + 1.0;
            let [mut u, mut v] = R2.map(|step| (0.5 + number * step).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            samples.push(Sample {
                point: (a + u * (b - a) + v * (c - a)).cast(),
                normal: normal.cast(),
            });
        }
    }
    samples
}

/// A part of a surface, searchable.
pub(crate) struct Layer {
    pub samples: Vec<Sample>,
    tree: Tree,
    grid: Grid,
}

impl Layer {
    /// `None` for no samples.
    pub(crate) fn new(samples: Vec<Sample>) -> Option<Self> {
        let points: Vec<_> = samples.iter().map(|sample| sample.point).collect();
        let tree = Tree::new(&points)?;
        let grid = Grid::new(&points, &tree)?;
        Some(Self {
            samples,
            tree,
            grid,
        })
    }

    /// Index of the sample nearest to a place.
    pub(crate) fn nearest(&self, place: &Point3<f32>) -> usize {
        self.tree.nearest(place).index
    }

    /// Indices of the samples within a distance, in no order.
    pub(crate) fn within(&self, place: &Point3<f32>, radius_m: f32) -> impl Iterator<Item = usize> {
        self.tree.within(place, radius_m).map(|found| found.index)
    }

    /// About the nearest sample, much quicker: the one that is nearest to the middle of the cube that the place lies in.
    /// `None` beyond [`MARGIN_M`] around the surface.
    pub(crate) fn near(&self, place: &Point3<f32>) -> Option<&Sample> {
        self.grid.at(place).map(|index| &self.samples[index])
    }
}

/// The nearest sample's index for each cube around a surface.
struct Grid {
    corner: Point3<f32>,
    size: [usize; 3],
    nearest: Vec<u32>,
}

/// Side of a cube: the surface of a can rises by 0.05 mm within.
const CUBE_M: f32 = 0.003;
/// How far around the surface the grid reaches.
pub(crate) const MARGIN_M: f32 = 0.024;

impl Grid {
    fn new(points: &[Point3<f32>], tree: &Tree) -> Option<Self> {
        let bounds = cloud::bounds(points)?;
        let corner = bounds.min - Vector3::repeat(MARGIN_M);
        let extent = bounds.extent() + Vector3::repeat(2.0 * MARGIN_M);
        let size = [extent.x, extent.y, extent.z].map(|m| (m / CUBE_M).ceil().max(1.0) as usize);
        let mut nearest = Vec::with_capacity(size.iter().product());
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let cube = Vector3::new(x as f32, y as f32, z as f32).add_scalar(0.5);
                    nearest.push(tree.nearest(&(corner + cube * CUBE_M)).index as u32);
                }
            }
        }
        Some(Self {
            corner,
            size,
            nearest,
        })
    }

    fn at(&self, place: &Point3<f32>) -> Option<usize> {
        let cube = (place - self.corner) / CUBE_M;
        let index = |axis: usize| {
            let number = cube[axis];
            (number >= 0.0 && number < self.size[axis] as f32).then_some(number as usize)
        };
        let (x, y, z) = (index(0)?, index(1)?, index(2)?);
        let place = (z * self.size[1] + y) * self.size[0] + x;
        self.nearest.get(place).map(|&index| index as usize)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn samples_lie_on_the_surface_and_stand_for_its_area() {
        let cylinder = Mesh::cylinder(0.03, 0.0, 0.1, 64).subdivided();
        let samples = samples(&cylinder, 4e-6);
        let area_m2 = std::f64::consts::TAU * 0.03 * (0.1 + 0.03);
        let stands_for_m2 = samples.len() as f64 * 4e-6;
        assert!((stands_for_m2 / area_m2 - 1.0).abs() < 0.01);
        let upper = samples.iter().filter(|s| s.point.z > 0.05).count();
        assert!((upper as f64 / samples.len() as f64 - 0.5).abs() < 0.01);
        for sample in &samples {
            let radius_m = sample.point.x.hypot(sample.point.y);
            let off_m = [sample.point.z, sample.point.z - 0.1, radius_m - 0.03];
            assert!(off_m.iter().any(|m| m.abs() < 1e-4), "{sample:?}");
            assert!(
                sample
                    .normal
                    .dot(&(sample.point.coords - Vector3::z() * 0.05))
                    > 0.0
            );
        }
    }

    #[test]
    fn the_quick_look_up_is_about_the_nearest() {
        let cylinder = Mesh::cylinder(0.03, 0.0, 0.1, 64).subdivided();
        let layer = Layer::new(samples(&cylinder, 2e-6)).unwrap();
        for k in 0..500 {
            let turn = k as f32 * 0.7;
            let radius_m = 0.02 + 0.02 * (k as f32 / 500.0);
            let place = Point3::new(radius_m * turn.cos(), radius_m * turn.sin(), 0.05);
            let near = layer.near(&place).unwrap();
            let nearest = &layer.samples[layer.nearest(&place)];
            let above_m = |sample: &Sample| sample.normal.dot(&(place - sample.point));
            assert!((above_m(near) - above_m(nearest)).abs() < 4e-4, "{place}");
        }
        assert!(layer.near(&Point3::new(0.2, 0.0, 0.0)).is_none());
    }
}
