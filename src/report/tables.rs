//! The tables of a run: all candidates, and each reported path over time. Each is written as CSV and is a
//! sheet of the workbook.

use super::ReportError;
use super::view::View;
use crate::ergonomics::ScoringMethod;
use crate::path::Family;
use crate::planner::{
    BodyScores, CandidateResult, Evaluated, MethodScores, PathData, RolloutTable, Status,
};
use crate::words;

/// A cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Text(String),
    Number(f64),
    Empty,
}

/// A table with as many cells in each row as columns; units are in the names of the columns.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Table {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
}

impl Cell {
    /// Empty where there is no finite number.
    fn number(value: Option<f64>) -> Self {
        value.filter(|v| v.is_finite()).map_or(Self::Empty, Self::Number)
    }
}

impl Table {
    /// As CSV; numbers in their shortest form that reads back the same.
    pub(super) fn csv(&self) -> Result<Vec<u8>, ReportError> {
        let mut table = csv::Writer::from_writer(Vec::new());
        table.write_record(&self.columns)?;
        for row in &self.rows {
            table.write_record(row.iter().map(|cell| match cell {
                Cell::Text(text) => text.clone(),
                Cell::Number(value) => value.to_string(),
                Cell::Empty => String::new(),
            }))?;
        }
        table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
    }
}

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
pub(super) fn candidates(view: &View) -> Table {
    let own = ScoringMethod::ALL.into_iter().flat_map(columns);
    let header = FIRST.map(str::to_owned).into_iter().chain(own).chain(LAST.map(str::to_owned));
    let rows = view.result.candidates.iter().map(|c| row(c, view.scores(c)));
    Table { columns: header.collect(), rows: rows.collect() }
}

fn row(c: &CandidateResult, body: Option<&BodyScores>) -> Vec<Cell> {
    let number = Cell::number;
    let text = |t: String| if t.is_empty() { Cell::Empty } else { Cell::Text(t) };
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
        number(c.rank.map(|r| r as f64)),
        text(c.id.clone()),
        text(words::paths::path_name(c)),
        text(family_name(c.family).to_owned()),
        text(state.to_owned()),
        text(evaluated.to_owned()),
        number(c.objective),
        text(body.map(|b| b.body.clone()).unwrap_or_default()),
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
        text(why.join("; ")),
        text(words::refusal::reason(&c.status, &c.changes)),
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

/// `paths/<rank>.csv`: TCP and robot over time.
pub(super) fn path(data: &PathData) -> Table {
    let mut columns: Vec<String> =
        ["time_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"].map(str::to_owned).to_vec();
    if !data.robot_q.is_empty() {
        columns.extend(data.robot_joints.iter().map(|j| format!("{j}_rad")));
    }
    let row = |(i, (time, tcp)): (usize, (&f64, &[f64; 7]))| {
        let joints = data.robot_q.get(i).into_iter().flatten();
        let all = std::iter::once(time).chain(tcp).chain(joints);
        all.map(|v| Cell::Number(*v)).collect()
    };
    let rows = data.time_s.iter().zip(&data.tcp).enumerate().map(row).collect();
    Table { columns, rows }
}
