//! One worker, from a second of recordings on, by what other people do.
//!
//! ```text
//! W      (nu Psi + n S / tr S) / (nu + n)      Psi: W of the people over its trace; S: second moment of the
//!                                              worker's joint velocities; n: its samples, 0.2 s apart
//! m(x)   the people's regression with the worker as one more person
//! S_q    (1 - s)(1 + s / (k s + 1 - s)) of the people's    k movements of the worker, s the share that is a person's own
//! ```
//! Where hands are low the modes of reaching down are adapted, each by the worker's movements of that mode, and not
//! the law of all modes together.
//!
//! The posterior mean of an inverse Wishart law about the people's W, and of Gaussian ones about their usual
//! postures. What differs between repetitions stays that of the people.

use super::dataset::{Dataset, Frame, sparse};
use super::measurer::Measurer;
use super::standing::adapt_standing;
use crate::files::InputError;
use crate::math::Pose;
use crate::posture::{Mode, Modes, PostureDistribution, PostureLaw, PostureModel};
use nalgebra::DMatrix;
use std::collections::BTreeSet;

/// nu: what the people's W counts, in independent samples of a worker's. Left-out people of a prototype were
/// predicted best with it; evidence alone would take a person's movements as more alike than they are.
const PEOPLE_COUNT: f64 = 30.0;
/// Time after which a sample counts as another one, s.
const APART_S: f64 = 0.2;
/// Shortest recording that says anything, s.
pub const SHORTEST_S: f64 = 0.5;
/// Most postures of the worker that the regression takes on.
const MOST_POSTURES: usize = 120;

/// A model of several people as that of one worker who was recorded; the worker's postures are in the body of
/// the model.
///
/// # Errors
/// Where the model is not one of several people, or of another chain or side, or too little was recorded.
pub fn adapt(model: &PostureModel, own: &Dataset) -> Result<PostureModel, InputError> {
    let Some(population) = model.postures.population else {
        return Err(InputError::new(&model.name, "is not a model of several people")
            .remedy("adapt one that was trained on several, such as the shipped `people`"));
    };
    if own.joints != model.joints {
        let message = format!(
            "moves {} coordinates, the recordings {}",
            model.joints.len(),
            own.joints.len()
        );
        return Err(InputError::new(&model.name, message)
            .remedy("give recordings that hold trunk, arm and both legs"));
    }
    let seconds = recorded_s(own);
    if seconds < SHORTEST_S {
        let message = format!("hold {seconds:.2} s of movement");
        return Err(InputError::new("the recordings", message)
            .remedy(format!("give at least {SHORTEST_S} s")));
    }
    own.refuse_still("the recordings")?;
    let frames: Vec<&Frame> = own.frames.iter().collect();
    let unknown = population.unknown_after(own.trials);
    let of_way = |law: &PostureLaw, postures: &PostureDistribution, frames: &[&Frame]| {
        (adapted_law(law, frames, own.coupling.stature_m()), adapted_postures(postures, unknown))
    };
    let anyhow = match &model.modes {
        Some(modes) => of_no_mode(modes, own),
        None => frames,
    };
    let (law, postures) = of_way(&model.law, &model.postures, &anyhow);
    let modes = model.modes.as_ref().map(|modes| {
        let of_mode = |(k, mode): (usize, &Mode)| {
            let (law, postures) = of_way(&mode.law, &mode.postures, &of_a_mode(modes, k, own));
            Mode { law, postures, ..*mode }
        };
        Modes { all: modes.all.iter().enumerate().map(of_mode).collect(), ..modes.clone() }
    });
    let mut provenance = model.provenance.clone();
    provenance.adapted_s = Some((10.0 * seconds).round() / 10.0);
    Ok(PostureModel {
        law,
        postures,
        modes,
        standing: model.standing.as_ref().map(|place| adapt_standing(place, own)),
        quality: Vec::new(),
        provenance,
        ..model.clone()
    })
}

/// How long the worker was recorded, s.
pub fn recorded_s(own: &Dataset) -> f64 {
    own.frames
        .windows(2)
        .filter(|w| w[0].trial == w[1].trial)
        .map(|w| w[1].time_s - w[0].time_s)
        .sum()
}

fn adapted_law(law: &PostureLaw, frames: &[&Frame], stature_m: f64) -> PostureLaw {
    let n = law.dof();
    let (mut moment, mut seconds) = (DMatrix::zeros(n, n), 0.0);
    for pair in frames.windows(2).filter(|w| w[0].trial == w[1].trial) {
        let step = pair[1].time_s - pair[0].time_s;
        moment.ger(step, &pair[1].qdot, &pair[1].qdot, 1.0);
        seconds += step;
    }
    let trace = law.weight.trace();
    let count = seconds / APART_S;
    let weight = if moment.trace() > 0.0 {
        let own = &moment * (trace / moment.trace());
        (&law.weight * PEOPLE_COUNT + own * count) / (PEOPLE_COUNT + count)
    } else {
        law.weight.clone()
    };
    let kept = super::dataset::at_most(&sparse(frames), MOST_POSTURES);
    let hands: Vec<Pose> = kept.iter().map(|f| f.hand).collect();
    let rows: Vec<_> = kept.iter().map(|f| f.q.transpose()).collect();
    let movements: Vec<usize> = kept.iter().map(|f| f.trial).collect();
    let attraction = law.attraction.as_ref().map(|usual| {
        let own = (!rows.is_empty())
            .then(|| usual.of_one_more(&hands, &DMatrix::from_rows(&rows), &movements, stature_m));
        own.flatten().unwrap_or_else(|| usual.clone())
    });
    PostureLaw { weight, attraction, ..law.clone() }
}

fn adapted_postures(postures: &PostureDistribution, unknown: f64) -> PostureDistribution {
    let mut own = PostureDistribution { population: None, ..postures.clone() };
    for about in
        own.about_usual.iter_mut().chain(own.low.iter_mut().map(|low| &mut low.about_usual))
    {
        *about *= unknown;
    }
    own
}

/// The worker's frames without the low movements of other modes: those whose lowest postures are nearer to
/// another one's.
fn of_a_mode<'a>(modes: &Modes, mode: usize, own: &'a Dataset) -> Vec<&'a Frame> {
    let Some(measurer) = &own.measurer else { return own.frames.iter().collect() };
    let other: BTreeSet<usize> = (0..own.trials)
        .filter(|t| nearest_mode(modes, measurer, own, *t).is_some_and(|k| k != mode))
        .collect();
    own.frames.iter().filter(|f| !other.contains(&f.trial)).collect()
}

/// The worker's frames that tell nothing of modes: one movement shows one way of reaching down, not that the worker
/// has no other.
fn of_no_mode<'a>(modes: &Modes, own: &'a Dataset) -> Vec<&'a Frame> {
    let stature_m = own.coupling.stature_m();
    own.frames.iter().filter(|f| f.hand.translation.y / stature_m >= modes.below).collect()
}

/// The mode of a movement by trunk and knees where the hand is lowest; none where it is not low.
fn nearest_mode(modes: &Modes, measurer: &Measurer, own: &Dataset, trial: usize) -> Option<usize> {
    let stature_m = own.coupling.stature_m();
    let height = |f: &&Frame| f.hand.translation.y / stature_m;
    let frames = own.frames.iter().filter(|f| f.trial == trial);
    let lowest = frames.min_by(|a, b| height(a).total_cmp(&height(b)))?;
    let here = measurer.measure(lowest.q.as_slice());
    let away = |m: &Mode| (m.trunk_deg - here[1]).hypot(m.knees_deg - here[4]);
    let nearest = |a: &usize, b: &usize| away(&modes.all[*a]).total_cmp(&away(&modes.all[*b]));
    (height(&lowest) < modes.below).then(|| (0..modes.all.len()).min_by(nearest)).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::human::{Body, Side};
    use crate::posture::{load_model, model_text, save_model, simulated_whole_operator};
    use crate::training::dataset::Trial;
    use crate::training::motion_file::trial_of;
    use crate::training::simulated_movements::SimulatedMovements;
    use std::path::Path;

    /// Movements of somebody who is none of the five people, in the body of their model.
    fn somebody(model: &PostureModel, movements: usize) -> Dataset {
        let body = Body::of_size("common", model.size).unwrap();
        let source = SimulatedMovements::new(&body, Side::Right, true, 11).unwrap();
        let trial = |(i, reach): (usize, crate::training::Reach)| -> Trial {
            let columns: Vec<Vec<f64>> = (0..reach.postures[0].len())
                .map(|c| reach.postures.iter().map(|q| q[c]).collect())
                .collect();
            trial_of(i.to_string(), 1.0 / (reach.times_s[1] - reach.times_s[0]), &columns)
        };
        let trials: Vec<Trial> =
            source.first(movements).unwrap().into_iter().enumerate().map(trial).collect();
        Dataset::new(&trials, &body, Side::Right).unwrap()
    }

    #[test]
    fn the_worker_is_found_between_the_people_and_what_was_recorded() {
        let (model, _) = load_model("people", Path::new(".")).unwrap();
        let own = somebody(&model, 4);
        let adapted = adapt(&model, &own).unwrap();
        // W: nearer to the worker's second moment, of the same size.
        let frames: Vec<&Frame> = own.frames.iter().collect();
        let mut moment = DMatrix::zeros(30, 30);
        for f in &frames {
            moment.ger(1.0, &f.qdot, &f.qdot, 1.0);
        }
        let unit = |m: &DMatrix<f64>| m / m.trace();
        let away = |m: &PostureModel| (unit(&m.law.weight) - unit(&moment)).norm();
        assert!(away(&adapted) < 0.9 * away(&model), "{} {}", away(&adapted), away(&model));
        let [before, after] = [&model, &adapted].map(|m| m.law.weight.trace());
        assert!((before / after - 1.0).abs() < 0.05, "{before} {after}");
        // Usual postures: nearer to the worker's where these were, and those of the people far away.
        let stature_m = own.coupling.stature_m();
        let usual = |m: &PostureModel, hand: &Pose| {
            m.law.attraction.as_ref().unwrap().usual_posture(hand, stature_m)
        };
        let off = |m: &PostureModel| -> f64 {
            frames.iter().map(|f| (usual(m, &f.hand).posture - &f.q).norm_squared()).sum()
        };
        assert!(off(&adapted) < 0.5 * off(&model), "{} {}", off(&adapted), off(&model));
        // Nothing is known less than before.
        let people = model
            .law
            .attraction
            .as_ref()
            .unwrap()
            .usual_postures(&frames.iter().map(|f| f.hand).collect::<Vec<_>>(), stature_m);
        for (f, people) in frames.iter().zip(people) {
            assert!(usual(&adapted, &f.hand).confidence > people.confidence - 1e-6);
        }
        // Less is unknown, and nobody else is drawn.
        let of = |m: &PostureModel| m.postures.about_usual.as_ref().unwrap().trace();
        assert!(of(&adapted) < of(&model));
        assert!(adapted.postures.population.is_none());
        assert_eq!(
            adapted.modes.as_ref().map(|m| m.all.len()),
            model.modes.as_ref().map(|m| m.all.len())
        );
        // A file keeps it.
        let folder = tempfile::tempdir().unwrap();
        save_model(&adapted, &folder.path().join("anna.json")).unwrap();
        let (read, _) = load_model("anna.json", folder.path()).unwrap();
        assert_eq!(model_text(&read).unwrap(), model_text(&adapted).unwrap());
        let again =
            usual(&read, &frames[9].hand).posture - usual(&adapted, &frames[9].hand).posture;
        assert!(again.amax() < 1e-9);
    }

    #[test]
    fn with_more_seconds_the_worker_counts_for_more() {
        let (model, _) = load_model("people", Path::new(".")).unwrap();
        let away = |movements: usize| {
            let own = somebody(&model, movements);
            let adapted = adapt(&model, &own).unwrap();
            let weight = |m: &PostureModel| &m.law.weight / m.law.weight.trace();
            ((weight(&adapted) - weight(&model)).norm(), adapted.provenance.adapted_s.unwrap())
        };
        let ((one, one_s), (six, six_s)) = (away(1), away(6));
        assert!(six > one && six_s > one_s, "{one} {six}");
    }

    #[test]
    fn what_cannot_be_adapted_is_said() {
        let (model, _) = load_model("people", Path::new(".")).unwrap();
        let own = somebody(&model, 1);
        let body = Body::of_size("common", model.size).unwrap();
        let single = simulated_whole_operator(&body, Side::Right).unwrap();
        let error = adapt(&single, &own).unwrap_err().to_string();
        assert!(error.contains("not a model of several people"), "{error}");
        let short = own.part(&[0, 1, 2]);
        let error = adapt(&model, &short).unwrap_err().to_string();
        assert!(error.contains("hold 0.07 s of movement"), "{error}");
        let seated = PostureModel { joints: model.joints[3..].to_vec(), ..model };
        let error = adapt(&seated, &own).unwrap_err().to_string();
        assert!(error.contains("27 coordinates, the recordings 30"), "{error}");
    }
}
