//! Planner presets: how many candidates and people, and what is made small. Owner of `planners/`.

use crate::files::{InputError, parse_toml, read_text, suggest};
use serde::{Deserialize, Serialize};
use std::path::Path;

const SCHEMA: &str = "ergopath/planner/1";
const SHIPPED: &[(&str, &str)] = &[
    ("default", include_str!("../../planners/default.toml")),
    ("quick", include_str!("../../planners/quick.toml")),
    ("careful", include_str!("../../planners/careful.toml")),
];

/// A planner's settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    schema: String,
    /// Name.
    pub name: String,
    /// Interior via-points of a candidate.
    pub vias: usize,
    /// Bend of the named families, m.
    pub named_offset_m: f64,
    /// Typical bend of sampled candidates, m (root mean square at mid-path).
    pub sampled_offset_m: f64,
    /// Sampled candidates.
    pub samples: usize,
    /// Time steps of a path.
    pub steps: usize,
    /// People per candidate in the search.
    pub rollouts_search: usize,
    /// Candidates that enter the selection.
    pub shortlist: usize,
    /// People in the selection and in the report.
    pub rollouts_final: usize,
    /// What is made small.
    pub objective: Objective,
}

/// Weights of the objective.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Objective {
    /// Of the expected RULA score.
    pub expected_rula: f64,
    /// Of the expected REBA score.
    pub expected_reba: f64,
    /// Of the mean of the worst tenth of people, RULA.
    pub cvar90_rula: f64,
    /// Of the share of time at RULA 5 or more.
    pub exposure_rula_5: f64,
}

/// Names of the shipped presets.
pub fn preset_names() -> Vec<&'static str> {
    SHIPPED.iter().map(|(n, _)| *n).collect()
}

/// A shipped preset by name, or a file.
pub fn load_preset(name_or_path: &str) -> Result<Preset, InputError> {
    if let Some((name, text)) = SHIPPED.iter().find(|(n, _)| *n == name_or_path) {
        return parse(Path::new(name), text);
    }
    let path = Path::new(name_or_path);
    if !path.is_file() && !name_or_path.contains(['/', '.']) {
        let names = preset_names();
        let help = suggest(name_or_path, names.iter().copied())
            .unwrap_or_else(|| format!("shipped planners: {}; or a file", names.join(", ")));
        let message = format!("there is no planner `{name_or_path}`");
        return Err(InputError::new(name_or_path, message).remedy(help));
    }
    parse(path, &read_text(path)?)
}

fn parse(path: &Path, text: &str) -> Result<Preset, InputError> {
    let preset: Preset = parse_toml(path, text)?;
    if preset.schema != SCHEMA {
        return Err(InputError::new(path, format!("schema is not `{SCHEMA}`")));
    }
    let o = &preset.objective;
    let weights = [o.expected_rula, o.expected_reba, o.cvar90_rula, o.exposure_rula_5];
    let counts = [
        ("vias", preset.vias, 1, 8),
        ("samples", preset.samples, 0, 100_000),
        ("steps", preset.steps, 10, 1000),
        ("rollouts_search", preset.rollouts_search, 1, 10_000),
        ("shortlist", preset.shortlist, 1, 1000),
        ("rollouts_final", preset.rollouts_final, 2, 100_000),
    ];
    for (key, value, low, high) in counts {
        if !(low..=high).contains(&value) {
            let message = format!("{key} = {value} is outside {low} to {high}");
            return Err(InputError::new(path, message));
        }
    }
    for (key, value) in
        [("named_offset_m", preset.named_offset_m), ("sampled_offset_m", preset.sampled_offset_m)]
    {
        if !(0.0..=2.0).contains(&value) {
            return Err(InputError::new(path, format!("{key} = {value} is outside 0 to 2 m")));
        }
    }
    if !weights.iter().all(|w| (0.0..=1e6).contains(w)) || weights.iter().sum::<f64>() <= 0.0 {
        return Err(InputError::new(path, format!("objective weights {weights:?} are not usable"))
            .remedy("weights are 0 or more, and at least one is above 0"));
    }
    Ok(preset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_file_is_compiled_in_and_valid() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("planners");
        let mut files = 0;
        for entry in folder.read_dir().unwrap() {
            let path = entry.unwrap().path();
            let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
            assert_eq!(load_preset(&stem).unwrap().name, stem);
            assert_eq!(load_preset(path.to_str().unwrap()).unwrap(), load_preset(&stem).unwrap());
            files += 1;
        }
        assert_eq!(files, SHIPPED.len());
        assert!(load_preset("defualt").is_err());
    }
}
