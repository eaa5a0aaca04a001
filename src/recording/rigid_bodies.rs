//! Folders of rigid-body CSV files: a solved skeleton, one file per body and person.
//!
//! A map says how files are named after person and body, and which columns hold their poses. Without one files are
//! `<person>_<body>_pose_saved.csv` with columns x, y, z (m) and q0..q3, a quaternion with the scalar last that maps
//! body axes to the world (z up). Other files are ignored.

use super::checks::refuse_impossible;
use super::columns::{Angle, OneTable, Tables, record};
use super::map::{BODY, Map, Origin, PERSON};
use super::markers::table::{NEEDS_RATE, NEEDS_UNIT};
use super::{Reading, Recording, Remark, bare_name};
use crate::files::{InputError, NumericTable, read_bytes, sha256_hex, suggest};
use std::path::{Path, PathBuf};

/// The map of folders that come without one.
const SHIPPED: &str = "rigid_bodies";

/// The CSV file of one body.
struct BodyFile {
    person: String,
    body: String,
    path: PathBuf,
}

/// Reads one person of a folder of rigid-body CSV files, recorded at `rate_hz`.
///
/// `person` may be left out if the folder holds only one.
pub fn read_rigid_bodies(
    folder: &Path,
    person: Option<&str>,
    rate_hz: f64,
) -> Result<Recording, InputError> {
    if !(rate_hz > 0.0 && rate_hz <= 10_000.0) {
        return Err(InputError::new(folder, format!("{rate_hz} is no rate in Hz"))
            .remedy("rates lie between 0 and 10000 frames per second"));
    }
    let recording = read_folder(folder, &Reading { person, ..Reading::default() }, Some(rate_hz))?;
    refuse_impossible(folder, &recording)?;
    Ok(recording)
}

/// Reads a folder as a map says, or else as those are that the shipped map tells.
pub(super) fn read_folder(
    folder: &Path,
    how: &Reading,
    rate_hz: Option<f64>,
) -> Result<Recording, InputError> {
    let shipped = Map::shipped(SHIPPED)?;
    let map = how.map.unwrap_or(&shipped);
    let Some(pattern) = &map.table().files else {
        let message = format!("is a folder, and the map `{}` does not name its files", map.name);
        return Err(InputError::new(folder, message)
            .remedy("say under [map] how they are named: files = \"{person}_{body}.csv\""));
    };
    let rate_hz = rate_hz
        .or(map.table().rate_hz)
        .ok_or_else(|| InputError::new(folder, "does not say its rate").remedy(NEEDS_RATE))?;
    let unit_m = map
        .table()
        .unit_m
        .ok_or_else(|| InputError::new(folder, "does not say its unit").remedy(NEEDS_UNIT))?;
    let mut remarks =
        vec![Remark::new("rate", format!("rate taken as {rate_hz} Hz: the files do not hold it"))];
    if how.map.is_none() {
        remarks.extend(conventions());
    }
    let files = list(folder, pattern, map, &mut remarks)?;
    let person = pick(folder, &files, how.person)?;
    let (mut all, mut bytes): (Vec<OneTable>, Vec<u8>) = (Vec::new(), Vec::new());
    for file in files.iter().filter(|f| f.person == person) {
        let text = read_bytes(&file.path)?;
        let table = NumericTable::parse(&file.path, &text)?;
        if let Some(first) = all.first().filter(|f| f.table.rows.len() != table.rows.len()) {
            let message = format!(
                "holds {} rows, but {} holds {}",
                table.rows.len(),
                bare_name(&first.path),
                first.table.rows.len()
            );
            return Err(InputError::new(&file.path, message)
                .remedy("all bodies of a person need the same frames"));
        }
        bytes.extend_from_slice(&text);
        all.push(OneTable { path: file.path.clone(), body: Some(file.body.clone()), table });
    }
    let pelvis = map.columns().iter().find(|p| p.name == "Pelvis");
    let pelvis = pelvis.and_then(|p| p.body.as_ref());
    if let Some(body) = pelvis.filter(|b| !all.iter().any(|t| t.body.as_ref() == Some(b))) {
        let file = pattern.replace(PERSON, &person).replace(BODY, body);
        let message = format!("`{person}` has no file for the body `{body}`");
        return Err(InputError::new(folder, message)
            .remedy(format!("add {file}: everything is related to the pelvis")));
    }
    let origin = Origin {
        path: folder,
        source: bare_name(folder),
        format: "rigid-body CSV",
        sha256: sha256_hex(&bytes),
    };
    let angle = Angle { rad: map.table().angle_rad, is_doubtful: false };
    record(&origin, &Tables { all, rate_hz, unit_m, angle, remarks }, map, how.body)
}

fn conventions() -> [Remark; 3] {
    [
        Remark::new(
            "axes",
            "bodies are parallel (x left, y back, z up) in a T-pose with palms down; a constant turn per \
         body brings them to the anatomical zero (arms hanging, palms forward)",
        ),
        Remark::new(
            "elbow",
            "the axial rotation of the upper arm is the file's own: elbow flexion is then about z up \
             to the carrying angle",
        ),
        Remark::new("trunk segments", "body `ab` (abdomen) is taken as L3, `chest` as T8"),
    ]
}

/// All bodies of all persons in the folder, in order of file names.
fn list(
    folder: &Path,
    pattern: &str,
    map: &Map,
    remarks: &mut Vec<Remark>,
) -> Result<Vec<BodyFile>, InputError> {
    let io = |e: std::io::Error| InputError::new(folder, format!("cannot be read: {e}"));
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        paths.push(entry.map_err(io)?.path());
    }
    paths.sort();
    let known: Vec<&str> = map.columns().iter().filter_map(|p| p.body.as_deref()).collect();
    // What ends all names.
    let ending = pattern.rsplit('}').next().unwrap_or_default();
    let mut files = Vec::new();
    let mut ignored = Vec::new();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // Of two bodies whose names end alike the longer is meant.
        let fits = known.iter().filter_map(|body| Some((*body, person_in(&name, pattern, body)?)));
        match fits.max_by_key(|(body, _)| body.len()) {
            Some((body, person)) => files.push(BodyFile { person, body: body.to_owned(), path }),
            None if name.ends_with(ending) => ignored.push(name),
            None => {}
        }
    }
    if files.is_empty() {
        let shown = pattern.replace('{', "<").replace('}', ">");
        return Err(InputError::new(folder, format!("holds no file named {shown}"))
            .remedy(format!("bodies known here: {}", known.join(", "))));
    }
    if !ignored.is_empty() {
        let text = format!("not a body of a person, left out: {}", ignored.join(", "));
        remarks.push(Remark::new("other files", text).of_size(ignored.len() as f64));
    }
    Ok(files)
}

/// The person whose body a file is, if its name is of the pattern.
fn person_in(name: &str, pattern: &str, body: &str) -> Option<String> {
    let pattern = pattern.replace(BODY, body);
    let (before, after) = pattern.split_once(PERSON)?;
    let person = name.strip_prefix(before)?.strip_suffix(after)?;
    (!person.is_empty()).then(|| person.to_owned())
}

fn pick(folder: &Path, files: &[BodyFile], person: Option<&str>) -> Result<String, InputError> {
    let mut present: Vec<&str> = files.iter().map(|f| f.person.as_str()).collect();
    present.sort_unstable();
    present.dedup();
    let listed = || format!("present are: {}", present.join(", "));
    match (person, present.as_slice()) {
        (Some(name), _) if present.contains(&name) => Ok(name.to_owned()),
        (Some(name), _) => {
            let help = suggest(name, present.iter().copied())
                .map_or_else(listed, |near| format!("{near} ({})", listed()));
            Err(InputError::new(folder, format!("holds no person `{name}`")).remedy(help))
        }
        (None, [one]) => Ok((*one).to_owned()),
        (None, _) => {
            Err(InputError::new(folder, format!("holds {} persons; pick one", present.len()))
                .remedy(listed()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use miette::Diagnostic as _;

    const SUFFIX: &str = "_pose_saved.csv";

    fn bodies() -> Vec<String> {
        let map = Map::shipped(SHIPPED).unwrap();
        map.columns().iter().map(|p| p.body.clone().unwrap()).collect()
    }

    /// A person whose bodies are all parallel, facing +x (x left = +y), for a few frames.
    fn write_person(folder: &Path, person: &str) {
        let facing = "0,0,0.7071068,0.7071068";
        for (i, body) in bodies().iter().enumerate() {
            let sign = if i % 2 == 0 { "" } else { "-" };
            let flipped: Vec<String> = facing.split(',').map(|v| format!("{sign}{v}")).collect();
            let rows = [facing.to_owned(), flipped.join(","), facing.to_owned()]
                .map(|q| format!("0.1,{i}.5,1,{q}\n"))
                .concat();
            let rows = rows.replace("--", "");
            let text = format!("x,y,z,q0,q1,q2,q3\n{rows}");
            std::fs::write(folder.join(format!("{person}_{body}{SUFFIX}")), text).unwrap();
        }
    }

    #[test]
    fn reads_one_person_and_lists_several() {
        let room = tempfile::tempdir().unwrap();
        write_person(room.path(), "ann");
        std::fs::write(room.path().join("box_pose_saved.csv"), "x\n1\n").unwrap();
        let one = read_rigid_bodies(room.path(), None, 100.0).unwrap();
        assert_eq!((one.segments.len(), one.frames(), one.rate_hz), (13, 3, 100.0));
        assert!(one.remarks.iter().any(|n| n.text.contains("box_pose_saved.csv")));
        let pelvis = one.segment("Pelvis").unwrap();
        assert!((pelvis.rotation[0] * Vec3::x() - Vec3::x()).norm() < 1e-6);
        assert!((pelvis.rotation[0] * Vec3::z() + Vec3::y()).norm() < 1e-6);
        // The same rotation with the other sign is no turn.
        let head = one.segment("Neck").unwrap();
        assert!(head.rotation[0].coords.dot(&head.rotation[1].coords) > 0.99);

        write_person(room.path(), "bob");
        let error = read_rigid_bodies(room.path(), None, 100.0).unwrap_err();
        assert_eq!(error.help().unwrap().to_string(), "present are: ann, bob");
        let error = read_rigid_bodies(room.path(), Some("bop"), 100.0).unwrap_err();
        assert!(error.help().unwrap().to_string().contains("did you mean `bob`?"));
        let other = read_rigid_bodies(room.path(), Some("bob"), 100.0).unwrap();
        assert_eq!(other.sha256, one.sha256);
    }

    #[test]
    fn refuses_gaps_norms_and_unequal_files() {
        let room = tempfile::tempdir().unwrap();
        assert!(read_rigid_bodies(room.path(), None, 100.0).is_err());
        write_person(room.path(), "ann");
        assert!(read_rigid_bodies(room.path(), None, f64::NAN).is_err());
        let path = room.path().join(format!("ann_chest{SUFFIX}"));
        let good = std::fs::read_to_string(&path).unwrap();
        let header = "x,y,z,q0,q1,q2,q3\n";
        for (text, expected) in [
            (good.replacen("0.1", "nan", 1), "line 2, column `x`"),
            (good.replacen("0.1", "", 1), "line 2, column `x`"),
            (good.replacen("0.7071068", "0", 1), "row 1 (frame 0): the quaternion has norm 0.707"),
            (format!("{header}0,0,0,0,0,0,1\n"), "holds 1 rows"),
            (header.to_owned(), "no rows"),
            (good.replacen("q3", "w", 1), "has no column `q3`"),
        ] {
            std::fs::write(&path, text).unwrap();
            let error = read_rigid_bodies(room.path(), None, 100.0).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
        std::fs::remove_file(room.path().join(format!("ann_hip{SUFFIX}"))).unwrap();
        let error = read_rigid_bodies(room.path(), None, 100.0).unwrap_err();
        assert!(error.message().contains("`hip`"), "{error}");
    }
}
