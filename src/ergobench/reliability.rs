//! Whether the risk that a plan predicts is the risk that the person has: true shares of time at RULA 5 or more,
//! for paths of which about the same share was predicted.

use super::bootstrap::{Gain, Part, by_cells};
use super::cell::{Cell, Outcome};
use crate::math::stats::mean;
use serde::Serialize;

/// Width of a bin of predicted shares.
const WIDTH: f64 = 0.2;

/// Paths of which about the same share of time at RULA 5 or more was predicted.
#[derive(Debug, Clone, Serialize)]
pub struct ReliabilityBin {
    /// Lower and upper end of the bin.
    pub between: [f64; 2],
    /// Mean predicted share.
    pub predicted: f64,
    /// Mean true share, with its interval by cells.
    pub truth: Gain,
    /// Paths in it: of every planner but the oracle, which knows the truth.
    pub paths: usize,
}

/// The bins that hold a path, from low to high risk.
pub(super) fn reliability(cells: &[Cell]) -> Vec<ReliabilityBin> {
    let bins = (1.0 / WIDTH).round() as usize;
    (0..bins).filter_map(|k| bin(cells, (k, bins))).collect()
}

fn bin(cells: &[Cell], (k, bins): (usize, usize)) -> Option<ReliabilityBin> {
    // The last bin holds its upper end too.
    let is_in = |share: f64| ((share / WIDTH) as usize).min(bins - 1) == k;
    let own = |c: &Cell| -> Vec<(f64, Vec<f64>)> {
        let judged = |o: &Outcome| {
            let predicted = o.predicted_exposure_rula_5.filter(|_| o.planner != "oracle")?;
            is_in(predicted).then(|| (predicted, o.high.clone()))
        };
        c.outcomes.iter().filter_map(judged).collect()
    };
    let all: Vec<Vec<(f64, Vec<f64>)>> =
        cells.iter().map(own).filter(|paths| !paths.is_empty()).collect();
    let predicted: Vec<f64> = all.iter().flatten().map(|p| p.0).collect();
    let parts: Vec<Part> = all
        .iter()
        .map(|paths| Part {
            repetitions: paths.iter().map(|p| p.1.len()).min().unwrap_or(0),
            of: Box::new(move |r| {
                let share =
                    |p: &(f64, Vec<f64>)| mean(&r.iter().map(|i| p.1[*i]).collect::<Vec<_>>());
                [paths.iter().map(share).sum(), paths.len() as f64]
            }),
        })
        .collect();
    let truth = by_cells(&parts)?;
    let between = [k, k + 1].map(|end| WIDTH * end as f64);
    Some(ReliabilityBin { between, predicted: mean(&predicted), truth, paths: predicted.len() })
}

#[cfg(test)]
mod tests {
    use super::super::families::Family;
    use super::super::people::Kind;
    use super::*;
    use approx::assert_relative_eq;

    fn cell(outcomes: &[(&str, Option<f64>, [f64; 2])]) -> Cell {
        let outcome = |(planner, predicted, high): &(&str, Option<f64>, [f64; 2])| Outcome {
            planner: (*planner).to_owned(),
            expected_rula: 0.0,
            cvar90_rula: 0.0,
            exposure_rula_5: mean(high),
            expected_reba: 0.0,
            reach_exceeded: 0.0,
            predicted_rula: None,
            predicted_exposure_rula_5: *predicted,
            rula: Vec::new(),
            high: high.to_vec(),
        };
        Cell {
            station: String::new(),
            family: Family::Bench,
            body: String::new(),
            kind: Kind::InClass,
            redrawn: 0,
            demonstrated: None,
            outcomes: outcomes.iter().map(outcome).collect(),
            failure: None,
        }
    }

    #[test]
    fn paths_meet_those_of_like_prediction_and_the_oracle_is_left_out() {
        let cells = [
            cell(&[
                ("ergopath", Some(0.1), [0.0, 0.4]),
                ("straight", Some(1.0), [0.7, 0.9]),
                ("oracle", Some(0.1), [1.0, 1.0]),
            ]),
            cell(&[
                ("ergopath", Some(0.3), [0.2, 0.4]),
                ("straight", Some(0.15), [0.5, 0.5]),
                ("shortest", None, [1.0, 1.0]),
            ]),
        ];
        let bins = reliability(&cells);
        let shown: Vec<[f64; 3]> =
            bins.iter().map(|b| [b.predicted, b.truth.mean, b.paths as f64]).collect();
        let wanted = [[0.125, 0.35, 2.0], [0.3, 0.3, 1.0], [1.0, 0.8, 1.0]];
        assert_eq!(shown.len(), wanted.len());
        for (a, b) in shown.iter().flatten().zip(wanted.iter().flatten()) {
            assert_relative_eq!(a, b, epsilon = 1e-12);
        }
        assert_relative_eq!(bins[2].between[1], 1.0, epsilon = 1e-12);
        // Two cells make an interval, one makes none.
        assert!(bins[0].truth.low95.is_some() && bins[1].truth.low95.is_none());
    }
}
