//! How far from the shoulder a hand can be at all.
//!
//! The shoulder moves with trunk and girdle, so that arm length alone would cut off places that people
//! do reach. The ball here is about the shoulder of the upright posture and holds every grip position
//! within the single joints' ranges (bounds on sums of joints only take away from that): its radius is
//! the largest distance that coordinate ascent finds from several postures, and 2 % more, because
//! ascent may stop short. Places in the ball can still be out of reach; places outside cannot be in.
//!
//! For one revolute joint the grip moves on a circle `c + r cos q + t sin q`, so that its distance from
//! a point is largest where the sine and cosine say, or at the nearer end of the joint's range.

use super::body::Body;
use super::side::{Coupled, Pelvis, Side};
use crate::files::InputError;
use crate::kinematics::{Frames, Linkage};
use crate::math::Vec3;

/// Sweeps over all joints.
const SWEEPS: usize = 60;
/// Change of the distance (m) below which a sweep was the last.
const SETTLED_M: f64 = 1e-5;
/// What is added because ascent may stop short.
const MARGIN: f64 = 1.02;

/// Middle (rest frame, m) and radius (m) of a ball that holds every position of the grip, the pelvis at
/// rest or anywhere within its coordinates' ranges.
///
/// # Errors
/// Never for a body that loaded.
pub fn reach_ball(body: &Body, side: Side, pelvis: Pelvis) -> Result<(Vec3, f64), InputError> {
    let shoulder = format!("{}UpperArm", side.prefix());
    let coupled = Coupled { hands: side.into(), pelvis };
    let arm = body.chain(coupled, &[&shoulder])?;
    let mut frames = Frames::default();
    arm.forward(&vec![0.0; arm.dof()], &mut frames);
    let (center, _) = arm.tip_frame(&frames, 1);
    let range = |share: f64| -> Vec<f64> {
        let joints = arm.joints().iter();
        joints.map(|j| j.lower + share * (j.upper - j.lower)).collect()
    };
    let starts = [0.05, 0.3, 0.5, 0.7, 0.95].map(range);
    let upright = vec![0.0; arm.dof()];
    let farthest = starts.into_iter().chain([upright]).map(|q| sweep(&arm, &center, q, true));
    Ok((center, MARGIN * farthest.fold(0.0, f64::max)))
}

/// How far a point (rest frame, m) is from the nearest place to which any posture brings the grip,
/// however the hand is turned, m; about zero when it can be reached. Bounds on sums of joints are left
/// out, so that it is never too large but for the descent stopping short.
///
/// # Errors
/// Never for a body that loaded.
pub fn reach_gap(body: &Body, side: Side, pelvis: Pelvis, point: &Vec3) -> Result<f64, InputError> {
    let arm = body.chain(Coupled { hands: side.into(), pelvis }, &[])?;
    let range = |share: f64| -> Vec<f64> {
        let joints = arm.joints().iter();
        joints.map(|j| j.lower + share * (j.upper - j.lower)).collect()
    };
    let starts = [0.3, 0.5, 0.7].map(range).into_iter().chain([vec![0.0; arm.dof()]]);
    Ok(starts.map(|q| sweep(&arm, point, q, false)).fold(f64::INFINITY, f64::min))
}

/// The largest (or the smallest) distance of the grip from `center` that turning one joint after the
/// other to its best finds.
fn sweep(arm: &Linkage, center: &Vec3, mut q: Vec<f64>, is_away: bool) -> f64 {
    let mut frames = Frames::default();
    let mut distance = if is_away { 0.0 } else { f64::INFINITY };
    let sign = if is_away { -1.0 } else { 1.0 };
    for _ in 0..SWEEPS {
        let before: f64 = distance;
        for i in 0..q.len() {
            arm.forward(&q, &mut frames);
            let (grip, _) = arm.tip_frame(&frames, 0);
            let jacobian = arm.jacobian(&frames, 0);
            let tangent: Vec3 = jacobian.fixed_view::<3, 1>(0, i).into();
            let axis: Vec3 = jacobian.fixed_view::<3, 1>(3, i).into();
            let joint = &arm.joints()[i];
            if joint.is_prismatic {
                let along = (center - grip).dot(&tangent) / tangent.norm_squared();
                let far = if along > 0.0 { joint.lower } else { joint.upper };
                q[i] = if is_away { far } else { (q[i] + along).clamp(joint.lower, joint.upper) };
                continue;
            }
            // From the axis to the grip, and from the middle of the circle to the center.
            let radial = tangent.cross(&axis);
            let to = center - (grip - radial);
            let turn = (sign * tangent.dot(&to)).atan2(sign * radial.dot(&to));
            q[i] = best_in_range(q[i] + turn, joint.lower, joint.upper);
        }
        arm.forward(&q, &mut frames);
        distance = (arm.tip_frame(&frames, 0).0 - center).norm();
        if (distance - before).abs() < SETTLED_M {
            break;
        }
    }
    distance
}

/// The angle in the range at which the cosine of its distance from `wanted` is largest.
fn best_in_range(wanted: f64, lower: f64, upper: f64) -> f64 {
    use std::f64::consts::TAU;
    let turned = wanted - TAU * ((wanted - lower) / TAU).floor();
    if turned <= upper {
        return turned;
    }
    // Beyond the upper end: by how much, and by how much before the lower end a turn later.
    if turned - upper < lower + TAU - turned { upper } else { lower }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::stream::{Purpose, stream};
    use rand::RngExt;
    use std::path::Path;

    #[test]
    fn no_posture_leaves_the_ball_and_the_ball_is_not_vast() {
        for (name, _) in super::super::PRESETS {
            let body = Body::load(name, Path::new(".")).unwrap();
            let (center, radius) = reach_ball(&body, Side::Right, Pelvis::Rests).unwrap();
            let arm = body.arm(Side::Right).unwrap();
            let mut frames = Frames::default();
            let mut farthest = 0.0f64;
            for index in 0..3000 {
                let mut rng = stream(11, Purpose::Simulation, 0, index);
                // Ends of the ranges are likelier: that is where arms are long.
                let mut share = || (1.6 * rng.random::<f64>() - 0.3).clamp(0.0, 1.0);
                let q: Vec<f64> =
                    arm.joints().iter().map(|j| j.lower + share() * (j.upper - j.lower)).collect();
                arm.forward(&q, &mut frames);
                farthest = farthest.max((arm.tip_frame(&frames, 0).0 - center).norm());
            }
            assert!(farthest <= radius, "{name}: {farthest} beyond {radius}");
            assert!(radius < 0.9 * body.size.stature_m, "{name}: {radius}");
            assert!(radius > 0.4 * body.size.stature_m, "{name}: {radius}");
            // The grip of some posture can be reached; a place past the ball by what is past.
            let there = arm.tip_frame(&frames, 0).0;
            assert!(reach_gap(&body, Side::Right, Pelvis::Rests, &there).unwrap() < 1e-3, "{name}");
            let beyond = center + Vec3::x() * (radius + 0.1);
            assert!(reach_gap(&body, Side::Right, Pelvis::Rests, &beyond).unwrap() > 0.1, "{name}");
        }
    }
}
