//! How low a hand is: people differ more when they reach down than when they stand.

use serde::{Deserialize, Serialize};

/// From hands at a height and above (0) to hands at another and below (1); rest frame, over stature. In between the
/// share `l` of the way counts as
///
/// ```text
/// (r^l - 1) / (r - 1)        l where r = 1
/// ```
/// so that a variance which is `r` times as large below grows by the same factor with every centimetre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lowness {
    /// Height from which on it is 0.
    pub from: f64,
    /// Height at which it is 1; below the other.
    pub to: f64,
    /// r, at least 1.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub ratio: f64,
}

fn one() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}

impl Lowness {
    /// Linear from one height to the other.
    pub fn linear(from: f64, to: f64) -> Self {
        Self { from, to, ratio: 1.0 }
    }

    /// Of a hand at a height (rest frame, over stature).
    pub fn of(&self, height: f64) -> f64 {
        let way = ((self.from - height) / (self.from - self.to)).clamp(0.0, 1.0);
        if is_one(&self.ratio) { way } else { (self.ratio.powf(way) - 1.0) / (self.ratio - 1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variance_grows_by_one_factor_everywhere() {
        let lowness = Lowness { ratio: 16.0, ..Lowness::linear(0.1, -0.3) };
        let variance = |height: f64| 2.0 * (1.0 - lowness.of(height)) + 32.0 * lowness.of(height);
        for (height, expected) in [
            (0.2, 2.0),
            (0.1, 2.0),
            (0.0, 4.0),
            (-0.1, 8.0),
            (-0.2, 16.0),
            (-0.3, 32.0),
            (-0.5, 32.0),
        ] {
            assert!((variance(height) - expected).abs() < 1e-12, "{height}");
        }
        assert!((Lowness::linear(0.1, -0.3).of(0.0) - 0.25).abs() < 1e-15);
    }
}
