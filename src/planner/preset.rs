//! Planner presets: how many candidates and repetitions, and the objective. Owner of `planners/`.

use crate::ergonomics::ScoringMethod;
use crate::files::{InputError, parse_toml, read_text, suggest, toml_schema};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

const SCHEMA: &str = "ergopath/planner/1";
const SHIPPED: &[(&str, &str)] = &[
    ("default", include_str!("../../planners/default.toml")),
    ("quick", include_str!("../../planners/quick.toml")),
    ("careful", include_str!("../../planners/careful.toml")),
    ("tail", include_str!("../../planners/tail.toml")),
    ("whole_body", include_str!("../../planners/whole_body.toml")),
];

/// A planner's settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// Version of this format: `ergopath/planner/1`.
    #[schemars(extend("const" = SCHEMA))]
    schema: String,
    /// Name.
    pub name: String,
    /// Interior via-points of a candidate.
    pub vias: usize,
    /// Bend of the named families, m.
    pub named_offset_m: f64,
    /// Typical bend of sampled candidates, m (root mean square at mid-path).
    pub sampled_offset_m: f64,
    /// Paths of a generation of the search.
    pub population: usize,
    /// Generations of the search.
    pub generations: usize,
    /// Fresh starts within the generations.
    pub runs: usize,
    /// Generations of each baseline that searches: random, and the two with a single posture.
    pub baseline_generations: usize,
    /// Time steps of a path.
    pub steps: usize,
    /// People that every path of a generation meets.
    pub rollouts_first: usize,
    /// People that the best of a generation meet.
    pub rollouts_most: usize,
    /// Paths that enter the selection on fresh repetitions.
    pub shortlist: usize,
    /// Of these, paths that are reported.
    pub reported: usize,
    /// People in the last round of the selection, and in the report.
    pub rollouts_final: usize,
    /// Weights of the objective, which is minimised.
    pub objective: Objective,
}

/// Weights of the objective: one or more of scores, and secondary terms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Objective {
    /// Of the expected RULA score.
    pub expected_rula: f64,
    /// Of the expected REBA score.
    pub expected_reba: f64,
    /// Of the mean of the worst tenth of repetitions, RULA.
    pub cvar90_rula: f64,
    /// Of the share of time at RULA 5 or more.
    pub exposure_rula_5: f64,
    /// Of the share of repetitions at RULA 5 or more for at least half a second.
    #[serde(default)]
    pub p_level_3: f64,
    /// Of the root mean square joint speed of the person, per rad/s.
    #[serde(default)]
    pub effort: f64,
    /// Of the duration over the scenario's, where it is free.
    #[serde(default)]
    pub duration: f64,
    /// Of the missing share of the wanted clearance between robot and obstacles.
    #[serde(default)]
    pub clearance: f64,
    /// The wanted clearance, m.
    #[serde(default = "wanted")]
    pub clearance_wanted_m: f64,
}

/// Weights of the figures of one scoring method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodWeights {
    /// Of the mean over repetitions of the time mean.
    pub expected: f64,
    /// Of the mean of the worst tenth of these.
    pub cvar90: f64,
    /// Of the share of time at action level 3 or above.
    pub exposure: f64,
    /// Of the share of repetitions at action level 3 or above for at least half a second.
    pub p_high: f64,
}

impl MethodWeights {
    /// All of them.
    pub fn all(&self) -> [f64; 4] {
        [self.expected, self.cvar90, self.exposure, self.p_high]
    }
}

impl Objective {
    /// What the file gives for one scoring method.
    pub fn weights(&self, method: ScoringMethod) -> MethodWeights {
        match method {
            ScoringMethod::Rula => MethodWeights {
                expected: self.expected_rula,
                cvar90: self.cvar90_rula,
                exposure: self.exposure_rula_5,
                p_high: self.p_level_3,
            },
            ScoringMethod::Reba => MethodWeights {
                expected: self.expected_reba,
                cvar90: 0.0,
                exposure: 0.0,
                p_high: 0.0,
            },
        }
    }
}

fn wanted() -> f64 {
    0.05
}

/// JSON Schema (draft 7) of planner files.
pub fn planner_schema() -> serde_json::Value {
    toml_schema::<Preset>()
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
    let of_scores: Vec<f64> = ScoringMethod::ALL.iter().flat_map(|m| o.weights(*m).all()).collect();
    let secondary = [o.effort, o.duration, o.clearance];
    let counts = [
        ("vias", preset.vias, 1, 8),
        ("population", preset.population, 4, 1000),
        ("generations", preset.generations, 1, 4000),
        ("runs", preset.runs, 1, preset.generations.max(1)),
        ("baseline_generations", preset.baseline_generations, 1, 4000),
        ("steps", preset.steps, 10, 1000),
        ("rollouts_first", preset.rollouts_first, 1, 10_000),
        ("rollouts_most", preset.rollouts_most, preset.rollouts_first, 10_000),
        ("shortlist", preset.shortlist, 1, 1000),
        ("reported", preset.reported, 1, preset.shortlist),
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
    let is_weight = |w: &f64| (0.0..=1e6).contains(w);
    if !of_scores.iter().chain(&secondary).all(is_weight) || of_scores.iter().sum::<f64>() <= 0.0 {
        let weights = [&of_scores[..], &secondary].concat();
        return Err(InputError::new(path, format!("objective weights {weights:?} are not usable"))
            .remedy("weights are 0 or more, and at least one of a score is above 0"));
    }
    if !(1e-3..=1.0).contains(&o.clearance_wanted_m) {
        let message =
            format!("clearance_wanted_m = {} is outside 0.001 to 1", o.clearance_wanted_m);
        return Err(InputError::new(path, message));
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
