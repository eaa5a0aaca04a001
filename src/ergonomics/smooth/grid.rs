//! Multilinear interpolation of a table of scores, with its partial derivatives.

/// Value and slopes at `scores` of a table whose dimension d has entries 1 to `sizes[d]`.
///
/// `CORNERS` is 2^N. A score outside the table counts as the nearest inside, and has slope 0.
pub(super) fn interpolate<const N: usize, const CORNERS: usize>(
    sizes: [u8; N],
    scores: [f64; N],
    look_up: impl Fn([u8; N]) -> u8,
) -> (f64, [f64; N]) {
    let (mut first, mut part, mut live) = ([1u8; N], [0.0; N], [0.0; N]);
    for d in 0..N {
        let last = f64::from(sizes[d]);
        let inside = scores[d].clamp(1.0, last);
        first[d] = inside.min(last - 1.0) as u8;
        part[d] = inside - f64::from(first[d]);
        live[d] = if scores[d] < 1.0 || scores[d] > last { 0.0 } else { 1.0 };
    }
    let mut values = [0.0; CORNERS];
    for (corner, value) in values.iter_mut().enumerate() {
        let mut cell = first;
        for (d, index) in cell.iter_mut().enumerate() {
            *index += ((corner >> d) & 1) as u8;
        }
        *value = f64::from(look_up(cell));
    }
    let slopes = std::array::from_fn(|d| {
        // Along dimension d the weights are -1 and 1 instead of 1 - part and part.
        live[d] * blend::<N, CORNERS>(&values, &part, Some(d))
    });
    (blend::<N, CORNERS>(&values, &part, None), slopes)
}

/// Folds the corners dimension by dimension; along `difference` their difference is taken.
fn blend<const N: usize, const CORNERS: usize>(
    values: &[f64; CORNERS],
    part: &[f64; N],
    difference: Option<usize>,
) -> f64 {
    let mut left = *values;
    let mut count = CORNERS;
    for (d, t) in part.iter().enumerate() {
        count /= 2;
        for i in 0..count {
            let (low, high) = (left[2 * i], left[2 * i + 1]);
            let rise = high - low;
            left[i] = if difference == Some(d) { rise } else { low + t * rise };
        }
    }
    left[0]
}
