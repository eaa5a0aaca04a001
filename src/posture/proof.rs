//! Whether a posture model that was read is one: the whole of it is proven before anything uses it.
//!
//! Sizes agree, matrices are symmetric and positive definite, every number is finite and one that a person can
//! have ([`crate::physical`]), and the joints are those of an ergopath body. Faults name the member of the file.

use super::attraction::{Attraction, Pull};
use super::law::PostureLaw;
use super::lowness::Lowness;
use super::model::{MethodQuality, PostureDistribution, PostureModel, Provenance};
use super::modes::Modes;
use super::noise::{Clock, Noise};
use super::primitive::Primitive;
use super::process::Process;
use crate::human::{Body, Coupled, PRESETS};
use crate::physical::{
    FIGURE, HAND_SPEED_M_S, JOINT_DEG, JOINT_RAD, JOINT_SPEED_RAD_S, OVER_STATURE, PELVIS_LEGS,
    Range, SHARE, STATURE_M, shown,
};
use nalgebra::DMatrix;
use std::path::Path;

/// Variance of a joint, of a square of [`JOINT_SPEED_RAD_S`] and [`JOINT_RAD`].
const SPEED_VARIANCE: f64 = JOINT_SPEED_RAD_S.high * JOINT_SPEED_RAD_S.high;
const POSTURE_VARIANCE: f64 = PELVIS_LEGS.high * PELVIS_LEGS.high;
/// How far from symmetric a matrix may be that was written with nine digits, over its largest entry.
const SYMMETRY: f64 = 1e-9;
/// Travel over which a departure fades, m, and its rate, 1/s: from a hand's tremor to never.
const PULL_M: Range = Range { low: 1e-3, high: 1e3, unit: "m" };
const PULL_PER_S: Range = Range { low: 1e-3, high: 1e3, unit: "1/s" };
/// Times of the noise: from a millisecond to longer than any movement.
const NOISE_S: Range = Range { low: 1e-3, high: 1e3, unit: "s" };
/// Factors of its standard deviation by the height of the hand.
const GAIN: Range = Range { low: 0.0, high: 100.0, unit: "" };
/// Growth of a variance from hands that are not low to those that are.
const LOWNESS_RATIO: Range = Range { low: 1.0, high: 1e6, unit: "" };
/// Most people and movements that a model is made from.
const MOST_COUNTED: usize = 1_000_000;
/// Longest name, characters.
const LONGEST_NAME: usize = 200;

/// Why a model cannot be used.
pub(super) fn prove(model: &PostureModel) -> Result<(), String> {
    model.size.check().map_err(|e| format!("size: {e}"))?;
    name("name", &model.name)?;
    joints(model)?;
    way(&model.law, &model.postures, &model.joints)?;
    if let Some(standing) = &model.standing
        && let Some(fault) = standing.fault()
    {
        return Err(format!("standing: {fault}"));
    }
    if let Some(modes) = &model.modes {
        for (i, mode) in modes.all.iter().enumerate() {
            let at = |e: String| format!("modes.all[{i}]: {e}");
            way(&mode.law, &mode.postures, &model.joints).map_err(at)?;
            in_range("trunk_deg", JOINT_DEG, [mode.trunk_deg]).map_err(at)?;
            in_range("knees_deg", JOINT_DEG, [mode.knees_deg]).map_err(at)?;
        }
        told_apart(modes)?;
    }
    for (i, of) in model.quality.iter().enumerate() {
        quality(of).map_err(|e| format!("quality[{i}]: {e}"))?;
    }
    provenance(&model.provenance).map_err(|e| format!("provenance: {e}"))
}

/// The joints are those of a body's arm on its pelvis, in their order: a name that no body has, or another
/// order, would give each angle to another joint.
fn joints(model: &PostureModel) -> Result<(), String> {
    let (body, _) = PRESETS[0];
    let body = Body::load(body, Path::new("")).map_err(|e| e.to_string())?;
    let coupled = Coupled { hands: model.side.into(), pelvis: model.pelvis() };
    let chain = body.chain(coupled, &[]).map_err(|e| e.to_string())?;
    let wanted = chain.joints().iter().map(|j| j.name.as_str());
    let given = model.joints.iter().map(String::as_str);
    if let Some((i, (found, wanted))) =
        given.zip(wanted).enumerate().find(|(_, (found, wanted))| found != wanted)
    {
        return Err(format!("joints[{i}]: `{found}` stands where a body has `{wanted}`"));
    }
    same("joints", model.joints.len(), chain.dof())
}

/// A law with its postures, of these joints.
fn way(law: &PostureLaw, postures: &PostureDistribution, joints: &[String]) -> Result<(), String> {
    let n = joints.len();
    covariance("law.weight", &law.weight, n, SPEED_VARIANCE)?;
    if let Some(offset) = &law.offset {
        same("law.offset", offset.len(), n)?;
        in_range("law.offset", JOINT_SPEED_RAD_S, offset.iter().copied())?;
    }
    if !(1..=6).contains(&law.task_rows) {
        return Err(format!("law.task_rows is {}, not 1 to 6", law.task_rows));
    }
    in_range("law.stature_m", STATURE_M, [law.stature_m])?;
    for (i, process) in law.processes.iter().enumerate() {
        let at = |e: String| format!("law.processes[{i}]: {e}");
        let inputs = process.inputs();
        same("postures among the inputs", inputs.0, n).map_err(at)?;
        same("inputs", inputs.0 + inputs.1, n + law.task_rows).map_err(at)?;
        served(process, n).map_err(at)?;
    }
    if let Some(own) = &law.primitive {
        primitive(own, n).map_err(|e| format!("law.primitive: {e}"))?;
    }
    noise(&law.noise, n).map_err(|e| format!("law.noise: {e}"))?;
    match (law.attraction.as_ref().map(Attraction::pull), law.noise.clock) {
        (None, _) => {}
        (Some(Pull::Metre { length_m }), Clock::Hand { .. }) => {
            in_range("law.attraction.pull.length_m", PULL_M, [length_m])?;
        }
        (Some(Pull::Second { rate_per_s }), Clock::Seconds { .. }) => {
            in_range("law.attraction.pull.rate_per_s", PULL_PER_S, [rate_per_s])?;
        }
        _ => return Err("the pull does not go by the clock of the noise".to_owned()),
    }
    if let Some(attraction) = &law.attraction {
        same("joints of law.attraction", attraction.dof(), n)?;
        for (column, joint) in attraction.postures().column_iter().zip(joints) {
            let what = || format!("law.attraction.postures_rad of `{joint}`");
            in_range("", coordinate(joint), column.iter().copied()).map_err(|e| what() + &e)?;
        }
    }
    distribution(postures, joints).map_err(|e| format!("postures: {e}"))
}

/// What a coordinate of a posture may be: an angle, or a place of the pelvis in leg lengths.
fn coordinate(joint: &str) -> Range {
    if joint.starts_with("pelvis_") { PELVIS_LEGS } else { JOINT_RAD }
}

fn distribution(postures: &PostureDistribution, joints: &[String]) -> Result<(), String> {
    let n = joints.len();
    same("mean", postures.mean.len(), n)?;
    for (value, joint) in postures.mean.iter().zip(joints) {
        in_range(&format!("mean of `{joint}`"), coordinate(joint), [*value])?;
    }
    covariance("covariance", &postures.covariance, n, POSTURE_VARIANCE)?;
    if let Some(about) = &postures.about_usual {
        covariance("about_usual", about, n, POSTURE_VARIANCE)?;
    }
    if let Some(low) = &postures.low {
        lowness(&low.lowness)?;
        covariance("low.about_usual", &low.about_usual, n, POSTURE_VARIANCE)?;
    }
    match postures.population.as_ref().and_then(super::population::Population::fault) {
        Some(fault) => Err(fault.to_owned()),
        None => Ok(()),
    }
}

fn noise(noise: &Noise, n: usize) -> Result<(), String> {
    same("factor", noise.factor.nrows(), n)?;
    if noise.factor.len() != n * noise.factor.ncols() {
        return Err("factor has not as many entries as rows and columns".to_owned());
    }
    in_range("factor", JOINT_SPEED_RAD_S, noise.factor.iter().copied())?;
    let shares = noise.shares;
    let parts = [shares.white, shares.correlated, shares.lasting];
    in_range("shares", SHARE, parts)?;
    if (parts.iter().sum::<f64>() - 1.0).abs() >= 1e-6 {
        return Err("noise times must be positive and its shares sum to 1".to_owned());
    }
    in_range("correlation_time_s", NOISE_S, [noise.correlation_time_s])?;
    in_range("white_interval_s", NOISE_S, [noise.white_interval_s])?;
    match noise.clock {
        Clock::Hand { speed_m_s, drift } => {
            in_range("clock.speed_m_s", HAND_SPEED_M_S, [speed_m_s])?;
            in_range("clock.drift.time_s", NOISE_S, [drift.time_s])?;
            let drifts = Range { low: 0.0, ..JOINT_SPEED_RAD_S };
            in_range("clock.drift.speed_rad_s", drifts, [drift.speed_rad_s])?;
        }
        Clock::Seconds { speed_share, speed_rms_m_s } => {
            in_range("clock.speed_share", SHARE, [speed_share])?;
            in_range("clock.speed_rms_m_s", HAND_SPEED_M_S, [speed_rms_m_s])?;
        }
    }
    let Some(low) = &noise.low else { return Ok(()) };
    lowness(&low.lowness)?;
    for (what, gains) in [("low.high", &low.high), ("low.low", &low.low)] {
        same(what, gains.len(), n)?;
        in_range(what, GAIN, gains.iter().copied())?;
    }
    Ok(())
}

fn lowness(at: &Lowness) -> Result<(), String> {
    in_range("lowness", OVER_STATURE, [at.from, at.to])?;
    in_range("lowness.ratio", LOWNESS_RATIO, [at.ratio])?;
    if at.from > at.to { Ok(()) } else { Err("lowness begins below where it ends".to_owned()) }
}

fn served(process: &Process, n: usize) -> Result<(), String> {
    if let Some(joint) = process.outputs().iter().find(|o| **o >= n) {
        return Err(format!("serves joint {joint} of a chain of {n}"));
    }
    Ok(())
}

fn primitive(own: &Primitive, n: usize) -> Result<(), String> {
    let count = own.root.len();
    if count == 0 {
        return Err("has no basis functions".to_owned());
    }
    if own.mean.shape() != (count, n) {
        return Err(format!("mean is {:?}, not {:?}", own.mean.shape(), (count, n)));
    }
    in_range("mean", JOINT_SPEED_RAD_S, own.mean.iter().copied())?;
    let columns = own.root.first().map_or(0, DMatrix::ncols);
    for (i, block) in own.root.iter().enumerate() {
        if block.shape() != (n, columns) {
            return Err(format!("root[{i}] is {:?}, not {:?}", block.shape(), (n, columns)));
        }
        in_range("root", JOINT_SPEED_RAD_S, block.iter().copied())?;
    }
    covariance("noise", &own.noise, n, SPEED_VARIANCE)
}

/// Modes are two or more, and each low movement is of one of them.
fn told_apart(modes: &Modes) -> Result<(), String> {
    in_range("modes.below", OVER_STATURE, [modes.below])?;
    counted("modes.people", modes.people)?;
    let is_share = |memberships: &[f64]| {
        memberships.len() == modes.all.len()
            && memberships.iter().all(|p| SHARE.holds(*p))
            && (memberships.iter().sum::<f64>() - 1.0).abs() < 1e-6
    };
    if modes.all.len() < 2
        || modes.low.is_empty()
        || !modes.low.iter().all(|m| is_share(&m.memberships))
    {
        return Err(
            "modes must be two or more, told apart by movements that each are of one".to_owned()
        );
    }
    for (i, movement) in modes.low.iter().enumerate() {
        in_range(&format!("modes.low[{i}].place"), OVER_STATURE, movement.place)?;
    }
    Ok(())
}

fn quality(of: &MethodQuality) -> Result<(), String> {
    let least_zero = Range { low: 0.0, ..FIGURE };
    in_range("relative_rmse", least_zero, [of.relative_rmse])?;
    in_range("rmse_rad_s", Range { low: 0.0, ..JOINT_SPEED_RAD_S }, [of.rmse_rad_s])?;
    in_range("log_likelihood_null", FIGURE, [of.log_likelihood_null])?;
    in_range("log_likelihood", FIGURE, [of.log_likelihood])?;
    in_range("trajectory_log_likelihood", FIGURE, of.trajectory_log_likelihood)?;
    let pair = |p: Option<(f64, f64)>| p.into_iter().flat_map(|(a, b)| [a, b]);
    let degrees = Range { low: 0.0, ..JOINT_DEG };
    in_range("path_error_deg", degrees, pair(of.path_error_deg))?;
    in_range("coverage", SHARE, pair(of.coverage))?;
    in_range("band_width_deg", degrees, of.band_width_deg)
}

fn provenance(p: &Provenance) -> Result<(), String> {
    counted("people", p.people)?;
    in_range("adapted_s", Range { low: 0.0, high: 1e7, unit: "s" }, p.adapted_s)?;
    if let Some((from, people)) = &p.filled_from {
        name("filled_from", from)?;
        counted("filled_from", *people)?;
    }
    let hashes = p.recordings.iter().chain([&p.body]);
    for (of, hash) in hashes {
        name("name", of)?;
        if hash.len() != 64 || !hash.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(format!("`{of}` has a SHA-256 that is none"));
        }
    }
    Ok(())
}

fn name(what: &str, name: &str) -> Result<(), String> {
    let is_plain = !name.trim().is_empty()
        && name.chars().count() <= LONGEST_NAME
        && !name.chars().any(char::is_control);
    if is_plain { Ok(()) } else { Err(format!("{what} is empty, too long, or cannot be printed")) }
}

fn counted(what: &str, count: usize) -> Result<(), String> {
    if (1..=MOST_COUNTED).contains(&count) {
        return Ok(());
    }
    Err(format!("{what} is {count}, not 1 to {MOST_COUNTED}"))
}

fn same(what: &str, found: usize, wanted: usize) -> Result<(), String> {
    if found == wanted { Ok(()) } else { Err(format!("{what}: {found} values, not {wanted}")) }
}

fn in_range(what: &str, range: Range, values: impl IntoIterator<Item = f64>) -> Result<(), String> {
    match range.outside(values) {
        Some(value) => Err(format!("{what}: {} is outside {range}", shown(value))),
        None => Ok(()),
    }
}

/// An n x n matrix that is symmetric and positive definite, with no variance above `most`.
fn covariance(what: &str, matrix: &DMatrix<f64>, n: usize, most: f64) -> Result<(), String> {
    if matrix.shape() != (n, n) {
        return Err(format!("{what} is {:?}, not {:?}", matrix.shape(), (n, n)));
    }
    let is_sound = matrix.iter().all(|v| v.is_finite())
        && (matrix - matrix.transpose()).amax() < SYMMETRY * matrix.amax()
        && matrix.clone().cholesky().is_some();
    if !is_sound {
        return Err(format!("{what} is not symmetric positive definite"));
    }
    if matrix.amax() > most {
        return Err(format!("{what} holds a variance of {}, above {most}", matrix.amax()));
    }
    Ok(())
}
