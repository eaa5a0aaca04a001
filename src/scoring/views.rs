//! The postures that an ergonomist would pick by eye: the worst, the longest held, the heaviest.

use super::frames::{Frame, ScoredSide, ScoredTrack};
use super::setup::grams;
use serde::Serialize;

/// Why a frame was picked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewKind {
    /// Highest RULA, then REBA, then step scores, then earliest.
    Worst,
    /// Middle of the longest hold of upper arm, neck or trunk.
    HeldLongest,
    /// Largest horizontal distance of the loaded hand from L5/S1, where the load bears most on the
    /// back; of the bare arm where there is no load.
    HighestLoad,
}

impl ViewKind {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Worst => "worst frame",
            Self::HeldLongest => "held longest",
            Self::HighestLoad => "highest load",
        }
    }
}

/// One picked frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct View {
    /// Why it was picked.
    pub kind: ViewKind,
    /// Trial or rollout.
    pub track: String,
    /// When, s.
    pub time_s: f64,
    /// RULA grand score.
    pub rula: u8,
    /// REBA final score.
    pub reba: u8,
    /// What makes it so.
    pub why: String,
    #[serde(skip)]
    pub(crate) frame: Frame,
}

/// The three views of a side; a hold is listed only where there is one.
pub fn views(side: &ScoredSide) -> Vec<View> {
    let all = || side.tracks.iter().flat_map(|t| t.frames.iter().map(move |f| (t, f)));
    let mut found = Vec::new();
    let worst = all().reduce(|a, b| if severity(b.1) > severity(a.1) { b } else { a });
    found.extend(worst.map(|(t, f)| {
        let why = format!(
            "REBA {}, RULA scores C {} and D {}",
            f.reba.total, f.rula.score_c, f.rula.score_d
        );
        view(ViewKind::Worst, t, f, why)
    }));
    found.extend(held_longest(side));
    let far = all().reduce(|a, b| if b.1.reach_m > a.1.reach_m { b } else { a });
    found.extend(far.map(|(t, f)| {
        let load = side.task.load_kg;
        let moment = load * 9.81 * f.reach_m;
        let why = if load > 0.0 {
            format!(
                "{} kg at {:.2} m in front of L5/S1: {moment:.0} N m there by the load alone, without the \
                 weight of the body",
                grams(load),
                f.reach_m
            )
        } else {
            format!("no load; the hand is {:.2} m in front of L5/S1", f.reach_m)
        };
        view(ViewKind::HighestLoad, t, f, why)
    }));
    found
}

fn view(kind: ViewKind, track: &ScoredTrack, frame: &Frame, why: String) -> View {
    View {
        kind,
        track: track.name.clone(),
        time_s: frame.time_s,
        rula: frame.rula.grand,
        reba: frame.reba.total,
        why,
        frame: *frame,
    }
}

/// By which frames are called worse.
fn severity(f: &Frame) -> (u8, u8, u8) {
    (f.rula.grand, f.reba.total, f.rula.score_c + f.rula.score_d)
}

fn held_longest(side: &ScoredSide) -> Option<View> {
    let holds = side.tracks.iter().flat_map(|t| {
        let parts = super::PARTS.iter().zip(&t.parts);
        parts
            .filter(|(part, _)| ["upper arm", "neck", "trunk"].contains(&part.name))
            .filter(|(part, _)| part.is_measured(&t.frames))
            .filter_map(move |(part, p)| p.longest_hold.map(|h| (t, part, h)))
    });
    let (track, part, hold) =
        holds.reduce(|a, b| if b.2.duration_s() > a.2.duration_s() { b } else { a })?;
    let middle = 0.5 * (hold.from_s + hold.to_s);
    let near = |f: &&Frame| (f.time_s - middle).abs();
    let frame = track.frames.iter().min_by(|a, b| near(a).total_cmp(&near(b)))?;
    let why = format!("{} held for {:.1} s", part.name, hold.duration_s());
    Some(view(ViewKind::HeldLongest, track, frame, why))
}
