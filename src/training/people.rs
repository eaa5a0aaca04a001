//! Several recorded people: who they are, their movements in bodies of their size, and what of a posture is
//! compared between a recording and a prediction.

mod bands;
mod centres;
mod curves;
mod file;
mod left_out;
mod own_seconds;
mod predictors;
mod risk;
mod seen;
mod sources;
mod summary;

pub use bands::{Bands, FeatureScore};
pub use centres::CENTRES;
pub use curves::{Curve, Curves};
pub use file::{PEOPLE_SCHEMA, PeopleFile, read_people_file};
pub use left_out::{
    LeftOut, MovementScore, PersonScore, PredictorScore, REPETITIONS, validate, validate_model,
};
pub use own_seconds::{AdaptedScore, OwnError};
pub use predictors::Predictor;
pub use risk::{Agreement, PartKnown, RiskScore, SheetMean, agreement};
pub use seen::Seen;
pub(super) use sources::read_sources;
pub use summary::{Known, RiskAgreement, coverage};

use super::dataset::{Dataset, Trial};
pub use super::measurer::{FEATURES, Features};
use super::source::{Source, Whom, from_recording, refuse_twice};
pub use super::standing::StandingScore;
use super::upright::Upright;
use crate::files::InputError;
use crate::human::{Body, BodySize, Coupled, Pelvis, Side};
use crate::kinematics::Frames;
use crate::recording::{Map, Reading, Recording, read_with};
use rayon::prelude::*;
use seen::{from_upright, recorded};
use std::path::PathBuf;

/// Fewest and most stature (m) that a recorded arm may ask for; beyond, the nearest is taken.
const STATURES_M: (f64, f64) = (1.3, 2.15);
/// Mass of a made-up body over the square of its stature, kg/m^2.
const BODY_MASS_INDEX: f64 = 24.0;

/// A person with recorded movements.
#[derive(Debug, Clone)]
pub struct Person {
    /// Code of the person.
    pub name: String,
    /// A body of the person's size.
    pub body: Body,
    /// The hand that leads.
    pub side: Side,
    /// The movements.
    pub movements: Vec<Movement>,
    /// The recordings that they come from, in the same order.
    pub sources: Vec<Source>,
}

/// One recorded movement of a person.
#[derive(Debug, Clone)]
pub struct Movement {
    /// Coordinates of the pelvis and joint angles in the person's body.
    pub trial: Trial,
    /// What was recorded at each of its rows.
    pub seen: Vec<Seen>,
}

/// Reads and fits all recordings of all people.
///
/// # Errors
/// Where a recording cannot be read or fitted, or does not hold both legs.
pub fn read_people(file: &PeopleFile) -> Result<Vec<Person>, InputError> {
    file.people.iter().map(read_one).collect()
}

/// Reads and fits the recordings of one worker; without a body, one with arms as long as the recorded ones.
///
/// # Errors
/// Where a recording cannot be read or fitted, or does not hold both legs.
pub fn read_worker(
    recordings: &[PathBuf],
    side: Side,
    body: Option<Body>,
    map: Option<Map>,
) -> Result<Person, InputError> {
    let recordings = recordings.to_vec();
    read_one(&file::Entry { name: "the worker".to_owned(), recordings, body, side, map })
}

impl Person {
    /// The movements in a body in which they meet those of others.
    ///
    /// # Errors
    /// Where the recordings do not suit the body.
    pub fn dataset(&self, body: &Body) -> Result<Dataset, InputError> {
        let trials: Vec<Trial> = self.movements.iter().map(|m| m.trial.clone()).collect();
        Dataset::of_seconds(&trials, body, self.side)
    }
}

fn read_one(entry: &file::Entry) -> Result<Person, InputError> {
    let map = entry.map.as_ref();
    let how = Reading { person: None, map, body: entry.body.as_ref() };
    let recordings: Result<Vec<Recording>, InputError> =
        entry.recordings.par_iter().map(|path| read_with(path, &how)).collect();
    let recordings = recordings?;
    let body = match &entry.body {
        Some(body) => body.clone(),
        None => sized(&entry.name, entry.side, &recordings)?,
    };
    let whom =
        Whom { person: None, side: entry.side, body: &body, pelvis: Some(Pelvis::Moves), map };
    let upright = Upright::of(&recordings);
    let recordings: Vec<Recording> = recordings.iter().map(|r| upright.levelled(r)).collect();
    let read: Result<Vec<(Movement, Source)>, InputError> = entry
        .recordings
        .par_iter()
        .zip(&recordings)
        .map(|(path, recording)| {
            let source = from_recording(recording, &whom, upright)?;
            let seen = recorded(recording, entry.side, upright)?;
            let trial = source.trials.first().cloned();
            let trial = trial.ok_or_else(|| InputError::new(path, "holds no movement"))?;
            Ok((Movement { trial, seen }, source))
        })
        .collect();
    let (mut movements, sources): (Vec<Movement>, Vec<Source>) = read?.into_iter().unzip();
    from_upright(&mut movements.iter_mut().map(|m| m.seen.as_mut_slice()).collect::<Vec<_>>());
    Ok(Person { name: entry.name.clone(), body, side: entry.side, movements, sources })
}

/// Refuses people who cannot be taken together: hands of both sides, or a recording that is there twice.
fn refuse_unlike(people: &[Person]) -> Result<(), InputError> {
    let side = people.first().map(|p| p.side);
    if let Some(other) = people.iter().find(|p| Some(p.side) != side) {
        let message =
            format!("leads with the {} hand, and others with the other", other.side.name());
        return Err(InputError::new(&other.name, message)
            .remedy("learn a model of each side; any model also serves as its mirror image"));
    }
    let all: Vec<&Source> = people.iter().flat_map(|p| &p.sources).collect();
    refuse_twice(&all)
}

/// The movements of all people as one data set, in a body in which their postures meet.
///
/// # Errors
/// Where hands of both sides lead, a recording is there twice, or there is too little to learn from.
pub fn people_dataset(people: &[Person], body: &Body) -> Result<Dataset, InputError> {
    refuse_unlike(people)?;
    let side = people.first().map_or(Side::Right, |p| p.side);
    let trials: Vec<Vec<Trial>> =
        people.iter().map(|p| p.movements.iter().map(|m| m.trial.clone()).collect()).collect();
    Dataset::of_people(&trials, body, side)
}

/// A man's body with arms as long as the recorded ones: nobody says how tall the person is.
pub(super) fn sized(name: &str, side: Side, recordings: &[Recording]) -> Result<Body, InputError> {
    let model = Body::load("male_p50", std::path::Path::new("."))?;
    let part = |part: &str| format!("{}{part}", side.prefix());
    let chain = model.chain(
        Coupled::arm(side),
        &[&part("UpperArm"), &part("ForeArm"), &part("Hand")].map(String::as_str),
    )?;
    let mut frames = Frames::default();
    chain.forward(&vec![0.0; chain.dof()], &mut frames);
    let [shoulder, elbow, wrist] = [1, 2, 3].map(|tip| chain.tip_frame(&frames, tip).0);
    let own = (elbow - shoulder).norm() + (wrist - elbow).norm();
    let lengths = recordings
        .iter()
        .filter_map(|r| Some(r.length_m(&part("UpperArm"))? + r.length_m(&part("ForeArm"))?));
    let lengths: Vec<f64> = lengths.collect();
    let recorded = if lengths.is_empty() { own } else { crate::math::stats::mean(&lengths) };
    let stature = model.size.stature_m * recorded / own;
    let stature_m = (1e3 * stature.clamp(STATURES_M.0, STATURES_M.1)).round() / 1e3;
    let mass_kg = (10.0 * BODY_MASS_INDEX * stature_m * stature_m).round() / 10.0;
    Body::of_size(name, BodySize { stature_m, mass_kg, sex: model.size.sex })
}
