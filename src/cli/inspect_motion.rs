//! `ergopath inspect MOTION`: an imported motion again, with the quality that its import found.

use super::import_print::quality_table;
use super::inspect::Args;
use super::{Failure, Outcome};
use crate::files::{InputError, NumericTable, Outputs};
use crate::human::{Body, Side};
use crate::report::{ImportPicture, import_figure};
use crate::training::{
    MotionLook, QUALITY_FILE, QualityRow, SegmentQuality, read_motion, read_quality,
};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The path of the picture of the i-th file, from 0; pictures are PNG.
pub(super) fn figure_path(asked: &Path, i: usize) -> Result<PathBuf, InputError> {
    if !asked.extension().is_some_and(|x| x.eq_ignore_ascii_case("png")) {
        return Err(InputError::new(asked, "is no name of a picture")
            .remedy("pictures are PNG: give a name that ends with .png"));
    }
    if i == 0 {
        return Ok(asked.to_owned());
    }
    let stem = asked.file_stem().unwrap_or_default().to_string_lossy();
    Ok(asked.with_file_name(format!("{stem}_{}.png", i + 1)))
}

/// Prints the motion, and draws it.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let folder = args.file.parent().unwrap_or(Path::new(""));
    let body = match &args.body {
        Some(name) => Body::load(name, Path::new("."))?,
        None => body_beside(&args.file, folder)?,
    };
    let side = side_of(&args.file)?;
    let motion = read_motion(&args.file, &body, side)?;
    let rows = quality_of(&args.file, &folder.join(QUALITY_FILE))?;
    let of_run = |run: usize| -> Vec<SegmentQuality> {
        rows.iter().filter(|r| r.run == run).map(|r| r.quality.clone()).collect()
    };
    if let Some(figure) = &args.figure {
        let longest = motion.trials.iter().enumerate().max_by_key(|(_, t)| t.q.len());
        let (i, trial) = longest
            .ok_or_else(|| InputError::new(&args.file, "holds no movement that could be drawn"))?;
        let look = MotionLook::new(&body, side, trial)?;
        let title = format!("{}, {} hand", motion.source, side.name());
        let quality = of_run(i + 1);
        let picture = ImportPicture { title: &title, body: &body, look: &look, quality: &quality };
        let png = import_figure(&picture).map_err(|e| InputError::fault(figure, e.to_string()))?;
        outputs.file(&figure_path(figure, 0)?, png)?;
    }
    outputs.write()?;
    if args.json {
        let runs: Vec<_> = motion
            .trials
            .iter()
            .enumerate()
            .map(|(i, t)| {
                json!({"rows": t.q.len(), "rate_hz": t.rate_hz, "segments": of_run(i + 1)})
            })
            .collect();
        say!("{}", json!({"motion": motion.source, "side": side, "body": body.name, "runs": runs}));
        return Ok(Outcome::Done);
    }
    say!("{}: joint motion of the {} hand in the body `{}`", motion.source, side.name(), body.name);
    for (i, trial) in motion.trials.iter().enumerate() {
        say!(
            "\ntrial {}: {} rows at {:.0} Hz, {:.1} s",
            i + 1,
            trial.q.len(),
            trial.rate_hz,
            trial.q.len() as f64 / trial.rate_hz
        );
        let quality = of_run(i + 1);
        if quality.is_empty() {
            say!("no residuals: there is no {QUALITY_FILE} of it beside it");
        } else {
            say!("{}", quality_table(&quality));
        }
    }
    if let Some(figure) = &args.figure {
        say!("\n{}", figure.display());
    }
    Ok(Outcome::Done)
}

/// The body that an import wrote beside its motions.
fn body_beside(file: &Path, folder: &Path) -> Result<Body, InputError> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(here)
        .map_err(|e| InputError::new(here, format!("cannot be read: {e}")))?;
    let paths = entries.filter_map(|e| Some(e.ok()?.path()));
    let bodies: Vec<PathBuf> = paths
        .filter(|p| p.extension().is_some_and(|x| x == "urdf"))
        .filter(|p| p.with_extension("body.toml").is_file())
        .collect();
    match bodies.as_slice() {
        [one] => Body::read(one),
        many => {
            let message = format!("has {} bodies beside it", many.len());
            Err(InputError::new(file, message)
                .remedy("say with --body in which one its joint angles are told"))
        }
    }
}

/// The hand that a motion follows, told by its columns.
fn side_of(file: &Path) -> Result<Side, InputError> {
    let table = NumericTable::read(file)?;
    let holds = |side: Side| {
        let joint = format!("j{}Elbow_Z", side.prefix());
        table.columns.iter().any(|c| *c == crate::human::column_of(&joint))
    };
    let found = [Side::Right, Side::Left].into_iter().find(|s| holds(*s));
    found.ok_or_else(|| {
        InputError::new(file, "holds no joint angles of an arm").remedy(
            "give a motion that `ergopath import` wrote; `ergopath check` says what a file is",
        )
    })
}

/// What the table beside a motion says of it; nothing where there is none.
fn quality_of(file: &Path, table: &Path) -> Result<Vec<QualityRow>, InputError> {
    if !table.is_file() {
        return Ok(Vec::new());
    }
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    Ok(read_quality(table)?.into_iter().filter(|row| row.motion == name).collect())
}
