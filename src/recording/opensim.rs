//! `OpenSim` motion and storage files (`.mot`, `.sto`): coordinates of a model over time.
//!
//! ```text
//! Coordinates                     the name; `Speeds` and others hold no posture
//! version=1
//! nRows=2
//! nColumns=3
//! inDegrees=yes                   of angles; places are in metres
//! endheader
//! time  pelvis_tilt  pelvis_ty
//! 0.00  -3.1         0.94
//! ```
//! Coordinates of states carry the path of their joint, as in `/jointset/hip_r/hip_flexion_r/value`.

use super::Remark;
use super::columns::{Angle, OneTable, Tables};
use super::lines::{Fault, number, shown};
use super::map::TableMap;
use super::markers::table::rate_of;
use crate::files::{InputError, NumericTable};
use std::path::Path;

const AGAIN: &str = "copy or export the file again";
const CUT_OFF: &str = "copy or export the file again; if it is whole, correct the number";
/// Names of tables whose columns are called as coordinates and are none.
const NOT_COORDINATES: [&str; 3] = ["Speeds", "Accelerations", "PositionErrors"];
/// Rate (Hz) of rows of uneven times, at most.
const EVEN_HZ: f64 = 200.0;
/// Longest step of time between rows, s.
const LONGEST_STEP_S: f64 = 0.2;

/// What a file says.
#[derive(Debug)]
struct Storage {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
    /// Line of each row, from 1.
    lines: Vec<u64>,
    in_degrees: Option<bool>,
}

/// Reads the columns of a file, with what a map says of them.
pub(super) fn read(path: &Path, bytes: &[u8], map: &TableMap) -> Result<Tables, InputError> {
    let storage = parse(&String::from_utf8_lossy(bytes)).map_err(|fault| fault.of(path))?;
    let said = storage.in_degrees.map(|yes| if yes { 1f64.to_radians() } else { 1.0 });
    let mut remarks = Vec::new();
    if let Some((own, said)) = map.angle_rad.zip(said).filter(|(own, said)| own != said) {
        let text = format!(
            "angles are taken in {}, as the map says, and not in {}, as the header does",
            unit_name(own),
            unit_name(said)
        );
        remarks.push(Remark::new("unit of angles", text).of_size(1.0));
    }
    let angle = Angle { rad: map.angle_rad.or(said), is_doubtful: map.angle_rad.is_none() };
    let (storage, rate_hz, note) = even(storage).map_err(|fault| fault.of(path))?;
    remarks.extend(note);
    let table = NumericTable::of(path, storage.columns, storage.rows, storage.lines);
    Ok(Tables {
        all: vec![OneTable { path: path.to_owned(), body: None, table }],
        rate_hz,
        unit_m: map.unit_m.unwrap_or(1.0),
        angle,
        remarks,
    })
}

fn unit_name(rad: f64) -> &'static str {
    if rad == 1.0 { "radians" } else { "degrees" }
}

fn parse(text: &str) -> Result<Storage, Fault> {
    let mut lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    let mut header = Header::default();
    let mut is_first = true;
    loop {
        let Some((i, line)) = lines.next() else {
            return Err(Fault::whole(
                "has no line `endheader`",
                "is it an OpenSim file, and whole?",
            ));
        };
        let line = line.trim();
        if line.eq_ignore_ascii_case("endheader") {
            break;
        }
        if is_first && NOT_COORDINATES.contains(&line) {
            let message = format!("holds {line}, not the coordinates of a posture");
            return Err(Fault::at(1, message, "give the file of coordinates (`_q`) beside it"));
        }
        is_first &= line.is_empty();
        header.read(i + 1, line)?;
    }
    let mut rest = lines.filter(|(_, line)| !line.trim().is_empty());
    let Some((i, labels)) = rest.next() else {
        return Err(Fault::whole("ends after its header", AGAIN));
    };
    let columns = columns(i + 1, labels)?;
    if let Some((line, count)) = header.columns.filter(|(_, count)| *count != columns.len()) {
        let message = format!("nColumns says {count}, but line {} names {}", i + 1, columns.len());
        return Err(Fault::at(line, message, AGAIN));
    }
    let (mut rows, mut row_lines) = (Vec::new(), Vec::new());
    for (i, line) in rest {
        rows.push(row(i + 1, line, &columns)?);
        row_lines.push(i as u64 + 1);
    }
    if let Some((line, count)) = header.rows.filter(|(_, count)| *count != rows.len()) {
        let message = format!("nRows says {count}, but {} follow", rows.len());
        return Err(Fault::at(line, message, CUT_OFF));
    }
    Ok(Storage { columns, rows, lines: row_lines, in_degrees: header.in_degrees })
}

/// What a header says, with the lines on which it says it.
#[derive(Debug, Default)]
struct Header {
    rows: Option<(usize, usize)>,
    columns: Option<(usize, usize)>,
    in_degrees: Option<bool>,
}

impl Header {
    fn read(&mut self, number: usize, line: &str) -> Result<(), Fault> {
        // Older programs write `datarows 53`.
        let Some((key, value)) =
            line.split_once('=').or_else(|| line.split_once(char::is_whitespace))
        else {
            return Ok(());
        };
        let (key, value) = (key.trim().to_lowercase(), value.trim());
        let count = || {
            value.parse().map(|count| Some((number, count))).map_err(|_| {
                let message = format!("`{}` is no number of rows or columns", shown(value));
                Fault::at(number, message, AGAIN)
            })
        };
        match key.as_str() {
            "nrows" | "datarows" => self.rows = count()?,
            "ncolumns" | "datacolumns" => self.columns = count()?,
            "indegrees" => {
                self.in_degrees = Some(match value.to_lowercase().as_str() {
                    "yes" => true,
                    "no" => false,
                    _ => {
                        let message = format!("inDegrees is `{}`", shown(value));
                        return Err(Fault::at(number, message, "it is yes or no"));
                    }
                });
            }
            _ => {}
        }
        Ok(())
    }
}

/// Names of columns; coordinates of states without their path.
fn columns(number: usize, line: &str) -> Result<Vec<String>, Fault> {
    let labels: Vec<&str> = if line.contains('\t') {
        line.trim_end().split('\t').map(str::trim).collect()
    } else {
        line.split_whitespace().collect()
    };
    let bare = |label: &&str| -> String {
        let path = label.strip_suffix("/value");
        path.and_then(|p| p.rsplit('/').next()).unwrap_or(label).to_owned()
    };
    let names: Vec<String> = labels.iter().map(bare).collect();
    if !names.first().is_some_and(|name| name.eq_ignore_ascii_case("time")) {
        let first = shown(labels.first().copied().unwrap_or_default());
        let message = format!("the first column is `{first}`, not `time`");
        return Err(Fault::at(number, message, "time (s) comes first in files of OpenSim"));
    }
    for (i, name) in names.iter().enumerate() {
        if names[..i].contains(name) {
            let message = format!("column `{}` appears twice", shown(name));
            return Err(Fault::at(number, message, "keep one of the two, or rename one"));
        }
    }
    Ok(names)
}

fn row(line: usize, text: &str, columns: &[String]) -> Result<Vec<f64>, Fault> {
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.len() != columns.len() {
        let message = format!("{} numbers, but there are {} columns", words.len(), columns.len());
        return Err(Fault::at(line, message, AGAIN));
    }
    words
        .iter()
        .zip(columns)
        .map(|(word, column)| {
            number(word).ok_or_else(|| {
                let message =
                    format!("column `{}`: `{}` is no finite number", shown(column), shown(word));
                Fault::at(
                    line,
                    message,
                    "cut the file where the solution failed, or solve it again",
                )
            })
        })
        .collect()
}

/// Rows at even times, as they are or else on straight lines between them; how many a second.
fn even(mut storage: Storage) -> Result<(Storage, f64, Option<Remark>), Fault> {
    const SORT: &str = "rows come in the order of time";
    let times: Vec<f64> = storage.rows.iter().map(|row| row[0]).collect();
    if let Some(i) = (1..times.len()).find(|i| times[*i] < times[i - 1]) {
        let message = format!("time goes back from {} to {} s", times[i - 1], times[i]);
        return Err(Fault::at(storage.lines[i] as usize, message, SORT));
    }
    if let Some(rate) = rate_of(&times, times.len()) {
        return Ok((storage, rate, None));
    }
    let [first, .., last] = times.as_slice() else {
        let message = format!("holds {} rows, too few for a movement", times.len());
        return Err(Fault::whole(message, "give the file of a movement"));
    };
    let steps = || times.windows(2).map(|w| w[1] - w[0]);
    let longest = steps().fold(0.0, f64::max);
    if let Some(i) = steps().position(|step| step > LONGEST_STEP_S) {
        let message = format!("time goes from {} to {} s in one step", times[i], times[i + 1]);
        return Err(Fault::at(
            storage.lines[i + 1] as usize,
            message,
            "cut the file there: what happens in a gap is unknown",
        ));
    }
    let whole = last - first;
    if whole <= 0.0 {
        return Err(Fault::whole("all rows are of one time", SORT));
    }
    let rate = ((times.len() - 1) as f64 / whole).min(EVEN_HZ);
    let count = (whole * rate).floor() as usize + 1;
    let (mut rows, mut lines) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut at = 0;
    for i in 0..count {
        let time = first + i as f64 / rate;
        while at + 2 < times.len() && times[at + 1] <= time {
            at += 1;
        }
        let step = times[at + 1] - times[at];
        let part = if step > 0.0 { ((time - times[at]) / step).clamp(0.0, 1.0) } else { 0.0 };
        let (a, b) = (&storage.rows[at], &storage.rows[at + 1]);
        rows.push(a.iter().zip(b).map(|(a, b)| a + part * (b - a)).collect());
        lines.push(storage.lines[at]);
    }
    let text = format!(
        "steps of time are uneven (up to {longest:.4} s), as of a simulation: rows are put on even ones, {rate:.0} a \
         second, by straight lines between them"
    );
    (storage.rows, storage.lines) = (rows, lines);
    Ok((storage, rate, Some(Remark::new("uneven times", text))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic as _;
    use proptest::prelude::*;

    const GOOD: &str = "Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\n\n\
        Units are S.I. units (second, meters, Newtons, ...)\n\nendheader\n\
        time\tknee_angle_r\tpelvis_ty\n0.00\t-3.5\t0.94\n  0.01\t4e0\t0.95\n";

    #[test]
    fn columns_rows_and_unit_are_read() {
        let found = parse(GOOD).unwrap();
        assert_eq!(found.columns, ["time", "knee_angle_r", "pelvis_ty"]);
        assert_eq!(found.rows, [[0.0, -3.5, 0.94], [0.01, 4.0, 0.95]]);
        assert_eq!((found.in_degrees, found.lines), (Some(true), vec![11, 12]));
        // As older programs write it, with spaces and without a word on the unit.
        let old = "name walk.mot\ndatacolumns 2\ndatarows 1\nrange 0 1\nEndHeader\ntime a\n0 1\n";
        let found = parse(old).unwrap();
        assert_eq!((found.in_degrees, found.rows.len()), (None, 1));
        // Coordinates of states.
        let states = GOOD.replace("knee_angle_r", "/jointset/knee_r/knee_angle_r/value");
        let states = states.replace("pelvis_ty", "/jointset/knee_r/knee_angle_r/speed");
        let found = parse(&states).unwrap();
        assert_eq!(found.columns[1..], ["knee_angle_r", "/jointset/knee_r/knee_angle_r/speed"]);
    }

    #[test]
    fn a_damaged_file_is_named_with_its_line() {
        for (from, to, expected) in [
            ("endheader\n", "", "has no line `endheader`"),
            ("Coordinates", "Speeds", "line 1: holds Speeds"),
            ("inDegrees=yes", "inDegrees=maybe", "line 5: inDegrees is `maybe`"),
            ("nRows=2", "nRows=3", "line 3: nRows says 3, but 2 follow"),
            ("nRows=2", "nRows=two", "line 3: `two` is no number"),
            ("nColumns=3", "nColumns=4", "line 4: nColumns says 4, but line 10 names 3"),
            ("time\t", "frame\t", "line 10: the first column is `frame`"),
            ("pelvis_ty", "knee_angle_r", "line 10: column `knee_angle_r` appears twice"),
            ("\t0.94", "", "line 11: 2 numbers, but there are 3 columns"),
            ("0.95", "0.95 7", "line 12: 4 numbers, but there are 3 columns"),
            ("-3.5", "nan", "line 11: column `knee_angle_r`: `nan` is no finite number"),
            ("-3.5", "x", "line 11: column `knee_angle_r`: `x` is no finite number"),
        ] {
            let text = GOOD.replacen(from, to, 1);
            assert_ne!(text, GOOD);
            let error = parse(&text).unwrap_err().of(Path::new("a.mot"));
            assert!(error.message().contains(expected), "{expected}: {error}");
            assert!(error.help().is_some());
        }
        assert!(parse("").is_err());
        let header = GOOD.split_once("time").unwrap().0;
        assert!(parse(header).unwrap_err().of(Path::new("a")).message().contains("ends after"));
    }

    fn timed(times: &[f64]) -> Result<(Storage, f64, Option<Remark>), Fault> {
        even(Storage {
            columns: vec!["time".into(), "a".into()],
            rows: times.iter().map(|t| vec![*t, 10.0 * t]).collect(),
            lines: (0..times.len() as u64).map(|i| i + 7).collect(),
            in_degrees: None,
        })
    }

    #[test]
    fn uneven_steps_are_made_even_and_gaps_refused() {
        let (storage, rate, note) = timed(&[0.0, 0.0167, 0.0333, 0.05]).unwrap();
        assert_eq!((rate, storage.rows.len(), note.is_none()), (60.0, 4, true));
        // A simulation with its own steps, two rows of one time, on a straight line.
        let (storage, rate, note) =
            timed(&[1.0, 1.001, 1.003, 1.003, 1.01, 1.02, 1.035, 1.04]).unwrap();
        assert!((rate - 175.0).abs() < 1e-9 && note.is_some(), "{rate}");
        for (i, row) in storage.rows.iter().enumerate() {
            assert!((row[0] - (1.0 + i as f64 / rate)).abs() < 1e-12, "{row:?}");
            assert!((row[1] - 10.0 * row[0]).abs() < 1e-12);
        }
        for (times, line, expected) in [
            (&[0.0, 0.01, 0.005][..], Some(9), "time goes back from 0.01 to 0.005 s"),
            (&[0.0, 0.01, 0.02, 0.5], Some(10), "from 0.02 to 0.5 s in one step"),
            (&[0.0, 0.0, 0.0], None, "all rows are of one time"),
            (&[0.0], None, "1 rows, too few"),
            (&[], None, "0 rows, too few"),
        ] {
            let fault = timed(times).unwrap_err();
            assert_eq!(fault.line, line);
            assert!(fault.message.contains(expected), "{}", fault.message);
        }
    }

    proptest! {
        #[test]
        fn no_damage_makes_it_panic(
            cut in 0.5f64..=1.0,
            changes in proptest::collection::vec((0.0f64..1.0, any::<u8>()), 0..6),
        ) {
            let mut bytes = GOOD.as_bytes().to_vec();
            for (at, value) in changes {
                let i = (at * bytes.len() as f64) as usize;
                bytes[i] = value;
            }
            bytes.truncate((cut * bytes.len() as f64) as usize);
            if let Ok(found) = parse(&String::from_utf8_lossy(&bytes)) {
                prop_assert!(found.rows.iter().all(|row| row.len() == found.columns.len()));
                let _ = even(found);
            }
        }
    }
}
