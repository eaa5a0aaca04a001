//! What `ergopath evaluate` shows: tables, or JSON.

use super::evaluate_data::Problem;
use crate::training::{Evaluation, GroupScore, MethodScore, Percentiles, RolloutScore};
use crate::words::number::percent;
use comfy_table::{CellAlignment, Table, presets};
use serde_json::{Value, json};

/// Geometric mean of weights over splits and files, scaled to mean 1.
fn weights(score: &MethodScore) -> Option<Vec<f64>> {
    let n = score.weights.first()?.len();
    let count = score.weights.len() as f64;
    let mean = |i: usize| score.weights.iter().map(|w| w[i].ln()).sum::<f64>() / count;
    let w: Vec<f64> = (0..n).map(|i| mean(i).exp()).collect();
    let scale = w.iter().sum::<f64>() / n as f64;
    Some(w.into_iter().map(|v| v / scale).collect())
}

pub(super) fn as_json(
    problems: &[Problem],
    judged: &[Evaluation],
    merged: &[MethodScore],
) -> Value {
    let figure = |s: &MethodScore, pick: fn(&GroupScore) -> f64| json!(s.spread(pick));
    let methods: Vec<Value> = merged
        .iter()
        .enumerate()
        .map(|(i, s)| {
            let walk = |pick: fn(&RolloutScore) -> f64| {
                json!(Percentiles::of(&s.rollouts.iter().map(pick).collect::<Vec<_>>()))
            };
            let rollout = (!s.rollouts.is_empty()).then(|| {
                json!({
                    "path_error_deg": walk(|r| r.path_error_deg),
                    "pulled_path_error_deg": walk(|r| r.pulled_path_error_deg),
                    "per_metre_path_error_deg": walk(|r| r.rule_error_deg.0),
                    "per_second_path_error_deg": walk(|r| r.rule_error_deg.1),
                    "rest_deg_s": walk(|r| r.rest_deg_s.0),
                    "recorded_rest_deg_s": recorded_rest(&s.rollouts),
                    "drift_deg": walk(|r| r.drift_deg.0),
                    "pulled_drift_deg": walk(|r| r.drift_deg.1),
                    "coverage_50": walk(|r| r.bands.coverage_50),
                    "coverage_90": walk(|r| r.bands.coverage_90),
                    "end_coverage_90": walk(|r| r.bands.end_coverage_90),
                    "width_90_deg": walk(|r| r.bands.width_90_deg),
                    "trajectory_ll": walk(|r| r.trajectory_ll),
                    "calibration": walk(|r| r.calibration),
                    "reach_exceeded_share": walk(|r| r.reach_exceeded_share),
                })
            });
            json!({
                "method": s.method.name(),
                "ll_q": figure(s, |g| g.ll_q),
                "rmse_q": figure(s, |g| g.rmse_q),
                "relative_rmse_q": figure(s, |g| g.relative_rmse_q),
                "ll_null": figure(s, |g| g.ll_null),
                "ll_x": figure(s, |g| g.ll_x),
                "rmse_x": figure(s, |g| g.rmse_x),
                "w": weights(s),
                "w_uncertainty": s.uncertainty,
                "rollout": rollout,
                "train_s": s.train_s,
                "predict_s": s.predict_s,
                "note": s.note,
                "trials": trials_json(problems, judged, i),
            })
        })
        .collect();
    let sets: Vec<Value> = problems
        .iter()
        .map(|p| {
            json!({
                "source": p.name,
                "rows": p.dataset.frames.len(),
                "trajectories": p.dataset.trials,
                "joints": p.dataset.joints,
                "split": p.split,
                "step_s": p.step.map(|s| s.0),
                "step_known": p.step.map(|s| s.1),
            })
        })
        .collect();
    json!({
        "methods": methods,
        "data": sets,
        "task_sd": judged.first().map(|j| j.task_sd.clone()),
        "null_floor_rad_s": judged.first().map(|j| j.null_floor_rad_s),
    })
}

/// The i-th method on each held-out trial of each split.
fn trials_json(problems: &[Problem], judged: &[Evaluation], i: usize) -> Vec<Value> {
    let of = |(problem, evaluation): (&Problem, &Evaluation)| -> Vec<Value> {
        let groups = evaluation.methods.get(i).map_or(&[][..], |s| &s.groups);
        let one = |g: &GroupScore| {
            json!({
                "trial": problem.trials.get(g.trial),
                "rows": g.rows,
                "ll_q": g.ll_q,
                "rmse_q": g.rmse_q,
                "relative_rmse_q": g.relative_rmse_q,
                "ll_null": g.ll_null,
                "walk": g.walk,
            })
        };
        groups.iter().map(one).collect()
    };
    problems.iter().zip(judged).flat_map(of).collect()
}

/// Most held-out trials that are listed as text.
const MOST_LISTED: usize = 40;

/// A figure of each method on each held-out trial, a row each; none where nothing is held out but one.
fn by_trial(
    problems: &[Problem],
    judged: &[Evaluation],
    digits: usize,
    pick: fn(&GroupScore) -> Option<f64>,
) -> Table {
    let names = judged.first().map_or(&[][..], |j| &j.methods);
    let mut header = vec!["held out", "rows"];
    header.extend(names.iter().map(|s| s.method.name()));
    let mut table = table_of(&header);
    for (problem, evaluation) in problems.iter().zip(judged) {
        let Some(first) = evaluation.methods.first() else { continue };
        for (row, group) in first.groups.iter().enumerate() {
            let name = problem.trials.get(group.trial).cloned().unwrap_or_default();
            let figure = |s: &MethodScore| {
                let own = s.groups.get(row).filter(|g| g.trial == group.trial);
                own.and_then(pick).map_or_else(|| "-".to_owned(), |v| number(v, digits))
            };
            let cells = evaluation.methods.iter().map(figure);
            table.add_row([name, group.rows.to_string()].into_iter().chain(cells));
        }
    }
    align(&mut table);
    table
}

fn print_by_trial(problems: &[Problem], judged: &[Evaluation], count: usize, has_rollouts: bool) {
    if count < 2 {
        return;
    }
    if count > MOST_LISTED {
        say!("\n{count} held-out trials; --json lists each.");
        return;
    }
    let table =
        |digits, pick: fn(&GroupScore) -> Option<f64>| by_trial(problems, judged, digits, pick);
    say!("\nBy held-out trial, RMSE of the joint velocity over its rms:");
    say!("{}", table(3, |g| Some(g.relative_rmse_q)));
    if has_rollouts {
        say!("\nMean joint error along the path with the pull, deg:");
        say!("{}", table(1, |g| Some(g.walk?.pulled_path_error_deg)));
        say!("\nShare of the joint angles inside the 90 % band:");
        say!("{}", table(2, |g| Some(g.walk?.coverage_90)));
    }
}

pub(super) fn print_text(
    problems: &[Problem],
    judged: &[Evaluation],
    merged: &[MethodScore],
    has_rollouts: bool,
) {
    for p in problems {
        let step = p.step.map_or_else(String::new, |(s, how)| format!(", step {s:.4} s ({how})"));
        say!(
            "{}: {} rows, {} joints, {} trajectories{step}; held out: {}",
            p.name,
            p.dataset.frames.len(),
            p.dataset.joints.len(),
            p.dataset.trials,
            p.split
        );
    }
    let groups = merged.first().map_or(0, |s| s.groups.len());
    say!(
        "\nHeld-out rows, {} (median [5th, 95th percentile] over {groups}):",
        "by trajectory and split"
    );
    say!("{}", figures(merged));
    if let Some(first) = judged.first() {
        let sd: Vec<String> = first.task_sd.iter().map(|s| format!("{s:.3e}")).collect();
        say!(
            "  LL: mean log-likelihood, nats per row ((rad/s)^-n, (m/s)^-m); RMSE in rad/s and m/s; \
             relative: over the rms of\n  the joint velocity. S_x = diag({})^2; floor of the null \
             directions {} rad/s. Compare LL only at equal floors.",
            sd.join(", "),
            first.null_floor_rad_s
        );
    }
    for s in merged.iter().filter(|s| s.note.is_some()) {
        say!("  {}: {}.", s.method.name(), s.note.as_deref().unwrap_or_default());
    }
    if has_rollouts {
        say!("\nRollouts along held-out paths, from the true first posture:");
        say!("{}", walks(merged));
        say!(
            "  Joint error along the path, rms over joints, mean over time and over what was held out, \
             without noise:\n  without a pull and with one by time or by hand travel. At rest: joint speed \
             of sampled repetitions while the\n  hand rests{}. Round trips: three there and back. Bands: 100 \
             sampled repetitions;\n  the noise is calibrated on the training part only.",
            recorded_text(merged)
        );
    }
    print_by_trial(problems, judged, groups, has_rollouts);
    say!("\nIdentified W (diagonal, scaled to mean 1; geometric mean over splits):");
    for s in merged.iter().filter(|s| s.method.identifies_weights()) {
        if let Some(w) = weights(s) {
            let list: Vec<String> = w.iter().map(|v| format!("{v:.3}")).collect();
            say!("  {:10} {}", s.method.name(), list.join(" "));
        }
        if let Some(u) = s.uncertainty.first() {
            let sd: Vec<String> = u.log_sd.iter().map(|v| format!("{v:.2}")).collect();
            say!("  {:10} {}", "  sd log", sd.join(" "));
            let joints = problems.first().map_or(&[][..], |p| &p.dataset.joints);
            let open: Vec<&str> = u
                .undetermined_joints
                .iter()
                .filter_map(|&i| joints.get(i).map(String::as_str))
                .collect();
            let which = if open.is_empty() { "none".to_owned() } else { open.join(", ") };
            say!(
                "  {:10} {} of {} directions undetermined by the data; joints whose weight is mostly the \
                 prior's: {which}",
                "",
                u.undetermined_directions,
                u.log_sd.len().saturating_sub(1)
            );
        }
    }
}

/// Mean recorded joint speed at rest over splits, deg/s; none where no hand rests.
fn recorded_rest(rollouts: &[RolloutScore]) -> Option<f64> {
    let known: Vec<f64> = rollouts.iter().filter_map(|r| r.rest_deg_s.1).collect();
    (!known.is_empty()).then(|| crate::math::stats::mean(&known))
}

fn recorded_text(merged: &[MethodScore]) -> String {
    let known = merged.first().and_then(|s| recorded_rest(&s.rollouts));
    known.map_or_else(String::new, |v| format!(" (recorded, hand below 0.02 m/s: {v:.1} deg/s)"))
}

fn spread_text(s: Percentiles, digits: usize) -> String {
    if s.p05 == s.p95 || s.p95.is_nan() {
        return number(s.median, digits);
    }
    format!("{} [{}, {}]", number(s.median, digits), number(s.p05, digits), number(s.p95, digits))
}

fn number(v: f64, digits: usize) -> String {
    if v != 0.0 && v.abs() < 1e-4 { format!("{v:.1e}") } else { format!("{v:.digits$}") }
}

fn table_of(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header);
    table
}

fn align(table: &mut Table) {
    let count = table.column_count();
    for column in 1..count {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
}

fn figures(merged: &[MethodScore]) -> Table {
    let header = [
        "method",
        "LL qdot",
        "RMSE qdot",
        "relative",
        "LL xdot",
        "RMSE xdot",
        "training",
        "per row",
    ];
    let mut table = table_of(&header);
    for s in merged {
        table.add_row([
            s.method.name().to_owned(),
            spread_text(s.spread(|g| g.ll_q), 2),
            spread_text(s.spread(|g| g.rmse_q), 4),
            spread_text(s.spread(|g| g.relative_rmse_q), 3),
            spread_text(s.spread(|g| g.ll_x), 2),
            spread_text(s.spread(|g| g.rmse_x), 4),
            format!("{:.2} s", s.train_s),
            format!("{:.0} us", 1e6 * s.predict_s),
        ]);
    }
    align(&mut table);
    table
}

fn walks(merged: &[MethodScore]) -> Table {
    let header = [
        "method",
        "no pull",
        "per second",
        "per metre",
        "at rest",
        "3 round trips",
        "with pull",
        "in 50 %",
        "in 90 %",
        "at the end",
        "90 % width",
        "LL path",
    ];
    let mut table = table_of(&header);
    for s in merged {
        let of = |pick: fn(&RolloutScore) -> f64| {
            crate::math::stats::mean(&s.rollouts.iter().map(pick).collect::<Vec<_>>())
        };
        let deg = |v: f64| format!("{v:.1} deg");
        table.add_row([
            s.method.name().to_owned(),
            deg(of(|r| r.path_error_deg)),
            deg(of(|r| r.rule_error_deg.1)),
            deg(of(|r| r.rule_error_deg.0)),
            format!("{:.1} deg/s", of(|r| r.rest_deg_s.0)),
            deg(of(|r| r.drift_deg.0)),
            deg(of(|r| r.drift_deg.1)),
            percent(of(|r| r.bands.coverage_50)),
            percent(of(|r| r.bands.coverage_90)),
            percent(of(|r| r.bands.end_coverage_90)),
            deg(of(|r| r.bands.width_90_deg)),
            format!("{:.1}", of(|r| r.trajectory_ll)),
        ]);
    }
    align(&mut table);
    table
}
