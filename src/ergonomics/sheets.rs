//! One posture on the sheets of all scoring methods, and what their steps do over many repetitions.

use super::drivers::{
    StepShare, reba_step_courses, reba_step_shares, rula_step_courses, rula_step_shares,
};
use super::method::{PerMethod, ScoringMethod};
use super::profile::Profile;
use super::reba::{RebaSteps, reba};
use super::rula::{RulaSteps, rula};
use super::worksheet::Worksheet;

/// A posture on the sheets of all scoring methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheet {
    /// By RULA.
    pub rula: RulaSteps,
    /// By REBA.
    pub reba: RebaSteps,
}

impl Sheet {
    /// Scores a filled-in worksheet.
    pub fn of(worksheet: &Worksheet, profile: &Profile) -> Self {
        Self { rula: rula(worksheet, profile), reba: reba(worksheet, profile) }
    }

    /// The score by one method.
    pub fn total(&self, method: ScoringMethod) -> u8 {
        match method {
            ScoringMethod::Rula => self.rula.grand,
            ScoringMethod::Reba => self.reba.total,
        }
    }

    /// The scores by all methods.
    pub fn totals(&self) -> PerMethod<u8> {
        PerMethod::of(|m| self.total(m))
    }
}

/// A step of a method over all repetitions, and its mean score at each time.
#[derive(Debug, Clone, PartialEq)]
pub struct StepOverTime {
    /// What it does to the expected score.
    pub share: StepShare,
    /// Mean score at each time, over the repetitions that have not exceeded their reach.
    pub course: Vec<f64>,
}

/// The steps of a method in the order of its sheet: `sheets[r][i]` is that of repetition `r` at time
/// `i`, `None` once its reach is exceeded. See [`rula_step_shares`].
pub fn steps_over_time(
    method: ScoringMethod,
    sheets: &[Vec<Option<Sheet>>],
    profile: &Profile,
) -> Vec<StepOverTime> {
    let (shares, courses) = match method {
        ScoringMethod::Rula => {
            let steps = each(sheets, |s| s.rula);
            (rula_step_shares(&steps, profile.rula_table_a), rula_step_courses(&steps))
        }
        ScoringMethod::Reba => {
            let steps = each(sheets, |s| s.reba);
            (reba_step_shares(&steps), reba_step_courses(&steps))
        }
    };
    shares.into_iter().zip(courses).map(|(share, course)| StepOverTime { share, course }).collect()
}

fn each<T>(sheets: &[Vec<Option<Sheet>>], of: impl Fn(&Sheet) -> T) -> Vec<Vec<Option<T>>> {
    sheets.iter().map(|r| r.iter().map(|s| s.as_ref().map(&of)).collect()).collect()
}
