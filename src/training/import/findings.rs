//! What should be looked at before an import is believed, in words: what changes the result comes first.

use super::ImportedFile;
use crate::human::{Pelvis, Side};
use crate::math::stats;
use crate::recording::{Recording, Remark, Run, grouped};
use crate::training::fit_report::FitReport;
use crate::training::motion_file::FEWEST_ROWS;
use crate::training::source::Whom;

/// The other hand goes so many times as far as the one that is followed,
const IDLE: f64 = 3.0;
/// and at least so far, m.
const IDLE_WAY_M: f64 = 0.3;
/// Residual of the hand that is an error of the body or of the recording, mm.
const LARGE_MM: f64 = 50.0;
/// Statures by the arms of two files that are those of two people, as a share.
const TWO_PEOPLE: f64 = 0.04;
/// Bend of both knees over which somebody sits who does not move the hips, rad.
const SITS: f64 = 1.0;
/// Way of the hips of somebody who sits, m.
const SEATED_WAY_M: f64 = 0.15;
/// Share of frames at a limit that is worth a word.
const PRESSED: f64 = 0.1;
/// Way of a planted foot that is worth a word, mm.
const SLIDES_MM: f64 = 50.0;
/// Turn of a segment that is worth a word where it is common to the files, deg.
const TURNED_DEG: f64 = 3.0;

pub(super) fn all(files: &[ImportedFile], read: &[Vec<Run>], whom: &Whom) -> Vec<String> {
    let of = |(file, runs): (&ImportedFile, &Vec<Run>)| -> Vec<Remark> {
        let recordings = || runs.iter().map(|r| &r.recording);
        let found = [
            idle(recordings(), whom.side),
            residual(file),
            sits(recordings(), whom),
            few(file),
            borders(file),
            sizes(file),
            pressed(file),
            feet(file),
        ];
        found.into_iter().flatten().collect()
    };
    let remarks: Vec<Vec<Remark>> = files.iter().zip(read).map(of).collect();
    let named = files.iter().zip(&remarks).map(|(f, r)| (f.name.as_str(), r.as_slice()));
    let mut found: Vec<String> = two_people(files).into_iter().collect();
    found.extend(grouped(&named.collect::<Vec<_>>()));
    found.extend(common_turns(files));
    found
}

/// Way of the hand of a side, seen from the pelvis, m.
fn way<'a>(recordings: impl Iterator<Item = &'a Recording>, side: Side) -> Option<f64> {
    let mut sum = None;
    for r in recordings {
        let (pelvis, hand) = (r.segment("Pelvis")?, r.segment(&format!("{}Hand", side.prefix()))?);
        let at = |i: usize| pelvis.rotation[i].inverse() * (hand.position[i] - pelvis.position[i]);
        let way: f64 = (1..r.frames()).map(|i| (at(i) - at(i - 1)).norm()).sum();
        sum = Some(sum.unwrap_or(0.0) + way);
    }
    sum
}

fn idle<'a>(recordings: impl Iterator<Item = &'a Recording> + Clone, side: Side) -> Option<Remark> {
    let other = side.other();
    let (own, others) = (way(recordings.clone(), side)?, way(recordings, other)?);
    (others > IDLE_WAY_M && others > IDLE * own).then(|| {
        let text = format!(
            "the {} hand goes {own:.2} m, the {} one {others:.2} m: did you mean --side {}?",
            side.name(),
            other.name(),
            other.name()
        );
        Remark::new("idle hand", text).of_size(others)
    })
}

fn reports(file: &ImportedFile) -> impl Iterator<Item = &FitReport> {
    file.runs.iter().filter_map(|r| r.source.fit())
}

fn residual(file: &ImportedFile) -> Option<Remark> {
    let worst = reports(file).map(|r| r.hand_residual_mm.p95).fold(0.0, f64::max);
    (worst > LARGE_MM).then(|| {
        let text = format!(
            "the hand of the body is {worst:.0} mm off the recorded one in one frame of twenty, over 5 cm: another \
             --body, or look at the recording before it is used"
        );
        Remark::new("residual", text).of_size(worst)
    })
}

/// Knees that stay bent while the hips stay where they are.
fn sits<'a>(recordings: impl Iterator<Item = &'a Recording>, whom: &Whom) -> Option<Remark> {
    if whom.pelvis == Some(Pelvis::Rests) {
        return None;
    }
    let (mut bends, mut ways) = (Vec::new(), Vec::new());
    for r in recordings {
        let pelvis = r.segment("Pelvis")?;
        let first = *pelvis.position.first()?;
        ways.extend(pelvis.position.iter().map(|p| (p - first).norm()));
        for side in ["Right", "Left"] {
            let track = |part: &str| r.segment(&format!("{side}{part}"));
            let (hip, knee, foot) = (track("UpperLeg")?, track("LowerLeg")?, track("Foot")?);
            bends.extend((0..r.frames()).map(|i| {
                let (thigh, shank) =
                    (knee.position[i] - hip.position[i], foot.position[i] - knee.position[i]);
                thigh.angle(&shank)
            }));
        }
    }
    let (bend, way) = (stats::quantile(&bends, 0.1), stats::quantile(&ways, 0.95));
    (bend > SITS && way < SEATED_WAY_M).then(|| {
        let text = format!(
            "the knees stay bent by {:.0} deg and the hips where they are: if the person sits, add --pelvis rests",
            bend.to_degrees()
        );
        Remark::new("sits", text).of_size(bend)
    })
}

/// Too few frames to be read again as a motion.
fn few(file: &ImportedFile) -> Option<Remark> {
    let fewest = reports(file).map(|r| r.frames).min().filter(|n| *n < FEWEST_ROWS)?;
    let text = format!(
        "{fewest} frames are imported, and nothing is learned from fewer than {FEWEST_ROWS}"
    );
    Some(Remark::new("few frames", text))
}

fn borders(file: &ImportedFile) -> Option<Remark> {
    let left_out = file.runs.first()?.frames_left_out;
    (left_out > 0).then(|| {
        let text = format!(
            "{} runs between long gaps, each a trial of its own; {left_out} frames are in none of them",
            file.runs.len()
        );
        Remark::new("runs", text).of_size(left_out as f64)
    })
}

fn sizes(file: &ImportedFile) -> Option<Remark> {
    let [arm, leg] = file.sizes.conflict()?;
    let text = format!(
        "its arms are those of a person of {arm:.2} m, its legs of {leg:.2} m: the body takes the arms' size unless \
         --body says otherwise"
    );
    Some(Remark::new("sizes", text).of_size((arm / leg - 1.0).abs()))
}

fn pressed(file: &ImportedFile) -> Option<Remark> {
    let worst = reports(file)
        .max_by(|a, b| a.frames_at_limit_share.total_cmp(&b.frames_at_limit_share))
        .filter(|r| r.frames_at_limit_share > PRESSED)?;
    let joints: Vec<&str> = worst.joints_at_limit.iter().take(3).map(|(j, _)| j.as_str()).collect();
    let text = format!(
        "a joint is at its limit in {:.0} % of the frames ({}): its angles are those of the limit there, not of the \
         person",
        100.0 * worst.frames_at_limit_share,
        joints.join(", ")
    );
    Some(Remark::new("limits", text).of_size(worst.frames_at_limit_share))
}

fn feet(file: &ImportedFile) -> Option<Remark> {
    let feet = file.runs.iter().filter_map(|r| r.feet);
    let worst = feet.max_by(|a, b| a.largest_mm.total_cmp(&b.largest_mm))?;
    (worst.largest_mm > SLIDES_MM).then(|| {
        let text = format!(
            "a planted foot slides by up to {:.0} mm while it stands: heights and steps are as uncertain",
            worst.largest_mm
        );
        Remark::new("sliding feet", text).of_size(worst.largest_mm)
    })
}

/// Arms of two lengths in one call.
fn two_people(files: &[ImportedFile]) -> Option<String> {
    let arms = files.iter().filter_map(|f| Some((f.name.as_str(), f.sizes.part("arm")?.stature_m)));
    let arms: Vec<(&str, f64)> = arms.collect();
    let shortest = arms.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let longest = arms.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (longest.1 / shortest.1 - 1.0 > TWO_PEOPLE).then(|| {
        format!(
            "two body sizes in one call: by the arm {} is {:.2} m tall and {} {:.2} m. Import people apart",
            shortest.0, shortest.1, longest.0, longest.1
        )
    })
}

/// Turns of segments about their own axes that are the same in all files: of the calibration of a day, not of
/// the movements.
fn common_turns(files: &[ImportedFile]) -> Option<String> {
    if files.len() < 2 {
        return None;
    }
    let all: Vec<&FitReport> = files.iter().flat_map(reports).collect();
    let mut told = Vec::new();
    for (segment, _) in &all.first()?.calibration_deg {
        let turns: Vec<[f64; 3]> = all
            .iter()
            .filter_map(|r| r.calibration_deg.iter().find(|(n, _)| n == segment))
            .map(|(_, turn)| *turn)
            .collect();
        for (axis, name) in ["ahead", "up", "right"].into_iter().enumerate() {
            let column: Vec<f64> = turns.iter().map(|t| t[axis]).collect();
            let (mean, spread) = (stats::mean(&column), stats::std_dev(&column));
            if mean.abs() > TURNED_DEG.max(2.0 * spread) {
                told.push(format!("{segment} {mean:.0} deg about {name}"));
            }
        }
    }
    (!told.is_empty()).then(|| {
        format!(
            "common to all files, so of the calibration and not of the movements, and taken out: {}",
            told.join(", ")
        )
    })
}
