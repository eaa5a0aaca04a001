//! Intervals that hold for other cells as well: cells are drawn again, and repetitions within them.
//!
//! ```text
//! estimate = sum over cells of v0 / sum over cells of v1        (v0, v1) of a cell's repetitions
//! resample: as many cells with replacement, each with its repetitions drawn again
//! ```
//! A cell is a workstation, a body and a person of its own, so that people are drawn with the cells.
//! Whatever a figure compares comes from the same drawn repetitions: pairs stay pairs. The interval is
//! the expanded percentile one (Hesterberg 2015, section 3.3): for n cells the percentiles are those of
//! `t_(n-1) sqrt(n / (n-1))` in the place of 1.96, because plain percentiles are too narrow for few.

use crate::ergonomics::t_critical_975;
use crate::math::stats::{normal_cdf, quantile_of_sorted};
use crate::math::stream::{Purpose, stream};
use rand::RngExt as _;
use serde::Serialize;

/// Resamples of cells, and of repetitions within a cell, from which those of the cell are picked.
const RESAMPLES: u32 = 4000;
const WITHIN: usize = 200;

/// Share of the denominator below which a resample's ratio says nothing.
const LEAST_BOTTOM: f64 = 0.05;

/// A figure with its 95 % interval by cells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gain {
    /// The figure.
    pub mean: f64,
    /// Lower end; none for a single cell, or for a share whose denominator may be nothing.
    pub low95: Option<f64>,
    /// Upper end, likewise.
    pub high95: Option<f64>,
    /// Cells behind it.
    pub cells: usize,
}

/// Numerator and denominator of the repetitions of some numbers.
type Figures<'a> = Box<dyn Fn(&[usize]) -> [f64; 2] + 'a>;

/// One cell: how many repetitions, and numerator and denominator of some of them, by number.
pub(super) struct Part<'a> {
    pub repetitions: usize,
    pub of: Figures<'a>,
}

/// Ratio of the sums over cells with its interval; `None` without cells or with a sum below 0 at the
/// bottom.
pub(super) fn by_cells(parts: &[Part]) -> Option<Gain> {
    let plain: Vec<[f64; 2]> =
        parts.iter().map(|p| (p.of)(&(0..p.repetitions).collect::<Vec<_>>())).collect();
    let count = parts.len();
    let mean = ratio(plain.iter()).filter(|m| m.is_finite())?;
    if count < 2 {
        return Some(Gain { mean, low95: None, high95: None, cells: count });
    }
    let again: Vec<Vec<[f64; 2]>> = parts.iter().enumerate().map(|(i, p)| within(i, p)).collect();
    let least = LEAST_BOTTOM * plain.iter().map(|v| v[1]).sum::<f64>();
    let mut means: Vec<f64> = (0..RESAMPLES)
        .filter_map(|k| {
            let mut rng = stream(0, Purpose::Bootstrap, 1 << 16, k);
            let drawn: Vec<&[f64; 2]> = (0..count)
                .map(|_| &again[rng.random_range(0..count)][rng.random_range(0..WITHIN)])
                .collect();
            let bottom: f64 = drawn.iter().map(|v| v[1]).sum();
            ratio(drawn.into_iter()).filter(|_| bottom > least)
        })
        .collect();
    means.sort_by(f64::total_cmp);
    let n = count as f64;
    let tail = normal_cdf(-t_critical_975(count - 1) * (n / (n - 1.0)).sqrt());
    // A ratio whose denominator may as well be nothing has no bounds (Fieller 1954).
    let undefined = 1.0 - means.len() as f64 / f64::from(RESAMPLES);
    let end = |p: f64| (undefined <= tail).then(|| quantile_of_sorted(&means, p));
    Some(Gain { mean, low95: end(tail), high95: end(1.0 - tail), cells: count })
}

/// `None` where the denominator is not above 0.
fn ratio<'a>(values: impl Iterator<Item = &'a [f64; 2]>) -> Option<f64> {
    let [a, b] = values.fold([0.0; 2], |sum, v| [sum[0] + v[0], sum[1] + v[1]]);
    (b > 0.0).then_some(a / b)
}

/// A cell's figures for repetitions drawn again, [`WITHIN`] times; by a cell's place in the list, so that
/// all figures of a row draw alike.
fn within(index: usize, part: &Part) -> Vec<[f64; 2]> {
    let mut rng = stream(0, Purpose::Bootstrap, 1 << 17, index as u32);
    let mut drawn = vec![0; part.repetitions];
    let one = |_| {
        drawn.fill_with(|| rng.random_range(0..part.repetitions));
        (part.of)(&drawn)
    };
    (0..WITHIN).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stats::std_dev;
    use crate::math::stream::normals;

    /// Cells with the given repetitions.
    fn parts(cells: &[Vec<f64>]) -> Vec<Part<'_>> {
        cells
            .iter()
            .map(|c| Part {
                repetitions: c.len(),
                of: Box::new(|r| [r.iter().map(|&i| c[i]).sum::<f64>() / r.len() as f64, 1.0]),
            })
            .collect()
    }

    fn half(g: &Gain) -> f64 {
        0.5 * (g.high95.unwrap() - g.low95.unwrap())
    }

    #[test]
    fn cells_that_differ_give_students_interval() {
        // Repetitions of a cell all alike: the closed form is Student's over cell means.
        for count in [12usize, 40] {
            let z = normals(&mut stream(1, Purpose::Simulation, 0, count as u32), count);
            let cells: Vec<Vec<f64>> = z.iter().map(|m| vec![*m; 50]).collect();
            let g = by_cells(&parts(&cells)).unwrap();
            let student = t_critical_975(count - 1) * std_dev(&z) / (count as f64).sqrt();
            assert!((half(&g) / student - 1.0).abs() < 0.12, "{count}: {} {student}", half(&g));
            assert!((g.mean - z.iter().sum::<f64>() / count as f64).abs() < 1e-12);
        }
    }

    #[test]
    fn equal_cells_leave_the_repetitions_variance() {
        let (count, repetitions) = (30usize, 100);
        let z = normals(&mut stream(2, Purpose::Simulation, 0, 0), repetitions);
        let g = by_cells(&parts(&vec![z.clone(); count])).unwrap();
        let n = count as f64;
        let factor = t_critical_975(count - 1) * (n / (n - 1.0)).sqrt();
        let expected = factor * std_dev(&z) / (n * repetitions as f64).sqrt();
        assert!((half(&g) / expected - 1.0).abs() < 0.12, "{} {expected}", half(&g));
    }

    #[test]
    fn the_interval_covers_as_often_as_it_says() {
        for count in [6usize, 15] {
            let trials = 300;
            let covers = (0..trials).filter(|&trial| {
                let z = normals(&mut stream(3, Purpose::Simulation, trial, count as u32), count);
                let cells: Vec<Vec<f64>> = z.iter().map(|m| vec![*m; 2]).collect();
                let g = by_cells(&parts(&cells)).unwrap();
                g.low95.unwrap() < 0.0 && g.high95.unwrap() > 0.0
            });
            let share = covers.count() as f64 / f64::from(trials);
            assert!((0.91..0.985).contains(&share), "{count} cells: {share}");
        }
    }

    #[test]
    fn one_cell_has_no_interval_and_a_ratio_needs_something_to_divide_by() {
        let g = by_cells(&parts(&[vec![1.0, 3.0]])).unwrap();
        assert_eq!((g.mean, g.low95, g.high95), (2.0, None, None));
        assert!(by_cells(&[]).is_none());
        let none = Part { repetitions: 2, of: Box::new(|_| [1.0, 0.0]) };
        assert!(by_cells(&[none]).is_none());
    }

    #[test]
    fn a_ratio_is_that_of_the_sums() {
        // Gains 1 of 2 and 3 of 4: 4 / 6, not the mean of 0.5 and 0.75.
        let of = |a: f64, b: f64| Part { repetitions: 3, of: Box::new(move |_| [a, b]) };
        let g = by_cells(&[of(1.0, 2.0), of(3.0, 4.0)]).unwrap();
        assert!((g.mean - 4.0 / 6.0).abs() < 1e-12);
        // A denominator that vanishes when one of the cells is drawn twice leaves no interval.
        let g = by_cells(&[of(1.0, 0.0), of(3.0, 4.0)]).unwrap();
        assert_eq!((g.mean, g.low95, g.high95), (1.0, None, None));
        let g = by_cells(&[of(1.0, 2.0), of(3.0, 4.0)]).unwrap();
        // Two cells: the ends are those of drawing one of them twice.
        assert_eq!((g.low95, g.high95), (Some(0.5), Some(0.75)));
    }
}
