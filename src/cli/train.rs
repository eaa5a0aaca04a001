//! `ergopath train`: learns a posture model from recordings and judges it on held-out movement.

use super::{Failure, Outcome};
use crate::files::{InputError, suggest, write_whole};
use crate::human::{Body, Side};
use crate::posture::{Method, MethodQuality, PostureModel, Provenance, save_model};
use crate::recording::read;
use crate::training::{
    Dataset, FitReport, FitSettings, TrainSettings, Trial, data_csv, fit, read_motion, train,
};
use comfy_table::{CellAlignment, Table, presets};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `train`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Recordings of one person: MVNX files, folders of rigid-body CSV files, or joint-motion CSV
    /// files.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Body of the person: a shipped one by name, or a URDF made by `ergopath body`.
    #[arg(long)]
    body: String,
    /// Posture model to write (JSON).
    #[arg(short, long, value_name = "MODEL")]
    output: PathBuf,
    /// Which person of a folder with several.
    #[arg(long)]
    person: Option<String>,
    /// The hand that holds on to the robot.
    #[arg(long, value_parser = parse_side, default_value = "right", value_name = "right|left")]
    side: Side,
    /// Method of the model: full-w, full-w-gp, mi-nsgp, w-ik, nsgp, sb-m, promp, gp or plain-ik.
    #[arg(long, value_parser = parse_method, default_value = "full-w")]
    method: Method,
    /// What to call the model; by default the name of its file.
    #[arg(long)]
    name: Option<String>,
    /// Do not pull towards the person's own postures.
    #[arg(long)]
    no_attraction: bool,
    /// Also write what the model was learned from, as plain numbers.
    #[arg(long, value_name = "DATA.csv")]
    export: Option<PathBuf>,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

pub(super) fn parse_side(text: &str) -> Result<Side, String> {
    match text.to_lowercase().as_str() {
        "right" | "r" => Ok(Side::Right),
        "left" | "l" => Ok(Side::Left),
        _ => Err("use right or left".to_owned()),
    }
}

fn parse_method(text: &str) -> Result<Method, String> {
    let names = Method::ALL.map(Method::name);
    Method::ALL.into_iter().find(|m| m.name() == text).ok_or_else(|| {
        suggest(text, names).unwrap_or_else(|| format!("known are: {}", names.join(", ")))
    })
}

/// What one recording gave.
pub(super) struct Source {
    pub name: String,
    sha256: String,
    simulated: bool,
    pub trials: Vec<Trial>,
    /// How the angles came about, a line each.
    lines: Vec<String>,
    pub notes: Vec<String>,
    fit: Option<FitReport>,
}

/// Whom to look for in recordings.
pub(super) struct Wanted<'a> {
    pub person: Option<&'a str>,
    pub side: Side,
    pub body: &'a Body,
}

/// Trains and writes the model.
pub(super) fn run(args: &Args) -> Result<Outcome, Failure> {
    let body = Body::load(&args.body, Path::new("."))?;
    let settings = TrainSettings { has_attraction: !args.no_attraction, ..Default::default() };
    let wanted = Wanted { person: args.person.as_deref(), side: args.side, body: &body };
    let sources: Result<Vec<Source>, InputError> =
        args.recordings.iter().map(|path| source(path, &wanted)).collect();
    let sources = sources?;
    refuse_mixture(&sources, args)?;
    let trials: Vec<Trial> = sources.iter().flat_map(|s| s.trials.clone()).collect();
    let dataset = Dataset::new(&trials, &body, args.side)?;
    let stem = args.output.file_stem().unwrap_or_default().to_string_lossy();
    let name = args.name.clone().unwrap_or_else(|| stem.replace('_', " "));
    let model = train(&dataset, &name, args.method, &settings, provenance(&sources, &body, args))?;
    write(&dataset, &model, args)?;
    for note in sources.iter().flat_map(|s| &s.notes) {
        complain!("warning: {note}");
    }
    if args.json {
        print_json(&sources, &dataset, &model);
    } else {
        print_text(&sources, &dataset, &model, &args.output);
    }
    Ok(Outcome::Done)
}

/// Reads a recording and fits the body to it, or takes the joint angles of a file.
pub(super) fn source(path: &Path, wanted: &Wanted) -> Result<Source, InputError> {
    let body = wanted.body;
    let is_csv = path.extension().is_some_and(|x| x.eq_ignore_ascii_case("csv"));
    if is_csv && !path.is_dir() {
        return from_angles(path, wanted);
    }
    let recording = read(path, wanted.person)?;
    let motion = fit(&recording, body, wanted.side, &FitSettings::default())?;
    let report = motion.report.clone();
    let mut lines = vec![format!(
        "{} frames at {} Hz, {:.1} s ({})",
        report.frames,
        recording.rate_hz,
        report.frames as f64 / recording.rate_hz,
        recording.format
    )];
    lines.extend(fit_lines(&report, body));
    let notes = recording.notes.iter().chain(&report.notes);
    Ok(Source {
        notes: notes.map(|n| format!("{}: {n}", recording.source)).collect(),
        name: recording.source.clone(),
        sha256: recording.sha256.clone(),
        simulated: false,
        trials: vec![Trial::from(&motion)],
        lines,
        fit: Some(report),
    })
}

fn from_angles(path: &Path, wanted: &Wanted) -> Result<Source, InputError> {
    if let Some(person) = wanted.person {
        let message = format!("holds joint angles of one person, so `{person}` cannot be picked");
        return Err(InputError::new(path, message).remedy("leave out --person for CSV files"));
    }
    let file = read_motion(path, wanted.body, wanted.side)?;
    let rows: usize = file.trials.iter().map(|t| t.q.len()).sum();
    let seconds: f64 = file.trials.iter().map(|t| t.q.len() as f64 / t.rate_hz).sum();
    let kind = if file.simulated { "simulated operator" } else { "joint angles" };
    let filter = file
        .cutoff_hz
        .map_or_else(|| "not filtered: the rate is too low".to_owned(), |f| format!("{f} Hz"));
    Ok(Source {
        name: file.source,
        sha256: file.sha256,
        simulated: file.simulated,
        lines: vec![
            format!("{rows} rows, {seconds:.1} s in {} trials ({kind})", file.trials.len()),
            format!("low-pass filter     {filter}"),
        ],
        trials: file.trials,
        notes: Vec::new(),
        fit: None,
    })
}

fn fit_lines(report: &FitReport, body: &Body) -> Vec<String> {
    let hand = report.hand_residual_mm;
    let worst: Vec<String> = report
        .joints_at_limit
        .iter()
        .take(3)
        .map(|(joint, share)| format!("{joint} {:.0} %", 100.0 * share))
        .collect();
    let at_limits = format!("{:.0} % of the frames", 100.0 * report.frames_at_limit_share);
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

/// Simulated and real movements must not make one model.
fn refuse_mixture(sources: &[Source], args: &Args) -> Result<(), InputError> {
    let simulated = sources.iter().filter(|s| s.simulated).count();
    if simulated != 0 && simulated != sources.len() {
        return Err(InputError::new(&args.output, "would mix a simulated operator with a person")
            .remedy("train them apart"));
    }
    for (i, source) in sources.iter().enumerate() {
        if sources[..i].iter().any(|s| s.sha256 == source.sha256) {
            return Err(InputError::new(&source.name, "is given twice")
                .remedy("a recording that is also held out would make the scores too good"));
        }
    }
    Ok(())
}

fn provenance(sources: &[Source], body: &Body, args: &Args) -> Provenance {
    let fits = sources.iter().any(|s| s.fit.is_some());
    let mut settings = vec![("cutoff_hz".to_owned(), FitSettings::default().cutoff_hz.to_string())];
    if fits {
        let fit = FitSettings::default();
        for (name, value) in [
            ("orientation_sd_deg", fit.orientation_sd_deg),
            ("axial_sd_deg", fit.axial_sd_deg),
            ("tilt_sd_deg", fit.tilt_sd_deg),
            ("limit_slack_deg", fit.limit_slack_deg),
            ("hand_sd_mm", fit.hand_sd_mm),
            ("sharing_sd_deg", fit.sharing_sd_deg),
            ("previous_sd_deg", fit.previous_sd_deg),
        ] {
            settings.push((format!("fit_{name}"), value.to_string()));
        }
    }
    if let Some(person) = &args.person {
        settings.push(("person".to_owned(), person.clone()));
    }
    Provenance {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        simulated: sources.iter().any(|s| s.simulated),
        recordings: sources.iter().map(|s| (s.name.clone(), s.sha256.clone())).collect(),
        body: (body.name.clone(), body.sha256()),
        settings,
        notes: sources.iter().flat_map(|s| s.notes.clone()).collect(),
    }
}

/// Model and data, both or neither.
fn write(dataset: &Dataset, model: &PostureModel, args: &Args) -> Result<(), InputError> {
    let Some(export) = &args.export else { return save_model(model, &args.output) };
    if std::path::absolute(export).ok() == std::path::absolute(&args.output).ok() {
        return Err(InputError::new(export, "is named for both model and data")
            .remedy("give --export and --output different names"));
    }
    let is_new = !export.exists();
    write_whole(export, data_csv(dataset).as_bytes())?;
    let saved = save_model(model, &args.output);
    if saved.is_err() && is_new {
        // The first error is the one to report; a file that stays is visible to the user.
        let _ = std::fs::remove_file(export);
    }
    saved
}

fn print_json(sources: &[Source], dataset: &Dataset, model: &PostureModel) {
    let recordings: Vec<_> = sources
        .iter()
        .map(|s| json!({"source": s.name, "sha256": s.sha256, "simulated": s.simulated, "fit": s.fit}))
        .collect();
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
                "speed_share": model.law.noise.speed_share,
            },
            "model": {"name": model.name, "method": model.method, "provenance": model.provenance},
        })
    );
}

fn print_text(sources: &[Source], dataset: &Dataset, model: &PostureModel, path: &Path) {
    for source in sources {
        say!("{}: {}", source.name, source.lines[0]);
        for line in &source.lines[1..] {
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
         and with\n  the pull towards the person's postures; what the 90 % band of rollouts holds of \
         the held-out joint\n  angles, and how wide it is. plain-ik is the plain pseudo-inverse."
    );
    let groups = model.weight_by_group().into_iter();
    let groups: Vec<String> = groups.map(|(g, s)| format!("{g} {:.0} %", 100.0 * s)).collect();
    say!("\nW of {} by joint group: {}", model.method.name(), groups.join(", "));
    let noise = &model.law.noise;
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    say!(
        "noise: {} directions; {} of the variance white, {} correlated over {:.2} s, {} lasting a whole \
         movement;\n  {} of it grows with the hand speed",
        noise.factor.ncols(),
        percent(noise.shares.white),
        percent(noise.shares.correlated),
        noise.correlation_time_s,
        percent(noise.shares.lasting),
        percent(noise.speed_share)
    );
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
        "90 % band holds",
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
            q.coverage.map_or_else(|| "-".to_owned(), |c| format!("{:.0} %", 100.0 * c.1)),
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
