//! What a map refuses, and how recordings are cut; that poses are met is tested where bodies are fitted.

use super::file::parse_map;
use super::{Map, Origin, Run, runs};
use crate::files::InputError;
use crate::math::Vec3;
use crate::recording::Markers;
use std::path::Path;

const TRUNK: &str = r#"
[segment.Pelvis]
joint = ["RASI", "LASI"]
right = ["LASI", "RASI"]
ahead = ["SACR", ["RASI", "LASI"]]

[segment.T8]
joint = "T10"
up = ["T10", "C7"]
right = "as Pelvis"
"#;

const ARM: &str = r#"
[segment.RightUpperArm]
joint = "RSHO"
end = "joint of RightForeArm"
right = "as RightForeArm"

[segment.RightForeArm]
joint = "RELB"
end = "RWRI"
right = { hinge = ["RSHO", "RELB", "RWRI"] }

[segment.RightHand]
joint = "RWRI"
up = "as RightForeArm"
right = "as RightForeArm"
"#;

fn read(general: &str, segments: &str) -> Result<Map, InputError> {
    let text = format!("schema = \"ergopath/map/1\"\n[map]\n{general}\n{segments}");
    parse_map(Path::new("m.toml"), &text)
}

fn said(general: &str, segments: &str) -> String {
    let error = read(general, segments).unwrap_err();
    format!("{:?}", miette::Report::new(error)).replace(['\n', '│'], " ")
}

/// A person who stands and bends the right elbow, `scale` times as large, for `frames` at 100 Hz.
fn person(frames: usize, scale: f64) -> Markers {
    let at = |i: usize| {
        let bend = 0.3 + 0.01 * i as f64;
        let wrist = Vec3::new(0.25 * bend.sin(), -0.2, 1.1 - 0.25 * bend.cos());
        [
            ("RASI", Vec3::new(0.1, -0.12, 1.0)),
            ("LASI", Vec3::new(0.1, 0.12, 1.0)),
            ("SACR", Vec3::new(-0.1, 0.0, 1.0)),
            ("T10", Vec3::new(-0.1, 0.0, 1.3)),
            ("C7", Vec3::new(-0.1, 0.0, 1.5)),
            ("RSHO", Vec3::new(0.0, -0.2, 1.4)),
            ("RELB", Vec3::new(0.0, -0.2, 1.1)),
            ("RWRI", wrist),
        ]
    };
    Markers {
        rate_hz: 100.0,
        names: at(0).iter().map(|(n, _)| (*n).to_owned()).collect(),
        positions: (0..frames)
            .map(|i| at(i).iter().map(|(_, p)| Some(scale * p)).collect())
            .collect(),
    }
}

fn make(markers: &Markers, map: &Map) -> Result<Vec<Run>, InputError> {
    let origin = Origin {
        path: Path::new("a.c3d"),
        source: "a.c3d".to_owned(),
        format: "C3D markers",
        sha256: String::new(),
    };
    runs(&origin, markers, map)
}

fn hide(markers: &mut Markers, name: &str, frames: std::ops::Range<usize>) {
    let i = markers.names.iter().position(|n| n == name).unwrap();
    for frame in &mut markers.positions[frames] {
        frame[i] = None;
    }
}

#[test]
fn an_upright_person_is_placed() {
    let map = read("", &format!("{TRUNK}{ARM}")).unwrap();
    let found = make(&person(50, 1.0), &map).unwrap();
    let r = &found[0].recording;
    assert_eq!((found.len(), r.frames(), r.segments.len()), (1, 50, 5));
    let pelvis = r.segment("Pelvis").unwrap();
    assert!((pelvis.position[3] - Vec3::new(0.1, 0.0, 1.0)).norm() < 1e-12);
    // Ahead is world x, up world z, the right world -y; the elbow bends about the right.
    for name in ["Pelvis", "T8", "RightUpperArm", "RightForeArm"] {
        let turn = r.segment(name).unwrap().rotation[3];
        assert!((turn * Vec3::z() + Vec3::y()).norm() < 1e-9, "{name}");
    }
    assert!((r.length_m("RightUpperArm").unwrap() - 0.3).abs() < 1e-12);
    assert!((r.length_m("RightForeArm").unwrap() - 0.25).abs() < 1e-12);
    // The same with another axis up, told by the trunk or by the map.
    let mut turned = person(50, 1.0);
    for place in turned.positions.iter_mut().flatten().flatten() {
        *place = Vec3::new(place.y, place.z, place.x);
    }
    let stated = read("up = \"y\"", &format!("{TRUNK}{ARM}")).unwrap();
    for map in [&map, &stated] {
        let other = make(&turned, map).unwrap();
        for (a, b) in other[0].recording.segments.iter().zip(&r.segments) {
            assert_eq!((&a.name, a.position.len()), (&b.name, b.position.len()));
            for i in 0..50 {
                assert!((a.position[i] - b.position[i]).norm() < 1e-12, "{}", a.name);
                assert!(a.rotation[i].angle_to(&b.rotation[i]) < 1e-7, "{}", a.name);
            }
        }
    }
    for place in turned.positions.iter_mut().flatten().flatten() {
        *place = Vec3::new(place.x, -place.y, -place.z);
    }
    let upside = make(&turned, &map).unwrap();
    let pelvis = upside[0].recording.segment("Pelvis").unwrap();
    assert!((pelvis.rotation[3] * Vec3::y() - Vec3::z()).norm() < 1e-9);
}

#[test]
fn long_gaps_are_borders_and_short_ones_are_filled() {
    let map = read("longest_gap_s = 0.1", &format!("{TRUNK}{ARM}")).unwrap();
    let mut markers = person(200, 1.0);
    hide(&mut markers, "RWRI", 20..30);
    hide(&mut markers, "C7", 60..71);
    hide(&mut markers, "C7", 90..120);
    hide(&mut markers, "T10", 195..200);
    let found = make(&markers, &map).unwrap();
    // From 71 to 89 there are too few frames.
    let spans: Vec<_> = found.iter().map(|r| (r.first_frame, r.recording.frames())).collect();
    assert_eq!(spans, [(0, 60), (120, 75)]);
    assert_eq!((found[0].gaps_filled, found[0].frames_left_out), (1, 65));
    let told: Vec<&str> = found[0].recording.remarks.iter().map(|r| r.text.as_str()).collect();
    assert!(told[0].contains("C7 is missing in 41 frames, 0.65 s"), "{told:?}");
    assert!(told[1].contains("1 gaps of up to 0.10 s") && told[1].contains("RWRI 10"), "{told:?}");
    hide(&mut markers, "C7", 0..200);
    let error = make(&markers, &map).unwrap_err();
    assert!(error.message().contains("`C7` is missing in 200 of 200"), "{error}");
}

#[test]
fn what_a_file_lacks_is_refused_or_optional() {
    let whole = format!("{TRUNK}{ARM}");
    let map = read("", &whole.replace("\"RELB\"", "\"RELBW\"")).unwrap();
    let error = format!("{:?}", miette::Report::new(make(&person(50, 1.0), &map).unwrap_err()));
    assert!(
        error.contains("no marker `RELBW`") && error.contains("did you mean `RELB`?"),
        "{error}"
    );
    let head =
        "[segment.Head]\njoint = \"HEAD\"\nup = \"as T8\"\nright = \"as T8\"\noptional = true\n";
    let map = read("", &format!("{whole}{head}")).unwrap();
    let found = make(&person(50, 1.0), &map).unwrap();
    assert!(found[0].recording.segment("Head").is_none());
    assert!(found[0].recording.remarks.iter().any(|r| r.text.contains("left out: Head")));
    let neck = "[segment.Neck]\njoint = \"joint of Head\"\nup = \"as T8\"\nright = \"as T8\"\n";
    let map = read("", &format!("{whole}{head}{neck}")).unwrap();
    let error = make(&person(50, 1.0), &map).unwrap_err();
    assert!(error.message().contains("lacks Head"), "{error}");
}

#[test]
fn wrong_units_and_lost_directions_are_questions() {
    let map = read("", &format!("{TRUNK}{ARM}")).unwrap();
    for (scale, unit) in
        [(0.001, "is the unit m, and not mm?"), (1000.0, "is the unit mm, and not m?")]
    {
        let error = make(&person(50, scale), &map).unwrap_err();
        let shown = format!("{:?}", miette::Report::new(error)).replace(['\n', '│'], " ");
        let flat = shown.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(unit), "{flat}");
    }
    let parallel = format!("{TRUNK}{ARM}")
        .replace("ahead = [\"SACR\", [\"RASI\", \"LASI\"]]", "ahead = [\"LASI\", \"RASI\"]");
    let error = make(&person(50, 1.0), &read("", &parallel).unwrap()).unwrap_err();
    assert!(error.message().contains("Pelvis are parallel"), "{error}");
    let straight = format!("{TRUNK}{ARM}")
        .replace("[\"RSHO\", \"RELB\", \"RWRI\"]", "[\"T10\", \"C7\", \"C7\"]");
    let error = make(&person(50, 1.0), &read("", &straight).unwrap()).unwrap_err();
    assert!(error.message().contains("hinge of RightForeArm"), "{error}");
    // A trunk that nobody maps does not tell what is up.
    let arm = ARM.to_owned();
    let error = make(&person(50, 1.0), &read("", &arm).unwrap()).unwrap_err();
    assert!(error.message().contains("what is up"), "{error}");
    assert!(make(&person(50, 1.0), &read("up = \"z\"", &arm).unwrap()).is_ok());
    let error = make(&person(5, 1.0), &map).unwrap_err();
    assert!(error.message().contains("too few"), "{error}");
}

#[test]
fn faults_of_a_map_are_named() {
    let whole = format!("{TRUNK}{ARM}");
    for (general, segments, expected) in [
        ("", String::new(), "maps no segment"),
        ("", whole.replace("segment.T8", "segment.T9"), "`T9` is no segment"),
        (
            "",
            whole.replace("joint of RightForeArm", "joint of RightForearm"),
            "`RightForearm` is no segment",
        ),
        ("", whole.replace("end = \"RWRI\"\n", ""), "1 directions tell its axes"),
        (
            "",
            whole.replace("up = [\"T10\", \"C7\"]", "up = [\"T10\", \"C7\"]\nend = \"C7\""),
            "`end` and `up`",
        ),
        ("", whole.replace("up = [\"T10\", \"C7\"]", "up = \"C7\""), "`C7` is no direction"),
        ("", whole.replace("up = [\"T10\", \"C7\"]", "up = [\"T10\"]"), "no direction"),
        ("", whole.replace("joint = \"T10\"", "joint = []"), "names no marker"),
        ("", whole.replace("joint = \"T10\"", "joint = 3"), "not the name of a marker"),
        (
            "",
            whole.replace("joint = \"T10\"", "joint = \"T10\"\nexact = \"ahead\""),
            "exact = `ahead`",
        ),
        (
            "",
            whole.replace("joint = \"T10\"", "joint = \"T10\"\noffset_mm = [0, 900, 0]"),
            "offset_mm",
        ),
        ("", whole.replace("joint = \"T10\"", "joint = \"T10\"\noffset_mm = [0, 9]"), "offset_mm"),
        (
            "",
            whole
                .replace("joint = \"T10\"", "joint = \"joint of RightHand\"")
                .replace("joint = \"RWRI\"", "joint = \"joint of T8\""),
            "made of each other",
        ),
        ("", TRUNK.replace("as Pelvis", "as Head"), "needs the segment Head"),
        (
            "",
            whole.replace(
                "joint = \"T10\"",
                "joint = \"T10\"\noffset_along = { direction = [\"A\", \"B\"], mm = 900 }",
            ),
            "900 mm are too many",
        ),
        (
            "",
            whole.replace(
                "joint = \"T10\"",
                "joint = \"T10\"\noffset_along = { direction = \"as Pelvis\", mm = 9 }",
            ),
            "offset_along names a segment",
        ),
        ("up = \"w\"", whole.clone(), "up = `w`"),
        ("longest_gap_s = 3", whole.clone(), "longest_gap_s = 3"),
        ("unit = \"furlong\"", whole.clone(), "`furlong` is unknown"),
        ("rate_hz = 0", whole.clone(), "0 is no rate"),
        ("points = [\"a\", \"a\"]", whole.clone(), "point `a` is there twice"),
        ("colour = 1", whole.clone(), "colour"),
    ] {
        let shown = said(general, &segments);
        let flat = shown.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(expected), "`{expected}` is missing in {flat}");
    }
    let turned = "[segment.Pelvis]\nturns = [\"a about up\"]\nplace = [\"x\", \"y\", \"z\"]\n";
    for (general, segments, expected) in [
        ("base = \"opensimm\"", String::new(), "did you mean `opensim`?"),
        ("angle_unit = \"gon\"", turned.to_owned(), "angle_unit `gon` is unknown"),
        ("files = \"{body}.csv\"", turned.to_owned(), "{person} and {body} in it, once each"),
        ("", format!("{turned}{ARM}"), "told in another way"),
        ("base = \"opensim\"", TRUNK.to_owned(), "told in another way"),
        ("", turned.replace("about up", "up"), "`a up` is no turn"),
        ("", turned.replace("about up", "about w"), "names no axis"),
        (
            "",
            turned.replace("\"a about up\"", "{ by = \"a\", about = [0, 0, 0] }"),
            "names no axis",
        ),
        (
            "",
            turned.replace("\"a about up\"", "{ by = \"a\", about = \"x\", offset_deg = 300 }"),
            "offset_deg = 300 is too large",
        ),
        ("", turned.replace("\"a about up\"", "3"), "no turn: give"),
        ("", format!("{turned}joint = \"A\"\n"), "`joint` is told by markers"),
        ("", format!("{turned}rotation_vector = [\"a\", \"b\", \"c\"]\n"), "several keys tell"),
        ("", format!("{turned}axes = [\"x\", \"y\", \"-z\"]\n"), "those of no turn"),
        ("", format!("{turned}axes = [\"x\", \"y\", \"q\"]\n"), "axes name no axis"),
        ("", turned.replace("turns = [\"a about up\"]\n", ""), "nothing tells how it is turned"),
        ("", turned.replace("\"a about", "\"{body}a about"), "`{body}` stands for nothing"),
        ("", "[segment.Pelvis]\n".to_owned(), "nothing tells where it is"),
    ] {
        let shown = said(general, &segments);
        let flat = shown.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(expected), "`{expected}` is missing in {flat}");
    }
    let old = parse_map(Path::new("m.toml"), "schema = \"ergopath/map/9\"\n").unwrap_err();
    assert!(old.message().contains("ergopath/map/1"), "{old}");
}
