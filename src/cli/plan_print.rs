//! What `plan` and `assess` show on the terminal: the verdict in two lines, the ranking with bars,
//! warnings, and how far to trust it.

use super::bars::{bad_share, bold, table};
use crate::ergonomics::ScoringMethod;
use crate::path::Family;
use crate::planner::{BodyScores, CandidateResult, Evaluated, RunResult, Severity, Status};
use crate::words;
use crate::words::number::{capital, percent, score};
use comfy_table::{Cell, CellAlignment};

/// Changes of the cell that are shown.
const MOST_CHANGES: usize = 3;

/// The verdict, and unless it is to be quiet the ranking and what belongs to it.
pub(super) fn print(result: &RunResult, quiet: bool) {
    print_verdict(result);
    if quiet {
        return;
    }
    print_ranking(result);
    let mut notes: Vec<String> = words::verdict::chosen(result).into_iter().collect();
    notes.extend(words::verdict::findings(result, Severity::Note));
    section("Part of the result", &notes);
    section("Warnings", &words::verdict::findings(result, Severity::Caution));
    print_strain(result);
    print_help(result);
    print_trust(result);
}

fn section(heading: &str, lines: &[String]) {
    if lines.is_empty() {
        return;
    }
    say!("\n{heading}");
    for line in lines {
        say!("  {line}");
    }
}

fn print_verdict(result: &RunResult) {
    say!("{}", bold(&words::verdict::headline(result)));
    for line in words::verdict::gain(result).into_iter().chain(words::verdict::expected(result)) {
        say!("  {line}");
    }
    for line in words::refused::lines(result) {
        say!("  {line}");
    }
    for line in words::verdict::findings(result, Severity::Doubt) {
        say!("  {line}");
    }
    if let Some(caveat) = result.verdict.caveat {
        say!("[{}]", words::verdict::caveat(caveat));
    }
}

/// The reported paths, best first; columns that would be empty are left out.
fn print_ranking(result: &RunResult) {
    let shown: Vec<&CandidateResult> =
        result.candidates.iter().filter(|c| c.evaluated == Evaluated::Reported).collect();
    if !shown.is_empty() {
        let several = shown.iter().any(|c| c.bodies.len() > 1);
        let lost = shown.iter().flat_map(|c| &c.bodies).any(|b| b.reach_exceeded > 0.0);
        let marked = shown.iter().any(|c| c.status != Status::Feasible);
        let mut header = vec!["rank", "path", "id"];
        header.extend(several.then_some("body"));
        let [lead, others @ ..] = ScoringMethod::ALL.map(ScoringMethod::name);
        header.extend(["time at 3+", "", lead, "90 % band", "per metre", "peak"]);
        header.extend(others);
        header.push("objective");
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
    let of = |e: Evaluated| result.candidates.iter().filter(move |c| c.evaluated == e);
    let searched = of(Evaluated::Search).count();
    if searched > 0 {
        say!("  and {searched} paths of the search that were not shortlisted");
    }
    let refused: Vec<String> = of(Evaluated::None)
        .filter(|c| c.family != Family::Sampled)
        .map(|c| format!("`{}`", c.id))
        .collect();
    let sampled = of(Evaluated::None).count() - refused.len();
    let sampled = (sampled > 0).then(|| format!("{sampled} of the search"));
    let all: Vec<String> = refused.into_iter().chain(sampled).collect();
    if !all.is_empty() {
        say!("  not feasible: {}", all.join(", "));
    }
    if !shown.is_empty() {
        say!(
            "  3+: RULA action level 3 or above (score 5 or more). Scores are means: they rank, they do not measure. \
             Ranked by the objective on other repetitions than those of the figures."
        );
    }
}

fn row(
    c: &CandidateResult,
    b: &BodyScores,
    is_first: bool,
    (several, lost, marked): (bool, bool, bool),
) -> Vec<Cell> {
    let right = |text: String| Cell::new(text).set_alignment(CellAlignment::Right);
    let once = |text: String| Cell::new(if is_first { text } else { String::new() });
    let limits = words::refusal::state(&c.status);
    let [lead, others @ ..] = ScoringMethod::ALL;
    let (scores, share) = (&b.scores[lead], b.scores[lead].high_band[0]);
    let mut cells = vec![
        once(c.rank.map_or_else(String::new, |r| r.to_string())),
        once(words::paths::path_name(c)),
        once(c.id.clone()),
    ];
    cells.extend(several.then(|| Cell::new(&b.body)));
    cells.extend([
        bad_share(share),
        right(percent(share)),
        right(score(scores.distribution.expected)),
        Cell::new(format!(
            "{} to {}",
            score(scores.distribution.p05),
            score(scores.distribution.p95)
        )),
        right(score(scores.per_metre)),
        right(score(scores.peak)),
    ]);
    cells.extend(others.map(|m| right(score(b.scores[m].distribution.expected))));
    cells.push(right(if is_first {
        c.objective.map_or_else(String::new, score)
    } else {
        String::new()
    }));
    cells.extend(lost.then(|| right(percent(b.reach_exceeded))));
    cells.extend(marked.then(|| once(limits.to_owned())));
    cells
}

/// What the whole body does along the lead.
fn print_strain(result: &RunResult) {
    let Some(best) = words::verdict::lead(result) else { return };
    for b in &best.bodies {
        let lines = words::strain::lines(b);
        if lines.is_empty() {
            continue;
        }
        say!("\nThe body of {} along `{}`", b.body, best.id);
        for (name, sentence) in lines {
            say!("  {name:<14} {sentence}");
        }
    }
}

/// The changes that would help most.
fn print_help(result: &RunResult) {
    let Some(found) = &result.recommendations else { return };
    let mut lines: Vec<String> = found.standing.iter().map(words::cell::standing_place).collect();
    lines.extend(found.clear.iter().take(MOST_CHANGES).map(|r| {
        let now_then = |[now, then]: [f64; 2]| format!("{} \u{2192} {}", score(now), score(then));
        let effects: Vec<String> = r
            .effect
            .iter()
            .map(|(m, e)| format!("{} {}", m.name(), now_then(e.expected)))
            .chain(words::cell::low_back(r))
            .collect();
        format!("{}: {}", capital(&words::cell::cell_change(&r.what)), effects.join(", "))
    }));
    section("What would help (each change alone, path and robot as they are)", &lines);
}

/// How far the figures of the lead can be trusted.
fn print_trust(result: &RunResult) {
    let Some(best) = words::verdict::lead(result) else { return };
    say!("\nHow far to trust `{}`", best.id);
    if let Some(path) = &best.path {
        say!("  limits         {}", words::checklist::summary(&best.checklist));
        say!("  robot          {}", words::robot::self_clearance(&path.self_clearance));
        say!("  obstacles      {}", words::robot::obstacle_clearance(&path.clearance));
    }
    for b in &best.bodies {
        if let Some(near) = &b.person_clearance {
            let sentence = words::robot::person_clearance(near);
            say!(
                "  to the person  {}: {sentence} (a planning margin, not a safety function)",
                b.body
            );
        }
        say!(
            "  hand on path   {}: at most {:.2} mm (rms {:.3} mm) and {:.2} deg off; out of reach {}; beyond the training \
             data {} of the path; standard error of RULA {:.3}",
            b.body,
            b.hand_residual_max_mm,
            b.hand_residual_rms_mm,
            b.hand_residual_max_deg,
            percent(b.reach_exceeded),
            percent(b.extrapolation_share),
            b.rula().distribution.standard_error.unwrap_or(f64::NAN)
        );
    }
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
