//! Folders of rigid-body CSV files: a solved skeleton, one file per body and person.
//!
//! Files are named `<person>_<body>_pose_saved.csv` and hold columns x, y, z (m) and q0..q3, a
//! quaternion with the scalar last that maps body axes to the world (z up). Other files are ignored.

use super::axes::rigid_body_from_isb;
use super::checks::{make_continuous, note_oddities, sort_segments, unit};
use super::{Recording, Remark, SegmentTrack, bare_name};
use crate::files::{InputError, NumericTable, read_bytes, sha256_hex, suggest};
use crate::math::Vec3;
use crate::math::stats::quantile;
use std::path::{Path, PathBuf};

/// Rate of rigid-body recordings (Hz) unless stated; the files do not hold it.
pub const RIGID_BODY_RATE_HZ: f64 = 120.0;

const SUFFIX: &str = "_pose_saved.csv";

/// Bodies and the segments they become. The abdomen spans 14 to 54 % of the way from the pelvis to
/// the neck, where MVNX has L5 (19 to 39 %) and L3 (39 to 57 %); T12 begins only at 57 %. It is
/// called L3 because its turn against the pelvis is that of the whole lumbar spine.
const BODIES: [(&str, &str); 13] = [
    ("hip", "Pelvis"),
    ("ab", "L3"),
    ("chest", "T8"),
    ("neck", "Neck"),
    ("head", "Head"),
    ("RShoulder", "RightShoulder"),
    ("RUArm", "RightUpperArm"),
    ("RFArm", "RightForeArm"),
    ("RHand", "RightHand"),
    ("LShoulder", "LeftShoulder"),
    ("LUArm", "LeftUpperArm"),
    ("LFArm", "LeftForeArm"),
    ("LHand", "LeftHand"),
];

/// The next body up or out, whose origin is the distal joint centre.
const NEXT: [(&str, &str); 8] = [
    ("Pelvis", "L3"),
    ("L3", "T8"),
    ("T8", "Neck"),
    ("Neck", "Head"),
    ("RightUpperArm", "RightForeArm"),
    ("RightForeArm", "RightHand"),
    ("LeftUpperArm", "LeftForeArm"),
    ("LeftForeArm", "LeftHand"),
];

/// The CSV file of one body.
struct Body {
    person: String,
    segment: &'static str,
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
    let mut remarks = conventions(rate_hz);
    let bodies = list(folder, &mut remarks)?;
    let person = pick(folder, &bodies, person)?;
    let bodies: Vec<&Body> = bodies.iter().filter(|b| b.person == person).collect();
    if !bodies.iter().any(|b| b.segment == "Pelvis") {
        return Err(InputError::new(folder, format!("`{person}` has no file for the body `hip`"))
            .remedy(format!("add {person}_hip{SUFFIX}: everything is related to the pelvis")));
    }
    let mut bytes = Vec::new();
    let mut segments: Vec<SegmentTrack> = Vec::new();
    for body in bodies {
        let text = read_bytes(&body.path)?;
        let track = track(body, &text)?;
        if let Some(first) = segments.first().filter(|f| f.position.len() != track.position.len()) {
            return Err(InputError::new(
                &body.path,
                format!(
                    "holds {} rows, but the file of {} holds {}",
                    track.position.len(),
                    first.name,
                    first.position.len()
                ),
            )
            .remedy("all bodies of a person need the same frames"));
        }
        bytes.extend_from_slice(&text);
        segments.push(track);
    }
    sort_segments(&mut segments);
    let mut recording = Recording {
        source: bare_name(folder),
        format: "rigid-body CSV",
        sha256: sha256_hex(&bytes),
        rate_hz,
        segments,
        segment_lengths_m: Vec::new(),
        remarks,
    };
    recording.segment_lengths_m = segment_lengths(&recording);
    note_oddities(&mut recording);
    Ok(recording)
}

fn conventions(rate_hz: f64) -> Vec<Remark> {
    vec![
        Remark::new("rate", format!("rate taken as {rate_hz} Hz: the files do not hold it")),
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
fn list(folder: &Path, remarks: &mut Vec<Remark>) -> Result<Vec<Body>, InputError> {
    let io = |e: std::io::Error| InputError::new(folder, format!("cannot be read: {e}"));
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        paths.push(entry.map_err(io)?.path());
    }
    paths.sort();
    let mut bodies = Vec::new();
    let mut ignored = Vec::new();
    for path in paths {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let Some(stem) = name.strip_suffix(SUFFIX) else { continue };
        let known = stem.rsplit_once('_').and_then(|(person, body)| {
            let (_, segment) = BODIES.iter().find(|(b, _)| *b == body)?;
            (!person.is_empty()).then(|| (person.to_owned(), *segment))
        });
        match known {
            Some((person, segment)) => bodies.push(Body { person, segment, path }),
            None => ignored.push(name),
        }
    }
    if bodies.is_empty() {
        let known: Vec<&str> = BODIES.iter().map(|(b, _)| *b).collect();
        return Err(InputError::new(
            folder,
            format!("holds no file named <person>_<body>{SUFFIX}"),
        )
        .remedy(format!("bodies known here: {}", known.join(", "))));
    }
    if !ignored.is_empty() {
        let text = format!("not a body of a person, left out: {}", ignored.join(", "));
        remarks.push(Remark::new("other files", text).of_size(ignored.len() as f64));
    }
    Ok(bodies)
}

fn pick(folder: &Path, bodies: &[Body], person: Option<&str>) -> Result<String, InputError> {
    let mut present: Vec<&str> = bodies.iter().map(|b| b.person.as_str()).collect();
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

fn track(body: &Body, bytes: &[u8]) -> Result<SegmentTrack, InputError> {
    let table = NumericTable::parse(&body.path, bytes)?;
    let mut columns = [0; 7];
    for (index, name) in columns.iter_mut().zip(["x", "y", "z", "q0", "q1", "q2", "q3"]) {
        *index = table.index(name)?;
    }
    let Some(constant) = rigid_body_from_isb(body.segment) else {
        return Err(InputError::new(&body.path, "has no known axes").remedy("remove the file"));
    };
    let mut position = Vec::with_capacity(table.rows.len());
    let mut rotation = Vec::with_capacity(table.rows.len());
    for (i, row) in table.rows.iter().enumerate() {
        let [x, y, z, q0, q1, q2, q3] = columns.map(|c| row[c]);
        position.push(Vec3::new(x, y, z));
        let turned = unit(q3, q0, q1, q2).map_err(|norm| {
            InputError::new(
                &body.path,
                format!("row {} (frame {i}): the quaternion has norm {norm:.3}, not 1", i + 1),
            )
            .remedy("remove the row from the files of all bodies, or repair it")
        })?;
        rotation.push(turned * constant);
    }
    make_continuous(&mut rotation);
    Ok(SegmentTrack { name: body.segment.to_owned(), position, rotation })
}

/// Medians over time, because the solved skeleton stretches a little.
fn segment_lengths(recording: &Recording) -> Vec<(String, f64)> {
    let offset = |from: &str, to: &str| -> Option<Vec3> {
        let (a, b) = (recording.segment(from)?, recording.segment(to)?);
        let local: Vec<Vec3> = (0..recording.frames())
            .map(|i| a.rotation[i].inverse() * (b.position[i] - a.position[i]))
            .collect();
        let middle = |axis: usize| {
            let values: Vec<f64> = local.iter().map(|v| v[axis]).collect();
            quantile(&values, 0.5)
        };
        Some(Vec3::new(middle(0), middle(1), middle(2)))
    };
    let mut lengths: Vec<(String, f64)> = NEXT
        .iter()
        .filter_map(|(segment, next)| Some(((*segment).to_owned(), offset(segment, next)?.norm())))
        .collect();
    // Clavicle axes are parallel to those of the trunk in the zero pose, so that offsets add up.
    let mut joint = |side: &str| -> Option<Vec3> {
        let clavicle = format!("{side}Shoulder");
        let out = offset(&clavicle, &format!("{side}UpperArm"))?;
        lengths.push((clavicle.clone(), out.norm()));
        Some(offset("T8", &clavicle)? + out)
    };
    if let (Some(right), Some(left)) = (joint("Right"), joint("Left")) {
        lengths.push(("ShoulderToShoulder".to_owned(), (right - left).norm()));
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;
    use miette::Diagnostic as _;

    /// A person whose bodies are all parallel, facing +x (x left = +y), for a few frames.
    fn write_person(folder: &Path, person: &str) {
        let facing = "0,0,0.7071068,0.7071068";
        for (i, (body, _)) in BODIES.iter().enumerate() {
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
            (format!("{header}0,0,0,0,0,0,0.5\n"), "norm 0.500"),
            (format!("{header}0,0,0,0,0,0,1\n"), "holds 1 rows"),
            (header.to_owned(), "no rows"),
            (good.replacen("q3", "w", 1), "column `q3` is missing"),
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
