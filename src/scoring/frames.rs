//! Every frame of a motion on a sheet of its own, for one side; and the table of all frames.

use super::motion::{Motion, Track};
use super::parts::{PARTS, Part};
use super::setup::{Answer, Declared, Neck, Use};
use crate::ergonomics::{
    ArmAngles, BackAngle, Clock, PartTimeline, Profile, RebaSteps, RulaSteps, Shown, TaskInputs,
    TimeRules, TrunkNeckAngles, Worksheet, reba, rula, worksheet,
};
use crate::files::InputError;
use crate::human::Side;
use crate::math::Vec3;
use crate::survey::WholePosture;

/// One posture of one side, on its sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Time, s.
    pub time_s: f64,
    /// Trunk, and neck by the rule in force.
    pub body: TrunkNeckAngles,
    /// The arm.
    pub arm: ArmAngles,
    /// Knee flexion, the larger of both, deg.
    pub knee_deg: f64,
    /// Whether both heels are up, so that the fore-feet alone carry.
    pub is_on_toes: bool,
    /// Horizontal distance of the wrist from L5/S1, m.
    pub reach_m: f64,
    /// The wrist in the world, m.
    pub hand_m: Vec3,
    /// Point midway between the ankles in the world, m.
    pub ankles_m: Vec3,
    /// Forward direction of the pelvis.
    pub facing: Vec3,
    /// The spine's joints added up.
    pub back: BackAngle,
    /// The filled-in sheet.
    pub sheet: Worksheet,
    /// RULA.
    pub rula: RulaSteps,
    /// REBA.
    pub reba: RebaSteps,
}

/// One track of one side.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredTrack {
    /// Name of the track.
    pub name: String,
    /// Its frames.
    pub frames: Vec<Frame>,
    /// Time that each frame stands for, s.
    pub weights_s: Vec<f64>,
    /// Observed time, s.
    pub observed_s: f64,
    /// Further frames in which the hand could not follow.
    pub exceeded: usize,
    /// Body parts over time, in the order of [`PARTS`].
    pub parts: Vec<PartTimeline>,
    /// Gaps in time.
    pub gaps: usize,
}

/// All tracks of one side.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoredSide {
    /// Which side.
    pub side: Side,
    /// Muscle use and activity.
    pub muscle: Use,
    /// Everything else that no motion shows.
    pub task: TaskInputs,
    /// Trials or rollouts.
    pub tracks: Vec<ScoredTrack>,
}

/// Scores a side; `None` where nobody measured, predicted or declared its arm.
pub fn score_side(
    motion: &Motion,
    side: Side,
    declared: &Declared,
    profile: &Profile,
    rules: TimeRules,
) -> Option<ScoredSide> {
    let is_hanging = !motion.has_arm(side) && declared.hanging == Some(side);
    if !motion.has_arm(side) && !is_hanging {
        return None;
    }
    let mut task = declared.task();
    if is_hanging {
        task = TaskInputs {
            load_kg: 0.0,
            load_shock: false,
            coupling: 0,
            arm_supported: false,
            ..task
        };
    }
    let neck = declared.neck_for(motion);
    let look = Look { side, neck, task, profile };
    let mut tracks: Vec<ScoredTrack> =
        motion.tracks.iter().map(|t| scored_track(t, &look, rules)).collect();
    let muscle = muscle_use(&tracks, declared, motion.origin);
    let task = muscle.enter(task);
    for frame in tracks.iter_mut().flat_map(|t| &mut t.frames) {
        frame.enter(&task, profile);
    }
    Some(ScoredSide { side, muscle, task, tracks })
}

struct Look<'a> {
    side: Side,
    neck: Neck,
    task: TaskInputs,
    profile: &'a Profile,
}

fn scored_track(track: &Track, look: &Look, rules: TimeRules) -> ScoredTrack {
    let clock = Clock::new(&track.time_s, rules);
    let frames: Vec<Frame> = track
        .time_s
        .iter()
        .zip(&track.postures)
        .map(|(time, posture)| look.frame(*time, posture))
        .collect();
    let part = |part: &Part| {
        let series: Vec<Vec<f64>> =
            part.angles.iter().map(|a| frames.iter().map(a.of).collect()).collect();
        let views: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
        clock.part(&views)
    };
    ScoredTrack {
        name: track.name.clone(),
        parts: PARTS.iter().map(part).collect(),
        gaps: clock.gaps(),
        observed_s: clock.observed_s,
        weights_s: clock.weights_s,
        exceeded: track.exceeded,
        frames,
    }
}

impl Look<'_> {
    fn frame(&self, time_s: f64, posture: &WholePosture) -> Frame {
        let body = match self.neck {
            Neck::Measured => posture.neck.unwrap_or(posture.neutral),
            Neck::Neutral => posture.neutral,
            Neck::Gaze => *posture.gaze(self.side),
        };
        // An arm that hangs by the scenario's word: at zero, thumb forward.
        let arm = posture.arm(self.side).copied().unwrap_or_default();
        let knee_deg = posture.knees_deg.map_or(0.0, |[r, l]| r.max(l));
        let sheet = Worksheet::default();
        let mut frame = Frame {
            time_s,
            body,
            arm,
            knee_deg,
            is_on_toes: posture.is_on_toes(),
            reach_m: posture.reach_m(self.side),
            hand_m: posture.hand_m(self.side),
            ankles_m: posture.ankles_m,
            facing: posture.facing,
            back: posture.back,
            sheet,
            rula: rula(&sheet, self.profile),
            reba: reba(&sheet, self.profile),
        };
        frame.enter(&self.task, self.profile);
        frame
    }
}

impl Frame {
    /// Fills in and scores the sheet.
    pub fn enter(&mut self, task: &TaskInputs, profile: &Profile) {
        let task = TaskInputs {
            knee_flex_deg: self.knee_deg,
            legs_unbalanced: task.legs_unbalanced || self.is_on_toes,
            ..*task
        };
        self.sheet = worksheet(&self.body, &self.arm, &task, profile);
        self.rula = rula(&self.sheet, profile);
        self.reba = reba(&self.sheet, profile);
    }
}

/// What most tracks show, or the task says.
fn muscle_use(tracks: &[ScoredTrack], declared: &Declared, origin: crate::scenario::Origin) -> Use {
    let most = |of: &dyn Fn(&ScoredTrack) -> Shown| {
        let all: Vec<Shown> = tracks.iter().map(of).collect();
        let count = |s: Shown| all.iter().filter(|a| **a == s).count();
        if 2 * count(Shown::Yes) > all.len() {
            Shown::Yes
        } else if count(Shown::TooShort) > 0 {
            Shown::TooShort
        } else {
            Shown::No
        }
    };
    let held =
        most(&|t| any(t, |p, part| if part.is_held_up(p, &t.frames) { p.held } else { no(p) }));
    let repeated = most(&|t| any(t, |p, _| p.repeated));
    let rapid = most(&|t| {
        let most = PARTS.iter().zip(&t.parts).filter(|(part, _)| part.is_large);
        let changes = most.map(|(_, p)| p.rapid_changes).max().unwrap_or(0);
        let is = changes > 0 && changes as f64 * 60.0 >= t.observed_s;
        // A plan does not claim it of one movement of a few seconds either.
        match (t.observed_s < 60.0, is) {
            (true, _) => Shown::TooShort,
            (false, true) => Shown::Yes,
            (false, false) => Shown::No,
        }
    });
    Use {
        held: Answer::new(held, declared.hold_s.map(|h| h > 60.0), origin),
        repeated: Answer::new(repeated, declared.cycles_per_min.map(|c| c > 4.0), origin),
        rapid: Answer::new(rapid, None, origin),
    }
}

/// A hold that does not count leaves "yes" at "no".
fn no(part: &PartTimeline) -> Shown {
    if part.held == Shown::TooShort { Shown::TooShort } else { Shown::No }
}

fn any(track: &ScoredTrack, of: impl Fn(&PartTimeline, &Part) -> Shown) -> Shown {
    let all: Vec<Shown> = track
        .parts
        .iter()
        .zip(PARTS)
        .filter(|(_, part)| part.is_measured(&track.frames))
        .map(|(p, part)| of(p, part))
        .collect();
    if all.contains(&Shown::Yes) {
        Shown::Yes
    } else if all.contains(&Shown::TooShort) {
        Shown::TooShort
    } else {
        Shown::No
    }
}

/// `frames.csv`: a row for each track, side and frame.
pub fn frames_csv(motion: &Motion, sides: &[ScoredSide]) -> Result<Vec<u8>, InputError> {
    let mut out = csv::Writer::from_writer(Vec::new());
    let fault = |e: csv::Error| InputError::new("frames.csv", e.to_string());
    let mut header: Vec<&str> = vec![motion.kind.track_word(), "side", "time_s"];
    let angles = || PARTS.iter().flat_map(|p| p.angles);
    let names: Vec<String> = angles().map(|a| format!("{}_deg", a.key)).collect();
    header.extend(names.iter().map(String::as_str));
    header.extend(Worksheet::COLUMNS);
    header.extend(RulaSteps::COLUMNS);
    header.extend(RebaSteps::COLUMNS);
    out.write_record(&header).map_err(fault)?;
    for side in sides {
        for track in &side.tracks {
            for frame in &track.frames {
                let mut row =
                    vec![track.name.clone(), side.side.name().to_owned(), short(frame.time_s)];
                row.extend(angles().map(|a| short((a.of)(frame))));
                row.extend(frame.sheet.values().iter().map(|v| short(*v)));
                row.extend(frame.rula.values().iter().map(u8::to_string));
                row.extend(frame.reba.values().iter().map(u8::to_string));
                out.write_record(&row).map_err(fault)?;
            }
        }
    }
    out.into_inner().map_err(|e| fault(e.into_error().into()))
}

/// At most six decimals: a millionth of a degree or second, without a negative zero.
fn short(value: f64) -> String {
    ((value * 1e6).round() / 1e6 + 0.0).to_string()
}
