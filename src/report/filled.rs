//! A sheet filled in for one frame and side, as an ergonomist would add it up by hand.
//!
//! Every step is a class by its angle, points added to it and its score; every look-up names row and
//! column. The lines are made from the scores themselves: a class is the score of the same sheet with
//! no box ticked.

use crate::ergonomics::{
    Profile, RebaSteps, RulaSteps, Worksheet, reba, reba_table_a, reba_table_b, reba_table_c, rula,
    rula_table_a, rula_table_b, rula_table_c,
};
use crate::scoring::Frame;
use std::fmt::Write as _;

/// One line of the sheet.
#[derive(Debug, Clone)]
pub(super) struct Line {
    /// Name of the step.
    pub step: &'static str,
    /// What was entered.
    pub entered: String,
    /// How it adds up.
    pub sum: String,
    /// Score.
    pub score: u8,
    /// The row of a table, with each column's heading, and which cell is meant.
    pub row: Option<TableRow>,
}

/// The row in which a look-up lies.
#[derive(Debug, Clone)]
pub(super) struct TableRow {
    /// What the columns are.
    pub columns: &'static str,
    /// Heading and value of every cell.
    pub cells: Vec<(String, u8)>,
    /// Index of the cell meant.
    pub hit: usize,
}

/// A block of lines with a heading.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Heading.
    pub title: &'static str,
    /// Lines in the order of the paper.
    pub lines: Vec<Line>,
}

/// A box of the sheet: whether it is ticked, its name, the points it gives.
type Tick = (bool, &'static str, i8);

fn step(name: &'static str, entered: String, class: u8, ticks: &[Tick], score: u8) -> Line {
    let mut sum = class.to_string();
    let mut added = i32::from(class);
    for (_, name, points) in ticks.iter().filter(|t| t.0) {
        let sign = if *points < 0 { "\u{2212}" } else { "+" };
        let _ = write!(sum, " {sign} {} ({name})", points.abs());
        added += i32::from(*points);
    }
    if added != i32::from(score) {
        sum += if added < i32::from(score) { ", at least 1" } else { ", one point for both" };
    }
    Line { step: name, entered, sum, score, row: None }
}

fn plain(name: &'static str, entered: String, score: u8) -> Line {
    Line { step: name, entered, sum: String::new(), score, row: None }
}

fn look_up(
    name: &'static str,
    entered: String,
    columns: &'static str,
    cells: Vec<(String, u8)>,
    hit: usize,
) -> Line {
    let hit = hit.min(cells.len().saturating_sub(1));
    let score = cells.get(hit).map_or(0, |c| c.1);
    Line {
        step: name,
        entered,
        sum: String::new(),
        score,
        row: Some(TableRow { columns, cells, hit }),
    }
}

fn total(name: &'static str, most: &'static str, parts: &[(&str, u8)], score: u8) -> Line {
    let sum: Vec<String> = parts.iter().map(|(n, v)| format!("{v} ({n})")).collect();
    let added: u8 = parts.iter().map(|p| p.1).sum();
    let most = if added > score { most } else { "" };
    Line { step: name, entered: String::new(), sum: sum.join(" + ") + most, score, row: None }
}

fn deg(angle: f64) -> String {
    // Adding 0 turns -0 into 0.
    let rounded = (angle * 10.0).round() / 10.0 + 0.0;
    // Thresholds are whole degrees: 20.04 must not be read as 20.
    let is_near = rounded.fract() == 0.0 && (angle - rounded).abs() >= 0.005;
    let (shown, digits) = if is_near { ((angle * 100.0).round() / 100.0, 2) } else { (rounded, 1) };
    let sign = if shown < 0.0 { "\u{2212}" } else { "" };
    format!("{sign}{:.digits$}\u{b0}", shown.abs())
}

/// Where the wrist is beside the midline of the trunk.
fn lateral(frame: &Frame) -> String {
    let mm = 1e3 * frame.arm.wrist_lateral_m;
    let side = if mm < 0.0 { "across" } else { "from" };
    format!("{:.0} mm {side} the midline", mm.abs())
}

/// The sheet without a ticked box: its scores are those of the angles alone.
fn unticked(sheet: &Worksheet) -> Worksheet {
    Worksheet {
        shoulder_raised: false,
        upper_arm_abducted: false,
        arm_supported: false,
        forearm_across_or_out: false,
        wrist_deviated: false,
        wrist_twist_end: false,
        neck_twisted: false,
        neck_side: false,
        trunk_twisted: false,
        trunk_side: false,
        legs_unbalanced: false,
        ..*sheet
    }
}

fn upper_arm_entry(frame: &Frame) -> String {
    let a = &frame.arm;
    format!(
        "flexion {}; abduction {}; girdle elevation {}",
        deg(frame.sheet.upper_arm_flex_deg),
        deg(a.upper_arm_abduction_deg),
        deg(a.girdle_elevation_deg)
    )
}

fn trunk_entry(frame: &Frame) -> String {
    let b = &frame.body;
    format!(
        "flexion {}; side bend {}; twist {}",
        deg(b.trunk_flex_deg),
        deg(b.trunk_side_deg),
        deg(b.trunk_twist_deg)
    )
}

fn neck_entry(frame: &Frame) -> String {
    let b = &frame.body;
    format!(
        "flexion {}; side bend {}; twist {}",
        deg(b.neck_flex_deg),
        deg(b.neck_side_deg),
        deg(b.neck_twist_deg)
    )
}

fn wrist_entry(frame: &Frame) -> String {
    format!(
        "flexion {}; deviation {}",
        deg(frame.arm.wrist_flex_deg),
        deg(frame.arm.wrist_deviation_deg)
    )
}

/// RULA of a frame.
pub(super) fn rula_groups(frame: &Frame, profile: &Profile) -> Vec<Group> {
    let (s, r) = (&frame.sheet, &frame.rula);
    let bare = rula(&unticked(s), profile);
    let twist = usize::from(r.wrist_twist) - 1;
    let a_cells = (1..=4).flat_map(|w| (1..=2).map(move |t| (w, t))).map(|(w, t)| {
        (format!("{w}.{t}"), rula_table_a(profile.rula_table_a, r.upper_arm, r.lower_arm, w, t))
    });
    let b_cells = (1..=6).flat_map(|t| (1..=2).map(move |l| (t, l)));
    let b_cells = b_cells.map(|(t, l)| (format!("{t}.{l}"), rula_table_b(r.neck, t, l)));
    let b_hit = 2 * (usize::from(r.trunk) - 1) + usize::from(r.legs) - 1;
    let c_cells = (1..=7).map(|d| (d.to_string(), rula_table_c(r.score_c, d)));
    let arm = vec![
        step("Upper arm", upper_arm_entry(frame), bare.upper_arm, &arm_ticks(s), r.upper_arm),
        step(
            "Lower arm",
            format!("elbow flexion {}; wrist {}", deg(s.elbow_flex_deg), lateral(frame)),
            bare.lower_arm,
            &[(s.forearm_across_or_out, "across the midline or out to the side", 1)],
            r.lower_arm,
        ),
        step(
            "Wrist",
            wrist_entry(frame),
            bare.wrist,
            &[(s.wrist_deviated, "deviated", 1)],
            r.wrist,
        ),
        plain("Wrist twist", twist_entry(frame), r.wrist_twist),
        look_up(
            "Table A",
            format!("row upper arm {}, lower arm {}", r.upper_arm, r.lower_arm),
            "wrist.twist",
            a_cells.collect(),
            2 * (usize::from(r.wrist) - 1) + twist,
        ),
        plain("Muscle use", muscle_entry(s), r.muscle),
        plain("Force or load", load_entry(s), r.force),
        total(
            "Score C",
            "",
            &[("A", r.posture_a), ("muscle", r.muscle), ("force", r.force)],
            r.score_c,
        ),
    ];
    let trunk = vec![
        step("Neck", neck_entry(frame), bare.neck, &two_ticks(s.neck_twisted, s.neck_side), r.neck),
        step(
            "Trunk",
            trunk_entry(frame) + if s.trunk_seated_supported { "; backrest" } else { "" },
            bare.trunk,
            &two_ticks(s.trunk_twisted, s.trunk_side),
            r.trunk,
        ),
        plain("Legs", legs_entry(s), r.legs),
        look_up("Table B", format!("row neck {}", r.neck), "trunk.legs", b_cells.collect(), b_hit),
        plain("Muscle use", "as above".to_owned(), r.muscle),
        plain("Force or load", "as above".to_owned(), r.force),
        total(
            "Score D",
            "",
            &[("B", r.posture_b), ("muscle", r.muscle), ("force", r.force)],
            r.score_d,
        ),
        look_up(
            "Table C",
            format!("row score C {} (8 and more are one row)", r.score_c),
            "score D, 7 and more are one column",
            c_cells.collect(),
            usize::from(r.score_d.clamp(1, 7)) - 1,
        ),
    ];
    vec![
        Group { title: "A. Arm and wrist", lines: arm },
        Group { title: "B. Neck, trunk and legs", lines: trunk },
    ]
}

/// REBA of a frame.
pub(super) fn reba_groups(frame: &Frame, profile: &Profile) -> Vec<Group> {
    let (s, r) = (&frame.sheet, &frame.reba);
    let bare = reba(&unticked(s), profile);
    let level = Worksheet { knee_flex_deg: 0.0, ..*s };
    let feet = reba(&level, profile).legs;
    let knee = i8::try_from(r.legs - feet).unwrap_or(0);
    let legs = step(
        "Legs",
        legs_entry(s) + &format!("; knee {}", deg(s.knee_flex_deg)),
        feet,
        &[(knee > 0, "knee bent", knee)],
        r.legs,
    );
    let a_cells = (1..=4).map(|l| (l.to_string(), reba_table_a(r.neck, r.trunk, l))).collect();
    let b_cells =
        (1..=3).map(|w| (w.to_string(), reba_table_b(r.upper_arm, r.lower_arm, w))).collect();
    let c_cells = (1..=12).map(|b| (b.to_string(), reba_table_c(r.score_a, b))).collect();
    let trunk = vec![
        step("Neck", neck_entry(frame), bare.neck, &two_ticks(s.neck_twisted, s.neck_side), r.neck),
        step(
            "Trunk",
            trunk_entry(frame),
            bare.trunk,
            &two_ticks(s.trunk_twisted, s.trunk_side),
            r.trunk,
        ),
        legs,
        look_up(
            "Table A",
            format!("row neck {}, trunk {}", r.neck, r.trunk),
            "legs",
            a_cells,
            usize::from(r.legs) - 1,
        ),
        plain("Load or force", load_entry(s), r.load),
        total("Score A", ", at most 12", &[("A", r.table_a), ("load", r.load)], r.score_a),
    ];
    let wrist_ticks = [(s.wrist_deviated || s.wrist_twist_end, "deviated or twisted", 1)];
    let arm = vec![
        step("Upper arm", upper_arm_entry(frame), bare.upper_arm, &arm_ticks(s), r.upper_arm),
        plain("Lower arm", format!("elbow flexion {}", deg(s.elbow_flex_deg)), r.lower_arm),
        step("Wrist", wrist_entry(frame), bare.wrist, &wrist_ticks, r.wrist),
        look_up(
            "Table B",
            format!("row upper arm {}, lower arm {}", r.upper_arm, r.lower_arm),
            "wrist",
            b_cells,
            usize::from(r.wrist) - 1,
        ),
        plain("Coupling", coupling_word(r.coupling).to_owned(), r.coupling),
        total("Score B", ", at most 12", &[("B", r.table_b), ("coupling", r.coupling)], r.score_b),
        look_up(
            "Table C",
            format!("row score A {}", r.score_a),
            "score B",
            c_cells,
            usize::from(r.score_b) - 1,
        ),
        plain("Activity", activity_entry(s), r.activity),
        total("REBA", ", at most 15", &[("C", r.score_c), ("activity", r.activity)], r.total),
    ];
    vec![
        Group { title: "A. Neck, trunk and legs", lines: trunk },
        Group { title: "B. Arm and wrist", lines: arm },
    ]
}

fn arm_ticks(s: &Worksheet) -> [Tick; 3] {
    [
        (s.shoulder_raised, "shoulder raised", 1),
        (s.upper_arm_abducted, "abducted", 1),
        (s.arm_supported, "supported", -1),
    ]
}

fn two_ticks(twisted: bool, side: bool) -> [Tick; 2] {
    [(twisted, "twisted", 1), (side, "bent to the side", 1)]
}

fn twist_entry(frame: &Frame) -> String {
    let end = if frame.sheet.wrist_twist_end { "near the end of its range" } else { "mid-range" };
    format!("{} from mid-prone, {end}", deg(frame.arm.wrist_twist_deg))
}

fn muscle_entry(s: &Worksheet) -> String {
    match (s.static_gt_1min, s.repeated_gt_4min) {
        (true, true) => "held > 1 min and repeated > 4 a minute",
        (true, false) => "held > 1 min",
        (false, true) => "repeated > 4 a minute",
        (false, false) => "neither held > 1 min nor repeated > 4 a minute",
    }
    .to_owned()
}

fn activity_entry(s: &Worksheet) -> String {
    let ticked: Vec<&str> = [
        (s.static_gt_1min, "held > 1 min"),
        (s.repeated_gt_4min, "repeated > 4 a minute"),
        (s.rapid_large_changes, "rapid large changes"),
    ]
    .into_iter()
    .filter(|t| t.0)
    .map(|t| t.1)
    .collect();
    if ticked.is_empty() { "none of the three".to_owned() } else { ticked.join(" + ") }
}

fn load_entry(s: &Worksheet) -> String {
    let how = if s.load_static_or_repeated { "static or repeated" } else { "intermittent" };
    let shock = if s.load_shock { ", shock" } else { "" };
    format!("{} kg, {how}{shock}", (s.load_kg * 1e3).round() / 1e3)
}

fn legs_entry(s: &Worksheet) -> String {
    let stance = if s.sitting { "sitting" } else { "standing" };
    let even = if s.legs_unbalanced { "unevenly loaded" } else { "evenly loaded" };
    format!("{stance}, {even}")
}

fn coupling_word(class: u8) -> &'static str {
    ["good", "fair", "poor", "unacceptable"][usize::from(class.min(3))]
}

/// The sheet as CSV: method, group, step, entered, sum, score.
pub(super) fn csv_text(frame: &Frame, profile: &Profile) -> Result<Vec<u8>, csv::Error> {
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record(["method", "group", "step", "entered", "sum", "score"])?;
    for (method, groups) in
        [("RULA", rula_groups(frame, profile)), ("REBA", reba_groups(frame, profile))]
    {
        for group in groups {
            for l in group.lines {
                let score = l.score.to_string();
                out.write_record([method, group.title, l.step, &l.entered, &l.sum, &score])?;
            }
        }
    }
    let inputs = Worksheet::COLUMNS.iter().zip(frame.sheet.values());
    for (name, value) in inputs {
        out.write_record(["worksheet", "input", name, &value.to_string(), "", ""])?;
    }
    let outputs = RulaSteps::COLUMNS.iter().zip(frame.rula.values());
    for (name, value) in outputs.chain(RebaSteps::COLUMNS.iter().zip(frame.reba.values())) {
        out.write_record(["worksheet", "output", name, "", "", &value.to_string()])?;
    }
    out.into_inner().map_err(|e| e.into_error().into())
}
