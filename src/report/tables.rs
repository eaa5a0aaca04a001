//! The tables of a run as CSV: all candidates, and each reported path over time.

use super::ReportError;
use super::view::View;
use crate::ergonomics::ScoringMethod;
use crate::path::Family;
use crate::planner::{
    BodyScores, CandidateResult, Evaluated, MethodScores, PathData, RolloutTable, Status,
};
use crate::words;

/// Columns before and after those of the scoring methods.
const FIRST: [&str; 8] =
    ["rank", "id", "name", "family", "state", "evaluated", "objective", "body"];
const LAST: [&str; 6] = [
    "reach_exceeded",
    "hand_travel_m",
    "hand_speed_max_m_s",
    "hand_acceleration_max_m_s2",
    "not_best_because",
    "reason",
];

/// Columns of a scoring method.
fn columns(method: ScoringMethod) -> [String; 8] {
    let (key, high) = (method.key(), method.high());
    [
        format!("expected_{key}"),
        format!("se_expected_{key}"),
        format!("p05_{key}"),
        format!("p95_{key}"),
        format!("cvar90_{key}"),
        format!("exposure_{key}_{high}"),
        format!("{key}_per_metre"),
        format!("peak_{key}"),
    ]
}

/// `candidates.csv`: each path for the body of the verdict, which is named.
pub(super) fn candidates(view: &View) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let own = ScoringMethod::ALL.into_iter().flat_map(columns);
    let header = FIRST.map(str::to_owned).into_iter().chain(own).chain(LAST.map(str::to_owned));
    table.write_record(header)?;
    for candidate in &view.result.candidates {
        table.write_record(row(candidate, view.scores(candidate)))?;
    }
    table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}

fn row(c: &CandidateResult, body: Option<&BodyScores>) -> Vec<String> {
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
    let mut row = vec![
        c.rank.map_or_else(String::new, |r| r.to_string()),
        c.id.clone(),
        words::paths::path_name(c),
        family_name(c.family).to_owned(),
        state.to_owned(),
        evaluated.to_owned(),
        number(c.objective),
        body.map(|b| b.body.clone()).unwrap_or_default(),
    ];
    for method in ScoringMethod::ALL {
        let s = body.map(|b| &b.scores[method]);
        let of = |f: fn(&MethodScores) -> f64| number(s.map(f));
        row.extend([
            of(|s| s.distribution.expected),
            number(s.and_then(|s| s.distribution.standard_error)),
            of(|s| s.distribution.p05),
            of(|s| s.distribution.p95),
            of(|s| s.distribution.cvar90),
            of(|s| s.high_band[0]),
            of(|s| s.per_metre),
            of(|s| s.peak),
        ]);
    }
    let hand = c.path.as_ref().map(|p| &p.hand);
    let why: Vec<String> = c.bought.iter().map(words::paths::bought).collect();
    row.extend([
        number(body.map(|b| b.reach_exceeded)),
        number(hand.map(|h| h.travel_m)),
        number(hand.map(|h| h.speed_m_s)),
        number(hand.and_then(|h| h.acceleration_m_s2)),
        why.join("; "),
        words::refusal::reason(&c.status, &c.changes),
    ]);
    row
}

/// A family's name as in `result.json`.
fn family_name(family: Family) -> &'static str {
    match family {
        Family::Straight => "straight",
        Family::StraightRetimed => "straight_retimed",
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

/// `rollouts/<rank>.csv`: rollout (from 1), time, pelvis and joint angles, a row for each sample.
pub(super) fn rollouts(table: &RolloutTable) -> Result<Vec<u8>, ReportError> {
    let mut out = csv::Writer::from_writer(Vec::new());
    let columns = table.columns.iter().cloned();
    out.write_record(["rollout".to_owned(), "time_s".to_owned()].into_iter().chain(columns))?;
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
