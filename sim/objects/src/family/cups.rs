//! Measures and outlines of the cups, in millimetres, as in [`super::outlines`]. No standard of cups is known to us: the ranges
//! are our own choice, round the objects of the paper's laboratory.

use super::measure::{Outline, Range};

pub(super) const SMALL_CUP_WIDTH: Range = [87.0, 90.5];
pub(super) const SMALL_CUP_HEIGHT: Range = [98.0, 108.0];
pub(super) const MEDIUM_CUP_WIDTH: Range = [81.5, 85.3];
pub(super) const MEDIUM_CUP_HEIGHT: Range = [121.5, 132.0];
pub(super) const LARGE_CUP_WIDTH: Range = [86.5, 91.0];
pub(super) const LARGE_CUP_HEIGHT: Range = [164.0, 178.0];

/// Paper cup: skirt round a raised bottom, straight taper, rolled rim.
pub(super) fn paper_cup(draw: &mut impl FnMut(Range) -> f32) -> Outline {
    let [width, height] = [SMALL_CUP_WIDTH, SMALL_CUP_HEIGHT].map(&mut *draw);
    let [foot, raised] = [[27.3, 30.5], [6.0, 10.0]].map(&mut *draw);
    let [roll, roll_height, wall] = [[2.2, 3.2], [3.2, 4.6], [0.6, 1.1]].map(draw);
    let (rim, top) = (0.5 * width, height);
    let taper = (rim - roll - foot) / (top - roll_height - 0.2);
    let mut outline = vec![
        [0.0, raised],
        [foot - 1.1, raised],
        [foot - 1.4, 0.2],
        [foot - 0.9, 0.0],
        [foot, 0.2],
    ];
    let rolled = [
        [1.0, 1.0],
        [0.7, 0.93],
        [0.22, 0.86],
        [0.0, 0.53],
        [0.085, 0.21],
        [0.42, 0.02],
        [0.8, 0.0],
        [1.14, 0.16],
        [1.24, 0.49],
    ];
    outline.extend(rolled.map(|[inward, down]| [rim - inward * roll, top - down * roll_height]));
    outline.extend([
        [foot + taper * (raised + 1.8) - wall, raised + 2.0],
        [foot - 0.9, raised + 1.0],
        [0.0, raised + 1.0],
    ]);
    outline
}

/// Plastic cup: rounded foot with a slightly raised bottom, taper, lip turned in.
pub(super) fn plastic_cup(draw: &mut impl FnMut(Range) -> f32) -> Outline {
    const HEEL_HEIGHT: f32 = 12.0;
    let [width, height] = [MEDIUM_CUP_WIDTH, MEDIUM_CUP_HEIGHT].map(&mut *draw);
    let [foot, heel] = [[23.0, 25.0], [29.2, 31.6]].map(&mut *draw);
    let [lip, lip_height, wall] = [[0.5, 2.4], [4.5, 8.0], [0.7, 1.4]].map(draw);
    let (rim, top) = (0.5 * width, height);
    let taper = (rim - heel) / (top - lip_height - HEEL_HEIGHT);
    let mut outline = vec![
        [0.0, 3.0],
        [foot - 4.0, 2.6],
        [foot - 1.5, 0.4],
        [foot, 0.0],
    ];
    let bend = [
        [0.0, 0.04],
        [0.41, 0.3],
        [0.68, 0.5],
        [0.86, 0.71],
        [1.0, 1.0],
    ];
    let from = foot + 2.0;
    outline.extend(bend.map(|[out, up]| [from + out * (heel - from), up * HEEL_HEIGHT]));
    outline.extend([
        [rim, top - lip_height],
        [rim - 0.17 * lip, top - 0.65 * lip_height],
        [rim - 0.5 * lip, top - 0.33 * lip_height],
        [rim - 0.72 * lip, top - 0.07 * lip_height],
        [rim - lip, top],
        [rim - lip - 0.5, top - 0.06 * lip_height],
        [rim - lip - 0.3, top - 0.39 * lip_height],
        [rim - wall - 0.3, top - 1.11 * lip_height],
        [heel + 6.0 * taper - wall, 18.0],
        [heel - 0.6 - wall, 9.0],
        [heel - 2.7 - wall, 5.0],
        [foot - 1.2, 4.2],
        [0.0, 4.2],
    ]);
    outline
}

/// Drinks cup: short foot, shallow step, long straight taper, lip turned in.
pub(super) fn drinks_cup(draw: &mut impl FnMut(Range) -> f32) -> Outline {
    let [width, height] = [LARGE_CUP_WIDTH, LARGE_CUP_HEIGHT].map(&mut *draw);
    let [foot, step] = [[30.8, 33.5], [3.2, 5.0]].map(&mut *draw);
    let [lip, lip_height, wall] = [[0.4, 2.0], [6.5, 12.0], [0.7, 1.3]].map(draw);
    let (rim, top) = (0.5 * width, height);
    vec![
        [0.0, 4.0],
        [foot - 2.3, 4.0],
        [foot - 0.8, 0.3],
        [foot, 0.0],
        [foot + 1.0, 0.3],
        [foot + 1.3, 3.0],
        [foot + 0.5 * step, 5.5],
        [foot + 0.72 * step, 8.8],
        [foot + 0.88 * step, 13.0],
        [foot + step, 24.0],
        [rim, top - lip_height],
        [rim - 0.1 * lip, top - 0.79 * lip_height],
        [rim - 0.35 * lip, top - 0.52 * lip_height],
        [rim - 0.55 * lip, top - 0.23 * lip_height],
        [rim - 0.7 * lip, top - 0.04 * lip_height],
        [rim - lip, top],
        [rim - lip - 0.5, top - 0.5],
        [rim - lip - 0.3, top - 0.54 * lip_height],
        [rim - wall - 0.1, top - 1.07 * lip_height],
        [foot + step - wall, 24.0],
        [foot + 0.88 * step - wall, 14.0],
        [foot + 0.28 * step, 7.0],
        [foot - 0.8, 5.4],
        [0.0, 5.2],
    ]
}
