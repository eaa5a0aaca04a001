//! Trains the shipped model of recorded people (`models/posture/people.json`) from the recordings of the
//! HDM05 database, which are not shipped: five people who put things on the floor and reach for high ones.
//!
//! ```text
//! cargo run --release --example recorded_people -- FOLDER OUT.json
//! ```
//! FOLDER holds the cuts of the database as Acclaim files (`HDM_bd_depositFloorR_001_120.amc` ..., with
//! the skeletons `HDM_bd.asf` ...). It takes some minutes.

#![allow(clippy::print_stderr, reason = "a program says what went wrong")]

use ergopath::files::{InputError, write_whole};
use ergopath::human::{Body, Side};
use ergopath::posture::{Method, save_model};
use ergopath::training::people::{PEOPLE_SCHEMA, people_dataset, read_people, read_people_file};
use ergopath::training::{Source, TrainSettings, Whom, provenance, remarks_of, train};
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;

/// Codes of the people in the database, and kinds of movement.
const PEOPLE: [&str; 5] = ["bd", "bk", "dg", "mm", "tr"];
const MOVEMENTS: [&str; 2] = ["depositFloorR", "grabHighR"];

const ATTRIBUTION: &str = "The data used in this project was obtained from HDM05 (Müller, Röder, Clausen, Eberhardt, \
                           Krüger, Weber: Universität Bonn, 2007), licensed under CC BY-SA 3.0; this model is \
                           derived from it and passed on under the same licence.";

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [folder, out] = words.as_slice() else {
        eprintln!("usage: recorded_people FOLDER OUT.json");
        return ExitCode::from(2);
    };
    match make(Path::new(folder), Path::new(out)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn make(folder: &Path, out: &Path) -> Result<(), InputError> {
    let fault = |e: std::io::Error| InputError::new(folder, format!("cannot be read: {e}"));
    let folder = folder.canonicalize().map_err(fault)?;
    let mut text = format!("schema = \"{PEOPLE_SCHEMA}\"\n");
    for person in PEOPLE {
        let patterns = MOVEMENTS.map(|movement| {
            format!("{:?}", folder.join(format!("HDM_{person}_{movement}_*.amc")).to_string_lossy())
        });
        let _ = write!(
            text,
            "[[person]]\nname = \"{person}\"\nrecordings = [{}]\n",
            patterns.join(", ")
        );
    }
    let aside = tempfile::tempdir().map_err(fault)?;
    let file = aside.path().join("people.toml");
    write_whole(&file, text.as_bytes())?;
    let people = read_people(&read_people_file(&file)?)?;
    let body = Body::load("male_p50", Path::new("."))?;
    let dataset = people_dataset(&people, &body)?;
    let of =
        |person: &str, s: &Source| Source { name: format!("{} of {person}", s.name), ..s.clone() };
    let sources: Vec<Source> =
        people.iter().flat_map(|p| p.sources.iter().map(|s| of(&p.name, s))).collect();
    for remark in remarks_of(&sources) {
        eprintln!("{remark}");
    }
    let whom = Whom { person: None, side: Side::Right, body: &body, pelvis: None, map: None };
    let settings = TrainSettings::default();
    let mut made_from = provenance(&sources, &whom);
    made_from.notes.insert(0, ATTRIBUTION.to_owned());
    let model = train(&dataset, "people", Method::FullW, &settings, made_from)?;
    save_model(&model, out)
}
