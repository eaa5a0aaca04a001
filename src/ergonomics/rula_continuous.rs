//! RULA continuous: the ergonomic cost of the paper's toy problem, a sum of polynomials.
//!
//! ```text
//! C(q) = sum over j of p2_j q_j^2 + p1_j q_j + p3_j         q in deg
//! ```
//! Vianello, Mouret, Dalin, Aubry, Ivaldi, "Human posture prediction during physical human-robot
//! interaction", supplementary Table 1: second-order fits to RULA's step scores, one joint each, after
//! Busch et al. (IROS 2017).
//!
//! **Not comparable with RULA's 1-7.** It is a sum of step scores that never goes through RULA's tables,
//! has no upper end, and holds for moderate angles only: at 90 deg the second joint counts 8.9, where
//! RULA's upper arm has 4.

/// Joints of the toy problem.
pub const CONTINUOUS_JOINTS: usize = 5;

/// `[p2, p1, p3]` of each joint (supplementary Table 1), per deg^2, per deg, and 1.
///
/// The table does not name the joints. By their shape they read as trunk, upper arm, elbow (lowest
/// near 78 deg), a rotation, and wrist; that reading is this project's.
pub const RULA_CONTINUOUS: [[f64; 3]; CONTINUOUS_JOINTS] = [
    [1.1e-3, 0.0, 0.0],
    [9.8e-4, 0.0, 1.0],
    [1.6e-4, -2.5e-2, 2.0],
    [1.2e-4, 0.0, 0.0],
    [2.1e-3, 0.0, 1.0],
];

/// RULA continuous of five joint angles (deg), and its gradient, per deg. A sum, not a score of 1-7.
///
/// # Examples
/// ```
/// use ergopath::ergonomics::rula_continuous;
/// let (sum, gradient) = rula_continuous(&[0.0; 5]);
/// assert_eq!(sum, 4.0);
/// // Only the elbow gains from leaving zero.
/// assert_eq!(gradient, [0.0, 0.0, -2.5e-2, 0.0, 0.0]);
/// ```
pub fn rula_continuous(q_deg: &[f64; CONTINUOUS_JOINTS]) -> (f64, [f64; CONTINUOUS_JOINTS]) {
    let of = |j: usize| (RULA_CONTINUOUS[j], q_deg[j]);
    let sum = (0..CONTINUOUS_JOINTS).map(|j| {
        let ([p2, p1, p3], q) = of(j);
        (p2 * q + p1) * q + p3
    });
    let slope = |j: usize| {
        let ([p2, p1, _], q) = of(j);
        2.0 * p2 * q + p1
    };
    (sum.sum(), std::array::from_fn(slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_joint_adds_its_polynomial() {
        // Worked by hand from the table, at 30 deg for one joint at a time.
        for (j, rise) in [0.99, 0.882, 0.144 - 0.75, 0.108, 1.89].into_iter().enumerate() {
            let mut q = [0.0; 5];
            q[j] = 30.0;
            assert!((rula_continuous(&q).0 - 4.0 - rise).abs() < 1e-12, "{j}");
        }
    }

    #[test]
    fn the_gradient_is_the_slope() {
        let q = [12.0, -40.0, 95.0, -170.0, 33.0];
        let (_, gradient) = rula_continuous(&q);
        for j in 0..5 {
            let at = |by: f64| {
                let mut moved = q;
                moved[j] += by;
                rula_continuous(&moved).0
            };
            // Central differences of a parabola are exact but for rounding.
            assert!(((at(0.5) - at(-0.5)) - gradient[j]).abs() < 1e-12, "{j}");
        }
    }

    #[test]
    fn the_elbow_is_best_near_78_deg() {
        let [p2, p1, p3] = RULA_CONTINUOUS[2];
        let best = -p1 / (2.0 * p2);
        assert!((best - 78.125).abs() < 1e-9);
        assert!(((p2 * best + p1) * best + p3 - 1.023_437_5).abs() < 1e-12);
    }
}
