//! The recordings of one person, read and fitted: what a model is learned from.

use super::dataset::{Dataset, Trial};
use super::filled::fill_pelvis;
use super::fit::{FitSettings, fit};
use super::fit_report::FitReport;
use super::motion_file::read_motion;
use super::over_feet::{OverFeet, over_feet, turns_where_it_faces};
use super::upright::Upright;
use crate::files::InputError;
use crate::human::{Body, Pelvis, Side};
use crate::posture::Provenance;
use crate::recording::{BORDERS, Map, Reading, Recording, Remark, Run, grouped, read_runs};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Joints from the pelvis to a grip.
const ARM_JOINTS: usize = 24;

/// Whom to look for in recordings.
#[derive(Debug, Clone, Copy)]
pub struct Whom<'a> {
    /// Which person of a recording with several.
    pub person: Option<&'a str>,
    /// The hand that holds on to the robot.
    pub side: Side,
    /// The person's body.
    pub body: &'a Body,
    /// Whether the pelvis moves in what is learned: as asked, or where all recordings hold the legs.
    pub pelvis: Option<Pelvis>,
    /// What makes markers the segments of a person.
    pub map: Option<&'a Map>,
}

impl<'a> Whom<'a> {
    /// How recordings are read.
    pub(super) fn reading(&self) -> Reading<'a> {
        Reading { person: self.person, map: self.map, body: Some(self.body) }
    }
}

/// What one recording gave.
#[derive(Debug, Clone)]
pub struct Source {
    /// Name of the file or folder.
    pub name: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
    /// Whether the movements are of a simulated operator.
    pub simulated: bool,
    /// The movements.
    pub trials: Vec<Trial>,
    /// How the joint angles came about.
    pub angles: Angles,
    /// What was assumed of it, and what looks odd.
    pub remarks: Vec<Remark>,
}

/// How joint angles came about.
#[derive(Debug, Clone)]
pub enum Angles {
    /// A body was fitted to recorded segments.
    Fitted {
        /// Kind of the recording.
        format: &'static str,
        /// Frames per second.
        rate_hz: f64,
        /// How well.
        report: Box<FitReport>,
    },
    /// They were given.
    Given {
        /// Cut-off of the low-pass filter, Hz; none where the rate is too low for one.
        cutoff_hz: Option<f64>,
    },
}

impl Source {
    /// How well the body fits; none where the angles were given.
    pub fn fit(&self) -> Option<&FitReport> {
        match &self.angles {
            Angles::Fitted { report, .. } => Some(report),
            Angles::Given { .. } => None,
        }
    }

    /// Whether its postures hold a pelvis that moves.
    pub(super) fn moves_pelvis(&self) -> bool {
        self.trials.iter().flat_map(|t| &t.q).all(|q| q.len() > ARM_JOINTS)
    }
}

/// Reads all recordings of one person and makes them one data set.
///
/// # Errors
/// Where a recording cannot be read or fitted, is given twice, or where simulated and real movements
/// would be mixed.
pub fn read_person(
    recordings: &[PathBuf],
    whom: &Whom,
) -> Result<(Vec<Source>, Dataset), InputError> {
    // Legs that are asked for and missing are filled in below.
    let willing = Whom { pelvis: whom.pelvis.filter(|p| *p == Pelvis::Rests), ..*whom };
    let sources: Result<Vec<Source>, InputError> =
        recordings.iter().map(|path| read_source(path, &willing)).collect();
    let mut sources = sources?;
    refuse_mixture(&sources)?;
    let filled = match whom.pelvis {
        Some(Pelvis::Moves) => fill_pelvis(&mut sources, (whom.body, whom.side))?,
        _ => None,
    };
    rest_where_one_must(&mut sources);
    let trials: Vec<Trial> = sources.iter().flat_map(|s| s.trials.clone()).collect();
    let mut dataset = Dataset::new(&trials, whom.body, whom.side)?;
    dataset.filled = filled.map(Arc::new);
    Ok((sources, dataset))
}

/// Reads a recording and fits the body to it, or takes the joint angles of a file.
///
/// # Errors
/// Where it cannot be read, or the person is not in it.
pub fn read_source(path: &Path, whom: &Whom) -> Result<Source, InputError> {
    let is_csv = path.extension().is_some_and(|x| x.eq_ignore_ascii_case("csv"));
    if is_csv && !path.is_dir() && whom.map.is_none() {
        return from_angles(path, whom);
    }
    from_runs(&read_runs(path, &whom.reading())?, whom)
}

/// Fits the body to the runs of a recording between its long gaps, each a trial of its own.
fn from_runs(runs: &[Run], whom: &Whom) -> Result<Source, InputError> {
    let as_recorded = Upright::AS_RECORDED;
    let fitted: Result<Vec<Source>, InputError> =
        runs.iter().map(|run| from_recording(&run.recording, whom, as_recorded)).collect();
    let mut fitted = fitted?;
    let longest = (0..runs.len()).max_by_key(|&i| (runs[i].recording.frames(), usize::MAX - i));
    let Some(longest) = longest.filter(|_| runs.len() > 1) else {
        return fitted.pop().ok_or_else(|| InputError::new("recording", "holds no movement"));
    };
    let mut spans = Vec::new();
    for (run, own) in runs.iter().zip(&mut fitted) {
        let (from, to) = (run.first_frame, run.first_frame + run.recording.frames() - 1);
        spans.push(format!("{from} to {to}"));
        for trial in &mut own.trials {
            trial.source = format!("{} frames {from} to {to}", own.name);
        }
    }
    let trials = fitted.iter().flat_map(|own| own.trials.clone()).collect();
    let mut whole = fitted.swap_remove(longest);
    whole.remarks.retain(|r| r.about != BORDERS);
    let text = format!(
        "{} runs between long gaps, each a trial of its own: frames {}; what is said of the fit is true of the longest",
        runs.len(),
        spans.join(", ")
    );
    whole.remarks.insert(0, Remark::new(BORDERS, text).of_size(1.0));
    Ok(Source { trials, ..whole })
}

/// Fits the body to a recording of a person with such legs.
pub(super) fn from_recording(
    recording: &Recording,
    whom: &Whom,
    upright: Upright,
) -> Result<Source, InputError> {
    let settings = FitSettings::default();
    let motion = fit(recording, whom.body, whom.side, &settings)?;
    let report = motion.report.clone();
    let mut remarks: Vec<Remark> =
        recording.remarks.iter().chain(&report.remarks).cloned().collect();
    let mut trial = Trial::from(&motion);
    if whom.pelvis != Some(Pelvis::Rests) {
        if let Some(standing) = over_feet(recording, whom.body, upright, settings.cutoff_hz)? {
            remarks.extend(standing_remarks(&standing));
            remarks.extend(upright_remarks(upright, standing.leg_m));
            trial = Trial { stepping: standing.stepping, ..trial.on_pelvis(&standing.pelvis) };
        } else if whom.pelvis.is_some() {
            return Err(InputError::new(&recording.source, "does not hold both legs")
                .remedy("a pelvis that moves is told from the feet: leave it at rest"));
        } else {
            trial.turn = turns_where_it_faces(recording, settings.cutoff_hz);
        }
    }
    Ok(Source {
        remarks,
        name: recording.source.clone(),
        sha256: recording.sha256.clone(),
        simulated: false,
        trials: vec![trial],
        angles: Angles::Fitted {
            format: recording.format,
            rate_hz: recording.rate_hz,
            report: Box::new(report),
        },
    })
}

fn from_angles(path: &Path, whom: &Whom) -> Result<Source, InputError> {
    if let Some(person) = whom.person {
        let message = format!("holds joint angles of one person, so `{person}` cannot be picked");
        return Err(InputError::new(path, message).remedy("leave out --person for CSV files"));
    }
    let file = read_motion(path, whom.body, whom.side)?;
    Ok(Source {
        name: file.source,
        sha256: file.sha256,
        simulated: file.simulated,
        trials: file.trials,
        angles: Angles::Given { cutoff_hz: file.cutoff_hz },
        remarks: Vec::new(),
    })
}

/// What a reader should know of a pelvis over its feet.
fn standing_remarks(standing: &OverFeet) -> Vec<Remark> {
    /// Change of height that is worth a word, leg lengths.
    const WORTH_A_WORD: f64 = 0.02;
    let text = format!(
        "the pelvis is told from the feet, which step in {:.0} % of the frames; leg of {:.2} m from hip to ankle",
        100.0 * standing.stepping_share(),
        standing.leg_m
    );
    let mut remarks = vec![Remark::new("feet", text).of_size(standing.stepping_share())];
    if standing.shifted > WORTH_A_WORD {
        let text = format!(
            "the pelvis was moved up or down by up to {:.0} % of a leg, for the knees of a body with its feet side by side \
             to bend as recorded",
            100.0 * standing.shifted
        );
        remarks.push(Remark::new("height of the pelvis", text).of_size(standing.shifted));
    }
    remarks
}

/// What a reader should know of joint centres that were seen to lie elsewhere than a body's; `leg_m` is the leg.
fn upright_remarks(upright: Upright, leg_m: f64) -> Vec<Remark> {
    /// Flexion that is worth a word, deg, and distance, cm.
    const WORTH_A_WORD_DEG: f64 = 10.0;
    const WORTH_A_WORD_CM: f64 = 2.0;
    let mut remarks = Vec::new();
    let bent = upright.look_bent_deg();
    if bent > WORTH_A_WORD_DEG {
        let text = format!(
            "where this person stands tallest the knees look bent by {bent:.0} deg: there they count as straight, as the joint \
             centres of some systems lie ahead of the knee"
        );
        remarks.push(Remark::new("straight knees", text).of_size(bent));
    }
    let inclined = upright.looks_inclined_deg();
    if inclined > WORTH_A_WORD_DEG {
        let text = format!(
            "where this person stands erect the pelvis looks inclined by {inclined:.0} deg: there it counts as level"
        );
        remarks.push(Remark::new("level pelvis", text).of_size(inclined));
    }
    let ahead_cm = 100.0 * upright.hips_ahead * leg_m;
    if ahead_cm.abs() > WORTH_A_WORD_CM {
        let text = format!(
            "where this person stands erect the hips lie {:.0} cm {} the line of the spine, those of the body in it: the trunk \
             is put where it was recorded",
            ahead_cm.abs(),
            if ahead_cm > 0.0 { "ahead of" } else { "behind" }
        );
        remarks.push(Remark::new("hips and spine", text).of_size(ahead_cm.abs()));
    }
    remarks
}

/// One recording without legs leaves every pelvis at rest.
fn rest_where_one_must(sources: &mut [Source]) {
    let Some(still) = sources.iter().find(|s| !s.moves_pelvis()).map(|s| s.name.clone()) else {
        return;
    };
    for source in sources.iter_mut().filter(|s| s.fit().is_some()) {
        if source.moves_pelvis() {
            let text = format!("learned over a pelvis that rests, as {still} holds no legs");
            source.remarks.push(Remark::new("resting pelvis", text));
            source.trials.iter_mut().for_each(Trial::leave_pelvis);
        }
    }
}

/// Simulated and real movements must not make one model.
fn refuse_mixture(sources: &[Source]) -> Result<(), InputError> {
    let simulated = sources.iter().filter(|s| s.simulated).count();
    if let Some(real) = sources.iter().find(|s| !s.simulated && simulated > 0) {
        return Err(InputError::new(
            &real.name,
            "is a recording of a person, and another is of a simulated operator: one model would mix them",
        )
        .remedy("train them apart"));
    }
    refuse_twice(&sources.iter().collect::<Vec<_>>())
}

const TOO_GOOD: &str = "a recording that is also held out would make the scores too good";

/// A recording that is given twice would be held out and teach at once.
///
/// # Errors
/// Where two have the same bytes, or hold the same movement.
pub fn refuse_twice(sources: &[&Source]) -> Result<(), InputError> {
    for (i, source) in sources.iter().enumerate() {
        if sources[..i].iter().any(|s| s.sha256 == source.sha256) {
            return Err(InputError::new(&source.name, "is given twice").remedy(TOO_GOOD));
        }
    }
    let trials: Vec<&Trial> = sources.iter().flat_map(|s| &s.trials).collect();
    for (i, trial) in trials.iter().enumerate() {
        if let Some(same) = trials[..i].iter().find(|t| t.q == trial.q) {
            let message = format!("holds the same movement as {}", same.source);
            return Err(InputError::new(&trial.source, message).remedy(TOO_GOOD));
        }
    }
    Ok(())
}

/// What should be known of recordings, said once where it is true of several.
pub fn remarks_of<'a>(sources: impl IntoIterator<Item = &'a Source>) -> Vec<String> {
    let all: Vec<_> =
        sources.into_iter().map(|s| (s.name.as_str(), s.remarks.as_slice())).collect();
    grouped(&all)
}

/// What a model of these recordings was made from and how.
pub fn provenance(sources: &[Source], whom: &Whom) -> Provenance {
    let fits = sources.iter().any(|s| s.fit().is_some());
    let mut settings = vec![("cutoff_hz".to_owned(), FitSettings::default().cutoff_hz.to_string())];
    if fits {
        let fit = FitSettings::default();
        for (name, value) in [
            ("orientation_sd_deg", fit.orientation_sd_deg),
            ("axial_sd_deg", fit.axial_sd_deg),
            ("tilt_sd_deg", fit.tilt_sd_deg),
            ("limit_slack_deg", fit.limit_slack_deg),
            ("hand_sd_mm", fit.hand_sd_mm),
            ("sharing_sd_deg", fit.sharing_sd_deg),
            ("previous_sd_deg", fit.previous_sd_deg),
        ] {
            settings.push((format!("fit_{name}"), value.to_string()));
        }
    }
    if let Some(map) = whom.map {
        settings.push(("map".to_owned(), map.name.clone()));
    }
    if let Some(person) = whom.person {
        settings.push(("person".to_owned(), person.to_owned()));
    }
    Provenance {
        program_version: env!("CARGO_PKG_VERSION").to_owned(),
        simulated: sources.iter().any(|s| s.simulated),
        adapted_s: None,
        people: 1,
        filled_from: None,
        recordings: sources.iter().map(|s| (s.name.clone(), s.sha256.clone())).collect(),
        body: (whom.body.name.clone(), whom.body.sha256()),
        settings,
        notes: remarks_of(sources),
    }
}
