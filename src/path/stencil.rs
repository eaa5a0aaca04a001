//! A path of piecewise constant jerk is a uniform cubic spline: every state of it is a combination of
//! a few neighbouring spline coefficients.
//!
//! ```text
//! T steps, coefficients c_0 .. c_{T+2};  step k rests on c_k .. c_{k+3};  dt one step
//! p_k = (c_k + 4 c_{k+1} + c_{k+2}) / 6      v_k dt = (c_{k+2} - c_k) / 2
//! a_k dt^2 = c_k - 2 c_{k+1} + c_{k+2}       j_k dt^3 = -c_k + 3 c_{k+1} - 3 c_{k+2} + c_{k+3}
//! ```
//! At rest at both ends the first three coefficients are the start and the last three the goal.
//! Inside a step the position lies in the hull of four Bezier points, the velocity in that of three.

use crate::math::Vec3;

/// Weights on consecutive coefficients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stencil {
    /// The first coefficient.
    pub(super) first: usize,
    /// Weights from it on; unused ones are zero.
    pub(super) weights: [f64; 4],
}

const fn stencil(first: usize, weights: [f64; 4]) -> Stencil {
    Stencil { first, weights }
}

/// Position at knot `k`.
pub(super) fn position(k: usize) -> Stencil {
    stencil(k, [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0, 0.0])
}

/// The four Bezier points of the position in step `k`. The knots are the means of the inner points
/// on either side.
pub(super) fn position_hull(k: usize) -> [Stencil; 4] {
    let [inner_a, inner_b] = position_inner(k);
    [position(k), inner_a, inner_b, position(k + 1)]
}

/// The two inner Bezier points of the position in step `k`.
pub(super) fn position_inner(k: usize) -> [Stencil; 2] {
    let (near, far) = (2.0 / 3.0, 1.0 / 3.0);
    [stencil(k + 1, [near, far, 0.0, 0.0]), stencil(k + 1, [far, near, 0.0, 0.0])]
}

/// Velocity times dt at knot `k`.
pub(super) fn velocity(k: usize) -> Stencil {
    stencil(k, [-0.5, 0.0, 0.5, 0.0])
}

/// The middle Bezier point of the velocity (times dt) in step `k`. The knots are the means of the
/// middle points on either side, so that a convex bound on these holds everywhere.
pub(super) fn velocity_middle(k: usize) -> Stencil {
    stencil(k + 1, [-1.0, 1.0, 0.0, 0.0])
}

/// Acceleration times dt^2 at knot `k`.
pub(super) fn acceleration(k: usize) -> Stencil {
    stencil(k, [1.0, -2.0, 1.0, 0.0])
}

/// Jerk times dt^3 in step `k`.
pub(super) fn jerk(k: usize) -> Stencil {
    stencil(k, [-1.0, 3.0, -3.0, 1.0])
}

impl Stencil {
    /// The combination of given coefficients.
    pub(super) fn of(&self, coefficients: &[Vec3]) -> Vec3 {
        let used = self.weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
        used.map(|(i, w)| coefficients[self.first + i] * *w).sum()
    }
}
