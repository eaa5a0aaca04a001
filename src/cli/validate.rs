//! `ergopath validate`: how well people are predicted whom no law has seen.

use super::progress::Progress;
use super::validate_print::{as_json, print_text};
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs};
use crate::human::Body;
use crate::posture::{PostureModel, load_model};
use crate::report::{ReportError, validation_files};
use crate::training::people::{Person, read_people, read_people_file, validate, validate_model};
use crate::training::{SHORTEST_S, TrainSettings, remarks_of};
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
    /// Also tell what so many seconds of each person's own bring (s): the people's model adapted to them, and a
    /// model of them alone, on the person's other movements.
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, conflicts_with = "model")]
    own: Option<f64>,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
    /// Folder for a page, validation.html, with its pictures and validation.json.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

fn parse_seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "give a number of seconds".to_owned())?;
    let range = SHORTEST_S..=600.0;
    range
        .contains(&seconds)
        .then_some(seconds)
        .ok_or_else(|| format!("give from {} to {} seconds", range.start(), range.end()))
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

    /// What must be known of a model that was learned from what it is judged on.
    fn has_seen(&self) -> Option<String> {
        let Self { name, recordings, learned } = self;
        (*learned > 0).then(|| {
            format!(
                "{name} was learned from {learned} of these {recordings} recordings: it looks better on them than \
                 on people whom it has not seen"
            )
        })
    }
}

/// Reads everybody, leaves each person out, and prints.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let file = read_people_file(&args.people)?;
    let body = Body::load(&args.body, Path::new("."))?;
    let model = args.model.as_ref().map(|m| load_model(m, Path::new("."))).transpose()?;
    if let (Some(name), Some((model, _))) = (&args.model, &model) {
        super::warn_of_unsealed_model(name, model);
    }
    let progress = Progress::new();
    progress.tell("reading", 0, file.count());
    let people = read_people(&file)?;
    drop(progress);
    // Known before minutes are spent, as is what cannot be written.
    args.output.as_deref().map_or(Ok(()), |folder| outputs.expect_folder(folder))?;
    for remark in remarks_of(people.iter().flat_map(|p| &p.sources)) {
        complain!("warning: {remark}");
    }
    let judged = model.as_ref().map(|(model, _)| Judged::new(model, &people));
    let seen: Vec<String> = judged.iter().filter_map(Judged::has_seen).collect();
    for remark in &seen {
        complain!("warning: {remark}");
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
        None => validate(&people, &body, &settings, args.own, &mut told)?,
    };
    drop(progress);
    let Some(found) = found else {
        return Err(InputError::new(&args.people, "was not finished: interrupted").into());
    };
    let json = as_json(&found, judged.as_ref());
    if let Some(folder) = &args.output {
        let fault = |e: ReportError| InputError::fault("report", e.to_string());
        let name = judged.as_ref().map(|j| j.name.as_str());
        let mut files = validation_files(&found, name, &seen).map_err(fault)?;
        files.push(("validation.json".to_owned(), format!("{json}\n").into_bytes()));
        outputs.folder(folder, files)?;
        outputs.write()?;
    }
    if args.json {
        say!("{json}");
    } else {
        print_text(&found, judged.as_ref());
        if let Some(folder) = &args.output {
            say!("\n{}", folder.join("validation.html").display());
        }
    }
    Ok(Outcome::Done)
}
