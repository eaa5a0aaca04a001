//! Settings of the training, with the defaults that held-out recordings chose.

use crate::files::InputError;
use crate::posture::Sampling;
use serde::{Deserialize, Serialize};

/// What the search for weights (and kernel parameters) maximises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// Marginal likelihood.
    #[default]
    Marginal,
    /// Predictive likelihood of each sample from all others.
    LeaveOneOut,
    /// Predictive likelihood of each trial (or block of a single trial) from all others.
    LeaveTrialOut,
    /// The paper's: likelihood of the training targets under the process trained on them.
    InSample,
}

impl Objective {
    /// All of them.
    pub const ALL: [Self; 4] =
        [Self::Marginal, Self::LeaveOneOut, Self::LeaveTrialOut, Self::InSample];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Marginal => "marginal",
            Self::LeaveOneOut => "leave-one-out",
            Self::LeaveTrialOut => "leave-trial-out",
            Self::InSample => "in-sample",
        }
    }
}

/// What the pull towards the person's own postures, and the noise with it, go by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PullRule {
    /// The hand's travel: a resting hand keeps its posture.
    PerMetre,
    /// Time.
    PerSecond,
    /// No pull.
    None,
}

impl PullRule {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::PerMetre, Self::PerSecond, Self::None];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::PerMetre => "per-metre",
            Self::PerSecond => "per-second",
            Self::None => "none",
        }
    }
}

/// How the weights are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Optimiser {
    /// L-BFGS with the closed-form gradient (the default).
    #[default]
    Lbfgs,
    /// The paper's BIPOP-CMA-ES, without gradients.
    BipopCmaEs,
}

impl Optimiser {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Lbfgs, Self::BipopCmaEs];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lbfgs => "lbfgs",
            Self::BipopCmaEs => "bipop-cma-es",
        }
    }
}

/// Length-scales of the kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lengths {
    /// One for the postures, one for the velocities (the default).
    #[default]
    Groups,
    /// One for all inputs, as in the paper.
    Isotropic,
}

/// What can be chosen when a posture model is learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainSettings {
    /// Share a of the least-squares diagonal in full-w, 0 to 1; by default 0.3, or 0.5 for a single
    /// trial shorter than 4 s.
    pub shrinkage: Option<f64>,
    /// Part of the mean joint-velocity variance that is added to the diagonal of full-w.
    pub diagonal_share: f64,
    /// The pull towards the person's own postures; by default per metre for people, and per second for
    /// other chains and for the published sampler.
    pub pull: Option<PullRule>,
    /// Hand travel after which the pull per metre leaves 1/e of a departure, m. Mean path error over
    /// sixteen splits of eight people: 4.28, 4.23 deg for 0.2, 0.4 m (4.35 with 4 /s, 5.99 without a
    /// pull). Over six of these splits, three people: 2.69 instead of 2.47 deg without the way of the
    /// usual posture; an offset that keeps the start's departure from it changes less than 0.02 deg.
    pub attraction_length_m: f64,
    /// Rate of the pull per second, 1/s.
    pub attraction_rate_per_s: f64,
    /// Its length-scale in standard deviations of the hand's features. Mean path error over six
    /// folds of two people (time splits at 60 and 70 %, blocks): 3.70, 3.80, 3.69, 3.58 deg for 0.5,
    /// 1, 2, 3; over the blocks alone 2.22, 1.90, 1.64, 1.64 deg, and 2.41 without a pull.
    pub attraction_length: f64,
    /// Length-scale of the usual postures of several people, which go by the hand's place, over the stature.
    pub place_length: f64,
    /// Its noise variance over signal variance.
    pub attraction_noise: f64,
    /// Most training postures behind it.
    pub attraction_postures: usize,
    /// What the search for weights and kernels maximises; by default leave-trial-out where there are
    /// at least three whole movements, else marginal likelihood.
    pub objective: Option<Objective>,
    /// How it searches.
    pub optimiser: Optimiser,
    /// Whether kernel parameters are fitted anew to every weight that the search tries, as published
    /// (and with BIPOP-CMA-ES whatever `optimiser` says); far slower, and on few samples only.
    pub refits_kernel: bool,
    /// Length-scales of the kernel: one for each group of inputs, or one for all.
    pub lengths: Lengths,
    /// Whether each joint has kernel parameters of its own; costs a factorisation for each.
    pub separate_kernels: bool,
    /// Smallest noise ratio of a process. Frames of people are nearly copies of each other: with a
    /// smaller one the process learns movements by heart.
    pub noise_ratio_floor: f64,
    /// Standard deviation of the prior on each log weight.
    pub weight_prior_sd: f64,
    /// Most samples behind an exact process; beyond, inducing centres.
    pub exact_samples: usize,
    /// Most samples in the search for weights and kernel parameters.
    pub search_samples: usize,
    /// Number of inducing centres; by default the number that held-out blocks ask for.
    pub inducing: Option<usize>,
    /// Standard deviation in every null direction below which nothing is claimed, rad/s.
    pub null_floor_rad_s: f64,
    /// How repetitions are drawn where bands are judged.
    pub sampling: Sampling,
    /// Seed of everything random.
    pub seed: u64,
}

impl Default for TrainSettings {
    fn default() -> Self {
        Self {
            shrinkage: None,
            diagonal_share: 1e-2,
            pull: None,
            attraction_length_m: 0.4,
            attraction_rate_per_s: 4.0,
            attraction_length: 2.0,
            place_length: 0.15,
            attraction_noise: 0.05,
            attraction_postures: 120,
            objective: None,
            optimiser: Optimiser::Lbfgs,
            refits_kernel: false,
            lengths: Lengths::Groups,
            separate_kernels: false,
            noise_ratio_floor: 0.1,
            weight_prior_sd: 1.0,
            exact_samples: 2000,
            search_samples: 1000,
            inducing: None,
            null_floor_rad_s: 0.01,
            sampling: Sampling::Pathwise,
            seed: 0,
        }
    }
}

impl TrainSettings {
    /// The objective for data of a number of whole movements.
    ///
    /// Frames of one movement share its noise. Marginal likelihood takes that for knowledge: on 20
    /// trajectories of a 5R chain with correlated noise its bands are 1.6 to 3.6 times as wide as
    /// needed once calibrated, those of leave-trial-out 1.1 to 1.3 times.
    pub fn objective_for(&self, trials: usize) -> Objective {
        let own = if trials >= 3 { Objective::LeaveTrialOut } else { Objective::Marginal };
        self.objective.unwrap_or(own)
    }

    /// The rule of the pull for a person, or for a chain of another kind.
    pub fn pull_for(&self, is_person: bool) -> PullRule {
        let by_hand = is_person && self.sampling == Sampling::Pathwise;
        self.pull.unwrap_or(if by_hand { PullRule::PerMetre } else { PullRule::PerSecond })
    }

    /// Whether the hand's travel carries the noise on, and not time.
    pub fn goes_with_hand(&self, is_person: bool) -> bool {
        match self.pull_for(is_person) {
            PullRule::PerMetre => true,
            PullRule::PerSecond => false,
            PullRule::None => is_person && self.sampling == Sampling::Pathwise,
        }
    }

    /// # Errors
    /// Where a value is out of range.
    pub fn check(&self) -> Result<(), InputError> {
        let share = self.shrinkage.unwrap_or(0.3);
        if self.sampling == Sampling::Independent && self.pull == Some(PullRule::PerMetre) {
            let message = "the published sampler draws by time, and cannot pull per metre";
            return Err(InputError::new("train settings", message)
                .remedy("use the pull per second with it, or none"));
        }
        let positive = [
            ("attraction_length_m", self.attraction_length_m),
            ("attraction_rate_per_s", self.attraction_rate_per_s),
            ("attraction_length", self.attraction_length),
            ("attraction_noise", self.attraction_noise),
            ("diagonal_share", self.diagonal_share),
            ("attraction_postures", self.attraction_postures as f64),
            ("noise_ratio_floor", self.noise_ratio_floor),
            ("weight_prior_sd", self.weight_prior_sd),
            ("exact_samples", self.exact_samples as f64),
            ("search_samples", self.search_samples as f64),
            ("inducing", self.inducing.unwrap_or(1) as f64),
            ("null_floor_rad_s", self.null_floor_rad_s),
        ];
        let wrong = positive.iter().find(|(_, v)| !(v.is_finite() && *v > 0.0));
        if let Some((name, value)) = wrong {
            return Err(InputError::new("train settings", format!("{name} = {value}"))
                .remedy(format!("{name} must be a positive number")));
        }
        if !(0.0..=1.0).contains(&share) {
            return Err(InputError::new("train settings", format!("shrinkage = {share}"))
                .remedy("a share lies between 0 and 1"));
        }
        Ok(())
    }
}
