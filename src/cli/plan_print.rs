//! What `plan` and `assess` show on the terminal: the verdict in two lines, the ranking with bars, what
//! to mind, and how far to trust it.

use super::bars::{bad_share, bold, percent, table};
use crate::planner::{BodyScores, CandidateResult, Evaluated, RunResult, Status};
use comfy_table::{Cell, CellAlignment};

/// Share from which something is told that makes the figures doubtful.
const DOUBTFUL: f64 = 0.1;
/// Change of expected RULA by an assumption from which it is told.
const WORTH_TELLING: f64 = 0.3;
/// Share of people by which a path must have fewer at action level 3 to be told.
const CLEARLY_FEWER: f64 = 0.1;

/// The verdict, and unless it is to be quiet the ranking and what belongs to it.
pub(super) fn print(result: &RunResult, quiet: bool) {
    let best = result.candidates.iter().find(|c| Some(&c.id) == result.verdict.best.as_ref());
    print_verdict(result, best);
    if quiet {
        return;
    }
    print_ranking(result);
    let told = ["Chosen with it", "Its timing", "Freedom of", "All freedoms"];
    let is_told = |l: &&String| told.iter().any(|start| l.starts_with(start));
    let choices: Vec<&String> = result.verdict.lines.iter().filter(is_told).collect();
    if best.is_some() && !choices.is_empty() {
        say!();
        for line in choices {
            say!("  {line}");
        }
    }
    let mind = to_mind(result, best);
    if !mind.is_empty() {
        say!("\nTo mind");
        for line in mind {
            say!("  {line}");
        }
    }
    print_certificates(result, best);
}

fn print_verdict(result: &RunResult, best: Option<&CandidateResult>) {
    say!("{}", bold(&result.verdict.headline));
    if let Some(body) = best.and_then(worst) {
        say!("{}", second_line(result, body));
    } else {
        for line in &result.verdict.lines {
            say!("  {line}");
        }
    }
    if let Some(caveat) = &result.verdict.caveat {
        say!("[{caveat}]");
    }
}

fn worst(candidate: &CandidateResult) -> Option<&BodyScores> {
    candidate.bodies.iter().max_by(|a, b| a.rula.expected.total_cmp(&b.rula.expected))
}

/// Expected RULA, and how it stands to the straight path and to the user's own.
fn second_line(result: &RunResult, body: &BodyScores) -> String {
    let is_shown = |id: &str| {
        id == "straight"
            || result
                .candidates
                .iter()
                .any(|c| c.id == id && c.family == crate::path::Family::Drawn)
    };
    let against = result.comparisons.iter().filter(|c| c.body == body.body && is_shown(&c.other));
    let mut parts = vec![format!("Expected RULA {:.2}", body.rula.expected)];
    for c in against {
        let d = &c.rula;
        let other = if c.other == "straight" {
            "the straight path".to_owned()
        } else {
            format!("your path `{}`", c.other)
        };
        parts.push(if d.clear {
            let (word, ends) = if d.mean < 0.0 {
                ("lower", [-d.high95, -d.low95])
            } else {
                ("higher", [d.low95, d.high95])
            };
            format!(
                "{:.2} {word} than {other} (95 % interval {:.2} to {:.2})",
                d.mean.abs(),
                ends[0],
                ends[1]
            )
        } else {
            format!(
                "not clearly different from {other} ({:+.2}, {:+.2} to {:+.2})",
                d.mean, d.low95, d.high95
            )
        });
    }
    let body_words = if result.candidates.iter().any(|c| c.bodies.len() > 1) {
        format!("; worst body {}", body.body)
    } else {
        String::new()
    };
    parts.join(", ") + &body_words
}

/// The reported paths, best first; columns that would be empty are left out.
fn print_ranking(result: &RunResult) {
    let shown: Vec<&CandidateResult> =
        result.candidates.iter().filter(|c| c.evaluated == Evaluated::Reported).collect();
    if !shown.is_empty() {
        let several = shown.iter().any(|c| c.bodies.len() > 1);
        let lost = shown.iter().flat_map(|c| &c.bodies).any(|b| b.reach_exceeded > 0.0);
        let marked = shown.iter().any(|c| c.status != Status::Feasible);
        let mut header = vec!["rank", "path"];
        header.extend(several.then_some("body"));
        header.extend(["time at 3+", "", "RULA", "90 % band", "REBA"]);
        header.extend(lost.then_some("out of reach"));
        header.extend(marked.then_some("limits"));
        let mut table = table(&header, &[0]);
        for c in &shown {
            for (i, b) in c.bodies.iter().enumerate() {
                table.add_row(row(c, b, i == 0, (several, lost, marked)));
            }
        }
        say!("\n{}", table.trim_fmt());
    }
    let count = |e: Evaluated| result.candidates.iter().filter(|c| c.evaluated == e).count();
    say!(
        "  and {} paths of the search that were not shortlisted, {} that are not feasible",
        count(Evaluated::Search),
        count(Evaluated::None)
    );
    say!(
        "  3+: RULA action level 3 or above (score 5 or more). Scores are means: they rank, they do not measure."
    );
}

fn row(
    c: &CandidateResult,
    b: &BodyScores,
    is_first: bool,
    (several, lost, marked): (bool, bool, bool),
) -> Vec<Cell> {
    let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
    let once = |text: String| Cell::new(if is_first { text } else { String::new() });
    // Another movement has no place among these.
    let rank = match (c.ends, c.rank) {
        (None, Some(rank)) => rank.to_string(),
        _ => "–".to_owned(),
    };
    let limits = match &c.status {
        Status::Feasible => "kept",
        Status::Marked { .. } => "over a limit",
        Status::Infeasible { .. } => "not feasible",
    };
    let share = b.rula.exposure.get(5).copied().unwrap_or(0.0);
    let mut cells = vec![once(rank), once(c.id.clone())];
    cells.extend(several.then(|| Cell::new(&b.body)));
    cells.extend([
        bad_share(share),
        right(percent(share)),
        right(format!("{:.2}", b.rula.expected)),
        Cell::new(format!("{:.2} to {:.2}", b.rula.p05, b.rula.p95)),
        right(format!("{:.2}", b.reba.expected)),
    ]);
    cells.extend(lost.then(|| right(percent(b.reach_exceeded))));
    cells.extend(marked.then(|| once(limits.to_owned())));
    cells
}

/// What should make the reader doubt, or act.
fn to_mind(result: &RunResult, best: Option<&CandidateResult>) -> Vec<String> {
    let mut mind = Vec::new();
    if let Some(b) = best.and_then(worst) {
        if b.extrapolation_share > DOUBTFUL {
            mind.push(format!(
                "{} of the best path lies beyond the posture model's training data; there it extrapolates",
                percent(b.extrapolation_share)
            ));
        }
        if b.unusual_starts > DOUBTFUL {
            mind.push(format!(
                "{} of the start postures are unusual for the training data: is the worker placed rightly?",
                percent(b.unusual_starts)
            ));
        }
        if b.reach_exceeded > 0.0 {
            mind.push(format!(
                "in {} of the repetitions the hand cannot follow, first at {:.2} s; they count as the worst score \
                 from there on",
                percent(b.reach_exceeded),
                b.reach_exceeded_from_s.unwrap_or(0.0)
            ));
        }
        mind.extend(best.and_then(|best| fewer_people(result, best, b)));
        let neck = result.inputs.iter().find(|i| i.input == "neck");
        if let Some((neck, change)) = neck.and_then(|n| Some((n, n.if_changed.as_ref()?)))
            && change.rula.abs() >= WORTH_TELLING
        {
            mind.push(format!(
                "the neck is assumed, not predicted ({}); {}, RULA would be {:.2}",
                neck.value,
                change.to,
                b.rula.expected + change.rula
            ));
        }
        let muscle = result.inputs.iter().find(|i| i.input == "muscle use");
        if let Some(change) = muscle.and_then(|m| m.if_changed.as_ref()) {
            mind.push(format!(
                "task.cycles_per_min and task.hold_s are not both given; repeated or held long, RULA would be {:.2}",
                b.rula.expected + change.rula
            ));
        }
    }
    for c in &result.candidates {
        if let Status::Marked { violations } = &c.status {
            mind.push(format!("`{}` breaks limits: {}", c.id, violations.join("; ")));
        }
    }
    mind
}

/// A path with clearly fewer people at action level 3 than the best, if there is one: the order is that
/// of the planner's objective.
fn fewer_people(result: &RunResult, best: &CandidateResult, body: &BodyScores) -> Option<String> {
    let people = |b: &BodyScores| b.rula.p_at_least.get(5).copied().unwrap_or(0.0);
    let is_other =
        |c: &&CandidateResult| c.status == Status::Feasible && c.ends.is_none() && c.id != best.id;
    let others = result.candidates.iter().filter(is_other);
    let of = |c: &&CandidateResult| worst(c).map_or(1.0, people);
    let fewest = others.filter(|c| !c.bodies.is_empty()).min_by(|a, b| of(a).total_cmp(&of(b)))?;
    let (there, here) = (of(&fewest), people(body));
    (here - there >= CLEARLY_FEWER).then(|| {
        format!(
            "on `{}` fewer people reach action level 3 for half a second ({} instead of {}): the order is that of \
             the planner's objective",
            fewest.id,
            percent(there),
            percent(here)
        )
    })
}

/// How far the best path's figures can be trusted.
fn print_certificates(result: &RunResult, best: Option<&CandidateResult>) {
    let (Some(best), Some(certificate)) = (best, &result.certificate) else { return };
    say!("\nHow far to trust `{}`", best.id);
    if let Some(path) = &best.path {
        let broken = path.checks.iter().filter(|c| !c.is_met()).count();
        let kept = if broken == 0 { "all kept".to_owned() } else { format!("{broken} broken") };
        say!(
            "  limits         {} checks on a grid ten times finer than the path's: {kept}",
            path.checks.len()
        );
        say!("  robot          {}", path.self_clearance);
    }
    for b in &best.bodies {
        if let Some(near) = &b.person_clearance {
            let sentence = near.sentence();
            say!(
                "  to the person  {}: {sentence} (a planning margin, not a safety function)",
                b.body
            );
        }
        say!(
            "  hand on path   {}: at most {:.2} mm (rms {:.3} mm) and {:.2} deg off; out of reach {:.0} %; \
             beyond the training data {:.0} % of the path; standard error of RULA {:.3}",
            b.body,
            b.hand_residual_max_mm,
            b.hand_residual_rms_mm,
            b.hand_residual_max_deg,
            100.0 * b.reach_exceeded,
            100.0 * b.extrapolation_share,
            b.rula.standard_error.unwrap_or(f64::NAN)
        );
    }
    let c = certificate;
    let difference = c.expected_rula_other_seed - c.expected_rula;
    let verdict = if difference.abs() <= c.half_width95 { "within" } else { "beyond" };
    say!(
        "  another seed   {} other people: expected RULA {:.2} instead of {:.2}, {verdict} the 95 % interval of \
         ±{:.2}",
        c.people,
        c.expected_rula_other_seed,
        c.expected_rula,
        c.half_width95
    );
    let searches: Vec<String> = result
        .search
        .iter()
        .map(|s| match s.infeasible {
            0 => format!("{} {}", s.name, s.paths),
            n => format!("{} {} ({n} refused)", s.name, s.paths),
        })
        .collect();
    if !searches.is_empty() {
        say!("  paths tried    {}", searches.join("; "));
    }
}
