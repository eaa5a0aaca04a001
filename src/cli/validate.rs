//! `ergopath validate`: how well people are predicted whom no law has seen.

use super::progress::Progress;
use super::validate_print::{as_json, print_text};
use super::{Failure, Outcome};
use crate::files::InputError;
use crate::human::Body;
use crate::posture::load_model;
use crate::training::people::{read_people, read_people_file, validate, validate_model};
use crate::training::{TrainSettings, remarks_of};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Arguments of `validate`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Who was recorded: a TOML file with a [[person]] for each.
    #[arg(value_name = "PEOPLE")]
    people: PathBuf,
    /// Judge this posture model (shipped, or a file) on these people, instead of leaving each of them out.
    #[arg(long, value_name = "MODEL", conflicts_with = "body")]
    model: Option<String>,
    /// Body in which the postures of all people meet.
    #[arg(long, default_value = "male_p50")]
    body: String,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

/// Reads everybody, leaves each person out, and prints.
pub(super) fn run(args: &Args) -> Result<Outcome, Failure> {
    let file = read_people_file(&args.people)?;
    let body = Body::load(&args.body, Path::new("."))?;
    let model = args.model.as_ref().map(|m| load_model(m, Path::new("."))).transpose()?;
    let progress = Progress::new();
    progress.tell("reading", 0, file.count());
    let people = read_people(&file)?;
    let mut told = |done: usize, total: usize| {
        progress.tell(
            if model.is_some() { "people judged" } else { "people left out" },
            done + 1,
            total,
        );
        !Progress::is_interrupted()
    };
    let settings = TrainSettings::default();
    let found = match &model {
        Some((model, _)) => validate_model(&people, model, &settings, &mut told)?,
        None => validate(&people, &body, &settings, &mut told)?,
    };
    drop(progress);
    let Some(found) = found else {
        return Err(InputError::new(&args.people, "was not finished: interrupted").into());
    };
    for remark in remarks_of(people.iter().flat_map(|p| &p.sources)) {
        complain!("warning: {remark}");
    }
    if let Some((model, _)) = &model {
        let known = model.provenance.recordings.iter().map(|(_, sha256)| sha256);
        let known: BTreeSet<&String> = known.collect();
        let all = || people.iter().flat_map(|p| &p.sources);
        let learned = all().filter(|s| known.contains(&s.sha256)).count();
        if learned > 0 {
            complain!(
                "warning: {} was learned from {learned} of these {} recordings: it looks better on them than \
                 on people whom it has not seen",
                model.name,
                all().count()
            );
        }
    }
    let judged = model.as_ref().map(|(model, _)| model.name.as_str());
    if args.json {
        say!("{}", as_json(&found, judged));
    } else {
        print_text(&found, judged);
    }
    Ok(Outcome::Done)
}
