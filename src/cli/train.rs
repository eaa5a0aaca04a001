//! `ergopath train`: learns a posture model from recordings and judges it on held-out movement.

use super::evaluate::parse_pull;
use super::train_print::{print_json, print_text};
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, suggest};
use crate::human::{Body, Side};
use crate::posture::{MODEL_SCHEMA, Method, PostureModel, Provenance, model_text};
use crate::recording::read;
use crate::report::{Learned, ReportError, held_out_figure, weights_figure};
use crate::training::{
    Dataset, FitReport, FitSettings, PullRule, TrainSettings, Trial, data_csv, fit,
    held_out_curves, read_motion, train, weight_spread,
};
use crate::words::number::percent;
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
    /// Folder for pictures of the training: weights.png, the weight of each joint with its uncertainty,
    /// and `held_out.png`, predicted against recorded joint angles of a movement that was held out.
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// How the model pulls towards the person's own postures: by the hand's travel (per-metre, the
    /// default), by time (per-second), or not at all (none).
    #[arg(long, value_parser = parse_pull, value_name = "RULE")]
    pull: Option<PullRule>,
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
    pub sha256: String,
    pub simulated: bool,
    pub trials: Vec<Trial>,
    /// How the angles came about, a line each.
    pub lines: Vec<String>,
    pub notes: Vec<String>,
    pub fit: Option<FitReport>,
}

/// Whom to look for in recordings.
pub(super) struct Wanted<'a> {
    pub person: Option<&'a str>,
    pub side: Side,
    pub body: &'a Body,
}

/// Trains and writes the model.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let body = Body::load(&args.body, Path::new("."))?;
    let settings = TrainSettings { pull: args.pull, ..Default::default() };
    let wanted = Wanted { person: args.person.as_deref(), side: args.side, body: &body };
    let sources: Result<Vec<Source>, InputError> =
        args.recordings.iter().map(|path| source(path, &wanted)).collect();
    let sources = sources?;
    refuse_mixture(&sources, args)?;
    let trials: Vec<Trial> = sources.iter().flat_map(|s| s.trials.clone()).collect();
    let dataset = Dataset::new(&trials, &body, args.side)?;
    let stem = args.output.file_stem().unwrap_or_default().to_string_lossy();
    let name = args.name.clone().unwrap_or_else(|| stem.replace('_', " "));
    // What cannot be written must not cost minutes.
    outputs.expect_file(&args.output, MODEL_SCHEMA.as_bytes())?;
    args.figures.as_deref().map_or(Ok(()), |folder| outputs.expect_folder(folder))?;
    let model = train(&dataset, &name, args.method, &settings, provenance(&sources, &body, args))?;
    let mut pictures = Vec::new();
    if let Some(folder) = &args.figures {
        let drawn = draw(&dataset, &trials, &model, &settings)?;
        pictures.extend(drawn.iter().map(|(name, _)| folder.join(name)));
        outputs.folder(folder, drawn.into_iter().map(|(name, png)| (name.to_owned(), png)))?;
    }
    if let Some(export) = &args.export {
        outputs.file(export, data_csv(&dataset))?;
    }
    outputs.file(&args.output, model_text(&model)?)?;
    outputs.write()?;
    for note in sources.iter().flat_map(|s| &s.notes) {
        complain!("warning: {note}");
    }
    if args.json {
        print_json(&sources, &dataset, &model, &pictures);
    } else {
        print_text(&sources, &dataset, &model, &args.output);
        for path in &pictures {
            say!("{}", path.display());
        }
        if let Some(reason) = no_weights(model.method).filter(|_| args.figures.is_some()) {
            say!("no weights.png: {reason}");
        }
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

/// The pictures as (name, bytes).
fn draw(
    dataset: &Dataset,
    trials: &[Trial],
    model: &PostureModel,
    settings: &TrainSettings,
) -> Result<Vec<(&'static str, Vec<u8>)>, InputError> {
    let fault = |e: ReportError| InputError::fault("figures", e.to_string());
    let whose = Learned { model: &model.name, is_simulated: model.provenance.simulated };
    let mut pictures = Vec::new();
    if let Some(spread) = weight_spread(dataset, model, settings)? {
        pictures.push(("weights.png", weights_figure(&spread, &whose).map_err(fault)?));
    }
    let curves = held_out_curves(dataset, model.method, settings)?;
    let recording = trials.get(curves.trial).map_or("", |t| t.source.as_str());
    pictures.push(("held_out.png", held_out_figure(&curves, recording, &whose).map_err(fault)?));
    Ok(pictures)
}

/// Why a method has no weights to draw; none where it has.
fn no_weights(method: Method) -> Option<&'static str> {
    match method {
        Method::Promp => Some("W of promp changes with the phase of the movement"),
        Method::Gp => Some("gp has no W"),
        method if method.identifies_weights() => None,
        _ => Some("W of this method is the identity: all joints weigh the same"),
    }
}
