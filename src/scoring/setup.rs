//! What no motion shows: load, coupling, support, stance; and where every input comes from.

use super::motion::{Motion, MotionKind};
use super::standards::LiftAsked;
use crate::ergonomics::{Profile, Shown, TaskInputs};
use crate::human::{Hands, Side, Stance};
use crate::scenario::{Origin, OtherArm, Scenario};
use crate::survey::NeckRule;
use serde::Serialize;

/// How the head is held in the sheets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Neck {
    /// As the motion shows it.
    Measured,
    /// In line with the trunk.
    Neutral,
    /// Turned to the hand.
    Gaze,
}

/// Inputs given with the command or the scenario; `None` is not given.
#[derive(Debug, Clone, Default)]
#[allow(clippy::struct_excessive_bools, reason = "a worksheet is a list of boxes to tick")]
pub struct Declared {
    /// Load on the hand, kg.
    pub load_kg: Option<f64>,
    /// REBA's coupling, 0 good to 3 unacceptable.
    pub coupling: Option<u8>,
    /// Cycles a minute.
    pub cycles_per_min: Option<f64>,
    /// Longest hold, s.
    pub hold_s: Option<f64>,
    /// Shock, or force that builds up rapidly.
    pub shock: bool,
    /// The arm's weight is supported, or the person leans.
    pub arm_supported: bool,
    /// The person sits.
    pub seated: bool,
    /// A backrest supports the trunk.
    pub trunk_supported: bool,
    /// Legs or feet not evenly loaded.
    pub legs_unbalanced: bool,
    /// How the head is held; by default as measured, else neutral.
    pub neck: Option<Neck>,
    /// A coupled side whose other arm hangs, as a scenario says.
    pub hanging: Option<Side>,
    /// Ask for the lifting equation.
    pub lift: Option<LiftAsked>,
}

impl Declared {
    /// What a scenario declares.
    pub fn of(scenario: &Scenario) -> Self {
        let (t, w) = (&scenario.task, &scenario.worker);
        let given = |o: Origin| o == Origin::FromTheTask;
        Self {
            load_kg: given(t.load_origin).then_some(t.load_kg),
            coupling: given(t.coupling_origin).then_some(t.coupling),
            cycles_per_min: t.cycles_per_min,
            hold_s: t.hold_s,
            shock: t.shock,
            arm_supported: w.arm_supported,
            seated: matches!(w.stance, Stance::Seated { .. }),
            trunk_supported: w.trunk_supported,
            legs_unbalanced: false,
            neck: match w.neck {
                NeckRule::Predicted | NeckRule::Looking => None,
                NeckRule::Neutral => Some(Neck::Neutral),
                NeckRule::Gaze => Some(Neck::Gaze),
            },
            lift: None,
            hanging: (w.other_arm != OtherArm::Unknown && w.hands != Hands::Both)
                .then(|| w.hands.lead().other()),
        }
    }

    /// How the head is held for a motion.
    pub fn neck_for(&self, motion: &Motion) -> Neck {
        match self.neck {
            Some(Neck::Measured) | None if motion.has_neck() => Neck::Measured,
            Some(rule) if rule != Neck::Measured => rule,
            _ => Neck::Neutral,
        }
    }

    /// The part of the sheet that no motion shows. Muscle use and activity are left open.
    pub fn task(&self) -> TaskInputs {
        TaskInputs {
            load_kg: self.load_kg.unwrap_or(0.0),
            load_shock: self.shock,
            coupling: self.coupling.unwrap_or(0),
            sitting: self.seated,
            trunk_supported: self.trunk_supported,
            legs_unbalanced: self.legs_unbalanced,
            arm_supported: self.arm_supported,
            ..TaskInputs::default()
        }
    }
}

/// One input of the sheets.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Input {
    /// Its name in plain words.
    pub input: String,
    /// Where it comes from.
    pub origin: Origin,
    /// Its value in words.
    pub value: String,
}

/// An answer to one question about time: from the motion, the task, or nobody.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Answer {
    /// What enters the sheets.
    pub is: bool,
    /// Where it comes from; assumed where it stays open.
    pub origin: Origin,
}

impl Answer {
    /// The motion or the task may say yes; no needs one of the two to say so.
    pub fn new(shown: Shown, task: Option<bool>, of_motion: Origin) -> Self {
        match (shown, task) {
            (Shown::Yes, _) => Self { is: true, origin: of_motion },
            (_, Some(true)) => Self { is: true, origin: Origin::FromTheTask },
            (Shown::No, _) => Self { is: false, origin: of_motion },
            (Shown::TooShort, Some(false)) => Self { is: false, origin: Origin::FromTheTask },
            (Shown::TooShort, None) => Self { is: false, origin: Origin::Assumed },
        }
    }
}

/// Muscle use and activity of one side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Use {
    /// A posture held for longer than 1 min.
    pub held: Answer,
    /// Repeated more than 4 times a minute.
    pub repeated: Answer,
    /// Rapid large changes of posture.
    pub rapid: Answer,
}

impl Use {
    /// Whether RULA's muscle use stays open, so that both totals are to be shown.
    pub fn is_open(&self) -> bool {
        let open = |a: Answer| a.origin == Origin::Assumed;
        !self.held.is && !self.repeated.is && (open(self.held) || open(self.repeated))
    }

    /// Entered into a task.
    #[must_use]
    pub fn enter(&self, task: TaskInputs) -> TaskInputs {
        TaskInputs {
            static_gt_1min: self.held.is,
            repeated_gt_4min: self.repeated.is,
            rapid_large_changes: self.rapid.is,
            load_static_or_repeated: self.held.is || self.repeated.is,
            ..task
        }
    }
}

/// All inputs of the sheets of one side with their origins.
pub fn inputs(
    motion: &Motion,
    declared: &Declared,
    side: Side,
    muscle: &Use,
    profile: &Profile,
) -> Vec<Input> {
    let mut all = posture_inputs(motion, declared, side);
    let line = |input: &str, origin: Origin, value: String| Input {
        input: input.to_owned(),
        origin,
        value,
    };
    let given = |given: bool| if given { Origin::FromTheTask } else { Origin::Assumed };
    let yes = |b: bool| if b { "yes" } else { "no" }.to_owned();
    let coupling = ["good", "fair", "poor", "unacceptable"];
    let load = declared.load_kg.unwrap_or(0.0);
    let class = usize::from(declared.coupling.unwrap_or(0)).min(3);
    all.extend([
        line("load on the hand", given(declared.load_kg.is_some()), format!("{} kg", grams(load))),
        line("shock or rapid build-up of force", given(declared.shock), yes(declared.shock)),
        line("coupling", given(declared.coupling.is_some()), coupling[class].to_owned()),
        line("arm supported", given(declared.arm_supported), yes(declared.arm_supported)),
        line("posture held > 1 min", muscle.held.origin, open_or(muscle.held)),
        line("repeated > 4 a minute", muscle.repeated.origin, open_or(muscle.repeated)),
        line("rapid large changes", muscle.rapid.origin, yes(muscle.rapid.is)),
        line(
            "convention",
            given(*profile != Profile::default()),
            format!("profile {}", profile.name),
        ),
    ]);
    all
}

/// A load in kg to the gram, without the digits of rounding.
pub(super) fn grams(load_kg: f64) -> f64 {
    (load_kg * 1e3).round() / 1e3
}

fn open_or(answer: Answer) -> String {
    match answer {
        Answer { origin: Origin::Assumed, .. } => "open: too short to show it; totals for 0 and 1",
        Answer { is: true, .. } => "yes",
        Answer { is: false, .. } => "no",
    }
    .to_owned()
}

fn posture_inputs(motion: &Motion, declared: &Declared, side: Side) -> Vec<Input> {
    let line = |input: String, origin: Origin, value: &str| Input {
        input,
        origin,
        value: value.to_owned(),
    };
    let from = match motion.kind {
        MotionKind::Recording => "body fitted to the recording",
        MotionKind::JointAngles => "joint angles of the file",
        MotionKind::Rollouts => "posture model, sampled",
    };
    let mut all = vec![line("trunk".to_owned(), motion.origin, from)];
    for s in [Side::Right, Side::Left] {
        let name = format!("{} arm", s.name());
        all.push(if motion.has_arm(s) {
            line(name, motion.origin, from)
        } else if declared.hanging == Some(s) {
            line(name, Origin::FromTheTask, "hanging")
        } else {
            line(name, Origin::Unknown, "not scored")
        });
    }
    all.push(match declared.neck_for(motion) {
        Neck::Measured if motion.kind == MotionKind::Recording => {
            line("neck".to_owned(), motion.origin, "recorded head against recorded chest")
        }
        Neck::Measured => line("neck".to_owned(), motion.origin, from),
        rule => {
            let origin = if declared.neck.is_some_and(|n| n == rule) {
                Origin::FromTheTask
            } else {
                Origin::Assumed
            };
            let value = if rule == Neck::Gaze {
                format!("head turned to the {} hand", side.name())
            } else {
                "in line with the trunk".to_owned()
            };
            line("neck".to_owned(), origin, &value)
        }
    });
    all.push(if declared.seated {
        line("legs".to_owned(), Origin::FromTheTask, "sitting")
    } else if motion.has_knees() {
        let from = match motion.kind {
            MotionKind::Recording => "recorded joint centres; the more bent knee",
            _ => from,
        };
        line("knees".to_owned(), motion.origin, from)
    } else {
        line("knees".to_owned(), Origin::Assumed, "straight")
    });
    let (balance, origin) = if declared.legs_unbalanced {
        ("unevenly loaded", Origin::FromTheTask)
    } else if motion.has_heels() {
        ("evenly loaded; unstable while both heels are up", motion.origin)
    } else {
        ("evenly loaded", Origin::Assumed)
    };
    all.push(line("legs and feet".to_owned(), origin, balance));
    let backrest = if declared.trunk_supported { Origin::FromTheTask } else { Origin::Assumed };
    if declared.seated {
        let value = if declared.trunk_supported { "yes" } else { "no" };
        all.push(line("trunk supported by a backrest".to_owned(), backrest, value));
    }
    all
}
