//! The posture model: everything learned about one person, with where it came from.

use super::attraction::Attraction;
use super::noise::Noise;
use super::null_space_gp::NullSpaceGp;
use crate::human::{BodySize, Side};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A choice of z and W in the conditioned Gaussian.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// W = I: the plain pseudo-inverse.
    PlainIk,
    /// A diagonal W by least squares.
    WIk,
    /// A full W: the shrunk second moment of the joint velocities.
    FullW,
    /// The paper's: a diagonal W and a Gaussian process in the null space.
    MiNsgp,
}

impl Method {
    /// All methods, in the order in which they are shown.
    pub const ALL: [Self; 4] = [Self::PlainIk, Self::WIk, Self::FullW, Self::MiNsgp];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlainIk => "plain-ik",
            Self::WIk => "w-ik",
            Self::FullW => "full-w",
            Self::MiNsgp => "mi-nsgp",
        }
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
}

impl PostureDistribution {
    /// Mahalanobis distance of a posture (n, rad) to the training postures.
    pub fn mahalanobis(&self, q: &DVector<f64>) -> f64 {
        let d = q - &self.mean;
        let Some(factor) = self.covariance.clone().cholesky() else { return f64::INFINITY };
        factor.l().solve_lower_triangular(&d).map_or(f64::INFINITY, |v| v.norm())
    }

    /// The distance that 1 % of draws exceed: root of the 99 % quantile of chi-squared with n
    /// degrees of freedom (Wilson and Hilferty 1931, within 0.5 % for n >= 5).
    pub fn unusual_distance(&self) -> f64 {
        let n = self.mean.len() as f64;
        let c = 2.0 / (9.0 * n);
        (n * (1.0 - c + 2.326_347_9 * c.sqrt()).powi(3)).sqrt()
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
}

/// Where a model comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of ergopath that trained it.
    pub program_version: String,
    /// True when the movements are those of a simulated operator.
    pub simulated: bool,
    /// File names of the recordings and the SHA-256 of their bytes.
    pub recordings: Vec<(String, String)>,
    /// Name of the body and the SHA-256 of its files.
    pub body: (String, String),
    /// Settings of the training, as name and value.
    pub settings: Vec<(String, String)>,
    /// Remarks of the fit, for the report.
    pub notes: Vec<String>,
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
    /// W, n x n, (rad/s)^2.
    pub weight: DMatrix<f64>,
    /// The pull towards the person's postures.
    pub attraction: Option<Attraction>,
    /// The null-space process of MI-NsGP.
    pub gp: Option<NullSpaceGp>,
    /// What differs between repetitions.
    pub noise: Noise,
    /// The person's postures.
    pub postures: PostureDistribution,
    /// Held-out quality of this and the other methods.
    pub quality: Vec<MethodQuality>,
    /// Where it comes from.
    pub provenance: Provenance,
}

impl PostureModel {
    /// Share of the joint-velocity variance by group of joints: (group, share), summing to 1.
    ///
    /// W is only known up to its scale, and single joints are poorly determined; groups are stable.
    pub fn weight_by_group(&self) -> Vec<(&'static str, f64)> {
        let groups = ["spine", "girdle", "shoulder", "elbow", "wrist"];
        let total = self.weight.trace();
        groups
            .into_iter()
            .map(|g| {
                let share: f64 = self
                    .joints
                    .iter()
                    .enumerate()
                    .filter(|(_, j)| group_of(j) == g)
                    .map(|(i, _)| self.weight[(i, i)])
                    .sum();
                (g, share / total)
            })
            .collect()
    }
}

/// Joint group of an Xsens joint name.
fn group_of(joint: &str) -> &'static str {
    if joint.contains("C7Shoulder") {
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
