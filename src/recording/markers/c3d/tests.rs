//! Tests of the C3D reader on made-up files of a few blocks.

use super::*;
use miette::Diagnostic as _;
use proptest::prelude::*;

/// A file of two markers and one analogue channel, two frames.
struct Made {
    is_float: bool,
    unit: &'static str,
    labels: [&'static str; 2],
    processor: u8,
    /// A further list of labels in the group POINT.
    computed: &'static str,
    /// Coordinates and residuals in the file's unit.
    frames: [[[f32; 4]; 2]; 2],
}

impl Default for Made {
    fn default() -> Self {
        Self {
            is_float: true,
            unit: "mm",
            labels: ["Ann:RASI", "T10"],
            processor: INTEL,
            computed: "",
            frames: [
                [[100.0, 200.0, -300.0, 0.5], [1000.0, 0.0, 0.0, 0.0]],
                [[0.0, 0.0, 0.0, -1.0], [1.0, 2.0, 3.0, 0.0]],
            ],
        }
    }
}

/// A record of the section of parameters.
fn record(name: &str, group: i8, content: &[u8], is_last: bool) -> Vec<u8> {
    let mut bytes = vec![u8::try_from(name.len()).unwrap(), group.cast_unsigned()];
    bytes.extend_from_slice(name.as_bytes());
    let step = if is_last { 0 } else { u16::try_from(2 + content.len()).unwrap() };
    bytes.extend_from_slice(&step.to_le_bytes());
    bytes.extend_from_slice(content);
    bytes
}

/// The content of a parameter that is a list of texts.
fn texts(list: &[&str]) -> Vec<u8> {
    let width = list.iter().map(|t| t.len()).max().unwrap();
    let mut bytes = vec![0xFF, 2, u8::try_from(width).unwrap(), u8::try_from(list.len()).unwrap()];
    for text in list {
        bytes.extend_from_slice(format!("{text:width$}").as_bytes());
    }
    bytes.push(0);
    bytes
}

impl Made {
    fn bytes(&self) -> Vec<u8> {
        let scale: f32 = if self.is_float { -0.1 } else { 0.1 };
        let mut header = vec![2, KEY];
        for word in [2_u16, 1, 1, 2, 0] {
            header.extend_from_slice(&word.to_le_bytes());
        }
        header.extend_from_slice(&scale.to_le_bytes());
        for word in [3_u16, 1] {
            header.extend_from_slice(&word.to_le_bytes());
        }
        header.extend_from_slice(&50_f32.to_le_bytes());
        header.resize(BLOCK, 0);

        let mut parameters = vec![1, KEY, 1, self.processor];
        parameters.extend(record("POINT", -1, &[0], false));
        let rate = [&[4, 0][..], &100_f32.to_le_bytes(), &[0]].concat();
        parameters.extend(record("RATE", 1, &rate, false));
        let unit = [&[0xFF, 1, 2][..], format!("{:2}", self.unit).as_bytes(), &[0]].concat();
        parameters.extend(record("UNITS", 1, &unit, false));
        if !self.computed.is_empty() {
            parameters.extend(record("ANGLES", 1, &texts(&[self.computed]), false));
        }
        parameters.extend(record("LABELS", 1, &texts(&self.labels), true));
        parameters.resize(BLOCK, 0);

        let mut bytes = [header, parameters].concat();
        for frame in &self.frames {
            for value in frame.iter().flatten().chain(&[7.0]) {
                if self.is_float {
                    bytes.extend_from_slice(&value.to_le_bytes());
                } else {
                    // Coordinates over the scale; residuals are one digit.
                    let whole = if value.abs() < 1.0 { value.floor() } else { value / scale };
                    bytes.extend_from_slice(&(whole.round() as i16).to_le_bytes());
                }
            }
        }
        bytes
    }
}

fn error(bytes: &[u8]) -> Fault {
    parse(bytes).unwrap_err()
}

fn assert_place(found: Option<Vec3>, wanted: [f64; 3]) {
    assert!((found.unwrap() - Vec3::from(wanted)).norm() < 1e-6, "{found:?}, not {wanted:?}");
}

#[test]
fn floats_and_integers_hold_the_same_places() {
    for is_float in [true, false] {
        let found = parse(&Made { is_float, ..Made::default() }.bytes()).unwrap();
        assert_eq!((found.rate_hz, found.names.join(" ").as_str()), (100.0, "RASI T10"));
        assert_eq!(found.positions.len(), 2);
        assert_place(found.positions[0][0], [0.1, 0.2, -0.3]);
        assert_place(found.positions[0][1], [1.0, 0.0, 0.0]);
        assert_eq!(found.positions[1][0], None);
        assert_place(found.positions[1][1], [0.001, 0.002, 0.003]);
    }
}

#[test]
fn gaps_are_residuals_below_zero_zeros_and_no_numbers() {
    let mut made = Made::default();
    made.frames[0][0] = [1.0, 2.0, 3.0, -1.0];
    made.frames[0][1] = [0.0, 0.0, 0.0, 0.0];
    made.frames[1][0] = [f32::NAN, 2.0, 3.0, 0.0];
    made.frames[1][1] = [1e30, 2.0, 3.0, 0.0];
    let found = parse(&made.bytes()).unwrap();
    assert!(found.positions.iter().flatten().all(Option::is_none));
}

#[test]
fn units_are_those_of_the_file_and_what_is_no_place_is_left_out() {
    let found = parse(&Made { unit: "m", ..Made::default() }.bytes()).unwrap();
    assert_place(found.positions[0][0], [100.0, 200.0, -300.0]);
    let made = Made { labels: ["T10", "Knee"], computed: "Knee", ..Made::default() };
    let found = parse(&made.bytes()).unwrap();
    assert_eq!((found.names.join(" ").as_str(), found.positions[0].len()), ("T10", 1));
}

#[test]
fn damaged_files_are_refused_with_a_remedy() {
    let good = Made::default().bytes();
    let set = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] = value;
        bytes
    };
    for (bytes, expected) in [
        (vec![], "is no C3D file"),
        (set(1, 0), "is no C3D file"),
        (good[..40].to_vec(), "cut off within its header"),
        (set(0, 0), "names no block"),
        (set(0, 200), "no section of parameters"),
        (set(2, 0), "holds no markers"),
        (set(15, 0xFF), "a scale of"),
        (set(6, 9), "its frames go from 9 to 2"),
        (set(8, 9), "is cut off: 2 of 9 frames are there"),
        (good[..good.len() - 1].to_vec(), "is cut off: 1 of 2 frames are there"),
        (set(BLOCK + 12, 0xFF), "parameters are damaged"),
        (Made { processor: 86, ..Made::default() }.bytes(), "DEC or MIPS"),
        (Made { processor: 1, ..Made::default() }.bytes(), "no section of parameters"),
        (Made { unit: "yd", ..Made::default() }.bytes(), "POINT:UNITS, `yd`, is no unit"),
    ] {
        let Fault(message, _) = error(&bytes);
        assert!(message.contains(expected), "{expected}: {message}");
    }
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.c3d");
    std::fs::write(&path, b"x").unwrap();
    let error = crate::recording::read_markers(&path).unwrap_err();
    assert!(error.to_string().contains("a.c3d") && error.help().is_some());
}

#[test]
fn a_real_box_lift_has_its_known_frames_markers_and_gaps() {
    let Some(path) = crate::skips::shared("recordings/pyomeca_boxlift/box_lift.c3d") else {
        return;
    };
    let found = crate::recording::read_markers(&path).unwrap();
    assert_eq!((found.rate_hz, found.positions.len(), found.names.len()), (100.0, 580, 51));
    assert!(found.names.iter().all(|name| !name.contains(':')), "{:?}", found.names);
    let gaps = found.positions.iter().filter(|frame| frame.iter().any(Option::is_none));
    assert_eq!(gaps.count(), 219);
    // In metres: as far from the pelvis as a breastbone is, and the hand as far as a forearm is long.
    let mean = |name: &str| {
        let places: Vec<Vec3> = found.track(name).unwrap().flatten().collect();
        places.iter().sum::<Vec3>() / places.len() as f64
    };
    for (from, to, range) in [("ASISr", "STER", 0.4..0.5), ("EPICl", "STYLr", 0.15..0.3)] {
        let far = (mean(from) - mean(to)).norm();
        assert!(range.contains(&far), "{from} to {to}: {far} m");
    }
}

proptest! {
    #[test]
    fn no_damage_makes_it_panic(
        is_float in any::<bool>(),
        cut in 0.5f64..=1.0,
        changes in proptest::collection::vec((0.0f64..1.0, any::<u8>()), 0..6),
        header in proptest::collection::vec((0_usize..24, any::<u8>()), 0..2),
    ) {
        let mut bytes = Made { is_float, ..Made::default() }.bytes();
        for (at, value) in changes {
            let i = (at * bytes.len() as f64) as usize;
            bytes[i] = value;
        }
        for (at, value) in header {
            bytes[at] = value;
        }
        bytes.truncate((cut * bytes.len() as f64) as usize);
        if let Ok(found) = parse(&bytes) {
            prop_assert!(found.positions.iter().all(|frame| frame.len() == found.names.len()));
        }
    }
}
