//! What a run finds besides its figures, as facts: what was chosen, what makes the figures doubtful,
//! what was not checked. How it is said is the business of [`crate::words`].

use super::checked::{Subject, Why};
use crate::ergonomics::{PairedDifference, PerMethod, ScoringMethod};
use crate::robot::AssumedShapes;
use crate::scenario::{EndMismatch, LowHand};
use serde::{Deserialize, Serialize};

/// How much a finding should weigh with the reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Part of the result.
    Note,
    /// Changes how figures should be read.
    Caution,
    /// The figures may mislead.
    Doubt,
}

/// One finding. Names of paths and bodies as in the result; lengths in m, times in s, shares in 0 to 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "finding", rename_all = "snake_case")]
pub enum Finding {
    /// The recordings support no statement about this body along the lead.
    NotSupported {
        /// Body.
        body: String,
        /// Share of the path beyond the training data.
        beyond: f64,
        /// Share of the start postures rarer than 1 in 100.
        unusual_starts: f64,
    },
    /// Part of the path is beyond the training data.
    BeyondData {
        /// Body.
        body: String,
        /// Share of the path.
        share: f64,
    },
    /// An end is so low that people bend their legs for it, which is not modelled.
    LowHand(LowHand),
    /// Start postures that are rare among the training postures.
    UnusualStarts {
        /// Body.
        body: String,
        /// Share of the starts.
        share: f64,
    },
    /// Something that could not be looked at.
    NotChecked {
        /// What.
        subject: Subject,
        /// Why.
        why: Why,
    },
    /// Links of the robot whose shapes are not known, and that were checked as assumed capsules.
    AssumedShapes(AssumedShapes),
    /// Repetitions whose hand cannot follow.
    OutOfReach {
        /// Body.
        body: String,
        /// Share of the repetitions.
        share: f64,
        /// First, s.
        from_s: f64,
    },
    /// Repetitions in which people would step, who stand still here.
    StepNeeded {
        /// Body.
        body: String,
        /// Share of the repetitions.
        share: f64,
    },
    /// Repetitions in which a part of the body goes into an obstacle.
    InFurniture {
        /// Body.
        body: String,
        /// Share of the repetitions.
        share: f64,
        /// Part of the body that goes deepest.
        part: String,
        /// Into which obstacle.
        obstacle: String,
        /// How deep in a bad repetition (95th percentile), m.
        depth_m: f64,
    },
    /// Another body than that of the verdict is worse in a figure.
    OtherBodyWorse {
        /// Body.
        body: String,
        /// By which method.
        method: ScoringMethod,
        /// Which figure.
        figure: Figure,
        /// Its value.
        value: f64,
        /// The value of the body of the verdict.
        verdict_value: f64,
    },
    /// The lead goes slowly through a part of its way.
    Lingers {
        /// From, s.
        from_s: f64,
        /// To, s.
        to_s: f64,
        /// Near, world, m.
        at_m: [f64; 3],
        /// Slower than, m/s.
        below_m_s: f64,
        /// Highest speed elsewhere, m/s.
        up_to_m_s: f64,
    },
    /// What a freedom is worth: without it minus with it, by RULA; none where the best path makes no
    /// use of it.
    Worth {
        /// Its name; none for all of them together.
        freedom: Option<String>,
        /// Body.
        body: String,
        /// Gain by the freedom.
        gain: Option<PairedDifference>,
    },
    /// Whether the task is repeated or held is open, and the answer matters.
    MuscleUseOpen {
        /// Body.
        body: String,
        /// Expected scores if it is.
        scores: PerMethod<f64>,
    },
    /// An assumption that moves the leading score much.
    Assumption {
        /// Index in the list of inputs.
        input: usize,
        /// Body.
        body: String,
        /// Expected score under the other assumption.
        score: f64,
    },
    /// A path on which clearly fewer repetitions reach action level 3 than on the best.
    FewerReachLevel3 {
        /// The path.
        path: String,
        /// Share of repetitions there.
        there: f64,
        /// And on the best.
        here: f64,
    },
    /// The user's own path breaks limits.
    BreaksLimits {
        /// The path.
        path: String,
    },
    /// A path with a lower objective than the best, which is not the best because it is clearly worse
    /// than the straight one in another figure.
    LowerMeanNotBest {
        /// The path.
        path: String,
    },
    /// Another path keeps another timing than the best, so that means over time do not compare routes.
    TimingDiffers {
        /// The path.
        path: String,
        /// Whether its route is that of the lead.
        same_route: bool,
        /// Lead minus other over hand travel, by RULA.
        per_metre: PairedDifference,
    },
    /// The user's path begins or ends elsewhere than the scenario; it is compared with nothing.
    OtherEnds {
        /// The path.
        path: String,
        /// How far off.
        off: EndMismatch,
    },
}

/// A figure of one body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Figure {
    /// Mean over repetitions and time.
    Expected,
    /// Share of time at action level 3 or above.
    High,
    /// 95th percentile over time, median over repetitions.
    Peak,
}

impl Figure {
    /// All figures that are compared between bodies.
    pub const ALL: [Self; 3] = [Self::Expected, Self::High, Self::Peak];
}

impl Finding {
    /// How much it should weigh.
    pub fn severity(&self) -> Severity {
        match self {
            Self::NotSupported { .. }
            | Self::NotChecked { .. }
            | Self::AssumedShapes(_)
            | Self::OtherEnds { .. }
            | Self::BreaksLimits { .. } => Severity::Doubt,
            Self::BeyondData { .. }
            | Self::UnusualStarts { .. }
            | Self::LowHand(_)
            | Self::OutOfReach { .. }
            | Self::StepNeeded { .. }
            | Self::InFurniture { .. }
            | Self::OtherBodyWorse { .. }
            | Self::MuscleUseOpen { .. }
            | Self::Assumption { .. }
            | Self::FewerReachLevel3 { .. }
            | Self::LowerMeanNotBest { .. }
            | Self::TimingDiffers { .. } => Severity::Caution,
            Self::Lingers { .. } | Self::Worth { .. } => Severity::Note,
        }
    }
}
