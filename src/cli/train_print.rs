//! What `train` says: the recordings, the quality of the methods, and what was learned.

use crate::human::Body;
use crate::posture::{Clock, Method, MethodQuality, Noise, PostureModel};
use crate::training::{Angles, Dataset, FitReport, Source};
use crate::words::number::percent;
use comfy_table::{CellAlignment, Table, presets};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Prints JSON at full precision.
pub(super) fn print_json(
    sources: &[Source],
    dataset: &Dataset,
    model: &PostureModel,
    figures: &[PathBuf],
) {
    let recordings: Vec<_> = sources
        .iter()
        .map(|s| json!({"source": s.name, "sha256": s.sha256, "simulated": s.simulated, "fit": s.fit()}))
        .collect();
    let figures: Vec<String> = figures.iter().map(|path| path.display().to_string()).collect();
    say!(
        "{}",
        json!({
            "recordings": recordings,
            "frames": dataset.frames.len(),
            "trials": dataset.trials,
            "quality": model.quality,
            "weight_by_group": model.weight_by_group().into_iter().collect::<std::collections::BTreeMap<_, _>>(),
            "noise": {
                "rank": model.law.noise.factor.ncols(),
                "shares": model.law.noise.shares,
                "correlation_time_s": model.law.noise.correlation_time_s,
                "clock": model.law.noise.clock,
            },
            "figures": figures,
            "model": {"name": model.name, "method": model.method, "provenance": model.provenance},
        })
    );
}

/// Prints what was read, how well the methods do, and what was learned.
pub(super) fn print_text(
    (sources, body): (&[Source], &Body),
    dataset: &Dataset,
    model: &PostureModel,
    path: &Path,
) {
    for source in sources {
        let lines = source_lines(source, body);
        say!("{}: {}", source.name, lines[0]);
        for line in &lines[1..] {
            say!("  {line}");
        }
    }
    let split = if dataset.trials > 1 {
        format!("whole trials of {} held out", dataset.trials)
    } else {
        "first 70 % of the time trains, 0.5 s gap, the rest tests".to_owned()
    };
    say!("\nHeld-out movement ({split}):");
    say!("{}", quality_table(&model.quality, model.method));
    say!(
        "  RMSE of joint velocity over its rms; log-likelihood in nats per frame (floor 0.01 rad/s; in \
         all\n  joints with S_x = (1e-4)^2); mean joint error along the held-out hand path, without \
         and with\n  the pull towards the person's postures; how much of the held-out joint angles \
         the 90 % band of\n  repetitions covers, and how wide it is. plain-ik is the plain pseudo-inverse."
    );
    let groups = model.weight_by_group().into_iter();
    let groups: Vec<String> = groups.map(|(g, s)| format!("{g} {}", percent(s))).collect();
    say!("\nW of {} by joint group: {}", model.method.name(), groups.join(", "));
    say!("noise: {}", noise_text(&model.law.noise));
    if dataset.trials < 3 {
        say!("  (from {} movement(s): what lasts a whole movement cannot be told)", dataset.trials);
    }
    let mark = if model.provenance.simulated { ", simulated" } else { "" };
    say!(
        "{}: `{}` ({}{mark}), learned on all {} frames",
        path.display(),
        model.name,
        model.method.name(),
        dataset.frames.len()
    );
}

/// What a recording holds and how its joint angles came about, a line each.
pub(super) fn source_lines(source: &Source, body: &Body) -> Vec<String> {
    match &source.angles {
        Angles::Fitted { format, rate_hz, report } => {
            let seconds = report.frames as f64 / rate_hz;
            let frames =
                format!("{} frames at {rate_hz} Hz, {seconds:.1} s ({format})", report.frames);
            std::iter::once(frames).chain(fit_lines(report, body)).collect()
        }
        Angles::Given { cutoff_hz } => {
            let trials = &source.trials;
            let rows: usize = trials.iter().map(|t| t.q.len()).sum();
            let seconds: f64 = trials.iter().map(|t| t.q.len() as f64 / t.rate_hz).sum();
            let kind = if source.simulated { "simulated operator" } else { "joint angles" };
            let filter = cutoff_hz.map_or_else(
                || "not filtered: the rate is too low".to_owned(),
                |f| format!("{f} Hz"),
            );
            vec![
                format!("{rows} rows, {seconds:.1} s in {} trials ({kind})", trials.len()),
                format!("low-pass filter     {filter}"),
            ]
        }
    }
}

fn fit_lines(report: &FitReport, body: &Body) -> Vec<String> {
    let hand = report.hand_residual_mm;
    let worst: Vec<String> = report
        .joints_at_limit
        .iter()
        .take(3)
        .map(|(joint, share)| format!("{joint} {}", percent(*share)))
        .collect();
    let at_limits = format!("{} of the frames", percent(report.frames_at_limit_share));
    let offset = report.pelvis_offset_mm;
    let hint = report.stature_hint_m.map_or_else(
        || "not told by the recording".to_owned(),
        |s| format!("{s:.2} m by the arm; the body is {:.2} m", body.size.stature_m),
    );
    vec![
        format!(
            "hand residual       median {:.1} mm, 95 % within {:.1} mm, largest {:.1} mm",
            hand.p50, hand.p95, hand.max
        ),
        // Else a difference of the two pelvis origins would be walked as a bent spine.
        format!(
            "pelvis offset       {:.0} {:.0} {:.0} mm (forward, up, right; constant, taken out before)",
            offset[0], offset[1], offset[2]
        ),
        format!("calibration         {}", calibration(report)),
        format!(
            "coupling error      {:.3} m/s rms, hand speed {:.3} m/s rms",
            report.coupling_error_m_s, report.hand_speed_m_s
        ),
        if worst.is_empty() {
            format!("pressing on limits  {at_limits}")
        } else {
            format!("pressing on limits  {at_limits} ({})", worst.join(", "))
        },
        format!("stature             {hint}"),
        format!(
            "low-pass filter     {} Hz (Butterworth without phase lag, fourth order), then central differences",
            report.cutoff_hz
        ),
    ]
}

/// The constant turns of the arm's segments, in one line.
fn calibration(report: &FitReport) -> String {
    let turned: Vec<String> = report
        .calibration_deg
        .iter()
        .filter(|(_, turn)| turn.iter().any(|a| a.abs() >= 0.5))
        .map(|(name, [x, y, z])| format!("{name} {x:.0} {y:.0} {z:.0}"))
        .collect();
    if turned.is_empty() {
        return "none needed: no joint is recorded beyond its range".to_owned();
    }
    format!("{} deg (about forward, up, right; constant, taken out before)", turned.join(", "))
}

/// What differs between repetitions, in words.
fn noise_text(noise: &Noise) -> String {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let parts = |correlated_over: String| {
        format!(
            "{} directions; {} of the variance white, {} correlated over {correlated_over}, {} lasting a \
             whole movement",
            noise.factor.ncols(),
            percent(noise.shares.white),
            percent(noise.shares.correlated),
            percent(noise.shares.lasting),
        )
    };
    match noise.clock {
        Clock::Hand { speed_m_s, drift } => format!(
            "{};\n  none of it while the hand rests: then joints drift at {:.1} deg/s rms",
            parts(format!("{:.2} m of hand travel", noise.correlation_time_s * speed_m_s)),
            drift.speed_rad_s.to_degrees()
        ),
        Clock::Seconds { speed_share, .. } => format!(
            "{};\n  {} of it grows with the hand speed",
            parts(format!("{:.2} s", noise.correlation_time_s)),
            percent(speed_share)
        ),
    }
}

fn quality_table(quality: &[MethodQuality], chosen: Method) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "",
        "method",
        "relative RMSE",
        "LL null",
        "LL all",
        "path error",
        "with pull",
        "90 % band covers",
        "width",
    ]);
    for q in quality {
        let path = |pick: fn((f64, f64)) -> f64| {
            q.path_error_deg.map_or_else(|| "-".to_owned(), |p| format!("{:.2} deg", pick(p)))
        };
        table.add_row([
            if q.method == chosen { "*" } else { "" }.to_owned(),
            q.method.name().to_owned(),
            format!("{:.3}", q.relative_rmse),
            format!("{:.1}", q.log_likelihood_null),
            format!("{:.1}", q.log_likelihood),
            path(|p| p.0),
            path(|p| p.1),
            q.coverage.map_or_else(|| "-".to_owned(), |c| percent(c.1)),
            q.band_width_deg.map_or_else(|| "-".to_owned(), |w| format!("{w:.1} deg")),
        ]);
    }
    for column in 2..9 {
        if let Some(c) = table.column_mut(column) {
            c.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}
