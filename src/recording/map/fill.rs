//! Gaps in the place of a marker: short ones are filled, long ones cut.

use crate::math::Vec3;

/// Frames on either side of a gap over which the speed there is taken.
const SPEED_OVER: usize = 3;

/// What was filled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Filled {
    pub gaps: usize,
    pub frames: usize,
    /// Frames of the longest of them.
    pub longest: usize,
}

impl Filled {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            gaps: self.gaps + other.gaps,
            frames: self.frames + other.frames,
            longest: self.longest.max(other.longest),
        }
    }
}

/// Fills gaps of at most `longest` frames between places that are known, by the cubic through both ends
/// with the speeds there.
pub(super) fn fill(track: &mut [Option<Vec3>], longest: usize) -> Filled {
    let mut filled = Filled::default();
    let known = track.to_vec();
    let mut before: Option<usize> = None;
    for (after, place) in known.iter().enumerate() {
        let Some(end) = place else { continue };
        if let Some((start, from)) = before.and_then(|b| Some((known[b]?, b))) {
            let missing = after - from - 1;
            if (1..=longest).contains(&missing) {
                let mean = (end - start) / (after - from) as f64;
                let speed = [
                    speed(&known, from, -1).unwrap_or(mean),
                    speed(&known, after, 1).unwrap_or(mean),
                ];
                for (i, gap) in track.iter_mut().enumerate().take(after).skip(from + 1) {
                    *gap = Some(between(
                        [start, *end],
                        speed,
                        (i - from) as f64,
                        (after - from) as f64,
                    ));
                }
                let own = Filled { gaps: 1, frames: missing, longest: missing };
                filled = filled.and(own);
            }
        }
        before = Some(after);
    }
    filled
}

/// Speed (m per frame) at the edge of a gap, from the known frames on the far side of it.
fn speed(known: &[Option<Vec3>], edge: usize, step: isize) -> Option<Vec3> {
    let at = |k: usize| {
        let i = edge.checked_add_signed(step * k.cast_signed())?;
        known.get(i).copied().flatten()
    };
    let here = known[edge]?;
    let reach = (1..=SPEED_OVER).take_while(|k| at(*k).is_some()).last()?;
    Some((at(reach)? - here) * (step as f64) / reach as f64)
}

/// The cubic at `t` frames after the start of `whole`.
fn between([start, end]: [Vec3; 2], [from, to]: [Vec3; 2], t: f64, whole: f64) -> Vec3 {
    let s = t / whole;
    let (s2, s3) = (s * s, s * s * s);
    start * (2.0 * s3 - 3.0 * s2 + 1.0)
        + end * (3.0 * s2 - 2.0 * s3)
        + from * (whole * (s3 - 2.0 * s2 + s))
        + to * (whole * (s3 - s2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn parabola(i: usize) -> Vec3 {
        let t = i as f64;
        Vec3::new(1.0 + 0.1 * t, -0.02 * t * t, 0.001 * t * t * t)
    }

    /// The same, by looking around each missing frame.
    fn naive(track: &[Option<Vec3>], longest: usize) -> Vec<Option<Vec3>> {
        let mut all = track.to_vec();
        for (i, place) in track.iter().enumerate() {
            if place.is_some() {
                continue;
            }
            let Some(a) = (0..i).rev().find(|j| track[*j].is_some()) else { continue };
            let Some(b) = (i..track.len()).find(|j| track[*j].is_some()) else { continue };
            if b - a - 1 > longest {
                continue;
            }
            let (p, q) = (track[a].unwrap(), track[b].unwrap());
            let mut back = 0;
            while back < 3 && a > back && track[a - back - 1].is_some() {
                back += 1;
            }
            let mut on = 0;
            while on < 3 && b + on + 1 < track.len() && track[b + on + 1].is_some() {
                on += 1;
            }
            let mean = (q - p) / (b - a) as f64;
            let u = if back > 0 { (p - track[a - back].unwrap()) / back as f64 } else { mean };
            let v = if on > 0 { (track[b + on].unwrap() - q) / on as f64 } else { mean };
            let w = (b - a) as f64;
            let s = (i - a) as f64 / w;
            // Of Bernstein's form.
            let (c, d) = (p + u * (w / 3.0), q - v * (w / 3.0));
            let r = 1.0 - s;
            let value =
                p * r.powi(3) + c * (3.0 * r * r * s) + d * (3.0 * r * s * s) + q * s.powi(3);
            all[i] = Some(value);
        }
        all
    }

    fn with_gaps(gaps: &[(usize, usize)]) -> Vec<Option<Vec3>> {
        let hidden = |i: usize| gaps.iter().any(|(a, n)| (*a..a + n).contains(&i));
        (0..60).map(|i| (!hidden(i)).then(|| parabola(i))).collect()
    }

    #[test]
    fn gaps_are_filled_as_a_naive_loop_does() {
        let gaps = [(0, 2), (5, 1), (7, 3), (20, 10), (31, 1), (34, 11), (50, 4), (58, 2)];
        let track = with_gaps(&gaps);
        let mut filled = track.clone();
        let count = fill(&mut filled, 10);
        assert_eq!(count, Filled { gaps: 5, frames: 19, longest: 10 });
        for (own, expected) in filled.iter().zip(naive(&track, 10)) {
            assert_eq!(own.is_some(), expected.is_some());
            if let (Some(own), Some(expected)) = (own, expected) {
                assert_relative_eq!(*own, expected, epsilon = 1e-12);
            }
        }
        // Neither the ends nor what is too long.
        assert!(filled[0].is_none() && filled[59].is_none() && filled[40].is_none());
    }

    #[test]
    fn a_steady_place_stays_and_a_smooth_path_is_met() {
        let mut still: Vec<Option<Vec3>> = vec![Some(Vec3::new(1.0, 2.0, 3.0)); 20];
        still[4..14].fill(None);
        fill(&mut still, 10);
        let off = |p: &Option<Vec3>| (p.unwrap() - Vec3::new(1.0, 2.0, 3.0)).norm();
        assert!(still.iter().all(|p| off(p) < 1e-12));
        let mut path = with_gaps(&[(20, 9)]);
        fill(&mut path, 10);
        let straight = 0.5 * (parabola(19) + parabola(29));
        let off = |p: Vec3| (p - parabola(24)).norm();
        assert!(off(path[24].unwrap()) < 0.35 * off(straight), "{:?}", path[24]);
    }
}
