//! `ergopath validate`: how well people are predicted whom no law has seen.

use super::progress::Progress;
use super::validate_print::{as_json, print_text};
use super::{Failure, Outcome};
use crate::files::InputError;
use crate::human::Body;
use crate::training::people::{read_people, read_people_file, validate};
use crate::training::{TrainSettings, remarks_of};
use std::path::{Path, PathBuf};

/// Arguments of `validate`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Who was recorded: a TOML file with a [[person]] for each.
    #[arg(value_name = "PEOPLE")]
    people: PathBuf,
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
    let progress = Progress::new();
    progress.tell("reading", 0, file.count());
    let people = read_people(&file)?;
    let mut told = |done: usize, total: usize| {
        progress.tell("people left out", done + 1, total);
        !Progress::is_interrupted()
    };
    let found = validate(&people, &body, &TrainSettings::default(), &mut told)?;
    drop(progress);
    let Some(found) = found else {
        return Err(InputError::new(&args.people, "was not finished: interrupted").into());
    };
    for remark in remarks_of(people.iter().flat_map(|p| &p.sources)) {
        complain!("warning: {remark}");
    }
    if args.json {
        say!("{}", as_json(&found));
    } else {
        print_text(&found);
    }
    Ok(Outcome::Done)
}
