//! The table: gains over each baseline under the truth, by family, pooled and by kind of person.

use super::bootstrap::{Gain, Part, by_cells};
use super::cell::{Cell, Outcome};
use super::families::Family;
use super::people::Kind;
use super::reliability::{ReliabilityBin, reliability};
use super::{OURS, PACED};
use crate::math::stats::{cvar_upper, mean};
use serde::Serialize;

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
    /// Mean of `other - ours` for each other planner, in points of expected RULA: above 0 ours is better.
    pub gains: Vec<(String, Gain)>,
    /// The same of `CVaR90`.
    pub cvar90_gains: Vec<(String, Gain)>,
    /// Our summed gain over the straight path as a share of the oracle's.
    pub share_of_oracle: Option<Gain>,
    /// Gain of the oracle over the straight path, as a share of the straight path's score.
    pub oracle_gain: Option<f64>,
    /// Mean of `truth - prediction` of our path's expected RULA: how far the learned model is off.
    pub calibration_gap: Option<Gain>,
    /// Mean share of repetitions in which the hand cannot follow our path, under the truth.
    pub out_of_reach: Option<f64>,
    /// Cells in which our path is worse than the straight one under the truth.
    pub worse_than_straight: usize,
}

/// All lines: one for each family, all together, then one for each kind of person.
#[derive(Debug, Clone, Serialize)]
pub struct Table {
    /// The lines.
    pub rows: Vec<Row>,
    /// Cells in which the planner fails, the worst first.
    pub failures: Vec<Weak>,
    /// Predicted against true share of time at RULA 5 or more.
    pub reliability: Vec<ReliabilityBin>,
}

/// A cell in which our path is worse than the straight one, cannot be followed, or was misjudged.
#[derive(Debug, Clone, Serialize)]
pub struct Weak {
    /// The workstation.
    pub station: String,
    /// Body and kind of the person.
    pub body: String,
    /// Kind of the person.
    pub kind: Kind,
    /// Expected RULA of our path: predicted by the learned model, and true.
    pub predicted: f64,
    /// Under the truth.
    pub truth: f64,
    /// Expected RULA of the straight path under the truth.
    pub straight: f64,
    /// Share of repetitions in which the hand cannot follow our path, under the truth.
    pub out_of_reach: f64,
}

/// Prediction error (points of RULA) and share out of reach beyond which a cell counts as a failure.
pub const MISJUDGED: f64 = 0.5;
/// See [`MISJUDGED`].
pub const OUT_OF_REACH: f64 = 0.05;

impl Weak {
    /// Whether our path is worse than the straight one.
    pub fn is_worse_than_straight(&self) -> bool {
        self.truth > self.straight
    }

    fn is_failure(&self) -> bool {
        let is_misjudged = (self.predicted - self.truth).abs() > MISJUDGED;
        self.is_worse_than_straight() || self.out_of_reach > OUT_OF_REACH || is_misjudged
    }

    fn of(cell: &Cell) -> Option<Self> {
        let (ours, straight) = (of(cell, OURS)?, of(cell, "straight")?);
        Some(Self {
            station: cell.station.clone(),
            body: cell.body.clone(),
            kind: cell.kind,
            predicted: ours.predicted_rula?,
            truth: ours.expected_rula,
            straight: straight.expected_rula,
            out_of_reach: ours.reach_exceeded,
        })
    }
}

/// Planners in the order of the table.
const PLANNERS: [&str; 9] = [
    OURS,
    PACED,
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
    let mut failures: Vec<Weak> =
        cells.iter().filter_map(Weak::of).filter(Weak::is_failure).collect();
    let error = |w: &Weak| w.truth - w.predicted.min(w.straight);
    failures.sort_by(|a, b| error(b).total_cmp(&error(a)));
    Table { rows, failures, reliability: reliability(cells) }
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
    let against = |figure: fn(&[f64]) -> f64| -> Vec<(String, Gain)> {
        let others = PLANNERS.iter().filter(|p| **p != OURS);
        others.filter_map(|p| Some(((*p).to_owned(), gain(&with, p, figure)?))).collect()
    };
    let relative: Vec<f64> = with
        .iter()
        .filter_map(|c| Some((of(c, "straight")?, of(c, "oracle")?)))
        .map(|(s, o)| 1.0 - o.expected_rula / s.expected_rula)
        .collect();
    let lost: Vec<f64> = with.iter().filter_map(|c| Some(of(c, OURS)?.reach_exceeded)).collect();
    let worse = with.iter().filter_map(|c| Weak::of(c)).filter(Weak::is_worse_than_straight);
    Row {
        family: None,
        kind: None,
        cells: (with.len(), cells.len() - with.len()),
        expected: mean_of(|o| o.expected_rula),
        cvar90: mean_of(|o| o.cvar90_rula),
        gains: against(mean),
        cvar90_gains: against(|x| cvar_upper(x, 0.1)),
        share_of_oracle: share(&with),
        oracle_gain: (!relative.is_empty()).then(|| mean(&relative)),
        calibration_gap: gap(&with),
        out_of_reach: (!lost.is_empty()).then(|| mean(&lost)),
        worse_than_straight: worse.count(),
    }
}

fn picked(values: &[f64], repetitions: &[usize]) -> Vec<f64> {
    repetitions.iter().map(|&r| values[r]).collect()
}

/// Mean over cells of `figure(other) - figure(ours)`, both of the same repetitions.
fn gain(cells: &[&Cell], other: &str, figure: fn(&[f64]) -> f64) -> Option<Gain> {
    let parts: Vec<Part> = cells
        .iter()
        .filter_map(|c| Some((&of(c, other)?.rula, &of(c, OURS)?.rula)))
        .map(|(a, b)| Part {
            repetitions: a.len().min(b.len()),
            of: Box::new(move |r| [figure(&picked(a, r)) - figure(&picked(b, r)), 1.0]),
        })
        .collect();
    by_cells(&parts)
}

/// Our summed gain over the oracle's, both against the straight path.
fn share(cells: &[&Cell]) -> Option<Gain> {
    let parts: Vec<Part> = cells
        .iter()
        .filter_map(|c| {
            Some((&of(c, "straight")?.rula, &of(c, OURS)?.rula, &of(c, "oracle")?.rula))
        })
        .map(|(s, e, o)| Part {
            repetitions: s.len().min(e.len()).min(o.len()),
            of: Box::new(move |r| {
                let straight = mean(&picked(s, r));
                [straight - mean(&picked(e, r)), straight - mean(&picked(o, r))]
            }),
        })
        .collect();
    by_cells(&parts)
}

/// Mean over cells of `truth - prediction` of our path.
fn gap(cells: &[&Cell]) -> Option<Gain> {
    let parts: Vec<Part> = cells
        .iter()
        .filter_map(|c| {
            let ours = of(c, OURS)?;
            Some((&ours.rula, ours.predicted_rula?))
        })
        .map(|(rula, predicted)| Part {
            repetitions: rula.len(),
            of: Box::new(move |r| [mean(&picked(rula, r)) - predicted, 1.0]),
        })
        .collect();
    by_cells(&parts)
}

#[cfg(test)]
mod tests {
    use super::super::people::Kind;
    use super::*;
    use approx::assert_relative_eq;

    fn cell(family: Family, lost: f64, rula: &[(&str, [f64; 4])]) -> Cell {
        let outcome = |(name, rula): &(&str, [f64; 4])| Outcome {
            planner: (*name).to_owned(),
            expected_rula: mean(rula),
            cvar90_rula: 0.0,
            exposure_rula_5: 0.0,
            expected_reba: 0.0,
            reach_exceeded: lost,
            predicted_rula: Some(mean(rula) - 0.1),
            predicted_exposure_rula_5: None,
            rula: rula.to_vec(),
            high: Vec::new(),
        };
        Cell {
            station: family.name().to_owned(),
            family,
            body: String::new(),
            kind: Kind::InClass,
            redrawn: 0,
            demonstrated: None,
            outcomes: rula.iter().map(outcome).collect(),
            failure: None,
        }
    }

    #[test]
    fn gains_are_paired_and_the_share_is_of_the_oracle() {
        let bench = [
            ("straight", [4.0, 5.0, 6.0, 5.0]),
            (OURS, [3.1, 4.1, 5.1, 4.1]),
            ("oracle", [3.0, 4.0, 5.0, 4.0]),
        ];
        let overhead = [("straight", [4.0; 4]), (OURS, [3.5; 4]), ("oracle", [3.0; 4])];
        let cells = [cell(Family::Bench, 0.0, &bench), cell(Family::Overhead, 0.0, &overhead)];
        let t = table(&cells);
        // Two families, all, one kind.
        assert_eq!(t.rows.len(), 4);
        let all = t.all().unwrap();
        let of = |gains: &[(String, Gain)]| gains.iter().find(|g| g.0 == "straight").unwrap().1;
        // The worst tenth of four is the worst: 6.0 - 5.1 and 4.0 - 3.5.
        assert_relative_eq!(of(&all.cvar90_gains).mean, 0.7, epsilon = 1e-12);
        let straight = of(&all.gains);
        assert_relative_eq!(straight.mean, 0.7, epsilon = 1e-12);
        // Every repetition of a cell has the same difference, so that only cells make a width: the
        // ends are those of drawing one of the two cells twice.
        assert_relative_eq!(straight.low95.unwrap(), 0.5, epsilon = 1e-9);
        assert_relative_eq!(straight.high95.unwrap(), 0.9, epsilon = 1e-9);
        assert_eq!(of(&t.rows[0].gains).low95, None);
        assert_relative_eq!(all.share_of_oracle.unwrap().mean, 0.7, epsilon = 1e-12);
        assert_relative_eq!(all.calibration_gap.unwrap().mean, 0.1, epsilon = 1e-12);
        assert!(all.gains.iter().all(|g| g.0 != "shortest"));
        assert!(t.failures.is_empty());
    }

    #[test]
    fn cells_that_fail_are_named_the_worst_first() {
        let cells = [
            cell(Family::Bench, 0.0, &[("straight", [4.0; 4]), (OURS, [3.5; 4])]),
            cell(Family::Overhead, 0.0, &[("straight", [4.0; 4]), (OURS, [4.2; 4])]),
            cell(Family::LowBin, 0.4, &[("straight", [4.0; 4]), (OURS, [5.5; 4])]),
            cell(Family::ShelfLift, 0.06, &[("straight", [6.0; 4]), (OURS, [5.0; 4])]),
        ];
        let t = table(&cells);
        let named: Vec<&str> = t.failures.iter().map(|w| w.station.as_str()).collect();
        let families = [Family::LowBin, Family::Overhead, Family::ShelfLift];
        assert_eq!(named, families.map(Family::name));
        assert_eq!(t.all().unwrap().worse_than_straight, 2);
        assert_relative_eq!(t.all().unwrap().out_of_reach.unwrap(), 0.115, epsilon = 1e-12);
    }
}
