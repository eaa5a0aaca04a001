//! `shift.csv`: minutes at each action level, of the whole shift and of each task, for each body and method.

use super::ReportError;
use crate::ergonomics::ScoringMethod;
use crate::shift::{Dose, ShiftResult};

const COLUMNS: [&str; 15] = [
    "shift",
    "body",
    "is_worst_body",
    "method",
    "part",
    "level",
    "cycles",
    "task_min",
    "movement_min",
    "at_min",
    "at_or_above_min",
    "at_or_above_low95_min",
    "at_or_above_high95_min",
    "at_or_above_p05_min",
    "at_or_above_p95_min",
];

/// The table: the whole shift first, then its tasks.
pub(super) fn table(result: &ShiftResult) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    let text = |v: f64| v.to_string();
    let spread = |d: Option<&Dose>| -> Vec<String> {
        let ends = |pair: Option<[f64; 2]>| {
            pair.map_or_else(|| [String::new(), String::new()], |p| p.map(text))
        };
        let [low, high] = ends(d.and_then(|d| d.interval95_min));
        let [p05, p95] = ends(d.and_then(|d| d.band90_min));
        vec![low, high, p05, p95]
    };
    for (k, body) in result.bodies.iter().enumerate() {
        for m in ScoringMethod::ALL {
            let head = |part: &str, level: u8| -> Vec<String> {
                vec![
                    result.name.clone(),
                    body.body.clone(),
                    (k == result.worst).to_string(),
                    m.key().to_owned(),
                    part.to_owned(),
                    level.to_string(),
                ]
            };
            let dose = &body.methods[m];
            for l in &dose.levels {
                let mut row = head("shift", l.level);
                row.push(String::new());
                row.push(text(result.time.shift_min));
                row.push(text(result.time.scored_min));
                row.push(text(l.at_min));
                row.push(text(l.at_least.mean_min));
                row.extend(spread(Some(&l.at_least)));
                table.write_record(row)?;
            }
            for (t, facts) in dose.tasks.iter().zip(&result.tasks) {
                for (i, l) in dose.levels.iter().enumerate() {
                    let above: f64 = t.at_min.iter().skip(i).sum();
                    let mut row = head(&format!("task {}", facts.name), l.level);
                    row.push(text(facts.cycles));
                    row.push(text(facts.minutes));
                    row.push(text(facts.moving_min));
                    row.push(text(t.at_min.get(i).copied().unwrap_or(0.0)));
                    row.push(text(above));
                    row.extend(spread((l.level == 3).then_some(&t.high)));
                    table.write_record(row)?;
                }
            }
        }
    }
    table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}
