//! Whether each view sees what the others saw.
//!
//! A camera that measures a depth along a ray has seen that nothing is nearer (free space, as in space carving: Kutulakos
//! and Seitz 2000). A surface that one view saw, that faces another view's camera, and through which that camera looks, is
//! gone from there, or came later: the object was dropped, taken away, put in, or swapped for another.

use cloud::{normals, transformed, voxel};
use hand_eye::HandRegion;
use nalgebra::{Isometry3, Point3, Vector3};

use crate::error::RegistrationError;

/// Distance between the surface points that are looked for, m.
const SPACING_M: f32 = 0.004;
/// Side of the patches that give their normals, m: some nine points.
const PATCH_M: f32 = 0.012;
/// Cosine of the largest angle between a surface's normal and the line of sight: 66°. What is more oblique, a depth camera
/// sees badly.
const FACING_MIN: f32 = 0.4;
/// A camera looks through a surface if what it sees there is farther by this, m: four times a D435i's noise at half a metre.
const THROUGH_M: f32 = 0.004;
/// From the fingertips down, fingers and object may move; below is the gripper, m: the fingers of Baxter's electric gripper
/// reach 30 mm along the object, the rest is for a mount that is off.
const FINGERS_M: f32 = 0.038;
/// So far over the fingertips the hand's axis is inside of every object, m: the smallest ball ends 10 mm over them.
const INSIDE_M: f32 = 0.003;
/// With fewer surface points that should be seen (16 mm² each), nothing is said.
const EXPECTED_MIN: usize = 25;

/// Of the surface points that a view should see, how many it does not.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    expected: usize,
    through: usize,
}

impl Tally {
    /// The share that the camera looks through; 0 where too little should be seen.
    pub(crate) fn share(&self) -> f64 {
        if self.expected < EXPECTED_MIN {
            return 0.0;
        }
        self.through as f64 / self.expected as f64
    }

    fn add(&mut self, other: Self) {
        self.expected += other.expected;
        self.through += other.through;
    }
}

/// How a new view contradicts the views before, in one part of the hand's region.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Change {
    /// Of the surface that the views before saw and that faces the new camera, the share that it looks through, 0 to 1.
    pub gone: f64,
    /// Of the surface that the new view sees and that faced the cameras before, the share that they looked through.
    pub new: f64,
}

impl Change {
    /// The larger of the two shares.
    pub fn largest(&self) -> f64 {
        self.gone.max(self.new)
    }
}

/// What the views of a scan so far have seen.
#[derive(Debug, Clone)]
pub(crate) struct Sights {
    region: HandRegion,
    /// Height of the fingertips in the hand's frame, m.
    fingertips_m: f32,
    seen: Vec<Sight>,
}

/// A new view compared with those before.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Comparison {
    /// The object, with the fingers that hold it.
    pub object: Change,
    /// The gripper below, of which all views should see the same.
    pub gripper: Change,
    /// Whether at least one earlier view saw free space on the hand's axis, just above the fingertips, where an object would
    /// be. One view is enough: in the others a finger may hide the axis.
    pub was_empty: bool,
    /// Whether the new view sees free space there.
    pub is_empty: bool,
}

impl Sights {
    pub(crate) fn new(region: HandRegion, fingertips_m: f64) -> Self {
        Self {
            region,
            fingertips_m: fingertips_m as f32,
            seen: Vec::new(),
        }
    }

    /// What a view sees, whose points (m) are in its camera's frame.
    ///
    /// # Errors
    /// Points that are too far away to be in metres.
    pub(crate) fn sight(
        &self,
        points: &[Point3<f32>],
        hand_from_camera: &Isometry3<f64>,
    ) -> Result<Sight, RegistrationError> {
        let mut placed = transformed(hand_from_camera, points);
        placed.retain(|point| self.region.holds(point));
        let thinned = voxel::downsample(&placed, SPACING_M).map_err(RegistrationError::TooLarge)?;
        let mut normals =
            normals::of_patches(&thinned, PATCH_M).map_err(RegistrationError::TooLarge)?;
        let eye = Point3::from(hand_from_camera.translation.vector).cast();
        normals::towards(&eye, &thinned, &mut normals);
        let surface = thinned.into_iter().zip(normals);
        Ok(Sight {
            eye,
            camera_from_hand: hand_from_camera.inverse(),
            surface: surface
                .filter_map(|(point, normal)| Some((point, normal?)))
                .collect(),
            depths: DepthMap::new(points),
        })
    }

    /// A view in the pose that its sight was made with, against all before it.
    pub(crate) fn compare(&self, sight: &Sight) -> Comparison {
        let object_above_m = self.fingertips_m - FINGERS_M;
        let part = |is_object: bool| {
            let (mut gone, mut new) = (Tally::default(), Tally::default());
            for before in &self.seen {
                let is_part = |point: &Point3<f32>| (point.z > object_above_m) == is_object;
                gone.add(sight.looks_through(before, is_part));
                new.add(before.looks_through(sight, is_part));
            }
            Change {
                gone: gone.share(),
                new: new.share(),
            }
        };
        let inside = Point3::new(0.0, 0.0, self.fingertips_m + INSIDE_M);
        Comparison {
            object: part(true),
            gripper: part(false),
            was_empty: self.seen.iter().any(|before| before.is_free(&inside)),
            is_empty: sight.is_free(&inside),
        }
    }

    pub(crate) fn push(&mut self, sight: Sight) {
        self.seen.push(sight);
    }
}

/// What one view has seen of the hand's region, and through which space.
#[derive(Debug, Clone)]
pub(crate) struct Sight {
    /// Place of the camera in the hand's frame, m.
    eye: Point3<f32>,
    camera_from_hand: Isometry3<f64>,
    /// Points of the hand's frame with unit normals towards the camera.
    surface: Vec<(Point3<f32>, Vector3<f32>)>,
    depths: DepthMap,
}

impl Sight {
    /// Whether the camera looks through a place of the hand's frame.
    fn is_free(&self, place: &Point3<f32>) -> bool {
        self.depths
            .is_free(&(self.camera_from_hand.cast::<f32>() * place))
    }

    /// Of the other's surface points that face this camera, how many it looks through.
    fn looks_through(&self, other: &Self, is_part: impl Fn(&Point3<f32>) -> bool) -> Tally {
        let facing = |(point, normal): &&(Point3<f32>, Vector3<f32>)| {
            let towards_eye = self.eye - point;
            is_part(point) && normal.dot(&towards_eye) > FACING_MIN * towards_eye.norm()
        };
        let expected: Vec<Point3<f32>> = other
            .surface
            .iter()
            .filter(facing)
            .map(|(point, _)| *point)
            .collect();
        let in_camera = transformed(&self.camera_from_hand, &expected);
        let through = in_camera.iter().filter(|point| self.depths.is_free(point));
        Tally {
            expected: expected.len(),
            through: through.count(),
        }
    }
}

/// The nearest depth in each cell of a coarse image of a view.
#[derive(Debug, Clone)]
struct DepthMap {
    /// m; infinite where nothing was measured. Row after row.
    nearest_m: Vec<f32>,
}

/// Side of a cell, as a tangent: 3 mm at 0.4 m, three pixels of a D435i, one of a Kinect whose image is thinned by two.
const CELL: f32 = 0.008;
/// Cells from the middle of the image to its border: 50°, more than a D435i's 45°.
const HALF_CELLS: i32 = 150;
const CELLS: usize = 2 * HALF_CELLS as usize;

impl DepthMap {
    /// Of points (m) in the camera's optical frame (z forward).
    fn new(points: &[Point3<f32>]) -> Self {
        let mut map = Self {
            nearest_m: vec![f32::INFINITY; CELLS * CELLS],
        };
        for point in points {
            let nearest = cell(point).and_then(|[column, row]| map.nearest_mut(column, row));
            if let Some(nearest) = nearest {
                *nearest = nearest.min(point.z);
            }
        }
        map
    }

    /// Whether the camera saw farther than a point, or nothing, in its cell and all cells around it. False outside of the
    /// image.
    fn is_free(&self, point: &Point3<f32>) -> bool {
        let Some([column, row]) = cell(point) else {
            return false;
        };
        let around = [-1, 0, 1];
        around.iter().all(|down| {
            around.iter().all(|right| {
                let nearest_m = self.nearest(column + right, row + down);
                nearest_m.is_some_and(|nearest_m| nearest_m > point.z + THROUGH_M)
            })
        })
    }

    fn nearest(&self, column: i32, row: i32) -> Option<f32> {
        self.nearest_m.get(index(column, row)?).copied()
    }

    fn nearest_mut(&mut self, column: i32, row: i32) -> Option<&mut f32> {
        self.nearest_m.get_mut(index(column, row)?)
    }
}

/// Column and row from the middle of the image; `None` for what is not in front of the camera.
fn cell(point: &Point3<f32>) -> Option<[i32; 2]> {
    (point.z > 0.0).then(|| [point.x, point.y].map(|across| floor(across / point.z / CELL)))
}

/// Rounds down. Saturates at the range of `i32`, which is far outside of the image. `f32::floor` would be slower: on baseline x86-64,
/// for which the programs are built, it is a function call.
fn floor(coordinate: f32) -> i32 {
    let towards_zero = coordinate as i32;
    towards_zero.saturating_sub(i32::from(coordinate < towards_zero as f32))
}

fn index(column: i32, row: i32) -> Option<usize> {
    let [column, row] = [column, row].map(|number| number.saturating_add(HALF_CELLS));
    let inside = 0..2 * HALF_CELLS;
    (inside.contains(&column) && inside.contains(&row))
        .then_some(row as usize * CELLS + column as usize)
}
