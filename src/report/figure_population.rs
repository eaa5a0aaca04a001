//! Figures: how repetitions differ on each path, and how body sizes differ on the best one.

use super::ReportError;
use super::figure_box::{BoxPanel, box_plots};
use super::figure_forest::{ForestPanel, ForestRow, forest_plots};
use super::view::View;
use crate::ergonomics::ScoreDistribution;
use crate::planner::BodyScores;

/// `figures/distributions.png`: the time mean of RULA of every repetition on each path.
pub(super) fn distributions(view: &View) -> Result<Vec<u8>, ReportError> {
    let of = |c: &&crate::planner::CandidateResult| {
        let body = view.scores(c)?;
        // Underscores are no place to break a line.
        Some((c.id.replace('_', " "), body.rula().by_rollout.clone()))
    };
    let panel = BoxPanel {
        title: format!(
            "Time mean of RULA over repetitions{}",
            view.body.map_or_else(String::new, |b| format!(", {b}"))
        ),
        unit: "score".to_owned(),
        is_error: false,
        methods: view.reported.iter().filter_map(of).collect(),
    };
    box_plots(&[panel])
}

/// `figures/population.png`: expected scores of the best path for each body size; nothing for one.
pub(super) fn population(view: &View) -> Result<Option<Vec<u8>>, ReportError> {
    let Some(lead) = view.lead.filter(|l| l.bodies.len() > 1) else { return Ok(None) };
    let panel = |title: &str, pick: fn(&BodyScores) -> &ScoreDistribution, reference: f64| {
        let row = |b: &BodyScores| {
            let d = pick(b);
            ForestRow {
                label: b.body.clone(),
                value: Some([d.expected, d.p05, d.p95]),
                is_total: Some(b.body.as_str()) == view.body,
            }
        };
        ForestPanel {
            title: title.to_owned(),
            axis: "score".to_owned(),
            reference,
            rows: lead.bodies.iter().map(row).collect(),
        }
    };
    let panels = [
        panel("Expected RULA", |b| &b.rula().distribution, 4.5),
        panel("Expected REBA", |b| &b.reba().distribution, 7.5),
    ];
    let key = "bold: the body of the verdict; bar: nine of ten repetitions; dashed: action level 3 begins";
    forest_plots(&panels, key).map(Some)
}
