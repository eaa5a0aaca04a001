//! Recordings of the upper body alone, made whole: where their hips are is what the shipped model of recorded
//! people expects of them.
//!
//! How the pelvis is turned tells a recording itself, seen from where the pelvis faces, and the feet are taken to
//! point there. Joint angles alone do not tell it: then it is expected too.

use super::dataset::Trial;
use super::fit::FitSettings;
use super::source::Source;
use crate::files::InputError;
use crate::human::{Body, Legs, PELVIS_JOINTS, Pelvis, Side, Stance, mirror_sign, pelvis_in_rest};
use crate::math::signal::low_pass_zero_phase;
use crate::posture::{Filling, PostureModel, Unrecorded, load_model};
use crate::recording::Remark;
use nalgebra::DVector;
use std::path::Path;

/// The shipped model of recorded people.
const FILLED_FROM: &str = "people";
/// Coordinates of a pelvis that are displacements; its turns follow.
const PLACES: usize = 3;

/// What was filled in, and from what.
#[derive(Debug, Clone)]
pub(super) struct Filled {
    /// The model of whole people.
    pub whole: PostureModel,
    /// Coordinates and how uncertain they are.
    pub what: Unrecorded,
}

/// Gives those of the sources that hold no legs a pelvis that moves; none where all hold them.
///
/// # Errors
/// Where one is of a simulated person, or nothing can be expected of its postures.
pub(super) fn fill_pelvis(
    sources: &mut [Source],
    who: (&Body, Side),
) -> Result<Option<Filled>, InputError> {
    let lacks = |i: &usize| !sources[*i].moves_pelvis();
    let lacking: Vec<usize> = (0..sources.len()).filter(lacks).collect();
    if lacking.is_empty() {
        return Ok(None);
    }
    if let Some(made_up) = sources.iter().find(|s| s.simulated) {
        let message =
            "is of a simulated operator whose pelvis rests, and people would make it whole";
        return Err(InputError::new(&made_up.name, message).remedy("leave out --pelvis moves"));
    }
    let (whole, _) = load_model(FILLED_FROM, Path::new("."))?;
    let mut of_lacking = lacking.iter().flat_map(|&i| &sources[i].trials);
    let is_turned = of_lacking.all(|t| !t.turn.is_empty());
    let unknown: Vec<usize> = (0..if is_turned { PLACES } else { PELVIS_JOINTS.len() }).collect();
    let singular = || InputError::fault(FILLED_FROM, "holds a singular covariance");
    let filling = Filling::new(&whole, &unknown).ok_or_else(singular)?;
    let unknown_of = whole.unknown_of(&unknown).ok_or_else(singular)?;
    let mut filled_s = 0.0;
    let seconds = |s: &Source| s.trials.iter().map(|t| t.q.len() as f64 / t.rate_hz).sum::<f64>();
    let all_s: f64 = sources.iter().map(seconds).sum();
    for &i in &lacking {
        filled_s += seconds(&sources[i]);
        for trial in &mut sources[i].trials {
            *trial = filled(trial, (&whole, &filling), &unknown, who)?;
        }
    }
    let height_cm = 100.0 * who.0.leg_m() * unknown_of[(1, 1)].sqrt();
    let what = if is_turned {
        "where the hips are and how the knees bend is"
    } else {
        "where the hips are, how the pelvis is turned and how the knees bend is"
    };
    let text = format!(
        "holds no legs: {what} not recorded but what the shipped model `{FILLED_FROM}` ({} recorded people, not your \
         workers) expects of such a posture, with hips up to {:.0} cm higher or lower in nine of ten frames, over feet \
         that do not step and point where the pelvis faces; the held-out figures take it as recorded",
        whole.provenance.people,
        1.645 * height_cm
    );
    for i in lacking {
        sources[i].remarks.push(Remark::new("filled pelvis", text.clone()).of_size(1.0));
    }
    let share = filled_s / all_s.max(f64::MIN_POSITIVE);
    Ok(Some(Filled { whole, what: Unrecorded { coordinates: unknown, share } }))
}

/// A trial on the pelvis that is expected of it.
fn filled(
    trial: &Trial,
    (whole, filling): (&PostureModel, &Filling),
    unknown: &[usize],
    (body, side): (&Body, Side),
) -> Result<Trial, InputError> {
    let sign = |joint: &String| if side == whole.side { 1.0 } else { mirror_sign(joint) };
    let signs: Vec<f64> = whole.joints.iter().map(sign).collect();
    let lead = Pelvis::Moves.free();
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(trial.q.len());
    for (i, joints) in trial.q.iter().enumerate() {
        let turn = if unknown.len() == lead { [0.0; 3] } else { trial.turn[i] };
        let own = [0.0; PLACES].iter().chain(&turn).chain(joints);
        let q = DVector::from_iterator(signs.len(), own.zip(&signs).map(|(q, s)| q * s));
        let found = filling.fill(&q).ok_or_else(|| {
            let message = format!("frame {i} holds a posture of which no pelvis can be expected");
            InputError::new(&trial.source, message).remedy("leave out --pelvis moves")
        })?;
        rows.push((0..lead).map(|c| found[c] * signs[c]).collect());
    }
    let legs = Legs::new(body, Stance::Standing { shoe_m: 0.0 })?;
    let columns: Vec<Vec<f64>> = (0..lead)
        .map(|c| {
            let column: Vec<f64> = rows.iter().map(|row| row[c]).collect();
            let is_smooth = !unknown.contains(&c);
            let cutoff_hz = FitSettings::default().cutoff_hz;
            if is_smooth { column } else { low_pass_zero_phase(&column, trial.rate_hz, cutoff_hz) }
        })
        .collect();
    let pelvis: Vec<[f64; 6]> = (0..rows.len())
        .map(|i| {
            let mut row: [f64; 6] = std::array::from_fn(|c| columns[c][i]);
            // A mean of bent and straight legs may be beyond straight ones.
            row[1] -= legs.too_high_m(&pelvis_in_rest(&row, body.leg_m())) / body.leg_m();
            row
        })
        .collect();
    Ok(trial.clone().on_pelvis(&pelvis))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::training::measurer::Measurer;
    use crate::training::people::{Person, read_people, read_people_file};

    /// Rms of the hips' height (cm), the trunk and the knees (deg) over the movements of a person whose legs are
    /// hidden: with the pelvis filled in, and upright.
    fn off(person: &Person, whole: &PostureModel) -> ([f64; 3], [f64; 3]) {
        let measurer = Measurer::new(&person.body, person.side).unwrap();
        let filling = Filling::new(whole, &[0, 1, 2]).unwrap();
        let (mut by_model, mut upright, mut count) = ([0.0; 3], [0.0; 3], 0.0);
        for movement in &person.movements {
            let recorded = &movement.trial;
            let mut hidden = recorded.clone();
            hidden.leave_pelvis();
            // Nearly what the recording itself would tell; only the turn on the feet is known here too.
            hidden.turn = recorded.q.iter().map(|q| [q[3], q[4], q[5]]).collect();
            let who = (&person.body, person.side);
            let found = filled(&hidden, (whole, &filling), &[0, 1, 2], who).unwrap();
            for (own, q) in found.q.iter().zip(&recorded.q).step_by(4) {
                assert_eq!(own[3..], q[3..], "what was recorded stays");
                let mut still = q.clone();
                still[..6].fill(0.0);
                let truth = measurer.measure(q);
                for (sum, guess) in [(&mut by_model, own), (&mut upright, &still)] {
                    let seen = measurer.measure(guess);
                    sum[0] += (100.0 * person.body.leg_m() * (guess[1] - q[1])).powi(2);
                    sum[1] += (seen[1] - truth[1]).powi(2);
                    sum[2] += (seen[4] - truth[4]).powi(2);
                }
                count += 1.0;
            }
        }
        let rms = |sum: [f64; 3]| sum.map(|s| (s / count).sqrt());
        (rms(by_model), rms(upright))
    }

    #[test]
    fn hidden_hips_and_knees_are_filled_in_better_than_by_standing_upright() {
        let Some(folder) = crate::skips::shared("recordings/hdm05") else { return };
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("people.toml");
        let clips = ["depositFloorR_001", "depositFloorR_003", "grabHighR_002"];
        let named = clips.map(|c| format!("{:?}", folder.join(format!("HDM_bd_{c}_120.amc"))));
        let text = "schema = \"ergopath/people/1\"\n[[person]]\nname = \"bd\"\n";
        std::fs::write(&file, format!("{text}recordings = [{}]\n", named.join(", "))).unwrap();
        let person = read_people(&read_people_file(&file).unwrap()).unwrap().remove(0);
        // The shipped model has seen this person: what is asked for here is the direction.
        let (whole, _) = load_model(FILLED_FROM, Path::new(".")).unwrap();
        let (by_model, upright) = off(&person, &whole);
        assert!(by_model[0] < 0.7 * upright[0], "height: {by_model:?} {upright:?}");
        assert!(by_model[1] < 1.0 && upright[1] > 5.0, "trunk: {by_model:?} {upright:?}");
        assert!(by_model[2] < 0.5 * upright[2], "knees: {by_model:?} {upright:?}");
        // What the model says is unknown is of the size of what it misses.
        let said_cm =
            100.0 * person.body.leg_m() * whole.unknown_of(&[0, 1, 2]).unwrap()[(1, 1)].sqrt();
        assert!((0.5..2.5).contains(&(said_cm / by_model[0])), "{said_cm} {by_model:?}");
    }
}
