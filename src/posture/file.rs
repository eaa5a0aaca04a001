//! The file of a posture model: JSON with a schema, checked when read. Owner of `models/posture`.

use super::attraction::{Attraction, Pull};
use super::law::PostureLaw;
use super::model::{PostureDistribution, PostureModel};
use super::modes::LowMovement;
use super::noise::Clock;
use super::population::Population;
use super::standing::StandingPlace;
use crate::files::{InputError, Memo, read_text, sha256_hex, suggest, write_whole};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Schema id and version; a reader refuses any other.
pub const MODEL_SCHEMA: &str = "ergopath/posture-model/3";

/// Models that ship inside the program.
const SHIPPED: &[(&str, &str)] = &[
    ("demo_operator", include_str!("../../models/posture/demo_operator.json")),
    ("whole_operator", include_str!("../../models/posture/whole_operator.json")),
    // Of another licence than the program: see models/posture/people.md.
    ("people", include_str!("../../models/posture/people.json")),
];

#[derive(Serialize)]
struct Written<'a> {
    schema: &'static str,
    #[serde(flatten)]
    model: &'a PostureModel,
}

#[derive(Deserialize)]
struct Head {
    schema: Option<String>,
}

/// A model as the text of its file.
pub fn model_text(model: &PostureModel) -> Result<String, InputError> {
    let text = serde_json::to_string(&Written { schema: MODEL_SCHEMA, model })
        .map_err(|e| InputError::fault("posture model", e.to_string()))?;
    Ok(text + "\n")
}

/// Writes a model whole or not at all.
pub fn save_model(model: &PostureModel, path: &Path) -> Result<(), InputError> {
    write_whole(path, model_text(model)?.as_bytes())
}

/// Reads a shipped model by name or a file (relative to `folder`), with the SHA-256 of its text.
pub fn load_model(name_or_path: &str, folder: &Path) -> Result<(PostureModel, String), InputError> {
    if let Some((name, text)) = SHIPPED.iter().find(|(n, _)| *n == name_or_path) {
        return parse(Path::new(name), text);
    }
    let path = folder.join(name_or_path);
    if !path.is_file() && !name_or_path.contains(['/', '.']) {
        let names: Vec<&str> = SHIPPED.iter().map(|(n, _)| *n).collect();
        let help = suggest(name_or_path, names.iter().copied()).unwrap_or_else(|| {
            format!("shipped models: {}; or the path of a trained model", names.join(", "))
        });
        let message = format!("there is no shipped posture model `{name_or_path}`");
        return Err(InputError::new(name_or_path, message).remedy(help));
    }
    parse(&path, &read_text(&path)?)
}

fn parse(path: &Path, text: &str) -> Result<(PostureModel, String), InputError> {
    static KNOWN: Memo<(PostureModel, String)> = Memo::new();
    KNOWN.of(&[&path.to_string_lossy(), text], || parse_anew(path, text))
}

fn parse_anew(path: &Path, text: &str) -> Result<(PostureModel, String), InputError> {
    let remedy = "train it again with this version: ergopath train RECORDING --body BODY -o MODEL";
    let broken = |e: serde_json::Error| {
        InputError::new(path, format!("is not a posture model: {e}")).remedy(remedy)
    };
    let head: Head = serde_json::from_str(text).map_err(broken)?;
    match head.schema.as_deref() {
        Some(MODEL_SCHEMA) => {}
        other => {
            let found = other.unwrap_or("none");
            let message = format!("schema `{found}` is not `{MODEL_SCHEMA}`");
            return Err(InputError::new(path, message).remedy(remedy));
        }
    }
    let mut value: serde_json::Value = serde_json::from_str(text).map_err(broken)?;
    if let Some(object) = value.as_object_mut() {
        object.remove("schema");
    }
    let model: PostureModel = serde_json::from_value(value).map_err(broken)?;
    check(&model).map_err(|e| InputError::new(path, e).remedy(remedy))?;
    Ok((model, sha256_hex(text.as_bytes())))
}

fn check(model: &PostureModel) -> Result<(), String> {
    let n = model.joints.len();
    check_way(&model.law, &model.postures, n)?;
    if let Some(fault) = model.postures.population.as_ref().and_then(Population::fault) {
        return Err(fault.to_owned());
    }
    if let Some(fault) = model.standing.as_ref().and_then(StandingPlace::fault) {
        return Err(fault.to_owned());
    }
    let Some(modes) = &model.modes else { return Ok(()) };
    for mode in &modes.all {
        check_way(&mode.law, &mode.postures, n).map_err(|e| format!("mode: {e}"))?;
    }
    let is_share = |m: &LowMovement| {
        m.memberships.len() == modes.all.len()
            && m.memberships.iter().all(|p| (0.0..=1.0).contains(p))
            && (m.memberships.iter().sum::<f64>() - 1.0).abs() < 1e-6
            && m.place.iter().all(|x| x.is_finite())
    };
    if modes.all.len() < 2 || modes.low.is_empty() || !modes.low.iter().all(is_share) {
        return Err(
            "modes must be two or more, told apart by movements that each are of one".to_owned()
        );
    }
    Ok(())
}

/// A law with its postures, of `n` joints.
fn check_way(law: &PostureLaw, postures: &PostureDistribution, n: usize) -> Result<(), String> {
    let shapes = [
        ("weight", law.weight.shape(), (n, n)),
        ("posture covariance", postures.covariance.shape(), (n, n)),
        ("posture mean", postures.mean.shape(), (n, 1)),
        ("noise factor", (law.noise.factor.nrows(), 0), (n, 0)),
    ];
    for (what, found, wanted) in shapes {
        if found != wanted {
            return Err(format!("{what} is {found:?}, not {wanted:?}"));
        }
    }
    let positive = |m: &DMatrix<f64>| {
        m.iter().all(|v| v.is_finite())
            && (m - m.transpose()).amax() < 1e-9 * m.amax()
            && m.clone().cholesky().is_some()
    };
    let low = postures.low.as_ref().map(|low| (&low.lowness, &low.about_usual));
    let about: Vec<&DMatrix<f64>> =
        postures.about_usual.iter().chain(low.map(|(_, about)| about)).collect();
    if about.iter().any(|m| m.shape() != (n, n)) {
        return Err(format!("covariance about usual postures is not {:?}", (n, n)));
    }
    let matrices = [("weight", &law.weight), ("posture covariance", &postures.covariance)];
    let about = about.into_iter().map(|m| ("covariance about usual postures", m));
    for (what, matrix) in matrices.into_iter().chain(about) {
        if !positive(matrix) {
            return Err(format!("{what} is not symmetric positive definite"));
        }
    }
    let noise = &law.noise;
    let shares = noise.shares;
    let parts = [shares.white, shares.correlated, shares.lasting];
    let heights =
        low.map(|(lowness, _)| lowness).into_iter().chain(noise.low.as_ref().map(|l| &l.lowness));
    let gains: Vec<f64> =
        noise.low.iter().flat_map(|low| low.high.iter().chain(&low.low).copied()).collect();
    if noise.low.as_ref().is_some_and(|low| low.high.len() != n || low.low.len() != n) {
        return Err(format!("noise at low hands is not of {n} joints"));
    }
    // NaN is in no range.
    let is_clock_sound = match noise.clock {
        Clock::Hand { speed_m_s, drift } => {
            speed_m_s > 0.0 && drift.speed_rad_s >= 0.0 && drift.time_s > 0.0
        }
        Clock::Seconds { speed_share, speed_rms_m_s } => {
            speed_rms_m_s > 0.0 && (0.0..=1.0).contains(&speed_share)
        }
    };
    let is_sound = noise.correlation_time_s > 0.0
        && noise.white_interval_s > 0.0
        && is_clock_sound
        && heights.into_iter().all(|h| h.from > h.to)
        && gains.into_iter().all(|g| g.is_finite() && g >= 0.0)
        && parts.iter().all(|p| (0.0..=1.0).contains(p))
        && (shares.white + shares.correlated + shares.lasting - 1.0).abs() < 1e-6;
    if !is_sound {
        return Err("noise times must be positive and its shares sum to 1".to_owned());
    }
    match (law.attraction.as_ref().map(Attraction::pull), noise.clock) {
        (Some(Pull::Metre { length_m }), Clock::Hand { .. }) if length_m > 0.0 => {}
        (Some(Pull::Second { rate_per_s }), Clock::Seconds { .. }) if rate_per_s > 0.0 => {}
        (None, _) => {}
        _ => return Err("the pull does not go by the clock of the noise".to_owned()),
    }
    if !(law.stature_m > 0.0 && (1..=6).contains(&law.task_rows)) {
        return Err("stature and task rows are out of range".to_owned());
    }
    if law.processes.iter().any(|p| p.outputs().iter().any(|o| *o >= n)) {
        return Err(format!("a process serves a joint beyond the {n} of the chain"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_older_model_is_refused_with_the_remedy() {
        let (_, text) = SHIPPED[0];
        let older = text.replacen(MODEL_SCHEMA, "ergopath/posture-model/2", 1);
        assert_ne!(older, text);
        let error = parse(Path::new("anna.json"), &older).unwrap_err().to_string();
        assert!(error.contains("anna.json") && error.contains("posture-model/2"), "{error}");
        let (model, _) = parse(Path::new("anna.json"), text).unwrap();
        // A pull by time has no place beside noise that goes by the hand.
        let mut mixed = model;
        let by_time = Clock::Seconds { speed_share: 0.5, speed_rms_m_s: 0.3 };
        mixed.law.noise.clock = by_time;
        assert!(check(&mixed).unwrap_err().contains("clock"));
    }
}
