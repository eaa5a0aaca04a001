//! Tables whose columns tell poses or turns of segments, by a map: CSV of any separator with a header.

use super::columns::{Angle, OneTable, Tables};
use super::map::TableMap;
use super::markers::HIGHEST_RATE_HZ;
use super::markers::table::{NEEDS_RATE, NEEDS_UNIT, TIMES, rate_of};
use crate::files::{InputError, NumericTable};
use std::path::Path;

/// Reads a table; where `has_places`, the map must say their unit.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    map: &TableMap,
    has_places: bool,
) -> Result<Tables, InputError> {
    let table = NumericTable::parse(path, bytes)?;
    let time = table.columns.iter().position(|c| TIMES.contains(&c.to_lowercase().as_str()));
    let rate_hz = match map.rate_hz {
        Some(rate) => rate,
        None => time
            .and_then(|time| {
                let times: Vec<f64> = table.rows.iter().map(|row| row[time]).collect();
                rate_of(&times, times.len())
            })
            .filter(|rate| *rate <= HIGHEST_RATE_HZ)
            .ok_or_else(|| InputError::new(path, "does not say its rate").remedy(NEEDS_RATE))?,
    };
    let unit_m = match map.unit_m {
        Some(unit) => unit,
        None if has_places => {
            return Err(InputError::new(path, "does not say its unit").remedy(NEEDS_UNIT));
        }
        None => 1.0,
    };
    Ok(Tables {
        all: vec![OneTable { path: path.to_owned(), body: None, table }],
        rate_hz,
        unit_m,
        angle: Angle { rad: map.angle_rad, is_doubtful: false },
        remarks: Vec::new(),
    })
}
