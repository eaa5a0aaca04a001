//! Whole postures of a recorded person.

use super::{Motion, MotionKind, Track};
use crate::files::InputError;
use crate::human::{Body, Side};
use crate::math::{Pose, Rotation};
use crate::recording::Recording;
use crate::scenario::Origin;
use crate::survey::{WholePosture, WholeSurveyor};
use crate::training::{FitSettings, JointMotion, fit};
use rayon::prelude::*;

/// Disagreement of the two chains' trunks from which a note is made, deg.
const APART_DEG: f64 = 5.0;

/// Fits a body to a recording, each arm for itself, and measures its postures in the world.
///
/// # Errors
/// Where neither arm can be fitted; then why the first could not.
pub fn read_recorded(
    recording: &Recording,
    body: &Body,
    sides: &[Side],
) -> Result<Motion, InputError> {
    let fits: Vec<(Side, Result<JointMotion, InputError>)> = sides
        .par_iter()
        .map(|side| (*side, fit(recording, body, *side, &FitSettings::default())))
        .collect();
    let mut notes: Vec<String> = recording.remarks.iter().map(|r| r.text.clone()).collect();
    let mut arms = Vec::new();
    let mut refused = None;
    for (side, result) in fits {
        match result {
            Ok(motion) => {
                let told = motion.report.remarks.iter();
                notes.extend(told.map(|r| format!("{} arm: {}", side.name(), r.text)));
                arms.push((side, motion));
            }
            Err(e) => {
                notes.push(format!("the {} arm is not scored: {}", side.name(), e.message()));
                refused = refused.or(Some(e));
            }
        }
    }
    if arms.is_empty() {
        return Err(refused.unwrap_or_else(|| InputError::new(&recording.source, "has no side")));
    }
    let surveyor = WholeSurveyor::new(body)?;
    let measured: Vec<Vec<WholePosture>> =
        arms.iter().map(|(side, m)| measure(recording, &surveyor, *side, m)).collect();
    notes.extend(apart(&measured));
    let postures = (0..recording.frames()).map(|i| merged(&arms, &measured, i)).collect();
    let rate = recording.rate_hz;
    let time_s = (0..recording.frames()).map(|i| i as f64 / rate).collect();
    Ok(Motion {
        source: recording.source.clone(),
        sha256: recording.sha256.clone(),
        body: body.name.clone(),
        kind: MotionKind::Recording,
        tracks: vec![Track { name: "1".to_owned(), time_s, postures, exceeded: 0 }],
        origin: Origin::Measured,
        notes,
    })
}

/// The postures of one fitted chain; only its own arm is known.
fn measure(
    recording: &Recording,
    surveyor: &WholeSurveyor,
    side: Side,
    motion: &JointMotion,
) -> Vec<WholePosture> {
    let chain = surveyor.chain(side);
    let mut q = vec![0.0; surveyor.dof()];
    let pelvis = recording.segment("Pelvis");
    let neck = recording.segment("T8").zip(recording.segment("Head"));
    let frames = motion.q.iter().enumerate();
    frames
        .map(|(i, angles)| {
            for (column, angle) in chain.iter().zip(angles) {
                q[*column] = *angle;
            }
            let at = pelvis.map_or_else(Pose::identity, |p| {
                Pose::from_parts(p.position[i].into(), p.rotation[i])
            });
            let head: Option<Rotation> = neck.map(|(t8, head)| {
                (t8.rotation[i].inverse() * head.rotation[i]).to_rotation_matrix()
            });
            let mut posture = surveyor.measure(&q, &at, head.as_ref());
            posture.neck = posture.neck.filter(|_| neck.is_some());
            posture.knees_deg = knees(recording, i);
            posture.heels_deg = None;
            posture
        })
        .collect()
}

/// Knee flexion right and left from the joint centres, where both legs are recorded.
fn knees(recording: &Recording, frame: usize) -> Option<[f64; 2]> {
    let one = |side: &str| {
        let at =
            |part: &str| recording.segment(&format!("{side}{part}")).map(|s| s.position[frame]);
        let (hip, knee, ankle) = (at("UpperLeg")?, at("LowerLeg")?, at("Foot")?);
        Some(WholePosture::knee_from_points(&hip, &knee, &ankle))
    };
    Some([one("Right")?, one("Left")?])
}

/// Trunk, neck and knees of the first chain, each arm of its own.
fn merged(
    arms: &[(Side, JointMotion)],
    measured: &[Vec<WholePosture>],
    frame: usize,
) -> WholePosture {
    let mut posture = measured[0][frame];
    posture.arms = [None; 2];
    for ((side, _), postures) in arms.iter().zip(measured) {
        posture.take_arm(*side, &postures[frame]);
    }
    posture
}

/// A note where the trunks of the two fits differ much.
fn apart(measured: &[Vec<WholePosture>]) -> Option<String> {
    let [right, left] = measured else { return None };
    let squares = right.iter().zip(left).map(|(a, b)| {
        let flexion = a.neutral.trunk_flex_deg - b.neutral.trunk_flex_deg;
        let twist = a.neutral.trunk_twist_deg - b.neutral.trunk_twist_deg;
        flexion.powi(2) + twist.powi(2)
    });
    let rms = (squares.sum::<f64>() / right.len().max(1) as f64).sqrt();
    (rms > APART_DEG).then(|| {
        format!(
            "the trunks of the two arms' fits differ by {rms:.1} deg rms; the sheets use the right one's"
        )
    })
}
