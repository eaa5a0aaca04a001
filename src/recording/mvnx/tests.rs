//! Tests of the MVNX reader on small made-up files and on damaged ones.

use super::*;
use approx::assert_relative_eq;
use proptest::prelude::*;

const LABELS: [&str; 5] = ["Pelvis", "T8", "RightShoulder", "RightUpperArm", "RightForeArm"];

fn q(axis_angle: [f64; 3]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vec3::from(axis_angle))
}

fn numbers(rotations: &[UnitQuaternion<f64>]) -> String {
    let words = rotations.iter().map(|r| format!("{} {} {} {}", r.w, r.i, r.j, r.k));
    words.collect::<Vec<_>>().join(" ")
}

/// ISB to world of the five segments: trunk upright, arm hanging, elbow flexed by `z`, turned by `y`.
fn posture(z: f64, y: f64) -> [UnitQuaternion<f64>; 5] {
    let upright = mvnx_from_isb();
    [upright, upright, upright, upright, upright * q([0.0, 0.0, z]) * q([0.0, y, 0.0])]
}

/// `R_tpose^T R_tpose-isb` of the made-up version 4.
fn constants() -> [UnitQuaternion<f64>; 5] {
    let arm = q([-std::f64::consts::FRAC_PI_2, 0.0, 0.0]);
    let trunk = UnitQuaternion::identity();
    [trunk, trunk, trunk, arm, arm * q([0.0, 0.0, std::f64::consts::FRAC_PI_2])]
}

fn mvnx(version: u8) -> String {
    let (tag, isb) = if version == 3 { ("pos_s", false) } else { ("pos_b", true) };
    let points = |segment: &str| -> String {
        let at =
            |label: &str, p: &str| format!("<point label=\"{label}\"><{tag}>{p}</{tag}></point>");
        match segment {
            "T8" => at("jRightT4Shoulder", "0 -0.03 0.08"),
            "RightShoulder" => at("jRightT4Shoulder", "0 0 0") + &at("jRightShoulder", "0 -0.14 0"),
            "RightUpperArm" => at("jRightShoulder", "0 0 0") + &at("jRightElbow", "0 -0.3 0"),
            "RightForeArm" => at("jRightElbow", "0 0 0"),
            _ => String::new(),
        }
    };
    let listed = LABELS.map(|s| {
        let points = points(s);
        format!("<segment label=\"{s}\" id=\"1\"><points>{points}</points></segment>\n")
    });
    let segments = listed.concat();
    let place = "0.5 0 1 ".repeat(LABELS.len());
    let frame = |head: &str, rotations: &[UnitQuaternion<f64>]| {
        format!(
            "<frame {head}>\n<orientation>{}</orientation><position>{place}</position></frame>\n",
            numbers(rotations)
        )
    };
    let tpose = [q([0.0, 0.0, 0.1]); 5];
    let mut frames = if isb {
        let turned: Vec<_> = tpose.iter().zip(constants()).map(|(t, c)| t * c).collect();
        frame("type=\"tpose\" time=\"0\"", &tpose) + &frame("type=\"tpose-isb\"", &turned)
    } else {
        frame("index=\"-2\" type=\"npose\"", &tpose)
    };
    for i in 0..3 {
        let wanted = posture(0.3 * f64::from(i), 1.5);
        let raw: Vec<_> = wanted
            .iter()
            .zip(constants())
            .map(|(w, c)| {
                let anatomical = w * mvnx_from_isb().inverse();
                if isb { anatomical * c.inverse() } else { anatomical }
            })
            .collect();
        frames += &frame(&format!("time=\"{}\" index=\"{i}\" type=\"normal\"", i * 10), &raw);
    }
    format!(
        "<?xml version=\"1.0\"?>\n<!-- <!DOCTYPE mvnx> -->\n<mvnx xmlns=\"http://x\" version=\"{version}\">\
         <comment>Secret Name</comment>\n<subject label=\"Secret Name\" frameRate=\"100\" \
         segmentCount=\"{}\" originalFilename=\"Secret Name.mvn\">\n<segments>{segments}</segments>\n\
         <frames>{frames}</frames></subject></mvnx>\n",
        LABELS.len()
    )
}

fn load(text: &str) -> Result<Recording, InputError> {
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("a.mvnx");
    std::fs::write(&path, text).unwrap();
    read(&path)
}

#[test]
fn both_versions_give_the_same_posture_in_isb_axes() {
    for version in [3, 4] {
        let text = mvnx(version);
        let r = load(&text).unwrap();
        assert_eq!((r.frames(), r.rate_hz, r.source.as_str()), (3, 100.0, "a.mvnx"));
        assert_eq!(r.sha256, crate::files::sha256_hex(text.as_bytes()));
        assert!(r.format.ends_with(char::from(b'0' + version)));
        for i in 0..3 {
            for (name, wanted) in LABELS.iter().zip(posture(0.3 * i as f64, 1.5)) {
                let found = r.segment(name).unwrap().rotation[i];
                assert_relative_eq!(found.angle_to(&wanted), 0.0, epsilon = 1e-7);
            }
        }
        assert_relative_eq!(r.length_m("RightUpperArm").unwrap(), 0.3);
        assert!(!format!("{r:?}").contains("Secret"));
    }
}

#[test]
fn damage_is_named_with_frame_and_value() {
    for version in [3, 4] {
        let good = mvnx(version);
        let at = good.find("index=\"1\"").unwrap();
        let damaged =
            |from: &str, to: &str| format!("{}{}", &good[..at], good[at..].replacen(from, to, 1));
        for (text, expected) in [
            (damaged("0.5 0 1", "0.5 NaN 1"), "frame 1: <position> of Pelvis: `NaN`"),
            (damaged("0.5 0 1", "0.5 1"), "frame 1: <position> holds 14 numbers, not 15"),
            (damaged("<orientation>", "<orientation>1 "), "frame 1: <orientation> holds 21"),
            (damaged("<orientation>", "<orientation>9"), "frame 1: the quaternion of Pelvis"),
            (damaged("index=\"1\"", "index=\"7\""), "frame 2 follows frame 7"),
            (damaged("<position>", "<place>").replacen("</position>", "</p>", 9), "well-formed"),
            (good[..at].to_owned(), "cut off"),
            (good.replace("type=\"normal\"", "type=\"x\""), "no motion"),
            (
                good.replace("version=\"3\"", "version=\"2\"")
                    .replace("version=\"4\"", "version=\"2\""),
                "version `2`",
            ),
            (good.replace("mvnx", "bvhx"), "root element is <bvhx>"),
            (good.replace("segments>", "things>"), "lists no segments"),
            (good.replace("\"T8\"", "\"Pelvis\""), "listed twice"),
            (good.replace("frameRate=\"100\"", "frameRate=\"-1\""), "frameRate `-1`"),
            (good.replace("Count=\"5\"", "Count=\"23\""), "segmentCount is 23"),
            (good.replace("0 -0.3 0", "0 -0.3"), "point `jRightElbow`"),
            (format!("{good}{good}"), "well-formed"),
            (String::new(), "no <mvnx>"),
        ] {
            let error = load(&text).unwrap_err();
            let shown = error.to_string();
            let is_second_root = expected == "well-formed" && shown.contains("after the end");
            assert!(shown.contains(expected) || is_second_root, "{expected}: {shown}");
            assert!(shown.contains("a.mvnx: line "), "{shown}");
        }
    }
    let room = tempfile::tempdir().unwrap();
    let path = room.path().join("latin.mvnx");
    std::fs::write(&path, mvnx(3).as_bytes().split(|b| *b == b'S').collect::<Vec<_>>().join(&0xe9))
        .unwrap();
    let error = read(&path).unwrap_err();
    assert!(error.message().contains("not UTF-8"), "{error}");
    let error = load(&mvnx(4).replace("tpose-isb", "other")).unwrap_err();
    assert!(error.message().contains("calibration"), "{error}");
}

#[test]
fn the_line_is_that_of_the_fault() {
    let text =
        mvnx(3).replacen("type=\"normal\">\n<orientation>", "type=\"normal\">\n<orientation>x", 1);
    let line = text[..text.find("<orientation>x").unwrap()].lines().count();
    let message = load(&text).unwrap_err().message().to_owned();
    assert!(message.starts_with(&format!("line {line}: ")), "{line}, {message}");
}

proptest! {
    #[test]
    fn no_damage_makes_it_panic(
        version in 3u8..=4,
        cut in 0.0f64..=1.0,
        changes in proptest::collection::vec((0.0f64..1.0, any::<u8>()), 0..6),
    ) {
        let mut bytes = mvnx(version).into_bytes();
        for (at, value) in changes {
            let i = (at * bytes.len() as f64) as usize;
            bytes[i] = value;
        }
        bytes.truncate((cut * bytes.len() as f64) as usize);
        if let Ok(export) = parse(bytes.as_slice()) {
            let recording = assemble(export, String::new(), String::new());
            for track in &recording.segments {
                prop_assert_eq!(track.position.len(), recording.frames());
                prop_assert!(track.rotation.iter().all(|r| r.coords.iter().all(|v| v.is_finite())));
            }
        }
    }
}
