//! `ergopath validate`: how well people are predicted whom no law has seen.

use super::progress::Progress;
use super::validate_print::{as_json, print_text};
use super::{Failure, Outcome};
use crate::files::InputError;
use crate::human::Body;
use crate::posture::{PostureModel, load_model};
use crate::training::people::{Person, read_people, read_people_file, validate, validate_model};
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

/// A saved model that was judged.
pub(super) struct Judged {
    /// Its name.
    pub name: String,
    /// How many recordings it was judged on.
    pub recordings: usize,
    /// How many of them it was learned from.
    pub learned: usize,
}

impl Judged {
    fn new(model: &PostureModel, people: &[Person]) -> Self {
        let known = model.provenance.recordings.iter().map(|(_, sha256)| sha256);
        let known: BTreeSet<&String> = known.collect();
        let all = || people.iter().flat_map(|p| &p.sources);
        let learned = all().filter(|s| known.contains(&s.sha256)).count();
        Self { name: model.name.clone(), recordings: all().count(), learned }
    }
}

/// Reads everybody, leaves each person out, and prints.
pub(super) fn run(args: &Args) -> Result<Outcome, Failure> {
    let file = read_people_file(&args.people)?;
    let body = Body::load(&args.body, Path::new("."))?;
    let model = args.model.as_ref().map(|m| load_model(m, Path::new("."))).transpose()?;
    let progress = Progress::new();
    progress.tell("reading", 0, file.count());
    let people = read_people(&file)?;
    drop(progress);
    // Known before minutes are spent.
    for remark in remarks_of(people.iter().flat_map(|p| &p.sources)) {
        complain!("warning: {remark}");
    }
    let judged = model.as_ref().map(|(model, _)| Judged::new(model, &people));
    if let Some(Judged { name, recordings, learned }) = judged.as_ref().filter(|j| j.learned > 0) {
        complain!(
            "warning: {name} was learned from {learned} of these {recordings} recordings: it looks better on them \
             than on people whom it has not seen"
        );
    }
    let progress = Progress::new();
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
    if args.json {
        say!("{}", as_json(&found, judged.as_ref()));
    } else {
        print_text(&found, judged.as_ref());
    }
    Ok(Outcome::Done)
}
