//! A simulated operator: a person made up for demonstrations and tests, never to be taken for data.
//!
//! It copies what real recordings show: one trunk rotation spread over the four spine joints (slopes
//! 1, 0.44, 0.44, 0.33), so that the joint velocities have rank 15 of 24; a shoulder that moves with
//! the elbow; arm joints that move far more than the spine; a posture law that bends the trunk for
//! low and far places; and correlated noise. The whole operator has a pelvis that tilts and goes back as
//! the trunk bends and sinks as the knees do. All numbers here are inventions.

use super::attraction::{Attraction, Pull};
use super::coupling::{Coupling, Hold};
use super::law::PostureLaw;
use super::model::{Method, PostureDistribution, PostureModel, Provenance};
use super::noise::{Clock, Drift, Noise};
use super::start::{StartRule, start_postures};
use crate::files::{InputError, Seal};
use crate::human::{Body, Coupled, PELVIS_JOINTS, Pelvis, Side, Stance};
use crate::math::pose::rotation_from_axes;
use crate::math::stream::{Purpose, normals, stream};
use crate::math::{Pose, Vec3};
use nalgebra::{DMatrix, DVector};

/// Hand speed at which the noise is stated, m/s.
const SPEED_RMS_M_S: f64 = 0.3;
/// What the joints do while the hand rests, as the people of a recorded hand-over do.
const DRIFT: Drift = Drift { speed_rad_s: 1.6 * std::f64::consts::PI / 180.0, time_s: 0.3 };
/// Hand travel after which 1/e of a departure from the usual posture is left, m.
const PULL: Pull = Pull::Metre { length_m: 0.2 };
const SPINE_SHARE: [f64; 4] = [1.0, 0.44, 0.44, 0.33];

/// The person's usual posture with a hand before the chest, deg: (joint without side, Z, X, Y).
const COMFORT: &[(&str, [f64; 3])] = &[
    ("C7Shoulder", [0.0, -2.0, 2.0]),
    ("Shoulder", [20.0, -18.0, 12.0]),
    ("Elbow", [75.0, 3.0, 95.0]),
    ("Wrist", [-8.0, 2.0, 0.0]),
];
/// Standard deviation of the usual posture by joint and axis, deg.
const SPREAD: &[(&str, [f64; 3])] = &[
    ("C7Shoulder", [1.0, 3.0, 4.0]),
    ("Shoulder", [16.0, 11.0, 13.0]),
    ("Elbow", [16.0, 2.0, 16.0]),
    ("Wrist", [10.0, 6.0, 1.0]),
];
/// Standard deviation of the trunk's Z, X, Y rotation as a whole, deg.
const TRUNK_SPREAD: [f64; 3] = [9.0, 3.5, 6.0];

/// The pelvis in the usual posture: forward, up (leg lengths), and its tilt, deg.
const PELVIS_COMFORT: [f64; 6] = [0.035, -0.003, 0.0, -2.0, 0.0, 0.0];
/// Ways in which a whole body varies: the six coordinates of the pelvis (leg lengths, deg) and the
/// trunk's rotation as a whole about Z, X, Y (deg), one standard deviation each over all places of the hand;
/// and what share of it is left where the place is known. [`KNEES`] is bending them.
const WAYS: &[([f64; 6], [f64; 3], f64)] = &[
    // Bending forward: the pelvis tilts and goes back.
    ([-0.018, -0.002, 0.0, -6.0, 0.0, 0.0], [-7.0, 0.0, 0.0], 0.5),
    // Bending the knees.
    ([-0.006, -0.022, 0.0, -2.0, 0.0, 0.0], [-0.5, 0.0, 0.0], 0.25),
    // Shifting the weight to a side.
    ([0.0, -0.001, 0.020, 0.0, 1.0, 0.0], [0.0, 2.0, 0.0], 0.7),
    // Turning.
    ([0.0, 0.0, 0.0, 0.0, 0.0, 4.0], [0.0, 0.0, 5.0], 0.7),
    // The trunk alone, and swaying.
    ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [4.0, 0.0, 0.0], 1.0),
    ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 3.0, 3.0], 1.0),
    ([0.010, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1.0),
];
/// Which of the ways bends the knees. How readily they are bent for a place goes by the height of the hand
/// over the hips (over stature): hardly at a bench, more and more below.
const KNEES: usize = 1;
const READILY: [(f64, f64); 2] = [(-0.02, 0.2), (-0.32, 1.6)];
/// What is added to each displacement of the pelvis, leg lengths.
const PELVIS_FLOOR: f64 = 0.003;

/// How far one simulated person's usual posture is from another's, in standard deviations, and how
/// their habits of moving differ (standard deviation of the logarithm of a joint group's share).
const INDIVIDUAL_POSTURE: f64 = 0.6;
const INDIVIDUAL_SHARE: f64 = 0.45;

/// The simulated operator in a body of any size, on a pelvis that rests.
pub fn simulated_operator(body: &Body, side: Side) -> Result<PostureModel, InputError> {
    simulated(body, Coupled::arm(side), None)
}

/// The simulated operator as a whole person, standing: pelvis, spine and arm; the legs follow.
pub fn simulated_whole_operator(body: &Body, side: Side) -> Result<PostureModel, InputError> {
    simulated(body, Coupled { hands: side.into(), pelvis: Pelvis::Moves }, None)
}

/// A simulated person with a usual posture and habits of their own, on a pelvis that rests; without a
/// number, the operator of the demonstration.
pub fn simulated_person(
    body: &Body,
    side: Side,
    number: Option<u64>,
) -> Result<PostureModel, InputError> {
    simulated(body, Coupled::arm(side), number)
}

/// The same as a whole person, standing.
pub fn simulated_whole_person(
    body: &Body,
    side: Side,
    number: u64,
) -> Result<PostureModel, InputError> {
    simulated(body, Coupled { hands: side.into(), pelvis: Pelvis::Moves }, Some(number))
}

fn simulated(
    body: &Body,
    coupled: Coupled,
    number: Option<u64>,
) -> Result<PostureModel, InputError> {
    let side = coupled.hands.lead();
    let standing = (Stance::Standing { shoe_m: 0.03 }, 0.0);
    let coupling = Coupling::of_person(body, coupled, &[Hold::Rigid], standing)?;
    let joints: Vec<String> = coupling.joints().map(str::to_owned).collect();
    let mut mean = comfort(&joints, side);
    let is_whole = coupled.pelvis != Pelvis::Rests;
    let mut spread =
        if is_whole { whole_covariance(&joints, |_, _| 1.0) } else { covariance(&joints) };
    // What differs from one time to the next where the hand is at the same place.
    let mut about = is_whole.then(|| whole_covariance(&joints, |_, share| share));
    if let Some(number) = number {
        individual(&joints, number, &mut mean, (&mut spread, about.as_mut()));
        let limits = coupling.limits();
        for (i, q) in mean.iter_mut().enumerate() {
            *q = q.clamp(limits.lower[i], limits.upper[i]);
        }
    }
    let mut postures = PostureDistribution::anywhere(mean, spread.clone());
    // Velocities: as the postures spread, with the elbow and the shoulder's flexion tied.
    let mut weight = about.as_ref().unwrap_or(&spread).clone();
    let flexion = |kind: &str| joints.iter().position(|j| parts(j) == (kind, 0));
    if let (Some(s), Some(e)) = (flexion("Shoulder"), flexion("Elbow")) {
        let tie = -0.6 * (weight[(s, s)] * weight[(e, e)]).sqrt();
        weight[(s, e)] = tie;
        weight[(e, s)] = tie;
    }
    let places = if coupled.pelvis == Pelvis::Rests { &BENCH } else { &WHOLE };
    let attraction = posture_law(&coupling, &postures, (body, side), places)?;
    let noise = Noise {
        clock: Clock::Hand { speed_m_s: SPEED_RMS_M_S, drift: DRIFT },
        ..Noise::correlated(noise_factor(about.as_ref().unwrap_or(&spread)), 0.35)
    };
    postures.about_usual = about;
    Ok(PostureModel {
        name: "simulated operator (truth)".to_owned(),
        method: Method::FullW,
        side,
        size: body.size,
        joints,
        law: PostureLaw {
            attraction: Some(attraction),
            noise,
            ..PostureLaw::of_weight(weight, body.size.stature_m, 6)
        },
        postures,
        modes: None,
        standing: None,
        quality: Vec::new(),
        provenance: Provenance {
            filled_from: None,
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            simulated: true,
            adapted_s: None,
            people: 1,
            recordings: Vec::new(),
            body: (body.name.clone(), body.sha256()),
            settings: Vec::new(),
            notes: vec!["made up, not measured".to_owned()],
        },
        seal: Seal::Whole,
    })
}

/// Makes somebody else of the operator: other shares of the joint groups, another usual posture.
fn individual(
    joints: &[String],
    number: u64,
    mean: &mut DVector<f64>,
    (spread, about): (&mut DMatrix<f64>, Option<&mut DMatrix<f64>>),
) {
    let mut rng = stream(number, Purpose::Simulation, 7, 0);
    let shares = normals(&mut rng, 3 * GROUPS);
    let scale = |joint: &String| {
        let (kind, axis) = parts(joint);
        let group = SPREAD.iter().position(|(k, _)| *k == kind).map_or(0, |g| g + 1);
        (INDIVIDUAL_SHARE * shares[3 * group + axis]).exp()
    };
    let scales = DVector::from_iterator(joints.len(), joints.iter().map(scale));
    let scales = DMatrix::from_diagonal(&scales);
    *spread = &scales * &*spread * &scales;
    if let Some(about) = about {
        *about = &scales * &*about * &scales;
    }
    if let Some(factor) = spread.clone().cholesky() {
        let z = DVector::from_vec(normals(&mut rng, joints.len()));
        *mean += factor.l() * z * INDIVIDUAL_POSTURE;
    }
}

/// Joint groups that differ between people: the spine and those of [`SPREAD`].
const GROUPS: usize = 1 + SPREAD.len();

/// Side, joint kind and axis of a column such as `jRightElbow_Z`.
fn parts(joint: &str) -> (&str, usize) {
    let axis = match joint.rsplit('_').next() {
        Some("Z") => 0,
        Some("X") => 1,
        _ => 2,
    };
    let bare = joint.trim_start_matches('j').split('_').next().unwrap_or_default();
    (bare.trim_start_matches("Right").trim_start_matches("Left"), axis)
}

fn lookup(table: &[(&str, [f64; 3])], kind: &str, axis: usize) -> f64 {
    table.iter().find(|(k, _)| *k == kind).map_or(0.0, |(_, v)| v[axis])
}

fn comfort(joints: &[String], side: Side) -> DVector<f64> {
    DVector::from_iterator(
        joints.len(),
        joints.iter().map(|j| {
            if let Some(p) = pelvis_coordinate(j) {
                return if p < 3 { PELVIS_COMFORT[p] } else { PELVIS_COMFORT[p].to_radians() };
            }
            let (kind, axis) = parts(j);
            // A slightly bent trunk; X and Y mirror on the left.
            let spine = ["L5S1", "L4L3", "L1T12", "T9T8"].iter().position(|s| *s == kind);
            let deg = match spine {
                Some(s) if axis == 0 => -4.0 * SPINE_SHARE[s],
                Some(_) => 0.0,
                None => lookup(COMFORT, kind, axis),
            };
            let mirror = if side == Side::Left && axis > 0 { -1.0 } else { 1.0 };
            (mirror * deg).to_radians()
        }),
    )
}

/// Place among the coordinates of the pelvis.
fn pelvis_coordinate(joint: &str) -> Option<usize> {
    PELVIS_JOINTS.iter().position(|p| *p == joint)
}

/// Posture covariance of a whole body: [`WAYS`] of pelvis and trunk, each as far as `size` says of its
/// number and share, independent arm joints, a floor.
fn whole_covariance(joints: &[String], size: impl Fn(usize, f64) -> f64) -> DMatrix<f64> {
    let n = joints.len();
    let total: f64 = SPINE_SHARE.iter().sum();
    let mut sum = DMatrix::zeros(n, n);
    for (number, (pelvis, trunk, share)) in WAYS.iter().enumerate() {
        let of = |j: &String| {
            let (kind, axis) = parts(j);
            let spine = ["L5S1", "L4L3", "L1T12", "T9T8"].iter().position(|s| *s == kind);
            match (pelvis_coordinate(j), spine) {
                (Some(p), _) if p < 3 => pelvis[p],
                (Some(p), _) => pelvis[p].to_radians(),
                (_, Some(s)) => (SPINE_SHARE[s] / total * trunk[axis]).to_radians(),
                _ => 0.0,
            }
        };
        let way = DVector::from_iterator(n, joints.iter().map(of)) * size(number, *share);
        sum += &way * way.transpose();
    }
    for (i, joint) in joints.iter().enumerate() {
        let (kind, axis) = parts(joint);
        sum[(i, i)] += match pelvis_coordinate(joint) {
            Some(p) if p < 3 => PELVIS_FLOOR.powi(2),
            Some(_) => 0.5f64.to_radians().powi(2),
            None => lookup(SPREAD, kind, axis).to_radians().powi(2) + 0.15f64.to_radians().powi(2),
        };
    }
    sum
}

/// Posture covariance, rad^2: the trunk of rank three, independent arm joints, a small floor.
fn covariance(joints: &[String]) -> DMatrix<f64> {
    let n = joints.len();
    let total: f64 = SPINE_SHARE.iter().sum();
    let share = |joint: &str| {
        let (kind, axis) = parts(joint);
        let spine = ["L5S1", "L4L3", "L1T12", "T9T8"].iter().position(|s| *s == kind);
        spine.map(|s| (SPINE_SHARE[s] / total, axis))
    };
    DMatrix::from_fn(n, n, |i, j| {
        let floor = if i == j { 0.15f64.to_radians().powi(2) } else { 0.0 };
        let value = match (share(&joints[i]), share(&joints[j])) {
            (Some((a, x)), Some((b, y))) if x == y => a * b * TRUNK_SPREAD[x].to_radians().powi(2),
            (None, None) if i == j => {
                let (kind, axis) = parts(&joints[i]);
                lookup(SPREAD, kind, axis).to_radians().powi(2)
            }
            _ => 0.0,
        };
        value + floor
    })
}

/// Noise: five standard deviations of the posture per second, per m/s of hand speed, at rms speed.
fn noise_factor(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = covariance.clone().symmetric_eigen();
    let kept: Vec<usize> = (0..covariance.nrows())
        .filter(|&i| eigen.eigenvalues[i] > 1e-3 * eigen.eigenvalues.max())
        .collect();
    DMatrix::from_fn(covariance.nrows(), kept.len(), |r, c| {
        let k = kept[c];
        5.0 * SPEED_RMS_M_S * eigen.eigenvalues[k].sqrt() * eigen.eigenvectors[(r, k)]
    })
}

/// How readily the knees are bent for a hand at a height over the hips, over stature.
fn readily(up: f64) -> f64 {
    let [(high, least), (low, most)] = READILY;
    least + (most - least) * ((high - up) / (high - low)).clamp(0.0, 1.0)
}

/// Where the usual postures are worked out: heights over the hips, distances ahead and to the own side,
/// all over stature.
struct Places {
    up: &'static [f64],
    forward: &'static [f64],
    sideways: &'static [f64],
}

/// What a hand reaches from a pelvis that rests, and from one that moves.
const BENCH: Places = Places {
    up: &[-0.10, 0.0, 0.10, 0.20, 0.30],
    forward: &[0.16, 0.22, 0.28, 0.34],
    sideways: &[-0.08, 0.03, 0.14, 0.24],
};
const WHOLE: Places = Places {
    up: &[-0.38, -0.30, -0.22, -0.15, -0.07, 0.02, 0.10, 0.19, 0.28, 0.38, 0.48, 0.57],
    forward: &[0.16, 0.24, 0.32],
    sideways: &[-0.06, 0.08, 0.20],
};

/// Postures over the work volume: for each hand pose the comfortable posture moved there.
fn posture_law(
    coupling: &Coupling,
    postures: &PostureDistribution,
    (body, side): (&Body, Side),
    places: &Places,
) -> Result<Attraction, InputError> {
    let h = body.size.stature_m;
    let out = if side == Side::Right { 1.0 } else { -1.0 };
    let (mut hands, mut rows) = (Vec::new(), Vec::new());
    let joints: Vec<String> = coupling.joints().map(str::to_owned).collect();
    let is_whole = joints.iter().any(|j| pelvis_coordinate(j).is_some());
    for &up in places.up {
        let there = is_whole.then(|| {
            let knees = readily(up);
            let covariance = whole_covariance(&joints, |n, _| if n == KNEES { knees } else { 1.0 });
            PostureDistribution::anywhere(postures.mean.clone(), covariance)
        });
        let postures = there.as_ref().unwrap_or(postures);
        for &forward in places.forward {
            for &sideways in places.sideways {
                let at = Vec3::new(forward * h, up * h, out * sideways * h);
                let hand = Pose::from_parts(at.into(), natural_grip(up));
                let start =
                    start_postures(coupling, postures, &StartRule::Mean, hand, (0, 0), 0..1);
                if let Some(q) = start.into_iter().next().and_then(|s| s.q) {
                    hands.push(hand);
                    rows.push(q.transpose());
                }
            }
        }
    }
    if rows.len() < 20 {
        return Err(InputError::new(
            &body.name,
            "the simulated operator cannot reach its workplace",
        ));
    }
    Ok(Attraction::fit(&hands, DMatrix::from_rows(&rows), h, PULL, 2.0, 0.05))
}

/// How a bar is held at a height over the hips (over stature): upright before the body, the thumb up; lower
/// down the thumb turns forward, higher up backward, as the forearm does.
///
/// In the rest frame (x forward, y up, z right) the wrist is behind the grip of an upright bar.
pub fn natural_grip(up: f64) -> nalgebra::UnitQuaternion<f64> {
    let beyond = (up + 0.10).min(0.0) / 0.28 * 80.0 + (up - 0.30).max(0.0) / 0.27 * 35.0;
    let (sin, cos) = (90.0 + beyond).to_radians().sin_cos();
    let (y, z) = (Vec3::new(-sin, cos, 0.0), Vec3::new(cos, sin, 0.0));
    rotation_from_axes(y.cross(&z), y, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posture::{HandPath, Sampler, Sampling, Start, roll_out};

    fn lift() -> (Vec<f64>, Vec<Pose>) {
        let hand = |s: f64| {
            let s = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
            let at = Vec3::new(0.38 + 0.06 * s, 0.02 + 0.35 * s, 0.02 + 0.25 * s);
            Pose::from_parts(at.into(), natural_grip(0.0))
        };
        let time: Vec<f64> = (0..=100).map(|i| 0.04 * f64::from(i)).collect();
        let hands = (0..=100).map(|i| hand(f64::from(i) / 100.0)).collect();
        (time, hands)
    }

    #[test]
    fn rollouts_keep_hand_and_limits() {
        // What the robot leaves free must not drift off and take the arm to its limits.
        for (name, hold) in [
            ("female_p05", Hold::Rigid),
            ("male_p95", Hold::Rigid),
            ("female_p50", Hold::FreeRoll),
            ("male_p50", Hold::Point),
        ] {
            let body = Body::load(name, std::path::Path::new(".")).unwrap();
            let model = simulated_operator(&body, Side::Right).unwrap();
            let coupling = Coupling::new(&body, Side::Right, hold).unwrap();
            let (time, hands) = lift();
            let starts = start_postures(
                &coupling,
                &model.postures,
                &StartRule::Sampled,
                hands[0],
                (1, 0),
                0..16,
            );
            for (r, start) in starts.iter().enumerate() {
                let q = start.q.as_ref().unwrap_or_else(|| panic!("{name} {r} is out of reach"));
                assert!(coupling.limits().violation(q.as_slice()) < 1e-9);
                let mut rng = stream(1, Purpose::Posture, 1, r as u32);
                let sampler = Sampler::new(&model.law, Sampling::Pathwise).unwrap();
                let path = HandPath::new(&coupling, &model.law, time.clone(), hands.clone());
                let person = sampler.draw(&mut rng, &path);
                let rollout = roll_out(&coupling, &model.law, &path, start, Some(&person));
                assert_eq!(rollout.reach_exceeded_at, None, "{name} {r}");
                assert!(rollout.max_residual_m < 2.1e-4, "{}", rollout.max_residual_m);
                for q in &rollout.q {
                    assert!(coupling.limits().violation(q.as_slice()) < 1e-9);
                }
            }
        }
    }

    #[test]
    fn the_spread_does_not_depend_on_the_step() {
        let body = Body::load("female_p50", std::path::Path::new(".")).unwrap();
        let model = simulated_operator(&body, Side::Right).unwrap();
        let coupling = Coupling::new(&body, Side::Right, Hold::Rigid).unwrap();
        let (time, hands) = lift();
        let starts =
            start_postures(&coupling, &model.postures, &StartRule::Mean, hands[0], (1, 0), 0..1);
        let spread = |every: usize| {
            let t: Vec<f64> = time.iter().copied().step_by(every).collect();
            let h: Vec<Pose> = hands.iter().copied().step_by(every).collect();
            let path = HandPath::new(&coupling, &model.law, t, h);
            let sampler = Sampler::new(&model.law, Sampling::Pathwise).unwrap();
            let ends: Vec<DVector<f64>> = (0..400)
                .map(|r| {
                    let mut rng = stream(2, Purpose::Posture, 0, r);
                    let person = sampler.draw(&mut rng, &path);
                    roll_out(&coupling, &model.law, &path, &starts[0], Some(&person))
                        .q
                        .pop()
                        .unwrap()
                })
                .collect();
            let mean = ends.iter().sum::<DVector<f64>>() / 400.0;
            (ends.iter().map(|e| (e - &mean).norm_squared()).sum::<f64>() / 400.0).sqrt()
        };
        let (fine, coarse) = (spread(1), spread(2));
        assert!((coarse / fine - 1.0).abs() < 0.08, "{fine} {coarse}");
    }

    /// The operator with a start in a body, without a drift unless asked for.
    fn operator(drifts: bool) -> (PostureModel, Coupling, Start) {
        let body = Body::load("female_p50", std::path::Path::new(".")).unwrap();
        let mut model = simulated_operator(&body, Side::Right).unwrap();
        if !drifts {
            model.law.noise.clock = Clock::Hand {
                speed_m_s: SPEED_RMS_M_S,
                drift: Drift { speed_rad_s: 0.0, ..DRIFT },
            };
        }
        let coupling = Coupling::new(&body, Side::Right, Hold::Rigid).unwrap();
        let hand = lift().1[0];
        let rule = StartRule::Sampled;
        let start = start_postures(&coupling, &model.postures, &rule, hand, (1, 0), 3..4).remove(0);
        (model, coupling, start)
    }

    /// One repetition of number r along a path.
    fn walked(
        (model, coupling, start): &(PostureModel, Coupling, Start),
        time_s: Vec<f64>,
        hands: Vec<Pose>,
        r: u32,
    ) -> Vec<DVector<f64>> {
        let path = HandPath::new(coupling, &model.law, time_s, hands);
        let sampler = Sampler::new(&model.law, Sampling::Pathwise).unwrap();
        let person = sampler.draw(&mut stream(4, Purpose::Posture, 0, r), &path);
        let rollout = roll_out(coupling, &model.law, &path, start, Some(&person));
        assert_eq!(rollout.reach_exceeded_at, None);
        rollout.q
    }

    #[test]
    fn a_resting_hand_holds_the_posture() {
        let (time, hands) = lift();
        let still = vec![hands[0]; time.len()];
        for (drifts, lowest, highest) in [(false, 0.0, 1e-9), (true, 0.8, 2.0)] {
            let who = operator(drifts);
            let mut squares = Vec::new();
            for r in 0..40 {
                let q = walked(&who, time.clone(), still.clone(), r);
                let speed =
                    |p: &[DVector<f64>]| (&p[1] - &p[0]).norm_squared() / (24.0 * 0.04 * 0.04);
                squares.extend(q.windows(2).map(speed));
                // Nor does it creep away in 5 minutes.
                let long = time.iter().map(|t| 75.0 * t).collect();
                let q = walked(&who, long, still.clone(), r);
                assert!((&q[100] - &q[0]).norm() / 24f64.sqrt() < 2.5f64.to_radians());
            }
            let speed = crate::math::stats::mean(&squares).sqrt().to_degrees();
            assert!((lowest..=highest).contains(&speed), "{speed} deg/s");
        }
    }

    #[test]
    fn the_posture_does_not_depend_on_the_duration() {
        let (time, hands) = lift();
        let who = operator(false);
        let long: Vec<f64> = time.iter().map(|t| 75.0 * t).collect();
        // The hand waits on the way.
        let waiting: Vec<f64> =
            time.iter().map(|t| t + if *t > 2.0 { 60.0 } else { 0.0 }).collect();
        let quick = walked(&who, time, hands.clone(), 1);
        for other in [long, waiting] {
            let slow = walked(&who, other, hands.clone(), 1);
            for (a, b) in quick.iter().zip(&slow) {
                assert!((a - b).amax() < 1e-12);
            }
        }
    }

    #[test]
    fn a_finer_sampling_changes_nothing() {
        let (time, hands) = lift();
        let who = operator(true);
        let half = |pick: &dyn Fn(usize, f64) -> Pose| {
            (0..200).map(|i| pick(i / 2, 0.5 * f64::from(i as u32 % 2))).collect::<Vec<_>>()
        };
        let mut finer =
            half(&|i, part| crate::math::pose::interpolate(&hands[i], &hands[i + 1], part));
        finer.push(hands[100]);
        let fine_time = (0..=200).map(|i| 0.02 * f64::from(i)).collect();
        let coarse = walked(&who, time, hands.clone(), 1);
        let fine = walked(&who, fine_time, finer, 1);
        for (k, q) in coarse.iter().enumerate() {
            assert!((q - &fine[2 * k]).amax() < 1e-9, "{k}: {}", (q - &fine[2 * k]).amax());
        }
    }

    #[test]
    fn moving_everything_changes_nothing_and_a_far_goal_is_reported() {
        let body = Body::load("female_p50", std::path::Path::new(".")).unwrap();
        let model = simulated_operator(&body, Side::Right).unwrap();
        let coupling = Coupling::new(&body, Side::Right, Hold::Point).unwrap();
        let (time, mut hands) = lift();
        for (k, hand) in hands.iter_mut().enumerate() {
            hand.translation.vector.x += 0.012 * k as f64;
        }
        let starts =
            start_postures(&coupling, &model.postures, &StartRule::Mean, hands[0], (1, 0), 0..1);
        let count = hands.len();
        let path = HandPath::new(&coupling, &model.law, time, hands);
        let rollout = roll_out(&coupling, &model.law, &path, &starts[0], None);
        assert!(rollout.reach_exceeded_at.is_some_and(|k| k > 10));
        assert_eq!(rollout.q.len(), count);
    }
}
