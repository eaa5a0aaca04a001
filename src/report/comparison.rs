//! Several runs side by side, from their `result.json`: `comparison.csv` and `comparison.html`.

use super::ReportError;
use super::page::document;
use super::style::{RULA_LEVELS, css};
use super::view::{change, percent, score};
use crate::planner::RESULT_SCHEMA;
use maud::{Markup, html};
use serde_json::Value;

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RowState {
    /// A path was found.
    Ok,
    /// No path keeps all limits; the most frequent reason.
    NoFeasiblePath(String),
    /// The run could not be made; why.
    Failed(String),
}

/// The best path's expected RULA minus another's, over the same people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Mean difference.
    pub mean: f64,
    /// Lower end of the 95 % interval.
    pub low95: f64,
    /// Upper end of the 95 % interval.
    pub high95: f64,
    /// Whether the interval leaves 0 out.
    pub clear: bool,
}

/// One run of a comparison: what can be read back from its `result.json`.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparisonRow {
    /// Name of the run: its folder or scenario.
    pub name: String,
    /// Name of the scenario, as it calls itself.
    pub scenario: String,
    /// Id of the best path.
    pub best: Option<String>,
    /// Body for which the best path scores worst.
    pub worst_body: Option<String>,
    /// Share of time at RULA 5 or more.
    pub exposure_rula_5: Option<f64>,
    /// Shares of time at each RULA score or above, index the score.
    pub rula_at_least: Vec<f64>,
    /// Expected RULA.
    pub expected_rula: Option<f64>,
    /// 5th percentile of the mean RULA of a repetition.
    pub p05_rula: Option<f64>,
    /// 95th percentile.
    pub p95_rula: Option<f64>,
    /// Expected REBA.
    pub expected_reba: Option<f64>,
    /// Expected RULA of the straight path for the same body.
    pub straight_rula: Option<f64>,
    /// Best minus straight.
    pub difference: Option<Difference>,
    /// Share of repetitions in which the hand cannot follow.
    pub reach_exceeded: Option<f64>,
    /// How the run ended.
    pub state: RowState,
    /// The words that stand in the verdict.
    pub caveat: Option<String>,
    /// SHA-256 of the scenario file.
    pub scenario_sha256: String,
    /// Version of ergopath.
    pub program_version: String,
    /// Seed.
    pub seed: Option<u64>,
}

impl ComparisonRow {
    /// A run that could not be made.
    pub fn failed(name: &str, reason: &str) -> Self {
        Self {
            name: name.to_owned(),
            scenario: String::new(),
            best: None,
            worst_body: None,
            exposure_rula_5: None,
            rula_at_least: Vec::new(),
            expected_rula: None,
            p05_rula: None,
            p95_rula: None,
            expected_reba: None,
            straight_rula: None,
            difference: None,
            reach_exceeded: None,
            state: RowState::Failed(reason.to_owned()),
            caveat: None,
            scenario_sha256: String::new(),
            program_version: String::new(),
            seed: None,
        }
    }

    /// Reads a run back; the error says what is missing.
    pub fn from_result_json(name: &str, result: &Value) -> Result<Self, String> {
        match result["schema"].as_str() {
            Some(RESULT_SCHEMA) => {}
            Some(other) => return Err(format!("schema is `{other}`, not `{RESULT_SCHEMA}`")),
            None => return Err(format!("has no schema; `{RESULT_SCHEMA}` is expected")),
        }
        let text = |pointer: &str| -> Result<String, String> {
            let found = result.pointer(pointer).and_then(Value::as_str);
            found.map(str::to_owned).ok_or_else(|| format!("`{pointer}` is missing"))
        };
        let mut row = Self {
            scenario: text("/setting/name")?,
            caveat: text("/verdict/caveat").ok(),
            scenario_sha256: text("/provenance/inputs/0/1")?,
            program_version: text("/provenance/program_version")?,
            seed: result["provenance"]["seed"].as_u64(),
            ..Self::failed(name, "")
        };
        let candidates = result["candidates"].as_array().ok_or("`/candidates` is missing")?;
        let Some(best) = result["verdict"]["best"].as_str() else {
            let reason = text("/verdict/lines/0").unwrap_or_else(|_| "no reason is stored".into());
            row.state = RowState::NoFeasiblePath(reason);
            return Ok(row);
        };
        let of = |id: &str| candidates.iter().find(|c| c["id"] == id);
        let found = of(best)
            .ok_or_else(|| format!("the best path `{best}` is not among the candidates"))?;
        let body =
            worst_body(found).ok_or_else(|| format!("the best path `{best}` has no scores"))?;
        let name_of_body = body["body"].as_str().unwrap_or_default();
        let at_least = body["rula"]["exposure"].as_array();
        row.rula_at_least = at_least.into_iter().flatten().filter_map(Value::as_f64).collect();
        row.exposure_rula_5 = row.rula_at_least.get(5).copied();
        row.expected_rula = body["rula"]["expected"].as_f64();
        row.p05_rula = body["rula"]["p05"].as_f64();
        row.p95_rula = body["rula"]["p95"].as_f64();
        row.expected_reba = body["reba"]["expected"].as_f64();
        row.reach_exceeded = body["reach_exceeded"].as_f64();
        let straight = of("straight").and_then(|c| c["bodies"].as_array());
        let straight = straight.into_iter().flatten().find(|b| b["body"] == name_of_body);
        row.straight_rula = straight.and_then(|b| b["rula"]["expected"].as_f64());
        row.difference = difference(result, name_of_body);
        row.best = Some(best.to_owned());
        row.worst_body = Some(name_of_body.to_owned());
        row.state = RowState::Ok;
        Ok(row)
    }

    fn state_words(&self) -> (&'static str, &str) {
        match &self.state {
            RowState::Ok => ("ok", ""),
            RowState::NoFeasiblePath(reason) => ("no feasible path", reason),
            RowState::Failed(reason) => ("failed", reason),
        }
    }
}

/// The scores of the body with the highest expected RULA.
fn worst_body(candidate: &Value) -> Option<&Value> {
    let expected = |b: &Value| b["rula"]["expected"].as_f64().unwrap_or(f64::NEG_INFINITY);
    candidate["bodies"].as_array()?.iter().max_by(|a, b| expected(a).total_cmp(&expected(b)))
}

fn difference(result: &Value, body: &str) -> Option<Difference> {
    let all = result["comparisons"].as_array()?;
    let d = &all.iter().find(|c| c["other"] == "straight" && c["body"] == body)?["rula"];
    Some(Difference {
        mean: d["mean"].as_f64()?,
        low95: d["low95"].as_f64()?,
        high95: d["high95"].as_f64()?,
        clear: d["clear"].as_bool()?,
    })
}

/// `comparison.csv` and `comparison.html`, sorted by expected RULA; runs without a path last.
pub fn comparison(rows: &[ComparisonRow]) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut sorted: Vec<&ComparisonRow> = rows.iter().collect();
    let key = |r: &ComparisonRow| r.expected_rula.unwrap_or(f64::INFINITY);
    sorted.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.name.cmp(&b.name)));
    Ok(vec![
        ("comparison.csv".to_owned(), table(&sorted)?),
        ("comparison.html".to_owned(), page(&sorted).into_bytes()),
    ])
}

const COLUMNS: [&str; 20] = [
    "name",
    "scenario",
    "state",
    "best",
    "worst_body",
    "exposure_rula_5",
    "expected_rula",
    "p05_rula",
    "p95_rula",
    "expected_reba",
    "straight_rula",
    "difference_rula",
    "difference_low95",
    "difference_high95",
    "reach_exceeded",
    "caveat",
    "scenario_sha256",
    "program_version",
    "seed",
    "reason",
];

fn table(rows: &[&ComparisonRow]) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    for r in rows {
        let (state, reason) = r.state_words();
        let number = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
        let text = |v: &Option<String>| v.clone().unwrap_or_default();
        table.write_record([
            r.name.clone(),
            r.scenario.clone(),
            state.to_owned(),
            text(&r.best),
            text(&r.worst_body),
            number(r.exposure_rula_5),
            number(r.expected_rula),
            number(r.p05_rula),
            number(r.p95_rula),
            number(r.expected_reba),
            number(r.straight_rula),
            number(r.difference.map(|d| d.mean)),
            number(r.difference.map(|d| d.low95)),
            number(r.difference.map(|d| d.high95)),
            number(r.reach_exceeded),
            text(&r.caveat),
            r.scenario_sha256.clone(),
            r.program_version.clone(),
            r.seed.map_or_else(String::new, |s| s.to_string()),
            reason.to_owned(),
        ])?;
    }
    table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}

fn page(rows: &[&ComparisonRow]) -> String {
    let (done, without): (Vec<&&ComparisonRow>, Vec<_>) =
        rows.iter().partition(|r| r.state == RowState::Ok);
    let mut caveats: Vec<&str> = done.iter().filter_map(|r| r.caveat.as_deref()).collect();
    caveats.sort_unstable();
    caveats.dedup();
    let intro = html! {
        h1 { "Comparison of " (rows.len()) " runs" }
        p { (done.len()) " with a path that keeps all limits, " (without.len()) " without." }
        @for caveat in caveats {
            @let n = done.iter().filter(|r| r.caveat.as_deref() == Some(caveat)).count();
            p.caveat { "Caution, " (n) " of " (done.len()) " runs: " (caveat) }
        }
    };
    let body = html! {
        @if !done.is_empty() {
            section aria-labelledby="h-runs" { h2 id="h-runs" { "Best path of each run" } (runs(&done)) }
        }
        @if !without.is_empty() {
            section aria-labelledby="h-without" { h2 id="h-without" { "Runs without a path" } (failures(&without)) }
        }
        section aria-labelledby="h-from" { h2 id="h-from" { "Where the runs come from" } (origins(rows)) }
    };
    document("Comparison of runs – ergopath", &intro, &body, &maud::html! {})
}

fn runs(rows: &[&&ComparisonRow]) -> Markup {
    let or = |v: Option<f64>, f: fn(f64) -> String| v.map_or_else(|| "–".to_owned(), f);
    html! {
        p.note {
            "Sorted by expected RULA of the body size that scores worst. Runs differ in scenario, so a lower \
             score says which arrangement is better only where task and duration are the same. 90 % band: nine of ten \
             repetitions lie within. 95 % interval: where the true mean difference lies, over the same simulated people."
        }
        p.note {
            "Bars, RULA action levels from left to right: "
            @for l in RULA_LEVELS { (l.number) " " (l.words) @if l.number < 4 { ", " } @else { "." } }
        }
        div.scroll tabindex="0" role="region" aria-label="Runs" { table {
            thead { tr {
                th scope="col" { "Run" }
                th scope="col" { "Best path" }
                th scope="col" { "Time at each action level" }
                th.n scope="col" { "Level 3+" }
                th.n scope="col" { "Expected RULA" span.small { "90 % band" } }
                th.n scope="col" { "Expected REBA" }
                th.n scope="col" { "Straight path RULA" }
                th.n scope="col" { "Best against straight" span.small { "95 % interval" } }
                th.n scope="col" { "Out of reach" }
            } }
            tbody { @for r in rows { tr {
                th scope="row" { (r.name) span.small { (r.scenario) } }
                td { (r.best.as_deref().unwrap_or("–")) span.small { (r.worst_body.as_deref().unwrap_or("")) } }
                td { (bar(r)) }
                td.n { (or(r.exposure_rula_5, percent)) }
                td.n { (or(r.expected_rula, score)) span.small { (or(r.p05_rula, score)) " to " (or(r.p95_rula, score)) } }
                td.n { (or(r.expected_reba, score)) }
                td.n { (or(r.straight_rula, score)) }
                td.n {
                    @if let Some(d) = r.difference {
                        @if d.clear { (change(d.mean)) } @else { "no clear difference" }
                        span.small { (change(d.low95)) " to " (change(d.high95)) }
                    } @else if r.best.as_deref() == Some("straight") { "is the straight path" } @else { "–" }
                }
                td.n { (or(r.reach_exceeded, percent)) }
            } } }
        } }
    }
}

/// A stacked bar with its numbers as text.
fn bar(row: &ComparisonRow) -> Markup {
    let shares = RULA_LEVELS.map(|l| (l, l.share(&row.rula_at_least)));
    html! {
        div.bar aria-hidden="true" {
            @for (level, share) in shares {
                @if share > 0.0 {
                    span style={ "width:" (format!("{:.2}", 100.0 * share)) "%;background:" (css(level.color)) } {}
                }
            }
        }
        span.small {
            @for (level, share) in shares { (level.number) ": " (percent(share)) @if level.number < 4 { ", " } }
        }
    }
}

fn failures(rows: &[&&ComparisonRow]) -> Markup {
    html! {
        table {
            thead { tr { th scope="col" { "Run" } th scope="col" { "State" } th scope="col" { "Reason" } } }
            tbody { @for r in rows {
                @let (state, reason) = r.state_words();
                tr { th scope="row" { (r.name) } td { (state) } td { (super::page::ticked(reason)) } }
            } }
        }
    }
}

fn origins(rows: &[&ComparisonRow]) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="Origins" { table {
            thead { tr {
                th scope="col" { "Run" } th scope="col" { "ergopath" } th.n scope="col" { "Seed" }
                th scope="col" { "SHA-256 of the scenario" }
            } }
            tbody { @for r in rows { tr {
                th scope="row" { (r.name) }
                td { (r.program_version) }
                td.n { (r.seed.map_or_else(String::new, |s| s.to_string())) }
                td { @if !r.scenario_sha256.is_empty() { code { (r.scenario_sha256) } } }
            } } }
        } }
        p.note { "Scores: RULA (McAtamney & Corlett 1993) and REBA (Hignett & McAtamney 2000)." }
    }
}
