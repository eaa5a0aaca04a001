//! The paper's experiments on the terminal.

use crate::posture::Method;
use crate::training::Percentiles;
use crate::training::paper::{
    Chain, ChainResult, HorizonPoint, MethodSummary, PaperExperiment, PaperResult, SetResult,
    paper_table,
};
use comfy_table::{CellAlignment, Table, presets};

/// Horizons that are printed, s.
const PRINTED_S: [f64; 4] = [0.5, 1.0, 2.0, 5.0];
/// Most sets that are listed one by one.
const LISTED: usize = 40;

/// Prints all that was found.
pub(super) fn print(result: &PaperResult) {
    say!("{}\n", intro(result));
    for chain in &result.chains {
        say!("{}\n", heading(chain));
        say!("{}\n", methods(result.experiment, chain).trim_fmt());
        say!("{}\n", over_horizon(chain).trim_fmt());
        say!("{}\n", sets(chain).trim_fmt());
        for line in lead(chain).into_iter().chain(weights(chain)) {
            say!("{line}");
        }
        say!("");
    }
    say!("{NOTE}");
}

const NOTE: &str = "\
  Median [5th, 95th percentile] over held-out movements. LL: mean log-likelihood, nats per frame, S_x = (1e-4 m/s,
  rad/s)^2. RMSE over all joints (rad/s; displacements of a pelvis that moves in leg lengths), relative: over the rms
  of the joint velocity. Surprise: squared residual in the null space over its predicted variance, by dimension: 1 is
  right, more is too sure; rescaled: were each law's covariance multiplied by it. In 50 %, 90 %: share of joint velocities inside the band of the prediction; bands: share of
  joint angles inside the 90 % band of repetitions from the known start, calibrated on what teaches, and its width.
  Hand and joints: off after so many seconds by the paper's own step, from the recorded posture. The paper's columns:
  another chain, other people; its RMSE behaves like a mean of squares, so the root is shown: compare order and ratios.";

fn intro(result: &PaperResult) -> String {
    let sets = result.chains.first().map_or(0, |c| c.sets.len());
    let who =
        if result.simulated { "simulated people (nobody was recorded)" } else { "recorded people" };
    let how = match (result.experiment, result.taught_by_others) {
        (PaperExperiment::Exp1, _) => {
            "the same movement: the first half of its repetitions teaches, the second half tests"
        }
        (PaperExperiment::Exp2, _) if result.simulated => {
            "random movements teach, the second half of the primitive's repetitions tests"
        }
        (PaperExperiment::Exp2, _) => {
            "a person's other tasks teach, the second half of a task's repetitions tests"
        }
        (PaperExperiment::Exp3, true) => {
            "another body: all other people's repetitions of a task teach, a person's own test"
        }
        (PaperExperiment::Exp3, false) => {
            "other bodies, seated: the first half of the repetitions teaches, the second half tests"
        }
    };
    format!(
        "{}, {who}: {how}. {sets} training sets; seed {}.",
        result.experiment.name(),
        result.seed
    )
}

fn heading(chain: &ChainResult) -> String {
    match chain.chain {
        Chain::Arm => {
            format!("From a pelvis that rests to the hand: {} joints", chain.joints.len())
        }
        Chain::Whole => format!("Whole body: {} coordinates", chain.joints.len()),
    }
}

fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header);
    for column in 1..header.len() {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn spread(p: Percentiles, digits: usize) -> String {
    format!("{:.digits$} [{:.digits$}, {:.digits$}]", p.median, p.p05, p.p95)
}

fn percent(share: f64) -> String {
    format!("{:.0}", 100.0 * share)
}

fn methods(experiment: PaperExperiment, chain: &ChainResult) -> Table {
    let mut rows = table(&[
        "method",
        "LL qdot",
        "relative RMSE",
        "RMSE xdot",
        "surprise",
        "in 50 %",
        "in 90 %",
        "band holds (width)",
        "paper: LL qdot",
        "paper: sqrt(RMSE) e-3",
    ]);
    let paper = paper_table(experiment);
    for m in &chain.methods {
        let own = paper.iter().find(|p| p.method == m.method);
        let of = |v: [f64; 3]| Percentiles { median: v[0], p05: v[1], p95: v[2] };
        rows.add_row([
            m.method.name().to_owned(),
            spread(m.ll_q, 1),
            spread(m.relative_rmse_q, 3),
            exact_or(m),
            format!("{:.1}", m.surprise.median),
            percent(m.velocity_coverage[0]),
            percent(m.velocity_coverage[1]),
            m.bands.map_or_else(String::new, |b| {
                format!("{} ({:.1} deg)", percent(b.coverage_90), b.width_90_deg)
            }),
            own.map_or_else(String::new, |p| spread(of(p.ll_q), 2)),
            own.map_or_else(String::new, |p| spread(of(p.rmse_q_if_squared().map(|v| 1e3 * v)), 0)),
        ]);
    }
    rows
}

fn exact_or(m: &MethodSummary) -> String {
    if m.rmse_x.p95 < 1e-9 { "exact".to_owned() } else { format!("{:.0e}", m.rmse_x.median) }
}

fn over_horizon(chain: &ChainResult) -> Table {
    let names: Vec<String> = PRINTED_S.iter().map(|h| format!("after {h} s")).collect();
    let mut header = vec!["hand (mm), joints (deg)"];
    header.extend(names.iter().map(String::as_str));
    let mut rows = table(&header);
    for curve in &chain.horizon {
        let at = |h: &f64| {
            let point = curve.points.iter().find(|p| p.horizon_s == *h);
            let shown = |p: &HorizonPoint| format!("{:.1}, {:.1}", p.hand_mm, p.joints_deg);
            point.map_or_else(|| "-".to_owned(), shown)
        };
        let mut row = vec![curve.method.to_owned()];
        row.extend(PRINTED_S.iter().map(at));
        rows.add_row(row);
    }
    rows
}

/// Relative RMSE of each set.
fn sets(chain: &ChainResult) -> Table {
    let names = chain.methods.iter().map(|m| m.method.name());
    let mut header = vec!["relative RMSE of", "task", "teaches", "tests", "rank"];
    header.extend(names);
    let mut rows = table(&header);
    let left = CellAlignment::Left;
    if let Some(column) = rows.column_mut(1) {
        column.set_cell_alignment(left);
    }
    for set in chain.sets.iter().take(LISTED) {
        let mut row = vec![
            set.who.clone(),
            set.task.clone(),
            counted(set.train.movements, set.train.people),
            set.test.movements.to_string(),
            format!("{:.1}", set.rank),
        ];
        row.extend(marked(set));
        rows.add_row(row);
    }
    rows
}

fn counted(movements: usize, people: usize) -> String {
    if people > 1 { format!("{movements} of {people}") } else { movements.to_string() }
}

/// The least of all is marked.
fn marked(set: &SetResult) -> Vec<String> {
    let least = set.methods.iter().map(|m| m.relative_rmse_q).fold(f64::INFINITY, f64::min);
    let shown = |v: f64| format!("{v:.3}{}", if v <= least { "*" } else { " " });
    set.methods.iter().map(|m| shown(m.relative_rmse_q)).collect()
}

/// Counted, not judged.
fn lead(chain: &ChainResult) -> Vec<String> {
    let one = |a: &crate::training::paper::Against| {
        format!(
            "  mi-nsgp against {}: relative RMSE smaller in {} of {} sets (median ratio {:.2}), likelihood \
             higher in {} (median {:+.1} nats; in {} once rescaled)",
            a.other.name(),
            a.rmse_better,
            a.sets,
            a.rmse_ratio,
            a.ll_better,
            a.ll_gain,
            a.ll_rescaled_better
        )
    };
    chain.against.iter().map(one).collect()
}

fn weights(chain: &ChainResult) -> Vec<String> {
    let one = |w: &crate::training::paper::WeightAgreement| {
        let pair = |k: usize| Some((w.difference[k]?, w.rank_correlation[k]?));
        let said = |(pair, who): (Option<(f64, f64)>, &str)| {
            pair.map(|(off, rank)| {
                format!("{off:.2} between sets of {who} (rank correlation {rank:.2})")
            })
        };
        let pairs = [(pair(0), "one person"), (pair(1), "two people")];
        let parts: Vec<String> = pairs.into_iter().filter_map(said).collect();
        (!parts.is_empty()).then(|| {
            format!(
                "  W of {}: log W differs by {}; it is {:.2} from W = I",
                w.method.name(),
                parts.join(", "),
                w.spread
            )
        })
    };
    let is_own = |w: &&crate::training::paper::WeightAgreement| w.method != Method::FullWGp;
    chain.weights.iter().filter(is_own).filter_map(one).collect()
}
