//! The page of `ergopath watch`: how the cell stands, above the last report in a frame. It holds no
//! figure of its own; its script asks for news and puts them in.

use super::page::{CSS, list, ticked};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const SCRIPT: &str = include_str!("watch.js");
const OWN_CSS: &str = "
#watch section { padding: 14px 20px; margin: 12px 0; }
#watch h1 { font-size: 1.25rem; }
#watch progress { width: min(100%, 24em); vertical-align: middle; accent-color: var(--accent); }
#watch pre { overflow-x: auto; font: .9rem/1.4 ui-monospace, Menlo, Consolas, monospace; margin: 0 0 10px; }
#watch .failed { border-top: 6px solid #8a3d00; }
#watch summary { cursor: pointer; }
#watch section > :last-child { margin-bottom: 0; }
#report { display: block; width: 100%; min-height: 400px; border: 0; }
#report[hidden] { display: none; }
";

/// How a watched scenario stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Watched {
    /// Name of its file.
    pub scenario: String,
    /// What is being done.
    pub phase: WatchedPhase,
    /// What the last look at the cell said; none before the first.
    pub check: Option<WatchedCheck>,
    /// Number of pictures of the cell so far.
    pub cell: u64,
    /// Number of reports so far.
    pub report: u64,
    /// Whether the last report is of what was saved last.
    pub is_current: bool,
}

/// What is being done with what was saved last.
#[derive(Debug, Clone, PartialEq)]
pub enum WatchedPhase {
    /// It is read and checked.
    Reading,
    /// It is planned.
    Planning {
        /// What of it.
        stage: &'static str,
        /// Items done.
        done: usize,
        /// Items in all.
        total: usize,
        /// The best objective so far, in a search.
        best: Option<f64>,
    },
    /// Its report is there.
    Done,
    /// It has no report.
    Failed {
        /// The error as a terminal shows it.
        text: String,
    },
}

/// What a look at the cell said, in sentences.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WatchedCheck {
    /// What the scenario says, and what is in reach.
    pub says: Vec<String>,
    /// What a reader should know, without being a fault.
    pub notes: Vec<String>,
    /// What a reader should look at.
    pub warnings: Vec<String>,
    /// What keeps the cell from being of use.
    pub errors: Vec<String>,
}

impl Watched {
    /// A scenario that nobody has looked at.
    pub fn new(scenario: String) -> Self {
        let phase = WatchedPhase::Reading;
        Self { scenario, phase, check: None, cell: 0, report: 0, is_current: false }
    }

    /// Title of the window.
    pub fn title(&self) -> String {
        let state = match self.phase {
            WatchedPhase::Reading => "reading",
            WatchedPhase::Planning { .. } => "planning",
            WatchedPhase::Done => "planned",
            WatchedPhase::Failed { .. } => "error",
        };
        format!("{state}: {}", self.scenario)
    }
}

/// The page around everything.
pub fn watch_page(scenario: &str) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (scenario) }
                link rel="icon" href="data:,";
                style { (PreEscaped(CSS)) (PreEscaped(OWN_CSS)) }
            }
            body {
                main id="watch" {
                    h1 { (scenario) }
                    noscript { p.warning { "This page follows the file by a script; allow scripts for this address." } }
                }
                p.warning id="gone" hidden {
                    "No answer from " code { "ergopath watch" } ": it has ended. Start it again, and this page goes on."
                }
                iframe id="report" title="Report of the last plan" hidden {}
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// The part of the page above the report.
pub fn watch_status(watched: &Watched) -> String {
    let has_report = watched.report > 0;
    let is_failed = matches!(watched.phase, WatchedPhase::Failed { .. });
    html! {
        h1 { (watched.scenario) }
        section class=[is_failed.then_some("failed")] {
            (phase(&watched.phase))
            @if has_report && !watched.is_current {
                p.note { "The report below is that of an earlier save." }
            }
        }
        @if let Some(check) = &watched.check {
            section {
                @for error in &check.errors { p.warning { strong { "Error: " } (ticked(error)) } }
                @for warning in &check.warnings { p.warning { strong { "Warning: " } (ticked(warning)) } }
                details id="says" {
                    summary { "What the scenario says" @if is_failed { ", as it was read last" } }
                    (list(&check.says))
                    @if !check.notes.is_empty() { (list(&check.notes)) }
                }
                @if watched.cell > 0 {
                    details open[!has_report] id="cell" {
                        summary { "The cell" @if is_failed { ", as it was read last" } }
                        img src={ "cell.png?v=" (watched.cell) }
                            alt="The cell from the side and from above, with person and robot at start and goal."
                            style="width:100%;height:auto";
                    }
                }
            }
        }
    }
    .into_string()
}

fn phase(phase: &WatchedPhase) -> Markup {
    html! {
        @match phase {
            WatchedPhase::Reading => p role="status" { "Reading and checking what was saved." },
            WatchedPhase::Planning { stage, done, total, best } => p {
                span role="status" { "Planning: " (stage) }
                " " progress value=(done) max=(total) {} " " (done) " of " (total)
                @if let Some(best) = best { ", best so far " (format!("{best:.2}")) }
            },
            WatchedPhase::Done => p role="status" { "Planned: the report below is that of what was saved last." },
            WatchedPhase::Failed { text } => {
                p role="alert" { strong { "What was saved last cannot be planned." } }
                pre { (text) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_files_say_is_text_and_an_old_report_is_called_one() {
        let mut watched = Watched::new("<b>.toml".to_owned());
        watched.phase = WatchedPhase::Failed { text: "<script>alert(1)</script>".to_owned() };
        watched.report = 1;
        let shown = watch_status(&watched);
        assert!(shown.contains("&lt;script&gt;alert(1)") && !shown.contains("<script>"));
        assert!(shown.contains("&lt;b&gt;.toml") && shown.contains("an earlier save"));
        assert!(watch_page("<b>.toml").contains("&lt;b&gt;.toml"));
        (watched.phase, watched.is_current) = (WatchedPhase::Done, true);
        assert!(!watch_status(&watched).contains("an earlier save"));
    }

    #[test]
    fn the_progress_is_shown() {
        let mut watched = Watched::new("cell.toml".to_owned());
        watched.phase =
            WatchedPhase::Planning { stage: "searching", done: 3, total: 12, best: Some(4.5) };
        let shown = watch_status(&watched);
        assert!(shown.contains("Planning: searching") && shown.contains("3 of 12"), "{shown}");
        assert!(shown.contains("best so far 4.50"));
        assert_eq!(watched.title(), "planning: cell.toml");
    }
}
