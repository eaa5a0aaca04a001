//! The data CSV: what a posture model was learned from, as plain numbers for other programs.
//!
//! ```text
//! q0..q(n-1) (rad), xdot0..xdot5 (m/s, rad/s), qdot0..qdot(n-1) (rad/s), train (1/0), traj (from 0)
//! ```
//! Rows are the frames at about 30 Hz that train or test; `train` follows the first held-out split,
//! and frames in its gap are left out.

use super::dataset::Dataset;
use std::fmt::Write as _;

/// The text of the data CSV, numbers at full precision.
pub fn data_csv(dataset: &Dataset) -> String {
    let n = dataset.joints.len();
    let groups = [("q", n), ("xdot", 6), ("qdot", n)];
    let mut header: Vec<String> =
        groups.iter().flat_map(|(g, count)| (0..*count).map(move |i| format!("{g}{i}"))).collect();
    header.extend(["train".to_owned(), "traj".to_owned()]);
    let mut text = header.join(",");
    text.push('\n');
    let folds = dataset.held_out();
    let Some(fold) = folds.first() else { return text };
    let mut rows: Vec<(usize, u8)> = fold.train.iter().map(|&i| (i, 1)).collect();
    rows.extend(fold.test.iter().map(|&i| (i, 0)));
    rows.sort_unstable();
    for (i, train) in rows {
        let frame = &dataset.frames[i];
        for value in frame.q.iter().chain(&frame.xdot).chain(&frame.qdot) {
            let _ = write!(text, "{value},");
        }
        let _ = writeln!(text, "{train},{}", frame.trial);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::NumericTable;
    use crate::training::dataset::tests::made_up;

    #[test]
    fn rows_meet_their_task_and_say_what_trains() {
        let data = made_up(3, 2.0, 30.0);
        let table =
            NumericTable::parse(std::path::Path::new("d.csv"), data_csv(&data).as_bytes()).unwrap();
        assert_eq!((table.columns.len(), table.rows.len()), (24 + 6 + 24 + 2, 180));
        assert_eq!(table.column("train").unwrap().iter().sum::<f64>(), 120.0);
        assert_eq!(table.column("q3").unwrap()[7], data.frames[7].q[3]);
        assert_eq!(table.column("traj").unwrap()[179], 2.0);
    }
}
