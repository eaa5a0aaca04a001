//! Data files of any chain: rows of what the joints and the task did.
//!
//! ```text
//! q0..q(n-1) (rad), xdot0..xdot(m-1) (m/s, rad/s), qdot0..qdot(n-1) (rad/s), train (1/0), traj (id)
//! time_s (s) may be added; without it the time step is given, or found from q and qdot
//! ```
//! `xdot` is that of the tip in the axes of the base link; linear rows first.

use super::dataset::{DataRow, Dataset, Fold};
use crate::files::{InputError, NumericTable, suggest};
use crate::kinematics::Linkage;
use crate::posture::{Coupling, Hold};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Joint angles beyond this are no radians.
const LARGEST_ANGLE_RAD: f64 = 25.0;
/// Part of the task velocity that `J qdot` may miss before the chain is doubted.
const MISMATCH: f64 = 0.5;
/// So many time steps without a row are a gap.
const GAP_STEPS: f64 = 1.5;

/// A data file as a data set.
#[derive(Debug, Clone)]
pub struct DataFile {
    /// File name without its path.
    pub source: String,
    /// The rows.
    pub dataset: Dataset,
    /// The split of the `train` column.
    pub train_column: Option<Fold>,
    /// Time step, s, and how it is known.
    pub step_s: (f64, &'static str),
    /// What a reader should know.
    pub warnings: Vec<String>,
}

/// The task of a number of velocity rows.
pub fn task_of_rows(count: usize) -> Option<Hold> {
    match count {
        2 => Some(Hold::Planar),
        3 => Some(Hold::Point),
        6 => Some(Hold::Rigid),
        _ => None,
    }
}

/// Reads a data file for a chain. `hold` is the task, by default that of the number of `xdot` columns;
/// `rate_hz` the rows per second, by default from `time_s`, or from q and qdot.
///
/// # Errors
/// Where the file is no table of finite numbers, columns are missing, unknown or of another number
/// than the chain's, or values cannot be in the stated units.
pub fn read_data(
    path: &Path,
    chain: &Linkage,
    hold: Option<Hold>,
    rate_hz: Option<f64>,
) -> Result<DataFile, InputError> {
    let table = NumericTable::read(path)?;
    let n = chain.dof();
    let count = |group: &str| {
        (0..table.columns.len())
            .take_while(|i| table.columns.iter().any(|c| *c == format!("{group}{i}")))
            .count()
    };
    let (columns_q, m, columns_v) = (count("q"), count("xdot"), count("qdot"));
    let hold = match hold.or_else(|| task_of_rows(m)) {
        Some(hold) if hold.rows() == m => hold,
        Some(hold) => {
            let message = format!("has {m} xdot columns; the task needs {}", hold.rows());
            return Err(InputError::new(path, message)
                .remedy("name them xdot0, xdot1, ... or choose another --task"));
        }
        None => {
            return Err(InputError::new(path, format!("has {m} xdot columns"))
                .remedy("2 are a planar task, 3 a position, 6 a pose (linear first)"));
        }
    };
    for (group, found) in [("q", columns_q), ("qdot", columns_v)] {
        if found != n {
            let message =
                format!("has {found} columns {group}0, {group}1, ...; the chain has {n} joints");
            return Err(InputError::new(path, message)
                .remedy("give the chain of the data: --chain FILE.urdf:BASE:TIP"));
        }
    }
    refuse_unknown(path, &table, n, m)?;
    let block = |group: &str, count: usize| -> Result<Vec<usize>, InputError> {
        (0..count).map(|i| table.index(&format!("{group}{i}"))).collect()
    };
    let (iq, ix, iv) = (block("q", n)?, block("xdot", m)?, block("qdot", n)?);
    let has = |name: &str| table.columns.iter().any(|c| c == name);
    let trials: Vec<f64> =
        if has("traj") { table.column("traj")? } else { vec![0.0; table.rows.len()] };
    let mut known: Vec<f64> = Vec::new();
    let mut rows: Vec<DataRow> = Vec::new();
    for (row, trial) in table.rows.iter().zip(&trials) {
        let pick = |columns: &[usize]| columns.iter().map(|&c| row[c]).collect::<Vec<f64>>();
        let id = known.iter().position(|k| k == trial).unwrap_or_else(|| {
            known.push(*trial);
            known.len() - 1
        });
        rows.push(DataRow {
            q: pick(&iq),
            xdot: pick(&ix),
            qdot: pick(&iv),
            trial: id,
            time_s: 0.0,
        });
    }
    for (line, row) in rows.iter().enumerate() {
        if let Some((joint, q)) =
            row.q.iter().enumerate().find(|(_, q)| q.abs() > LARGEST_ANGLE_RAD)
        {
            let message =
                format!("row {}, column `q{joint}`: {q} is no joint angle in rad", line + 1);
            return Err(InputError::new(path, message).remedy("convert degrees to radians"));
        }
    }
    let step_s = set_times(path, &table, &mut rows, rate_hz)?;
    let gaps = cut_at_gaps(&mut rows, step_s.0);
    let source = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let coupling = Coupling::of_chain(chain.clone(), hold);
    let dataset = Dataset::of_rows(&source, &rows, coupling)?;
    let train_column = if has("train") { Some(train_fold(path, &table)?) } else { None };
    let gaps = (gaps > 0).then(|| {
        format!("{gaps} gaps in time_s are borders: a trajectory of its own begins behind each")
    });
    let warnings = mismatch(&dataset).into_iter().chain(gaps).collect();
    Ok(DataFile { source, dataset, train_column, step_s, warnings })
}

fn refuse_unknown(path: &Path, table: &NumericTable, n: usize, m: usize) -> Result<(), InputError> {
    let mut known: Vec<String> = ["train", "traj", "time_s"].map(str::to_owned).to_vec();
    for (group, count) in [("q", n), ("xdot", m), ("qdot", n)] {
        known.extend((0..count).map(|i| format!("{group}{i}")));
    }
    let Some(stranger) = table.columns.iter().find(|c| !known.contains(c)) else { return Ok(()) };
    let help = suggest(stranger, known.iter().map(String::as_str))
        .unwrap_or_else(|| "columns are q0.., xdot0.., qdot0.., train, traj and time_s".to_owned());
    Err(InputError::new(path, format!("column `{stranger}` is unknown")).remedy(help))
}

/// Fills in the times of the rows; the step (s) and how it is known.
fn set_times(
    path: &Path,
    table: &NumericTable,
    rows: &mut [DataRow],
    rate_hz: Option<f64>,
) -> Result<(f64, &'static str), InputError> {
    if table.columns.iter().any(|c| c == "time_s") {
        let times = table.column("time_s")?;
        for (row, time) in rows.iter_mut().zip(&times) {
            row.time_s = *time;
        }
        let mut steps: Vec<f64> = Vec::new();
        for (line, w) in rows.windows(2).enumerate() {
            if w[0].trial == w[1].trial {
                let step = w[1].time_s - w[0].time_s;
                if step <= 0.0 {
                    let message = format!("row {}: time_s does not grow", line + 2);
                    return Err(InputError::new(path, message).remedy("sort rows by time"));
                }
                steps.push(step);
            }
        }
        steps.sort_by(f64::total_cmp);
        return Ok((steps.get(steps.len() / 2).copied().unwrap_or(1.0), "time_s"));
    }
    let (step, how) = match rate_hz {
        Some(rate) => (1.0 / rate, "given"),
        None => match step_of_motion(rows) {
            Some(step) => (step, "from q and qdot"),
            None => (1.0, "unknown, taken as 1 s"),
        },
    };
    let mut index = BTreeMap::<usize, usize>::new();
    for row in rows {
        let at = index.entry(row.trial).or_default();
        row.time_s = *at as f64 * step;
        *at += 1;
    }
    Ok((step, how))
}

/// Makes the rows behind each gap in time a trial of their own, so that nothing goes across it; the number of
/// gaps.
fn cut_at_gaps(rows: &mut [DataRow], step_s: f64) -> usize {
    let trials: BTreeSet<usize> = rows.iter().map(|r| r.trial).collect();
    let mut free = trials.last().map_or(0, |last| last + 1);
    // Of each trial of the file: its last time, and what its rows are called now.
    let mut now: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
    for row in rows {
        let (last_s, called) = now.entry(row.trial).or_insert((row.time_s, row.trial));
        if row.time_s - *last_s > GAP_STEPS * step_s {
            *called = free;
            free += 1;
        }
        *last_s = row.time_s;
        row.trial = *called;
    }
    free - trials.last().map_or(0, |last| last + 1)
}

/// The time step at which the differences of q fit qdot best, s.
fn step_of_motion(rows: &[DataRow]) -> Option<f64> {
    let (mut along, mut power) = (0.0, 0.0);
    for w in rows.windows(2).filter(|w| w[0].trial == w[1].trial) {
        for j in 0..w[0].q.len() {
            along += (w[1].q[j] - w[0].q[j]) * w[0].qdot[j];
            power += w[0].qdot[j] * w[0].qdot[j];
        }
    }
    (along > 0.0 && power > 0.0).then(|| along / power)
}

fn train_fold(path: &Path, table: &NumericTable) -> Result<Fold, InputError> {
    let flags = table.column("train")?;
    if let Some((line, flag)) = flags.iter().enumerate().find(|(_, f)| **f != 0.0 && **f != 1.0) {
        let message = format!("row {}, column `train`: {flag}", line + 1);
        return Err(InputError::new(path, message).remedy("1 for rows that train, 0 for others"));
    }
    let pick = |wanted: f64| (0..flags.len()).filter(|&i| flags[i] == wanted).collect::<Vec<_>>();
    let fold = Fold { train: pick(1.0), test: pick(0.0) };
    if fold.train.len() < 20 || fold.test.is_empty() {
        let message =
            format!("has {} rows that train and {} that do not", fold.train.len(), fold.test.len());
        return Err(InputError::new(path, message)
            .remedy("at least 20 rows must train and one must be held out; or choose --split"));
    }
    Ok(fold)
}

/// A warning where the chain does not make the task velocities of the data.
fn mismatch(dataset: &Dataset) -> Option<String> {
    let (mut missed, mut power) = (0.0, 0.0);
    for f in &dataset.frames {
        missed += (&f.xdot - &f.jacobian * &f.qdot).norm_squared();
        power += f.xdot.norm_squared();
    }
    let part = (missed / power.max(f64::MIN_POSITIVE)).sqrt();
    (part > MISMATCH).then(|| {
        format!(
            "xdot differs from J qdot by {:.0} % of its size: check the chain, its base and tip, the \
             units and the axes (those of the base link)",
            100.0 * part
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::parse_urdf;
    use crate::training::toy5r::{BASE, TIP, ToyConstants, generate, planar_urdf};
    use std::fmt::Write as _;

    fn chain() -> Linkage {
        let text = planar_urdf(&ToyConstants::default());
        let model = parse_urdf(Path::new("toy.urdf"), &text).unwrap();
        Linkage::chain(&model, BASE, TIP).unwrap()
    }

    fn text(header: &str, scale: f64) -> String {
        let toy = generate(3, &ToyConstants::default()).unwrap();
        let mut text = format!("{header}\n");
        for i in 0..60 {
            let values = toy.q[i].iter().map(|v| v * scale).chain(toy.xdot[i]).chain(toy.qdot[i]);
            for v in values {
                let _ = write!(text, "{v},");
            }
            let _ = writeln!(text, "{},0", u8::from(toy.train[i]));
        }
        text
    }

    const HEADER: &str = "q0,q1,q2,q3,q4,xdot0,xdot1,qdot0,qdot1,qdot2,qdot3,qdot4,train,traj";

    fn read(text: &str) -> Result<DataFile, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.csv");
        std::fs::write(&path, text).unwrap();
        read_data(&path, &chain(), None, None).map_err(|e| {
            let message = e.to_string();
            format!("{message} {:?}", miette::Report::new(e))
        })
    }

    #[test]
    fn a_good_file_is_a_data_set() {
        let file = read(&text(HEADER, 1.0)).unwrap();
        assert_eq!((file.dataset.frames.len(), file.dataset.task_rows()), (60, 2));
        assert!((file.step_s.0 - 0.2).abs() < 0.02, "{:?}", file.step_s);
        let fold = file.train_column.unwrap();
        assert_eq!(fold.train.len() + fold.test.len(), 60);
        assert!(file.warnings.is_empty());
        for f in &file.dataset.frames {
            assert!((&f.jacobian * &f.qdot - &f.xdot).norm() < 1e-12);
        }
    }

    #[test]
    fn a_gap_in_time_is_a_border() {
        let timed = |time: &dyn Fn(usize) -> f64| {
            let own = text(HEADER, 1.0);
            let rows = own.lines().skip(1).enumerate();
            let rows: Vec<String> = rows.map(|(i, line)| format!("{line},{}", time(i))).collect();
            read(&format!("{HEADER},time_s\n{}\n", rows.join("\n"))).unwrap()
        };
        let even = timed(&|i| 0.2 * i as f64);
        assert_eq!((even.dataset.trials, even.warnings.len()), (1, 0));
        // Two rows are lost behind the 30th.
        let cut = timed(&|i| 0.2 * (i + if i < 30 { 0 } else { 2 }) as f64);
        assert_eq!((cut.dataset.trials, cut.warnings.len()), (2, 1));
        let runs = super::super::dataset::runs(&cut.dataset.frames.iter().collect::<Vec<_>>());
        assert_eq!(runs.iter().map(Vec::len).collect::<Vec<_>>(), [30, 30]);
    }

    #[test]
    fn faults_are_named() {
        let said = |header: &str, scale: f64| read(&text(header, scale)).unwrap_err();
        assert!(said(HEADER, 57.3).contains("rad"));
        let e = said(&HEADER.replace("train", "tran"), 1.0);
        assert!(e.contains("`tran`") && e.contains("train"), "{e}");
        assert!(said(&HEADER.replace("xdot1", "speed"), 1.0).contains("xdot columns"));
        assert!(said(&HEADER.replace("qdot4", "qdot7"), 1.0).contains("5 joints"));
    }
}
