//! Places of markers over time, as C3D and TRC files and tables hold them: not yet the segments of a person.

mod c3d;
pub(super) mod table;
mod trc;

use crate::files::InputError;
use crate::math::Vec3;
use std::collections::BTreeMap;
use std::path::Path;

/// Lengths of the units that marker files name, m.
const UNITS_M: [(&str, f64); 9] = [
    ("m", 1.0),
    ("meters", 1.0),
    ("metres", 1.0),
    ("dm", 0.1),
    ("cm", 0.01),
    ("mm", 0.001),
    ("in", 0.0254),
    ("inches", 0.0254),
    ("ft", 0.3048),
];
pub(super) const KNOWN_UNITS: &str =
    "known units are m, cm, mm, in and ft: export the file in one of them";
/// Highest rate believed, Hz.
pub(super) const HIGHEST_RATE_HZ: f64 = 10_000.0;

/// Markers over time, in the axes of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Markers {
    /// Frames per second, Hz.
    pub rate_hz: f64,
    /// Names of the markers, without those of the people that wore them.
    pub names: Vec<String>,
    /// Place of each marker (m), a row for each frame in the order of the names; none where it was not
    /// seen.
    pub positions: Vec<Vec<Option<Vec3>>>,
}

impl Markers {
    /// Places (m) of a marker over time.
    pub fn track(&self, name: &str) -> Option<impl Iterator<Item = Option<Vec3>>> {
        let i = self.names.iter().position(|n| n == name)?;
        Some(self.positions.iter().map(move |frame| frame[i]))
    }
}

/// Reads the markers of a `.c3d` file (of Intel numbers) or a `.trc` file.
pub fn read_markers(path: &Path) -> Result<Markers, InputError> {
    match path.extension().unwrap_or_default().to_string_lossy().to_lowercase().as_str() {
        "c3d" => c3d::read(path),
        "trc" => trc::read(path),
        _ => {
            Err(InputError::new(path, "is no file of markers")
                .remedy("known are .c3d and .trc files"))
        }
    }
}

/// The length of a unit (m) by its name.
pub(super) fn unit_m(name: &str) -> Option<f64> {
    let name = name.trim();
    UNITS_M.iter().find(|(unit, _)| unit.eq_ignore_ascii_case(name)).map(|(_, length)| *length)
}

/// Names without what stands before a colon, which is whom they belong to. Where two would then be alike,
/// the people are counted instead; markers without a name are told by their number.
fn without_people(labels: &[String]) -> Vec<String> {
    let parts = labels.iter().enumerate().map(|(i, label)| {
        let (person, name) = label.rsplit_once(':').unwrap_or(("", label));
        let name = name.trim();
        (person, if name.is_empty() { format!("#{}", i + 1) } else { name.to_owned() })
    });
    let parts: Vec<(&str, String)> = parts.collect();
    let mut people: BTreeMap<&str, usize> = BTreeMap::new();
    let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
    for (person, name) in &parts {
        let number = people.len() + 1;
        people.entry(person).or_insert(number);
        *uses.entry(name).or_default() += 1;
    }
    let mut given: BTreeMap<String, usize> = BTreeMap::new();
    let mut names = Vec::with_capacity(parts.len());
    for (person, name) in &parts {
        let full = if uses[name.as_str()] == 1 {
            name.clone()
        } else {
            format!("{}:{name}", people[person])
        };
        let count = given.entry(full.clone()).or_default();
        *count += 1;
        names.push(if *count == 1 { full } else { format!("{full}#{count}") });
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_people_are_left_out_and_markers_stay_apart() {
        let names = |labels: &[&str]| {
            without_people(&labels.iter().map(|l| (*l).to_owned()).collect::<Vec<_>>()).join(" ")
        };
        assert_eq!(names(&["Ann:RASI", "Ann:LASI ", "T10"]), "RASI LASI T10");
        assert_eq!(names(&["Ann:RASI", "Bob:RASI", "Bob:T10"]), "1:RASI 2:RASI T10");
        assert_eq!(names(&["Ann:RASI", "Ann:RASI", "", ""]), "1:RASI 1:RASI#2 #3 #4");
    }

    #[test]
    fn other_files_are_refused() {
        assert!(
            read_markers(Path::new("walk.bvh")).unwrap_err().to_string().contains("no file of")
        );
        assert!(read_markers(Path::new("none.c3d")).is_err());
        assert!(read_markers(Path::new("none.trc")).is_err());
    }
}
