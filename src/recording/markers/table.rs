//! Tables of places: Qualisys exports, CSV with names in its header, and plain rows of numbers.
//!
//! ```text
//! Qualisys   NO_OF_FRAMES .., FREQUENCY 100, MARKER_NAMES a b .., then [frame, time,] x y z x y z ..   (mm)
//! CSV        [time_s,] a_x, a_y, a_z, b_x, ..                       unit and, without time_s, rate by the map
//! plain      x y z x y z ..                                         names, unit and rate by the map
//! ```
//! An empty cell, `NaN` or `null` is a place that was not seen; so are three zeros of a Qualisys export.

use super::{HIGHEST_RATE_HZ, Markers, without_people};
use crate::files::{CsvText, InputError, suggest};
use crate::math::Vec3;
use crate::recording::lines::{Fault, shown};
use crate::recording::map::TableMap;
use std::path::Path;

const AXES: [&str; 3] = ["x", "y", "z"];
const SKIPPED: &str = "-";
/// Largest number believed in any unit.
const LARGEST: f64 = 1e9;
/// Largest departure of a time step from the mean one, as a part of it.
const STEP_TOLERANCE: f64 = 0.05;
/// Names of a column of times, s.
pub(in crate::recording) const TIMES: [&str; 2] = ["time_s", "time"];
pub(in crate::recording) const NEEDS_UNIT: &str =
    "say under [map] what one of its numbers is: unit = \"mm\", or \"m\", \"cm\" ..";
pub(in crate::recording) const NEEDS_RATE: &str =
    "say under [map] how many rows a second has: rate_hz = 100";

/// Reads a table with what a map says of it.
pub(in crate::recording) fn read(
    path: &Path,
    bytes: &[u8],
    map: &TableMap,
) -> Result<Markers, InputError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let first = text.lines().map(str::trim).find(|l| !l.is_empty()).unwrap_or_default();
    if text.lines().take(20).any(|line| line.starts_with("MARKER_NAMES")) {
        return qualisys(text, map).map_err(|fault| fault.of(path));
    }
    if words(first).next().is_some_and(|word| cell(word).is_ok()) {
        return plain(text, map).map_err(|fault| fault.of(path));
    }
    with_header(path, bytes, map)
}

/// Words of a row, however they are parted.
fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|c: char| c == ',' || c == ';' || c.is_whitespace()).filter(|w| !w.is_empty())
}

/// A number, or none where there is none; an error for anything else.
fn cell(word: &str) -> Result<Option<f64>, ()> {
    let word = word.trim();
    if word.is_empty() || ["nan", "null", "na"].iter().any(|w| word.eq_ignore_ascii_case(w)) {
        return Ok(None);
    }
    let value = word.parse::<f64>().map_err(|_| ())?;
    Ok(Some(value).filter(|v| v.abs() <= LARGEST))
}

fn place(cells: [Option<f64>; 3], unit_m: f64) -> Option<Vec3> {
    let [x, y, z] = cells;
    Some(unit_m * Vec3::new(x?, y?, z?))
}

/// The names that count and their columns.
fn wanted(names: &[String]) -> Vec<(usize, String)> {
    let all = names.iter().enumerate().filter(|(_, n)| *n != SKIPPED);
    all.map(|(i, n)| (3 * i, n.clone())).collect()
}

fn plain(text: &str, map: &TableMap) -> Result<Markers, Fault> {
    if map.points.is_empty() {
        return Err(Fault::whole(
            "is a table without names",
            "name its points under [map], one for each three columns: points = [\"RWrist\", ..]",
        ));
    }
    let unit_m = map.unit_m.ok_or_else(|| Fault::whole("does not say its unit", NEEDS_UNIT))?;
    let rate_hz = map.rate_hz.ok_or_else(|| Fault::whole("does not say its rate", NEEDS_RATE))?;
    let columns = 3 * map.points.len();
    let points = wanted(&map.points);
    let mut positions = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let cells: Vec<&str> = words(line).collect();
        if cells.is_empty() {
            continue;
        }
        if cells.len() != columns {
            let message =
                format!("{} numbers, but the map names {} points", cells.len(), map.points.len());
            return Err(Fault::at(
                i + 1,
                message,
                "each point takes three columns; `-` skips three",
            ));
        }
        positions.push(row(i + 1, &cells, &points, unit_m)?);
    }
    Ok(Markers { rate_hz, names: points.into_iter().map(|(_, n)| n).collect(), positions })
}

fn row(
    line: usize,
    cells: &[&str],
    points: &[(usize, String)],
    unit_m: f64,
) -> Result<Vec<Option<Vec3>>, Fault> {
    let number = |i: usize| {
        cell(cells[i]).map_err(|()| {
            let message = format!("column {}: `{}` is no number", i + 1, shown(cells[i]));
            Fault::at(line, message, "give numbers with decimal points; NaN where nothing was seen")
        })
    };
    points
        .iter()
        .map(|(at, _)| Ok(place([number(*at)?, number(at + 1)?, number(at + 2)?], unit_m)))
        .collect()
}

fn qualisys(text: &str, map: &TableMap) -> Result<Markers, Fault> {
    const AGAIN: &str = "export it again as TSV, with the header";
    let lines: Vec<Vec<&str>> = text
        .lines()
        .map(|l| l.trim_end_matches('\r').split('\t').map(str::trim).collect())
        .collect();
    let key = |name: &str| lines.iter().find(|cells| cells[0] == name).map(|cells| &cells[1..]);
    let labels: Vec<String> = key("MARKER_NAMES")
        .unwrap_or_default()
        .iter()
        .filter(|n| !n.is_empty())
        .map(|n| (*n).to_owned())
        .collect();
    let rate = key("FREQUENCY").and_then(|cells| cells.first()?.parse::<f64>().ok());
    let rate_hz = rate
        .or(map.rate_hz)
        .filter(|r| *r > 0.0 && *r <= HIGHEST_RATE_HZ)
        .ok_or_else(|| Fault::whole("has no FREQUENCY in its header", NEEDS_RATE))?;
    let columns = 3 * labels.len();
    let is_row = |cells: &Vec<&str>| {
        cells.len() >= columns
            && cells.iter().all(|c| cell(c).is_ok())
            && cells.iter().any(|c| !c.is_empty())
    };
    let first = lines.iter().position(is_row);
    let first = first.ok_or_else(|| Fault::whole("has no row of places", AGAIN))?;
    // Before the places there may be frame and time, and behind them an empty cell.
    let width = lines[first].iter().rposition(|c| !c.is_empty()).map_or(0, |last| last + 1);
    let before @ 0..=2 = width.max(columns) - columns else {
        return Err(Fault::at(first + 1, "has more columns than three for each marker", AGAIN));
    };
    let points: Vec<(usize, String)> =
        labels.iter().enumerate().map(|(i, n)| (before + 3 * i, n.clone())).collect();
    let unit_m = map.unit_m.unwrap_or(0.001);
    let mut positions = Vec::new();
    for (i, cells) in lines.iter().enumerate().skip(first) {
        if cells.iter().all(|c| c.is_empty()) {
            continue;
        }
        if cells.len() < before + columns {
            let message =
                format!("{} cells, but the markers take {}", cells.len(), before + columns);
            return Err(Fault::at(i + 1, message, AGAIN));
        }
        let mut places = row(i + 1, cells, &points, unit_m)?;
        for place in &mut places {
            *place = place.filter(|p| p.amax() > 0.0);
        }
        positions.push(places);
    }
    Ok(Markers { rate_hz, names: without_people(&labels), positions })
}

/// A table whose header names columns `POINT_x`, `POINT_y`, `POINT_z`, parted by any sign.
fn with_header(path: &Path, bytes: &[u8], map: &TableMap) -> Result<Markers, InputError> {
    let text = CsvText::of(path, bytes)?;
    let mut reader = text.reader();
    let header = reader.headers().map_err(|e| text.broken(path, &e))?.clone();
    let columns: Vec<&str> = header.iter().collect();
    let triples = triples(&columns);
    let known = || triples.iter().map(|(name, _)| name.as_str());
    if triples.is_empty() {
        return Err(InputError::new(path, "has no three columns POINT_x, POINT_y and POINT_z")
            .remedy(format!("its columns are: {}", columns.join(", "))));
    }
    if let Some(lost) = map.points.iter().find(|p| *p != SKIPPED && !known().any(|k| k == *p)) {
        let listed = format!("its points are: {}", known().collect::<Vec<_>>().join(", "));
        return Err(InputError::new(path, format!("has no point `{lost}`"))
            .remedy(suggest(lost, known()).unwrap_or(listed)));
    }
    let unit_m = map
        .unit_m
        .ok_or_else(|| InputError::new(path, "does not say its unit").remedy(NEEDS_UNIT))?;
    let time = columns.iter().position(|c| TIMES.contains(&c.to_lowercase().as_str()));
    let (mut positions, mut times) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(|e| text.broken(path, &e))?;
        let number = |i: usize| {
            let word = record.get(i).unwrap_or_default();
            match text.number(word) {
                Some(value) => Ok(Some(value).filter(|v| v.abs() <= LARGEST)),
                None => cell(word).map_err(|()| {
                    let (line, column) = (text.line(&record), columns[i]);
                    InputError::new(
                        path,
                        format!("line {line}, column `{column}`: `{}` is no number", shown(word)),
                    )
                    .remedy("leave the cell empty where nothing was seen")
                }),
            }
        };
        let mut places = Vec::with_capacity(triples.len());
        for (_, [x, y, z]) in &triples {
            places.push(place([number(*x)?, number(*y)?, number(*z)?], unit_m));
        }
        positions.push(places);
        if let Some(time) = time {
            times.extend(number(time)?);
        }
    }
    let rate_hz = match map.rate_hz {
        Some(rate) => rate,
        None => rate_of(&times, positions.len())
            .ok_or_else(|| InputError::new(path, "does not say its rate").remedy(NEEDS_RATE))?,
    };
    let names: Vec<String> = triples.into_iter().map(|(name, _)| name).collect();
    Ok(Markers { rate_hz, names, positions })
}

/// Points that have three columns, with these.
fn triples(columns: &[&str]) -> Vec<(String, [usize; 3])> {
    let split = |column: &str, axis: &str| -> Option<String> {
        let end = column.char_indices().next_back()?.0;
        let (name, last) = column.split_at(end);
        let name = name.trim_end_matches(['_', '.', ' ', '-', ':']);
        (last.eq_ignore_ascii_case(axis) && !name.is_empty() && name.len() < end)
            .then(|| name.to_owned())
    };
    let find = |name: &str, axis: &str| {
        columns.iter().position(|c| split(c, axis).is_some_and(|n| n == name))
    };
    columns
        .iter()
        .filter_map(|column| {
            let name = split(column, AXES[0])?;
            let [x, y, z] = AXES.map(|axis| find(&name, axis));
            Some((name, [x?, y?, z?]))
        })
        .collect()
}

/// Rows per second of uniform times (s).
pub(in crate::recording) fn rate_of(times: &[f64], rows: usize) -> Option<f64> {
    if times.len() != rows || rows < 2 {
        return None;
    }
    let step = (times[rows - 1] - times[0]) / (rows - 1) as f64;
    let is_even = times.windows(2).all(|w| ((w[1] - w[0]) - step).abs() <= STEP_TOLERANCE * step);
    // Times of files are rounded: a rate is a whole number unless it is clearly none.
    let rate = 1.0 / step;
    let whole = rate.round();
    let rate = if (rate - whole).abs() < 2e-3 * rate { whole } else { rate };
    (is_even && step > 0.0 && rate <= HIGHEST_RATE_HZ).then_some(rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(points: &[&str], unit_m: Option<f64>, rate_hz: Option<f64>) -> TableMap {
        TableMap {
            points: points.iter().map(|p| (*p).to_owned()).collect(),
            unit_m,
            rate_hz,
            ..TableMap::default()
        }
    }

    fn parse(text: &str, map: &TableMap) -> Result<Markers, String> {
        read(Path::new("t.tsv"), text.as_bytes(), map).map_err(|e| e.to_string())
    }

    const QUALISYS: &str = "NO_OF_FRAMES\t2\nNO_OF_CAMERAS\t8\nFREQUENCY\t100\nDESCRIPTION\t--\n\
        MARKER_NAMES\tRASI\tLASI\n1\t0.00\t1000\t2000\t3000\t10\t20\t30\n2\t0.01\t1100\t\t3000\t0\t0\t0\n";

    #[test]
    fn a_qualisys_export_says_everything_itself() {
        let found = parse(QUALISYS, &TableMap::default()).unwrap();
        assert_eq!(
            (found.rate_hz, found.names.as_slice()),
            (100.0, &["RASI".to_owned(), "LASI".into()][..])
        );
        assert_eq!(found.positions[0][0], Some(Vec3::new(1.0, 2.0, 3.0)));
        assert_eq!(found.positions[1], [None, None]);
        // Without frame and time.
        let bare = QUALISYS.replace("1\t0.00\t", "").replace("2\t0.01\t", "");
        assert_eq!(parse(&bare, &TableMap::default()).unwrap().positions, found.positions);
        let headed = QUALISYS.replace("\n1\t0.00", "\nFrame\tTime\tRASI X\tRASI Y\n1\t0.00");
        assert_eq!(parse(&headed, &TableMap::default()).unwrap().positions, found.positions);
        let lost = QUALISYS.replace("FREQUENCY\t100\n", "");
        assert!(parse(&lost, &TableMap::default()).unwrap_err().contains("FREQUENCY"));
        let broken = QUALISYS.replace("1100", "oops");
        assert!(parse(&broken, &TableMap::default()).unwrap_err().contains("`oops`"));
    }

    #[test]
    fn plain_rows_need_names_unit_and_rate() {
        let text = "1 2 3 4 5 6\n1 2 nan 4 5 6\n";
        let whole = map(&["A", "B"], Some(0.01), Some(30.0));
        let found = parse(text, &whole).unwrap();
        assert_eq!(found.positions[0][1], Some(Vec3::new(0.04, 0.05, 0.06)));
        assert_eq!(found.positions[1][0], None);
        let skipped = parse(text, &map(&["-", "B"], Some(0.01), Some(30.0))).unwrap();
        assert_eq!((skipped.names.len(), skipped.positions[0].len()), (1, 1));
        for (map, expected) in [
            (map(&[], Some(0.01), Some(30.0)), "without names"),
            (map(&["A", "B"], None, Some(30.0)), "unit"),
            (map(&["A", "B"], Some(0.01), None), "rate"),
            (map(&["A"], Some(0.01), Some(30.0)), "line 1: 6 numbers"),
        ] {
            let error = parse(text, &map).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
        assert!(parse("1 2 3 4 5 b\n", &whole).unwrap_err().contains("line 1: column 6"));
    }

    #[test]
    fn a_header_names_the_points() {
        let text = "time_s,RWrist_x,RWrist_y,RWrist_z,elbow.X,elbow.Y,elbow.Z,box\n\
                    0,1,2,3,4,5,6,9\n0.02,1,,3,4,5,6,9\n0.04,1,2,3,4,5,6,9\n";
        let found = parse(text, &map(&[], Some(0.001), None)).unwrap();
        assert_eq!((found.rate_hz, found.names.join(" ").as_str()), (50.0, "RWrist elbow"));
        assert_eq!(found.positions[1], [None, Some(Vec3::new(0.004, 0.005, 0.006))]);
        for (text, map, expected) in [
            (text.to_owned(), map(&[], None, None), "unit"),
            (text.replace("time_s", "n"), map(&[], Some(1.0), None), "rate"),
            (text.replace("0.04", "0.09"), map(&[], Some(1.0), None), "rate"),
            (text.to_owned(), map(&["RWrst"], Some(1.0), None), "no point `RWrst`"),
            (text.replace(",2,3", ",b,3"), map(&[], Some(1.0), None), "line 2, column `RWrist_y`"),
            ("a,b\n1,2\n".to_owned(), map(&[], Some(1.0), None), "POINT_x"),
        ] {
            let error = parse(&text, &map).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
