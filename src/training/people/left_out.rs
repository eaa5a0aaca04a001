//! How well people are predicted whom no law has seen: one person is left out, the others teach.
//!
//! ```text
//! from the recorded first posture    rms over time of mean prediction less record, for each predictor
//! from starts that the law draws     bands of repetitions: share of the record inside, width, energy score
//! ```
//! Bands are those of a stranger at work: neither the first posture nor anything else of the person is
//! known but the path of the hand from the feet and the size of the body. A saved model is judged in the same
//! way on people whom it has not seen.

use super::super::dataset::{Dataset, Frame, runs};
use super::super::measurer::Measurer;
use super::super::methods::{Law, learn_laws};
use super::super::modes::learn_modes;
use super::super::rollout_check::{band_end, sampled_law, walk_path};
use super::super::settings::TrainSettings;
use super::super::spread::{learn_about_usual, learn_attraction, learn_postures};
use super::super::standing::{StandingScore, judge_standing, learn_standing};
use super::super::strangers::{mean_energy_deg, strangers};
use super::{FEATURES, Features, Movement, Person, refuse_unlike};
use crate::files::InputError;
use crate::human::{Body, Pelvis};
use crate::posture::{
    Attraction, HandFeatures, Method, Modelled, Modes, PostureDistribution, PostureLaw,
    PostureModel, StandingPlace, low_place, roll_out,
};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

/// Repetitions behind a band.
const REPETITIONS: usize = 100;

/// What predicts a posture from the path of the hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Predictor {
    /// The law with a full weight matrix and the pull towards usual postures.
    FullW,
    /// The same with a diagonal weight matrix.
    DiagonalW,
    /// The plain pseudo-inverse, without a pull.
    PlainIk,
    /// The usual posture at the hand's place, which need not reach the hand.
    Regression,
    /// The posture of the training frame with the nearest hand.
    NearestNeighbour,
    /// The mean posture of the training people.
    MeanPosture,
}

impl Predictor {
    /// All, the law first.
    pub const ALL: [Self; 6] = [
        Self::FullW,
        Self::DiagonalW,
        Self::PlainIk,
        Self::Regression,
        Self::NearestNeighbour,
        Self::MeanPosture,
    ];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::FullW => "full-w",
            Self::DiagonalW => "diagonal-w",
            Self::PlainIk => "plain-ik",
            Self::Regression => "regression",
            Self::NearestNeighbour => "nearest-neighbour",
            Self::MeanPosture => "mean-posture",
        }
    }
}

/// Errors of one predictor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PredictorScore {
    /// Which.
    pub predictor: Predictor,
    /// Rms over time, in the order of [`FEATURES`]: cm, then deg.
    pub rms: Features,
}

/// What bands of one feature held.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FeatureScore {
    /// Name.
    pub feature: &'static str,
    /// Share of the frames inside the central 50 and 90 %.
    pub coverage: [f64; 2],
    /// Mean width of the 90 % band, cm or deg.
    pub width_90: f64,
}

/// What repetitions of strangers say of a movement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bands {
    /// Bands.
    pub features: Vec<FeatureScore>,
    /// Mean energy score of the four angles, deg.
    pub energy_deg: f64,
    /// Share of the repetitions that could not follow the hand to its end.
    pub ended_share: f64,
}

/// One movement of somebody who was left out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovementScore {
    /// Name of the recording.
    pub movement: String,
    /// Frames that were compared.
    pub frames: usize,
    /// Errors from the recorded first posture.
    pub predictors: Vec<PredictorScore>,
    /// Bands of repetitions.
    #[serde(flatten)]
    pub bands: Bands,
    /// The same where one law stands for all modes.
    pub one_law: Bands,
    /// Predicted shares of the modes; empty where they are not told apart.
    pub modes: Vec<f64>,
    /// How far the fitted body itself is from the record, rms, in the order of [`FEATURES`].
    pub fit_rms: Features,
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
    told: &mut dyn FnMut(usize, usize) -> bool,
) -> Result<Option<LeftOut>, InputError> {
    if people.len() < 2 {
        return Err(InputError::new("people", "there is only one person")
            .remedy("somebody must be left out, and somebody else must teach"));
    }
    refuse_unlike(people)?;
    one_by_one(people, told, |i, person| {
        let others: Vec<&Person> =
            people.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, p)| p).collect();
        left_out(person, &others, common, settings)
    })
}

/// The score of each person in turn; none where `told` answers not to go on.
fn one_by_one(
    people: &[Person],
    told: &mut dyn FnMut(usize, usize) -> bool,
    score: impl Fn(usize, &Person) -> Result<PersonScore, InputError>,
) -> Result<Option<LeftOut>, InputError> {
    let mut scores = Vec::new();
    for (i, person) in people.iter().enumerate() {
        if !told(i, people.len()) {
            return Ok(None);
        }
        scores.push(score(i, person)?);
    }
    Ok(Some(LeftOut { people: scores }))
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

/// What the others teach.
struct Taught<'a> {
    full: PostureLaw,
    diagonal: Option<PostureLaw>,
    plain: PostureLaw,
    usual: Option<Attraction>,
    postures: PostureDistribution,
    modes: Option<Modes>,
    standing: Option<StandingPlace>,
    /// Whom it was learned from, and how their hands compare; not known of a saved model.
    teachers: Option<(&'a Dataset, HandFeatures)>,
}

impl<'a> Taught<'a> {
    fn by(dataset: &'a Dataset, settings: &TrainSettings) -> Result<Self, InputError> {
        let every: Vec<usize> = (0..dataset.frames.len()).collect();
        let all: Vec<&Frame> = dataset.frames.iter().collect();
        let stature_m = dataset.coupling.stature_m();
        let methods = [Method::FullW, Method::WIk, Method::PlainIk];
        let laws = learn_laws(&methods, &all, stature_m, settings, None)?;
        let usual = learn_attraction(dataset, &all, settings);
        let of = |law: &Law, is_pulled: bool| PostureLaw {
            attraction: usual.clone().filter(|_| is_pulled),
            ..law.law.clone()
        };
        let (full, repetitions) = sampled_law(dataset, &every, &laws[0], settings)?;
        let modes = learn_modes(dataset, &laws[0], &repetitions, settings)?;
        let clock = full.noise.clock;
        let clocked = |mut law: PostureLaw| {
            law.noise.clock = clock;
            law
        };
        let [diagonal, plain] = [of(&laws[1], true), of(&laws[2], false)].map(clocked);
        let diagonal = Some(diagonal);
        let hands = HandFeatures::fit(&all.iter().map(|f| f.hand).collect::<Vec<_>>(), stature_m);
        let (about_usual, low) = learn_about_usual(dataset, settings).unzip();
        let postures =
            PostureDistribution { about_usual, low: low.flatten(), ..learn_postures(&all) };
        let teachers = Some((dataset, hands));
        let standing = learn_standing(dataset);
        Ok(Self { full, diagonal, plain, usual, postures, modes, standing, teachers })
    }

    /// What a saved model teaches.
    fn saved(model: &PostureModel) -> Self {
        let full = model.law.clone();
        let n = full.dof();
        let weight = DMatrix::identity(n, n);
        let plain = PostureLaw { weight, attraction: None, offset: None, ..full.clone() };
        Self {
            usual: full.attraction.clone(),
            full,
            diagonal: None,
            plain,
            postures: model.postures.clone(),
            modes: model.modes.clone(),
            standing: model.standing.clone(),
            teachers: None,
        }
    }

    /// The posture of the frame whose hand is nearest.
    fn nearest(&self, hand: &crate::math::Pose, stature_m: f64) -> Option<&DVector<f64>> {
        let (dataset, hands) = self.teachers.as_ref()?;
        let own_m = dataset.coupling.stature_m();
        let x = hands.of(hand, stature_m);
        let away = |f: &Frame| -> f64 {
            hands.of(&f.hand, own_m).iter().zip(&x).map(|(a, b)| (a - b).powi(2)).sum()
        };
        let near = dataset.frames.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        near.map(|f| &f.q)
    }
}

fn left_out(
    person: &Person,
    others: &[&Person],
    common: &Body,
    settings: &TrainSettings,
) -> Result<PersonScore, InputError> {
    let groups: Vec<Vec<_>> =
        others.iter().map(|p| p.movements.iter().map(|m| m.trial.clone()).collect()).collect();
    let dataset = Dataset::of_people(&groups, common, person.side)?;
    judged(person, &Taught::by(&dataset, settings)?, settings)
}

/// How well a person's movements are predicted.
fn judged(
    person: &Person,
    taught: &Taught,
    settings: &TrainSettings,
) -> Result<PersonScore, InputError> {
    let trials: Vec<_> = person.movements.iter().map(|m| m.trial.clone()).collect();
    let own = Dataset::new(&trials, &person.body, person.side)?;
    let measurer = Measurer::new(&person.body, person.side)?;
    let all: Vec<&Frame> = own.frames.iter().collect();
    let movements: Vec<MovementScore> = runs(&all)
        .par_iter()
        .filter(|run| run.len() > 2)
        .map(|run| {
            let movement = &person.movements[run[0].trial];
            score((taught, &own), &measurer, (movement, run), settings)
        })
        .collect::<Option<Vec<_>>>()
        .ok_or_else(super::super::methods::singular)?;
    Ok(PersonScore {
        person: person.name.clone(),
        stature_m: person.body.size.stature_m,
        movements,
        standing: taught.standing.as_ref().map(|place| judge_standing(place, &own)),
    })
}

/// A difference in the unit of the scores: of hips, leg lengths become cm of a leg of `leg_m`.
fn in_units(difference: f64, feature: usize, leg_m: f64) -> f64 {
    if feature == 0 { 100.0 * leg_m * difference } else { difference }
}

fn score(
    (taught, own): (&Taught, &Dataset),
    measurer: &Measurer,
    (movement, run): (&Movement, &[&Frame]),
    settings: &TrainSettings,
) -> Option<MovementScore> {
    let row = |f: &Frame| (f.time_s * movement.trial.rate_hz).round() as usize;
    let seen: Vec<Features> = run.iter().map(|f| movement.seen[row(f)]).collect();
    let leg_m = measurer.legs.length_m();
    let rms = |postures: &mut dyn Iterator<Item = Features>| -> Features {
        let mut sum = [0.0; FEATURES.len()];
        for (found, seen) in postures.zip(&seen) {
            for (c, s) in sum.iter_mut().enumerate() {
                *s += in_units(found[c] - seen[c], c, leg_m).powi(2);
            }
        }
        sum.map(|s| (s / run.len() as f64).sqrt())
    };
    let stature_m = own.coupling.stature_m();
    let predicted = |predictor: Predictor| -> Option<Features> {
        let walked = |law: &PostureLaw| {
            let (path, start) = walk_path(own, law, run);
            let rollout = roll_out(&own.coupling, law, &path, &start, None);
            rms(&mut rollout.q.iter().map(|q| measurer.measure(q.as_slice())))
        };
        let of = |q: &DVector<f64>| measurer.measure(q.as_slice());
        match predictor {
            Predictor::FullW => Some(walked(&taught.full)),
            Predictor::DiagonalW => taught.diagonal.as_ref().map(walked),
            Predictor::PlainIk => Some(walked(&taught.plain)),
            Predictor::Regression => {
                let usual = taught.usual.as_ref()?;
                let at = |f: &&Frame| of(&usual.usual_posture(&f.hand, stature_m).posture);
                Some(rms(&mut run.iter().map(at)))
            }
            Predictor::NearestNeighbour => {
                let at = |f: &&Frame| taught.nearest(&f.hand, stature_m).map(of);
                let all: Option<Vec<Features>> = run.iter().map(at).collect();
                Some(rms(&mut all?.into_iter()))
            }
            Predictor::MeanPosture => Some(rms(&mut run.iter().map(|_| of(&taught.postures.mean)))),
        }
    };
    let predictors = Predictor::ALL
        .iter()
        .filter_map(|&predictor| Some(PredictorScore { predictor, rms: predicted(predictor)? }))
        .collect();
    let stranger = |modes: Option<&Modes>| {
        let people = Modelled::of((&taught.full, &taught.postures), modes)?;
        let how = (settings.seed, REPETITIONS);
        let (walks, ended_share) = strangers(&people, (own, measurer), run, how);
        let (features, energy_deg) = bands(&walks, &seen, leg_m);
        Some(Bands { features, energy_deg, ended_share })
    };
    let place = low_place(run.iter().map(|f| &f.hand), stature_m);
    let told = taught.modes.as_ref().and_then(|modes| modes.at(place));
    let one_law = stranger(None)?;
    let bands = match told {
        Some(_) => stranger(taught.modes.as_ref())?,
        None => one_law.clone(),
    };
    Some(MovementScore {
        movement: movement.trial.source.clone(),
        frames: run.len(),
        predictors,
        bands,
        one_law,
        modes: told.map_or_else(Vec::new, |t| t.shares),
        fit_rms: rms(&mut run.iter().map(|f| measurer.measure(f.q.as_slice()))),
    })
}

/// What the bands of repetitions (R x T) hold of the record, and the energy score of the angles.
fn bands(walks: &[Vec<Features>], seen: &[Features], leg_m: f64) -> (Vec<FeatureScore>, f64) {
    if walks.len() < 2 {
        let none = |feature| FeatureScore { feature, coverage: [0.0; 2], width_90: 0.0 };
        return (FEATURES.into_iter().map(none).collect(), f64::NAN);
    }
    let features = FEATURES.iter().enumerate().map(|(c, &feature)| {
        let (mut inside, mut width) = ([0.0; 2], 0.0);
        for (t, seen) in seen.iter().enumerate() {
            let mut values: Vec<f64> = walks.iter().map(|w| w[t][c]).collect();
            values.sort_by(f64::total_cmp);
            let at = |p: f64| band_end(&values, p);
            let within = |low: f64, high: f64| f64::from(u8::from((low..=high).contains(&seen[c])));
            inside[0] += within(at(0.25), at(0.75));
            inside[1] += within(at(0.05), at(0.95));
            width += in_units(at(0.95) - at(0.05), c, leg_m);
        }
        let count = seen.len() as f64;
        FeatureScore { feature, coverage: inside.map(|i| i / count), width_90: width / count }
    });
    (features.collect(), mean_energy_deg(walks, seen))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::Side;
    use crate::math::stats::mean;
    use crate::training::SimulatedMovements;
    use crate::training::dataset::Trial;
    use crate::training::motion_file::trial_of;
    use std::path::Path;

    /// Made-up people who differ by chance only.
    fn people(count: u64) -> Vec<Person> {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let measurer = Measurer::new(&body, Side::Right).unwrap();
        let movement = |trial: Trial| Movement {
            seen: trial.q.iter().map(|q| measurer.measure(q)).collect(),
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
        let found = validate(&people, &body, &settings, &mut told).unwrap().unwrap();
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
        // What was measured was the body itself, but for the filter's hair at the ends.
        assert!(movements.iter().flat_map(|m| m.fit_rms).all(|f| f < 1e-9));
        let mut stop = |_: usize, _: usize| false;
        assert!(validate(&people, &body, &settings, &mut stop).unwrap().is_none());
        assert!(validate(&people[..1], &body, &settings, &mut stop).is_err());
        let mut unlike = people;
        unlike[2].side = Side::Left;
        let error = validate(&unlike, &body, &settings, &mut stop).unwrap_err();
        assert!(error.message().contains("left hand"), "{error}");
    }

    #[test]
    fn the_energy_score_is_that_of_a_naive_loop() {
        let seen = vec![[0.0, 1.0, 2.0, 3.0, 4.0]; 2];
        let walks: Vec<Vec<Features>> =
            (0..5).map(|i| vec![[0.0, f64::from(i), 2.0, 3.0 - f64::from(i), 4.0]; 2]).collect();
        let (features, energy) = bands(&walks, &seen, 0.9);
        // |x - y| is hypot(i - 1, i); |x - x'| is root two times |i - j|.
        let to: f64 =
            (0..5).map(|i| f64::hypot(f64::from(i) - 1.0, f64::from(i))).sum::<f64>() / 5.0;
        let mut between = 0.0;
        for i in 0..5 {
            for j in 0..5 {
                between += f64::from(i - j).abs() * 2f64.sqrt() / 20.0;
            }
        }
        assert!((energy - (to - 0.5 * between)).abs() < 1e-12, "{energy}");
        assert_eq!(features[3].coverage[1], 1.0);
        assert_eq!(features[2].width_90, 0.0);
    }
}
