//! Smooth scores of a posture and their gradients with respect to its joint angles.
//!
//! ```text
//! d score / d q_j = sum over body angles a of (d score / d a) (d a / d q_j)
//! ```
//! The first factor is that of the smooth score, the second the rate of the body angle where joint j
//! alone moves at 1 rad/s: its column of the Jacobian gives every segment's angular velocity and every
//! joint centre's velocity. The pelvis stands still.

use super::{ArmSegments, Lens, NeckRule, Sight, Surveyor, rotation, whole_posture};
use crate::ergonomics::{
    ArmRates, BodyRates, arm_angles, arm_rates, smooth_reba, smooth_rula, trunk_neck_angles,
    trunk_neck_rates,
};
use crate::human::{PosedSkeleton, Segment};
use crate::math::Vec3;
use nalgebra::{DVector, Matrix6xX, UnitQuaternion};

/// Smooth scores of the coupled arm's side, and their gradients.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoreGradient {
    /// Smooth RULA grand score, 1-7.
    pub rula: f64,
    /// Smooth REBA final score, 1-15.
    pub reba: f64,
    /// Derivatives of RULA with respect to the n joints of the coupled chain, 1/rad.
    pub rula_per_rad: DVector<f64>,
    /// Derivatives of REBA, 1/rad.
    pub reba_per_rad: DVector<f64>,
}

/// Jacobians (world axes) of the segments that the scores see.
struct Motion {
    l5: Matrix6xX<f64>,
    t8: Matrix6xX<f64>,
    neck: Matrix6xX<f64>,
    head: Matrix6xX<f64>,
    grip: Matrix6xX<f64>,
    girdle: Matrix6xX<f64>,
    upper: Matrix6xX<f64>,
    fore: Matrix6xX<f64>,
    hand: Matrix6xX<f64>,
}

impl Surveyor {
    /// Smooth scores of the posture `q` (n joints of the coupled chain, rad) and their gradients;
    /// steps of `width_deg` as in [`smooth_rula`].
    ///
    /// With [`NeckRule::Gaze`] the head turns with the hand, and that motion is part of the gradient;
    /// where the neck is at the end of its range it no longer follows, and the gradient jumps.
    pub fn smooth_scores(&self, q: &DVector<f64>, lens: &Lens, width_deg: f64) -> ScoreGradient {
        let parts = &self.upper;
        let posed = parts.skeleton.pose(&whole_posture(&parts.skeleton, self.side, q));
        let [coupled, _] = parts.arms;
        let (mut body, sight) = (self.body_pose(&posed), self.sight(&posed));
        if lens.neck == NeckRule::Gaze {
            body.head = sight.head();
        }
        let arm = super::arm_pose(&posed, &self.pelvis, coupled);
        let angles = (trunk_neck_angles(&body), arm_angles(&body, &arm));
        let (task, profile) = (&lens.task, &lens.profile);
        let rula = smooth_rula(&angles.0, &angles.1, task, profile, width_deg);
        let reba = smooth_reba(&angles.0, &angles.1, task, profile, width_deg);

        let motion = self.motion(&posed, coupled);
        let mut found = ScoreGradient {
            rula: rula.steps.grand,
            reba: reba.steps.total,
            rula_per_rad: DVector::zeros(q.len()),
            reba_per_rad: DVector::zeros(q.len()),
        };
        for j in 0..q.len() {
            let (mut body_rates, rates) = motion.rates(j);
            if lens.neck == NeckRule::Gaze {
                body_rates.head = sight.spin(&motion, j);
            }
            let trunk_neck = trunk_neck_rates(&body, &body_rates);
            let arm = arm_rates(&body, &arm, &body_rates, &rates);
            found.rula_per_rad[j] = rula.gradient.along(&trunk_neck, &arm);
            found.reba_per_rad[j] = reba.gradient.along(&trunk_neck, &arm);
        }
        found
    }

    fn motion(&self, posed: &PosedSkeleton, arm: ArmSegments) -> Motion {
        let turn = rotation(&self.pelvis);
        let of = |segment: Segment| {
            let mut jacobian = posed.jacobian(segment);
            for half in [0, 3] {
                let turned = turn.matrix() * jacobian.fixed_rows::<3>(half);
                jacobian.fixed_rows_mut::<3>(half).copy_from(&turned);
            }
            jacobian
        };
        let parts = &self.upper;
        Motion {
            l5: of(parts.l5),
            t8: of(parts.t8),
            neck: of(parts.neck),
            head: of(parts.head),
            grip: of(parts.grip),
            girdle: of(arm.girdle),
            upper: of(arm.upper),
            fore: of(arm.fore),
            hand: of(arm.hand),
        }
    }
}

/// Velocity of a segment's origin where joint j moves at 1 rad/s.
fn velocity(jacobian: &Matrix6xX<f64>, j: usize) -> Vec3 {
    jacobian.fixed_view::<3, 1>(0, j).into_owned()
}

/// Angular velocity of a segment where joint j moves at 1 rad/s.
fn spin(jacobian: &Matrix6xX<f64>, j: usize) -> Vec3 {
    jacobian.fixed_view::<3, 1>(3, j).into_owned()
}

impl Motion {
    /// What joint j moves at 1 rad/s, the head held to the trunk.
    fn rates(&self, j: usize) -> (BodyRates, ArmRates) {
        let body = BodyRates {
            pelvis: Vec3::zeros(),
            thorax: spin(&self.t8, j),
            head: spin(&self.t8, j),
            l5s1: velocity(&self.l5, j),
            c7t1: velocity(&self.neck, j),
        };
        let arm = ArmRates {
            upper_arm: spin(&self.upper, j),
            forearm: spin(&self.fore, j),
            hand: spin(&self.hand, j),
            shoulder: velocity(&self.upper, j),
            elbow: velocity(&self.fore, j),
            wrist: velocity(&self.hand, j),
            sternoclavicular: velocity(&self.girdle, j),
            // A number of the body.
            shoulder_lateral_m: 0.0,
        };
        (body, arm)
    }
}

impl Sight {
    /// Angular velocity of the head that follows the hand, where joint j moves at 1 rad/s.
    fn spin(&self, motion: &Motion, j: usize) -> Vec3 {
        let thorax_spin = self.thorax.inverse() * spin(&motion.t8, j);
        let approach = velocity(&motion.grip, j) - velocity(&motion.head, j);
        let (to, rate) = (self.to, self.thorax.inverse() * approach - thorax_spin.cross(&self.to));
        let (level, distance) = (to.x.hypot(to.z), to.norm());
        if level < 1e-9 {
            return spin(&motion.t8, j); // the hand straight above or below: no azimuth
        }
        let (turn, nod) = self.held();
        let turning =
            if turn == self.turn { (to.z * rate.x - to.x * rate.z) / (level * level) } else { 0.0 };
        let nodding = if nod == self.nod {
            let away = (to.x * rate.x + to.z * rate.z) / level;
            (level * rate.y - to.y * away) / (distance * distance)
        } else {
            0.0
        };
        let nod_axis = UnitQuaternion::from_scaled_axis(Vec3::y() * turn) * Vec3::z();
        self.thorax * (thorax_spin + Vec3::y() * turning + nod_axis * nodding)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ergonomics::{Profile, TaskInputs};
    use crate::human::{Body, Side, Stance};
    use crate::math::stream::{Purpose, stream};
    use rand::RngExt as _;

    fn surveyor(side: Side) -> (Surveyor, Vec<(f64, f64)>) {
        let body = Body::load("male_p50", std::path::Path::new(".")).unwrap();
        let stance = Stance::Standing { shoe_m: 0.03 };
        let pelvis = body.pelvis_pose([0.4, -0.3], 0.7, stance);
        let joints = body.arm(side).unwrap();
        let range = joints.joints().iter().map(|j| (j.lower, j.upper)).collect();
        (Surveyor::new(&body, side, pelvis, stance).unwrap(), range)
    }

    /// RULA and REBA by the surveyor's own angles, each with the scores at which its tables are entered.
    fn scores(
        surveyor: &Surveyor,
        q: &DVector<f64>,
        lens: &Lens,
        width: f64,
    ) -> [(f64, Vec<f64>); 2] {
        let angles = surveyor.measure(q);
        let body = angles.trunk_neck(lens.neck);
        let (task, profile) = (&lens.task, &lens.profile);
        let r = smooth_rula(body, &angles.arm, task, profile, width).steps;
        let e = smooth_reba(body, &angles.arm, task, profile, width).steps;
        let entered = vec![
            r.upper_arm,
            r.lower_arm,
            r.wrist,
            r.wrist_twist,
            r.neck,
            r.trunk,
            r.score_c,
            r.score_d,
        ];
        let (body, arm) = ([e.neck, e.trunk, e.legs], [e.upper_arm, e.lower_arm, e.wrist]);
        [(r.grand, entered), (e.total, [&body[..], &arm, &[e.score_a, e.score_b]].concat())]
    }

    /// Whether a score passes a whole number between two postures: there its gradient jumps.
    fn jumps(before: &[f64], after: &[f64]) -> bool {
        let passes = |(a, b): (&f64, &f64)| a.floor() != b.floor() && (a - b).abs() > 1e-12;
        before.iter().zip(after).any(passes)
    }

    /// Largest relative error of the gradients over random postures, and how many numbers were
    /// compared, were not 0, and were left out as the gradient jumps.
    fn worst(side: Side, neck: NeckRule, width: f64) -> (f64, [usize; 3]) {
        let (surveyor, range) = surveyor(side);
        let mut rng = stream(7, Purpose::Simulation, 900, 0);
        let (mut worst, mut counts) = (0.0f64, [0; 3]);
        for k in 0..60 {
            let task = TaskInputs { load_kg: 6.0, sitting: k % 2 == 0, ..TaskInputs::default() };
            let task = TaskInputs { trunk_supported: true, coupling: (k % 4) as u8, ..task };
            let profile = Profile::by_name(Profile::names()[k % 4]).unwrap();
            let lens = Lens { task, neck, profile };
            let inner =
                range.iter().map(|(low, high)| low + (high - low) * rng.random_range(0.05..0.95));
            let q = DVector::from_iterator(range.len(), inner);
            let found = surveyor.smooth_scores(&q, &lens, width);
            let here = scores(&surveyor, &q, &lens, width);
            assert_eq!([found.rula, found.reba], [here[0].0, here[1].0]);
            for j in 0..q.len() {
                let h = 1e-5;
                let around = [-2.0, -1.0, 1.0, 2.0].map(|k| {
                    let mut q = q.clone();
                    q[j] += k * h;
                    scores(&surveyor, &q, &lens, width)
                });
                for (s, ours) in
                    [found.rula_per_rad[j], found.reba_per_rad[j]].into_iter().enumerate()
                {
                    let [a, b, c, d] = [0, 1, 2, 3].map(|k| around[k][s].0);
                    // Central difference of fourth order.
                    let slope = (8.0 * (c - b) - (d - a)) / (12.0 * h);
                    counts[0] += 1;
                    counts[1] += usize::from(slope.abs() > 1e-3);
                    if jumps(&around[0][s].1, &around[3][s].1) {
                        counts[2] += 1;
                    } else {
                        worst = worst.max((ours - slope).abs() / ours.abs().max(1.0));
                    }
                }
            }
        }
        (worst, counts)
    }

    #[test]
    #[allow(clippy::print_stderr, reason = "shows the measured errors")]
    fn gradients_by_joint_angles_are_the_slopes() {
        for side in [Side::Right, Side::Left] {
            for neck in [NeckRule::Neutral, NeckRule::Gaze] {
                for width in [1.0, 5.0, 20.0] {
                    let (error, [all, nonzero, jumps]) = worst(side, neck, width);
                    eprintln!(
                        "{side:?} {neck:?} width {width}: error {error:.1e}, {nonzero} of {all} slopes not 0, \
                         {jumps} left out"
                    );
                    assert!(error < 1e-6, "{side:?} {neck:?} {width}: {error}");
                    assert!(jumps * 200 <= all, "{jumps} of {all}");
                    assert!(nonzero * 20 > all, "{nonzero} of {all}");
                }
            }
        }
    }
}
