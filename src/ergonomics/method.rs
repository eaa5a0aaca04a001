//! The scoring methods by which paths are ranked and reported, and tables that hold one value for
//! each. A further score is registered here: everything above iterates over [`ScoringMethod::ALL`].

use super::action_levels::{ActionLevelShare, levels};
use super::exposure::ScoreDistribution;
use super::reba::{REBA_WORST, reba_action_level, reba_action_short, reba_action_words};
use super::rula::{RULA_WORST, rula_action_level, rula_action_short, rula_action_words};
use serde::{Deserialize, Serialize};
use std::ops::{Index, IndexMut};

/// A method that gives each posture a whole number, more being worse, and sorts the numbers into
/// action levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScoringMethod {
    /// Rapid Upper Limb Assessment, grand score 1 to 7.
    Rula,
    /// Rapid Entire Body Assessment, final score 1 to 15.
    Reba,
}

impl ScoringMethod {
    /// All of them, the one that leads the verdict first.
    pub const ALL: [Self; 2] = [Self::Rula, Self::Reba];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rula => "RULA",
            Self::Reba => "REBA",
        }
    }

    /// Its name in column names and keys.
    pub fn key(self) -> &'static str {
        match self {
            Self::Rula => "rula",
            Self::Reba => "reba",
        }
    }

    /// The highest score.
    pub fn worst(self) -> u8 {
        match self {
            Self::Rula => RULA_WORST,
            Self::Reba => REBA_WORST,
        }
    }

    /// The action level of a score.
    pub fn level(self, score: u8) -> u8 {
        match self {
            Self::Rula => rula_action_level(score),
            Self::Reba => reba_action_level(score),
        }
    }

    /// What an action level asks for.
    pub fn level_words(self, level: u8) -> &'static str {
        match self {
            Self::Rula => rula_action_words(level),
            Self::Reba => reba_action_words(level),
        }
    }

    /// The same in a word or two.
    pub fn level_short(self, level: u8) -> &'static str {
        match self {
            Self::Rula => rula_action_short(level),
            Self::Reba => reba_action_short(level),
        }
    }

    /// The lowest score of action level 3, from which on both methods ask for a change soon.
    pub fn high(self) -> u8 {
        (1..=self.worst()).find(|s| self.level(*s) >= 3).unwrap_or(self.worst())
    }

    /// A distribution by action level.
    pub fn levels(self, scores: &ScoreDistribution) -> Vec<ActionLevelShare> {
        levels(scores, self.worst(), |score| self.level(score), |level| self.level_words(level))
    }

    fn place(self) -> usize {
        match self {
            Self::Rula => 0,
            Self::Reba => 1,
        }
    }
}

/// One value for each scoring method.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "ByKey<T>", into = "ByKey<T>")]
#[serde(bound(serialize = "T: Serialize + Clone", deserialize = "T: Deserialize<'de>"))]
pub struct PerMethod<T>([T; 2]);

/// As it is written: by the methods' keys, all of them.
#[derive(Serialize, Deserialize)]
struct ByKey<T> {
    rula: T,
    reba: T,
}

impl<T> From<ByKey<T>> for PerMethod<T> {
    fn from(by_key: ByKey<T>) -> Self {
        Self([by_key.rula, by_key.reba])
    }
}

impl<T> From<PerMethod<T>> for ByKey<T> {
    fn from(PerMethod([rula, reba]): PerMethod<T>) -> Self {
        Self { rula, reba }
    }
}

impl<T> PerMethod<T> {
    /// Made one by one.
    pub fn of(value: impl FnMut(ScoringMethod) -> T) -> Self {
        Self(ScoringMethod::ALL.map(value))
    }

    /// Made one by one; `None` if one is missing.
    pub fn all(value: impl FnMut(ScoringMethod) -> Option<T>) -> Option<Self> {
        let [rula, reba] = ScoringMethod::ALL.map(value);
        Some(Self([rula?, reba?]))
    }

    /// Each method with its value.
    pub fn iter(&self) -> impl Iterator<Item = (ScoringMethod, &T)> {
        ScoringMethod::ALL.into_iter().map(|m| (m, &self[m]))
    }

    /// Every value turned into another.
    pub fn map<U>(self, mut to: impl FnMut(T) -> U) -> PerMethod<U> {
        PerMethod(self.0.map(&mut to))
    }
}

impl<T> Index<ScoringMethod> for PerMethod<T> {
    type Output = T;

    fn index(&self, method: ScoringMethod) -> &T {
        &self.0[method.place()]
    }
}

impl<T> IndexMut<ScoringMethod> for PerMethod<T> {
    fn index_mut(&mut self, method: ScoringMethod) -> &mut T {
        &mut self.0[method.place()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_third_action_level_begins_at_5_and_8() {
        let high = PerMethod::of(ScoringMethod::high);
        assert_eq!((high[ScoringMethod::Rula], high[ScoringMethod::Reba]), (5, 8));
    }

    #[test]
    fn values_are_written_by_key_and_none_may_be_missing() {
        let names = PerMethod::of(|m| m.name().to_owned());
        let text = serde_json::to_string(&names).unwrap();
        assert_eq!(text, r#"{"rula":"RULA","reba":"REBA"}"#);
        assert_eq!(serde_json::from_str::<PerMethod<String>>(&text).unwrap(), names);
        assert!(serde_json::from_str::<PerMethod<String>>(r#"{"rula":"x"}"#).is_err());
        let keys: Vec<&str> = names.iter().map(|(m, _)| m.key()).collect();
        assert_eq!(keys, ["rula", "reba"]);
    }
}
