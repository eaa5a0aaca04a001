//! Small multiples of the cells of several runs, all at one scale.

use super::ReportError;
use super::comparison::{Comparison, NamedRun};
use super::figure_paths::{Look, draw, shown};
use super::panel::{Panel, Words};
use super::sheet::png;
use super::view::View;
use crate::planner::RunResult;

/// Runs beyond this number are not drawn.
const MOST: usize = 8;
const WIDTH: u32 = 1600;
/// Room for the words around a row of panels, px.
const AROUND: f64 = 150.0;

/// Every run that has a path, from the side and from above; none without any.
pub(super) fn cells(
    comparison: &Comparison,
    results: &[NamedRun],
) -> Result<Option<Vec<u8>>, ReportError> {
    let result = |name: &str| -> Option<&RunResult> {
        results.iter().find(|(n, _)| n == name)?.1.as_ref().ok()
    };
    let ranked = comparison.ranked();
    let done = ranked.iter().filter(|r| r.best().is_some());
    let views: Vec<(&str, View)> = done
        .filter_map(|r| Some((r.name.as_str(), View::of(result(&r.name)?))))
        .take(MOST)
        .collect();
    if views.is_empty() {
        return Ok(None);
    }
    let columns = [(110.0, 780.0), (900.0, 1570.0)];
    let looks = |v: &View| [Look::Side(v.result.setting.facing), Look::Top];
    // One scale for all: that at which the widest panel fits; then every row is as high as it needs.
    let mut px_per_m = f64::INFINITY;
    let mut heights = Vec::new();
    for (_, view) in &views {
        let bounds = looks(view).map(|look| shown(view, look));
        for ((low, high), (left, right)) in bounds.iter().zip(columns) {
            px_per_m = px_per_m.min((right - left) / (high[0] - low[0]).max(1e-9));
        }
        heights.push(bounds.iter().map(|(low, high)| high[1] - low[1]).fold(0.0, f64::max));
    }
    // A tall cell must not make the page endless.
    let tallest = heights.iter().copied().fold(0.0, f64::max);
    px_per_m = px_per_m.min(560.0 / tallest.max(1e-9));
    let rows: Vec<f64> = heights.iter().map(|h| h * px_per_m).collect();
    let height = rows.iter().map(|h| h + AROUND).sum::<f64>() + 20.0;
    png("cells", (WIDTH, height.ceil() as u32), |sheet| {
        let mut top = 60.0;
        for ((name, view), row) in views.iter().zip(&rows) {
            for (look, x_px) in looks(view).into_iter().zip(columns) {
                let (low, high) = shown(view, look);
                let y_px = (top, top + row);
                let panel = Panel { x_px, y_px, x: (low[0], high[0]), y: (low[1], high[1]) }
                    .equalised(px_per_m);
                draw(sheet, view, look, &panel)?;
                let side = matches!(look, Look::Side(_));
                let title =
                    if side { format!("{name}, from the side") } else { "From above".into() };
                let (x, y) = if side { ("forward (m)", "height (m)") } else { ("x (m)", "y (m)") };
                panel.axes(sheet, Words { title: &title, x, y }, &panel.y_ticks())?;
            }
            top += row + AROUND;
        }
        Ok(())
    })
    .map(Some)
}
