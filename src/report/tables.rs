//! The tables of a run as CSV: all candidates, and each reported path over time.

use super::ReportError;
use super::view::worst_body;
use crate::path::Family;
use crate::planner::{CandidateResult, Evaluated, PathData, RolloutTable, RunResult, Status};
use crate::words::refusal::reason;

const COLUMNS: [&str; 15] = [
    "rank",
    "id",
    "family",
    "state",
    "evaluated",
    "expected_rula",
    "expected_reba",
    "exposure_rula_5",
    "exposure_reba_8",
    "cvar90_rula",
    "reach_exceeded",
    "se_expected_rula",
    "p05_rula",
    "p95_rula",
    "reason",
];

/// `candidates.csv`: the worst body of each path.
pub(super) fn candidates(result: &RunResult) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    for candidate in &result.candidates {
        table.write_record(row(candidate))?;
    }
    table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}

fn row(c: &CandidateResult) -> [String; 15] {
    let body = worst_body(c);
    let number =
        |v: Option<f64>| v.filter(|v| v.is_finite()).map_or_else(String::new, |v| v.to_string());
    let state = match &c.status {
        Status::Feasible => "feasible",
        Status::Marked { .. } => "marked",
        Status::Infeasible { .. } => "infeasible",
    };
    let evaluated = match c.evaluated {
        Evaluated::None => "none",
        Evaluated::Search => "search",
        Evaluated::Reported => "reported",
    };
    [
        c.rank.map_or_else(String::new, |r| r.to_string()),
        c.id.clone(),
        family_name(c.family).to_owned(),
        state.to_owned(),
        evaluated.to_owned(),
        number(body.map(|b| b.rula.expected)),
        number(body.map(|b| b.reba.expected)),
        number(body.and_then(|b| b.rula.exposure.get(5).copied())),
        number(body.and_then(|b| b.reba.exposure.get(8).copied())),
        number(body.map(|b| b.rula.cvar90)),
        number(body.map(|b| b.reach_exceeded)),
        number(body.and_then(|b| b.rula.standard_error)),
        number(body.map(|b| b.rula.p05)),
        number(body.map(|b| b.rula.p95)),
        reason(&c.status, &c.changes),
    ]
}

/// A family's name as in `result.json`.
fn family_name(family: Family) -> &'static str {
    match family {
        Family::Straight => "straight",
        Family::Lifted => "lifted",
        Family::Lowered => "lowered",
        Family::TowardBody => "toward_body",
        Family::Away => "away",
        Family::Sampled => "sampled",
        Family::Drawn => "drawn",
        Family::ExpertArc => "expert_arc",
        Family::Shortest => "shortest",
        Family::BestRandom => "best_random",
        Family::SinglePosturePlain => "single_posture_plain",
        Family::SinglePostureLearned => "single_posture_learned",
        Family::Held => "held",
    }
}

/// `rollouts/<rank>.csv`: rollout (from 1), time and joint angles, a row for each sample.
pub(super) fn rollouts(table: &RolloutTable) -> Result<Vec<u8>, ReportError> {
    let mut out = csv::Writer::from_writer(Vec::new());
    let joints = table.joints.iter().map(|j| format!("{j}_rad"));
    out.write_record(["rollout".to_owned(), "time_s".to_owned()].into_iter().chain(joints))?;
    for (r, walk) in table.q.iter().enumerate() {
        for (t, q) in table.time_s.iter().zip(walk) {
            let head = [(r + 1).to_string(), t.to_string()];
            out.write_record(head.into_iter().chain(q.iter().map(f64::to_string)))?;
        }
    }
    out.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}

/// `paths/<rank>.csv`: numbers in their shortest form that reads back the same.
pub(super) fn path(data: &PathData) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let mut header: Vec<String> =
        ["time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"].map(str::to_owned).to_vec();
    if !data.robot_q.is_empty() {
        header.extend(data.robot_joints.iter().map(|j| format!("{j}_rad")));
    }
    table.write_record(&header)?;
    for (i, (time, tcp)) in data.time_s.iter().zip(&data.tcp).enumerate() {
        let mut row: Vec<String> = vec![time.to_string()];
        row.extend(tcp.iter().map(f64::to_string));
        row.extend(data.robot_q.get(i).into_iter().flatten().map(f64::to_string));
        table.write_record(&row)?;
    }
    table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}
