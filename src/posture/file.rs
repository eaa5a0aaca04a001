//! The file of a posture model: JSON with a schema, checked when read. Owner of `models/posture`.

use super::model::PostureModel;
use super::proof::prove;
use crate::files::{
    InputError, Memo, read_text, sealed_json, sha256_hex, suggest, take_seal, write_whole,
};
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

/// A model as the text of its file, with a checksum over its content.
pub fn model_text(model: &PostureModel) -> Result<String, InputError> {
    sealed_json(&Written { schema: MODEL_SCHEMA, model })
        .map_err(|e| InputError::fault("posture model", e.to_string()))
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
    let seal = take_seal(path, &mut value, remedy)?;
    if let Some(object) = value.as_object_mut() {
        object.remove("schema");
    }
    let model: PostureModel = serde_json::from_value(value).map_err(broken)?;
    prove(&model).map_err(|e| {
        InputError::new(path, format!("is not a model of a person: {e}")).remedy(remedy)
    })?;
    Ok((PostureModel { seal, ..model }, sha256_hex(text.as_bytes())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posture::Clock;

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
        assert!(prove(&mixed).unwrap_err().contains("clock"));
    }
}
