//! What the paper's experiments found: facts by chain, training set, method and movement.

use super::against::{Against, WeightAgreement};
use super::horizon::{HorizonCurve, Walk};
use super::sets::PaperExperiment;
use super::spread::PostureSpread;
use super::summary::MethodSummary;
use crate::posture::Method;
use crate::training::Bands;
use serde::Serialize;

/// What of the body is predicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Chain {
    /// From a pelvis that rests to the hand, 24 joints: the paper's.
    Arm,
    /// The pelvis over its feet besides: 30 coordinates.
    Whole,
}

impl Chain {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Arm, Self::Whole];

    /// Its name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Arm => "arm",
            Self::Whole => "whole",
        }
    }
}

/// How much taught and tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SetSize {
    /// People.
    pub people: usize,
    /// Movements.
    pub movements: usize,
    /// Frames, at about 30 Hz.
    pub frames: usize,
}

/// What a method made of one held-out movement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovementScore {
    /// Name of the recording or repetition.
    pub movement: String,
    /// Frames.
    pub frames: usize,
    /// Mean log-likelihood of the joint velocity, nats per frame.
    pub ll_q: f64,
    /// The same within the null space, nats per frame.
    pub ll_null: f64,
    /// Mean over frames of the squared residual within the null space in units of its predicted variance, by
    /// dimension: 1 where the law knows how sure it is, more where it is too sure.
    pub surprise: f64,
    /// RMSE of the joint velocity, rad/s.
    pub rmse_q: f64,
    /// The same over the rms of the joint velocity.
    pub relative_rmse_q: f64,
    /// Mean log-likelihood of the task velocity, nats per frame.
    pub ll_x: f64,
    /// RMSE of the task velocity, m/s and rad/s.
    pub rmse_x: f64,
    /// Share of joint velocities inside the central 50 and 90 % band of the prediction.
    pub velocity_coverage: [f64; 2],
    /// Errors over the horizon.
    #[serde(skip)]
    pub(super) walk: Option<Walk>,
}

/// What a method made of one training set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodOnSet {
    /// The method.
    pub method: Method,
    /// Relative RMSE over all frames that test.
    pub relative_rmse_q: f64,
    /// Mean log-likelihood of the joint velocity over all of them, nats per frame.
    pub ll_q: f64,
    /// [`MovementScore::surprise`] over all of them.
    pub surprise: f64,
    /// Log-likelihood within the null space were all covariances scaled by that, nats per frame: what the law says
    /// when its sureness is put right in hindsight.
    pub ll_rescaled: f64,
    /// Diagonal of W over its geometric mean, n; none of methods that do not learn W.
    pub weights: Option<Vec<f64>>,
    /// What bands of repetitions from the known start held, of methods of which it was asked.
    pub bands: Option<Bands>,
    /// The held-out movements.
    pub movements: Vec<MovementScore>,
}

/// One training set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetResult {
    /// Who is predicted.
    pub who: String,
    /// What they do.
    pub task: String,
    /// What taught.
    pub train: SetSize,
    /// What tested.
    pub test: SetSize,
    /// Participation rank of the joint velocities that taught: (sum l)^2 / sum l^2 over the eigenvalues l of
    /// their second moment.
    pub rank: f64,
    /// The methods, in the order asked for.
    pub methods: Vec<MethodOnSet>,
}

/// All sets on one chain.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainResult {
    /// Which.
    pub chain: Chain,
    /// Names of the joints, n.
    pub joints: Vec<String>,
    /// The sets.
    pub sets: Vec<SetResult>,
    /// Methods over all held-out movements of all sets.
    pub methods: Vec<MethodSummary>,
    /// MI-NsGP against each other method, set by set.
    pub against: Vec<Against>,
    /// How far W agrees between sets.
    pub weights: Vec<WeightAgreement>,
    /// Errors of hand and joints over the horizon.
    pub horizon: Vec<HorizonCurve>,
    /// Sampled trajectories of one held-out movement, of methods of which bands were asked.
    #[serde(skip)]
    pub spreads: Vec<PostureSpread>,
}

/// One of the paper's experiments.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperResult {
    /// Which.
    pub experiment: PaperExperiment,
    /// Whether nobody was recorded.
    pub simulated: bool,
    /// Whether other people taught.
    pub taught_by_others: bool,
    /// Seed of everything random.
    pub seed: u64,
    /// By chain.
    pub chains: Vec<ChainResult>,
}
