//! Whether a result that was read is one: the whole of it is proven before anything uses it.
//!
//! Every number lies in the range of what its name says it is ([`crate::physical`]); lists that belong together
//! are of one length; ids and bodies that are named are there. Faults name the member of the file.

use super::result::{BodyScores, CandidateResult, PathData, RunResult};
use crate::ergonomics::ScoringMethod;
use crate::physical::{ANGLE_DEG, FIGURE, Range, SHARE};
use serde_json::Value;
use std::collections::BTreeSet;

/// Distances, times and masses of a run, by the ends of their names.
const METRES: Range = Range { low: -200.0, high: 200.0, unit: "m" };
const MILLIMETRES: Range = Range { low: -2e5, high: 2e5, unit: "mm" };
const SECONDS: Range = Range { low: -1e5, high: 1e5, unit: "s" };
const KILOGRAMS: Range = Range { low: 0.0, high: 1e3, unit: "kg" };
/// Largest distance of a quaternion's norm from 1.
const NORM: f64 = 1e-3;
/// A seed is any whole number, and says nothing of a size.
const SEED: &str = "seed";

/// Why a result cannot be used; `value` is its JSON, of which every number is looked at.
pub(super) fn prove(result: &RunResult, value: &Value) -> Result<(), String> {
    numbers(value, "", "")?;
    let ids: BTreeSet<&str> = result.candidates.iter().map(|c| c.id.as_str()).collect();
    if ids.len() != result.candidates.len() {
        return Err("two paths have one id".to_owned());
    }
    let bodies: BTreeSet<&str> = result.setting.bodies.iter().map(|b| b.name.as_str()).collect();
    let verdict = &result.verdict;
    let compared = result.comparisons.iter().flat_map(|c| [&c.lead, &c.other]);
    for id in verdict.best.iter().chain(&verdict.lead).chain(compared) {
        if !ids.contains(id.as_str()) {
            return Err(format!("names a path `{id}`, which it does not hold"));
        }
    }
    let named = result.candidates.iter().flat_map(|c| c.bodies.iter().map(|b| &b.body));
    let compared = result.comparisons.iter().map(|c| &c.body);
    for body in verdict.body.iter().chain(named).chain(compared) {
        if !bodies.contains(body.as_str()) {
            return Err(format!("names a body `{body}`, which it does not hold"));
        }
    }
    for (k, moment) in result.moments.iter().enumerate() {
        let points = moment.mannequin.points_m.len();
        if !moment.mannequin.capsules.iter().all(|c| c.fits(points)) {
            return Err(format!("moments[{k}]: a piece of the mannequin has no point to lie at"));
        }
    }
    result
        .candidates
        .iter()
        .try_for_each(|c| candidate(c).map_err(|e| format!("path `{}`: {e}", c.id)))
}

fn candidate(c: &CandidateResult) -> Result<(), String> {
    if let Some(path) = &c.path {
        along(path)?;
    }
    c.bodies.iter().try_for_each(|b| scores(b).map_err(|e| format!("body `{}`: {e}", b.body)))
}

fn along(path: &PathData) -> Result<(), String> {
    let count = path.time_s.len();
    if path.tcp.len() != count {
        return Err(format!("{} places for {count} times", path.tcp.len()));
    }
    if path.time_s.windows(2).any(|t| t[1] <= t[0]) {
        return Err("its times do not rise".to_owned());
    }
    let norm = |t: &[f64; 7]| t[3..].iter().map(|v| v * v).sum::<f64>().sqrt();
    if path.tcp.iter().any(|t| (norm(t) - 1.0).abs() > NORM) {
        return Err("an orientation is no unit quaternion".to_owned());
    }
    let joints = path.robot_joints.len();
    if let Some(row) = path.robot_q.iter().find(|q| q.len() != joints) {
        return Err(format!("has a robot posture of {} values for {joints} joints", row.len()));
    }
    if !path.robot_q.is_empty() && path.robot_q.len() != count {
        return Err(format!("{} postures of the robot for {count} times", path.robot_q.len()));
    }
    Ok(())
}

fn scores(body: &BodyScores) -> Result<(), String> {
    for method in ScoringMethod::ALL {
        let s = &body.scores[method];
        let lists = [&s.by_rollout, &s.per_metre_by_rollout, &s.peak_by_rollout];
        if lists.iter().any(|l| l.len() > body.rollouts || l.len() != s.by_rollout.len()) {
            return Err("its lists of repetitions differ in length".to_owned());
        }
        let levels = usize::from(method.level(method.worst()) - method.level(1)) + 1;
        if s.levels.len() != levels {
            return Err(format!("{} action levels, not {levels}", s.levels.len()));
        }
        let times = s.parts.first().map_or(0, |p| p.over_time.len());
        if s.parts.iter().any(|p| p.over_time.len() != times) {
            return Err("its body parts differ in length over time".to_owned());
        }
    }
    Ok(())
}

/// Every number is one that a member of this name can hold.
fn numbers(value: &Value, place: &str, name: &str) -> Result<(), String> {
    match value {
        Value::Object(members) => members.iter().try_for_each(|(key, inner)| {
            let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
            numbers(inner, &place, key)
        }),
        Value::Array(items) => items.iter().enumerate().try_for_each(|(i, inner)| {
            // The place is made where it is needed only.
            numbers(inner, "", name).map_err(|e| format!("{place}[{i}]{e}"))
        }),
        Value::Number(number) if name != SEED => {
            let range = range_of(name);
            let v = number.as_f64().unwrap_or(f64::NAN);
            range.fault("", v).map_or(Ok(()), |fault| Err(format!("{place}:{fault}")))
        }
        _ => Ok(()),
    }
}

fn range_of(name: &str) -> Range {
    let is_share = ["share", "share_allowed", "share_below", "share_inside", "coverage"];
    let ends = |end: &str| name.ends_with(end);
    if is_share.contains(&name) || ends("_share") || name.starts_with("share_9") {
        SHARE
    } else if ends("_mm") {
        MILLIMETRES
    } else if ends("_m") {
        METRES
    } else if ends("_deg") {
        ANGLE_DEG
    } else if ends("_kg") {
        KILOGRAMS
    } else if ends("_s") && !ends("_m_s") && !ends("rad_s") && !ends("deg_s") {
        SECONDS
    } else {
        FIGURE
    }
}
