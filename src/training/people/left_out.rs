//! How well people are predicted whom no law has seen: one person is left out, the others teach.
//!
//! ```text
//! from the recorded first posture    rms over time of prediction less record, for each predictor
//! from starts that the law draws     bands of repetitions: share of the record inside, width, proper scores;
//!                                    RULA and REBA, beside those of each predictor from the usual start
//! ```
//! Bands are those of a stranger at work: neither the first posture nor anything else of the person is
//! known but the path of the hand from the feet and the size of the body. A saved model is judged in the same
//! way on people whom it has not seen.

use super::super::dataset::{Dataset, Frame, runs};
use super::super::measurer::Measurer;
use super::super::settings::TrainSettings;
use super::super::standing::{StandingScore, judge_standing};
use super::super::strangers::Strangers;
use super::bands::{Bands, in_units};
use super::centres::{CENTRES, Centres};
use super::curves::{Curve, Curves};
use super::own_seconds::{AdaptedScore, adapted_score};
use super::predictors::{Predictor, Taught};
use super::risk::{Assessor, Repeated, RiskScore, SheetMean};
use super::seen::Seen;
use super::{FEATURES, Features, Movement, Person, refuse_unlike};
use crate::ergonomics::{PerMethod, ScoringMethod, Worksheet};
use crate::files::InputError;
use crate::human::{Body, Pelvis, Side};
use crate::posture::{Modelled, Modes, PostureModel, low_place};
use nalgebra::DVector;
use rayon::prelude::*;
use serde::Serialize;

/// Repetitions behind a band.
pub const REPETITIONS: usize = 100;

/// Errors of one predictor, without chance in it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PredictorScore {
    /// Which.
    pub predictor: Predictor,
    /// Rms over time from the recorded first posture, in the order of [`FEATURES`]: cm, then deg.
    pub rms: Features,
    /// The same of the joint centres [`CENTRES`], against those of the fitted body, cm.
    pub centres_cm: [f64; CENTRES.len()],
    /// RULA and REBA, mean over time, from the recorded first posture.
    pub risk_known_start: PerMethod<f64>,
    /// The same from the path of the hand alone; none where the usual start is out of reach.
    pub risk: Option<PerMethod<f64>>,
}

/// One movement of somebody who was left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovementScore {
    /// Name of the recording.
    pub movement: String,
    /// Frames that were compared.
    pub frames: usize,
    /// What each predictor says without chance.
    pub predictors: Vec<PredictorScore>,
    /// RULA and REBA of the record and of repetitions; none where fewer than two begin.
    pub risk: Option<PerMethod<RiskScore>>,
    /// What is entered in their sheets.
    pub entered: Vec<SheetMean>,
    /// Bands of repetitions.
    #[serde(flatten)]
    pub bands: Bands,
    /// The same where one law stands for all modes.
    pub one_law: Bands,
    /// Predicted shares of the modes; empty where they are not told apart.
    pub modes: Vec<f64>,
    /// How far the fitted body itself is from the record, rms, in the order of [`FEATURES`].
    pub fit_rms: Features,
    /// Over time, for pictures; none where fewer than two repetitions begin.
    #[serde(skip)]
    pub curves: Option<Curves>,
}

/// One person who was left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PersonScore {
    /// Code of the person.
    pub person: String,
    /// Stature of the body, m.
    pub stature_m: f64,
    /// Movements.
    pub movements: Vec<MovementScore>,
    /// Where the person stood; none where the model does not say.
    pub standing: Option<StandingScore>,
}

/// People whom a model has not seen: left out one by one, or those on whom a saved model is judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// In the order of the file.
    pub people: Vec<PersonScore>,
    /// What some seconds of each person's own bring; empty where that was not asked for.
    pub adapted: Vec<AdaptedScore>,
}

/// Leaves out each person in turn. `told` hears how many are done and of how many; it answers whether to go
/// on. `common` is the body in which the others' postures meet.
///
/// # Errors
/// Where there are fewer than two people, hands of both sides lead, a recording is there twice, or too
/// little or nothing moves.
pub fn validate(
    people: &[Person],
    common: &Body,
    settings: &TrainSettings,
    own_s: Option<f64>,
    told: &mut dyn FnMut(usize, usize) -> bool,
) -> Result<Option<LeftOut>, InputError> {
    if people.len() < 2 {
        return Err(InputError::new("people", "there is only one person")
            .remedy("somebody must be left out, and somebody else must teach"));
    }
    refuse_unlike(people)?;
    let mut adapted = Vec::new();
    let found = one_by_one(people, told, |i, person| {
        let others: Vec<&Person> =
            people.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, p)| p).collect();
        let dataset = of_others(&others, common, person.side)?;
        if let Some(own_s) = own_s {
            adapted.push(adapted_score(person, &dataset, (common, own_s), settings)?);
        }
        judged(person, &Taught::by(&dataset, settings)?, settings)
    })?;
    Ok(found.map(|found| LeftOut { adapted, ..found }))
}

/// The score of each person in turn; none where `told` answers not to go on.
fn one_by_one(
    people: &[Person],
    told: &mut dyn FnMut(usize, usize) -> bool,
    mut score: impl FnMut(usize, &Person) -> Result<PersonScore, InputError>,
) -> Result<Option<LeftOut>, InputError> {
    let mut scores = Vec::new();
    for (i, person) in people.iter().enumerate() {
        if !told(i, people.len()) {
            return Ok(None);
        }
        scores.push(score(i, person)?);
    }
    Ok(Some(LeftOut { people: scores, adapted: Vec::new() }))
}

/// Judges a saved model on people, as [`validate`] does on those whom it leaves out.
///
/// # Errors
/// Where the model is one of the other hand or of another chain than a whole person, or nothing moves.
pub fn validate_model(
    people: &[Person],
    model: &PostureModel,
    settings: &TrainSettings,
    told: &mut dyn FnMut(usize, usize) -> bool,
) -> Result<Option<LeftOut>, InputError> {
    if model.pelvis() != Pelvis::Moves {
        return Err(InputError::new(&model.name, "was learned over a pelvis that rests")
            .remedy("give a model of whole people: one trained on recordings that hold the legs"));
    }
    if let Some(other) = people.iter().find(|p| p.side != model.side) {
        return Err(InputError::new(&other.name, "leads with the other hand than the model's")
            .remedy("judge each side by a model of that side"));
    }
    let taught = Taught::saved(model);
    one_by_one(people, told, |_, person| judged(person, &taught, settings))
}

fn of_others(others: &[&Person], common: &Body, side: Side) -> Result<Dataset, InputError> {
    let groups: Vec<Vec<_>> =
        others.iter().map(|p| p.movements.iter().map(|m| m.trial.clone()).collect()).collect();
    Dataset::of_people(&groups, common, side)
}

/// What tells of a person's postures.
struct Judge<'a> {
    taught: &'a Taught<'a>,
    own: Dataset,
    measurer: Measurer,
    centres: Centres,
    assessor: Assessor,
    seed: u64,
}

/// How well a person's movements are predicted.
pub(super) fn judged(
    person: &Person,
    taught: &Taught,
    settings: &TrainSettings,
) -> Result<PersonScore, InputError> {
    let trials: Vec<_> = person.movements.iter().map(|m| m.trial.clone()).collect();
    let knows_head = person.movements.iter().flat_map(|m| &m.seen).all(|s| s.head.is_some());
    let judge = Judge {
        taught,
        own: Dataset::new(&trials, &person.body, person.side)?,
        measurer: Measurer::new(&person.body, person.side)?,
        centres: Centres::new(&person.body, person.side)?,
        assessor: Assessor::new(&person.body, person.side, knows_head)?,
        seed: settings.seed,
    };
    let all: Vec<&Frame> = judge.own.frames.iter().collect();
    let movements: Vec<MovementScore> = runs(&all)
        .par_iter()
        .filter(|run| run.len() > 2)
        .map(|run| judge.movement(&person.movements[run[0].trial], run))
        .collect::<Option<Vec<_>>>()
        .ok_or_else(super::super::methods::singular)?;
    Ok(PersonScore {
        person: person.name.clone(),
        stature_m: person.body.size.stature_m,
        movements,
        standing: taught.standing.as_ref().map(|place| judge_standing(place, &judge.own)),
    })
}

/// A recorded movement at the frames that are compared.
struct Record<'a> {
    run: &'a [&'a Frame],
    features: Vec<Features>,
    sheets: Vec<Worksheet>,
}

impl Judge<'_> {
    fn movement(&self, movement: &Movement, run: &[&Frame]) -> Option<MovementScore> {
        let row = |f: &Frame| (f.time_s * movement.trial.rate_hz).round() as usize;
        let seen: Vec<&Seen> = run.iter().map(|f| &movement.seen[row(f)]).collect();
        let record = Record {
            run,
            features: seen.iter().map(|s| s.features).collect(),
            sheets: run.iter().zip(&seen).map(|(f, s)| self.assessor.recorded(&f.q, s)).collect(),
        };
        let usual = self.taught.usual_start(&self.own, run);
        let predictors = Predictor::ALL
            .into_iter()
            .filter_map(|predictor| self.predictor(predictor, &record, usual.as_ref()))
            .collect();
        let place = low_place(run.iter().map(|f| &f.hand), self.own.coupling.stature_m());
        let told = self.taught.modes.as_ref().and_then(|modes| modes.at(place));
        let alone = self.strangers(None, run)?;
        let one_law = self.bands(&alone, &record).1;
        let strangers = match told {
            Some(_) => self.strangers(self.taught.modes.as_ref(), run)?,
            None => alone,
        };
        let (walks, bands) = self.bands(&strangers, &record);
        let repeated = self.assessor.repeated(&strangers.walks, (self.seed, run[0].trial as u32));
        let fitted: Vec<Features> =
            run.iter().map(|f| self.measurer.measure(f.q.as_slice())).collect();
        Some(MovementScore {
            movement: movement.trial.source.clone(),
            frames: run.len(),
            predictors,
            risk: self.assessor.compared(&repeated, &record.sheets),
            entered: Assessor::entered(&repeated, &record.sheets),
            curves: self.curves(&record, &walks, &repeated),
            bands,
            one_law,
            modes: told.map_or_else(Vec::new, |t| t.shares),
            fit_rms: self.rms(&fitted, &record.features),
        })
    }

    /// What a predictor says without chance; none where it was not taught.
    fn predictor(
        &self,
        predictor: Predictor,
        record: &Record,
        usual: Option<&DVector<f64>>,
    ) -> Option<PredictorScore> {
        let along = (&self.own, record.run);
        let known = self.taught.postures(predictor, along, &record.run[0].q)?;
        let found: Vec<Features> =
            known.iter().map(|q| self.measurer.measure(q.as_slice())).collect();
        let risk_known_start = self.assessor.of_postures(&known);
        let risk = if predictor.needs_start() {
            usual.and_then(|start| self.taught.postures(predictor, along, start))
        } else {
            Some(known.clone())
        };
        let fitted = record.run.iter().map(|f| &f.q);
        Some(PredictorScore {
            predictor,
            rms: self.rms(&found, &record.features),
            centres_cm: self.centres.rms_cm(known.iter().zip(fitted)),
            risk_known_start,
            risk: risk.map(|postures| self.assessor.of_postures(&postures)),
        })
    }

    fn strangers(&self, modes: Option<&Modes>, run: &[&Frame]) -> Option<Strangers> {
        let people = Modelled::of((&self.taught.full, &self.taught.postures), modes)?.strangers();
        Some(Strangers::along(&people, &self.own, run, (self.seed, REPETITIONS)))
    }

    /// Features of the repetitions that begin (R x T), and what their bands hold.
    fn bands(&self, strangers: &Strangers, record: &Record) -> (Vec<Vec<Features>>, Bands) {
        let walks = strangers.features(&self.measurer);
        let leg_m = self.measurer.legs.length_m();
        let bands = Bands::of(&walks, &record.features, leg_m, strangers.ended_share());
        (walks, bands)
    }

    fn curves(
        &self,
        record: &Record,
        walks: &[Vec<Features>],
        repeated: &Repeated,
    ) -> Option<Curves> {
        let method = ScoringMethod::Rula;
        let scores = self.assessor.over_time(repeated, &record.sheets, (method, None));
        let numbers = |s: &Vec<u8>| s.iter().map(|v| f64::from(*v)).collect::<Vec<f64>>();
        let own = record.sheets.iter().map(|s| f64::from(self.assessor.total(s, method)));
        (walks.len() > 1).then(|| Curves {
            time_s: record.run.iter().map(|f| f.time_s).collect(),
            features: (0..FEATURES.len())
                .map(|feature| Curve::of_feature(&record.features, walks, feature))
                .collect(),
            rula: Curve::of(own.collect(), &scores.iter().map(numbers).collect::<Vec<_>>()),
        })
    }

    /// Rms over time, in the units of the scores.
    fn rms(&self, found: &[Features], seen: &[Features]) -> Features {
        let leg_m = self.measurer.legs.length_m();
        let mut sum = [0.0; FEATURES.len()];
        for (found, seen) in found.iter().zip(seen) {
            for (c, s) in sum.iter_mut().enumerate() {
                *s += in_units(found[c] - seen[c], c, leg_m).powi(2);
            }
        }
        sum.map(|s| (s / seen.len() as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::super::summary::Known;
    use super::*;
    use crate::math::stats::mean;
    use crate::training::SimulatedMovements;
    use crate::training::dataset::Trial;
    use crate::training::motion_file::trial_of;
    use std::path::Path;

    /// Nobody looked at the heads, and the feet stood.
    fn seen(features: Features) -> Seen {
        Seen { features, head: None, knees_deg: [features[4]; 2], heels_deg: None }
    }

    /// Made-up people who differ by chance only.
    fn people(count: u64) -> Vec<Person> {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let measurer = Measurer::new(&body, Side::Right).unwrap();
        let movement = |trial: Trial| Movement {
            seen: trial.q.iter().map(|q| seen(measurer.measure(q))).collect(),
            trial,
        };
        let one = |number: u64| {
            let source = SimulatedMovements::new(&body, Side::Right, true, 7 + number).unwrap();
            let reaches = source.first(4).unwrap().into_iter().enumerate().map(|(i, reach)| {
                let columns: Vec<Vec<f64>> = (0..reach.postures[0].len())
                    .map(|c| reach.postures.iter().map(|q| q[c]).collect())
                    .collect();
                let rate = 1.0 / (reach.times_s[1] - reach.times_s[0]);
                movement(trial_of(format!("{number} {i}"), rate, &columns))
            });
            Person {
                name: number.to_string(),
                body: body.clone(),
                side: Side::Right,
                movements: reaches.collect(),
                sources: Vec::new(),
            }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn people_alike_are_predicted_and_their_bands_hold() {
        let people = people(4);
        let settings = TrainSettings::default();
        let body = people[0].body.clone();
        let mut heard = Vec::new();
        let mut told = |done: usize, total: usize| {
            heard.push((done, total));
            true
        };
        let found = validate(&people, &body, &settings, None, &mut told).unwrap().unwrap();
        assert_eq!(heard, [(0, 4), (1, 4), (2, 4), (3, 4)]);
        let movements: Vec<&MovementScore> =
            found.people.iter().flat_map(|p| &p.movements).collect();
        assert_eq!(movements.len(), 16);
        let error = |predictor: Predictor, feature: usize| {
            let of = |m: &&MovementScore| {
                m.predictors.iter().find(|p| p.predictor == predictor).unwrap().rms[feature]
            };
            mean(&movements.iter().map(of).collect::<Vec<_>>())
        };
        for (feature, name) in FEATURES.iter().enumerate() {
            let [law, still] =
                [Predictor::FullW, Predictor::MeanPosture].map(|p| error(p, feature));
            assert!(law < 0.7 * still, "{name}: {law} against {still}");
            let held = mean(
                &movements
                    .iter()
                    .map(|m| m.bands.features[feature].coverage[1])
                    .collect::<Vec<_>>(),
            );
            assert!((0.75..=1.0).contains(&held), "{name}: bands hold {held}");
        }
        let rula = found.risk(ScoringMethod::Rula);
        let of = |p: Predictor| found.risk_of(ScoringMethod::Rula, p, Known::HandPath).unwrap();
        let [mae, still] = [rula.agreement.mae, of(Predictor::MeanPosture).mae];
        assert_eq!(rula.movements, 16);
        assert!(mae < 0.7 * still, "RULA: {mae} against {still}");
        assert!(rula.inside90 > 0.6, "{rula:?}");
        for movement in &movements {
            let (curves, risk) =
                (movement.curves.as_ref().unwrap(), movement.risk.as_ref().unwrap());
            let over_time = [&curves.rula.recorded, &curves.rula.mean].map(|v| mean(v));
            let risk = &risk[ScoringMethod::Rula];
            assert!((over_time[0] - risk.recorded).abs() < 1e-9);
            assert!((over_time[1] - risk.predicted).abs() < 1e-9);
            assert_eq!(curves.time_s.len(), curves.features[0].recorded.len());
        }
        // What was measured was the body itself, but for the filter's hair at the ends.
        assert!(movements.iter().flat_map(|m| m.fit_rms).all(|f| f < 1e-9));
        let mut stop = |_: usize, _: usize| false;
        assert!(validate(&people, &body, &settings, None, &mut stop).unwrap().is_none());
        assert!(validate(&people[..1], &body, &settings, None, &mut stop).is_err());
        let mut unlike = people;
        unlike[2].side = Side::Left;
        let error = validate(&unlike, &body, &settings, None, &mut stop).unwrap_err();
        assert!(error.message().contains("left hand"), "{error}");
    }
}
