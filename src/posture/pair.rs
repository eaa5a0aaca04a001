//! Two hands from the law of one: the other arm moves as the mirror image does.
//!
//! ```text
//! trunk    t = pelvis and spine: what the law of the right and the mirrored law of the left say, averaged
//! arms     a_r | t  as learned,   a_l | t  its mirror image,   independent of each other given t
//! ```
//! so that the covariance of all is that of `(t, B t + e_r, B' t + e_l)`. People who lift with both hands
//! were not needed; where they are recorded, a model of both hands takes its place.

use super::attraction::UsualPosture;
use super::model::{LowPostures, PostureDistribution};
use crate::human::mirror_sign;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// How the columns of one hand's chain make those of both: `trunk` of them first, then the arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    trunk: usize,
    /// Sign of each column in the mirror image, n of one hand.
    signs: Vec<f64>,
}

impl Pair {
    /// For the chain of one hand.
    pub fn new(joints: &[String]) -> Self {
        let is_arm = |j: &&String| j.contains("Right") || j.contains("Left");
        let trunk = joints.iter().take_while(|j| !is_arm(j)).count();
        Self { trunk, signs: joints.iter().map(|j| mirror_sign(j)).collect() }
    }

    /// Joints of both hands' chain: the second arm after the first.
    pub fn joints(&self, joints: &[String]) -> Vec<String> {
        let other = joints[self.trunk..].iter().map(|j| crate::human::other_side_joint(j));
        joints.iter().cloned().chain(other).collect()
    }

    fn mirrored(&self, v: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(v.len(), v.iter().zip(&self.signs).map(|(v, s)| v * s))
    }

    /// A posture of both from one of each, the second in the mirror image.
    fn joined(&self, first: &DVector<f64>, second: &DVector<f64>) -> DVector<f64> {
        let (t, n) = (self.trunk, first.len());
        let other = self.mirrored(second);
        let mut both = DVector::zeros(2 * n - t);
        both.rows_mut(0, t).copy_from(&((first.rows(0, t) + other.rows(0, t)) * 0.5));
        both.rows_mut(t, n - t).copy_from(&first.rows(t, n - t));
        both.rows_mut(n, n - t).copy_from(&other.rows(t, n - t));
        both
    }

    /// Sizes of both from those of one: without signs.
    pub(super) fn sizes(&self, one: &DVector<f64>) -> DVector<f64> {
        let (t, n) = (self.trunk, one.len());
        DVector::from_fn(2 * n - t, |i, _| one[if i < n { i } else { t + i - n }])
    }

    /// The usual posture of both hands from that of each, the second in the mirror image.
    pub(super) fn together(&self, first: &UsualPosture, second: &UsualPosture) -> UsualPosture {
        UsualPosture {
            posture: self.joined(&first.posture, &second.posture),
            confidence: first.confidence.min(second.confidence),
            growth: first.growth.zip(second.growth).map(|(a, b)| a.max(b)),
        }
    }

    /// A covariance of both from that of one, n x n; `None` where it is not positive definite.
    pub fn covariance(&self, one: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (t, n) = (self.trunk, one.nrows());
        let a = n - t;
        let signs = DMatrix::from_diagonal(&DVector::from_vec(self.signs.clone()));
        let mirror = &signs * one * &signs;
        let average = (one + &mirror) * 0.5;
        let trunk = average.view((0, 0), (t, t)).into_owned();
        let mut both = DMatrix::zeros(n + a, n + a);
        both.view_mut((0, 0), (t, t)).copy_from(&trunk);
        // a = B t + e, of the recorded side and of its mirror image.
        let mut slopes = Vec::new();
        for (i, own) in [one, &mirror].into_iter().enumerate() {
            let factor = own.view((0, 0), (t, t)).into_owned().cholesky()?;
            let across = own.view((0, t), (t, a)).into_owned();
            let slope = factor.solve(&across).transpose();
            let rest = own.view((t, t), (a, a)) - &slope * across;
            let from = t + i * a;
            let own = &slope * &trunk * slope.transpose() + rest;
            both.view_mut((from, from), (a, a)).copy_from(&((&own + own.transpose()) * 0.5));
            let cross = &trunk * slope.transpose();
            both.view_mut((0, from), (t, a)).copy_from(&cross);
            both.view_mut((from, 0), (a, t)).copy_from(&cross.transpose());
            slopes.push(slope);
        }
        let arms = &slopes[0] * &trunk * slopes[1].transpose();
        both.view_mut((t, n), (a, a)).copy_from(&arms);
        both.view_mut((n, t), (a, a)).copy_from(&arms.transpose());
        Some(both)
    }

    /// The postures of both from those of one.
    pub fn postures(&self, one: &PostureDistribution) -> Option<PostureDistribution> {
        // In the mirror image the second hand is where the first is.
        let mean = self.joined(&one.mean, &one.mean);
        let about_usual = match &one.about_usual {
            Some(about) => Some(self.covariance(about)?),
            None => None,
        };
        let low = match &one.low {
            Some(low) => Some(LowPostures {
                lowness: low.lowness,
                about_usual: self.covariance(&low.about_usual)?,
            }),
            None => None,
        };
        let covariance = self.covariance(&one.covariance)?;
        Some(PostureDistribution { mean, covariance, about_usual, low, population: one.population })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, normals, stream};

    fn joints() -> Vec<String> {
        ["pelvis_up", "jL5S1_Z", "jL5S1_X", "jRightShoulder_Z", "jRightShoulder_X"]
            .map(str::to_owned)
            .to_vec()
    }

    #[test]
    fn both_sides_are_mirror_images_and_keep_what_one_says() {
        let pair = Pair::new(&joints());
        assert_eq!(pair.joints(&joints())[5..], ["jLeftShoulder_Z", "jLeftShoulder_X"]);
        let a = DMatrix::from_vec(5, 5, normals(&mut stream(3, Purpose::Simulation, 0, 0), 25));
        let one = &a * a.transpose() + DMatrix::identity(5, 5) * 0.1;
        let both = pair.covariance(&one).unwrap();
        assert!(both.clone().cholesky().is_some());
        // The mirror image of both is both with the arms exchanged.
        let place = [0, 1, 2, 5, 6, 3, 4];
        let sign = [1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        for i in 0..7 {
            for j in 0..7 {
                let there = both[(place[i], place[j])] * sign[i] * sign[j];
                assert!((both[(i, j)] - there).abs() < 1e-12, "{i} {j}");
            }
        }
        // Given the trunk, the arm is as learned.
        let given = |m: &DMatrix<f64>| {
            let f = m.view((0, 0), (3, 3)).into_owned().cholesky().unwrap();
            let across = m.view((0, 3), (3, 2)).into_owned();
            m.view((3, 3), (2, 2)) - across.tr_mul(&f.solve(&across))
        };
        assert!((given(&one) - given(&both)).amax() < 1e-12);
    }
}
