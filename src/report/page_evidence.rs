//! Sections of the page that let a reader check the verdict: inputs, assumptions, verification,
//! refused paths, posture model, provenance.

use super::page::{list, ticked};
use super::page_scores::error;
use super::view::View;
use crate::ergonomics::ScoringMethod;
use crate::path::Check;
use crate::planner::{
    BodyScores, CandidateResult, CheckState, Checked, InputOrigin, PathData, PersonClearance,
    Refusal, Status, Subject,
};
use crate::robot::{NotChecked, RobotFacts};
use crate::scenario::Origin;
use crate::words;
use crate::words::number::{capital, change, percent, score, value};
use maud::{Markup, html};

/// Where each input of the scores comes from.
pub(super) fn inputs(view: &View) -> Markup {
    html! {
        p.note {
            "Assumed inputs were neither measured nor given. The last columns show how the expected scores of the best path would \
             change"
            @if let Some(body) = view.body { " for " (body) }
            " if the input had the value in the column before."
        }
        div.scroll tabindex="0" role="region" aria-label="Inputs" {
            table {
                thead { tr {
                    th scope="col" { "Input" }
                    th scope="col" { "Value" }
                    th scope="col" { "Where from" }
                    th scope="col" { "If it were" }
                    @for m in ScoringMethod::ALL { th.n scope="col" { "Change in expected " (m.name()) } }
                } }
                tbody { @for input in &view.result.inputs { (input_row(input)) } }
            }
        }
    }
}

fn input_row(input: &InputOrigin) -> Markup {
    let (name, value) = words::cell::input(&input.input);
    html! {
        tr {
            th scope="row" { (name) }
            td { (value) }
            td { @if input.origin == Origin::Assumed { strong { "assumed" } } @else { (words::cell::origin(input.origin)) } }
            @if let Some(to) = &input.if_changed {
                td { (words::cell::alternative(&to.to)) }
                @for (_, by) in to.change.iter() { td.n { (change(*by)) } }
            } @else {
                td { "–" } @for _ in ScoringMethod::ALL { td.n { "–" } }
            }
        }
    }
}

/// What was assumed and what is left out.
pub(super) fn assumptions(view: &View) -> Markup {
    let s = &view.result.setting;
    html! {
        h3 { "Worker" }
        (list(&words::setting::bodies(s)))
        (list(&words::setting::worker(&s.worker)))
        h3 { "Robot" }
        (list(&words::robot::facts(&s.robot)))
        @if !s.meshes.is_empty() {
            h3 { "Obstacles from meshes" }
            (list(&s.meshes.iter().map(words::setting::mesh).collect::<Vec<_>>()))
        }
        h3 { "Limits that are defaults of the program, not of your cell" }
        @if s.assumed_limits.is_empty() { p { "None: the scenario gives all limits." } } @else { (list(&s.assumed_limits)) }
        h3 { "Not modelled" }
        ul { @for n in &view.result.not_modelled { li { (words::setting::not_modelled(*n)) } } }
    }
}

/// Limits with margins, and how far the numbers can be trusted.
pub(super) fn verification(view: &View) -> Markup {
    let Some(lead) = view.lead else {
        return html! { p { "No path was scored; see the reasons below." } };
    };
    html! {
        @if let Some(path) = &lead.path { (limits(lead, path)) }
        @if let Some(body) = view.scores(lead) {
            h3 { "Simulated repetitions" @if lead.bodies.len() > 1 { " (" (body.body) ")" } }
            (trust(body))
        }
        (near_people(lead, &view.result.setting.robot))
        details {
            summary { "What was searched, and moved thresholds" }
            (searched(view))
            (thresholds(view))
        }
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

/// Checks of the tool's movement that were not made: they have no figures.
fn unmeasured(lead: &CandidateResult) -> impl Iterator<Item = &Checked> {
    let is_open = |c: &&Checked| matches!(c.state, CheckState::NotChecked { .. });
    lead.checklist.iter().filter(|c| c.subject < Subject::Joints).filter(is_open)
}

fn limits(lead: &CandidateResult, path: &PathData) -> Markup {
    html! {
        p { (capital(&words::checklist::summary(&lead.checklist))) "." }
        div.scroll tabindex="0" role="region" aria-label="Limits" {
            table {
                caption { "Limits of the tool's movement along path " (lead.id) ", measured on the finished path." }
                thead { tr {
                    th scope="col" { "Quantity" }
                    th scope="col" { "Unit" }
                    th.n scope="col" { "Largest value" }
                    th.n scope="col" { "Limit" }
                    th.n scope="col" { "Margin" }
                    th.n scope="col" { "At (s)" }
                    th scope="col" { "Kept" }
                } }
                tbody {
                    @for check in &path.checks { (check_row(check)) }
                    @for check in unmeasured(lead) {
                        tr {
                            th scope="row" { (words::checklist::subject(check.subject)) }
                            td colspan="6" { strong { (words::checklist::state(check.state)) } }
                        }
                    }
                }
            }
        }
        h3 { "Robot and cell" }
        ul {
            @for line in path.robot_margins.iter().flat_map(words::robot::margins) { li { (ticked(&line)) } }
            @if path.robot_q.is_empty() { li { strong { "The robot cannot follow this path." } } }
            li { (ticked(&words::robot::obstacle_clearance(&path.clearance))) }
            li { (ticked(&words::robot::self_clearance(&path.self_clearance))) }
            @if path.moved_m > 0.0 {
                li { "planning moved the path by at most " (format!("{:.1}", 1e3 * path.moved_m)) " mm to keep the limits" }
            }
        }
    }
}

fn check_row(check: &Check) -> Markup {
    let (name, unit) = words::path::quantity_heading(check.quantity);
    html! {
        // How near a path is to the best one is no limit: not worth the paper.
        tr class=[check.quantity.is_optimality().then_some("onscreen")] {
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

/// What was searched.
fn searched(view: &View) -> Markup {
    html! {
        @if !view.result.search.is_empty() {
            h3 { "Searches" }
            ul { @for s in &view.result.search { li { (s.name) ": " (s.paths) " paths tried, " (s.infeasible) " refused" } } }
        }
    }
}

/// The expected scores with the angle thresholds moved.
fn thresholds(view: &View) -> Markup {
    let Some(t) = &view.result.threshold_sensitivity else { return html! {} };
    html! {
        h3 { "Threshold sensitivity" }
        div.scroll tabindex="0" role="region" aria-label="Moved thresholds" { table.slim {
            caption { "Expected scores of the best path with thresholds moved by " (t.by_deg) "\u{b0} (measured angles are as uncertain as that)." }
            thead { tr {
                th scope="col" { "Thresholds of" }
                @for m in ScoringMethod::ALL { th.n scope="col" { (m.name()) ", laxer to stricter" } }
            } }
            tbody { @for b in &t.bands {
                tr {
                    th scope="row" { (b.part.map_or("all together", |p| p.name())) }
                    @for m in ScoringMethod::ALL { td.n { (score(b.laxer[m])) " to " (score(b.stricter[m])) } }
                }
            } }
        } }
    }
}

fn trust(b: &BodyScores) -> Markup {
    html! {
        dl.pairs {
            // Who is worst off stands in the decision.
            @for (name, sentence) in words::strain::lines(b).into_iter().filter(|(n, _)| *n != words::strain::WORST_OFF) {
                dt { (name) } dd { (ticked(&sentence)) }
            }
        }
        dl.pairs {
            dt { "Repetitions" } dd { (b.rollouts) ", each along the whole path" }
            dt { "Monte Carlo standard error" }
            dd { @for (m, s) in b.scores.iter() { (m.name()) " " (error(s.distribution.standard_error)) ", " } "(from the limited number of repetitions alone)" }
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
            dt { "Body" } dd { (ticked(&words::setting::learned_on(m))) }
        }
        details {
        summary { "How it was learned, and its quality" }
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
    let sum = words::verdict::objective(&s.objective);
    html! {
        details {
        summary { "Settings of the planner " (s.name) }
        dl.pairs {
            dt { "Objective" } dd { (sum) " (minimised)" }
            dt { "Candidates" }
            dd { (s.population * s.generations) " in " (s.generations) " generations, with " (s.vias) " via-points each (first typical bend " (s.sampled_offset_m) " m), beside the named ones (bend " (s.named_offset_m) " m)" }
            dt { "Steps of a path" } dd { (s.steps) }
            dt { "Repetitions" }
            dd { (s.rollouts_first) " to " (s.rollouts_most) " per path in the search, " (s.rollouts_final) " in the selection and as many fresh ones in this report" }
            dt { "Shortlist" } dd { (s.shortlist) " paths, and always the straight path and your own" }
        }
        }
    }
}
