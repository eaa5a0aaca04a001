//! The paper's experiments with people (Vianello et al. 2021, section VI): on simulated operators, and on
//! people whom the user recorded.
//!
//! ```text
//! exp1   same primitive        the first half of the repetitions of a task teaches, the second half tests
//! exp2   other movements       random movements (recorded people: their other tasks) teach, the primitive tests
//! exp3   another body          simulated: seated, in other bodies, as exp1; recorded: other people teach
//! ```
//! [`Performer`]s with their tasks become [`TrainingSet`]s; each is looked at on two chains, from the pelvis to the
//! hand as in the paper and of the whole body, and all methods are learned and judged on the same frames:
//! scores of joint velocities, W, the error of hand and joints over a growing horizon, and what bands hold.
//! [`paper_table`] holds the paper's own figures. Whoever shows figures of simulated operators has to say so.

mod against;
mod horizon;
mod judge;
mod people;
mod result;
mod sets;
mod spread;
mod summary;
mod tables;

pub use against::{Against, WeightAgreement};
pub use horizon::{HORIZONS_S, HorizonCurve, HorizonPoint};
pub use judge::{PaperQuestion, run_paper};
pub use people::performers;
pub use result::{Chain, ChainResult, MethodOnSet, MovementScore, PaperResult, SetResult, SetSize};
pub use sets::{PaperExperiment, Performer, Task, TrainingSet, training_sets};
pub use spread::{PostureSpread, SCORES};
pub use summary::MethodSummary;
pub use tables::{PaperSpreads, paper_table};
