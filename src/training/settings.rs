//! Settings of the training, with the defaults that held-out recordings chose.

use crate::files::InputError;
use serde::{Deserialize, Serialize};

/// What can be chosen when a posture model is learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainSettings {
    /// Share a of the least-squares diagonal in full-w, 0 to 1; by default 0.3, or 0.5 for a single
    /// trial shorter than 4 s.
    pub shrinkage: Option<f64>,
    /// Part of the mean joint-velocity variance that is added to the diagonal of full-w.
    pub diagonal_share: f64,
    /// Whether the model pulls towards the person's own postures.
    pub has_attraction: bool,
    /// Rate of that pull, 1/s.
    pub attraction_rate_per_s: f64,
    /// Its length-scale in standard deviations of the hand's features. Mean path error over six
    /// folds of two people (time splits at 60 and 70 %, blocks): 3.70, 3.80, 3.69, 3.58 deg for 0.5,
    /// 1, 2, 3; over the blocks alone 2.22, 1.90, 1.64, 1.64 deg, and 2.41 without a pull.
    pub attraction_length: f64,
    /// Its noise variance over signal variance.
    pub attraction_noise: f64,
    /// Most training postures behind it.
    pub attraction_postures: usize,
    /// Most frames behind the process of mi-nsgp.
    pub gp_samples: usize,
}

impl Default for TrainSettings {
    fn default() -> Self {
        Self {
            shrinkage: None,
            diagonal_share: 1e-2,
            has_attraction: true,
            attraction_rate_per_s: 4.0,
            attraction_length: 2.0,
            attraction_noise: 0.05,
            attraction_postures: 120,
            gp_samples: 400,
        }
    }
}

impl TrainSettings {
    /// # Errors
    /// Where a value is out of range.
    pub fn check(&self) -> Result<(), InputError> {
        let share = self.shrinkage.unwrap_or(0.3);
        let positive = [
            ("attraction_rate_per_s", self.attraction_rate_per_s),
            ("attraction_length", self.attraction_length),
            ("attraction_noise", self.attraction_noise),
            ("diagonal_share", self.diagonal_share),
            ("attraction_postures", self.attraction_postures as f64),
            ("gp_samples", self.gp_samples as f64),
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
