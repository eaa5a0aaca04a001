//! `comparison.csv`: a row for each path of each body of each run.

use super::ReportError;
use super::comparison::{ComparedBody, ComparedPath, ComparedRun, Comparison, Role};

const COLUMNS: [&str; 27] = [
    "name",
    "scenario",
    "state",
    "body",
    "is_worst_body",
    "role",
    "path",
    "exposure_rula_5",
    "exposure_rula_5_p05",
    "exposure_rula_5_p95",
    "expected_rula",
    "p05_rula",
    "p95_rula",
    "cvar90_rula",
    "expected_reba",
    "reach_exceeded",
    "best_minus_this",
    "best_minus_this_low95",
    "best_minus_this_high95",
    "against",
    "minus_against",
    "minus_against_low95",
    "minus_against_high95",
    "minus_against_pairing",
    "caveat",
    "seed",
    "reason",
];

/// The table, runs by rank.
pub(super) fn table(comparison: &Comparison) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    for run in comparison.ranked() {
        if run.bodies.is_empty() {
            table.write_record(row(comparison, run, None))?;
        }
        for (k, body) in run.bodies.iter().enumerate() {
            for path in &body.paths {
                let of = (body, run.worst == Some(k), path);
                table.write_record(row(comparison, run, Some(of)))?;
            }
        }
    }
    table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}

fn row(
    comparison: &Comparison,
    run: &ComparedRun,
    of: Option<(&ComparedBody, bool, &ComparedPath)>,
) -> [String; COLUMNS.len()] {
    let (state, reason) = run.state_words();
    let path = of.map(|(_, _, p)| p);
    let number = |f: fn(&ComparedPath) -> f64| path.map_or_else(String::new, |p| f(p).to_string());
    let own = path.and_then(|p| p.best_minus_this);
    // The runs are compared by their best paths.
    let other =
        of.filter(|(_, _, p)| p.role == Role::Best).and_then(|(b, _, _)| b.against.as_ref());
    let text = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let pairing = other.map(|d| match &d.unpaired_because {
        None => "paired".to_owned(),
        Some(why) => format!("unpaired: {why}"),
    });
    let role = path.map_or("", |p| match p.role {
        Role::Best => "best",
        Role::Straight => "straight",
        Role::Own => "own",
    });
    [
        run.name.clone(),
        run.scenario.clone(),
        state.to_owned(),
        of.map(|(b, _, _)| b.body.clone()).unwrap_or_default(),
        of.map(|(_, worst, _)| worst.to_string()).unwrap_or_default(),
        role.to_owned(),
        path.map(|p| p.id.clone()).unwrap_or_default(),
        number(|p| p.exposure_rula_5[0]),
        number(|p| p.exposure_rula_5[1]),
        number(|p| p.exposure_rula_5[2]),
        number(|p| p.expected_rula),
        number(|p| p.p05_rula),
        number(|p| p.p95_rula),
        number(|p| p.cvar90_rula),
        number(|p| p.expected_reba),
        number(|p| p.reach_exceeded),
        text(own.map(|d| d.mean)),
        text(own.map(|d| d.low95)),
        text(own.map(|d| d.high95)),
        other.and(comparison.against.clone()).unwrap_or_default(),
        text(other.map(|d| d.mean)),
        text(other.map(|d| d.low95)),
        text(other.map(|d| d.high95)),
        pairing.unwrap_or_default(),
        run.caveat.clone().unwrap_or_default(),
        run.seed.map_or_else(String::new, |s| s.to_string()),
        reason.to_owned(),
    ]
}
