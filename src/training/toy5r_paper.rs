//! The paper's own figures for the 5R problem, and how they must be read beside ours.
//!
//! Vianello et al., supplementary material, first table: ten repeats with random start and weights,
//! median [5th, 95th percentile]. Its columns cannot be compared with ours digit by digit:
//!
//! - **`LL_x`** is 11.65 for every method that meets the task. That is the density of an exact hit in two
//!   dimensions, -2 (ln sigma + ln(2 pi) / 2), at sigma = 1.18e-3 m/s: it says what task noise was
//!   assumed and nothing about the methods.
//! - **"R-MSE"** of the joint velocity behaves like a mean of squares, without the root: the joint
//!   velocities of such a problem are some tenths of rad/s, and 1.7e-3 (rad/s)^2 is (0.041 rad/s)^2,
//!   near our errors; 1.7e-3 rad/s would be far below any noise that lets the likelihoods be so low.
//!   The root of a quantile is the quantile of the root, so [`PaperRow::rmse_q_if_squared`] compares.
//! - **`LL_q`** near 8.9 is not the density of a calibrated prediction in five dimensions: 11.65 of it
//!   belong to the two task directions, and what is left for the other three, about -3, would need a
//!   spread of 0.7 rad/s in each, against errors of 0.04. Constants that the paper leaves open
//!   ([`open_constants`]) shift the column by a common amount besides.
//!
//! What can be compared is the order of the methods and the ratios between their errors.

use super::toy5r::ToyConstants;

/// Median, 5th and 95th percentile over ten repeats.
pub type Spread = [f64; 3];

/// One method of the paper's table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperRow {
    /// The method as the paper calls it.
    pub method: &'static str,
    /// Mean log-likelihood of the joint velocity, natural logarithm.
    pub ll_q: Spread,
    /// "R-MSE" of the joint velocity as printed.
    pub rmse_q: Spread,
    /// Mean log-likelihood of the task velocity, natural logarithm.
    pub ll_x: Spread,
    /// "R-MSE" of the task velocity as printed.
    pub rmse_x: Spread,
}

impl PaperRow {
    /// Root of the printed joint-velocity error, rad/s: the error if the column is a mean of squares.
    pub fn rmse_q_if_squared(&self) -> Spread {
        self.rmse_q.map(f64::sqrt)
    }
}

const EXACT_HIT: Spread = [11.65, 11.65, 11.65];

/// The table of the 5R problem, in the paper's order.
pub const PAPER_5R: [PaperRow; 6] = [
    PaperRow {
        method: "GP",
        ll_q: [4.39, 4.23, 4.45],
        rmse_q: [16.98e-3, 10.34e-3, 30.90e-3],
        ll_x: [2.43, 2.35, 2.45],
        rmse_x: [6.31e-2, 3.54e-2, 11.68e-2],
    },
    PaperRow {
        method: "W-IK",
        ll_q: [4.67, 4.28, 4.76],
        rmse_q: [4.33e-3, 2.46e-3, 8.13e-3],
        ll_x: EXACT_HIT,
        rmse_x: [3.57e-5, 1.47e-5, 4.25e-5],
    },
    PaperRow {
        method: "Sb-M",
        ll_q: [8.18, 8.00, 8.26],
        rmse_q: [11.30e-3, 8.69e-3, 15.10e-3],
        ll_x: EXACT_HIT,
        rmse_x: [2.96e-5, 1.73e-5, 3.22e-5],
    },
    PaperRow {
        method: "NsGP",
        ll_q: [8.72, 8.64, 8.77],
        rmse_q: [2.06e-3, 1.36e-3, 3.91e-3],
        ll_x: EXACT_HIT,
        rmse_x: [1.27e-5, 0.63e-5, 2.35e-5],
    },
    PaperRow {
        method: "ProMP",
        ll_q: [8.34, 6.70, 9.27],
        rmse_q: [13.69e-3, 8.07e-3, 25.29e-3],
        ll_x: [9.47, 9.27, 9.55],
        rmse_x: [3.76e-2, 2.84e-2, 4.58e-2],
    },
    PaperRow {
        method: "MI-NsGP",
        ll_q: [8.93, 8.83, 8.97],
        rmse_q: [1.69e-3, 1.26e-3, 2.80e-3],
        ll_x: EXACT_HIT,
        rmse_x: [2.41e-5, 1.05e-5, 3.81e-5],
    },
];

/// What the paper leaves open, and what set A chose.
pub fn open_constants() -> Vec<(&'static str, String)> {
    let c = ToyConstants::default();
    vec![
        ("lengths of the links", format!("{} m each", c.links[0])),
        ("time step", format!("{} s", c.dt_s)),
        ("largest task velocity u_max", format!("{} m/s per component", c.u_max_m_s)),
        ("noise in z", format!("{} rad/s", c.sigma_z)),
        ("acceleration noise", format!("{} rad/s^2", c.sigma_a)),
        ("task noise of predictions", format!("{:e} m/s, from LL_x = 11.65", c.sigma_xdot_m_s)),
        (
            "gain and sign of z",
            format!(
                "{} rad/s per unit of the cost's negative gradient per degree; the printed sign \
                 runs away from the least cost",
                c.z_gain
            ),
        ),
        (
            "bounds of the weights",
            format!("[{}, {}]; the paper prints [0 + eps, 2 - eps]", c.w_eps, 2.0 - c.w_eps),
        ),
        (
            "singular posture",
            format!("smallest singular value of J below {} m/rad", c.singular_threshold),
        ),
        ("start posture", format!("each angle uniform in [0, {}] deg", c.q0_range_deg)),
        ("smoothness of the null-space basis", "no basis: all joints, projected".to_owned()),
        (
            "segments for ProMP",
            "50 consecutive rows; 70 % of the segments train: not the same rows as the other \
             methods'"
                .to_owned(),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn percentiles_enclose_medians() {
        for row in PAPER_5R {
            for [median, low, high] in [row.ll_q, row.rmse_q, row.ll_x, row.rmse_x] {
                assert!(low <= median && median <= high, "{}", row.method);
            }
        }
    }

    #[test]
    fn the_exact_hit_gives_the_task_noise_away() {
        let sigma = ToyConstants::default().sigma_xdot_m_s;
        let hit = -2.0 * (sigma.ln() + 0.5 * std::f64::consts::TAU.ln());
        assert_relative_eq!(hit, EXACT_HIT[0], epsilon = 5e-3);
    }

    #[test]
    fn open_constants_are_those_of_set_a() {
        let open = open_constants();
        assert!(open.iter().any(|(what, chosen)| *what == "time step" && chosen == "0.2 s"));
        assert!(
            open.iter()
                .any(|(what, chosen)| what.contains("task noise")
                    && chosen.starts_with("1.18e-3 m/s"))
        );
    }
}
