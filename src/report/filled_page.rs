//! The filled-in sheet as a page that prints on A4.

use super::ReportError;
use super::filled::{Group, TableRow, csv_text, reba_groups, rula_groups};
use super::page::document;
use super::style::{Level, css, method_levels};
use crate::ergonomics::{Profile, ScoringMethod, TaskInputs, reba_action_words, rula_action_words};
use crate::scenario::Origin;
use crate::scoring::{Frame, Input, MotionKind, ScoredSide, Summary};
use maud::{Markup, PreEscaped, html};

/// A frame whose sheet was asked for.
#[derive(Debug, Clone, Copy)]
pub struct Picked<'a> {
    /// The motion.
    pub summary: &'a Summary,
    /// The side.
    pub side: &'a ScoredSide,
    /// Every input with its origin.
    pub inputs: &'a [Input],
    /// Index of the trial or rollout.
    pub track: usize,
    /// Index of the frame in it.
    pub time: usize,
}

impl Picked<'_> {
    fn frame(&self) -> Option<&Frame> {
        self.side.tracks.get(self.track)?.frames.get(self.time)
    }

    fn track_name(&self) -> &str {
        self.side.tracks.get(self.track).map_or("", |t| &t.name)
    }
}

/// `worksheets/<side>-<time>s[-<track>].html` and `.csv`.
pub fn sheet_files(picked: &Picked) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let Some(frame) = picked.frame() else { return Ok(Vec::new()) };
    let track = if picked.side.tracks.len() > 1 {
        format!("-{}{}", picked.summary.kind.track_word(), picked.track_name())
    } else {
        String::new()
    };
    let stem = format!("worksheets/{}-{:.3}s{track}", picked.side.side.name(), frame.time_s);
    let profile = &picked.summary.profile;
    Ok(vec![
        (format!("{stem}.html"), page(picked, frame).into_bytes()),
        (format!("{stem}.csv"), csv_text(frame, profile)?),
    ])
}

const STYLE: &str = "
.sheet td.n.score { font-weight: 680; font-size: 1.05em; width: 3.2em; }
.sheet { table-layout: fixed; }
.sheet th:first-child { width: 9.5em; }
.sheet th.n { width: 4em; }
.sheet.inputs th:first-child { width: 17em; }
.sheet tr.sum > * { background: #edf0f4; }
.sheet tr.look > * { border-bottom: 0; }
.strip { display: inline-flex; flex-wrap: wrap; margin-top: 3px; }
.strip span { border: 1px solid var(--line); border-left-width: 0; min-width: 2.1em; text-align: center; line-height: 1.25; padding: 1px 3px; }
.strip span:first-child { border-left-width: 1px; }
.strip i { display: block; font-style: normal; font-size: .78em; color: var(--muted); }
.strip .hit { outline: 2px solid var(--ink); outline-offset: -1px; font-weight: 700; background: #e8f2f9; }
.total { display: flex; align-items: baseline; gap: 14px; margin: 12px 0 0; }
.total b { font-size: 1.7rem; line-height: 1.2; }
.two { display: grid; grid-template-columns: 1fr 1fr; gap: 0 28px; }
.sign { display: grid; grid-template-columns: 2fr 1fr 2fr; gap: 28px; margin-top: 34px; }
.sign span { border-top: 1px solid var(--muted); color: var(--muted); font-size: .88rem; padding-top: 3px; }
@media (max-width: 700px) { .two { grid-template-columns: 1fr; } }
@media print {
  html { font-size: 8.6pt; }
  .sheet td, .sheet th { padding: 2px 4px; }
  section.method { break-after: page; }
  .strip .hit, .sheet tr.sum > * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}";

fn page(picked: &Picked, frame: &Frame) -> String {
    let s = picked.summary;
    let side = picked.side.side.name();
    let title = format!("Worksheet, {side} side, {:.2} s \u{2013} {}", frame.time_s, s.source);
    let track = (picked.side.tracks.len() > 1)
        .then(|| format!(", {} {}", s.kind.track_word(), picked.track_name()));
    let intro = html! {
        style { (PreEscaped(STYLE)) }
        h1 { "Worksheet of one posture: " (side) " side at " (format!("{:.2}", frame.time_s)) " s" }
        p.note {
            code { (s.source) } @if let Some(track) = track { (track) } ", " (kind(s.kind)) ", body " (s.body)
            ". Profile " code { (s.profile.name) } ". Angles in degrees, flexion positive."
        }
    };
    let (rula, reba) = (&frame.rula, &frame.reba);
    let body = html! {
        section.method.verdict {
            h2 { "RULA" }
            (groups(&rula_groups(frame, &s.profile)))
            (total("Grand score", rula.grand, rula.action_level, &method_levels(ScoringMethod::Rula), rula_action_words(rula.action_level)))
            @if picked.side.muscle.is_open() { (if_muscle_use(picked, frame)) }
            p.note.small { "RULA: Applied Ergonomics 24(2):91-99, 1993. Muscle use and force count in both groups." }
        }
        section.method {
            h2 { "REBA" }
            (groups(&reba_groups(frame, &s.profile)))
            (total("Final score", reba.total, reba.action_level, &method_levels(ScoringMethod::Reba), reba_action_words(reba.action_level)))
            p.note.small { "REBA: Applied Ergonomics 31:201-205, 2000. Twist and side bend share one point." }
        }
        section {
            h2 { "Where every input comes from" }
            (inputs(picked.inputs))
            h3 { "Thresholds of profile " code { (s.profile.name) } }
            (thresholds(&s.profile))
            div.sign { span { "Checked by" } span { "Date" } span { "Signature" } }
        }
    };
    document(&title, &intro, &body, &maud::html! {})
}

/// Totals for the other answer to a question that the motion is too short for.
fn if_muscle_use(picked: &Picked, frame: &Frame) -> Markup {
    let mut other = *frame;
    let task =
        TaskInputs { static_gt_1min: true, load_static_or_repeated: true, ..picked.side.task };
    other.enter(&task, &picked.summary.profile);
    html! {
        p.note {
            "Whether the posture is held for more than 1 min, or the movement repeated more than 4 times a minute, is open. \
             If so: RULA " strong { (other.rula.grand) } ", REBA " strong { (other.reba.total) } "."
        }
    }
}

fn kind(kind: MotionKind) -> &'static str {
    match kind {
        MotionKind::Recording => "a recording",
        MotionKind::JointAngles => "joint angles",
        MotionKind::Rollouts => {
            "a sampled posture, one of many that the posture model thinks likely"
        }
    }
}

fn groups(groups: &[Group]) -> Markup {
    html! {
        @for group in groups {
            h3 { (group.title) }
            table.sheet {
                thead { tr {
                    th scope="col" { "Step" } th scope="col" { "Entered" }
                    th scope="col" { "Adds up" } th.n scope="col" { "Score" }
                } }
                tbody {
                    @for line in &group.lines {
                        @let is_total = line.row.is_some() || line.step.starts_with("Score") || line.step == "REBA";
                        tr.sum[is_total] {
                            th scope="row" { (line.step) }
                            @if let Some(row) = &line.row {
                                td colspan="2" { (line.entered) ", column " (row.columns) ":" br; (strip(row)) }
                            } @else if line.sum.is_empty() {
                                td colspan="2" { (line.entered) }
                            } @else if line.entered.is_empty() {
                                td colspan="2" { (line.sum) }
                            } @else {
                                td { (line.entered) }
                                td { (line.sum) }
                            }
                            td.n.score { (line.score) }
                        }
                    }
                }
            }
        }
    }
}

/// The row of a table, the cell meant framed.
fn strip(row: &TableRow) -> Markup {
    html! {
        span.strip {
            @for (i, (heading, value)) in row.cells.iter().enumerate() {
                span.hit[i == row.hit] { i { (heading) } (value) }
            }
        }
    }
}

fn total(name: &str, score: u8, level: u8, levels: &[Level], words: &str) -> Markup {
    let color = levels.iter().find(|l| l.number == level).map(|l| css(l.color));
    html! {
        p.total {
            span { (name) } b { (score) }
            @if let Some(color) = color {
                span.badge style={ "background:" (color) "55;border-color:" (color) } { "action level " (level) }
            }
            span { (words) }
        }
    }
}

fn inputs(inputs: &[Input]) -> Markup {
    html! {
        table.sheet.inputs {
            thead { tr { th scope="col" { "Input" } th scope="col" { "Value" } th scope="col" { "Where from" } } }
            tbody {
                @for i in inputs {
                    tr { th scope="row" { (i.input) } td { (i.value) } td { (origin(i.origin)) } }
                }
            }
        }
    }
}

fn origin(origin: Origin) -> &'static str {
    match origin {
        Origin::Measured => "measured",
        Origin::Predicted => "predicted by the posture model",
        Origin::FromTheTask => "from the task",
        Origin::Assumed => "assumed",
        Origin::Unknown => "unknown",
    }
}

/// Every number that the papers leave open, and the fixed ones beside them.
fn thresholds(p: &Profile) -> Markup {
    let far =
        p.rula_trunk_far_extension_deg.map_or("never".to_owned(), |d| format!("beyond {d}\u{b0}"));
    let on = if p.or_more_is_higher { "the higher class" } else { "the lower class" };
    let lines: [(&str, String); 16] = [
        (
            "shoulder raised",
            format!(
                "girdle > {}\u{b0}, less {} per degree of arm above 30\u{b0}",
                p.shoulder_raised_deg, p.girdle_rhythm
            ),
        ),
        ("upper arm abducted", format!("> {}\u{b0}", p.abducted_deg)),
        (
            "upper arm classed by",
            format!("{:?} rule; 20, 45, 90\u{b0}", p.upper_arm_rule).to_lowercase(),
        ),
        ("lower arm", "60 to 100\u{b0}".to_owned()),
        ("across the midline", format!("> {:.0} mm", 1e3 * p.midline_tolerance_m)),
        ("out to the side", format!("> {:.0} mm outside the shoulder", 1e3 * p.out_margin_m)),
        ("wrist neutral (RULA)", format!("\u{b1}{}\u{b0}; then 15\u{b0}", p.wrist_neutral_deg)),
        ("wrist deviated", format!("> {}\u{b0}", p.wrist_deviated_deg)),
        ("end of twist", format!("> {}\u{b0} from mid-prone", p.wrist_twist_deg)),
        (
            "neck",
            format!(
                "extension beyond {}\u{b0}; 10 and 20\u{b0} (REBA 20\u{b0})",
                p.neck_extension_deg
            ),
        ),
        (
            "neck twist, side bend",
            format!("> {}\u{b0}, > {}\u{b0}", p.neck_twist_deg, p.neck_side_deg),
        ),
        ("trunk upright", format!("\u{b1}{}\u{b0}; then 20 and 60\u{b0}", p.trunk_upright_deg)),
        ("trunk extension, class 3", format!("RULA {far}, REBA beyond 20\u{b0}")),
        (
            "trunk twist, side bend",
            format!("> {}\u{b0}, > {}\u{b0}", p.trunk_twist_deg, p.trunk_side_deg),
        ),
        (
            "RULA table A; over 10 kg",
            format!("{:?}; {} if intermittent", p.rula_table_a, p.rula_force_over_10kg),
        ),
        ("angle on an \u{201c}or more\u{201d} threshold", on.to_owned()),
    ];
    html! {
        div.two {
            @for half in lines.chunks(8) {
                dl.pairs { @for (name, value) in half { dt { (name) } dd { (value) } } }
            }
        }
    }
}
