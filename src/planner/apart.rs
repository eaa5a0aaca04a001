//! What follows when the robot comes too near to the worker: less value in the search, refusal in the
//! selection and by the report, and how much farther apart robot and person would have to be.

use super::environment::{Environment, SELECTION_BLOCK};
use super::near::Care;
use super::objective::Figures;
use super::prepare::Prepared;
use super::refusal::{Hint, Refusal, RefusedBy, Status};
use super::result::{BodyScores, CandidateResult, Verdict};
use super::space::Space;
use crate::math::Vec3;
use crate::math::stats::quantile;
use crate::path::{Change, Mover};
use crate::scenario::{PersonMargin, Variant};

/// Standard deviations by which few repetitions must exceed the share before a path is refused early.
const SURELY: f64 = 2.33;
/// Distances by which base and worker are tried farther apart, m.
const TRIED_M: [f64; 5] = [0.05, 0.1, 0.15, 0.2, 0.3];

impl Prepared {
    /// Refuses a path on which too many of the selection's repetitions come too near. `is_all`: these are
    /// all of them; before that only a clear excess counts.
    pub(super) fn refuse_if_too_near(
        &mut self,
        bodies: &[&str],
        figures: &[Figures],
        (margin, is_all): (&PersonMargin, bool),
    ) {
        for (body, f) in bodies.iter().zip(figures).filter(|(_, f)| !f.near_m.is_empty()) {
            let count = f.near_m.len() as f64;
            let below = f.near_m.iter().filter(|d| **d < margin.margin_m).count() as f64 / count;
            let spread = (margin.share * (1.0 - margin.share) / count).sqrt();
            let slack = if is_all { 0.0 } else { SURELY * spread };
            if below > margin.share + slack {
                let p05 = quantile(&f.near_m, 0.05);
                self.severity = (margin.margin_m - p05).max(0.0);
                let nearest = f.nearest.as_ref().map(|n| n.1.clone());
                let refusal = too_near(body, nearest.unwrap_or_default(), (below, p05), margin);
                self.status.refuse(self.is_users, refusal);
                return;
            }
        }
    }
}

impl CandidateResult {
    /// Refuses (or marks, if it is the user's own) a path by the reported repetitions.
    pub(super) fn mark_if_too_near(&mut self, is_users: bool, margin: &PersonMargin) {
        let broken = |b: &&BodyScores| b.person_clearance.as_ref().is_some_and(|c| !c.is_kept());
        let Some(body) = self.bodies.iter().find(broken) else { return };
        let Some(c) = &body.person_clearance else { return };
        let nearest = [c.link.clone(), c.body_part.clone()];
        let refusal = too_near(&body.body, nearest, (c.share_below, c.p05_m), margin);
        let is_person = |v: &Refusal| v.by() == RefusedBy::Person;
        match &self.status {
            // Said already, from the repetitions of the selection.
            Status::Marked { violations } if violations.iter().any(is_person) => {}
            _ => self.status.refuse(is_users, refusal),
        }
    }
}

/// Puts into the verdict of a run in which all that could be simulated came too near: where the
/// nearest to feasible is too near, and how much farther apart robot and person would have to be.
pub(super) fn explain_nearness(
    environment: &Environment,
    refused: &[&Prepared],
    space: &Space,
    verdict: &mut Verdict,
) {
    let is_person = |p: &Prepared| p.status.refused_by() == Some(RefusedBy::Person);
    let near = refused.iter().filter(|p| is_person(p));
    let Some(closest) = near.min_by(|a, b| a.severity.total_cmp(&b.severity)) else { return };
    let changes = farther_apart(environment, space);
    verdict
        .hints
        .push(Hint::NearestToFeasible { id: closest.id.clone(), missing_m: closest.severity });
    let tried_m = TRIED_M[TRIED_M.len() - 1];
    verdict.hints.push(Hint::Apart { changes: changes.clone(), tried_m });
    verdict.changes.extend(changes);
}

/// The smallest of a few distances by which base or worker would have to move away.
fn farther_apart(environment: &Environment, space: &Space) -> Vec<Change> {
    let Some(straight) = space.named().into_iter().next() else { return Vec::new() };
    let nominal = &straight.variant;
    let [x, y] = nominal.at_m;
    let base = nominal.base.translation.vector;
    let apart = Vec3::new(base.x - x, base.y - y, 0.0);
    let Some(away) = apart.try_normalize(1e-6) else { return Vec::new() };
    let repetitions = environment.preset.rollouts_final.min(64);
    let is_enough = |variant: &Variant| {
        let prepared = environment.workshop.candidate(&straight.candidate, variant);
        if !prepared.is_feasible() {
            return false;
        }
        let block = (environment.seed, SELECTION_BLOCK);
        let figures = environment.figures(&prepared, block, 0..repetitions, Care::Selection);
        let margin = &environment.scenario.person_margin;
        figures.iter().all(|f| {
            let below = f.near_m.iter().filter(|d| **d < margin.margin_m).count() as f64;
            let lost = f.lost.iter().sum::<f64>();
            below <= margin.share * f.near_m.len() as f64 && 2.0 * lost < f.lost.len() as f64
        })
    };
    let robot = TRIED_M.into_iter().find(|by| {
        let mut moved = nominal.clone();
        moved.base.translation.vector += away * *by;
        is_enough(&moved)
    });
    let worker = TRIED_M.into_iter().find(|by| {
        let at_m = [x - away.x * by, y - away.y * by];
        is_enough(&Variant { at_m, ..nominal.clone() })
    });
    let change = |what, by: Option<f64>| by.map(|by_m| Change::MoveApart { what, by_m });
    let robot = change(Mover::Robot, robot);
    robot.into_iter().chain(change(Mover::Worker, worker)).collect()
}

/// The refusal: link and body part that are nearest, share of repetitions below the margin and 5th
/// percentile of the distance, m.
fn too_near(
    body: &str,
    [link, body_part]: [String; 2],
    (share_below, p05_m): (f64, f64),
    margin: &PersonMargin,
) -> Refusal {
    let (share_allowed, margin_m) = (margin.share, margin.margin_m);
    let body = body.to_owned();
    Refusal::Person { body, link, body_part, share_below, share_allowed, margin_m, p05_m }
}
