//! The whole training: judge all methods on held-out movement, then learn the chosen one on all.
//!
//! ```text
//! Dataset ─ evaluate ─► quality of every method
//!         ─ all frames ─► z and W, attraction, postures
//!         ─ unseen residuals (with the attraction) ─► noise
//! ```

use super::dataset::{Dataset, Frame};
use super::evaluate::{Judging, MethodScore, evaluate};
use super::methods::{Law, learn_laws, singular};
use super::modes::{learn_modes, modes_note};
use super::rollout_check::{LearnedRepetitions, learn_repetitions};
use super::settings::{PullRule, TrainSettings};
use super::standing::learn_standing;
use super::way::{learn_way, rounded};
use crate::files::{InputError, Seal};
use crate::math::stats::mean;
use crate::posture::{Clock, Method, MethodQuality, PostureModel, Provenance};
use std::collections::BTreeSet;

/// Significant digits kept of scores.
const SCORE_DIGITS: i32 = 5;

/// Learns a posture model of the person of `dataset`.
///
/// # Errors
/// Where a setting is out of range, the chain is singular in the data, or the data are not a person's.
pub fn train(
    dataset: &Dataset,
    name: &str,
    method: Method,
    settings: &TrainSettings,
    provenance: Provenance,
) -> Result<PostureModel, InputError> {
    settings.check()?;
    let mut methods = if dataset.is_of_people() { Vec::new() } else { SHOWN.to_vec() };
    if !methods.contains(&method) {
        methods.push(method);
    }
    let judging = Judging { methods, task_sd: None, has_rollouts: true };
    let judged = evaluate(dataset, &dataset.held_out(), &judging, settings)?;
    let quality = judged.methods.iter().map(quality).collect();
    Ok(PostureModel { quality, ..learn(dataset, name, method, settings, provenance)? })
}

/// The same without judging any method.
///
/// # Errors
/// As for [`train`].
pub fn learn(
    dataset: &Dataset,
    name: &str,
    method: Method,
    settings: &TrainSettings,
    provenance: Provenance,
) -> Result<PostureModel, InputError> {
    settings.check()?;
    let Some((side, size)) = dataset.person else {
        return Err(InputError::new(name, "is not learned from a body")
            .remedy("a posture model is one of a person: give recordings and a body"));
    };
    let every: Vec<usize> = (0..dataset.frames.len()).collect();
    let all: Vec<&Frame> = dataset.frames.iter().collect();
    let stature_m = dataset.coupling.stature_m();
    let laws = learn_laws(&[method], &all, stature_m, settings, None)?;
    let law = laws.into_iter().next().ok_or_else(|| InputError::new(name, "has no law"))?;
    let repetitions = learn_repetitions(dataset, &every, &law, settings)?;
    let people: BTreeSet<usize> = dataset.frames.iter().map(|f| f.person).collect();
    let filled_from =
        dataset.filled.as_ref().map(|f| (f.whole.name.clone(), f.whole.provenance.people));
    let mut provenance = Provenance { people: people.len(), filled_from, ..provenance };
    provenance.settings.extend(described(settings, &law, &repetitions, dataset));
    provenance.notes.extend(notes(dataset, &law, &repetitions, settings));
    // Knees that were filled in tell no ways of reaching down.
    let modes = if dataset.filled.is_some() {
        None
    } else {
        learn_modes(dataset, &law, &repetitions, settings)?
    };
    provenance.notes.extend(modes.as_ref().map(modes_note));
    let (law, postures) = learn_way(dataset, law, &repetitions, settings);
    let model = PostureModel {
        name: name.to_owned(),
        method,
        side,
        size,
        joints: dataset.joints.clone(),
        law,
        postures,
        modes,
        standing: learn_standing(dataset),
        quality: Vec::new(),
        provenance,
        seal: Seal::Whole,
    };
    match &dataset.filled {
        Some(filled) => model.unsure_of(&filled.what, &filled.whole).ok_or_else(singular),
        None => Ok(model),
    }
}

/// Methods that are judged beside the chosen one of one person; people who are left out judge others
/// ([`crate::training::people::validate`]).
const SHOWN: [Method; 4] = [Method::PlainIk, Method::WIk, Method::FullW, Method::MiNsgp];

/// Means over splits and held-out trajectories.
fn quality(score: &MethodScore) -> MethodQuality {
    let of = |pick: fn(&super::evaluate::GroupScore) -> f64| {
        rounded(mean(&score.groups.iter().map(pick).collect::<Vec<_>>()), SCORE_DIGITS)
    };
    let walk = |pick: fn(&super::rollout_check::RolloutScore) -> f64| {
        rounded(mean(&score.rollouts.iter().map(pick).collect::<Vec<_>>()), SCORE_DIGITS)
    };
    MethodQuality {
        method: score.method,
        relative_rmse: of(|g| g.relative_rmse_q),
        rmse_rad_s: of(|g| g.rmse_q),
        log_likelihood_null: of(|g| g.ll_null),
        log_likelihood: of(|g| g.ll_q),
        path_error_deg: Some((walk(|r| r.path_error_deg), walk(|r| r.pulled_path_error_deg))),
        coverage: Some((walk(|r| r.bands.coverage_50), walk(|r| r.bands.coverage_90))),
        band_width_deg: Some(walk(|r| r.bands.width_90_deg)),
        trajectory_log_likelihood: Some(walk(|r| r.trajectory_ll)),
    }
}

fn described(
    settings: &TrainSettings,
    law: &Law,
    repetitions: &LearnedRepetitions,
    dataset: &Dataset,
) -> Vec<(String, String)> {
    let LearnedRepetitions { noise, calibration, .. } = repetitions;
    let pull = settings.pull_for(dataset.person.is_some());
    let mut list = vec![("method", law.method.name().to_owned())];
    if let Some(a) = law.shrinkage {
        list.push(("shrinkage", a.to_string()));
        list.push(("diagonal_share", settings.diagonal_share.to_string()));
    }
    if repetitions.is_pulled {
        list.push(("pull", pull.name().to_owned()));
        match pull {
            PullRule::PerMetre => {
                list.push(("attraction_length_m", settings.attraction_length_m.to_string()));
            }
            _ => list.push(("attraction_rate_per_s", settings.attraction_rate_per_s.to_string())),
        }
        list.push(("attraction_length", settings.attraction_length.to_string()));
        list.push(("attraction_noise", settings.attraction_noise.to_string()));
        list.push(("attraction_postures", settings.attraction_postures.to_string()));
    }
    if law.method == Method::MiNsgp {
        list.push(("objective", settings.objective_for(dataset.trials).name().to_owned()));
        list.push(("optimiser", settings.optimiser.name().to_owned()));
        list.push(("weight_prior_sd", settings.weight_prior_sd.to_string()));
    }
    for h in &law.hypers {
        list.push(("gp_length_posture", format!("{:.4}", h.length_posture)));
        list.push(("gp_length_velocity", format!("{:.4}", h.length_velocity)));
        list.push(("gp_noise_ratio", format!("{:.4}", h.noise_ratio)));
    }
    if law.method.has_process() {
        list.push(("noise_ratio_floor", settings.noise_ratio_floor.to_string()));
    }
    match noise.clock {
        Clock::Hand { speed_m_s, drift } => {
            list.push(("usual_hand_speed_m_s", format!("{speed_m_s:.4}")));
            list.push(("drift_deg_s", format!("{:.3}", drift.speed_rad_s.to_degrees())));
        }
        Clock::Seconds { speed_share, .. } => {
            list.push(("noise_speed_share", speed_share.to_string()));
        }
    }
    list.push(("noise_calibration", format!("{calibration:.4}")));
    list.into_iter().map(|(k, v)| (k.to_owned(), v)).collect()
}

fn notes(
    dataset: &Dataset,
    law: &Law,
    repetitions: &LearnedRepetitions,
    settings: &TrainSettings,
) -> Vec<String> {
    let people: BTreeSet<usize> = dataset.frames.iter().map(|f| f.person).collect();
    let mut notes = vec![if people.len() > 1 {
        format!(
            "judged on whole people held out, {} in all, with {} trials; their postures meet in one body",
            people.len(),
            dataset.trials
        )
    } else if dataset.trials > 1 {
        format!("judged on whole trials held out, {} in all", dataset.trials)
    } else {
        "judged on the last part of the only trial: the first 70 % of the time trained, 0.5 s were \
         left out; what differs between repetitions is not known from one trial"
            .to_owned()
    }];
    if let Some((free, pulled)) = repetitions.pull_error_deg {
        let verdict = if repetitions.is_pulled { "it is used" } else { "it is left out" };
        notes.push(format!(
            "on held-out blocks the joint error along the path is {free:.2} deg without and \
             {pulled:.2} deg with the pull towards the person's own postures: {verdict}"
        ));
    }
    for process in &law.law.processes {
        if process.is_inducing() {
            notes.push(format!(
                "the process rests on {} inducing centres: there are more than {} samples",
                process.centre_count(),
                settings.exact_samples
            ));
            break;
        }
    }
    notes
}
