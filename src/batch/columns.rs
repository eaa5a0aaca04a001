//! The columns of the results: names, units, meaning and where each comes from, in one place.

use crate::ergonomics::ScoringMethod;
use crate::planner::{
    BodyScores, BodyStrain, CandidateResult, Comparison, MethodScores, PersonClearance, RunResult,
    Status,
};
use crate::robot::ObstacleClearance;
use serde::{Deserialize, Serialize};

/// What stands in a cell of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Not known, not checked or without meaning here.
    None,
    /// Yes or no.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// Text.
    Text(String),
}

impl Value {
    /// As a number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Whole(n) => Some(*n as f64),
            Self::Number(v) => Some(*v),
            _ => None,
        }
    }
}

impl From<f64> for Value {
    fn from(v: f64) -> Self {
        if v.is_finite() { Self::Number(v) } else { Self::None }
    }
}

impl From<usize> for Value {
    fn from(n: usize) -> Self {
        i64::try_from(n).map_or(Self::None, Self::Whole)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::None, Into::into)
    }
}

/// What all values of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// [`Value::Flag`].
    Flag,
    /// [`Value::Whole`].
    Whole,
    /// [`Value::Number`].
    Number,
    /// [`Value::Text`].
    Text,
}

/// A column of the results.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// Name, with the unit at its end where there is one.
    pub name: &'static str,
    /// What its values are.
    pub kind: Kind,
    /// Unit in words; empty for text and flags.
    pub unit: &'static str,
    /// What it says, for people.
    pub about: &'static str,
    /// Of one body along one path of a run.
    pub(super) of: fn(&Found) -> Value,
}

/// One body along one path of a run.
#[derive(Debug)]
pub(super) struct Found<'a> {
    pub result: &'a RunResult,
    pub path: &'a CandidateResult,
    pub body: &'a BodyScores,
}

impl Found<'_> {
    pub(super) fn is_lead(&self) -> bool {
        let lead = self.result.verdict.lead.as_ref();
        self.result.verdict.is_decided() && lead == Some(&self.path.id)
    }

    /// The comparison of the lead with this path, for this body.
    fn comparison(&self) -> Option<&Comparison> {
        let is = |c: &&Comparison| c.other == self.path.id && c.body == self.body.body;
        self.result.comparisons.iter().find(is)
    }

    fn size(&self) -> Option<&crate::human::BodySize> {
        let facts = self.result.setting.bodies.iter().find(|b| b.name == self.body.body)?;
        // Of a population there is no one size.
        facts.members.is_empty().then_some(&facts.size)
    }

    fn strain(&self, pick: impl Fn(&BodyStrain) -> Option<f64>) -> Value {
        self.body.strain.as_ref().and_then(pick).into()
    }

    fn person(&self, pick: impl Fn(&PersonClearance) -> f64) -> Value {
        self.body.person_clearance.as_ref().map(pick).into()
    }
}

/// Columns before those of the paths, which every row has: name and meaning.
pub(super) const OF_CELL: [(&str, &str); 3] = [
    ("cell", "Number of the cell, from 1, in the order of the batch file."),
    (
        "state",
        "How the cell ended: `ok`; `no_feasible_path` where no path keeps all limits; `not_supported` where the \
         recordings support no statement about the worker; `failed` where the run could not be made.",
    ),
    ("reason", "Why a cell has no path that may be used; empty where it has one."),
];

/// Columns after those of the paths.
pub(super) const AFTER: [(&str, &str); 2] = [
    ("program_version", "Version of ergopath that made the row."),
    (
        "key",
        "SHA-256 of all that the cell reads; its folder in `cells/` is named by the first 16 digits.",
    ),
];

/// Whether a factor may not have this name.
pub(super) fn is_taken(name: &str) -> bool {
    let fixed = OF_CELL.iter().chain(&AFTER).map(|(n, _)| *n);
    fixed.chain(COLUMNS.iter().map(|c| c.name)).any(|n| n == name)
}

/// The columns of bodies and paths, in order.
pub fn columns() -> &'static [Column] {
    COLUMNS
}

fn exposure(s: &MethodScores, k: usize) -> Value {
    s.distribution.exposure.get(k).copied().into()
}

fn at_least(s: &MethodScores, k: usize) -> Value {
    s.distribution.p_at_least.get(k).copied().into()
}

fn level(f: &Found, method: ScoringMethod, level: u8) -> Value {
    f.body.scores[method].levels.iter().find(|l| l.level == level).map(|l| l.share).into()
}

fn status(f: &Found) -> Value {
    match &f.path.status {
        Status::Feasible => "feasible",
        Status::Marked { .. } => "over_a_limit",
        Status::Infeasible { .. } => "infeasible",
    }
    .into()
}

fn obstacle(f: &Found) -> Value {
    match f.path.path.as_ref().map(|p| &p.clearance) {
        Some(ObstacleClearance::Least { nearest, .. }) => nearest.distance_m.into(),
        _ => Value::None,
    }
}

macro_rules! columns {
    ($($name:literal, $kind:ident, $unit:literal, $about:literal, $of:expr;)+) => {
        &[$(Column { name: $name, kind: Kind::$kind, unit: $unit, about: $about, of: $of },)+]
    };
}

use ScoringMethod::{Reba, Rula};

const COLUMNS: &[Column] = columns! {
    "station", Text, "", "The scenario's own name for the workstation.", |f| f.result.setting.name.as_str().into();
    "robot", Text, "", "Name of the robot.", |f| f.result.setting.robot.name.as_str().into();
    "posture_model", Text, "", "Name of the posture model.", |f| f.result.posture_model.name.as_str().into();
    "run_seed", Whole, "", "Seed of all randomness of the run.", |f| i64::try_from(f.result.provenance.seed).map_or(Value::None, Value::Whole);
    "load_kg", Number, "kg", "Load on the hand.", |f| f.result.setting.task.load_kg.into();
    "path", Text, "", "Name of the path in its run.", |f| f.path.id.as_str().into();
    "rank", Whole, "", "Rank of the path in its cell, 1 is best by the planner's objective; empty where the path may not be ranked.", |f| f.path.rank.into();
    "is_lead", Flag, "", "Whether the cell's verdict is about this path: the best one, or in `assess` the first of your own.", |f| Value::Flag(f.is_lead());
    "status", Text, "", "`feasible`; `over_a_limit` for a path of your own that breaks a limit and was scored all the same; `infeasible`.", status;
    "body", Text, "", "Name of the body.", |f| f.body.body.as_str().into();
    "is_worst_body", Flag, "", "Whether the verdict of the cell is about this body: the one that is worst in the objective.", |f| Value::Flag(f.result.verdict.body.as_ref() == Some(&f.body.body));
    "stature_m", Number, "m", "Stature; empty for a population.", |f| f.size().map(|s| s.stature_m).into();
    "body_mass_kg", Number, "kg", "Body mass; empty for a population.", |f| f.size().map(|s| s.mass_kg).into();
    "repetitions", Whole, "", "Simulated repetitions behind the row.", |f| f.body.rollouts.into();
    "people", Whole, "", "People who repeat in turn; empty where every repetition counts alone.", |f| f.body.rula().persons().into();
    "duration_s", Number, "s", "Duration of the path.", |f| f.path.path.as_ref().and_then(|p| Some(p.time_s.last()? - p.time_s.first()?)).into();
    "scenario_duration_s", Number, "s", "Duration that the scenario gives.", |f| f.result.setting.duration_s.into();
    "hand_travel_m", Number, "m", "Length of the hand's way.", |f| f.path.path.as_ref().map(|p| p.hand.travel_m).into();
    "objective", Number, "", "The planner's objective for the path; lower is better, and comparable only within one planner.", |f| f.path.objective.into();
    "rula_expected", Number, "", "Mean over repetitions of the time mean of RULA. A mean of whole-number scores: it ranks, it does not measure.", |f| f.body.rula().distribution.expected.into();
    "rula_expected_se", Number, "", "Monte Carlo standard error of `rula_expected`.", |f| f.body.rula().distribution.standard_error.into();
    "rula_p05", Number, "", "5th percentile over repetitions of the time mean of RULA.", |f| f.body.rula().distribution.p05.into();
    "rula_p95", Number, "", "95th percentile over repetitions of the time mean of RULA.", |f| f.body.rula().distribution.p95.into();
    "rula_cvar90", Number, "", "Mean of the worst tenth of the repetitions, RULA.", |f| f.body.rula().distribution.cvar90.into();
    "rula_peak", Number, "", "95th percentile of RULA over time, median over repetitions.", |f| f.body.rula().peak.into();
    "rula_per_metre", Number, "", "Mean of RULA over the hand's way; it does not depend on the timing.", |f| f.body.rula().per_metre.into();
    "time_share_rula_level_1", Number, "share", "Share of the time at RULA action level 1.", |f| level(f, Rula, 1);
    "time_share_rula_level_2", Number, "share", "Share of the time at RULA action level 2.", |f| level(f, Rula, 2);
    "time_share_rula_level_3", Number, "share", "Share of the time at RULA action level 3.", |f| level(f, Rula, 3);
    "time_share_rula_level_4", Number, "share", "Share of the time at RULA action level 4.", |f| level(f, Rula, 4);
    "time_share_rula_ge_5", Number, "share", "Share of the time at RULA 5 or more, action level 3 or above.", |f| exposure(f.body.rula(), 5);
    "time_share_rula_ge_5_p05", Number, "share", "5th percentile over repetitions of that share.", |f| f.body.rula().high_band[1].into();
    "time_share_rula_ge_5_p95", Number, "share", "95th percentile over repetitions of that share.", |f| f.body.rula().high_band[2].into();
    "p_rula_ge_3", Number, "share", "Share of repetitions with at least half a second at RULA 3 or more.", |f| at_least(f.body.rula(), 3);
    "p_rula_ge_5", Number, "share", "Share of repetitions with at least half a second at RULA 5 or more.", |f| at_least(f.body.rula(), 5);
    "p_rula_ge_5_se", Number, "share", "Monte Carlo standard error of `p_rula_ge_5`; 0 where no or every repetition counts, which with n repetitions still leaves up to 3/n open.", |f| f.body.rula().distribution.p_at_least_se.as_ref().and_then(|e| e.get(5).copied()).into();
    "p_rula_ge_7", Number, "share", "Share of repetitions with at least half a second at RULA 7.", |f| at_least(f.body.rula(), 7);
    "reba_expected", Number, "", "Mean over repetitions of the time mean of REBA.", |f| f.body.reba().distribution.expected.into();
    "reba_expected_se", Number, "", "Monte Carlo standard error of `reba_expected`.", |f| f.body.reba().distribution.standard_error.into();
    "reba_p05", Number, "", "5th percentile over repetitions of the time mean of REBA.", |f| f.body.reba().distribution.p05.into();
    "reba_p95", Number, "", "95th percentile over repetitions of the time mean of REBA.", |f| f.body.reba().distribution.p95.into();
    "time_share_reba_level_0", Number, "share", "Share of the time at REBA action level 0.", |f| level(f, Reba, 0);
    "time_share_reba_level_1", Number, "share", "Share of the time at REBA action level 1.", |f| level(f, Reba, 1);
    "time_share_reba_level_2", Number, "share", "Share of the time at REBA action level 2.", |f| level(f, Reba, 2);
    "time_share_reba_level_3", Number, "share", "Share of the time at REBA action level 3.", |f| level(f, Reba, 3);
    "time_share_reba_level_4", Number, "share", "Share of the time at REBA action level 4.", |f| level(f, Reba, 4);
    "p_reba_ge_8", Number, "share", "Share of repetitions with at least half a second at REBA 8 or more, action level 3 or above.", |f| at_least(f.body.reba(), 8);
    "lead_minus_this_rula", Number, "", "Expected RULA of the cell's lead minus that of this path, on the same repetitions; empty for the lead.", |f| f.comparison().map(|c| c.scores[Rula].time_mean.mean).into();
    "lead_minus_this_rula_low95", Number, "", "Lower end of its 95 % interval.", |f| f.comparison().map(|c| c.scores[Rula].time_mean.low95).into();
    "lead_minus_this_rula_high95", Number, "", "Upper end of its 95 % interval.", |f| f.comparison().map(|c| c.scores[Rula].time_mean.high95).into();
    "people_between_sd_rula", Number, "", "How far people differ: standard deviation of people's own expected RULA; empty where nobody repeats.", |f| f.body.rula().people.as_ref().map(|p| p.between_sd).into();
    "people_within_sd_rula", Number, "", "How far the repetitions of one person differ: their standard deviation.", |f| f.body.rula().people.as_ref().map(|p| p.within_sd).into();
    "people_at_high_share", Number, "share", "Share of people who are at RULA action level 3 or above for half a second in at least half of their repetitions.", |f| f.body.rula().people.as_ref().map(|p| p.at_high).into();
    "worst_person", Whole, "", "Number of the person with the highest mean RULA, from 1.", |f| f.body.worst_off.as_ref().map(|w| w.person).into();
    "worst_person_rula", Number, "", "Mean RULA of that person's repetitions.", |f| f.body.worst_off.as_ref().map(|w| w.score).into();
    "worst_person_stature_m", Number, "m", "That person's stature, in a population.", |f| f.body.worst_off.as_ref().and_then(|w| w.size.as_ref()).map(|s| s.stature_m).into();
    "reach_exceeded_share", Number, "share", "Share of repetitions in which the hand cannot follow the path.", |f| f.body.reach_exceeded.into();
    "beyond_training_share", Number, "share", "Share of the samples that the recordings do not support.", |f| f.body.extrapolation_share.into();
    "robot_person_least_m", Number, "m", "Least distance between robot and person over repetitions and time; empty where it was not checked.", |f| f.person(|p| p.min_m);
    "robot_person_nearer_share", Number, "share", "Share of repetitions in which the robot comes nearer to the person than the scenario allows; empty where it was not checked.", |f| f.person(|p| p.share_below);
    "robot_obstacle_least_m", Number, "m", "Least distance between robot and obstacles; empty where there is none or it was not checked.", obstacle;
    "trunk_flexion_deg", Number, "deg", "Largest flexion of the trunk to the vertical, median over repetitions.", |f| f.strain(|s| Some(s.trunk_flexion_deg.median));
    "knee_flexion_deg", Number, "deg", "Largest flexion of a knee, median over repetitions; empty where the legs are not predicted.", |f| f.strain(|s| Some(s.knee_flexion_deg?.median));
    "l5s1_peak_nm", Number, "N m", "Largest static moment about L5/S1, median over repetitions.", |f| f.strain(|s| Some(s.l5s1_peak_nm.median));
    "niosh_lifting_index", Number, "", "Lifting index of the revised NIOSH equation; for two hands only.", |f| f.strain(|s| s.niosh.as_ref()?.lifting_index);
    "stretched_share", Number, "share", "Share of repetitions that reach only just or not at all: people would step; empty where this is not predicted.", |f| f.strain(|s| s.stretched_share);
};

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_column_is_described_once_and_names_its_unit() {
        let mut seen = BTreeSet::new();
        for c in columns() {
            assert!(seen.insert(c.name) && is_taken(c.name), "{}", c.name);
            assert!(c.about.len() > 5 && c.about.ends_with('.'), "{}: {}", c.name, c.about);
            let ending = match c.unit {
                "m" => "_m",
                "s" => "_s",
                "kg" => "_kg",
                "deg" => "_deg",
                "N m" => "_nm",
                "share" | "" => "",
                other => panic!("{other}"),
            };
            assert!(c.name.ends_with(ending), "{} in {}", c.name, c.unit);
            assert_eq!(
                c.unit == "share",
                c.name.contains("share") || c.name.starts_with("p_"),
                "{}",
                c.name
            );
            for quoted in c.about.split('`').skip(1).step_by(2) {
                let is_column = columns().iter().any(|o| o.name == quoted);
                let is_value =
                    ["feasible", "over_a_limit", "infeasible", "assess"].contains(&quoted);
                assert!(is_column || is_value, "{}: `{quoted}`", c.name);
            }
        }
        assert!(!is_taken("layout") && is_taken("cell") && is_taken("key"));
    }

    #[test]
    fn values_come_back_from_their_text_as_they_were() {
        let all = vec![
            Value::None,
            Value::Flag(true),
            Value::Whole(5),
            Value::Number(5.0),
            Value::Number(0.1 + 0.2),
            Value::Text("5".into()),
            f64::NAN.into(),
        ];
        let text = serde_json::to_string(&all).unwrap();
        let back: Vec<Value> = serde_json::from_str(&text).unwrap();
        assert_eq!(back, all);
    }
}
