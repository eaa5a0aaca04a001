//! What is true of all movements of people who were left out.

use super::left_out::{LeftOut, MovementScore, PersonScore, PredictorScore};
use super::predictors::Predictor;
use super::risk::{Agreement, SheetMean, agreement};
use super::{CENTRES, FEATURES};
use crate::ergonomics::{BodyPart, ScoringMethod};
use crate::math::stats::mean;
use serde::Serialize;

/// What is known to a predictor that follows the hand: where it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// The usual posture at the first place of the hand: nothing is known but its path.
    HandPath,
    /// The recorded first posture.
    Start,
}

/// How scores that repetitions predict go with recorded ones.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RiskAgreement {
    /// Of the mean over repetitions.
    #[serde(flatten)]
    pub agreement: Agreement,
    /// Share of the movements whose recorded score is in the 50 % band.
    pub inside50: f64,
    /// The same of the 90 % band.
    pub inside90: f64,
    /// Mean width of the 90 % band.
    pub width90: f64,
    /// Movements that were compared.
    pub movements: usize,
}

/// Mean coverage (50 or 90 %) of a feature over the frames of movements.
pub fn coverage(movements: &[&MovementScore], feature: usize, level: usize) -> f64 {
    let frames: usize = movements.iter().map(|m| m.frames).sum();
    let inside: f64 =
        movements.iter().map(|m| m.frames as f64 * m.bands.features[feature].coverage[level]).sum();
    inside / frames.max(1) as f64
}

impl PersonScore {
    /// The movements, by reference.
    pub fn own(&self) -> Vec<&MovementScore> {
        self.movements.iter().collect()
    }
}

/// Means of figures of a predictor over movements that have them; NaN where none has.
fn over(
    movements: &[&MovementScore],
    predictor: Predictor,
    of: impl Fn(&PredictorScore) -> f64,
) -> f64 {
    let scores = movements.iter().filter_map(|m| m.by(predictor));
    mean(&scores.map(of).collect::<Vec<_>>())
}

impl MovementScore {
    /// What a predictor says; none where it was not taught.
    pub fn by(&self, predictor: Predictor) -> Option<&PredictorScore> {
        self.predictors.iter().find(|p| p.predictor == predictor)
    }
}

impl LeftOut {
    /// The movements of everybody.
    pub fn movements(&self) -> Vec<&MovementScore> {
        self.people.iter().flat_map(|p| &p.movements).collect()
    }

    /// The predictors that were there to be judged, the law first.
    pub fn predictors(&self) -> Vec<Predictor> {
        let all = self.movements();
        let known = |p: &Predictor| all.iter().any(|m| m.by(*p).is_some());
        Predictor::ALL.into_iter().filter(known).collect()
    }

    /// Mean over movements of the rms of a feature by a predictor.
    pub fn rms(&self, predictor: Predictor, feature: usize) -> f64 {
        over(&self.movements(), predictor, |p| p.rms[feature])
    }

    /// Mean over movements of the rms distance of the joint centres, cm.
    pub fn centres_cm(&self, predictor: Predictor) -> [f64; CENTRES.len()] {
        let all = self.movements();
        std::array::from_fn(|i| over(&all, predictor, |p| p.centres_cm[i]))
    }

    /// Mean rms of the angles of each person, deg.
    pub fn angle_errors_deg(&self, predictor: Predictor) -> Vec<f64> {
        let angles = |p: &PredictorScore| mean(&p.rms[1..]);
        self.people.iter().map(|p| over(&p.own(), predictor, angles)).collect()
    }

    /// Mean coverage (50 or 90 %) of the features.
    pub fn pooled(&self, level: usize) -> f64 {
        let all = self.movements();
        mean(&(0..FEATURES.len()).map(|f| coverage(&all, f, level)).collect::<Vec<_>>())
    }

    /// The lowest coverage of a feature of a person.
    pub fn worst(&self, level: usize) -> f64 {
        self.people
            .iter()
            .flat_map(|p| (0..FEATURES.len()).map(|f| coverage(&p.own(), f, level)))
            .fold(f64::INFINITY, f64::min)
    }

    /// Mean over movements of the continuous ranked probability score of a feature, cm or deg.
    pub fn crps(&self, feature: usize) -> f64 {
        let all = self.movements();
        let known = all.iter().filter_map(|m| m.bands.features[feature].crps);
        mean(&known.collect::<Vec<_>>())
    }

    /// How scores by repetitions of strangers go with recorded ones.
    pub fn risk(&self, method: ScoringMethod) -> RiskAgreement {
        let all = self.movements();
        let scores: Vec<_> =
            all.iter().filter_map(|m| m.risk.as_ref()).map(|r| &r[method]).collect();
        let share = |inside: &[bool]| {
            inside.iter().filter(|i| **i).count() as f64 / inside.len().max(1) as f64
        };
        let inside50: Vec<bool> = scores.iter().map(|s| s.is_inside(s.band_50)).collect();
        let inside90: Vec<bool> = scores.iter().map(|s| s.is_inside(s.band_90)).collect();
        let width: Vec<f64> = scores.iter().map(|s| s.band_90[1] - s.band_90[0]).collect();
        let pairs: Vec<[f64; 2]> = scores.iter().map(|s| [s.recorded, s.predicted]).collect();
        RiskAgreement {
            agreement: agreement(&pairs),
            inside50: share(&inside50),
            inside90: share(&inside90),
            width90: mean(&width),
            movements: scores.len(),
        }
    }

    /// The same if a part of the body were known.
    pub fn risk_with(&self, method: ScoringMethod, part: BodyPart) -> Agreement {
        let all = self.movements();
        let pairs = all.iter().filter_map(|m| m.risk.as_ref()).filter_map(|risk| {
            let score = &risk[method];
            let known = score.with_recorded.iter().find(|k| k.part == part)?;
            Some([score.recorded, known.predicted])
        });
        agreement(&pairs.collect::<Vec<_>>())
    }

    /// The same of a predictor without chance; none where no movement has it.
    pub fn risk_of(
        &self,
        method: ScoringMethod,
        predictor: Predictor,
        known: Known,
    ) -> Option<Agreement> {
        let all = self.movements();
        let pairs = all.iter().filter_map(|m| {
            let by = m.by(predictor)?;
            let predicted = match known {
                Known::HandPath => by.risk?[method],
                Known::Start => by.risk_known_start[method],
            };
            Some([m.risk.as_ref()?[method].recorded, predicted])
        });
        let pairs: Vec<[f64; 2]> = pairs.collect();
        (!pairs.is_empty()).then(|| agreement(&pairs))
    }

    /// What is entered in the sheets, mean over movements.
    pub fn entered(&self) -> Vec<SheetMean> {
        let all = self.movements();
        let Some(first) = all.first() else { return Vec::new() };
        let over = |i: usize, of: fn(&SheetMean) -> f64| {
            let values = all.iter().map(|m| of(&m.entered[i])).filter(|v| v.is_finite());
            mean(&values.collect::<Vec<_>>())
        };
        let columns = first.entered.iter().enumerate();
        columns
            .map(|(i, entered)| SheetMean {
                column: entered.column,
                recorded: over(i, |e| e.recorded),
                predicted: over(i, |e| e.predicted),
            })
            .collect()
    }

    /// How well standing places were predicted: rms ahead and to the right (m), and the share within what the others
    /// say of 90 %, all movements alike; none where no model says.
    pub fn standing(&self) -> Option<([f64; 2], f64)> {
        let of = |p: &PersonScore| Some((p.movements.len() as f64, p.standing.clone()?));
        let all: Vec<_> = self.people.iter().filter_map(of).collect();
        let count = Some(all.iter().map(|(n, _)| n).sum::<f64>()).filter(|n| *n > 0.0)?;
        let rms = |i: usize| {
            (all.iter().map(|(n, s)| n * s.rms_m[i].powi(2)).sum::<f64>() / count).sqrt()
        };
        let inside = all.iter().map(|(n, s)| n * s.inside_90).sum::<f64>() / count;
        Some(([rms(0), rms(1)], inside))
    }
}
