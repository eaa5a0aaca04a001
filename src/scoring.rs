//! Scores of what there already is: filled-in worksheets, recorded motions, sampled postures.

mod table;

pub use table::{ScoredTable, score_table};
