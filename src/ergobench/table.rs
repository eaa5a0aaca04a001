//! The table: gains over each baseline under the truth, by family and pooled.

use super::cell::{Cell, Outcome};
use super::families::Family;
use super::people::Kind;
use crate::math::stats::{cvar_upper, mean, quantile, std_dev};
use crate::math::stream::{Purpose, stream};
use rand::RngExt as _;
use serde::Serialize;

/// A mean with its 95 % interval over repetitions, with the cells as they are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gain {
    /// Mean of `baseline - ours`, in points of expected RULA: above 0 we are better.
    pub mean: f64,
    /// Lower end.
    pub low95: f64,
    /// Upper end.
    pub high95: f64,
    /// Cells behind it.
    pub cells: usize,
}

/// One line of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The family; none for a line over families.
    pub family: Option<Family>,
    /// The kind of person; none for a line over kinds.
    pub kind: Option<Kind>,
    /// Cells with an outcome, and cells without.
    pub cells: (usize, usize),
    /// Mean expected RULA of each planner.
    pub expected: Vec<(String, f64)>,
    /// Mean `CVaR90` of RULA of each planner.
    pub cvar90: Vec<(String, f64)>,
    /// Gain of ours over each other planner.
    pub gains: Vec<(String, Gain)>,
    /// The same of `CVaR90`, pooled; the interval by resampling of repetitions.
    pub cvar90_gains: Vec<(String, Gain)>,
    /// Our gain over the straight path as a share of the oracle's, with its interval (delta method).
    pub share_of_oracle: Option<Gain>,
    /// Gain of the oracle over the straight path, as a share of the straight path's score.
    pub oracle_gain: Option<f64>,
    /// Mean of `truth - prediction` of our path: how far the model is off.
    pub calibration_gap: Option<f64>,
}

/// All lines: one for each family, all together, then one for each kind of person.
#[derive(Debug, Clone, Serialize)]
pub struct Table {
    /// The lines.
    pub rows: Vec<Row>,
}

/// Planners in the order of the table.
const PLANNERS: [&str; 8] = [
    "ergopath",
    "straight",
    "shortest",
    "expert_arc",
    "best_random",
    "single_posture_plain",
    "single_posture_learned",
    "oracle",
];

/// Sums up cells.
pub fn table(cells: &[Cell]) -> Table {
    let mut rows: Vec<Row> = Family::ALL
        .into_iter()
        .filter(|f| cells.iter().any(|c| c.family == *f))
        .map(|f| {
            let own: Vec<&Cell> = cells.iter().filter(|c| c.family == f).collect();
            Row { family: Some(f), ..row(&own) }
        })
        .collect();
    rows.push(row(&cells.iter().collect::<Vec<_>>()));
    for kind in Kind::ALL {
        let own: Vec<&Cell> = cells.iter().filter(|c| c.kind == kind).collect();
        if !own.is_empty() {
            rows.push(Row { kind: Some(kind), ..row(&own) });
        }
    }
    Table { rows }
}

impl Table {
    /// The line over all cells.
    pub fn all(&self) -> Option<&Row> {
        self.rows.iter().find(|r| r.family.is_none() && r.kind.is_none())
    }
}

fn of<'a>(cell: &'a Cell, planner: &str) -> Option<&'a Outcome> {
    cell.outcomes.iter().find(|o| o.planner == planner)
}

fn row(cells: &[&Cell]) -> Row {
    let with: Vec<&Cell> = cells.iter().copied().filter(|c| !c.outcomes.is_empty()).collect();
    let mean_of = |pick: fn(&Outcome) -> f64| -> Vec<(String, f64)> {
        let of_planner = |p: &&str| {
            let all: Vec<f64> = with.iter().filter_map(|c| of(c, p).map(pick)).collect();
            (!all.is_empty()).then(|| ((*p).to_owned(), mean(&all)))
        };
        PLANNERS.iter().filter_map(of_planner).collect()
    };
    let against = |of: fn(&[&Cell], &str, &str) -> Option<Gain>| -> Vec<(String, Gain)> {
        let others = PLANNERS.iter().filter(|p| **p != "ergopath");
        others.filter_map(|p| of(&with, p, "ergopath").map(|g| ((*p).to_owned(), g))).collect()
    };
    let gap: Vec<f64> = with
        .iter()
        .filter_map(|c| of(c, "ergopath"))
        .filter_map(|o| o.predicted_rula.map(|p| o.expected_rula - p))
        .collect();
    let relative: Vec<f64> = with
        .iter()
        .filter_map(|c| Some((of(c, "straight")?, of(c, "oracle")?)))
        .map(|(s, o)| 1.0 - o.expected_rula / s.expected_rula)
        .collect();
    Row {
        family: None,
        kind: None,
        cells: (with.len(), cells.len() - with.len()),
        expected: mean_of(|o| o.expected_rula),
        cvar90: mean_of(|o| o.cvar90_rula),
        gains: against(gain),
        cvar90_gains: against(cvar_gain),
        share_of_oracle: share(&with),
        oracle_gain: (!relative.is_empty()).then(|| mean(&relative)),
        calibration_gap: (!gap.is_empty()).then(|| mean(&gap)),
    }
}

/// Mean over cells of `a - b`, paired over repetitions.
fn gain(cells: &[&Cell], a: &str, b: &str) -> Option<Gain> {
    let differences: Vec<Vec<f64>> = cells
        .iter()
        .filter_map(|c| Some((of(c, a)?, of(c, b)?)))
        .map(|(a, b)| a.rula.iter().zip(&b.rula).map(|(x, y)| x - y).collect())
        .collect();
    if differences.is_empty() {
        return None;
    }
    let count = differences.len() as f64;
    let means: Vec<f64> = differences.iter().map(|d| mean(d)).collect();
    let variance: f64 = differences.iter().map(|d| std_dev(d).powi(2) / d.len() as f64).sum();
    let half = 1.96 * variance.sqrt() / count;
    let m = mean(&means);
    Some(Gain { mean: m, low95: m - half, high95: m + half, cells: differences.len() })
}

/// Resamples behind an interval of a `CVaR90`.
const RESAMPLES: u32 = 500;

/// Mean over cells of `CVaR90(a) - CVaR90(b)`; its interval resamples repetitions within each cell,
/// the same ones for both.
fn cvar_gain(cells: &[&Cell], a: &str, b: &str) -> Option<Gain> {
    let pairs: Vec<(&[f64], &[f64])> = cells
        .iter()
        .filter_map(|c| Some((of(c, a)?.rula.as_slice(), of(c, b)?.rula.as_slice())))
        .collect();
    if pairs.is_empty() {
        return None;
    }
    let difference = |x: &[f64], y: &[f64]| cvar_upper(x, 0.1) - cvar_upper(y, 0.1);
    let plain: Vec<f64> = pairs.iter().map(|(x, y)| difference(x, y)).collect();
    let resampled = |k: u32| {
        let mut rng = stream(0, Purpose::Simulation, 30, k);
        let one = |(x, y): &(&[f64], &[f64])| {
            let count = x.len().min(y.len());
            let drawn: Vec<usize> = (0..count).map(|_| rng.random_range(0..count)).collect();
            let pick = |v: &[f64]| drawn.iter().map(|&i| v[i]).collect::<Vec<_>>();
            difference(&pick(x), &pick(y))
        };
        mean(&pairs.iter().map(one).collect::<Vec<_>>())
    };
    let means: Vec<f64> = (0..RESAMPLES).map(resampled).collect();
    let (low95, high95) = (quantile(&means, 0.025), quantile(&means, 0.975));
    Some(Gain { mean: mean(&plain), low95, high95, cells: pairs.len() })
}

/// Pooled gain of ours over the pooled gain of the oracle, both against the straight path.
fn share(cells: &[&Cell]) -> Option<Gain> {
    let mut ours = Vec::new();
    let mut best = Vec::new();
    for c in cells {
        let (Some(s), Some(e), Some(o)) = (of(c, "straight"), of(c, "ergopath"), of(c, "oracle"))
        else {
            continue;
        };
        ours.push(s.rula.iter().zip(&e.rula).map(|(x, y)| x - y).collect::<Vec<f64>>());
        best.push(s.rula.iter().zip(&o.rula).map(|(x, y)| x - y).collect::<Vec<f64>>());
    }
    let pooled = |all: &[Vec<f64>]| mean(&all.iter().map(|d| mean(d)).collect::<Vec<_>>());
    let (a, b) = (pooled(&ours), pooled(&best));
    if ours.is_empty() || b <= 0.0 {
        return None;
    }
    let ratio = a / b;
    // d(a/b) = (da - ratio db) / b, repetition by repetition.
    let variance: f64 = ours
        .iter()
        .zip(&best)
        .map(|(x, y)| {
            let residual: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - ratio * y).collect();
            std_dev(&residual).powi(2) / residual.len() as f64
        })
        .sum();
    let half = 1.96 * variance.sqrt() / (ours.len() as f64 * b);
    Some(Gain { mean: ratio, low95: ratio - half, high95: ratio + half, cells: ours.len() })
}

#[cfg(test)]
mod tests {
    use super::super::people::Kind;
    use super::*;
    use approx::assert_relative_eq;

    fn cell(family: Family, rula: &[(&str, [f64; 4])]) -> Cell {
        let outcome = |(name, rula): &(&str, [f64; 4])| Outcome {
            planner: (*name).to_owned(),
            expected_rula: mean(rula),
            cvar90_rula: 0.0,
            exposure_rula_5: 0.0,
            expected_reba: 0.0,
            reach_exceeded: 0.0,
            predicted_rula: Some(mean(rula) - 0.1),
            rula: rula.to_vec(),
        };
        Cell {
            station: String::new(),
            family,
            body: String::new(),
            kind: Kind::InClass,
            redrawn: 0,
            outcomes: rula.iter().map(outcome).collect(),
            failure: None,
        }
    }

    #[test]
    fn gains_are_paired_and_the_share_is_of_the_oracle() {
        let cells = [
            cell(
                Family::Bench,
                &[
                    ("straight", [4.0, 5.0, 6.0, 5.0]),
                    ("ergopath", [3.1, 4.1, 5.1, 4.1]),
                    ("oracle", [3.0, 4.0, 5.0, 4.0]),
                ],
            ),
            cell(
                Family::Overhead,
                &[("straight", [4.0; 4]), ("ergopath", [3.5; 4]), ("oracle", [3.0; 4])],
            ),
        ];
        let t = table(&cells);
        // Two families, all, one kind.
        assert_eq!(t.rows.len(), 4);
        let all = t.all().unwrap();
        let tail = &all.cvar90_gains.iter().find(|g| g.0 == "straight").unwrap().1;
        // The worst tenth of four is the worst: 6.0 - 5.1 and 4.0 - 3.5.
        assert_relative_eq!(tail.mean, 0.7, epsilon = 1e-12);
        assert_relative_eq!(tail.high95 - tail.low95, 0.0, epsilon = 1e-9);
        let straight = &all.gains.iter().find(|g| g.0 == "straight").unwrap().1;
        assert_relative_eq!(straight.mean, 0.7, epsilon = 1e-12);
        // Every repetition has the same difference: no width.
        assert_relative_eq!(straight.low95, 0.7, epsilon = 1e-9);
        assert_relative_eq!(all.share_of_oracle.unwrap().mean, 0.7, epsilon = 1e-12);
        assert_relative_eq!(all.calibration_gap.unwrap(), 0.1, epsilon = 1e-12);
        assert!(all.gains.iter().all(|g| g.0 != "shortest"));
    }
}
