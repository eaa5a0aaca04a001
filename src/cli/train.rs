//! `ergopath train`: learns a posture model from recordings and judges it on held-out movement.

use super::evaluate::parse_pull;
use super::train_print::{print_json, print_text};
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, suggest};
use crate::human::{Body, Pelvis, Side};
use crate::posture::{MODEL_SCHEMA, Method, PostureModel, model_text};
use crate::recording::{Map, read_map};
use crate::report::{Learned, ReportError, held_out_figure, weights_figure};
use crate::training::people::{Person, people_dataset, read_people, read_people_file};
use crate::training::{
    Dataset, PullRule, Source, TrainSettings, Whom, data_csv, held_out_curves, provenance,
    read_person, remarks_of, train, weight_spread,
};
use std::path::{Path, PathBuf};

/// Arguments of `train`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Recordings of one person: MVNX and BVH files, AMC files with their ASF, MOT and STO files of coordinates, folders of rigid-body CSV
    /// files, joint-motion CSV files, or with --map C3D and TRC files and tables; or a TOML file that names
    /// several people.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Body of the person, or the one in which the postures of several people meet: a shipped one by
    /// name, or a URDF made by `ergopath body`.
    #[arg(long)]
    body: String,
    /// Posture model to write (JSON).
    #[arg(short, long, value_name = "MODEL")]
    output: PathBuf,
    /// Which person of a folder with several.
    #[arg(long)]
    person: Option<String>,
    /// What makes the markers of C3D and TRC files, or the points of tables, the segments of a person.
    #[arg(long, value_name = "MAP.toml")]
    map: Option<PathBuf>,
    /// The hand that holds on to the robot.
    #[arg(long, value_parser = parse_side, default_value = "right", value_name = "right|left")]
    side: Side,
    /// Whether the pelvis moves over planted feet or rests, as of somebody who sits: by default it moves
    /// where all recordings hold both legs. With `moves`, hips and knees of recordings without legs are those
    /// that the shipped model of recorded people expects of such a posture.
    #[arg(long, value_parser = parse_pelvis, value_name = "moves|rests")]
    pelvis: Option<Pelvis>,
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

pub(super) fn parse_pelvis(text: &str) -> Result<Pelvis, String> {
    match text.to_lowercase().as_str() {
        "moves" => Ok(Pelvis::Moves),
        "rests" => Ok(Pelvis::Rests),
        _ => Err("use moves or rests".to_owned()),
    }
}

fn parse_method(text: &str) -> Result<Method, String> {
    let names = Method::ALL.map(Method::name);
    Method::ALL.into_iter().find(|m| m.name() == text).ok_or_else(|| {
        suggest(text, names).unwrap_or_else(|| format!("known are: {}", names.join(", ")))
    })
}

fn whom<'a>(args: &'a Args, body: &'a Body, map: Option<&'a Map>) -> Whom<'a> {
    Whom { person: args.person.as_deref(), side: args.side, body, pelvis: args.pelvis, map }
}

/// The recordings of one person, or of the several of a people file.
fn read_recorded(args: &Args, whom: &Whom) -> Result<(Vec<Source>, Dataset), InputError> {
    let is_people = |path: &PathBuf| path.extension().is_some_and(|x| x == "toml");
    let Some(file) = args.recordings.iter().find(|path| is_people(path)) else {
        return read_person(&args.recordings, whom);
    };
    if args.recordings.len() > 1 {
        return Err(InputError::new(file, "names several people, and other recordings are given")
            .remedy("name those in the file too"));
    }
    if args.person.is_some() || args.pelvis == Some(Pelvis::Rests) {
        return Err(InputError::new(file, "names several people, who are learned as a whole")
            .remedy("leave out --person and --pelvis"));
    }
    if args.map.is_some() {
        return Err(InputError::new(file, "names several people, each with a map of their own")
            .remedy("leave out --map, and add map = \"..\" to each [[person]]"));
    }
    let people = read_people(&read_people_file(file)?)?;
    let dataset = people_dataset(&people, whom.body)?;
    let whose = |p: Person| {
        p.sources
            .into_iter()
            .map(move |s| Source { name: format!("{} of {}", s.name, p.name), ..s })
    };
    Ok((people.into_iter().flat_map(whose).collect(), dataset))
}

/// Trains and writes the model.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let body = Body::load(&args.body, Path::new("."))?;
    let settings = TrainSettings { pull: args.pull, ..Default::default() };
    let map = args.map.as_deref().map(read_map).transpose()?;
    let whom = whom(args, &body, map.as_ref());
    let (sources, dataset) = read_recorded(args, &whom)?;
    let stem = args.output.file_stem().unwrap_or_default().to_string_lossy();
    let name = args.name.clone().unwrap_or_else(|| stem.replace('_', " "));
    // What cannot be written must not cost minutes.
    outputs.expect_file(&args.output, MODEL_SCHEMA.as_bytes())?;
    args.figures.as_deref().map_or(Ok(()), |folder| outputs.expect_folder(folder))?;
    // Known before minutes are spent.
    for remark in remarks_of(&sources) {
        complain!("warning: {remark}");
    }
    let model = train(&dataset, &name, args.method, &settings, provenance(&sources, &whom))?;
    let mut pictures = Vec::new();
    if let Some(folder) = &args.figures {
        let drawn = draw(&dataset, &sources, &model, &settings)?;
        pictures.extend(drawn.iter().map(|(name, _)| folder.join(name)));
        outputs.folder(folder, drawn.into_iter().map(|(name, png)| (name.to_owned(), png)))?;
    }
    if let Some(export) = &args.export {
        outputs.file(export, data_csv(&dataset))?;
    }
    outputs.file(&args.output, model_text(&model)?)?;
    outputs.write()?;
    if args.json {
        print_json(&sources, &dataset, &model, &pictures);
    } else {
        print_text((&sources, &body), &dataset, &model, &args.output);
        for path in &pictures {
            say!("{}", path.display());
        }
        if let Some(reason) = no_weights(model.method).filter(|_| args.figures.is_some()) {
            say!("no weights.png: {reason}");
        }
    }
    Ok(Outcome::Done)
}

/// The pictures as (name, bytes).
fn draw(
    dataset: &Dataset,
    sources: &[Source],
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
    let recording = sources.iter().flat_map(|s| &s.trials).nth(curves.trial);
    let recording = recording.map_or("", |t| t.source.as_str());
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
