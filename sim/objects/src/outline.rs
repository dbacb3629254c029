//! The outlines of the objects, in millimetres, as measured on scans of the real ones.
//!
//! Parts that a scanner cannot see (the inside of a cup, the bottom of a can) follow the usual make of such objects.
//! Outlines of cans and cups: radius and height, from the axis at the bottom, outward and up, to the axis again. Outlines of
//! balls: angle from the top in degrees, and radius.

/// Foam basketball; the scan shows the scanner's stand as a foot.
pub(crate) const TINY_BALL_MM: &[[f32; 2]] = &[
    [0.0, 32.1],
    [15.0, 31.3],
    [25.0, 31.0],
    [45.0, 30.76],
    [65.0, 30.65],
    [85.0, 30.6],
    [95.0, 30.6],
    [115.0, 30.67],
    [135.0, 30.88],
    [149.0, 30.95],
    [157.5, 34.1],
    [161.0, 33.4],
    [165.0, 32.75],
    [170.0, 32.1],
    [175.0, 31.76],
    [180.0, 31.7],
];

/// Tennis ball; the scan shows the stand as a foot, too.
pub(crate) const SMALL_BALL_MM: &[[f32; 2]] = &[
    [0.0, 32.6],
    [15.0, 32.5],
    [35.0, 32.15],
    [55.0, 31.96],
    [85.0, 32.0],
    [95.0, 32.0],
    [115.0, 32.02],
    [149.0, 32.1],
    [157.5, 34.6],
    [161.0, 33.85],
    [165.0, 33.2],
    [170.0, 32.5],
    [175.0, 32.18],
    [180.0, 32.1],
];

/// Foam ball with a flat that it stands on.
pub(crate) const MEDIUM_BALL_MM: &[[f32; 2]] = &[
    [0.0, 48.4],
    [15.0, 48.2],
    [25.0, 48.9],
    [35.0, 48.9],
    [65.0, 48.4],
    [75.0, 48.45],
    [90.0, 48.7],
    [125.0, 48.75],
    [135.0, 48.4],
    [145.0, 46.1],
    [155.0, 43.3],
    [165.0, 41.9],
    [180.0, 41.6],
];

/// Drawn aluminium can: domed bottom inside a foot ring, long neck, seam, recessed lid.
pub(crate) const MEDIUM_CAN_MM: &[[f32; 2]] = &[
    [0.0, 10.0],
    [8.0, 9.3],
    [15.0, 7.2],
    [21.0, 3.8],
    [24.0, 1.0],
    [26.0, 0.0],
    [28.0, 0.2],
    [31.0, 1.0],
    [31.9, 4.0],
    [32.45, 6.0],
    [32.75, 8.5],
    [32.75, 102.0],
    [32.4, 104.5],
    [31.4, 107.0],
    [30.1, 110.0],
    [28.6, 113.0],
    [27.1, 116.0],
    [26.4, 118.0],
    [26.4, 122.0],
    [26.0, 124.0],
    [25.6, 126.4],
    [25.1, 127.4],
    [24.3, 127.2],
    [23.8, 126.0],
    [23.2, 121.5],
    [21.8, 121.0],
    [20.8, 122.3],
    [0.0, 122.6],
];

/// Welded tin: seams at both ends, beads round the body, recessed ends.
pub(crate) fn food_can_mm() -> Vec<[f32; 2]> {
    const BODY_MM: f32 = 36.6;
    const BEAD_DEPTH_MM: f32 = 0.7;
    const BEADS: usize = 12;
    const BEADS_FROM_MM: f32 = 28.0;
    const BEADS_TO_MM: f32 = 92.0;
    let mut outline = vec![
        [0.0, 3.2],
        [34.4, 3.0],
        [35.0, 0.6],
        [35.7, 0.0],
        [36.9, 0.4],
    ];
    outline.extend([[37.1, 2.8], [36.0, 4.2], [36.4, 7.0], [BODY_MM, 9.0]]);
    let pitch_mm = (BEADS_TO_MM - BEADS_FROM_MM) / (2 * BEADS) as f32;
    outline.extend((0..=2 * BEADS).map(|k| {
        let depth_mm = if k % 2 == 1 { BEAD_DEPTH_MM } else { 0.0 };
        [BODY_MM - depth_mm, BEADS_FROM_MM + pitch_mm * k as f32]
    }));
    outline.extend([
        [BODY_MM, 110.0],
        [36.5, 113.8],
        [37.6, 114.6],
        [37.95, 115.6],
    ]);
    outline.extend([
        [37.8, 117.9],
        [37.0, 118.5],
        [36.0, 118.3],
        [35.3, 117.5],
        [34.8, 114.4],
    ]);
    outline.extend([[33.0, 114.2], [31.5, 115.0], [0.0, 115.0]]);
    outline
}

/// Paper cup: skirt round a raised bottom, straight taper, rolled rim.
pub(crate) const SMALL_CUP_MM: &[[f32; 2]] = &[
    [0.0, 8.0],
    [27.4, 8.0],
    [27.1, 0.2],
    [27.6, 0.0],
    [28.5, 0.2],
    [41.3, 98.6],
    [42.2, 98.9],
    [43.6, 99.2],
    [44.25, 100.6],
    [44.0, 102.0],
    [43.0, 102.8],
    [41.9, 102.9],
    [40.9, 102.2],
    [40.6, 100.8],
    [28.8, 10.0],
    [27.6, 9.0],
    [0.0, 9.0],
];

/// Plastic cup: rounded foot with a slightly raised bottom, taper, lip turned in.
pub(crate) const MEDIUM_CUP_MM: &[[f32; 2]] = &[
    [0.0, 3.0],
    [20.0, 2.6],
    [22.5, 0.4],
    [24.0, 0.0],
    [26.0, 0.5],
    [27.8, 3.6],
    [29.0, 6.0],
    [29.8, 8.5],
    [30.4, 12.0],
    [30.9, 17.5],
    [32.5, 32.0],
    [34.2, 48.0],
    [35.9, 64.0],
    [37.6, 80.0],
    [39.2, 96.0],
    [41.2, 115.5],
    [41.7, 119.8],
    [41.4, 122.2],
    [40.8, 124.4],
    [40.4, 126.2],
    [39.9, 126.7],
    [39.4, 126.3],
    [39.6, 124.0],
    [40.2, 119.0],
    [38.2, 96.0],
    [33.2, 48.0],
    [29.9, 18.0],
    [28.6, 9.0],
    [26.5, 5.0],
    [23.0, 4.2],
    [0.0, 4.2],
];

/// Drinks cup: short foot, shallow step, long straight taper, lip turned in.
pub(crate) const LARGE_CUP_MM: &[[f32; 2]] = &[
    [0.0, 4.0],
    [30.0, 4.0],
    [31.5, 0.3],
    [32.3, 0.0],
    [33.3, 0.3],
    [33.6, 3.0],
    [34.5, 5.5],
    [35.4, 8.8],
    [36.1, 13.0],
    [36.6, 24.0],
    [44.0, 153.0],
    [44.35, 159.8],
    [44.2, 162.2],
    [43.8, 165.2],
    [43.5, 168.5],
    [43.3, 170.6],
    [42.8, 171.1],
    [42.3, 170.6],
    [42.6, 165.0],
    [43.1, 159.0],
    [42.9, 153.0],
    [35.5, 24.0],
    [35.0, 14.0],
    [33.5, 7.0],
    [31.5, 5.4],
    [0.0, 5.2],
];
