//! What a search has tried: its points, and where it stands.

use super::refusal::Refusal;
use crate::math::cma::Cma;
use crate::path::Change;
use serde::{Deserialize, Serialize};

/// Value from which infeasible points are counted; no objective of feasible ones comes near it.
pub(super) const INFEASIBLE: f64 = 1e9;

/// A point that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tried {
    /// Its name.
    pub id: String,
    /// Search variables.
    pub x: Vec<f64>,
    /// The objective in the search; of an infeasible point a large number.
    pub value: f64,
    /// People behind the value; 0 for an infeasible point.
    pub repetitions: usize,
    /// Length of the way, m; of an infeasible point maybe infinite.
    pub length_m: f64,
    /// Why it was refused.
    pub refused: Option<Refusal>,
    /// What would make it feasible, each alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub changes: Vec<Change>,
}

impl Tried {
    /// A point that nobody has judged yet.
    pub(super) fn at(id: &str, x: Vec<f64>) -> Self {
        let (id, value) = (id.to_owned(), INFEASIBLE);
        let (refused, changes) = (None, Vec::new());
        Self { id, x, value, repetitions: 0, length_m: f64::MAX, refused, changes }
    }
}

/// A search that can go on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchState {
    pub(super) cma: Cma,
    /// Generations done.
    pub(super) generation: usize,
    /// All points, in order.
    pub tried: Vec<Tried>,
}

impl SearchState {
    /// Why it cannot go on; none where it can.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let n = self.cma.mean().len();
        if let Some(fault) = self.cma.fault() {
            return Some(fault);
        }
        let is_whole = |t: &Tried| t.x.len() == n && t.x.iter().all(|x| x.is_finite());
        (!self.tried.iter().all(is_whole)).then_some("a point that it tried is not whole")
    }

    /// The centre of the last generation, as a point.
    pub(super) fn centre(&self) -> Vec<f64> {
        self.cma.mean().to_vec()
    }

    /// The best distinct points, at most `count`, each farther than `apart` (white units) from those
    /// before it. Points on at least `repetitions` repetitions come first.
    pub(super) fn best(&self, count: usize, repetitions: usize, apart: f64) -> Vec<&Tried> {
        let mut order: Vec<&Tried> = self.tried.iter().filter(|t| t.repetitions > 0).collect();
        order.sort_by(|a, b| {
            (b.repetitions >= repetitions)
                .cmp(&(a.repetitions >= repetitions))
                .then(a.value.total_cmp(&b.value))
                .then(a.id.cmp(&b.id))
        });
        let mut kept: Vec<&Tried> = Vec::new();
        for point in order {
            let is_new = |k: &&&Tried| distance(&k.x, &point.x) < apart;
            if kept.len() < count && !kept.iter().any(|k| is_new(&k)) {
                kept.push(point);
            }
        }
        kept
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
