//! Recordings as native motions: a body of the person's size, the fitted joint angles, and how good they are.
//!
//! ```text
//! files ─ runs ─► sizes ─► body ─ fit ─► joint motion (CSV), quality by segment, what should be looked at
//! ```

mod findings;
mod look;
mod quality;
mod quality_file;
mod sizes;

pub use look::MotionLook;
pub use quality::{Drift, Residuals, SegmentQuality, drift};
pub use quality_file::{QUALITY_FILE, QualityRow, read_quality};
pub use sizes::{PartSize, Sizes};

use super::dataset::Trial;
use super::motion_file::{FITTED_MARK, motion_text};
use super::people::sized;
use super::source::{Source, Whom, from_recording};
use super::upright::Upright;
use crate::files::InputError;
use crate::human::{Body, Coupled, Pelvis, Side};
use crate::recording::{Map, Reading, Recording, Run, read_runs};
use rayon::prelude::*;
use std::path::PathBuf;

/// What is to be imported, and as whom.
#[derive(Debug, Clone, Copy)]
pub struct ImportRequest<'a> {
    /// Recordings of one person.
    pub files: &'a [PathBuf],
    /// Which person of a recording with several.
    pub person: Option<&'a str>,
    /// The hand that is followed.
    pub side: Side,
    /// The person's body; none: one of the size of the recorded arm.
    pub body: Option<&'a Body>,
    /// Whether the pelvis moves; none: where legs are recorded.
    pub pelvis: Option<Pelvis>,
    /// What makes markers segments.
    pub map: Option<&'a Map>,
}

/// What a call gave.
#[derive(Debug, Clone)]
pub struct Import {
    /// The body in which the motions are told.
    pub body: Body,
    /// In the order of the files.
    pub files: Vec<ImportedFile>,
    /// What should be looked at, over all files.
    pub warnings: Vec<String>,
}

/// What one file gave.
#[derive(Debug, Clone)]
pub struct ImportedFile {
    /// Name of the file.
    pub name: String,
    /// Sizes that it tells.
    pub sizes: Sizes,
    /// Its runs.
    pub runs: Vec<ImportedRun>,
    /// Joint motion of all runs, as text.
    pub motion: String,
}

/// A part of a file without long gaps.
#[derive(Debug, Clone)]
pub struct ImportedRun {
    /// Its first frame in the file.
    pub first_frame: usize,
    /// Gaps filled in the whole file.
    pub gaps_filled: usize,
    /// Frames of the file that are in no run.
    pub frames_left_out: usize,
    /// The fitted movement.
    pub source: Source,
    /// Residuals of each recorded segment of the chain.
    pub segments: Vec<SegmentQuality>,
    /// How planted feet slide; none without legs.
    pub feet: Option<Drift>,
}

/// Reads, sizes, and fits.
///
/// # Errors
/// Where a file cannot be read or fitted, or is given twice.
pub fn import(request: &ImportRequest) -> Result<Import, InputError> {
    let how = Reading { person: request.person, map: request.map, body: request.body };
    let read: Result<Vec<Vec<Run>>, InputError> =
        request.files.par_iter().map(|path| read_runs(path, &how)).collect();
    let read = read?;
    let recordings: Vec<Recording> =
        read.iter().flatten().map(|run| run.recording.clone()).collect();
    let body = match request.body {
        Some(body) => body.clone(),
        None => sized("body", request.side, &recordings)?,
    };
    let whom = Whom {
        person: request.person,
        side: request.side,
        body: &body,
        pelvis: request.pelvis,
        map: request.map,
    };
    let files: Result<Vec<ImportedFile>, InputError> =
        read.par_iter().map(|runs| one(runs, &whom)).collect();
    let files = files?;
    let all: Vec<&Source> =
        files.iter().flat_map(|f| f.runs.iter().take(1)).map(|r| &r.source).collect();
    super::source::refuse_twice(&all)?;
    let warnings = findings::all(&files, &read, &whom);
    Ok(Import { body, files, warnings })
}

fn one(runs: &[Run], whom: &Whom) -> Result<ImportedFile, InputError> {
    let done: Result<Vec<ImportedRun>, InputError> = runs
        .par_iter()
        .map(|run| {
            let source = from_recording(&run.recording, whom, Upright::AS_RECORDED)?;
            Ok(ImportedRun {
                first_frame: run.first_frame,
                gaps_filled: run.gaps_filled,
                frames_left_out: run.frames_left_out,
                segments: quality::segments(&run.recording, whom, &source)?,
                feet: drift(&run.recording),
                source,
            })
        })
        .collect();
    let done = done?;
    let first = runs.first().map(|r| &r.recording);
    let name = first.map_or_else(String::new, |r| r.source.clone());
    Ok(ImportedFile {
        sizes: Sizes::of(runs.iter().map(|r| &r.recording), whom.side)?,
        motion: motion(&name, &done, whom)?,
        name,
        runs: done,
    })
}

/// The joint motion of a file: a trial for each run.
fn motion(name: &str, runs: &[ImportedRun], whom: &Whom) -> Result<String, InputError> {
    let trials: Vec<&Trial> = runs.iter().flat_map(|r| &r.source.trials).collect();
    let dof = trials.first().and_then(|t| t.q.first()).map_or(0, Vec::len);
    let coupled = |pelvis| Coupled { hands: whom.side.into(), pelvis };
    let chain = [Pelvis::Rests, Pelvis::Moves]
        .into_iter()
        .map(|pelvis| whom.body.chain(coupled(pelvis), &[]))
        .find(|chain| chain.as_ref().is_ok_and(|c| c.dof() == dof));
    let chain =
        chain.ok_or_else(|| InputError::fault(name, "has another chain than its body"))??;
    let joints: Vec<String> = chain.joints().iter().map(|j| j.name.clone()).collect();
    let timed: Vec<(Vec<f64>, Vec<Vec<f64>>)> = trials
        .iter()
        .zip(runs)
        .map(|(t, run)| {
            let time = |i: usize| (run.first_frame + i) as f64 / t.rate_hz;
            ((0..t.q.len()).map(time).collect(), t.q.clone())
        })
        .collect();
    let made_by = format!("{}, {} hand, body {}", name, whom.side.name(), whom.body.name);
    // The mark is the first line.
    let text = motion_text(
        &[FITTED_MARK.trim_start_matches("# "), &made_by],
        (&joints, whom.body),
        &timed,
    );
    let steps: Vec<bool> = trials.iter().flat_map(|t| t.stepping.iter().copied()).collect();
    Ok(if steps.is_empty() { text } else { with_steps(&text, &steps) })
}

/// The same table with a column on whether a foot steps.
fn with_steps(text: &str, steps: &[bool]) -> String {
    let mut steps = steps.iter();
    let mut is_header = true;
    let mut with = String::with_capacity(text.len() + 2 * steps.len());
    for line in text.lines() {
        with.push_str(line);
        if !line.starts_with('#') {
            let cell = if is_header {
                ",stepping"
            } else if steps.next().copied().unwrap_or_default() {
                ",1"
            } else {
                ",0"
            };
            with.push_str(cell);
            is_header = false;
        }
        with.push('\n');
    }
    with
}
