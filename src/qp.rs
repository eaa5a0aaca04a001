//! Quadratic programs over linear and second-order cones, as values that can be looked at.
//!
//! ```text
//! minimise    1/2 x^T P x + q^T x
//! subject to  A x + s = b,   s in K = K_1 x K_2 x ...
//! ```
//! `x` n variables, `P` n x n symmetric positive semidefinite (upper triangle given), `A` m x n,
//! multipliers `z` of the m rows in the dual cone. The rows come in labelled blocks, one cone each,
//! so that a contradiction can be told in the words of the problem. This module is the only one that
//! names the solver; its answers are statuses, never panics.

mod check;

pub use check::{Residuals, residuals};

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus,
    SupportedConeT, ZeroConeT,
};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The cone in which the slack `s = b - A x` of one block of rows must lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cone {
    /// `s = 0`: equalities `A x = b`.
    Zero,
    /// `s >= 0`: inequalities `A x <= b`.
    Nonnegative,
    /// `s_0 >= |(s_1, s_2, ...)|`.
    SecondOrder,
}

/// A block of consecutive rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Block {
    /// What the rows say, for people; blocks may share a label.
    pub label: Cow<'static, str>,
    /// Where the slack of the rows must lie.
    pub cone: Cone,
    /// Number of rows.
    pub rows: usize,
}

/// One matrix entry: row, column, value. Entries at the same place add up.
pub type Entry = (usize, usize, f64);

/// A conic quadratic program.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Problem {
    /// Number of variables n.
    pub variables: usize,
    /// Upper triangle of `P`.
    pub quadratic: Vec<Entry>,
    /// `q`, n numbers.
    pub linear: Vec<f64>,
    /// `A`.
    pub matrix: Vec<Entry>,
    /// `b`, m numbers.
    pub offset: Vec<f64>,
    /// The blocks of rows, in order, m rows in all.
    pub blocks: Vec<Block>,
}

/// A label whose rows take part in a contradiction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Culprit {
    /// The label of the rows.
    pub label: String,
    /// Its share of `sum |b_i z_i|` over the rows of the certificate, in [0, 1]; this does not change
    /// when rows or variables are scaled.
    pub share: f64,
}

/// Why the solver stopped without an answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub enum Stop {
    /// The iteration limit was reached.
    MaxIterations,
    /// The arithmetic broke down.
    NumericalError,
    /// The iterates no longer got better.
    InsufficientProgress,
    /// The problem is malformed, for the reason given.
    Invalid(String),
    /// Any other status, by the solver's name.
    Other(String),
}

/// What came of a problem.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Outcome {
    /// The minimiser.
    Solved {
        /// Variables, n numbers.
        x: Vec<f64>,
        /// Multipliers of the rows, m numbers.
        z: Vec<f64>,
        /// `1/2 x^T P x + q^T x`.
        objective: f64,
        /// Interior-point iterations.
        iterations: u32,
        /// Whether only the reduced accuracy was reached ("almost solved").
        is_reduced: bool,
    },
    /// No `x` meets all rows.
    PrimalInfeasible {
        /// The labels that contradict each other, largest share first.
        culprits: Vec<Culprit>,
    },
    /// The objective has no lower bound.
    DualInfeasible,
    /// No answer.
    NotConverged {
        /// Why not.
        status: Stop,
    },
}

impl Problem {
    /// An empty problem in `variables` variables: minimise 0.
    pub fn new(variables: usize) -> Self {
        Self { variables, linear: vec![0.0; variables], ..Self::default() }
    }

    /// Number of rows m.
    pub fn rows(&self) -> usize {
        self.offset.len()
    }

    /// Appends a block of rows: for each its entries (column, value) and its offset. Rows of a
    /// polyhedral cone join the block before them when label and cone are the same: one cone of many
    /// rows costs the solver less than many of one.
    pub fn push_block(
        &mut self,
        label: impl Into<Cow<'static, str>>,
        cone: Cone,
        rows: &[(&[(usize, f64)], f64)],
    ) {
        for (entries, offset) in rows {
            let row = self.rows();
            self.matrix.extend(entries.iter().map(|(column, value)| (row, *column, *value)));
            self.offset.push(*offset);
        }
        let label = label.into();
        match self.blocks.last_mut() {
            Some(last) if cone != Cone::SecondOrder && last.cone == cone && last.label == label => {
                last.rows += rows.len();
            }
            _ => self.blocks.push(Block { label, cone, rows: rows.len() }),
        }
    }

    /// The first thing that is wrong with the sizes, indices or numbers.
    pub fn fault(&self) -> Option<String> {
        let (n, m) = (self.variables, self.rows());
        if self.linear.len() != n {
            return Some(format!("q holds {} numbers for {n} variables", self.linear.len()));
        }
        let in_blocks: usize = self.blocks.iter().map(|b| b.rows).sum();
        if in_blocks != m {
            return Some(format!("the blocks hold {in_blocks} rows and b holds {m}"));
        }
        if n == 0 {
            return Some("there are no variables".to_owned());
        }
        if let Some((row, column, _)) =
            self.quadratic.iter().find(|(row, column, _)| row > column || *column >= n)
        {
            return Some(format!("P({row}, {column}) is outside the upper triangle"));
        }
        if let Some((row, column, _)) =
            self.matrix.iter().find(|(row, column, _)| *row >= m || *column >= n)
        {
            return Some(format!("A({row}, {column}) is outside the matrix"));
        }
        let entries = self.quadratic.iter().chain(&self.matrix).map(|(_, _, value)| value);
        let mut numbers = entries.chain(&self.linear).chain(&self.offset);
        numbers.any(|x| !x.is_finite()).then(|| "a coefficient is not finite".to_owned())
    }
}

/// Solves a problem; single-threaded and deterministic.
pub fn solve(problem: &Problem) -> Outcome {
    if let Some(fault) = problem.fault() {
        return Outcome::NotConverged { status: Stop::Invalid(fault) };
    }
    let n = problem.variables;
    let quadratic = compressed(n, n, &problem.quadratic);
    let matrix = compressed(problem.rows(), n, &problem.matrix);
    let cones: Vec<SupportedConeT<f64>> = problem
        .blocks
        .iter()
        .map(|block| match block.cone {
            Cone::Zero => ZeroConeT(block.rows),
            Cone::Nonnegative => NonnegativeConeT(block.rows),
            Cone::SecondOrder => SecondOrderConeT(block.rows),
        })
        .collect();
    let by = |settings| {
        let (linear, offset) = (&problem.linear, &problem.offset);
        match DefaultSolver::new(&quadratic, linear, &matrix, offset, &cones, settings) {
            Ok(mut solver) => {
                solver.solve();
                outcome(problem, &solver)
            }
            Err(e) => Outcome::NotConverged { status: Stop::Invalid(e.to_string()) },
        }
    };
    match by(settings()) {
        Outcome::NotConverged { status: Stop::InsufficientProgress | Stop::NumericalError } => {
            by(exact_settings())
        }
        reduced @ Outcome::Solved { is_reduced: true, .. } => match by(exact_settings()) {
            Outcome::NotConverged { .. } => reduced,
            exact => exact,
        },
        other => other,
    }
}

/// For the rare problem (short steps of a path) that the usual regularisation of the linear systems
/// drowns: a hundredth of it, made good by refinement.
fn exact_settings() -> DefaultSettings<f64> {
    DefaultSettings {
        static_regularization_constant: 1e-10,
        iterative_refinement_max_iter: 20,
        ..settings()
    }
}

fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        max_threads: 1,
        direct_solve_method: "qdldl".to_owned(),
        // One step of refinement takes as many iterations here as ten do, in less time.
        iterative_refinement_max_iter: 1,
        // Presolve would drop rows and with them their labels.
        presolve_enable: false,
        ..DefaultSettings::default()
    }
}

fn outcome(problem: &Problem, solver: &DefaultSolver<f64>) -> Outcome {
    let solution = &solver.solution;
    let stopped = |status| Outcome::NotConverged { status };
    match solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => {
            if solution.x.iter().chain(&solution.z).any(|x| !x.is_finite()) {
                return stopped(Stop::NumericalError);
            }
            Outcome::Solved {
                x: solution.x.clone(),
                z: solution.z.clone(),
                objective: solution.obj_val,
                iterations: solution.iterations,
                is_reduced: solution.status == SolverStatus::AlmostSolved,
            }
        }
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
            Outcome::PrimalInfeasible { culprits: culprits(problem, &solution.z) }
        }
        SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => {
            Outcome::DualInfeasible
        }
        SolverStatus::MaxIterations => stopped(Stop::MaxIterations),
        SolverStatus::NumericalError => stopped(Stop::NumericalError),
        SolverStatus::InsufficientProgress => stopped(Stop::InsufficientProgress),
        other => stopped(Stop::Other(format!("{other:?}"))),
    }
}

/// Labels of the rows that carry the certificate `A^T z = 0, b^T z < 0`.
///
/// `|b_i z_i|` measures a row's part in the contradiction in the same unit for every row. A row with
/// `b_i = 0` may be needed too; such labels follow, ordered by `|z_i| |A_i|`.
fn culprits(problem: &Problem, z: &[f64]) -> Vec<Culprit> {
    let mut row_size = vec![0.0f64; problem.rows()];
    for (row, _, value) in &problem.matrix {
        row_size[*row] += value * value;
    }
    // Label, part of b^T z, weight of the rows.
    let mut found: Vec<(&str, f64, f64)> = Vec::new();
    let mut row = 0;
    for block in &problem.blocks {
        let rows = row..row + block.rows;
        let part: f64 = rows.clone().map(|i| (problem.offset[i] * z[i]).abs()).sum();
        let weight: f64 = rows.map(|i| z[i].abs() * row_size[i].sqrt()).sum();
        row += block.rows;
        match found.iter_mut().find(|(label, _, _)| *label == block.label) {
            Some(entry) => {
                entry.1 += part;
                entry.2 += weight;
            }
            None => found.push((&block.label, part, weight)),
        }
    }
    let total: f64 = found.iter().map(|f| f.1).sum();
    let heaviest = found.iter().map(|f| f.2).fold(0.0, f64::max);
    // An interior-point certificate leaves small multipliers on rows that do not matter.
    found.retain(|f| f.1 > 1e-3 * total || f.2 > 1e-3 * heaviest);
    found.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.2.total_cmp(&a.2)));
    let share = |part: f64| if total > 0.0 { part / total } else { 0.0 };
    found
        .into_iter()
        .map(|(label, part, _)| Culprit { label: label.to_owned(), share: share(part) })
        .collect()
}

/// Compressed columns of a list of entries, those at the same place added up.
fn compressed(rows: usize, columns: usize, entries: &[Entry]) -> CscMatrix<f64> {
    let mut sorted = entries.to_vec();
    sorted.sort_by_key(|(row, column, _)| (*column, *row));
    let mut starts = vec![0; columns + 1];
    let mut row_of: Vec<usize> = Vec::with_capacity(sorted.len());
    let mut values: Vec<f64> = Vec::with_capacity(sorted.len());
    let mut before = None;
    for (row, column, value) in sorted {
        if before == Some((row, column)) {
            if let Some(last) = values.last_mut() {
                *last += value;
            }
            continue;
        }
        before = Some((row, column));
        row_of.push(row);
        values.push(value);
        starts[column + 1] += 1;
    }
    for column in 0..columns {
        starts[column + 1] += starts[column];
    }
    CscMatrix::new(rows, columns, starts, row_of, values)
}

#[cfg(test)]
mod tests;
