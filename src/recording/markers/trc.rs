//! TRC files: a table of marker places with a header of five lines, parted by tabs.
//!
//! ```text
//! PathFileType  4  (X/Y/Z)  name
//! DataRate  CameraRate  NumFrames  NumMarkers  Units  ..
//! 100  100  2  2  mm  ..
//! Frame#  Time  first                second
//!               X1     Y1     Z1     X2     Y2     Z2
//! 1       0.00  1.0    2.0    3.0    4.0    5.0    6.0
//! ```
//! Three empty cells are a marker that was not seen.

use super::{HIGHEST_RATE_HZ, KNOWN_UNITS, Markers, unit_m, without_people};
use crate::files::{InputError, read_bytes};
use crate::math::Vec3;
use crate::recording::lines::{Fault, number, shown};
use std::path::Path;

const AGAIN: &str = "copy or export the file again, with its columns parted by tabs";

/// Reads a file.
pub(super) fn read(path: &Path) -> Result<Markers, InputError> {
    let bytes = read_bytes(path)?;
    parse(&String::from_utf8_lossy(&bytes)).map_err(|fault| fault.of(path))
}

fn parse(text: &str) -> Result<Markers, Fault> {
    let lines: Vec<Vec<&str>> = text
        .trim_start_matches('\u{feff}')
        .lines()
        .map(|line| line.trim_end_matches('\r').split('\t').map(str::trim).collect())
        .collect();
    let [first, keys, values, labels, ..] = lines.as_slice() else {
        return Err(Fault::whole("is cut off within its header", AGAIN));
    };
    if !first.first().is_some_and(|word| word.eq_ignore_ascii_case("PathFileType")) {
        return Err(Fault::at(1, "does not begin with `PathFileType`", "is it a .trc file?"));
    }
    let header = Header::read(keys, values)?;
    let names = names(labels, header.markers)?;
    // Behind a line of axes and often an empty one.
    let rows = lines.iter().enumerate().skip(4).skip_while(|(_, cells)| !is_row(cells));
    let rows = rows.filter(|(_, cells)| cells.iter().any(|cell| !cell.is_empty()));
    let positions: Vec<Vec<Option<Vec3>>> = rows
        .map(|(i, cells)| row(i + 1, cells, &names, header.unit_m))
        .collect::<Result<_, _>>()?;
    if positions.len() != header.frames || positions.is_empty() {
        let message = format!("NumFrames says {}, but {} follow", header.frames, positions.len());
        return Err(Fault::at(3, message, AGAIN));
    }
    Ok(Markers { rate_hz: header.rate_hz, names: without_people(&names), positions })
}

struct Header {
    rate_hz: f64,
    frames: usize,
    markers: usize,
    unit_m: f64,
}

impl Header {
    fn read(keys: &[&str], values: &[&str]) -> Result<Self, Fault> {
        let value = |key: &str| {
            let at = keys.iter().position(|k| k.eq_ignore_ascii_case(key));
            let value = at.and_then(|at| values.get(at)).filter(|value| !value.is_empty());
            value.ok_or_else(|| Fault::at(3, format!("lacks a value of `{key}`"), AGAIN))
        };
        let wrong = |key: &str, value: &str, remedy: &'static str| {
            Fault::at(3, format!("`{key}`: `{}` is not known", shown(value)), remedy)
        };
        let count = |key: &str| {
            let value = value(key)?;
            value.parse().map_err(|_| wrong(key, value, AGAIN))
        };
        let rate = value("DataRate")?;
        let units = value("Units")?;
        Ok(Self {
            rate_hz: number(rate)
                .filter(|rate| *rate > 0.0 && *rate <= HIGHEST_RATE_HZ)
                .ok_or_else(|| wrong("DataRate", rate, AGAIN))?,
            frames: count("NumFrames")?,
            markers: count("NumMarkers")?,
            unit_m: unit_m(units).ok_or_else(|| wrong("Units", units, KNOWN_UNITS))?,
        })
    }
}

/// The names above every third column after frame and time.
fn names(cells: &[&str], count: usize) -> Result<Vec<String>, Fault> {
    let named = cells.iter().skip(2).enumerate().filter(|(_, cell)| !cell.is_empty());
    let names: Vec<(usize, &str)> = named.map(|(i, cell)| (i, *cell)).collect();
    if let Some((_, name)) =
        names.iter().enumerate().find(|(k, (i, _))| *i != 3 * k).map(|(_, n)| n)
    {
        let message = format!("`{}` does not stand above its own three columns", shown(name));
        return Err(Fault::at(4, message, AGAIN));
    }
    if names.len() != count || count == 0 {
        let message = format!("names {} markers, but NumMarkers says {count}", names.len());
        return Err(Fault::at(4, message, AGAIN));
    }
    Ok(names.into_iter().map(|(_, name)| name.to_owned()).collect())
}

/// Whether a line begins with the number of a frame.
fn is_row(cells: &[&str]) -> bool {
    cells.first().is_some_and(|cell| cell.parse::<u64>().is_ok())
}

fn row(
    line: usize,
    cells: &[&str],
    names: &[String],
    unit_m: f64,
) -> Result<Vec<Option<Vec3>>, Fault> {
    // Programs end lines with a tab, or leave out the empty cells at their end.
    let beyond = cells.iter().skip(2 + 3 * names.len()).any(|cell| !cell.is_empty());
    if !is_row(cells) || cells.len() < 2 || beyond {
        let message = format!("is no frame of {} markers", names.len());
        return Err(Fault::at(line, message, AGAIN));
    }
    let cell = |i: usize| cells.get(i).copied().unwrap_or_default();
    let value = |name: &str, cell: &str| match number(cell) {
        Some(value) => Ok(Some(value)),
        None if cell.is_empty() || cell.eq_ignore_ascii_case("nan") => Ok(None),
        None => {
            let message = format!("`{}`: `{}` is no number", shown(name), shown(cell));
            Err(Fault::at(line, message, AGAIN))
        }
    };
    let place = |(k, name): (usize, &String)| {
        let [x, y, z] = [2, 3, 4].map(|i| value(name, cell(3 * k + i)));
        match (x?, y?, z?) {
            (Some(x), Some(y), Some(z)) => Ok(Some(unit_m * Vec3::new(x, y, z))),
            (None, None, None) => Ok(None),
            _ => {
                let message = format!("`{}` lacks a part of its place", shown(name));
                Err(Fault::at(line, message, AGAIN))
            }
        }
    };
    names.iter().enumerate().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic as _;
    use proptest::prelude::*;

    const GOOD: &str = "PathFileType\t4\t(X/Y/Z)\tann.trc\n\
        DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\n\
        100.0\t100.0\t2\t2\tmm\t100.0\n\
        Frame#\tTime\tAnn:RASI\t\t\tT10\t\t\n\
        \t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\
        \n\
        1\t0.00\t100\t200\t300\t-1.5\t0\t1000\t\n\
        2\t0.01\t\t\t\t1\t2\t3\n";

    #[test]
    fn places_are_read_in_metres_and_gaps_are_kept() {
        let found = parse(GOOD).unwrap();
        assert_eq!((found.rate_hz, found.names.join(" ").as_str()), (100.0, "RASI T10"));
        let at = |x: f64, y: f64, z: f64| Some(Vec3::new(x, y, z));
        assert_eq!(found.positions[0], [at(0.1, 0.2, 0.3), at(-0.0015, 0.0, 1.0)]);
        assert_eq!(found.positions[1][0], None);
        assert_eq!(found.track("RASI").unwrap().flatten().count(), 1);
        assert!(found.track("LASI").is_none());
        // Empty cells at the end of a line may be left out.
        let short = GOOD.replace("2\t0.01\t\t\t\t1\t2\t3", "2\t0.01\t1\t2\t3");
        assert_eq!(parse(&short).unwrap().positions[1][1], None);
    }

    #[test]
    fn a_damaged_file_is_named_with_its_line() {
        for (from, to, expected) in [
            ("PathFileType", "Path", "line 1: does not begin"),
            ("100.0\t100.0\t2", "0\t100.0\t2", "line 3: `DataRate`: `0`"),
            ("\t2\t2\tmm", "\t2\t2\tyd", "line 3: `Units`: `yd`"),
            ("\t2\t2\tmm", "\t2\tx\tmm", "line 3: `NumMarkers`: `x`"),
            ("\t2\t2\tmm", "\t2\t3\tmm", "line 4: names 2 markers, but NumMarkers says 3"),
            ("\t2\t2\tmm", "\t9\t2\tmm", "line 3: NumFrames says 9, but 2 follow"),
            ("NumFrames", "Frames", "line 3: lacks a value of `NumFrames`"),
            ("RASI\t\t\t", "RASI\t\t", "line 4: `T10` does not stand above"),
            ("-1.5", "much", "line 7: `T10`: `much` is no number"),
            ("-1.5", "1e99", "line 7: `T10`: `1e99` is no number"),
            ("-1.5", "", "line 7: `T10` lacks a part"),
            ("1\t2\t3\n", "1\t2\t3\t4\n", "line 8: is no frame of 2 markers"),
            ("2\t0.01", "x\t0.01", "line 8: is no frame of 2 markers"),
        ] {
            let text = GOOD.replacen(from, to, 1);
            assert_ne!(text, GOOD);
            let error = parse(&text).unwrap_err().of(Path::new("a.trc"));
            assert!(error.message().contains(expected), "{expected}: {error}");
            assert!(error.help().is_some());
        }
        assert!(parse("").is_err());
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
                prop_assert!(found.positions.iter().all(|frame| frame.len() == found.names.len()));
            }
        }
    }
}
