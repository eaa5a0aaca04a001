//! Recorded movements: MVNX exports, BVH files, Acclaim motions, `OpenSim` coordinates, rigid-body CSV folders, and
//! with a [`Map`] markers, tables of points and tables of poses become one neutral type.
//!
//! A [`Recording`] holds segment poses of one person in ISB segment axes, whatever the file used.
//! The axes of every segment are x forward, y up (towards the proximal joint of a hanging limb) and
//! z right, on both sides of the body, and all of them are parallel to the pelvis in the *anatomical
//! zero pose*: standing upright, arms hanging, palms forward. A relaxed hanging right hand with the
//! thumb forward is therefore turned +90 degrees about +y, a left one -90 degrees.
//!
//! Nothing is filtered or resampled here, and nothing that could name a person is kept.

mod acclaim;
mod axes;
mod bvh;
mod checks;
mod columns;
mod lines;
mod map;
mod markers;
mod mvnx;
mod mvnx_parse;
mod opensim;
mod pose_table;
mod remark;
mod rigid_bodies;

pub use axes::{SEGMENT_NAMES, zxy_angles};
pub use map::{MAP_SCHEMA, Map, Run, read_map};
pub use markers::{Markers, read_markers};
pub use remark::{BORDERS, Remark, grouped};
pub use rigid_bodies::read_rigid_bodies;

use crate::files::{InputError, read_bytes, sha256_hex};
use crate::human::Body;
use crate::math::Vec3;
use nalgebra::UnitQuaternion;
use std::path::Path;

/// Segment poses of one person over time, in ISB segment axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Name of the file or folder read, without its path.
    pub source: String,
    /// `MVNX v3`, `MVNX v4`, `BVH`, `Acclaim ASF/AMC`, `OpenSim`, `rigid-body CSV`, `C3D markers`, `TRC markers`,
    /// `table of points` or `table of poses`.
    pub format: &'static str,
    /// SHA-256 of the bytes read; of a folder: of the person's files joined in order of their names;
    /// of an Acclaim motion: of its skeleton and itself joined.
    pub sha256: String,
    /// Frames per second, Hz.
    pub rate_hz: f64,
    /// One track per segment, in the order of [`SEGMENT_NAMES`], all of one length.
    pub segments: Vec<SegmentTrack>,
    /// Name and distance (m) between the proximal and the distal joint centre of a segment. A hand
    /// ends at its finger tip (MVNX only). `ShoulderToShoulder` and `HipToHip` are the distances
    /// between the right and left joint centres while all segments are parallel to the trunk.
    pub segment_lengths_m: Vec<(String, f64)>,
    /// Conventions applied, frames skipped and what looks suspicious.
    pub remarks: Vec<Remark>,
}

/// The pose of one segment over time.
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentTrack {
    /// One of [`SEGMENT_NAMES`].
    pub name: String,
    /// Proximal joint centre in the world (m, z up), one per frame.
    pub position: Vec<Vec3>,
    /// Rotation that maps segment axes (ISB) to world axes, one per frame, signs continuous.
    pub rotation: Vec<UnitQuaternion<f64>>,
}

impl Recording {
    /// The track of a segment.
    pub fn segment(&self, name: &str) -> Option<&SegmentTrack> {
        self.segments.iter().find(|s| s.name == name)
    }

    /// A length (m) of `segment_lengths_m` by its name.
    pub fn length_m(&self, name: &str) -> Option<f64> {
        self.segment_lengths_m.iter().find(|(n, _)| n == name).map(|(_, length)| *length)
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.segments.first().map_or(0, |s| s.position.len())
    }
}

/// How a recording is to be read.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reading<'a> {
    /// Which of several people in a folder; may be left out if there is only one. A file holds one person without
    /// a name.
    pub person: Option<&'a str>,
    /// What markers, points or columns are.
    pub map: Option<&'a Map>,
    /// On which body joint angles without lengths are put; none: a man of middle size.
    pub body: Option<&'a Body>,
}

/// Reads a recording that needs no map: an `.mvnx` file (version 3 or 4), a `.bvh` file, an `.amc` file with its
/// skeleton, `OpenSim` coordinates (`.mot`, `.sto`), or a folder of rigid-body CSV files.
///
/// The skeleton of `X.amc` is `X.asf` beside it, or the only .asf there whose name `X` begins with.
pub fn read(path: &Path, person: Option<&str>) -> Result<Recording, InputError> {
    read_with(path, &Reading { person, ..Reading::default() })
}

/// Reads a recording as [`read`] does; a map also says what C3D and TRC files, and tables (`.csv`, `.tsv`, `.txt`),
/// are of a person. Of a file with long gaps it is the longest run.
pub fn read_with(path: &Path, how: &Reading) -> Result<Recording, InputError> {
    let longest = read_runs(path, how)?
        .into_iter()
        .map(|run| run.recording)
        .reduce(|longest, next| if next.frames() > longest.frames() { next } else { longest });
    longest.ok_or_else(|| InputError::new(path, "holds no movement"))
}

/// All runs of a recording between its long gaps; one, where a file is no file of markers.
pub fn read_runs(path: &Path, how: &Reading) -> Result<Vec<Run>, InputError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if let Some(name) = how.person.filter(|_| !path.is_dir()) {
        let message = format!("holds one unnamed person, so person `{name}` cannot be picked");
        return Err(InputError::new(path, message).remedy(format!(
            "leave the person out for .{extension} files; a map names the markers of one person"
        )));
    }
    let (is_folder, of_columns) = (path.is_dir(), how.map.map(Map::is_of_columns));
    let recording = match (extension.as_str(), how.map) {
        _ if is_folder && of_columns != Some(false) => rigid_bodies::read_folder(path, how, None)?,
        (other, _) if is_folder => return Err(refusal(path, other, of_columns)),
        ("mvnx", _) => mvnx::read(path)?,
        ("amc", _) => acclaim::read(path)?,
        ("bvh", _) => bvh::read(path)?,
        ("mot" | "sto", _) if of_columns != Some(false) => read_opensim(path, how)?,
        ("csv" | "tsv" | "txt", Some(map)) if map.is_of_columns() => read_poses(path, map, how)?,
        ("c3d" | "trc" | "csv" | "tsv" | "txt", Some(map)) if !map.is_of_columns() => {
            let runs = read_points(path, &extension, map)?;
            runs.iter().try_for_each(|r| checks::refuse_impossible(path, &r.recording))?;
            return Ok(runs);
        }
        (other, _) => return Err(refusal(path, other, of_columns)),
    };
    checks::refuse_impossible(path, &recording)?;
    Ok(vec![Run { recording, first_frame: 0, gaps_filled: 0, frames_left_out: 0 }])
}

fn read_opensim(path: &Path, how: &Reading) -> Result<Recording, InputError> {
    let shipped = Map::shipped("opensim")?;
    let map = how.map.unwrap_or(&shipped);
    let bytes = read_bytes(path)?;
    let tables = opensim::read(path, &bytes, map.table())?;
    columns::record(&origin(path, "OpenSim", &bytes), &tables, map, how.body)
}

fn read_poses(path: &Path, map: &Map, how: &Reading) -> Result<Recording, InputError> {
    let bytes = read_bytes(path)?;
    let has_places = map.columns().iter().any(|p| p.place.is_some());
    let tables = pose_table::read(path, &bytes, map.table(), has_places)?;
    columns::record(&origin(path, "table of poses", &bytes), &tables, map, how.body)
}

fn read_points(path: &Path, extension: &str, map: &Map) -> Result<Vec<Run>, InputError> {
    let bytes = read_bytes(path)?;
    let (format, markers) = match extension {
        "c3d" => ("C3D markers", read_markers(path)?),
        "trc" => ("TRC markers", read_markers(path)?),
        _ => ("table of points", markers::table::read(path, &bytes, map.table())?),
    };
    map::runs(&origin(path, format, &bytes), &markers, map)
}

fn origin<'a>(path: &'a Path, format: &'static str, bytes: &[u8]) -> map::Origin<'a> {
    map::Origin { path, source: bare_name(path), format, sha256: sha256_hex(bytes) }
}

const SAY_COLUMNS: &str =
    "say with --map which columns are points or poses, and which of them make which segments";

/// Why a file of no known kind is not read.
fn refusal(path: &Path, extension: &str, of_columns: Option<bool>) -> InputError {
    let known = "known are .mvnx files (version 3 or 4), .bvh files, .amc files with their .asf, OpenSim's .mot and \
                 .sto files, folders of rigid-body CSV files named <person>_<body>_pose_saved.csv, and with a map \
                 .c3d and .trc files and tables";
    if !path.exists() {
        return InputError::new(path, "cannot be read: no such file or folder")
            .remedy("check the path; paths inside a scenario are relative to the scenario file");
    }
    match extension {
        "c3d" | "trc" if of_columns == Some(true) => {
            InputError::new(path, "holds markers, and the map tells columns of a table")
                .remedy("give a map whose segments have `joint` and two directions")
        }
        _ if of_columns == Some(false) && (path.is_dir() || ["mot", "sto"].contains(&extension)) => {
            InputError::new(path, "holds no markers, as the map tells segments by")
                .remedy("leave out --map, or give one whose segments have `turns` or `quaternion`")
        }
        "csv" if !path.to_string_lossy().ends_with("_pose_saved.csv") => {
            InputError::new(path, "is a table, which does not say what its columns are")
                .remedy(SAY_COLUMNS)
        }
        "csv" => InputError::new(path, "is one body of a rigid-body recording")
            .remedy("give the folder that holds the CSV files of all bodies instead"),
        "mvn" => InputError::new(path, "is a recording in its maker's own binary format")
            .remedy("export it as MVNX with position and orientation of the segments"),
        "c3d" | "trc" => InputError::new(path, "holds markers, not the segments of a person").remedy(
            "say with --map which markers make which segments, or let the capture program solve its skeleton \
             and export MVNX or BVH",
        ),
        "tsv" | "txt" => InputError::new(path, "is a table, which does not say what its columns are")
            .remedy(SAY_COLUMNS),
        "asf" => InputError::new(path, "is a skeleton without its motion")
            .remedy("give the .amc file beside it"),
        "" => InputError::new(path, "has no extension that tells its kind").remedy(known),
        other => InputError::new(path, format!("`.{other}` is no kind of recording known here"))
            .remedy(known),
    }
}

/// The name of a file or folder without its path, even for `.`.
fn bare_name(path: &Path) -> String {
    let full = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    full.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic as _;

    #[test]
    fn unknown_kinds_are_refused_with_a_remedy() {
        let room = tempfile::tempdir().unwrap();
        for (name, expected) in [
            ("walk.fbx", "`.fbx` is no kind"),
            ("walk", "no extension"),
            ("giver_hip_pose_saved.csv", "one body"),
            ("walk.mvn", "binary format"),
            ("walk.asf", "without its motion"),
            ("walk.c3d", "holds markers"),
            ("walk.TRC", "holds markers"),
            ("walk.tsv", "is a table"),
        ] {
            let path = room.path().join(name);
            std::fs::write(&path, b"x").unwrap();
            let error = read(&path, None).unwrap_err();
            assert!(error.message().contains(expected), "{error}");
            assert!(error.help().is_some());
        }
        let error = read(&room.path().join("none.fbx"), None).unwrap_err();
        assert!(error.message().contains("no such file"), "{error}");
        assert!(read(&room.path().join("none.mvnx"), None).is_err());
        let error = read(&room.path().join("none.mvnx"), Some("Ann")).unwrap_err();
        assert!(error.message().contains("`Ann`"), "{error}");
    }
}
