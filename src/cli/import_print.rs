//! What `import` prints: sizes, and residuals of each segment.

use crate::human::Side;
use crate::training::{FitReport, Import, ImportedFile, Residuals, SegmentQuality};
use crate::words::number::percent;
use comfy_table::{CellAlignment, Table, presets};
use serde_json::{Value, json};

pub(super) fn as_json(done: &Import, names: &[String], body: &str) -> Value {
    let files: Vec<Value> = done
        .files
        .iter()
        .zip(names)
        .map(|(file, motion)| {
            let runs: Vec<Value> = file
                .runs
                .iter()
                .map(|run| {
                    json!({
                        "first_frame": run.first_frame,
                        "gaps_filled": run.gaps_filled,
                        "frames_left_out": run.frames_left_out,
                        "fit": run.source.fit(),
                        "segments": run.segments,
                        "feet": run.feet,
                    })
                })
                .collect();
            json!({
                "source": file.name,
                "sha256": file.runs.first().map(|r| &r.source.sha256),
                "motion": motion,
                "sizes": file.sizes.parts,
                "runs": runs,
            })
        })
        .collect();
    json!({
        "body": {"file": body, "size": done.body.size},
        "files": files,
        "warnings": done.warnings,
    })
}

/// Residuals of the segments of a run as a table.
pub(super) fn quality_table(segments: &[SegmentQuality]) -> Table {
    let mut table = plain(&["", "joint centre", "", "", "axes", "", ""]);
    table.add_row(["segment", "constant", "scatter", "95 % in", "constant", "scatter", "95 % in"]);
    for segment in segments {
        let figures = |r: &Residuals, unit: &str, digits: usize| {
            [r.constant, r.median, r.p95].map(|v| format!("{v:.digits$} {unit}"))
        };
        let cells = [figures(&segment.place_mm, "mm", 1), figures(&segment.turn_deg, "deg", 1)];
        table.add_row(std::iter::once(segment.segment.clone()).chain(cells.into_iter().flatten()));
    }
    aligned(table, 7)
}

pub(super) fn print_text(done: &Import, side: Side) {
    for file in &done.files {
        sizes(file);
        for (i, run) in file.runs.iter().enumerate() {
            let Some(fit) = run.source.fit() else { continue };
            let rate = run.source.trials.first().map_or(1.0, |t| t.rate_hz);
            let seconds = fit.frames as f64 / rate;
            let which = if file.runs.len() > 1 {
                format!("run {} from frame {}, ", i + 1, run.first_frame)
            } else {
                String::new()
            };
            say!("\n{}: {which}{} frames at {rate} Hz, {seconds:.1} s", file.name, fit.frames);
            say!("{}", quality_table(&run.segments));
            figures(fit);
            if run.gaps_filled > 0 {
                say!("  gaps                {} filled", run.gaps_filled);
            }
            if let Some(feet) = run.feet {
                say!(
                    "  planted feet        slide by {:.0} mm (median of {} times), at most {:.0} mm",
                    feet.median_mm,
                    feet.stands,
                    feet.largest_mm
                );
            }
        }
    }
    let size = done.body.size;
    say!(
        "\nfitted in `{}`, {} of {:.3} m, following the {} hand",
        done.body.name,
        size.sex,
        size.stature_m,
        side.name()
    );
}

fn sizes(file: &ImportedFile) {
    if file.sizes.parts.is_empty() {
        return;
    }
    say!("{}: sizes", file.name);
    let mut table = plain(&["", "length", "of a man of", "men shorter", "women shorter"]);
    for part in &file.sizes.parts {
        table.add_row([
            part.part.to_owned(),
            format!("{:.3} m", part.length_m),
            format!("{:.2} m", part.stature_m),
            percent(part.shorter[0]),
            percent(part.shorter[1]),
        ]);
    }
    say!("{}", aligned(table, 5));
}

fn figures(fit: &FitReport) {
    let hand = fit.hand_residual_mm;
    say!(
        "  hand residual       median {:.1} mm, 95 % within {:.1} mm, largest {:.1} mm after the constant",
        hand.p50,
        hand.p95,
        hand.max
    );
    let turned: Vec<String> = fit
        .calibration_deg
        .iter()
        .filter(|(_, turn)| turn.iter().any(|a| a.abs() >= 0.5))
        .map(|(name, [x, y, z])| format!("{name} {x:.0} {y:.0} {z:.0}"))
        .collect();
    if !turned.is_empty() {
        say!("  calibration         {} deg (about forward, up, right)", turned.join(", "));
    }
    let worst: Vec<String> = fit
        .joints_at_limit
        .iter()
        .take(3)
        .map(|(joint, share)| format!("{joint} {}", percent(*share)))
        .collect();
    let which = if worst.is_empty() { String::new() } else { format!(" ({})", worst.join(", ")) };
    say!("  at a limit          {} of the frames{which}", percent(fit.frames_at_limit_share));
}

fn plain(header: &[&str]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header(header.iter().copied());
    table
}

fn aligned(mut table: Table, columns: usize) -> Table {
    for column in 1..columns {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}
