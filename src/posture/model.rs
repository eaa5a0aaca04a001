//! The posture model: everything learned about one person, with where it came from.

use super::attraction::UsualPosture;
use super::law::PostureLaw;
use super::lowness::Lowness;
use super::modes::Modes;
use super::population::Population;
use super::standing::StandingPlace;
use crate::files::Seal;
use crate::human::{BodySize, Side};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A choice of z and W in the conditioned Gaussian; the paper's six, ours, and the plain one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The paper's: a diagonal W and a Gaussian process in the null space.
    MiNsgp,
    /// A Gaussian process for the joint velocity itself; the task is not met.
    Gp,
    /// A diagonal W by least squares.
    WIk,
    /// W = I and a Gaussian process in the null space.
    Nsgp,
    /// W = I and one normal distribution in the null space.
    SbM,
    /// A movement primitive conditioned on the hand's velocity.
    Promp,
    /// A full W: the shrunk second moment of the joint velocities.
    FullW,
    /// The full W and a Gaussian process on top.
    FullWGp,
    /// W = I: the plain pseudo-inverse.
    PlainIk,
}

impl Method {
    /// The paper's six and ours.
    pub const EIGHT: [Self; 8] = [
        Self::MiNsgp,
        Self::Gp,
        Self::WIk,
        Self::Nsgp,
        Self::SbM,
        Self::Promp,
        Self::FullW,
        Self::FullWGp,
    ];
    /// All methods, the plain pseudo-inverse first for comparison.
    pub const ALL: [Self; 9] = [
        Self::PlainIk,
        Self::WIk,
        Self::FullW,
        Self::MiNsgp,
        Self::FullWGp,
        Self::Nsgp,
        Self::SbM,
        Self::Promp,
        Self::Gp,
    ];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::MiNsgp => "mi-nsgp",
            Self::Gp => "gp",
            Self::WIk => "w-ik",
            Self::Nsgp => "nsgp",
            Self::SbM => "sb-m",
            Self::Promp => "promp",
            Self::FullW => "full-w",
            Self::FullWGp => "full-w-gp",
            Self::PlainIk => "plain-ik",
        }
    }

    /// Whether its W is searched or moulded from the data.
    pub fn identifies_weights(self) -> bool {
        matches!(self, Self::MiNsgp | Self::WIk | Self::FullW | Self::FullWGp)
    }

    /// Whether it has a Gaussian process.
    pub fn has_process(self) -> bool {
        matches!(self, Self::MiNsgp | Self::Nsgp | Self::FullWGp | Self::Gp)
    }
}

/// The person's postures as a Gaussian.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PostureDistribution {
    /// Mean, n, rad.
    pub mean: DVector<f64>,
    /// Shrunk covariance, n x n, rad^2, positive definite.
    pub covariance: DMatrix<f64>,
    /// Shrunk covariance about the usual posture at a place of the hand, n x n, rad^2; none where the
    /// postures of all places are taken together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about_usual: Option<DMatrix<f64>>,
    /// The same of hands that reach down, where it is another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<LowPostures>,
    /// What of that is a person's own; none of a model of one person.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub population: Option<Population>,
}

/// How postures spread about the usual one where the hand is low.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LowPostures {
    /// Where that is.
    pub lowness: Lowness,
    /// Shrunk covariance, n x n, rad^2.
    pub about_usual: DMatrix<f64>,
}

impl PostureDistribution {
    /// Of all postures, wherever the hand was.
    pub fn anywhere(mean: DVector<f64>, covariance: DMatrix<f64>) -> Self {
        Self { mean, covariance, about_usual: None, low: None, population: None }
    }

    /// Of the postures with the hand at a place where `usual` is, at a height (rest frame, over stature): the
    /// more the training says of it, the narrower, or the less of the postures elsewhere.
    pub fn near(&self, usual: &UsualPosture, height: f64) -> Cow<'_, Self> {
        let Some(about) = &self.about_usual else { return Cow::Borrowed(self) };
        let about = match &self.low {
            Some(low) => {
                let share = low.lowness.of(height);
                Cow::Owned(about * (1.0 - share) + &low.about_usual * share)
            }
            None => Cow::Borrowed(about),
        };
        if let Some(growth) = usual.growth {
            let of_here = Self::anywhere(usual.posture.clone(), about.into_owned() * growth);
            return Cow::Owned(Self { population: self.population, ..of_here });
        }
        let known = usual.trust();
        let between = |here: f64, anywhere: f64| known * here + (1.0 - known) * anywhere;
        Cow::Owned(Self {
            population: self.population,
            ..Self::anywhere(
                usual.posture.zip_map(&self.mean, between),
                about.zip_map(&self.covariance, between),
            )
        })
    }

    /// What a person has of their own wherever the hand is; none where that is not known.
    pub(super) fn own(&self, block: (u64, u32), person: usize) -> Option<OwnPosture> {
        let z = self.population?.person(block, person, self.mean.len());
        let of = |covariance: &DMatrix<f64>| Some(covariance.clone().cholesky()?.l() * &z);
        let low = match &self.low {
            Some(low) => Some((low.lowness, of(&low.about_usual)?)),
            None => None,
        };
        Some(OwnPosture { high: of(self.about_usual.as_ref()?)?, low })
    }

    /// Mahalanobis distance of a posture (n, rad) to the training postures.
    pub fn mahalanobis(&self, q: &DVector<f64>) -> f64 {
        let d = q - &self.mean;
        let Some(factor) = self.covariance.clone().cholesky() else { return f64::INFINITY };
        factor.l().solve_lower_triangular(&d).map_or(f64::INFINITY, |v| v.norm())
    }

    /// The distance that 1 % of postures exceed: of a Gaussian's draws, or of people who were left out where that
    /// is known.
    pub fn unusual_distance(&self) -> f64 {
        gaussian_99(self.mean.len()) * self.population.map_or(1.0, |own| own.tail)
    }
}

/// Distance that 1 % of draws of a Gaussian in n dimensions exceed: root of the 99 % quantile of chi-squared with n
/// degrees of freedom (Wilson and Hilferty 1931, within 0.5 % for n >= 5).
pub(crate) fn gaussian_99(n: usize) -> f64 {
    let n = n as f64;
    let c = 2.0 / (9.0 * n);
    (n * (1.0 - c + 2.326_347_9 * c.sqrt()).powi(3)).sqrt()
}

/// By what the usual postures of a person differ from those of all.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnPosture {
    /// Of hands that are not low, n, rad.
    high: DVector<f64>,
    low: Option<(Lowness, DVector<f64>)>,
}

impl OwnPosture {
    /// At a height of the hand (rest frame, over stature), n, rad.
    pub(super) fn at(&self, height: f64) -> Cow<'_, DVector<f64>> {
        match &self.low {
            Some((lowness, low)) => Cow::Owned(self.high.lerp(low, lowness.of(height))),
            None => Cow::Borrowed(&self.high),
        }
    }
}

/// How well a method predicts held-out movement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MethodQuality {
    /// The method.
    pub method: Method,
    /// RMSE of the joint velocity over its rms.
    pub relative_rmse: f64,
    /// RMSE of the joint velocity, rad/s.
    pub rmse_rad_s: f64,
    /// Mean log-likelihood of a held-out joint velocity within the null space, nats.
    pub log_likelihood_null: f64,
    /// The same in all n joints, with the stated task noise, nats.
    pub log_likelihood: f64,
    /// Mean joint error along the held-out hand path, deg; without and with the attraction.
    pub path_error_deg: Option<(f64, f64)>,
    /// Share of held-out joint angles inside the 50 and 90 % band of rollouts.
    pub coverage: Option<(f64, f64)>,
    /// Mean width of the 90 % band, deg.
    pub band_width_deg: Option<f64>,
    /// Log-likelihood of whole held-out trajectories, nats per frame.
    pub trajectory_log_likelihood: Option<f64>,
}

/// Where a model comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of ergopath that trained it.
    pub program_version: String,
    /// True when the movements are those of a simulated operator.
    pub simulated: bool,
    /// How many people the movements are of.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub people: usize,
    /// How long the one worker was recorded to whom the model of several people was adapted, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adapted_s: Option<f64>,
    /// The model that hips and knees were filled from where recordings hold no legs, and of how many people it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filled_from: Option<(String, usize)>,
    /// File names of the recordings and the SHA-256 of their bytes.
    pub recordings: Vec<(String, String)>,
    /// Name of the body and the SHA-256 of its files.
    pub body: (String, String),
    /// Settings of the training, as name and value.
    pub settings: Vec<(String, String)>,
    /// Remarks of the fit, for the report.
    pub notes: Vec<String>,
}

fn one() -> usize {
    1
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_one(count: &usize) -> bool {
    *count == 1
}

/// A learned model of how one person resolves redundancy.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PostureModel {
    /// What to call it.
    pub name: String,
    /// The method behind z and W.
    pub method: Method,
    /// The coupled side.
    pub side: Side,
    /// Size of the body on which it was learned.
    pub size: BodySize,
    /// Joints of the chain, n names.
    pub joints: Vec<String>,
    /// z and W, the pull, and what differs between repetitions.
    pub law: PostureLaw,
    /// The person's postures.
    pub postures: PostureDistribution,
    /// Ways of doing the same that are told apart, where that predicts people who were left out better;
    /// the law and the postures are of all together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modes: Option<Modes>,
    /// Where people stand, and so when they step; none where it was not recorded of several people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standing: Option<StandingPlace>,
    /// Held-out quality of this and the other methods.
    pub quality: Vec<MethodQuality>,
    /// Where it comes from.
    pub provenance: Provenance,
    /// Whether its file can say that nobody changed it.
    #[serde(skip)]
    pub seal: Seal,
}

impl PostureModel {
    /// Share of the joint-velocity variance by group of joints: (group, share), summing to 1.
    ///
    /// W is only known up to its scale, and single joints are poorly determined; groups are stable.
    pub fn weight_by_group(&self) -> Vec<(&'static str, f64)> {
        let total = self.law.weight.trace();
        JOINT_GROUPS
            .into_iter()
            .filter(|g| self.joints.iter().any(|j| joint_group(j) == *g))
            .map(|g| {
                let share: f64 = self
                    .joints
                    .iter()
                    .enumerate()
                    .filter(|(_, j)| joint_group(j) == g)
                    .map(|(i, _)| self.law.weight[(i, i)])
                    .sum();
                (g, share / total)
            })
            .collect()
    }
}

/// Groups of joints from the ground to the hand.
const JOINT_GROUPS: [&str; 6] = ["pelvis", "spine", "girdle", "shoulder", "elbow", "wrist"];

/// The group of a joint's name: pelvis, spine, girdle, shoulder, elbow or wrist.
pub fn joint_group(joint: &str) -> &'static str {
    if joint.to_lowercase().contains("pelvis") {
        "pelvis"
    } else if joint.contains("C7Shoulder") {
        "girdle"
    } else if joint.contains("Shoulder") {
        "shoulder"
    } else if joint.contains("Elbow") {
        "elbow"
    } else if joint.contains("Wrist") {
        "wrist"
    } else {
        "spine"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn postures_near_a_place_are_its_own_as_far_as_it_is_known() {
        let all = PostureDistribution {
            about_usual: Some(DMatrix::identity(2, 2) * 0.1),
            ..PostureDistribution::anywhere(DVector::zeros(2), DMatrix::identity(2, 2))
        };
        let posture = DVector::from_vec(vec![0.4, -0.2]);
        let at = |confidence: f64| {
            let usual = UsualPosture { posture: posture.clone(), confidence, growth: None };
            all.near(&usual, 0.0).into_owned()
        };
        let (unknown, half, known) = (at(0.0), at(0.5f64.sqrt()), at(1.0));
        assert_eq!((&unknown.mean, &unknown.covariance), (&all.mean, &all.covariance));
        assert_eq!((&known.mean, Some(&known.covariance)), (&posture, all.about_usual.as_ref()));
        assert!((half.mean - &posture * 0.5).amax() < 1e-12);
        assert!((half.covariance - DMatrix::identity(2, 2) * 0.55).amax() < 1e-12);
        // Wider where the hand is low.
        let lowness = Lowness::linear(0.0, -0.2);
        let low = Some(LowPostures { lowness, about_usual: DMatrix::identity(2, 2) * 0.3 });
        let all = PostureDistribution { low, ..all };
        let usual = UsualPosture { posture: posture.clone(), confidence: 1.0, growth: None };
        for (height, wanted) in [(0.1, 0.1), (-0.1, 0.2), (-0.5, 0.3)] {
            let found = all.near(&usual, height);
            assert!((found.covariance[(0, 0)] - wanted).abs() < 1e-12, "{height}");
        }
        // With a trend: about the usual posture still, only wider.
        let unsure = all.near(&UsualPosture { growth: Some(1.5), confidence: 0.6, ..usual }, 0.1);
        assert_eq!(unsure.mean, posture);
        assert!((unsure.covariance[(0, 0)] - 0.15).abs() < 1e-12);
    }
}
