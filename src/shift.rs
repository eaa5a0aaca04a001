//! A whole shift: several finished runs and scored motions as tasks of one worker's day.
//!
//! ```text
//! shift file ─ read_shift ─► Shift (tasks with their results and minutes)
//!            ─ Shift::assess ─► ShiftResult: minutes at each action level over people, lifting, hand exertions
//! ```
//! Minutes add up over tasks; how scores combine in a body over a day nobody knows, so nothing but time is added.

mod dose;
mod exertion;
mod file;
mod lifting;
mod read;
mod result;
mod sums;

pub use exertion::{ExertionDose, HandDose, TaskExertion};
pub use file::{Order, SHIFT_SCHEMA, shift_schema};
pub use lifting::{CompositeRefusal, LiftRefusal, LiftingDose, TaskLift};
pub use read::{Shift, ShiftTask, TaskSource, read_shift};
pub use result::{
    BodyDose, Dose, LevelDose, MethodDose, SHIFT_RESULT_SCHEMA, ShiftNote, ShiftResult, ShiftTime,
    TaskApart, TaskDose, TaskFacts, TaskKind, Units, WhyApart, WorstPerson,
};
