//! What some seconds of a person's own movement bring: the others' model adapted to them, beside the others alone
//! and the person alone, on movements of which nothing was taken.

use super::super::adapt::adapt;
use super::super::dataset::{Dataset, Trial};
use super::super::settings::TrainSettings;
use super::super::train::learn;
use super::left_out::judged;
use super::predictors::{Predictor, Taught};
use super::{Movement, Person};
use crate::files::InputError;
use crate::human::Body;
use crate::math::stats::mean;
use crate::posture::{Method, PostureModel, Provenance};
use serde::Serialize;

/// Errors of a model on movements of a person.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OwnError {
    /// Root mean square over time of trunk, upper arm, elbow and knees from the recorded first posture, mean of the
    /// four and over movements, deg.
    pub error_deg: f64,
    /// Mean energy score of repetitions, deg; not a number where none begins.
    pub energy_deg: f64,
}

/// What a person's own seconds bring.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AdaptedScore {
    /// Code of the person.
    pub person: String,
    /// Seconds of the person's own.
    pub own_s: f64,
    /// Movements that were judged.
    pub movements: usize,
    /// The others alone.
    pub people: OwnError,
    /// The others adapted to the person.
    pub adapted: OwnError,
    /// The person alone; none where so little does not make a model.
    pub own: Option<OwnError>,
}

/// Judges `own_s` seconds of a person beside a data set of the others.
pub(super) fn adapted_score(
    person: &Person,
    others: &Dataset,
    (common, own_s): (&Body, f64),
    settings: &TrainSettings,
) -> Result<AdaptedScore, InputError> {
    let (own, rest) = taken(&person.movements, own_s);
    if rest.is_empty() {
        return Err(InputError::new(&person.name, format!("has no movement left after {own_s} s"))
            .remedy("take fewer seconds"));
    }
    let rest = Person { movements: rest, ..person.clone() };
    let people = learn(others, "others", Method::FullW, settings, nowhere())?;
    let adapted = adapt(&people, &Dataset::of_seconds(&own, common, person.side)?)?;
    // In the person's own body, as anybody would learn it.
    let alone = Dataset::new(&own, &person.body, person.side)
        .and_then(|own| learn(&own, "own", Method::FullW, settings, nowhere()));
    let error = |model: &PostureModel| -> Result<OwnError, InputError> {
        let score = judged(&rest, &Taught::saved(model), settings)?;
        let of_law = |m: &super::MovementScore| {
            let rms = m.by(Predictor::FullW).map_or([f64::NAN; 5], |p| p.rms);
            mean(&rms[1..])
        };
        Ok(OwnError {
            error_deg: mean(&score.movements.iter().map(of_law).collect::<Vec<f64>>()),
            energy_deg: mean(
                &score.movements.iter().map(|m| m.bands.energy_deg).collect::<Vec<f64>>(),
            ),
        })
    };
    Ok(AdaptedScore {
        person: person.name.clone(),
        own_s,
        movements: rest.movements.len(),
        people: error(&people)?,
        adapted: error(&adapted)?,
        own: alone.ok().and_then(|model| error(&model).ok()),
    })
}

fn nowhere() -> Provenance {
    Provenance {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        simulated: false,
        people: 1,
        adapted_s: None,
        filled_from: None,
        recordings: Vec::new(),
        body: (String::new(), String::new()),
        settings: Vec::new(),
        notes: Vec::new(),
    }
}

/// Stretches of so many seconds in all, of each movement in turn that in which most moves; and the movements of which
/// nothing was taken.
fn taken(movements: &[Movement], seconds: f64) -> (Vec<Trial>, Vec<Movement>) {
    let (mut own, mut rest, mut missing) = (Vec::new(), Vec::new(), seconds);
    for movement in movements {
        let trial = &movement.trial;
        let rows = ((missing * trial.rate_hz).ceil() as usize + 1).min(trial.q.len());
        if missing <= 0.0 || rows < 3 {
            rest.push(movement.clone());
            continue;
        }
        let speed: Vec<f64> =
            trial.qdot.iter().map(|v| v.iter().map(|v| v * v).sum::<f64>()).collect();
        let moved = |from: &usize| speed[*from..from + rows].iter().sum::<f64>();
        let most = (0..=trial.q.len() - rows).max_by(|a, b| moved(a).total_cmp(&moved(b)));
        let from = most.unwrap_or(0);
        own.push(trial.rows(from..from + rows));
        missing -= (rows - 1) as f64 / trial.rate_hz;
        if missing < 0.5 / trial.rate_hz {
            missing = 0.0;
        }
    }
    (own, rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::motion_file::trial_of;

    #[test]
    fn the_second_in_which_most_moves_is_taken_and_its_movement_is_not_judged() {
        // Still for a second, then moving for one.
        let column: Vec<f64> =
            (0..=120).map(|t| if t < 60 { 0.0 } else { 0.01 * f64::from(t - 60) }).collect();
        let movement = |name: &str| Movement {
            trial: trial_of(name.to_owned(), 60.0, std::slice::from_ref(&column)),
            seen: Vec::new(),
        };
        let all = [movement("a"), movement("b"), movement("c")];
        let (own, rest) = taken(&all, 0.5);
        assert_eq!((own.len(), rest.len()), (1, 2));
        assert_eq!((own[0].source.as_str(), own[0].q.len()), ("a", 31));
        assert!(own[0].qdot.iter().skip(3).all(|v| v[0] > 0.3));
        // More than one movement holds.
        let (own, rest) = taken(&all, 3.0);
        let seconds: Vec<usize> = own.iter().map(|t| t.q.len() - 1).collect();
        assert_eq!((seconds, rest.len()), (vec![120, 60], 1));
    }
}
