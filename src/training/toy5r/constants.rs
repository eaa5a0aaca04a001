//! Constants of the 5R problem: what the paper gives, and what it leaves open.

use super::planar::JOINTS;
use crate::files::InputError;
use serde::{Deserialize, Serialize};

/// Constants of the 5R problem. The defaults ("set A") keep every figure of the paper that it prints
/// and fill in the rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ToyConstants {
    /// Lengths of the links, base first, m. Open: the paper only says "planar robot with 5 degrees of
    /// freedom".
    pub links: [f64; JOINTS],
    /// Time step, s. Open: a symbol in the paper.
    pub dt_s: f64,
    /// Largest task velocity of each component, m/s. Open: a symbol in the paper.
    pub u_max_m_s: f64,
    /// Standard deviation of the white noise in z, rad/s. Open: a symbol in the paper.
    pub sigma_z: f64,
    /// Standard deviation of the joint acceleration noise that moves the posture between samples,
    /// rad/s^2. Open: a symbol in the paper.
    pub sigma_a: f64,
    /// Standard deviation of the task velocity in predictive covariances, m/s. Not printed, but given
    /// away: a log-likelihood of 11.65 in two dimensions is that of an exact hit at 1.18e-3 m/s.
    pub sigma_xdot_m_s: f64,
    /// Gain from the negative gradient of the cost (per degree) to z (rad/s). Open: the paper writes
    /// the gradient without gain or sign; the literal sign runs away from the least cost.
    pub z_gain: f64,
    /// Number of samples. Given: 1000.
    pub samples: usize,
    /// Share of the samples that train. Given: 70 to 30.
    pub train_share: f64,
    /// How far the weights stay from 0 and 2. Open: a symbol in the paper.
    pub w_eps: f64,
    /// Smallest singular value of the Jacobian, m/rad, below which a posture is singular and the
    /// collection starts again at `q0`. Open: the paper says "a singular configuration". The reference
    /// data set (0.04, no restart) goes down to 0.115 m/rad; it cannot mean the ratio of the singular
    /// values, which falls to 0.039 there.
    pub singular_threshold: f64,
    /// Each angle of the start posture is drawn between zero and this, deg. Open: the paper says that
    /// the starting point varies.
    pub q0_range_deg: f64,
}

impl Default for ToyConstants {
    fn default() -> Self {
        Self {
            links: [0.4; JOINTS],
            dt_s: 0.2,
            u_max_m_s: 0.3,
            sigma_z: 0.045,
            sigma_a: 0.1,
            sigma_xdot_m_s: 1.18e-3,
            z_gain: 2.0,
            samples: 1000,
            train_share: 0.7,
            w_eps: 0.05,
            singular_threshold: 0.04,
            q0_range_deg: 60.0,
        }
    }
}

impl ToyConstants {
    /// Set A with a tenth of the noise in z and of the acceleration noise.
    pub fn low_noise() -> Self {
        let set_a = Self::default();
        Self { sigma_z: 0.1 * set_a.sigma_z, sigma_a: 0.1 * set_a.sigma_a, ..set_a }
    }

    /// Length of the stretched chain, m.
    pub fn reach_m(&self) -> f64 {
        self.links.iter().sum()
    }

    /// # Errors
    /// Where a value is out of range.
    pub fn check(&self) -> Result<(), InputError> {
        let wrong = |name: &str, value: f64, remedy: &str| {
            Err(InputError::new("5R constants", format!("{name} = {value}")).remedy(remedy))
        };
        let shortest = self.links.iter().copied().fold(f64::INFINITY, f64::min);
        let positive = [
            ("links", shortest),
            ("dt_s", self.dt_s),
            ("u_max_m_s", self.u_max_m_s),
            ("sigma_xdot_m_s", self.sigma_xdot_m_s),
            ("singular_threshold", self.singular_threshold),
            ("q0_range_deg", self.q0_range_deg),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return wrong(name, value, &format!("{name} must be positive"));
            }
        }
        let not_negative =
            [("sigma_z", self.sigma_z), ("sigma_a", self.sigma_a), ("z_gain", self.z_gain)];
        for (name, value) in not_negative {
            if !(value.is_finite() && value >= 0.0) {
                return wrong(name, value, &format!("{name} must not be negative"));
            }
        }
        if !self.reach_m().is_finite() {
            return wrong("links", self.reach_m(), "links must be finite lengths in m");
        }
        if self.q0_range_deg > 180.0 {
            return wrong("q0_range_deg", self.q0_range_deg, "half a turn is the most");
        }
        if !(self.w_eps > 0.0 && self.w_eps < 1.0) {
            return wrong("w_eps", self.w_eps, "weights are drawn from [w_eps, 2 - w_eps]");
        }
        if !(self.train_share > 0.0 && self.train_share < 1.0) {
            return wrong("train_share", self.train_share, "a share lies between 0 and 1");
        }
        if self.samples < 10 {
            return wrong("samples", self.samples as f64, "take ten samples at least");
        }
        if self.singular_threshold > 0.1 * self.reach_m() {
            let remedy = "a tenth of the chain's length at most, or every posture is singular";
            return wrong("singular_threshold", self.singular_threshold, remedy);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nonsense_is_refused_by_name() {
        let set_a = ToyConstants::default();
        assert!(set_a.check().is_ok() && ToyConstants::low_noise().check().is_ok());
        let refused = [
            ("links", ToyConstants { links: [0.4, 0.4, 0.0, 0.4, 0.4], ..set_a.clone() }),
            ("links", ToyConstants { links: [0.4, 0.4, f64::INFINITY, 0.4, 0.4], ..set_a.clone() }),
            ("dt_s", ToyConstants { dt_s: 0.0, ..set_a.clone() }),
            ("sigma_z", ToyConstants { sigma_z: f64::NAN, ..set_a.clone() }),
            ("w_eps", ToyConstants { w_eps: 1.0, ..set_a.clone() }),
            ("train_share", ToyConstants { train_share: 1.0, ..set_a.clone() }),
            ("samples", ToyConstants { samples: 0, ..set_a.clone() }),
            ("singular_threshold", ToyConstants { singular_threshold: 0.5, ..set_a.clone() }),
            ("q0_range_deg", ToyConstants { q0_range_deg: 400.0, ..set_a.clone() }),
        ];
        for (name, constants) in refused {
            let error = constants.check().unwrap_err().to_string();
            assert!(error.contains(name), "{name}: {error}");
        }
    }

    #[test]
    fn keys_are_known_or_refused() {
        let constants: ToyConstants = toml::from_str("dt_s = 0.04\n").unwrap();
        assert_eq!(constants, ToyConstants { dt_s: 0.04, ..ToyConstants::default() });
        assert!(toml::from_str::<ToyConstants>("dt = 0.04\n").is_err());
    }
}
