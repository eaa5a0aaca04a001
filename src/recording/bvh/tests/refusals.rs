//! What the BVH reader refuses.

use super::*;

/// The text with the part after `mark` changed once.
fn after(text: &str, mark: &str, from: &str, to: &str) -> String {
    let at = text.find(mark).unwrap();
    let changed = text[at..].replacen(from, to, 1);
    assert_ne!(changed, text[at..], "{from} after {mark}");
    format!("{}{changed}", &text[..at])
}

#[test]
fn a_damaged_file_is_named_with_its_line() {
    let good = Style::default().text(&[&[], &[]]);
    let line = |mark: &str| good[..good.find(mark).unwrap()].lines().count() + 1;
    let (spine, motion) = (line("JOINT Spine\n"), line("MOTION"));
    let first_row = good.lines().nth(motion + 2).unwrap();
    let short_row = first_row.rsplit_once(' ').unwrap().0;
    for (text, at, expected) in [
        (String::new(), 0, "is empty"),
        ("x".to_owned(), 1, "begins with `x`"),
        (good.replacen("ROOT", "RUT", 1), 2, "`RUT` is not known"),
        (good.replacen("ROOT Hips", "ROOT", 1), 2, "no name"),
        (good.replacen("ROOT", "JOINT", 1), 2, "outside of a ROOT"),
        (after(&good, "JOINT Spine\n", "{", ""), spine + 2, "comes before a brace"),
        (after(&good, "JOINT Spine\n", "JOINT Spine", ""), spine + 1, "opens without a joint"),
        (after(&good, "JOINT Spine\n", "JOINT", "ROOT"), spine, "a second ROOT"),
        (
            after(&good, "JOINT Spine\n", "OFFSET 0 10 0", "OFFSET 0 10"),
            spine + 2,
            "lacks a number",
        ),
        (after(&good, "JOINT Spine\n", "OFFSET 0 10 0", "OFFSET 0 ten 0"), spine + 2, "`ten`"),
        (after(&good, "End Site", "  OFFSET 0 15 0\n", ""), line("End Site"), "has no OFFSET"),
        (after(&good, "JOINT Spine\n", "3 Z", "4 Z"), spine + 3, "count of its 3 channels"),
        (after(&good, "JOINT Spine\n", "Xrot", "Wrot"), spine + 3, "`Wrotation` is not known"),
        (after(&good, "JOINT Spine\n", "Xrot", "Zrot"), spine + 3, "`Zrotation` is listed twice"),
        (good.replacen("MOTION", "}\nMOTION", 1), motion, "never opened"),
        (good.replacen("}\nMOTION", "MOTION", 1), 2, "no closing brace"),
        (good.replacen("MOTION", "MOVES", 1), motion, "`MOVES` is not known"),
        (good[..good.find("MOTION").unwrap()].to_owned(), 0, "ends before the word MOTION"),
        ("HIERARCHY\nMOTION\n".to_owned(), 2, "before any ROOT"),
        (good.replacen("Frames: 2", "Frames: two", 1), motion + 1, "`two` is no number of frames"),
        (good.replacen("Frames: 2", "Frames: 3", 1), motion + 1, "says 3, but 2 follow"),
        (good.replacen("Frames:", "Images:", 1), motion + 1, "where `Frames:` should"),
        (good.replacen("Time: 0.008333", "Time: 0", 1), motion + 2, "`0` is no time"),
        (good.replacen("Time: 0.008333", "Time: nan", 1), motion + 2, "`nan` is no time"),
        (good.replacen(first_row, short_row, 1), motion + 3, "holds 68 values, not 69"),
        (good.replacen(first_row, &format!("{short_row} NaN"), 1), motion + 3, "value 69: `NaN`"),
        (good.replacen(first_row, &format!("{short_row} 1e99"), 1), motion + 3, "`1e99`"),
        (good[..good.find(first_row).unwrap()].replace(": 2", ": 0"), motion + 1, "no frames"),
    ] {
        let error = load(&text).unwrap_err();
        assert!(error.message().contains(expected), "{expected}: {error}");
        let is_told = at == 0 || error.message().starts_with(&format!("line {at}: "));
        assert!(is_told, "line {at}, {expected}: {error}");
        assert!(error.to_string().contains("a.bvh") && error.help().is_some(), "{error}");
    }
}

#[test]
fn a_skeleton_that_is_no_person_is_refused() {
    let named = |from: &'static str, to: &'static str| {
        Style::default().named(move |n| Some(n.replace(from, to)))
    };
    let without =
        |gone: &str| Style::default().named(|n| (!n.contains(gone)).then(|| n.to_owned()));
    for (style, expected) in [
        (without("RightShoulder"), "no joint such as `RightArm`"),
        (
            named("Hips", "Root").named(|n| Some(n.replace("UpLeg", "Log"))),
            "no joint such as `Hips`",
        ),
        (
            named("Hips", "Root").named(|n| Some(n.replace("Spine2", "Hips"))),
            "no joint between `Hips`",
        ),
        (named("Hips", "Root").named(|n| Some(n.replace("Head", "Hips"))), "do not hang on `Hips`"),
        (
            without("Leg").offset("LeftArm", [-0.19, 0.0, 0.0]),
            "its right and its left side in one place",
        ),
        (
            Style::default().offset("LeftForeArm", [0.0, 0.3, 0.0]),
            "the left arm has no length, or points up",
        ),
        (Style::default().offset("LeftForeArm", [0.0; 3]), "the left arm has no length"),
        (
            Style::default().offset("LeftHand", [0.0, 0.0, 0.25]),
            "how the bone of `LeftForeArm` is turned",
        ),
        (Style::default().offset("LeftToeBase", [0.0, -0.06, -0.14]), "left foot points backwards"),
        (Style::default().offset("LeftLeg", [0.0, 0.42, 0.0]), "left leg does not stand upright"),
        (Style::default().offset("Spine", [0.0, 0.1, 2.0]), "does not stand upright"),
        (Style { unit_m: 0.1, ..Style::default() }, "its arms are 5.5000 long"),
        (Style { unit_m: 1e-7, ..Style::default() }, "no arm is in any unit"),
        (without("Hand"), "no arm with joints"),
    ] {
        let error = load(&style.text(&[&[]])).unwrap_err();
        assert!(error.message().contains(expected), "{expected}: {error}");
        assert!(error.to_string().contains("a.bvh") && error.help().is_some(), "{error}");
    }
}

proptest! {
    #[test]
    fn no_damage_makes_it_panic(
        cut in 0.5f64..=1.0,
        changes in proptest::collection::vec((0.0f64..1.0, any::<u8>()), 0..6),
    ) {
        let mut bytes = Style::default().text(&[&[], &[]]).into_bytes();
        for (at, value) in changes {
            let i = (at * bytes.len() as f64) as usize;
            bytes[i] = value;
        }
        bytes.truncate((cut * bytes.len() as f64) as usize);
        if let Ok(r) = load(&String::from_utf8_lossy(&bytes)) {
            for track in &r.segments {
                prop_assert_eq!(track.position.len(), r.frames());
                prop_assert!(track.position.iter().all(|p| p.iter().all(|v| v.is_finite())));
                prop_assert!(track.rotation.iter().all(|q| (q.norm() - 1.0).abs() < 1e-9));
            }
        }
    }
}
