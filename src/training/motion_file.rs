//! Joint-motion CSV files: movements that are already joint angles of a body of this program.
//!
//! ```text
//! # simulated operator            first line of a file that no person made
//! # fitted recording              first line of a file that `ergopath import` wrote
//! trial,time_s,pelvis_up_m,...,jL5S1_Z_rad,...[,stepping]    `trial` may be left out; one column per joint, rad
//! ```
//! The pelvis (displacement from where it is upright, m, and turn, rad) is in all six columns or in none.
//! Within a trial the time step is uniform. Angles are filtered like those of recordings (6 Hz) and
//! differentiated; what the filter carries across a limit by a hair is left there. Those of a fitted recording are
//! filtered already, and may be as far beyond a limit as the fit allows; `stepping` is 1 where a foot steps.

use super::dataset::Trial;
use super::fit::FitSettings;
use crate::files::{InputError, NumericTable, read_bytes, sha256_hex, suggest};
use crate::human::{
    Body, Coupled, PELVIS_JOINTS, Pelvis, PostureLimits, Side, column_of, column_unit,
};
use crate::math::signal::{differentiate, low_pass_zero_phase};
use std::fmt::Write as _;
use std::path::Path;

/// First line of a file of simulated movements.
pub const SIMULATED_MARK: &str = "# simulated operator";
/// First line of a file of movements that were fitted to a recording.
pub const FITTED_MARK: &str = "# fitted recording";
/// Column of whether a foot steps.
const STEPPING: &str = "stepping";
/// Angles beyond a limit by no more than this are rounding, rad.
const LIMIT_TOLERANCE: f64 = 1e-4;
/// Largest departure of a time step from the mean step of its trial, as a part of it.
const STEP_TOLERANCE: f64 = 0.02;
pub(super) const FEWEST_ROWS: usize = 8;

/// What a joint-motion file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionFile {
    /// File name without its path.
    pub source: String,
    /// SHA-256 of the bytes.
    pub sha256: String,
    /// Whether the file says that the movements are those of a simulated operator.
    pub simulated: bool,
    /// Cut-off of the low-pass filter, Hz; none where the rate is too low for it.
    pub cutoff_hz: Option<f64>,
    /// The movements.
    pub trials: Vec<Trial>,
}

/// Reads a joint-motion CSV of the chain of a body.
///
/// # Errors
/// Where the file is no table of finite numbers, a joint is missing or unknown, the time is not
/// uniform, or an angle is outside the body's limits.
pub fn read_motion(path: &Path, body: &Body, side: Side) -> Result<MotionFile, InputError> {
    parse_motion(path, &read_bytes(path)?, body, side)
}

fn parse_motion(
    path: &Path,
    bytes: &[u8],
    body: &Body,
    side: Side,
) -> Result<MotionFile, InputError> {
    let table = NumericTable::parse(path, bytes)?;
    let has_pelvis = table.columns.iter().any(|c| PELVIS_JOINTS.iter().any(|p| column_of(p) == *c));
    let pelvis = if has_pelvis { Pelvis::Moves } else { Pelvis::Rests };
    let chain = body.chain(Coupled { hands: side.into(), pelvis }, &[])?;
    let is_fitted = bytes.starts_with(FITTED_MARK.as_bytes());
    let limits = body.limits(&chain);
    let limits = if is_fitted {
        limits.widened(FitSettings::default().limit_slack_deg.to_radians())
    } else {
        limits
    };
    let joints: Vec<String> = chain.joints().iter().map(|j| j.name.clone()).collect();
    refuse_unknown(path, &table, &joints)?;
    let time = table.index("time_s")?;
    let columns: Result<Vec<usize>, InputError> =
        joints.iter().map(|j| table.index(&column_of(j))).collect();
    let columns = columns?;
    let units: Vec<f64> = joints.iter().map(|j| column_unit(j, body)).collect();
    let value = |row: &[f64], i: usize| row[columns[i]] / units[i];
    let trial = table.columns.iter().position(|c| c == "trial");
    let stepping = table.columns.iter().position(|c| c == STEPPING);
    let source = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut groups: Vec<(f64, Vec<usize>)> = Vec::new();
    for (i, row) in table.rows.iter().enumerate() {
        let q: Vec<f64> = (0..columns.len()).map(|c| value(row, c)).collect();
        refuse_outside(path, i, &q, &joints, &limits)?;
        let name = trial.map_or(0.0, |c| row[c]);
        if groups.last().is_none_or(|(current, _)| *current != name) {
            if groups.iter().any(|(other, _)| *other == name) {
                let message = format!("row {}: trial {name} appears again", i + 1);
                return Err(
                    InputError::new(path, message).remedy("keep the rows of each trial together")
                );
            }
            groups.push((name, Vec::new()));
        }
        if let Some((_, rows)) = groups.last_mut() {
            rows.push(i);
        }
    }
    let mut trials = Vec::new();
    let mut is_filtered = true;
    for (name, rows) in groups {
        let times: Vec<f64> = rows.iter().map(|&i| table.rows[i][time]).collect();
        let rate_hz = uniform_rate(path, &times, rows[0])?;
        is_filtered &= is_fitted || FitSettings::default().cutoff_hz < 0.25 * rate_hz;
        let angles: Vec<Vec<f64>> = (0..columns.len())
            .map(|c| rows.iter().map(|&i| value(&table.rows[i], c)).collect())
            .collect();
        let label = if trial.is_some() { format!("{source} trial {name}") } else { source.clone() };
        let steps = stepping.map(|c| rows.iter().map(|&i| table.rows[i][c] > 0.5).collect());
        let own = if is_fitted {
            as_it_is(label, rate_hz, &angles)
        } else {
            trial_of(label, rate_hz, &angles)
        };
        trials.push(Trial { stepping: steps.unwrap_or_default(), ..own });
    }
    Ok(MotionFile {
        source,
        sha256: sha256_hex(bytes),
        simulated: bytes.starts_with(SIMULATED_MARK.as_bytes()),
        cutoff_hz: is_filtered.then_some(FitSettings::default().cutoff_hz),
        trials,
    })
}

fn refuse_unknown(path: &Path, table: &NumericTable, joints: &[String]) -> Result<(), InputError> {
    let known = || {
        let joints = joints.iter().map(|j| column_of(j));
        joints.chain(["trial".to_owned(), "time_s".to_owned(), STEPPING.to_owned()])
    };
    for column in &table.columns {
        if !known().any(|k| k == *column) {
            let names: Vec<String> = known().collect();
            let help = suggest(column, names.iter().map(String::as_str));
            let message = format!("column `{column}` is no joint of the chain");
            return Err(InputError::new(path, message).remedy(help.unwrap_or_else(|| {
                "columns are trial (optional), time_s and <joint>_rad of the coupled side".into()
            })));
        }
    }
    Ok(())
}

fn refuse_outside(
    path: &Path,
    row: usize,
    q: &[f64],
    joints: &[String],
    limits: &PostureLimits,
) -> Result<(), InputError> {
    let out = |v: f64, low: f64, high: f64| v < low - LIMIT_TOLERANCE || v > high + LIMIT_TOLERANCE;
    let single = (0..q.len())
        .find(|&i| out(q[i], limits.lower[i], limits.upper[i]))
        .map(|i| (joints[i].as_str(), q[i], limits.lower[i], limits.upper[i]));
    let sum = || {
        limits.sums.iter().find_map(|s| {
            let total = s.columns.iter().map(|&c| q[c]).sum();
            out(total, s.lower, s.upper).then_some((s.name.as_str(), total, s.lower, s.upper))
        })
    };
    match single.or_else(sum) {
        None => Ok(()),
        Some((name, value, low, high)) => {
            let message =
                format!("row {}: {name} is {value} rad, outside {low:.4} to {high:.4}", row + 1);
            Err(InputError::new(path, message)
                .remedy("angles must be those of the stated body and side, in rad"))
        }
    }
}

/// Frames per second of uniform times; `first_row` (from 0) is only named in errors.
fn uniform_rate(path: &Path, times: &[f64], first_row: usize) -> Result<f64, InputError> {
    if times.len() < FEWEST_ROWS {
        let message = format!("row {}: a trial of only {} rows", first_row + 1, times.len());
        return Err(InputError::new(path, message)
            .remedy(format!("a trial needs at least {FEWEST_ROWS} rows")));
    }
    let step = (times[times.len() - 1] - times[0]) / (times.len() - 1) as f64;
    let uneven = (1..times.len()).find(|&i| {
        let own = times[i] - times[i - 1];
        // Written as a negation so that a step of zero everywhere is refused too.
        !(own > 0.0 && (own - step).abs() <= STEP_TOLERANCE * step)
    });
    if let Some(i) = uneven {
        let message = format!(
            "row {}: time goes from {} to {} s, not by the trial's step of {step:.6} s",
            first_row + i + 1,
            times[i - 1],
            times[i]
        );
        return Err(InputError::new(path, message).remedy(
            "resample each trial to a uniform time step, or mark trials in a column `trial`",
        ));
    }
    Ok(1.0 / step)
}

/// A trial from columns of angles (rad): filtered, then differentiated.
pub fn trial_of(source: String, rate_hz: f64, angles: &[Vec<f64>]) -> Trial {
    let cutoff = FitSettings::default().cutoff_hz;
    let smooth: Vec<Vec<f64>> =
        angles.iter().map(|a| low_pass_zero_phase(a, rate_hz, cutoff)).collect();
    as_it_is(source, rate_hz, &smooth)
}

/// A trial from columns of angles that are smooth (rad).
fn as_it_is(source: String, rate_hz: f64, smooth: &[Vec<f64>]) -> Trial {
    let rates: Vec<Vec<f64>> = smooth.iter().map(|a| differentiate(a, 1.0 / rate_hz)).collect();
    let rows = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
        (0..smooth[0].len()).map(|i| columns.iter().map(|c| c[i]).collect()).collect()
    };
    Trial {
        source,
        rate_hz,
        q: rows(smooth),
        qdot: rows(&rates),
        stepping: Vec::new(),
        turn: Vec::new(),
    }
}

/// The text of a joint-motion file of a body: comment lines, header, rows rounded to 1e-5 (s, rad, m).
///
/// `trials` holds times (s) and postures (T x n, rad, leg lengths) of each trial.
pub fn motion_text(
    comments: &[&str],
    (joints, body): (&[String], &Body),
    trials: &[(Vec<f64>, Vec<Vec<f64>>)],
) -> String {
    let mut text = String::new();
    for comment in comments {
        let _ = writeln!(text, "# {comment}");
    }
    text.push_str("trial,time_s");
    for joint in joints {
        let _ = write!(text, ",{}", column_of(joint));
    }
    text.push('\n');
    for (index, (times, postures)) in trials.iter().enumerate() {
        for (time, q) in times.iter().zip(postures) {
            let _ = write!(text, "{},{}", index + 1, short(*time));
            for (value, joint) in q.iter().zip(joints) {
                let _ = write!(text, ",{}", short(value * column_unit(joint, body)));
            }
            text.push('\n');
        }
    }
    text
}

/// At most five decimals, without trailing zeros or a negative zero.
fn short(value: f64) -> f64 {
    (value * 1e5).round() / 1e5 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joints(body: &Body) -> Vec<String> {
        body.arm(Side::Right).unwrap().joints().iter().map(|j| j.name.clone()).collect()
    }

    fn sample(simulated: bool) -> (Body, String) {
        let body = Body::load("female_p50", Path::new(".")).unwrap();
        let names = joints(&body);
        let trial = |shift: f64| {
            let times: Vec<f64> = (0..40).map(|i| f64::from(i) / 30.0).collect();
            let rows = times
                .iter()
                .map(|t| (0..24).map(|c| 0.05 + 0.03 * (t + shift + f64::from(c)).sin()).collect())
                .collect();
            (times, rows)
        };
        let comments: &[&str] =
            if simulated { &["simulated operator", "x"] } else { &["a person"] };
        let text = motion_text(comments, (&names, &body), &[trial(0.0), trial(1.0)]);
        (body, text)
    }

    fn parse(body: &Body, text: &str) -> Result<MotionFile, InputError> {
        parse_motion(Path::new("m.csv"), text.as_bytes(), body, Side::Right)
    }

    #[test]
    fn what_was_written_is_read() {
        let (body, text) = sample(true);
        let file = parse(&body, &text).unwrap();
        assert!(file.simulated);
        assert_eq!(file.trials.len(), 2);
        assert!((file.trials[0].rate_hz - 30.0).abs() < 0.01);
        let expected = 0.05 + 0.03 * (20.0f64 / 30.0 + 3.0).sin();
        assert!((file.trials[0].q[20][3] - expected).abs() < 1e-4);
        let (body, text) = sample(false);
        assert!(!parse(&body, &text).unwrap().simulated);
    }

    #[test]
    fn faults_are_named() {
        let (body, text) = sample(false);
        let line = |n: usize| text.lines().nth(n).unwrap();
        let rejected = |broken: String| parse(&body, &broken).unwrap_err().message().to_owned();
        let message = rejected(text.replace("jRightElbow_Z_rad", "jRightElbow_Q_rad"));
        assert!(message.contains("jRightElbow_Q_rad"), "{message}");
        let far = line(12).replacen(line(12).split(',').nth(4).unwrap(), "2.5", 1);
        let message = rejected(text.replace(line(12), &far));
        assert!(message.contains("row 11") && message.contains("jL5S1_Y"), "{message}");
        let message = rejected(text.replace(&format!("{}\n", line(20)), ""));
        assert!(message.contains("time goes from"), "{message}");
        let message = rejected(text.lines().take(5).collect::<Vec<_>>().join("\n"));
        assert!(message.contains("only 3 rows"), "{message}");
        assert!(rejected(text.replace("time_s", "jL5S1_Z")).contains("no joint"));
    }
}
