//! The files of the paper's experiments: tables, figures and JSON.

use super::ReportError;
use super::figure_box::{BoxPanel, box_plots};
use super::figure_horizon::horizon_figure;
use super::figure_spread::spread_figure;
use super::figure_weight_sets::weights_over_sets;
use super::paper_page::{ChainDrawings, page};
use crate::posture::Method;
use crate::training::Bands;
use crate::training::paper::{ChainResult, MovementScore, PaperResult, PostureSpread, SCORES};

const COLUMNS: [&str; 15] = [
    "person",
    "task",
    "method",
    "movement",
    "frames",
    "ll_q_nats",
    "ll_null_nats",
    "surprise",
    "rmse_q_rad_s",
    "relative_rmse_q",
    "ll_x_nats",
    "rmse_x_m_s",
    "inside_50",
    "inside_90",
    "taught_by_movements",
];

/// A page, tables, figures and `<experiment>.json`, as (name, bytes).
///
/// # Errors
/// Where a file cannot be made.
pub fn paper_files(result: &PaperResult) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let name = result.experiment.name();
    let json = serde_json::to_string_pretty(result)? + "\n";
    let mut files = vec![(format!("{name}.json"), json.into_bytes())];
    let mut drawings = Vec::new();
    for chain in &result.chains {
        let key = chain.chain.name();
        let drawn = drawn(chain, result.simulated)?;
        let said = |bytes: Vec<u8>| told(result.simulated, &bytes);
        files.push((format!("{key}/scores.csv"), said(scores(chain)?)));
        files.push((format!("{key}/weights.csv"), said(weights(chain)?)));
        files.push((format!("{key}/horizon.csv"), said(horizon(chain)?)));
        for spread in &chain.spreads {
            let method = spread.method.name();
            files.push((format!("{key}/spread-{method}.csv"), said(spread_table(spread)?)));
        }
        files.extend(pictures(key, &drawn));
        drawings.push(drawn);
    }
    files.push(("experiment.html".to_owned(), page(result, &drawings).into_bytes()));
    Ok(files)
}

fn drawn(chain: &ChainResult, is_simulated: bool) -> Result<ChainDrawings, ReportError> {
    let spreads: Result<Vec<(Method, Vec<u8>)>, ReportError> = chain
        .spreads
        .iter()
        .map(|spread| Ok((spread.method, spread_figure(spread, is_simulated)?)))
        .collect();
    Ok(ChainDrawings {
        methods: box_plots(&panels(chain))?,
        coverage: box_plots(&coverages(chain))?,
        horizon: horizon_figure(chain, is_simulated)?,
        weights: weights_over_sets(chain, is_simulated)?,
        spreads: spreads?,
    })
}

/// The pictures of a chain as files.
fn pictures(key: &str, drawn: &ChainDrawings) -> Vec<(String, Vec<u8>)> {
    let single = [
        ("methods", Some(&drawn.methods)),
        ("coverage", Some(&drawn.coverage)),
        ("horizon", Some(&drawn.horizon)),
        ("weights", drawn.weights.as_ref()),
    ];
    let single = single.into_iter().filter_map(|(name, png)| Some((name.to_owned(), png?)));
    let spreads = drawn.spreads.iter().map(|(m, png)| (format!("spread-{}", m.name()), png));
    single.chain(spreads).map(|(name, png)| (format!("{key}/{name}.png"), png.clone())).collect()
}

/// Whoever reads a table of simulated people is told.
fn told(simulated: bool, table: &[u8]) -> Vec<u8> {
    let mark: &[u8] = if simulated { b"# simulated people: nobody was recorded\n" } else { b"" };
    [mark, table].concat()
}

/// One measure of all held-out movements, by method; without those that are `left_out`.
fn panel(
    chain: &ChainResult,
    (title, unit, is_error): (&str, &str, bool),
    left_out: Option<Method>,
    pick: fn(&MovementScore) -> f64,
) -> BoxPanel {
    let of = |m: usize| {
        let movements = chain.sets.iter().flat_map(|s| &s.methods[m].movements);
        movements.map(pick).collect::<Vec<f64>>()
    };
    let methods = chain.methods.iter().enumerate().filter(|(_, s)| Some(s.method) != left_out);
    BoxPanel {
        title: title.to_owned(),
        unit: unit.to_owned(),
        is_error,
        methods: methods.map(|(m, s)| (s.method.name().to_owned(), of(m))).collect(),
    }
}

/// The paper's figure: likelihoods and errors. A law that does not meet the task has likelihoods so low that the
/// others could not be told apart beside it.
fn panels(chain: &ChainResult) -> Vec<BoxPanel> {
    let direct = Some(Method::Gp).filter(|gp| chain.methods.iter().any(|m| m.method == *gp));
    let without = if direct.is_some() { ", without gp" } else { "" };
    let nats = |of: &str| format!("Log-likelihood of the {of} velocity{without}");
    vec![
        panel(chain, (&nats("joint"), "nats per frame", false), direct, |s| s.ll_q),
        panel(chain, ("RMSE of the joint velocity over its rms", "no unit", true), None, |s| {
            s.relative_rmse_q
        }),
        panel(chain, (&nats("task"), "nats per frame", false), direct, |s| s.ll_x),
        panel(chain, ("RMSE of the task velocity", "m/s, rad/s", true), None, |s| s.rmse_x),
    ]
}

/// Shares inside the bands of predicted velocities, and of repetitions where these were asked for.
fn coverages(chain: &ChainResult) -> Vec<BoxPanel> {
    let percent = |title| (title, "%", false);
    let mut panels = vec![
        panel(chain, percent("Joint velocities inside the 50 % band"), None, |s| {
            100.0 * s.velocity_coverage[0]
        }),
        panel(chain, percent("Joint velocities inside the 90 % band"), None, |s| {
            100.0 * s.velocity_coverage[1]
        }),
    ];
    let bands = |title: &str, pick: fn(&Bands) -> f64| {
        let of = |m: usize| -> Vec<f64> {
            chain.sets.iter().filter_map(|s| s.methods[m].bands.as_ref()).map(pick).collect()
        };
        let banded = chain.methods.iter().enumerate().filter(|(_, m)| m.bands.is_some());
        BoxPanel {
            title: title.to_owned(),
            unit: "%, by training set".to_owned(),
            is_error: false,
            methods: banded.map(|(m, s)| (s.method.name().to_owned(), of(m))).collect(),
        }
    };
    if chain.methods.iter().any(|m| m.bands.is_some()) {
        panels.push(bands("Joint angles inside the 50 % band", |b| 100.0 * b.coverage_50));
        panels.push(bands("Joint angles inside the 90 % band", |b| 100.0 * b.coverage_90));
    }
    panels
}

fn finished(table: csv::Writer<Vec<u8>>) -> Result<Vec<u8>, ReportError> {
    table.into_inner().map_err(|e| ReportError::Table(e.into_error().into()))
}

/// A row for each method and held-out movement.
fn scores(chain: &ChainResult) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(COLUMNS)?;
    for set in &chain.sets {
        for own in &set.methods {
            for s in &own.movements {
                let numbers = [
                    s.ll_q,
                    s.ll_null,
                    s.surprise,
                    s.rmse_q,
                    s.relative_rmse_q,
                    s.ll_x,
                    s.rmse_x,
                    s.velocity_coverage[0],
                    s.velocity_coverage[1],
                ];
                let mut row = vec![
                    set.who.clone(),
                    set.task.clone(),
                    own.method.name().to_owned(),
                    s.movement.clone(),
                    s.frames.to_string(),
                ];
                row.extend(numbers.iter().map(f64::to_string));
                row.push(set.train.movements.to_string());
                table.write_record(row)?;
            }
        }
    }
    finished(table)
}

/// The diagonal of W over its geometric mean: a row for each set and method, a column for each joint.
fn weights(chain: &ChainResult) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let joints = chain.joints.iter().map(String::as_str);
    table.write_record(["person", "task", "method"].into_iter().chain(joints))?;
    for set in &chain.sets {
        for own in &set.methods {
            let Some(weights) = &own.weights else { continue };
            let mut row = vec![set.who.clone(), set.task.clone(), own.method.name().to_owned()];
            row.extend(weights.iter().map(f64::to_string));
            table.write_record(row)?;
        }
    }
    finished(table)
}

fn horizon(chain: &ChainResult) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(["method", "horizon_s", "movements", "hand_mm", "joints_deg"])?;
    for curve in &chain.horizon {
        for p in &curve.points {
            table.write_record([
                curve.method.to_owned(),
                p.horizon_s.to_string(),
                p.movements.to_string(),
                p.hand_mm.to_string(),
                p.joints_deg.to_string(),
            ])?;
        }
    }
    finished(table)
}

/// Four scores over time: recorded, and quantiles of the sampled trajectories.
fn spread_table(spread: &PostureSpread) -> Result<Vec<u8>, ReportError> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table
        .write_record(["score", "time_s", "recorded", "p05", "p25", "p50", "p75", "p95", "mean"])?;
    for (name, curve) in SCORES.iter().zip(&spread.scores) {
        for (t, time_s) in spread.time_s.iter().enumerate() {
            let quantiles = curve.quantiles.iter().map(|q| q[t]);
            let numbers = [*time_s, curve.recorded[t]].into_iter().chain(quantiles);
            let mut row = vec![(*name).to_owned()];
            row.extend(numbers.chain([curve.mean[t]]).map(|v| v.to_string()));
            table.write_record(row)?;
        }
    }
    finished(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Body, Side};
    use crate::training::paper::{
        Chain, PaperExperiment, PaperQuestion, Performer, Task, run_paper, training_sets,
    };
    use crate::training::{SimulatedMovements, TrainSettings};
    use std::path::Path;

    #[test]
    fn everything_is_written_alike_twice() {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let source = SimulatedMovements::new(&body, Side::Right, true, 5).unwrap();
        let reaches = source.first(4).unwrap();
        let repetitions = reaches.iter().map(|r| r.sparse_trial("reach".to_owned())).collect();
        let tasks = vec![Task { name: "reach".to_owned(), is_primitive: true, repetitions }];
        let side = Side::Right;
        let person = Performer { name: "1".to_owned(), body, side, is_seated: false, tasks };
        let question = PaperQuestion {
            experiment: PaperExperiment::Exp1,
            simulated: true,
            by_others: false,
            chains: Chain::ALL.to_vec(),
            methods: vec![Method::FullW, Method::Gp],
            banded: vec![Method::FullW],
        };
        let sets = training_sets(question.experiment, &[person], false).unwrap();
        let settings = TrainSettings { search_samples: 40, ..TrainSettings::default() };
        let result = run_paper(&sets, &question, &settings, &|_, _| true).unwrap().unwrap();
        let files = paper_files(&result).unwrap();
        assert_eq!(files, paper_files(&result).unwrap());
        let named = |name: &str| &files.iter().find(|(own, _)| own == name).unwrap().1;
        for chain in ["arm", "whole"] {
            for picture in ["methods", "coverage", "horizon", "weights", "spread-full-w"] {
                assert_eq!(&named(&format!("{chain}/{picture}.png"))[1..4], b"PNG");
            }
            for table in ["scores", "weights", "horizon", "spread-full-w"] {
                let text = String::from_utf8(named(&format!("{chain}/{table}.csv")).clone());
                assert!(text.unwrap().starts_with("# simulated people"), "{table}");
            }
        }
        let page = String::from_utf8(named("experiment.html").clone()).unwrap();
        for part in ["EXP1", "nobody was recorded", "24 joints", "30 coordinates", "Fig. 5"] {
            assert!(page.contains(part), "{part}");
        }
        assert!(named("exp1.json").starts_with(b"{"));
    }
}
