//! How far joint centres are from those of the fitted body.

use crate::files::InputError;
use crate::human::{Body, Coupled, Head, Pelvis, Segment, Side, Skeleton, Stance};
use crate::math::Vec3;
use nalgebra::DVector;

/// The joint centres of the side that leads, in order.
pub const CENTRES: [&str; 4] = ["shoulder", "elbow", "hip", "knee"];
/// The segments that begin at them.
const SEGMENTS: [&str; CENTRES.len()] = ["UpperArm", "ForeArm", "UpperLeg", "LowerLeg"];

/// Tells where they are.
pub(super) struct Centres {
    skeleton: Skeleton,
    segments: [Segment; CENTRES.len()],
}

impl Centres {
    pub(super) fn new(body: &Body, side: Side) -> Result<Self, InputError> {
        let coupled = Coupled { hands: side.into(), pelvis: Pelvis::Moves };
        let skeleton = Skeleton::new(body, coupled, Stance::Standing { shoe_m: 0.0 }, true)?;
        let of = |part: &str| skeleton.segment(&format!("{}{part}", side.prefix()));
        let [shoulder, elbow, hip, knee] = SEGMENTS.map(of);
        let segments = [shoulder?, elbow?, hip?, knee?];
        Ok(Self { skeleton, segments })
    }

    /// Seen from between the feet, m.
    fn at(&self, q: &DVector<f64>) -> [Vec3; CENTRES.len()] {
        let posed = self.skeleton.pose(&self.skeleton.whole(q.as_slice(), Head::default()));
        self.segments.map(|s| posed.at(s).translation.vector)
    }

    /// Rms distance over pairs of postures (pelvis and joints), cm.
    pub(super) fn rms_cm<'a>(
        &self,
        pairs: impl Iterator<Item = (&'a DVector<f64>, &'a DVector<f64>)>,
    ) -> [f64; CENTRES.len()] {
        let (mut sum, mut count) = ([0.0; CENTRES.len()], 0.0);
        for (a, b) in pairs {
            let (a, b) = (self.at(a), self.at(b));
            for (s, (a, b)) in sum.iter_mut().zip(a.iter().zip(&b)) {
                *s += (a - b).norm_squared();
            }
            count += 1.0;
        }
        sum.map(|s| 100.0 * (s / f64::max(count, 1.0)).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn what_moves_is_what_lies_beyond_the_joint() {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        let centres = Centres::new(&body, Side::Right).unwrap();
        let still = DVector::zeros(30);
        let moved = |column: usize, by: f64| {
            let mut q = still.clone();
            q[column] = by;
            centres.rms_cm([(&q, &still), (&still, &still)].into_iter())
        };
        // The pelvis by a tenth of a leg takes the hip along, and the feet stay: half of the frames, so root half.
        let [shoulder, _, hip, knee] = moved(0, 0.1);
        let way_cm = 10.0 * body.leg_m() / 2f64.sqrt();
        assert!((hip - way_cm).abs() < 1e-9 && (shoulder - way_cm).abs() < 1e-9, "{hip}");
        assert!(knee > 0.0 && knee < hip);
        // The shoulder joint moves the elbow only.
        let arm = body.arm(Side::Right).unwrap();
        let joint = arm.joints().iter().position(|j| j.name == "jRightShoulder_Z").unwrap();
        let [shoulder, elbow, hip, knee] = moved(6 + joint, 0.5);
        assert!(elbow > 5.0 && [shoulder, hip, knee].iter().all(|d| *d < 1e-9));
    }
}
