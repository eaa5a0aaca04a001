//! Distance between straight segments, and so between capsules.

use super::Vec3;

/// Squared length (m^2) below which a segment counts as a point.
const POINT: f64 = 1e-18;

/// Smallest distance (m) between the segments from `a[0]` to `a[1]` and from `b[0]` to `b[1]`.
///
/// Less the two radii this is the signed distance of two capsules; where their axes cross, minus the
/// sum of the radii.
pub fn segment_distance(a: [&Vec3; 2], b: [&Vec3; 2]) -> f64 {
    let (u, v, r) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (uu, vv, vr, ur) = (u.norm_squared(), v.norm_squared(), v.dot(&r), u.dot(&r));
    // The nearest point of the one segment to a point of the other.
    let on_a = |t: f64| if uu > POINT { ((t * u.dot(&v) - ur) / uu).clamp(0.0, 1.0) } else { 0.0 };
    let (s, t) = if vv <= POINT {
        (on_a(0.0), 0.0)
    } else {
        let uv = u.dot(&v);
        let across = uu * vv - uv * uv;
        // Nearly parallel, every pair of feet does: start from an end.
        let s = if across > 1e-12 * uu * vv {
            ((uv * vr - ur * vv) / across).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let t = (s * uv + vr) / vv;
        // Past an end of b: that end, and the nearest point of a to it.
        if t < 0.0 {
            (on_a(0.0), 0.0)
        } else if t > 1.0 {
            (on_a(1.0), 1.0)
        } else {
            (s, t)
        }
    };
    (r + u * s - v * t).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    /// The least over a grid of both segments.
    fn brute(a: [&Vec3; 2], b: [&Vec3; 2], n: u32) -> f64 {
        let at = |x: [&Vec3; 2], i: u32| x[0].lerp(x[1], f64::from(i) / f64::from(n));
        let pairs = (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j)));
        pairs.map(|(i, j)| (at(a, i) - at(b, j)).norm()).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn agrees_with_a_dense_grid() {
        let n = 160;
        for index in 0..300 {
            let r = normals(&mut stream(6, Purpose::Simulation, 0, index), 12);
            let point = |i: usize| Vec3::new(r[i], r[i + 1], r[i + 2]);
            let (p, q, x) = (point(0), point(3), point(6));
            // Some are points, parallel, on one line or touching.
            let (q, x, y) = match index % 6 {
                0 => (p, x, point(9)),
                1 => (q, x, x),
                2 => (q, x, x + (q - p) * 0.7),
                3 => (q, p.lerp(&q, 1.4), p.lerp(&q, 2.0)),
                4 => (q, p.lerp(&q, 0.3), point(9)),
                _ => (q, x, point(9)),
            };
            let own = segment_distance([&p, &q], [&x, &y]);
            let grid = brute([&p, &q], [&x, &y], n);
            let step = 0.5 * ((q - p).norm() + (y - x).norm()) / f64::from(n);
            assert!(own <= grid + 1e-9, "{index}: {own} above {grid}");
            assert!(grid - own <= step + 1e-9, "{index}: {own} below {grid} by more than a step");
            assert!((own - segment_distance([&y, &x], [&q, &p])).abs() < 1e-9, "{index}");
        }
    }

    #[test]
    fn known_cases() {
        let v = Vec3::new;
        let far = |a: [Vec3; 2], b: [Vec3; 2]| segment_distance([&a[0], &a[1]], [&b[0], &b[1]]);
        let x = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0)];
        // Across, parallel beside, parallel behind, crossing.
        assert!((far(x, [v(0.5, -1.0, 0.3), v(0.5, 1.0, 0.3)]) - 0.3).abs() < 1e-12);
        assert!((far(x, [v(0.2, 0.4, 0.0), v(5.0, 0.4, 0.0)]) - 0.4).abs() < 1e-12);
        assert!((far(x, [v(1.3, 0.4, 0.0), v(5.0, 0.4, 0.0)]) - 0.5).abs() < 1e-12);
        assert!(far(x, [v(0.5, -1.0, 0.0), v(0.5, 1.0, 0.0)]) < 1e-12);
    }
}
