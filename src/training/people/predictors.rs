//! What predicts a posture from the path of the hand, and what it was taught by.

use super::super::dataset::{Dataset, Frame};
use super::super::methods::{Law, learn_laws};
use super::super::modes::learn_modes;
use super::super::rollout_check::{sampled_law, walk_path};
use super::super::settings::TrainSettings;
use super::super::spread::{learn_about_usual, learn_attraction, learn_postures};
use super::super::standing::learn_standing;
use crate::files::InputError;
use crate::posture::{
    Attraction, Behaviour, Certain, Grips, HandFeatures, Method, Modes, PostureDistribution,
    PostureLaw, PostureModel, StandingPlace, Start, StartRule, roll_out,
};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

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

    /// Whether it follows the hand from a first posture on.
    pub fn needs_start(self) -> bool {
        matches!(self, Self::FullW | Self::DiagonalW | Self::PlainIk)
    }
}

/// What the others teach.
pub(super) struct Taught<'a> {
    pub full: PostureLaw,
    diagonal: Option<PostureLaw>,
    plain: PostureLaw,
    usual: Option<Attraction>,
    pub postures: PostureDistribution,
    pub modes: Option<Modes>,
    pub standing: Option<StandingPlace>,
    /// Whom it was learned from, and how their hands compare; not known of a saved model.
    teachers: Option<(&'a Dataset, HandFeatures)>,
}

impl<'a> Taught<'a> {
    pub(super) fn by(dataset: &'a Dataset, settings: &TrainSettings) -> Result<Self, InputError> {
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
        let postures = learn_about_usual(dataset, settings, learn_postures(&all));
        let teachers = Some((dataset, hands));
        let standing = learn_standing(dataset);
        Ok(Self { full, diagonal, plain, usual, postures, modes, standing, teachers })
    }

    /// What a saved model teaches.
    pub(super) fn saved(model: &PostureModel) -> Self {
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

    /// The posture in which these people usually begin with the hand at the start of a run, for everything that
    /// follows the hand; none where the body does not reach it.
    pub(super) fn usual_start(&self, own: &Dataset, run: &[&Frame]) -> Option<DVector<f64>> {
        let people = Certain { law: &self.full, postures: &self.postures };
        let grips = Grips::from(&run[0].hand);
        people.starts(&own.coupling, &grips, None, &StartRule::Mean, (0, 0), 0..1).pop()?.q
    }

    /// The postures (T) of a predictor along a run, without chance; those that follow the hand do so from `start`.
    /// None where it was not taught.
    pub(super) fn postures(
        &self,
        predictor: Predictor,
        (own, run): (&Dataset, &[&Frame]),
        start: &DVector<f64>,
    ) -> Option<Vec<DVector<f64>>> {
        let stature_m = own.coupling.stature_m();
        let walked = |law: &PostureLaw| {
            let (path, recorded) = walk_path(own, law, run);
            let start = Start { q: Some(start.clone()), ..recorded };
            roll_out(&own.coupling, law, &path, &start, None).q
        };
        match predictor {
            Predictor::FullW => Some(walked(&self.full)),
            Predictor::DiagonalW => self.diagonal.as_ref().map(walked),
            Predictor::PlainIk => Some(walked(&self.plain)),
            Predictor::Regression => {
                let usual = self.usual.as_ref()?;
                let at = |f: &&Frame| usual.usual_posture(&f.hand, stature_m).posture;
                Some(run.iter().map(at).collect())
            }
            Predictor::NearestNeighbour => {
                run.iter().map(|f| self.nearest(&f.hand, stature_m).cloned()).collect()
            }
            Predictor::MeanPosture => Some(vec![self.postures.mean.clone(); run.len()]),
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
