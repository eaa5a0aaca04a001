//! What the Acclaim reader refuses, and which skeleton it takes.

use super::*;

/// The text with the part after `mark` changed once.
fn after(text: &str, mark: &str, from: &str, to: &str) -> String {
    let at = text.find(mark).unwrap();
    format!("{}{}", &text[..at], text[at..].replacen(from, to, 1))
}

#[test]
fn a_damaged_motion_is_named_with_line_and_frame() {
    let good = amc(&[&[], &[], &[]]);
    let per_frame = good.lines().skip(3).count() / 3;
    let lines = |count: usize| good.split_inclusive('\n').take(count).collect::<String>();
    let second = 3 + per_frame + 1;
    for (text, line, expected) in [
        (lines(second + 4), second, "frame 2 lacks `lowerback`"),
        (after(&good, "\n2\n", "ltibia 0", "ltibia 0 0"), second + 3, "`ltibia` holds 2 values"),
        (after(&good, "\n2\n", "lfemur 0 0 0", "lfemur 0 0"), second + 2, "holds 2 values, not 3"),
        (after(&good, "\n2\n", "ltibia 0", "ltibia NaN"), second + 3, "`ltibia`: `NaN`"),
        (after(&good, "\n2\n", "ltibia 0", "ltibia 1e99"), second + 3, "`ltibia`: `1e99`"),
        (after(&good, "\n2\n", "ltibia 0", "tail 0"), second + 3, "no bone `tail`"),
        (after(&good, "\n2\n", "ltoes 0", "ltibia 0"), second + 5, "`ltibia` is given twice"),
        (after(&good, "\n2\n", "2\n", "4\n"), second, "frame 4 follows frame 1"),
        (after(&good, "\n1\n", "1\n", ""), 4, "`root` stands before"),
    ] {
        let error = load(&asf(0, 1.0, true), &text).unwrap_err();
        let message = error.message();
        assert!(message.contains(expected), "{expected}: {message}");
        assert!(message.starts_with(&format!("line {line}: ")), "line {line}: {message}");
        assert!(error.to_string().contains("a_b_120.amc") && error.help().is_some());
    }
    for empty in ["", ":DEGREES\n"] {
        let error = load(&asf(0, 1.0, true), empty).unwrap_err();
        assert!(error.message().contains("no frames"), "{error}");
    }
}

#[test]
fn a_damaged_skeleton_is_named_with_its_line() {
    let good = asf(0, 1.0, true);
    let femur = "name lfemur";
    for (text, expected) in [
        (good.replace("length 0.0254", "length -1"), "line 6: a length scale of -1"),
        (good.replace("angle deg", "angle gon"), "line 7: `gon` is no unit"),
        (good.replace("TX TY TZ RX RY RZ", "TX TY TZ RX RY"), "each of TX TY TZ RX RY RZ once"),
        (good.replace("TX TY TZ RX", "TX TY TZ TX"), "line 11: `order` lists `TX` twice"),
        (good.replace("  order TX", "  other TX"), "no `order`"),
        (good.replace("orientation 0 0 0", "orientation 0 90 0"), "line 14: the root has a"),
        (after(&good, femur, "XYZ", "XYX"), "line 28: `XYX` is no order"),
        (after(&good, femur, "axis 0", "axis x"), "line 28: `axis`: `x` is no number"),
        (after(&good, femur, "axis 0 0 0 XYZ", ""), "line 23: the bone `lfemur` has no axis"),
        (after(&good, femur, "length 0.4", ""), "`lfemur` has no length"),
        (after(&good, femur, "length 0.4", "length -0.4"), "negative length"),
        (after(&good, femur, "direction 0 -1 0", ""), "`lfemur` has no direction"),
        (after(&good, femur, "direction 0 -1 0", "direction 0 -2 0"), "no unit vector"),
        (after(&good, femur, "rx ry rz", "rx ry rx"), "line 29: `dof` lists `rx` twice"),
        (after(&good, femur, "rx ry rz", "rx ry tz"), "line 29: a bone that moves"),
        (after(&good, femur, "rx ry rz", "rx ry l"), "line 29: `dof`: `l` is not known"),
        (after(&good, femur, "end\n", ""), "`begin` is out of place"),
        (good.replace("name lfemur", "name ltibia"), "`lfemur` is no bone of :bonedata"),
        (good.replace("ltibia lfoot", "ltibia ltibia"), "`ltibia` follows more than one"),
        (good.replace("  ltibia lfoot\n", ""), "the bone `lfoot` does not hang on the root"),
        (good[..good.find("name rthumb").unwrap()].to_owned(), "no `end`"),
        (good.replace("rthumb", "rpollex"), "has no bone `rthumb`"),
        (good.replace("thorax", "chest"), "has no bone `thorax`"),
        (after(&good, "name lwrist", "length 0.05", "length 0"), "`lwrist` has no length"),
        (good.replace("length 0.0254", "length 1"), "legs are 0.020 m long"),
        (good.replace("length 0.0254", "length 1e-9"), "m long"),
        (String::new(), "no `order`"),
    ] {
        let error = load(&text, &amc(&[&[]])).unwrap_err();
        assert!(error.message().contains(expected), "{expected}: {error}");
        assert!(error.to_string().contains("a.asf") && error.help().is_some(), "{error}");
    }
    // Sitting on the floor with the legs ahead, and a thumb along the hand.
    let sitting = good.replace("direction 0 -1 0", "direction 0 0 1");
    let error = load(&sitting, &amc(&[&[]])).unwrap_err();
    assert!(error.message().contains("does not stand upright"), "{error}");
    let thumb = good.find("name lthumb").unwrap();
    let row = good[thumb..].lines().nth(1).unwrap();
    let error = load(&good.replacen(row, "  direction 1 0 0", 1), &amc(&[&[]])).unwrap_err();
    assert!(error.message().contains("nothing tells how `lwrist`"), "{error}");
}

#[test]
fn the_skeleton_is_the_one_whose_name_the_motion_begins_with() {
    let room = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(room.path().join(name), text).unwrap();
    let get = |name: &str| read(&room.path().join(name));
    put("02_06.amc", &amc(&[&[]]));
    let error = get("02_06.amc").unwrap_err();
    assert!(error.message().contains("no 02_06.asf beside it"), "{error}");
    assert!(error.to_string().contains("02_06.amc") && error.help().is_some());
    // Names that only look alike are no skeletons of it.
    put("0.asf", "damaged");
    put("02_06_1.asf", "damaged");
    assert!(get("02_06.amc").unwrap_err().message().contains("has no skeleton"));
    put("02.asf", &asf(0, 1.0, true));
    let r = get("02_06.amc").unwrap();
    assert_eq!(r.rate_hz, 120.0);
    assert!(r.remarks.iter().any(|n| n.text.contains("taken as 120 Hz")), "{:?}", r.remarks);
    let joined = asf(0, 1.0, true) + &amc(&[&[]]);
    assert_eq!(r.sha256, crate::files::sha256_hex(joined.as_bytes()));
    // Two that fit, and then one of the very name.
    put("02_06_100.amc", &amc(&[&[]]));
    put("02_06.ASF", &asf(0, 1.0, true));
    let error = get("02_06_100.amc").unwrap_err();
    assert!(error.message().contains("several skeletons: 02.asf, 02_06.ASF"), "{error}");
    assert!(error.help().unwrap().to_string().contains("02_06_100.asf"));
    put("02_06_100.asf", &asf(0, 1.0, true));
    let r = get("02_06_100.amc").unwrap();
    assert_eq!(r.rate_hz, 100.0);
    assert!(
        r.remarks.iter().any(|n| n.text.contains("100 Hz taken from the end")),
        "{:?}",
        r.remarks
    );
    assert_eq!(rate(Path::new("a/02_060.amc")), (120.0, false));
    assert_eq!(rate(Path::new("120.amc")), (120.0, false));
    assert!(get("none.amc").unwrap_err().message().contains("cannot be read"));
}

proptest! {
    #[test]
    fn no_damage_makes_it_panic(
        in_skeleton in any::<bool>(),
        cut in 0.5f64..=1.0,
        changes in proptest::collection::vec((0.0f64..1.0, any::<u8>()), 0..6),
    ) {
        let mut texts = [asf(0, 1.0, true).into_bytes(), amc(&[&[], &[]]).into_bytes()];
        let bytes = &mut texts[usize::from(!in_skeleton)];
        for (at, value) in changes {
            let i = (at * bytes.len() as f64) as usize;
            bytes[i] = value;
        }
        bytes.truncate((cut * bytes.len() as f64) as usize);
        let [skeleton, motion] = texts.map(|b| String::from_utf8_lossy(&b).into_owned());
        if let Ok(r) = load(&skeleton, &motion) {
            for track in &r.segments {
                prop_assert_eq!(track.position.len(), r.frames());
                prop_assert!(track.position.iter().all(|p| p.iter().all(|v| v.is_finite())));
                prop_assert!(track.rotation.iter().all(|q| (q.norm() - 1.0).abs() < 1e-9));
            }
        }
    }
}
