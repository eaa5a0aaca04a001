//! `ergopath adapt`: a model of several people as that of one worker who was recorded for some seconds.

use super::train::parse_side;
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs};
use crate::human::{Body, Side};
use crate::posture::{MODEL_SCHEMA, PostureModel, load_model, model_text};
use crate::recording::read_map;
use crate::training::people::{Person, read_worker};
use crate::training::{SHORTEST_S, adapt, recorded_s, remarks_of};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `adapt`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Model of several people: the shipped `people`, or a file.
    #[arg(value_name = "MODEL")]
    model: String,
    /// Recordings of one worker, whole body: half a second of movement or more.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// Posture model to write (JSON).
    #[arg(short, long, value_name = "MODEL.json")]
    output: PathBuf,
    /// Body of the worker: a shipped one by name, or a URDF made by `ergopath body`. Without it, one with
    /// arms as long as the recorded ones.
    #[arg(long)]
    body: Option<String>,
    /// The hand that leads; it must be that of the model.
    #[arg(long, value_parser = parse_side, default_value = "right", value_name = "right|left")]
    side: Side,
    /// What makes the markers of C3D and TRC files, or the points of tables, the segments of a person.
    #[arg(long, value_name = "MAP.toml")]
    map: Option<PathBuf>,
    /// What to call the model; by default the name of its file.
    #[arg(long)]
    name: Option<String>,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

/// Reads the recordings, adapts the model, and writes it.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let (model, sha256) = load_model(&args.model, Path::new("."))?;
    super::warn_of_unsealed_model(&args.model, &model);
    if model.side != args.side {
        let message = format!("leads with the {} hand", model.side.name());
        let remedy = "record the worker with that hand leading, or give a model of the other one";
        return Err(InputError::new(&args.model, message).remedy(remedy).into());
    }
    outputs.expect_file(&args.output, MODEL_SCHEMA.as_bytes())?;
    let body = args.body.as_ref().map(|b| Body::load(b, Path::new("."))).transpose()?;
    let map = args.map.as_deref().map(read_map).transpose()?;
    let worker = read_worker(&args.recordings, args.side, body, map)?;
    for remark in remarks_of(&worker.sources) {
        complain!("warning: {remark}");
    }
    let common = Body::of_size(&model.name, model.size)?;
    let own = worker.dataset(&common)?;
    let seconds = recorded_s(&own);
    let mut adapted = adapt(&model, &own)?;
    let stem = args.output.file_stem().unwrap_or_default().to_string_lossy();
    adapted.name = args.name.clone().unwrap_or_else(|| stem.replace('_', " "));
    let own = worker.sources.iter().map(|s| (s.name.clone(), s.sha256.clone()));
    adapted.provenance.recordings.extend(own);
    adapted.provenance.notes.insert(0, note(&model, &worker, seconds, &sha256));
    outputs.file(&args.output, model_text(&adapted)?)?;
    outputs.write()?;
    let size = worker.body.size;
    if args.json {
        say!(
            "{}",
            json!({
                "model": adapted.name, "people": model.name, "movements": worker.movements.len(),
                "seconds": seconds, "stature_m": size.stature_m,
                "weight_by_group": adapted.weight_by_group().into_iter().collect::<std::collections::BTreeMap<_, _>>(),
            })
        );
        return Ok(Outcome::Done);
    }
    say!(
        "{}: `{}` adapted to one worker by {} {} ({seconds:.1} s); by the arms the worker is {:.2} m tall",
        args.output.display(),
        model.name,
        worker.movements.len(),
        if worker.movements.len() == 1 { "movement" } else { "movements" },
        size.stature_m
    );
    say!("  joints that move   {}", groups(&model, &adapted));
    say!(
        "  Usual postures and standing place near the recorded movements are the worker's as far as these say; elsewhere, and in \
         what differs between repetitions, those of the people. From {SHORTEST_S} s on; more movements at the places of the \
         work say more."
    );
    say!("  in a scenario      posture_model = \"{}\"", args.output.display());
    Ok(Outcome::Done)
}

fn note(model: &PostureModel, worker: &Person, seconds: f64, sha256: &str) -> String {
    format!(
        "`{}` (SHA-256 {}) of {} people, adapted to one worker by {} movements of {seconds:.1} s in all",
        model.name,
        &sha256[..sha256.len().min(12)],
        model.provenance.people,
        worker.movements.len()
    )
}

/// The share of each group of joints in W, before and after.
fn groups(before: &PostureModel, after: &PostureModel) -> String {
    let percent = crate::words::number::percent;
    let both = before.weight_by_group().into_iter().zip(after.weight_by_group());
    let all: Vec<String> = both
        .map(|((group, a), (_, b))| format!("{group} {} \u{2192} {}", percent(a), percent(b)))
        .collect();
    all.join(", ")
}
