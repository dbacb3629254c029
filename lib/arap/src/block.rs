//! Forward and back substitution for one block of columns, with three right-hand sides at once.

/// x, y and z of an unknown. The fourth number pads to one 256-bit SIMD register.
pub(super) type Lane = [f64; 4];

/// Forward substitution (L·x = b): solves for the block's own unknowns and subtracts their share from the rows below.
/// `below` starts at row `base`.
#[inline(always)]
pub(super) fn lower<const W: usize>(
    values: &[f64],
    rows: &[u32],
    own: &mut [Lane],
    below: &mut [Lane],
    base: usize,
) {
    let (values, _) = values.as_chunks::<W>();
    let mut solved = [[0.0; 4]; W];
    for row in 0..W {
        let mut sum = own[row];
        for column in 0..row {
            subtract(&mut sum, values[row][column], &solved[column]);
        }
        solved[row] = sum.map(|component| component * values[row][row]);
        own[row] = solved[row];
    }
    for (&row, factors) in rows.iter().zip(&values[W..]) {
        let place = &mut below[row as usize - base];
        let mut sum = *place;
        for column in 0..W {
            subtract(&mut sum, factors[column], &solved[column]);
        }
        *place = sum;
    }
}

/// Back substitution (Lᵀ·x = b): subtracts the share of the known rows below from the block's own unknowns, then solves
/// for these. `below` starts at row `base`.
#[inline(always)]
pub(super) fn upper<const W: usize>(
    values: &[f64],
    rows: &[u32],
    own: &mut [Lane],
    below: &[Lane],
    base: usize,
) {
    let (values, _) = values.as_chunks::<W>();
    let mut sums = [[0.0; 4]; W];
    sums.copy_from_slice(own);
    for (&row, factors) in rows.iter().zip(&values[W..]) {
        let known = below[row as usize - base];
        for column in 0..W {
            subtract(&mut sums[column], factors[column], &known);
        }
    }
    for row in (0..W).rev() {
        let solved = sums[row].map(|component| component * values[row][row]);
        for column in 0..row {
            subtract(&mut sums[column], values[row][column], &solved);
        }
        own[row] = solved;
    }
}

#[inline(always)]
fn subtract(sum: &mut Lane, factor: f64, lane: &Lane) {
    for component in 0..4 {
        sum[component] -= factor * lane[component];
    }
}
