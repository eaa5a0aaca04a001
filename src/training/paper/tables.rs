//! The paper's own figures for its experiments with people: supplement, one table for each.
//!
//! Median, 5th and 95th percentile. What [`toy5r_paper`](crate::training::toy5r_paper) says of the first table
//! holds here too: "R-MSE" reads as a mean of squares, the task likelihood tells the task noise that was assumed,
//! and only order and ratios compare, because chain, units and people are others.

use super::sets::PaperExperiment;
use crate::posture::Method;

/// Median, 5th and 95th percentile.
type Spread = [f64; 3];

/// One method of a table: log-likelihood and "R-MSE" of the joint velocity, as printed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperSpreads {
    /// The method.
    pub method: Method,
    /// Mean log-likelihood of the joint velocity, natural logarithm.
    pub ll_q: Spread,
    /// "R-MSE" of the joint velocity.
    pub rmse_q: Spread,
}

impl PaperSpreads {
    /// Root of the printed error, rad/s: the error if the column is a mean of squares.
    pub fn rmse_q_if_squared(&self) -> Spread {
        self.rmse_q.map(f64::sqrt)
    }
}

type Row = (Method, Spread, Spread);

const EXP1: [Row; 6] = [
    (Method::Gp, [7.69, 7.50, 7.84], [43.33e-3, 23.05e-3, 86.41e-3]),
    (Method::WIk, [7.05, 6.68, 7.12], [2.82e-3, 1.24e-3, 6.40e-3]),
    (Method::SbM, [8.57, 8.25, 8.65], [3.48e-3, 1.37e-3, 8.09e-3]),
    (Method::Nsgp, [8.82, 8.39, 9.10], [2.9e-3, 1.31e-3, 5.53e-3]),
    (Method::Promp, [9.02, 8.20, 9.46], [2.30e-3, 1.37e-3, 3.83e-3]),
    (Method::MiNsgp, [9.32, 8.81, 9.59], [2.19e-3, 1.24e-3, 3.38e-3]),
];
const EXP2: [Row; 6] = [
    (Method::Gp, [7.22, 7.02, 7.27], [57.13e-3, 45.74e-3, 94.05e-3]),
    (Method::WIk, [6.85, 5.36, 7.10], [10.08e-3, 6.67e-3, 17.64e-3]),
    (Method::SbM, [7.24, 7.13, 7.27], [15.73e-3, 12.27e-3, 23.03e-3]),
    (Method::Nsgp, [7.97, 7.79, 8.13], [9.35e-3, 4.18e-3, 10.85e-3]),
    (Method::Promp, [8.09, 7.44, 8.34], [11.04e-3, 8.70e-3, 15.25e-3]),
    (Method::MiNsgp, [8.72, 8.52, 8.81], [4.34e-3, 3.93e-3, 6.22e-3]),
];
const EXP3: [Row; 6] = [
    (Method::Gp, [8.50, 8.17, 8.81], [28.93e-3, 25.94e-3, 44.06e-3]),
    (Method::WIk, [7.12, 7.00, 7.14], [3.47e-3, 1.0e-3, 7.92e-3]),
    (Method::SbM, [8.92, 8.55, 8.97], [4.20e-3, 1.63e-3, 10.37e-3]),
    (Method::Nsgp, [9.28, 9.10, 9.47], [2.01e-3, 1.15e-3, 4.38e-3]),
    (Method::Promp, [9.22, 8.39, 9.61], [3.67e-3, 2.43e-3, 5.35e-3]),
    (Method::MiNsgp, [9.47, 9.28, 9.67], [1.93e-3, 1.05e-3, 4.13e-3]),
];

/// The paper's table of an experiment, in its order.
pub fn paper_table(experiment: PaperExperiment) -> [PaperSpreads; 6] {
    let rows = match experiment {
        PaperExperiment::Exp1 => EXP1,
        PaperExperiment::Exp2 => EXP2,
        PaperExperiment::Exp3 => EXP3,
    };
    rows.map(|(method, ll_q, rmse_q)| PaperSpreads { method, ll_q, rmse_q })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_enclose_medians_and_the_papers_method_leads() {
        for experiment in [PaperExperiment::Exp1, PaperExperiment::Exp2, PaperExperiment::Exp3] {
            let rows = paper_table(experiment);
            for row in rows {
                for [median, low, high] in [row.ll_q, row.rmse_q] {
                    assert!(low <= median && median <= high, "{:?}", row.method);
                }
            }
            let own = rows[5];
            assert_eq!(own.method, Method::MiNsgp);
            assert!(rows[..5].iter().all(|r| own.ll_q[0] > r.ll_q[0]));
            assert!(rows[..5].iter().all(|r| own.rmse_q[0] < r.rmse_q[0]));
        }
    }
}
