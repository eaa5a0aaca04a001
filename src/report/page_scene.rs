//! The moving scene of the page: markup, data and the library that draws it.

use super::ReportError;
use super::figure_paths::role;
use super::style::{Pen, Stroke, css, method_levels, segment_color};
use super::view::{View, family_words};
use crate::ergonomics::{BandOverTime, ScoringMethod};
use crate::human::SegmentKind;
use crate::planner::{CandidateResult, SceneMotion, SceneObstacle};
use maud::{Markup, PreEscaped, html};
use serde::Serialize;

/// Draws the scene; part of the page.
const SCENE_SCRIPT: &str = include_str!("scene.js");
/// plotly.js, compressed with gzip, in base64 (`build.rs`): less than half of its size.
const LIBRARY: &str = include_str!(concat!(env!("OUT_DIR"), "/plotly.js.gz.base64"));

/// The scene and what is said beside it.
#[derive(Serialize)]
struct PageScene<'a> {
    workspace_m: Option<[[f64; 3]; 2]>,
    obstacles: &'a [SceneObstacle],
    motions: Vec<PageMotion<'a>>,
    facing: [f64; 2],
    /// The body that is shown first.
    body: &'a str,
    levels: Vec<PageLevel>,
    segments: Vec<PageSegment>,
}

/// How a kind of segment is coloured.
#[derive(Serialize)]
struct PageSegment {
    kind: SegmentKind,
    /// None: that of the action level of the moment.
    color: Option<String>,
}

#[derive(Serialize)]
struct PageMotion<'a> {
    #[serde(flatten)]
    motion: &'a SceneMotion,
    name: String,
    color: String,
    dash: &'static str,
    /// x, y, z of the TCP, whole mm.
    tcp_mm: Vec<i64>,
    /// At the moments of the motion.
    time_s: Vec<f64>,
    scores: Vec<PageScores<'a>>,
}

#[derive(Serialize)]
struct PageScores<'a> {
    body: &'a str,
    rula: BandOverTime,
    reba: BandOverTime,
}

#[derive(Serialize)]
struct PageLevel {
    number: u8,
    /// Highest score of the level.
    to: u8,
    color: String,
    words: &'static str,
}

/// The reported paths that can be shown, best first.
fn shown<'a>(view: &View<'a>) -> Vec<(&'a CandidateResult, &'a SceneMotion)> {
    let motions = &view.result.scene.motions;
    let with_motion =
        |c: &&'a CandidateResult| Some((*c, motions.iter().find(|m| m.candidate == c.id)?));
    view.reported.iter().filter_map(with_motion).collect()
}

fn page_motion<'a>(
    view: &View,
    candidate: &'a CandidateResult,
    motion: &'a SceneMotion,
) -> Option<PageMotion<'a>> {
    let path = candidate.path.as_ref()?;
    let (_, pen) = role(view, candidate);
    let at = |values: &[f64]| -> Vec<f64> {
        motion.samples.iter().filter_map(|&k| values.get(k).copied()).collect()
    };
    let band =
        |b: &BandOverTime| BandOverTime { mean: at(&b.mean), p05: at(&b.p05), p95: at(&b.p95) };
    let scores = candidate.bodies.iter().map(|b| PageScores {
        body: &b.body,
        rula: band(&b.rula().distribution.band),
        reba: band(&b.reba().distribution.band),
    });
    let millimetres = |t: &[f64; 7]| [t[0], t[1], t[2]].map(|v| (1e3 * v).round() as i64);
    Some(PageMotion {
        motion,
        name: named(candidate),
        color: css(pen.color),
        dash: match pen.stroke {
            Stroke::Solid => "solid",
            Stroke::Dashed => "dash",
            Stroke::Dotted => "dot",
        },
        tcp_mm: path.tcp.iter().flat_map(millimetres).collect(),
        time_s: at(&path.time_s),
        scores: scores.collect(),
    })
}

fn named(candidate: &CandidateResult) -> String {
    let rank = candidate.rank.map_or_else(String::new, |r| format!("{r}. "));
    format!("{rank}{} ({})", candidate.id, family_words(candidate.family))
}

/// The section; its controls appear when the script has made the scene.
pub(super) fn section(view: &View) -> Markup {
    let paths = shown(view);
    let Some((first, _)) = paths.first() else {
        return html! { p { "No path was scored, so nothing moves." } };
    };
    html! {
        p.onscreen {
            "The robot, the person as a mannequin, and the paths; in motion. The person shown is the \
             repetition nearest to the mean posture of all. Translucent ghosts are other repetitions, spread evenly \
             over their ranking by RULA: how much "
            (if view.shows_people() { "postures vary, from person to person and each time." } else { "this one person's posture varies." })
        }
        noscript { p.note { "The scene needs scripts. The figures below show start and goal without them." } }
        p.note.scripted id="scene-status" role="status" { "The scene is being made \u{2026}" }
        p.printed { "The scene moves on a screen only; the figure shows start and goal." }
        div.scene id="scene-box" hidden {
            div.controls role="group" aria-label="What the scene shows" {
                label { "Path " select id="scene-path" {
                    @for (i, (c, _)) in paths.iter().enumerate() { option value=(i) { (named(c)) } }
                } }
                label { "Body size " select id="scene-body" {
                    @for b in &first.bodies {
                        option value=(b.body) selected[view.body == Some(b.body.as_str())] { (b.body) }
                    }
                } }
                label { input type="checkbox" id="scene-ghosts" checked; " Ghosts" }
                span.views role="group" aria-label="View" {
                    @for (id, words) in [("free", "Free"), ("side", "Side"), ("front", "Front"), ("top", "Top")] {
                        button type="button" data-view=(id) { (words) }
                    }
                }
            }
            div id="scene-plot" tabindex="0" role="group"
                aria-label="3-D scene. Drag or use the arrow keys to turn it, plus and minus to zoom." {}
            (key(view, &paths))
            div.controls role="group" aria-label="Time" {
                button type="button" id="scene-play" { "Play" }
                label.wide { "Time " input type="range" id="scene-frame" min="0" max="99" value="0"; }
                span id="scene-time" {}
            }
            dl.readout id="scene-readout" aria-live="polite" {
                div { dt { span.swatch id="scene-swatch" {} "Person shown, now" } dd id="scene-own" {} }
                div { dt { "RULA of all repetitions, now" } dd id="scene-rula" {} }
                div { dt { "REBA of all repetitions, now" } dd id="scene-reba" {} }
            }
            p.note {
                "The shirt has the colour of the RULA action level of the moment: "
                @for (i, l) in method_levels(ScoringMethod::Rula).iter().enumerate() {
                    @if i > 0 { ", " }
                    span.swatch style={ "background:" (css(l.color)) } {} (l.number) " " (l.words)
                }
                ". Grid 0.5 m. A ghost disappears when its hand can no longer follow."
            }
        }
    }
}

/// What the lines and bodies are; each differs from the others in more than colour.
fn key(view: &View, paths: &[(&CandidateResult, &SceneMotion)]) -> Markup {
    let mut pens: Vec<(Pen, &str)> = Vec::new();
    for (candidate, _) in paths {
        let (depth, pen) = role(view, candidate);
        let words = ["other paths", "straight path", "your own path", "best path"];
        let entry = (pen, words[usize::from(depth).min(3)]);
        if !pens.contains(&entry) {
            pens.push(entry);
        }
    }
    html! {
        ul.key-list aria-label="Key" {
            @for (pen, words) in pens {
                li { span.stroke style={ "border-top:4px " (pen.stroke.css()) " " (css(pen.color)) } {} (words) }
            }
            li { "the chosen path is the thickest" }
            @if view.result.scene.workspace_m.is_some() {
                li { span.stroke style="border-top:2px dotted #005a8c" {} "workspace of the tool" }
            }
            li { span.swatch style="background:#c3cad5" {} "robot" }
            li { span.swatch style="background:#4b5c7833" {} "ghosts" }
        }
    }
}

/// Data, library and script; empty without a scored path.
pub(super) fn scripts(view: &View) -> Result<Markup, ReportError> {
    let paths = shown(view);
    let Some((first, _)) = paths.first() else { return Ok(html! {}) };
    let page = PageScene {
        workspace_m: view.result.scene.workspace_m,
        obstacles: &view.result.scene.obstacles,
        motions: paths.iter().filter_map(|(c, m)| page_motion(view, c, m)).collect(),
        facing: view.result.setting.facing,
        body: view.body.or(first.bodies.first().map(|b| b.body.as_str())).unwrap_or_default(),
        levels: method_levels(ScoringMethod::Rula)
            .iter()
            .map(|l| PageLevel {
                number: l.number,
                to: l.scores.1,
                color: css(l.color),
                words: l.words,
            })
            .collect(),
        segments: SegmentKind::ALL
            .map(|kind| PageSegment { kind, color: segment_color(kind).map(css) })
            .into(),
    };
    // No `<` in the data can end the element or open a comment.
    let data = serde_json::to_string(&page)?.replace('<', "\\u003c");
    Ok(html! {
        script type="application/json" id="scene-data" { (PreEscaped(data)) }
        script type="text/plain" id="scene-library" { (LIBRARY) }
        script { (PreEscaped(SCENE_SCRIPT)) }
    })
}

#[cfg(test)]
mod tests {
    use base64::Engine as _;
    use base64::engine::general_purpose::STANDARD;
    use flate2::read::GzDecoder;
    use std::io::Read as _;

    #[test]
    fn the_library_is_plotly_alone() {
        let packed = STANDARD.decode(super::LIBRARY).unwrap();
        let mut script = String::new();
        GzDecoder::new(&packed[..]).read_to_string(&mut script).unwrap();
        assert!(script.contains("plotly.js v3") && !script.contains("</script>"));
        assert!(script.len() < 5_500_000 && super::LIBRARY.len() < 2_500_000, "{}", script.len());
    }
}
