//! Outlines that turn about z to the surface of an object.

/// Points round the axis. A multiple of four, so that the widest ring reaches the exact extent on x and y.
pub(crate) const SEGMENTS: usize = 64;
/// Longest step along an outline.
const STEP_M: f32 = 0.006;
const BALL_RINGS: usize = 48;

/// Converts a closed outline (radius, height) from mm to m and subdivides its segments.
pub(crate) fn subdivided(outline_mm: &[[f32; 2]]) -> Vec<[f32; 2]> {
    subdivided_in(outline_mm, &steps(outline_mm))
}

/// In how many parts each segment of an outline (mm) is to be cut.
pub(crate) fn steps(outline_mm: &[[f32; 2]]) -> Vec<usize> {
    let outline_m: Vec<[f32; 2]> = outline_mm.iter().copied().map(metres).collect();
    outline_m
        .windows(2)
        .map(|pair| {
            let [a, b] = [pair[0], pair[1]];
            ((b[0] - a[0]).hypot(b[1] - a[1]) / STEP_M).ceil().max(1.0) as usize
        })
        .collect()
}

/// Converts a closed outline from mm to m and cuts each segment in so many parts.
pub(crate) fn subdivided_in(outline_mm: &[[f32; 2]], steps: &[usize]) -> Vec<[f32; 2]> {
    let mut outline_m = vec![metres(outline_mm[0])];
    for (pair, &steps) in outline_mm.windows(2).zip(steps) {
        let [a, b] = [metres(pair[0]), metres(pair[1])];
        outline_m.extend((1..=steps).map(|k| {
            let share = k as f32 / steps as f32;
            [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
        }));
    }
    outline_m
}

fn metres(place_mm: [f32; 2]) -> [f32; 2] {
    place_mm.map(|length_mm| length_mm / 1000.0)
}

/// The outline of a ball from its radii by angle (degrees) from the top; straight between them, on the axis at both ends.
pub(crate) fn ball(radii_mm: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let radius_m = |degrees: f32| {
        let after = radii_mm.partition_point(|entry| entry[0] <= degrees);
        let [from, to] = [after - 1, after.min(radii_mm.len() - 1)].map(|index| radii_mm[index]);
        let share = (degrees - from[0]) / (to[0] - from[0]).max(1.0);
        (from[1] + share * (to[1] - from[1])) / 1000.0
    };
    let below_m = radius_m(180.0);
    let inner = (1..BALL_RINGS).map(|k| {
        let degrees = 180.0 - 180.0 * k as f32 / BALL_RINGS as f32;
        let (sin, cos) = degrees.to_radians().sin_cos();
        [radius_m(degrees) * sin, below_m + radius_m(degrees) * cos]
    });
    std::iter::once([0.0, 0.0])
        .chain(inner)
        .chain([[0.0, below_m + radius_m(0.0)]])
        .collect()
}
