//! The clamped cubic spline: the curve through given points with the least bending.
//!
//! ```text
//! y minimises  int_0^1 |y''(s)|^2 ds,   y(s_k) = y_k,   y'(0) = y'(1) = 0
//! ```
//! At the knots its slopes `m_k` solve the tridiagonal system of equal second derivatives on both
//! sides; between knots it is the cubic Hermite interpolant.

use crate::math::Vec3;

/// A spline over the parameter `s` in [0, 1], at rest at both ends.
#[derive(Debug, Clone, PartialEq)]
pub struct ClampedSpline {
    knots: Vec<f64>,
    points: Vec<Vec3>,
    slopes: Vec<Vec3>,
}

impl ClampedSpline {
    /// The spline through `points` at the strictly increasing `knots` from 0 to 1, as many of each
    /// and at least two; `None` for anything else.
    pub fn new(knots: Vec<f64>, points: Vec<Vec3>) -> Option<Self> {
        let is_increasing = knots.windows(2).all(|k| k[1] > k[0]);
        let spans = knots.first() == Some(&0.0) && knots.last() == Some(&1.0);
        if !is_increasing || !spans || knots.len() != points.len() || knots.len() < 2 {
            return None;
        }
        let slopes = slopes(&knots, &points);
        Some(Self { knots, points, slopes })
    }

    /// Position at `s`, clamped to [0, 1].
    pub fn position(&self, s: f64) -> Vec3 {
        let (i, h, u) = self.place(s);
        let (p0, p1) = (self.points[i], self.points[i + 1]);
        let (m0, m1) = (self.slopes[i] * h, self.slopes[i + 1] * h);
        let (u2, u3) = (u * u, u * u * u);
        p0 * (2.0 * u3 - 3.0 * u2 + 1.0)
            + m0 * (u3 - 2.0 * u2 + u)
            + p1 * (3.0 * u2 - 2.0 * u3)
            + m1 * (u3 - u2)
    }

    /// First derivative at `s`, clamped to [0, 1].
    pub fn slope(&self, s: f64) -> Vec3 {
        let (i, h, u) = self.place(s);
        let chord = (self.points[i + 1] - self.points[i]) / h;
        let (m0, m1) = (self.slopes[i], self.slopes[i + 1]);
        chord * (6.0 * u * (1.0 - u))
            + m0 * ((1.0 - u) * (1.0 - 3.0 * u))
            + m1 * (u * (3.0 * u - 2.0))
    }

    /// The same curve, `factor` times as large.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let of = |list: &[Vec3]| list.iter().map(|v| v * factor).collect();
        Self { knots: self.knots.clone(), points: of(&self.points), slopes: of(&self.slopes) }
    }

    /// Second derivative at `s`, clamped to [0, 1].
    pub fn second_derivative(&self, s: f64) -> Vec3 {
        let (i, h, u) = self.place(s);
        let ends = self.end_bending(i, h);
        ends[0].lerp(&ends[1], u)
    }

    /// `int y_a'' . y_b'' ds` of two splines over the same knots.
    pub fn bending(&self, other: &Self) -> f64 {
        (0..self.knots.len() - 1)
            .map(|i| {
                let h = self.knots[i + 1] - self.knots[i];
                let (a, b) = (self.end_bending(i, h), other.end_bending(i, h));
                // Both are linear on the segment.
                let mixed = a[0].dot(&b[1]) + a[1].dot(&b[0]);
                h / 3.0 * (a[0].dot(&b[0]) + a[1].dot(&b[1]) + mixed / 2.0)
            })
            .sum()
    }

    /// Segment, its width, and the place inside it in [0, 1].
    fn place(&self, s: f64) -> (usize, f64, f64) {
        let s = s.clamp(0.0, 1.0);
        let last = self.knots.len() - 1;
        let i = self.knots.partition_point(|k| *k <= s).clamp(1, last) - 1;
        let h = self.knots[i + 1] - self.knots[i];
        (i, h, (s - self.knots[i]) / h)
    }

    /// Second derivatives at the two ends of segment `i`.
    fn end_bending(&self, i: usize, h: f64) -> [Vec3; 2] {
        let chord = (self.points[i + 1] - self.points[i]) / h;
        let (m0, m1) = (self.slopes[i], self.slopes[i + 1]);
        [(chord * 6.0 - m0 * 4.0 - m1 * 2.0) / h, (m0 * 2.0 + m1 * 4.0 - chord * 6.0) / h]
    }
}

/// Slopes at the knots, zero at both ends, by elimination of the tridiagonal system.
fn slopes(knots: &[f64], points: &[Vec3]) -> Vec<Vec3> {
    let n = knots.len();
    let h = |i: usize| knots[i + 1] - knots[i];
    let mut slopes = vec![Vec3::zeros(); n];
    // Eliminated rows: slope_k = value_k - upper_k slope_(k+1).
    let (mut upper, mut value) = (vec![0.0; n], vec![Vec3::zeros(); n]);
    for k in 1..n - 1 {
        let (below, above) = (1.0 / h(k - 1), 1.0 / h(k));
        let chords = (points[k] - points[k - 1]) * (3.0 * below * below)
            + (points[k + 1] - points[k]) * (3.0 * above * above);
        let pivot = 2.0 * (below + above) - below * upper[k - 1];
        upper[k] = above / pivot;
        value[k] = (chords - value[k - 1] * below) / pivot;
    }
    for k in (1..n - 1).rev() {
        slopes[k] = value[k] - slopes[k + 1] * upper[k];
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn wavy() -> ClampedSpline {
        let points = [0.0, 0.4, -0.1, 1.0].map(|y| Vec3::new(y, 1.0 - y, y * y));
        ClampedSpline::new(vec![0.0, 0.2, 0.7, 1.0], points.to_vec()).unwrap()
    }

    #[test]
    fn passes_its_points_smoothly_and_rests_at_the_ends() {
        let spline = wavy();
        let e = 1e-6;
        for (k, point) in spline.knots.iter().zip(&spline.points) {
            assert_relative_eq!(spline.position(*k), *point, epsilon = 1e-12);
        }
        for end in [0.0, 1.0 - e] {
            let slope = (spline.position(end + e) - spline.position(end)) / e;
            assert!(slope.norm() < 1e-4, "{slope}");
        }
        for k in [0.2, 0.7] {
            let jump = spline.second_derivative(k + 1e-9) - spline.second_derivative(k - 1e-9);
            assert!(jump.norm() < 1e-5, "{jump}");
        }
        let s = 0.45;
        let slope = (spline.position(s + e) - spline.position(s - e)) / (2.0 * e);
        assert_relative_eq!(slope, spline.slope(s), epsilon = 1e-8);
        assert_relative_eq!(spline.scaled(0.3).position(s), spline.position(s) * 0.3);
        let numeric = (spline.position(s + 1e-4) - spline.position(s) * 2.0
            + spline.position(s - 1e-4))
            / 1e-8;
        assert_relative_eq!(numeric, spline.second_derivative(s), epsilon = 1e-5);
    }

    #[test]
    fn without_interior_points_it_is_the_cubic_ease() {
        let spline = ClampedSpline::new(vec![0.0, 1.0], vec![Vec3::zeros(), Vec3::x()]).unwrap();
        for s in [0.1, 0.5, 0.8] {
            assert_relative_eq!(spline.position(s).x, 3.0 * s * s - 2.0 * s * s * s);
        }
        assert_relative_eq!(spline.bending(&spline), 12.0, epsilon = 1e-12);
    }

    #[test]
    fn bends_less_than_any_other_curve_through_the_points() {
        // y + t w with w = 0 at the knots and w' = 0 at the ends: the cross term vanishes.
        let spline = wavy();
        let bump = |s: f64| s * s * (s - 0.2) * (s - 0.7) * (s - 1.0) * (1.0 - s);
        let steps = 20_000;
        let h = 1.0 / f64::from(steps);
        let cross: f64 = (1..steps)
            .map(|i| {
                let s = f64::from(i) * h;
                let w = (bump(s + h) - 2.0 * bump(s) + bump(s - h)) / (h * h);
                w * spline.second_derivative(s).x * h
            })
            .sum();
        assert!(cross.abs() < 1e-3, "{cross}");
        let own: f64 = (0..steps)
            .map(|i| spline.second_derivative((f64::from(i) + 0.5) * h).norm_squared() * h)
            .sum();
        assert_relative_eq!(own, spline.bending(&spline), max_relative = 1e-4);
    }

    #[test]
    fn malformed_knots_are_refused() {
        let points = vec![Vec3::zeros(); 3];
        for knots in [vec![0.0, 1.0], vec![0.0, 0.5, 0.9], vec![0.0, f64::NAN, 1.0]] {
            assert!(ClampedSpline::new(knots, points.clone()).is_none());
        }
        assert!(ClampedSpline::new(vec![0.0, 0.0, 1.0], points).is_none());
    }
}
