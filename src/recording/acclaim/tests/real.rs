//! Five people of a motion capture database, where they are at hand: do they stand and move like
//! people?

#![allow(clippy::print_stdout, reason = "says the figures it judges")]

use super::*;
use crate::skips::shared;

/// Trunk inclination and knee flexion (deg) at the lowest posture of every deposit on the floor, of
/// each person in order of the clips, found by another program.
const DEPOSITS: [(&str, &[(f64, f64)]); 5] = [
    (
        "bd",
        &[(66.0, 142.0), (110.0, 66.0), (80.0, 118.0), (111.0, 59.0), (83.0, 112.0), (112.0, 65.0)],
    ),
    (
        "bk",
        &[(51.0, 153.0), (114.0, 68.0), (52.0, 158.0), (116.0, 58.0), (48.0, 155.0), (118.0, 61.0)],
    ),
    (
        "dg",
        &[(63.0, 143.0), (108.0, 70.0), (86.0, 113.0), (101.0, 80.0), (53.0, 155.0), (46.0, 159.0)],
    ),
    (
        "mm",
        &[
            (76.0, 126.0),
            (105.0, 49.0),
            (80.0, 104.0),
            (108.0, 64.0),
            (78.0, 117.0),
            (106.0, 53.0),
            (87.0, 95.0),
            (104.0, 63.0),
        ],
    ),
    (
        "tr",
        &[(78.0, 123.0), (111.0, 79.0), (71.0, 143.0), (112.0, 71.0), (62.0, 152.0), (116.0, 65.0)],
    ),
];

/// What jumps in two of the files themselves: an almost straight arm about its own length, and a hand.
const JUMPS: [(&str, &str); 2] =
    [("mm_grabHighR_018", "RightUpperArm"), ("tr_depositFloorR_028", "RightHand")];

/// The motions of a person (all of them: an empty name) at a task, in order of their names.
fn clips(folder: &Path, person: &str, task: &str) -> Vec<Recording> {
    let mut paths: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| {
            let name = bare_name(p);
            p.extension().is_some_and(|x| x == "amc")
                && name.contains(&format!("_{person}"))
                && name.contains(task)
        })
        .collect();
    paths.sort();
    paths.iter().map(|p| crate::recording::read(p, None).unwrap()).collect()
}

fn at(r: &Recording, segment: &str, frame: usize) -> Vec3 {
    r.segment(segment).unwrap().position[frame]
}

/// Heights of a joint centre over time, m.
fn heights(r: &Recording, segment: &str) -> Vec<f64> {
    r.segment(segment).unwrap().position.iter().map(|p| p.z).collect()
}

/// Knee flexion from the joint centres, mean of both, deg.
fn knees(r: &Recording, frame: usize) -> f64 {
    let one = |side: &str| {
        let [hip, knee, ankle] =
            ["UpperLeg", "LowerLeg", "Foot"].map(|part| at(r, &format!("{side}{part}"), frame));
        (knee - hip).angle(&(ankle - knee)).to_degrees()
    };
    0.5 * (one("Right") + one("Left"))
}

/// Inclination of the line from the lowest joint of the spine to the neck, deg.
fn trunk(r: &Recording, frame: usize) -> f64 {
    (at(r, "Neck", frame) - at(r, "L5", frame)).angle(&Vec3::z()).to_degrees()
}

/// Inclination of a segment's y axis, deg.
fn tilt(r: &Recording, segment: &str, frame: usize) -> f64 {
    (r.segment(segment).unwrap().rotation[frame] * Vec3::y()).angle(&Vec3::z()).to_degrees()
}

/// The frame of the least value.
fn least(values: impl Iterator<Item = f64>) -> usize {
    let (frame, _) = values.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    frame
}

fn span(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Angles of a child segment in its parent over time, deg: `[z, x, y]`, mirrored on the left.
fn joint(r: &Recording, side: &str, parent: &str, child: &str) -> [Vec<f64>; 3] {
    let sign = if side == "Right" { 1.0 } else { -1.0 };
    let [p, c] = [parent, child].map(|n| r.segment(&format!("{side}{n}")).unwrap());
    let all: Vec<[f64; 3]> = (p.rotation.iter().zip(&c.rotation))
        .map(|(p, c)| zxy_angles(&(p.inverse() * c)).map(f64::to_degrees))
        .collect();
    [(0, 1.0), (1, sign), (2, sign)].map(|(k, s)| all.iter().map(|a| s * a[k]).collect())
}

#[test]
fn everybody_stands_on_the_floor_and_moves_smoothly() {
    let Some(folder) = shared("recordings/hdm05") else { return };
    let all = clips(&folder, "", "");
    assert_eq!(all.len(), 113);
    let mut turned = 0;
    for r in &all {
        let name = &r.source;
        assert_eq!((r.rate_hz, r.segments.len()), (120.0, 23), "{name}");
        let leg = leg(&r.segment_lengths_m);
        assert!((0.78..0.94).contains(&leg), "{name}: leg of {leg} m");
        for (part, low, high) in
            [("RightUpperArm", 0.24, 0.33), ("LeftForeArm", 0.22, 0.36), ("HipToHip", 0.10, 0.24)]
        {
            let length = r.length_m(part).unwrap();
            assert!((low..high).contains(&length), "{name}: {part} of {length} m");
        }
        // Where a leg was solved half a turn round, the file's foot jumps with it: told, and kept.
        let was_turned = r.remarks.iter().any(|n| n.text.contains("knee bends forwards"));
        turned += usize::from(was_turned);
        let may_jump = |text: &str| {
            let is_foot = ["Foot", "Toe"].iter().any(|part| text.contains(part));
            let is_known =
                JUMPS.iter().any(|(clip, part)| name.contains(clip) && text.contains(part));
            is_known || (was_turned && is_foot)
        };
        let jumps: Vec<&Remark> = r.remarks.iter().filter(|n| n.text.contains("jumps")).collect();
        assert!(jumps.iter().all(|n| may_jump(&n.text)), "{name}: {jumps:?}");
        // The most upright frame.
        let up = least((0..r.frames()).map(|i| knees(r, i) + trunk(r, i)));
        let place = |segment: &str| at(r, segment, up);
        for toe in ["RightToe", "LeftToe"] {
            assert!((-0.03..0.16).contains(&place(toe).z), "{name}: {toe} at {}", place(toe).z);
        }
        assert!((1.4..1.8).contains(&place("Head").z), "{name}: head at {}", place("Head").z);
        // These skeletons have standing knees bent by 15 to 35 degrees, hence the shanks.
        for segment in ["Pelvis", "T8", "RightLowerLeg", "LeftLowerLeg"] {
            let tilt = tilt(r, segment, up);
            assert!(tilt < 40.0, "{name}: {segment} leans by {tilt} deg");
        }
        // Facing: toes before ankles, the right side to the right.
        let pelvis = r.segment("Pelvis").unwrap().rotation[up];
        let ahead = place("RightToe") - place("RightFoot") + place("LeftToe") - place("LeftFoot");
        assert!((pelvis.inverse() * ahead).x > 0.1, "{name}: {ahead:?}");
        let across = pelvis.inverse() * (place("RightUpperArm") - place("LeftUpperArm"));
        assert!(across.z > 0.3, "{name}: {across:?}");
    }
    println!("a leg turned back in {turned} motions");
    assert_eq!(turned, 11);
}

#[test]
fn squats_bend_the_knees_and_hands_go_where_the_task_asks() {
    let Some(folder) = shared("recordings/hdm05") else { return };
    for r in clips(&folder, "", "squat") {
        let (low, high) = span(&(0..r.frames()).map(|i| knees(&r, i)).collect::<Vec<_>>());
        assert!(low < 50.0 && (60.0..170.0).contains(&high), "{}: {low} to {high}", r.source);
        // Forwards: no knee bends the other way, and the joint is the hinge of the skeleton.
        let [z, x, y] = joint(&r, "Left", "UpperLeg", "LowerLeg").map(|v| span(&v));
        assert!(z.1 < 5.0 && z.0 > -170.0, "{}: knee {z:?}", r.source);
        assert!(x.1 - x.0 < 1.0 && y.1 - y.0 < 1.0, "{}: {x:?} {y:?}", r.source);
    }
    for r in clips(&folder, "", "depositFloor") {
        let (low, _) = span(&heights(&r, "RightHand"));
        assert!((0.0..0.2).contains(&low), "{}: wrist at {low} m", r.source);
    }
    for r in clips(&folder, "", "grabHigh") {
        let above = heights(&r, "RightHand").into_iter().zip(heights(&r, "RightUpperArm"));
        let (_, high) = span(&above.map(|(wrist, shoulder)| wrist - shoulder).collect::<Vec<_>>());
        assert!(high > 0.03, "{}: wrist {high} m above the shoulder", r.source);
    }
}

/// Not the pronation, whose zero each skeleton sets in its own way.
#[test]
fn arms_turn_within_what_arms_can() {
    let Some(folder) = shared("recordings/hdm05") else { return };
    let mut elbow: [Vec<f64>; 3] = Default::default();
    let mut wrist: [Vec<f64>; 3] = Default::default();
    for r in clips(&folder, "", "") {
        for side in ["Right", "Left"] {
            let joints = [
                (&mut elbow, joint(&r, side, "UpperArm", "ForeArm")),
                (&mut wrist, joint(&r, side, "ForeArm", "Hand")),
            ];
            for (all, one) in joints {
                all.iter_mut().zip(one).for_each(|(all, one)| all.extend(one));
            }
        }
    }
    for (what, values, low, high) in [
        ("elbow flexion", &elbow[0], -10.0, 160.0),
        ("carrying angle", &elbow[1], -5.0, 5.0),
        ("wrist flexion", &wrist[0], -90.0, 90.0),
        ("wrist deviation", &wrist[1], -60.0, 60.0),
    ] {
        let inside = values.iter().filter(|v| (low..=high).contains(*v)).count();
        let share = inside as f64 / values.len() as f64;
        let q =
            [0.0, 0.05, 0.5, 0.95, 1.0].map(|p| crate::math::stats::quantile(values, p).round());
        println!("{what:16} {q:?} deg, {:.1} % in {low}..{high}", 100.0 * share);
        assert!(share > 0.95, "{what}: only {share} in {low}..{high}");
    }
}

#[test]
fn deposits_on_the_floor_are_as_deep_as_another_program_found() {
    let Some(folder) = shared("recordings/hdm05") else { return };
    let (mut count, mut near) = (0, 0);
    for (person, wanted) in DEPOSITS {
        let clips = clips(&folder, person, "depositFloor");
        assert_eq!(clips.len(), wanted.len());
        for (r, (trunk_deg, knees_deg)) in clips.iter().zip(wanted) {
            let deepest = least(heights(r, "RightHand").into_iter());
            let (t, k) = (trunk(r, deepest), knees(r, deepest));
            println!("{}: {t:.0}/{k:.0}, there {trunk_deg:.0}/{knees_deg:.0}", r.source);
            count += 1;
            near += usize::from((t - trunk_deg).abs() < 10.0 && (k - knees_deg).abs() < 10.0);
        }
    }
    println!("{near} of {count} within 10 deg");
    assert!(count == 32 && near >= 28, "{near} of {count}");
}
