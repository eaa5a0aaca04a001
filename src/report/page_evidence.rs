//! Sections of the page that let a reader check the verdict: inputs, assumptions, verification,
//! refused paths, posture model, provenance.

use super::page::{list, ticked};
use super::page_scores::error;
use super::view::View;
use crate::path::Check;
use crate::planner::{
    BodyScores, CandidateResult, InputOrigin, PathData, PersonClearance, Refusal, Status,
};
use crate::robot::{NotChecked, RobotFacts};
use crate::scenario::Origin;
use crate::words;
use crate::words::number::{change, percent, score, value};
use maud::{Markup, html};

fn origin_words(origin: Origin) -> &'static str {
    match origin {
        Origin::Measured => "measured",
        Origin::Predicted => "predicted by the posture model",
        Origin::FromTheTask => "from the task",
        Origin::Assumed => "assumed",
        Origin::Unknown => "unknown, not scored",
    }
}

/// Where each input of the scores comes from.
pub(super) fn inputs(view: &View) -> Markup {
    html! {
        p.note {
            "What is assumed was not measured or given. The last columns say how the expected scores of the best path change \
             if the input is what stands in the column before"
            @if view.lead.is_some_and(|l| l.bodies.len() > 1) { ", for the body that is listed first" }
            "."
        }
        div.scroll tabindex="0" role="region" aria-label="Inputs" {
            table {
                thead { tr {
                    th scope="col" { "Input" }
                    th scope="col" { "Value" }
                    th scope="col" { "Where from" }
                    th scope="col" { "If it were" }
                    th.n scope="col" { "Change of expected RULA" }
                    th.n scope="col" { "Change of expected REBA" }
                } }
                tbody { @for input in &view.result.inputs { (input_row(input)) } }
            }
        }
    }
}

fn input_row(input: &InputOrigin) -> Markup {
    html! {
        tr {
            th scope="row" { (input.input) }
            td { (input.value) }
            td { @if input.origin == Origin::Assumed { strong { "assumed" } } @else { (origin_words(input.origin)) } }
            @if let Some(to) = &input.if_changed {
                td { (to.to) }
                td.n { (change(to.rula)) }
                td.n { (change(to.reba)) }
            } @else {
                td { "–" } td.n { "–" } td.n { "–" }
            }
        }
    }
}

/// What was assumed and what is left out.
pub(super) fn assumptions(view: &View) -> Markup {
    let s = &view.result.setting;
    html! {
        h3 { "Worker" }
        (list(&s.bodies))
        (list(&s.worker))
        h3 { "Robot" }
        (list(&words::robot::facts(&s.robot)))
        h3 { "Limits that are defaults of the program, not of your cell" }
        @if s.assumed_limits.is_empty() { p { "None: the scenario gives all limits." } } @else { (list(&s.assumed_limits)) }
        h3 { "Not modelled" }
        (list(&view.result.not_modelled))
    }
}

/// Limits with margins, and how far the numbers can be trusted.
pub(super) fn verification(view: &View) -> Markup {
    let Some(lead) = view.lead else {
        return html! { p { "No path was scored; see the reasons below." } };
    };
    html! {
        @if let Some(path) = &lead.path { (limits(&lead.id, path)) }
        @if let Some(body) = view.scores(lead) {
            h3 { "Simulated people" @if lead.bodies.len() > 1 { " (" (body.body) ")" } }
            (trust(body))
        }
        (another_seed(view))
        (thresholds(view))
        (near_people(lead, &view.result.setting.robot))
    }
}

/// How near the robot comes to each body.
fn near_people(lead: &CandidateResult, robot: &RobotFacts) -> Markup {
    let why = robot.not_checked.unwrap_or(NotChecked::NoMotion);
    let found: Vec<(&str, &PersonClearance)> = lead
        .bodies
        .iter()
        .filter_map(|b| b.person_clearance.as_ref().map(|c| (b.body.as_str(), c)))
        .collect();
    html! {
        h3 { "Distance between robot and person" }
        @if found.is_empty() {
            p { "Not checked: " (words::robot::not_checked(why)) "." }
        } @else {
            p.note {
                "Least distance of each repetition over time, between capsules around the robot's links and the person's body parts. \
                 The hand and forearm that hold on may be at the robot's wrist and do not count there. This is a margin for planning, \
                 not a safety function."
            }
            div.scroll tabindex="0" role="region" aria-label="Distance between robot and person" {
                table {
                    thead { tr {
                        th scope="col" { "Body" }
                        th.n scope="col" { "Least (mm)" }
                        th.n scope="col" { "5th percentile (mm)" }
                        th.n scope="col" { "Margin (mm)" }
                        th.n scope="col" { "Nearer than the margin" }
                        th.n scope="col" { "Allowed" }
                        th scope="col" { "Nearest" }
                        th scope="col" { "Kept" }
                    } }
                    tbody { @for (body, c) in &found {
                        tr {
                            th scope="row" { (body) }
                            td.n { (format!("{:.0}", 1e3 * c.min_m)) }
                            td.n { (format!("{:.0}", 1e3 * c.p05_m)) }
                            td.n { (format!("{:.0}", 1e3 * c.margin_m)) }
                            td.n { (percent(c.share_below)) }
                            td.n { (percent(c.share_allowed)) }
                            td { code { (c.link) } " and " (c.body_part) " at " (format!("{:.2}", c.time_s)) " s" }
                            td { @if c.is_kept() { "yes" } @else { strong { "no" } } }
                        }
                    } }
                }
            }
        }
    }
}

fn limits(id: &str, path: &PathData) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="Limits" {
            table {
                caption { "Limits of the tool's movement along path " (id) ", measured on the finished path." }
                thead { tr {
                    th scope="col" { "Quantity" }
                    th scope="col" { "Unit" }
                    th.n scope="col" { "Largest value" }
                    th.n scope="col" { "Limit" }
                    th.n scope="col" { "Margin" }
                    th.n scope="col" { "At (s)" }
                    th scope="col" { "Kept" }
                } }
                tbody { @for check in &path.checks { (check_row(check)) } }
            }
        }
        h3 { "Robot and cell" }
        ul {
            @for line in path.robot_margins.iter().flat_map(words::robot::margins) { li { (ticked(&line)) } }
            @if path.robot_q.is_empty() { li { strong { "The robot cannot follow this path." } } }
            li { (ticked(&words::robot::obstacle_clearance(&path.clearance))) }
            li { (ticked(&words::robot::self_clearance(&path.self_clearance))) }
            li { "planning moved the path by at most " (format!("{:.1}", 1e3 * path.moved_m)) " mm to keep the limits" }
        }
    }
}

fn check_row(check: &Check) -> Markup {
    let (name, unit) = words::path::quantity_heading(check.quantity);
    html! {
        tr {
            th scope="row" { (name) }
            td { (unit) }
            td.n { (value(check.value)) }
            td.n { (value(check.limit)) }
            td.n { (value(check.margin())) }
            td.n { (format!("{:.2}", check.at_s)) }
            td { @if check.is_met() { "yes" } @else { strong { "no" } } }
        }
    }
}

/// The best path among other people, and what was searched.
fn another_seed(view: &View) -> Markup {
    let Some(c) = &view.result.certificate else { return html! {} };
    let moved = c.expected_rula_other_seed - c.expected_rula;
    let is_within = moved.abs() <= c.half_width95;
    html! {
        h3 { "Under another seed" }
        p {
            (c.people) " other simulated people: expected RULA " (score(c.expected_rula_other_seed)) " against "
            (score(c.expected_rula)) ", " @if is_within { "within" } @else { strong { "outside" } }
            " the 95 % interval of " (format!("{:.3}", c.half_width95)) " for chance alone. The path itself was not searched again."
        }
        @if !view.result.search.is_empty() {
            ul { @for s in &view.result.search { li { (s.name) ": " (s.paths) " paths tried, " (s.infeasible) " refused" } } }
        }
    }
}

/// The expected scores with the angle thresholds moved.
fn thresholds(view: &View) -> Markup {
    let Some(t) = &view.result.threshold_sensitivity else { return html! {} };
    html! {
        h3 { "If the angle thresholds lay elsewhere" }
        div.scroll tabindex="0" role="region" aria-label="Moved thresholds" { table.slim {
            caption { "Expected scores of the best path with thresholds moved by " (t.by_deg) "\u{b0} (measured angles are as uncertain as that)." }
            thead { tr {
                th scope="col" { "Thresholds of" }
                th.n scope="col" { "RULA, laxer to stricter" }
                th.n scope="col" { "REBA, laxer to stricter" }
            } }
            tbody { @for b in &t.bands {
                tr {
                    th scope="row" { (b.part.map_or("all together", |p| p.name())) }
                    td.n { (score(b.laxer.rula)) " to " (score(b.stricter.rula)) }
                    td.n { (score(b.laxer.reba)) " to " (score(b.stricter.reba)) }
                }
            } }
        } }
    }
}

fn trust(b: &BodyScores) -> Markup {
    html! {
        dl.pairs {
            dt { "Repetitions" } dd { (b.rollouts) " simulated people, each along the whole path" }
            dt { "Monte Carlo standard error" }
            dd { "RULA " (error(b.rula.standard_error)) ", REBA " (error(b.reba.standard_error)) " (from the limited number of repetitions alone)" }
            dt { "Hand to path" }
            dd {
                "at most " (format!("{:.2}", b.hand_residual_max_mm)) " mm, root mean square "
                (format!("{:.2}", b.hand_residual_rms_mm)) " mm; at most " (format!("{:.2}", b.hand_residual_max_deg)) " deg"
            }
            dt { "Out of reach" }
            dd {
                (percent(b.reach_exceeded)) " of the repetitions"
                @if let Some(from) = b.reach_exceeded_from_s { ", first at " (format!("{from:.2}")) " s" }
            }
            dt { "Beyond the training data" }
            dd { (percent(b.extrapolation_share)) " of the samples are postures or movements that the training data do not support" }
            dt { "Unusual starts" }
            dd {
                (percent(b.unusual_starts)) " of the start postures are rarer than one in a hundred of the training postures (mean \
                 Mahalanobis distance " (score(b.start_distance)) ": distance from the usual posture in standard deviations)"
            }
        }
    }
}

/// Refusals that differ only in their numbers.
struct Group<'a> {
    first: &'a Refusal,
    ids: Vec<&'a str>,
}

/// Paths that cannot be used, grouped by reason.
pub(super) fn infeasible(view: &View) -> Markup {
    let mut groups: Vec<Group> = Vec::new();
    for c in &view.result.candidates {
        let Status::Infeasible { refusal } = &c.status else { continue };
        match groups.iter_mut().find(|g| g.first.kind() == refusal.kind()) {
            Some(group) => group.ids.push(&c.id),
            None => groups.push(Group { first: refusal, ids: vec![&c.id] }),
        }
    }
    groups.sort_by_key(|g| std::cmp::Reverse(g.ids.len()));
    let refused: usize = groups.iter().map(|g| g.ids.len()).sum();
    if refused == 0 {
        return html! { p { "None: every candidate could be made feasible." } };
    }
    html! {
        p { (refused) " of " (view.result.candidates.len()) " candidates cannot be used." }
        div.scroll tabindex="0" role="region" aria-label="Paths that are not feasible" {
            table {
                thead { tr {
                    th.n scope="col" { "Paths" }
                    th scope="col" { "Refused by" }
                    th scope="col" { "Reason (of the first)" }
                    th scope="col" { "Which" }
                } }
                tbody {
                    @for g in &groups {
                        tr {
                            td.n { (g.ids.len()) }
                            td { (words::refusal::refused_by(g.first.by())) }
                            td { (ticked(&words::refusal::refusal(g.first))) }
                            td {
                                (g.ids.iter().take(8).copied().collect::<Vec<_>>().join(", "))
                                @if g.ids.len() > 8 { ", and " (g.ids.len() - 8) " more" }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The posture model.
pub(super) fn model(view: &View) -> Markup {
    let m = &view.result.posture_model;
    html! {
        dl.pairs {
            dt { "Name" } dd { (m.name) }
            dt { "Made from" }
            dd { @if m.simulated { strong { "movements of a simulated operator, not of people" } } @else { "recorded movements" } }
            dt { "Method" } dd { code { (m.method) } }
            dt { "Body" } dd { (ticked(&m.learned_on)) }
        }
        @if !m.weight_by_group.is_empty() {
            h3 { "How the body shares the movement" }
            p.note { "Weight of each joint group in the method's weight matrix W: the larger its share, the more of a free movement it takes over." }
            table.slim {
                thead { tr { th scope="col" { "Joint group" } th.n scope="col" { "Share of the weight" } } }
                tbody { @for (group, share) in &m.weight_by_group { tr { th scope="row" { (group) } td.n { (percent(*share)) } } } }
            }
        }
        @if m.quality.is_empty() {
            p { "No quality on held-out movement is stored with this model." }
        } @else {
            h3 { "Quality on movement that was held out of the training" }
            table {
                thead { tr {
                    th scope="col" { "Method" }
                    th.n scope="col" { "Relative error of joint speed" }
                    th.n scope="col" { "Error of joint speed (rad/s)" }
                    th.n scope="col" { "Log-likelihood (nats, higher is better)" }
                    th.n scope="col" { "Joint error along the hand path (deg)" span.small { "without; with the pull to usual postures" } }
                } }
                tbody {
                    @for q in &m.quality {
                        tr {
                            th scope="row" { (q.method.name()) }
                            td.n { (score(q.relative_rmse)) }
                            td.n { (score(q.rmse_rad_s)) }
                            td.n { (score(q.log_likelihood)) }
                            td.n {
                                @if let Some((without, with)) = q.path_error_deg { (score(without)) "; " (score(with)) } @else { "–" }
                            }
                        }
                    }
                }
            }
        }
        @if !m.notes.is_empty() { h3 { "Notes of the training" } (list(&m.notes)) }
    }
}

/// How to make the run again.
pub(super) fn provenance(view: &View) -> Markup {
    let p = &view.result.provenance;
    html! {
        dl.pairs {
            dt { "Program" } dd { "ergopath " (p.program_version) }
            dt { "Command" } dd { code { (p.command) } }
            dt { "Seed" } dd { (p.seed) " (the same inputs and seed give the same files, byte for byte)" }
            dt { "Scores" }
            dd {
                "RULA (McAtamney & Corlett 1993) and REBA (Hignett & McAtamney 2000), score profile "
                code { (p.score_profile) }
                " for what these papers leave open"
            }
        }
        h3 { "Inputs" }
        div.scroll tabindex="0" role="region" aria-label="Hashes of the inputs" {
            table {
                thead { tr { th scope="col" { "Input" } th scope="col" { "SHA-256" } } }
                tbody { @for (name, hash) in &p.inputs { tr { th scope="row" { (name) } td { code { (hash) } } } } }
            }
        }
        (planner(view))
    }
}

fn planner(view: &View) -> Markup {
    let s = &view.result.planner;
    let o = &s.objective;
    let weights = [
        ("expected RULA", o.expected_rula),
        ("expected REBA", o.expected_reba),
        ("RULA, mean of the worst tenth", o.cvar90_rula),
        ("share of time at RULA 5 or more", o.exposure_rula_5),
    ];
    let sum: Vec<String> = weights
        .iter()
        .filter(|(_, w)| *w != 0.0)
        .map(|(name, w)| format!("{w} x {name}"))
        .collect();
    html! {
        h3 { "Planner " (s.name) }
        dl.pairs {
            dt { "Made small" } dd { (sum.join(" + ")) }
            dt { "Candidates" }
            dd { (s.population * s.generations) " in " (s.generations) " generations, with " (s.vias) " via-points each (first typical bend " (s.sampled_offset_m) " m), beside the named ones (bend " (s.named_offset_m) " m)" }
            dt { "Steps of a path" } dd { (s.steps) }
            dt { "People" }
            dd { (s.rollouts_first) " to " (s.rollouts_most) " per path in the search, " (s.rollouts_final) " in the selection and, fresh ones, in this report" }
            dt { "Shortlist" } dd { (s.shortlist) " paths, and always the straight path and your own" }
        }
    }
}
