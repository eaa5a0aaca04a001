//! The recordings of several people as they are, with whatever legs they hold.

use super::file::{Entry, PeopleFile};
use super::sized;
use crate::files::InputError;
use crate::human::{Body, Side};
use crate::recording::{Reading, Recording, read_with};
use crate::training::source::{Source, Whom, read_source, refuse_twice};
use rayon::prelude::*;

/// A person's recordings, read and fitted.
pub(in crate::training) struct PersonSources {
    /// Code of the person.
    pub name: String,
    /// A body of the person's size.
    pub body: Body,
    /// The hand that leads.
    pub side: Side,
    /// By name of the file.
    pub sources: Vec<Source>,
}

/// Reads and fits the recordings of all people. The pelvis moves where legs were recorded.
///
/// # Errors
/// Where a recording cannot be read or fitted, or is there twice.
pub(in crate::training) fn read_sources(
    file: &PeopleFile,
) -> Result<Vec<PersonSources>, InputError> {
    let people: Result<Vec<PersonSources>, InputError> = file.people.iter().map(one).collect();
    let people = people?;
    refuse_twice(&people.iter().flat_map(|p| &p.sources).collect::<Vec<_>>())?;
    Ok(people)
}

fn one(entry: &Entry) -> Result<PersonSources, InputError> {
    let body = match &entry.body {
        Some(body) => body.clone(),
        None => sized(&entry.name, entry.side, &recordings(entry)?)?,
    };
    let map = entry.map.as_ref();
    let whom = Whom { person: None, side: entry.side, body: &body, pelvis: None, map };
    let sources: Result<Vec<Source>, InputError> =
        entry.recordings.par_iter().map(|path| read_source(path, &whom)).collect();
    Ok(PersonSources { sources: sources?, name: entry.name.clone(), side: entry.side, body })
}

fn recordings(entry: &Entry) -> Result<Vec<Recording>, InputError> {
    let how = Reading { person: None, map: entry.map.as_ref(), body: None };
    entry.recordings.par_iter().map(|path| read_with(path, &how)).collect()
}
