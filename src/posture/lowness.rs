//! How low a hand is: people differ more when they reach down than when they stand.

use serde::{Deserialize, Serialize};

/// From hands at a height and above (0) to hands at another and below (1), linear between; rest frame, over
/// stature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lowness {
    /// Height from which on it is 0.
    pub from: f64,
    /// Height at which it is 1; below the other.
    pub to: f64,
}

impl Lowness {
    /// Of a hand at a height (rest frame, over stature).
    pub fn of(&self, height: f64) -> f64 {
        ((self.from - height) / (self.from - self.to)).clamp(0.0, 1.0)
    }
}
