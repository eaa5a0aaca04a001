//! `ergopath score MOTION`: reads, scores, writes the folder, prints.

use super::score::{Args, file};
use super::score_print::{print_paired, print_text};
use super::{Failure, Outcome};
use crate::ergonomics::{PairedDifference, TimeRules, paired_difference};
use crate::files::{InputError, Outputs, sealed_pretty_json};
use crate::human::{Body, Side, Stance};
use crate::recording::{Reading, read_map, read_with};
use crate::report::{Picked, sheet_files};
use crate::scenario::{Scenario, read_scenario};
use crate::scoring::{
    Declared, LiftAsked, Motion, MotionKind, ScoredSide, Summary, frames_csv, read_angles,
    read_recorded, score_side, summarise,
};
use std::path::Path;

/// Standing without a word on shoes: 30 mm, as in a scenario.
const SHOE_M: f64 = 0.03;

/// What is known before the motion is read.
struct Setting {
    body: Body,
    stance: Stance,
    declared: Declared,
    duration_s: Option<f64>,
    /// Arms that must be scored; all that the motion knows where it is empty.
    sides: Vec<Side>,
}

/// Everything about one motion.
struct Scored {
    motion: Motion,
    sides: Vec<ScoredSide>,
    summary: Summary,
}

/// Scores one motion.
pub(super) fn single(path: &Path, args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let output = file(args.output.as_ref());
    if let Some(folder) = output {
        // A folder that cannot be written fails now, not after the work.
        outputs.expect_folder(folder)?;
    }
    let setting = setting(args)?;
    let scored = score(path, &setting, args)?;
    let json = sealed_pretty_json(&scored.summary)
        .map(|text| text.trim_end().to_owned())
        .map_err(|e| InputError::fault("summary.json", e.to_string()))?;
    if let Some(folder) = output {
        outputs.folder(folder, files(&scored, &json, args)?)?;
        outputs.write()?;
    }
    for note in &scored.summary.notes {
        complain!("note: {}: {note}", scored.summary.source);
    }
    if args.json {
        say!("{json}");
    } else {
        print_text(&scored.summary);
        if let Some(folder) = output {
            say!("\n{}", folder.join("summary.json").display());
        }
    }
    Ok(Outcome::Done)
}

fn setting(args: &Args) -> Result<Setting, InputError> {
    let scenario = args.scenario.as_deref().map(read_scenario).transpose()?;
    let body = match (&args.body, &scenario) {
        (Some(name), _) => Body::load(name, Path::new("."))?,
        (None, Some(s)) => s.worker.bodies[0].clone(),
        (None, None) => {
            return Err(InputError::new("--body", "is missing").remedy(
                "name the body of the motion: female_p05, female_p50, male_p50, male_p95 or a URDF; or \
                 give --scenario",
            ));
        }
    };
    let mut declared = scenario.as_ref().map_or_else(|| of_flags(args), Declared::of);
    declared.neck = args.neck.or(declared.neck);
    declared.lift = args.task.lift_hours.map(|hours| LiftAsked { hours });
    let asked = args.side.as_ref().map(|s| s.0.clone());
    let sides = asked.or_else(|| scenario.as_ref().map(coupled)).unwrap_or_default();
    let stance = match (&scenario, declared.seated) {
        (Some(s), _) => s.worker.stance,
        (None, true) => {
            let seat_height_m = args.task.seat_height_m.unwrap_or(0.45);
            Stance::Seated { seat_height_m, footrest_m: 0.0 }
        }
        (None, false) => Stance::Standing { shoe_m: SHOE_M },
    };
    let duration_s = scenario.map(|s| s.duration_s);
    Ok(Setting { body, stance, declared, duration_s, sides })
}

/// The arms of a scenario that are known.
fn coupled(scenario: &Scenario) -> Vec<Side> {
    let hanging = Declared::of(scenario).hanging;
    scenario.worker.hands.sides().iter().copied().chain(hanging).collect()
}

fn of_flags(args: &Args) -> Declared {
    let t = &args.task;
    Declared {
        load_kg: t.load_kg,
        coupling: t.coupling,
        cycles_per_min: t.cycles_per_min,
        hold_s: t.hold_s,
        shock: t.shock,
        arm_supported: t.arm_supported,
        seated: t.seated || t.seat_height_m.is_some(),
        trunk_supported: t.trunk_supported,
        legs_unbalanced: t.legs_unbalanced,
        neck: None,
        hanging: None,
        lift: None,
    }
}

fn score(path: &Path, setting: &Setting, args: &Args) -> Result<Scored, InputError> {
    let motion = read_any(path, setting, args)?;
    if args.neck == Some(crate::scoring::Neck::Measured) && !motion.has_neck() {
        return Err(InputError::new(path, "does not hold the neck")
            .remedy("use --neck neutral or --neck gaze"));
    }
    let rules = TimeRules::default();
    let all = [Side::Right, Side::Left];
    let asked = if setting.sides.is_empty() { &all[..] } else { &setting.sides };
    let mut sides = Vec::new();
    for side in asked {
        match score_side(&motion, *side, &setting.declared, &args.profile, rules) {
            Some(scored) => sides.push(scored),
            None if setting.sides.is_empty() => {}
            None => {
                let message = format!("nobody measured or predicted the {} arm", side.name());
                return Err(InputError::new(path, message)
                    .remedy("an unknown arm is not scored; choose the other with --side"));
            }
        }
    }
    let summary = summarise(&motion, &sides, &setting.declared, &args.profile, rules);
    Ok(Scored { motion, sides, summary })
}

fn read_any(path: &Path, setting: &Setting, args: &Args) -> Result<Motion, InputError> {
    let is_csv = path.extension().is_some_and(|x| x.eq_ignore_ascii_case("csv"));
    if is_csv && !path.is_dir() && args.map.is_none() {
        if let Some(person) = &args.person {
            let message = format!("holds one person, so `{person}` cannot be picked");
            return Err(InputError::new(path, message).remedy("leave out --person for CSV files"));
        }
        return read_angles(path, &setting.body, setting.stance, setting.duration_s);
    }
    let map = args.map.as_deref().map(read_map).transpose()?;
    let how =
        Reading { person: args.person.as_deref(), map: map.as_ref(), body: Some(&setting.body) };
    let recording = read_with(path, &how)?;
    let both = [Side::Right, Side::Left];
    let sides = if setting.sides.is_empty() { &both[..] } else { &setting.sides };
    read_recorded(&recording, &setting.body, sides)
}

fn files(scored: &Scored, json: &str, args: &Args) -> Result<Vec<(String, Vec<u8>)>, InputError> {
    let mut files = vec![
        ("summary.json".to_owned(), format!("{json}\n").into_bytes()),
        ("frames.csv".to_owned(), frames_csv(&scored.motion, &scored.sides)?),
    ];
    if let Some(sheet) = &args.sheet {
        for (i, side) in scored.sides.iter().enumerate() {
            let summary = &scored.summary.sides[i];
            for (track, time) in picks(sheet, side, summary)? {
                let picked =
                    Picked { summary: &scored.summary, side, inputs: &summary.inputs, track, time };
                let sheets = sheet_files(&picked);
                files.extend(sheets.map_err(|e| InputError::fault("worksheets", e.to_string()))?);
            }
        }
    }
    Ok(files)
}

/// Track and frame of every sheet that was asked for. A time is looked up in the first track; of
/// rollouts, in the one whose time mean of RULA is the middle one.
fn picks(
    sheet: &str,
    side: &ScoredSide,
    summary: &crate::scoring::SideSummary,
) -> Result<Vec<(usize, usize)>, InputError> {
    let wrong = |what: String| {
        InputError::new("--sheet", what).remedy("give times in s, for example 1.5,3, or `worst`")
    };
    let mut found = Vec::new();
    for word in sheet.split(',').map(str::trim) {
        if word == "worst" {
            let worst = summary.views.iter().find(|v| v.kind == crate::scoring::ViewKind::Worst);
            let Some(view) = worst else { continue };
            let Some(track) = side.tracks.iter().position(|t| t.name == view.track) else {
                continue;
            };
            found.push((track, nearest(&side.tracks[track], view.time_s)));
            continue;
        }
        let time: f64 = word
            .parse()
            .ok()
            .filter(|t: &f64| t.is_finite())
            .ok_or_else(|| wrong(format!("`{word}` is no time")))?;
        let track = middle_track(summary);
        let frames = &side.tracks[track].frames;
        let (first, last) = (frames[0].time_s, frames[frames.len() - 1].time_s);
        if !(first - 1e-9..=last + 1e-9).contains(&time) {
            return Err(wrong(format!("{time} s is outside the motion, {first} to {last} s")));
        }
        found.push((track, nearest(&side.tracks[track], time)));
    }
    Ok(found)
}

fn nearest(track: &crate::scoring::ScoredTrack, time: f64) -> usize {
    let far = |i: usize| (track.frames[i].time_s - time).abs();
    (0..track.frames.len()).min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(0)
}

fn middle_track(summary: &crate::scoring::SideSummary) -> usize {
    let Some(rollouts) = &summary.over_rollouts else { return 0 };
    let means = &rollouts.rula.by_rollout;
    let mut order: Vec<usize> = (0..means.len()).collect();
    order.sort_by(|a, b| means[*a].total_cmp(&means[*b]));
    order.get(order.len() / 2).copied().unwrap_or(0)
}

/// Compares two files of rollouts of the same people.
pub(super) fn paired(a: &Path, b: &Path, args: &Args) -> Result<Outcome, Failure> {
    if args.output.is_some() {
        return Err(InputError::new("--paired", "prints; it writes no folder")
            .remedy("leave out -o; --json prints the figures for machines")
            .into());
    }
    let setting = setting(args)?;
    let (first, second) = (score(a, &setting, args)?, score(b, &setting, args)?);
    for (path, scored) in [(a, &first), (b, &second)] {
        if scored.motion.kind != MotionKind::Rollouts {
            return Err(InputError::new(path, "holds no rollouts, so there are no pairs")
                .remedy("give two rollouts/<rank>.csv of one `ergopath plan --rollouts`")
                .into());
        }
    }
    if first.motion.tracks.len() != second.motion.tracks.len() {
        return Err(InputError::new(b, "holds another number of rollouts than the first file")
            .remedy("both must hold the same repetitions: of one `ergopath plan --rollouts`")
            .into());
    }
    let mut rows: Vec<(Side, [PairedDifference; 2])> = Vec::new();
    for (x, y) in first.summary.sides.iter().zip(&second.summary.sides) {
        let (Some(p), Some(q)) = (&x.over_rollouts, &y.over_rollouts) else { continue };
        let rula = paired_difference(&p.rula.by_rollout, &q.rula.by_rollout);
        let reba = paired_difference(&p.reba.by_rollout, &q.reba.by_rollout);
        rows.push((x.side, [rula, reba]));
    }
    if args.json {
        let sides: Vec<_> = rows
            .iter()
            .map(|(s, [rula, reba])| serde_json::json!({"side": s, "rula": rula, "reba": reba}))
            .collect();
        say!(
            "{}",
            serde_json::json!({"a": first.summary.source, "b": second.summary.source, "sides": sides})
        );
    } else {
        print_paired(&first.summary, &second.summary, &rows);
    }
    Ok(Outcome::Done)
}
