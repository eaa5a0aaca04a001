//! Scores of what there already is: filled-in worksheets, recorded motions, sampled postures.
//!
//! ```text
//! worksheets (CSV)                       ─ table   ─► ScoredTable
//! recording, joint angles, rollouts      ─ motion  ─► Motion      (whole postures over time)
//!   ─ frames (Declared, Profile)         ─► ScoredSide            (a sheet for every frame)
//!   ─ summary                            ─► Summary               (over time or over rollouts)
//! ```

mod frames;
mod motion;
mod parts;
mod setup;
mod standards;
mod stored;
mod summary;
mod table;
mod views;

pub use frames::{Frame, ScoredSide, ScoredTrack, frames_csv, score_side};
pub use motion::{Motion, MotionKind, Track, read_angles, read_recorded};
pub use parts::{Angle, PARTS, Part, Step};
pub use setup::{Answer, Declared, Input, Neck, Use, inputs};
pub use standards::{BackTimes, LiftAsked, LubaTimes, OtherMethods};
pub use stored::{StoredScore, StoredSide, read_score};
pub use summary::{
    AngleSpread, DriverShare, LevelShare, OverRollouts, OverTime, PartSummary, RolloutFigures,
    SCORE_SCHEMA, SideSummary, Summary, TrackMean, summarise,
};
pub use table::{ScoredTable, score_table};
pub use views::{View, ViewKind, views};
