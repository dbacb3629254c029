//! The measures of the families, in millimetres, and their outlines: radius and height, from the axis at the bottom, outward and
//! up, to the axis again.
//!
//! What standards say is cited. Where we know of none (cups, foam balls), the ranges are our own choice, round the object
//! that the paper's laboratory has. Each range contains that object's measures, without the foot that a scanner's stand left on some
//! scans, and 1 % more; no two families meet.

use std::f32::consts::PI;

use super::cups::{
    LARGE_CUP_HEIGHT, LARGE_CUP_WIDTH, MEDIUM_CUP_HEIGHT, MEDIUM_CUP_WIDTH, SMALL_CUP_HEIGHT,
    SMALL_CUP_WIDTH, drinks_cup, paper_cup, plastic_cup,
};
use super::measure::{Outline, Range};
use crate::class::ObjectClass;

/// Outside diameter of a beverage can's body: 66.09 ± 0.18 mm (2.602 ± 0.007 in; Can Manufacturers Institute, Voluntary Can and
/// End Dimension Reference Manual, 202 beverage can); the paper's can: 65.5 mm.
const CAN_WIDTH: Range = [64.8, 66.9];
/// 115 mm with 330 ml; 122.2 ± 0.4 mm before seaming with 355 ml (4.812 ± 0.015 in, same manual); the paper's can: 127.4 mm.
const CAN_HEIGHT: Range = [114.0, 128.7];

/// Over the seams: 76.2 mm (No. 300 is 300 x 407 in the same manual: 3 in wide and 4 7/16 in high, nominal outside dimensions);
/// the paper's tin: 75.9 mm.
const TIN_WIDTH: Range = [74.8, 77.0];
/// No. 300: 112.7 mm; the paper's tin: 118.5 mm.
const TIN_HEIGHT: Range = [111.0, 120.0];

const TINY_BALL_WIDTH: Range = [60.5, 61.9];
/// By which share it is higher than wide.
const TINY_BALL_LONGER: Range = [0.0, 0.045];
/// Tennis ball, type 1 or 2: 65.4 to 68.6 mm (Rules of Tennis of the ITF, Appendix I); the paper's, a worn one: 64.0 mm.
const SMALL_BALL_WIDTH: Range = [63.4, 68.6];
const SMALL_BALL_LONGER: Range = [0.0, 0.02];
const MEDIUM_BALL_WIDTH: Range = [95.5, 99.5];
/// Height of the spherical cap that is missing at the flat bottom of the ball, mm.
const MEDIUM_BALL_FLAT: Range = [1.0, 9.0];

/// Ranges of width and height, mm.
pub(super) fn size_range_mm(class: ObjectClass) -> [Range; 2] {
    let longer = |[least, most]: Range, [less, more]: Range| {
        [[least, most], [least * (1.0 + less), most * (1.0 + more)]]
    };
    match class {
        ObjectClass::MediumCan => [CAN_WIDTH, CAN_HEIGHT],
        ObjectClass::FoodCan => [TIN_WIDTH, TIN_HEIGHT],
        ObjectClass::SmallCup => [SMALL_CUP_WIDTH, SMALL_CUP_HEIGHT],
        ObjectClass::MediumCup => [MEDIUM_CUP_WIDTH, MEDIUM_CUP_HEIGHT],
        ObjectClass::LargeCup => [LARGE_CUP_WIDTH, LARGE_CUP_HEIGHT],
        ObjectClass::TinyBall => longer(TINY_BALL_WIDTH, TINY_BALL_LONGER),
        ObjectClass::SmallBall => longer(SMALL_BALL_WIDTH, SMALL_BALL_LONGER),
        ObjectClass::MediumBall => {
            let ([least, most], [less, more]) = (MEDIUM_BALL_WIDTH, MEDIUM_BALL_FLAT);
            [[least, most], [least - more, most - less]]
        }
    }
}

/// An outline with the measures that `draw` takes from their ranges; the first two are those that instances are held out by. All
/// outlines of a class have as many points, which correspond to each other.
pub(super) fn outline_mm(class: ObjectClass, draw: &mut impl FnMut(Range) -> f32) -> Outline {
    match class {
        ObjectClass::MediumCan => can(draw),
        ObjectClass::FoodCan => tin(draw),
        ObjectClass::SmallCup => paper_cup(draw),
        ObjectClass::MediumCup => plastic_cup(draw),
        ObjectClass::LargeCup => drinks_cup(draw),
        ObjectClass::TinyBall => {
            let [width, longer] = [TINY_BALL_WIDTH, TINY_BALL_LONGER].map(draw);
            ball(width, longer, 0.0)
        }
        ObjectClass::SmallBall => {
            let [width, longer] = [SMALL_BALL_WIDTH, SMALL_BALL_LONGER].map(draw);
            ball(width, longer, 0.0)
        }
        ObjectClass::MediumBall => {
            let [width, flat] = [MEDIUM_BALL_WIDTH, MEDIUM_BALL_FLAT].map(draw);
            ball(width, 0.0, flat)
        }
    }
}

/// Drawn aluminium can: domed bottom inside a foot ring, heel, neck, seam, recessed lid.
fn can(draw: &mut impl FnMut(Range) -> f32) -> Outline {
    let [width, height] = [CAN_WIDTH, CAN_HEIGHT].map(&mut *draw);
    // The neck is as wide as the lid's plug, 52.4 mm (2.063 in) with a 202 lid in the same manual; the seam is wider.
    let [neck, seam] = [[26.0, 26.8], [0.0, 0.9]].map(&mut *draw);
    let [neck_height, collar] = [[10.0, 17.5], [3.0, 9.5]].map(&mut *draw);
    let [foot, heel] = [[22.5, 26.2], [8.0, 14.0]].map(&mut *draw);
    let [dome, recess] = [[8.5, 11.5], [4.5, 7.0]].map(draw);
    let (wall, top) = (0.5 * width, height);
    let mut outline = vec![[0.0, dome]];
    let bowl = [[0.31, 0.93], [0.58, 0.72], [0.81, 0.38], [0.92, 0.1]];
    outline.extend(bowl.map(|[out, up]| [out * foot, up * dome]));
    outline.push([foot, 0.0]);
    let bend = [
        [0.30, 0.02],
        [0.74, 0.12],
        [0.87, 0.47],
        [0.96, 0.7],
        [1.0, 1.0],
    ];
    outline.extend(bend.map(|[out, up]| [foot + out * (wall - foot), up * heel]));
    let neck_from = top - collar - neck_height;
    let shoulder = [
        [0.0, 0.0],
        [0.055, 0.16],
        [0.21, 0.31],
        [0.42, 0.5],
        [0.65, 0.69],
        [0.89, 0.875],
        [1.0, 1.0],
    ];
    outline.extend(
        shoulder.map(|[inward, up]| [wall + inward * (neck - wall), neck_from + up * neck_height]),
    );
    let lid = neck + seam;
    outline.extend([
        [neck, top - 0.57 * collar],
        [lid - 0.2, top - 0.36 * collar],
        [lid - 0.4, top - 0.1 * collar],
        [lid - 1.0, top],
        [lid - 2.0, top - 0.2],
        [lid - 2.6, top - 1.4],
        [lid - 3.2, top - recess],
        [lid - 4.6, top - recess - 0.5],
        [lid - 5.6, top - recess + 0.8],
        [0.0, top - recess + 1.1],
    ]);
    outline
}

/// Welded tin: seams at both ends, beads round the body, recessed ends.
fn tin(draw: &mut impl FnMut(Range) -> f32) -> Outline {
    const BEADS: usize = 12;
    let [width, height] = [TIN_WIDTH, TIN_HEIGHT].map(&mut *draw);
    let [inset, bead] = [[0.9, 1.7], [0.0, 1.0]].map(&mut *draw);
    let [plain_below, plain_above] = [[18.0, 32.0]; 2].map(&mut *draw);
    let [narrower, below, above] = [[0.0, 0.9], [2.6, 4.4], [2.6, 4.4]].map(draw);
    let (seam, top) = (0.5 * width, height);
    let body = seam - inset;
    let mut outline = vec![
        [0.0, below],
        [seam - 3.55, below - 0.2],
        [seam - 2.95, 0.6],
        [seam - 2.25, 0.0],
        [seam - 0.2 - narrower, 0.4],
        [seam - narrower, 2.8],
        [body - 0.6, 4.2],
        [body - 0.2, 7.0],
        [body, 9.0],
    ];
    let pitch = (top - plain_above - plain_below) / (2 * BEADS) as f32;
    outline.extend((0..=2 * BEADS).map(|k| {
        let depth = if k % 2 == 1 { bead } else { 0.0 };
        [body - depth, plain_below + pitch * k as f32]
    }));
    outline.extend([
        [body, top - 8.5],
        [body - 0.1, top - 4.7],
        [seam - 0.35, top - 3.9],
        [seam, top - 2.9],
        [seam - 0.15, top - 0.6],
        [seam - 0.95, top],
        [seam - 1.95, top - 0.2],
        [seam - 2.65, top - 1.0],
        [seam - 3.15, top - above - 0.6],
        [seam - 4.95, top - above - 0.8],
        [seam - 6.45, top - above],
        [0.0, top - above],
    ]);
    outline
}

/// Ball, higher than wide by a share, and cut off at the bottom.
fn ball(width: f32, longer: f32, flat: f32) -> Outline {
    const RINGS: usize = 48;
    let (radius, stretch) = (0.5 * width, 1.0 + longer);
    let bottom = radius - flat;
    let inner = (1..RINGS).map(|k| {
        let (sin, cos) = (PI * k as f32 / RINGS as f32).sin_cos();
        // On the flat, a ring is where its direction from the middle meets it.
        let length = if radius * cos > bottom {
            bottom / cos
        } else {
            radius
        };
        [length * sin, stretch * (bottom - length * cos).max(0.0)]
    });
    let top = [0.0, stretch * (bottom + radius)];
    std::iter::once([0.0, 0.0])
        .chain(inner)
        .chain([top])
        .collect()
}
