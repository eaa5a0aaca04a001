//! `ergopath import`: recordings become motions of a body of the person's size, with a table of their quality.

use super::import_print::{as_json, print_text};
use super::inspect_motion::figure_path;
use super::train::{parse_pelvis, parse_side};
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, read_text};
use crate::human::{Body, BodyFiles, PRESETS, Pelvis, Side, generate};
use crate::recording::read_map;
use crate::report::{ImportPicture, import_figure};
use crate::training::{
    Import, ImportRequest, ImportedFile, MotionLook, QUALITY_FILE, import, remarks_of,
};
use std::path::{Path, PathBuf};

const AUTO: &str = "auto";

/// Arguments of `import`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Recordings of one person: MVNX and BVH files, AMC files with their ASF, MOT and STO files of coordinates,
    /// folders of rigid-body CSV files, or with --map C3D and TRC files and tables.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Body of the person: a shipped one by name, or a URDF made by `ergopath body`; by default a man's body
    /// with arms as long as the recorded ones. Files of coordinates (MOT, STO) have no lengths: give it.
    #[arg(long, default_value = AUTO, value_name = "auto|BODY")]
    body: String,
    /// What makes the markers of C3D and TRC files, or the points and columns of tables, the segments of a person:
    /// a file, or a shipped map by name.
    #[arg(long, value_name = "MAP.toml|NAME")]
    map: Option<PathBuf>,
    /// Which person of a folder with several.
    #[arg(long)]
    person: Option<String>,
    /// The hand that is followed.
    #[arg(long, value_parser = parse_side, default_value = "right", value_name = "right|left")]
    side: Side,
    /// Whether the pelvis moves over planted feet or rests, as of somebody who sits: by default it moves
    /// where both legs are recorded.
    #[arg(long, value_parser = parse_pelvis, value_name = "moves|rests")]
    pelvis: Option<Pelvis>,
    /// Folder to write: a motion for each file, the body, and `quality.csv`.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Draw the movement: the person, main angles, residuals; of several files each, numbered.
    #[arg(long, value_name = "FILE.png")]
    figure: Option<PathBuf>,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

/// Imports, writes the folder, prints.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let map = args.map.as_deref().map(read_map).transpose()?;
    let body = (args.body != AUTO).then(|| Body::load(&args.body, Path::new("."))).transpose()?;
    outputs.expect_folder(&args.output)?;
    if let Some(figure) = &args.figure {
        figure_path(figure, 0)?;
    }
    let done = import(&ImportRequest {
        files: &args.files,
        person: args.person.as_deref(),
        side: args.side,
        body: body.as_ref(),
        pelvis: args.pelvis,
        map: map.as_ref(),
    })?;
    let names = names(&done);
    let BodyFiles { urdf, sheet } = body_files(&args.body, &done.body)?;
    let body_name = format!("{}.urdf", done.body.name);
    let mut files = vec![
        (body_name.clone(), urdf.into_bytes()),
        (format!("{}.body.toml", done.body.name), sheet.into_bytes()),
        (QUALITY_FILE.to_owned(), done.quality_csv(&names)?),
    ];
    for (file, name) in done.files.iter().zip(&names) {
        files.push((name.clone(), file.motion.clone().into_bytes()));
    }
    outputs.folder(&args.output, files)?;
    let mut figures = Vec::new();
    for (i, file) in done.files.iter().enumerate() {
        if let Some(figure) = &args.figure {
            let path = figure_path(figure, i)?;
            outputs.file(&path, picture(file, &done.body, args.side)?)?;
            figures.push(path);
        }
    }
    outputs.write()?;
    for warning in &done.warnings {
        complain!("warning: {warning}");
    }
    if args.json {
        say!("{}", as_json(&done, &names, &body_name));
        return Ok(Outcome::Done);
    }
    for remark in remarks_of(done.files.iter().flat_map(|f| &f.runs).map(|r| &r.source)) {
        complain!("note: {remark}");
    }
    print_text(&done, args.side);
    say!("\n{}: the body", args.output.join(&body_name).display());
    for name in &names {
        say!("{}: its joint motion", args.output.join(name).display());
    }
    say!("{}: all of the table", args.output.join(QUALITY_FILE).display());
    for figure in &figures {
        say!("{}: the picture", figure.display());
    }
    Ok(Outcome::Done)
}

/// A picture of the longest run of a file.
fn picture(file: &ImportedFile, body: &Body, side: Side) -> Result<Vec<u8>, InputError> {
    let runs = file.runs.iter().filter_map(|run| Some((run, run.source.trials.first()?)));
    let longest = runs.max_by_key(|(_, trial)| trial.q.len());
    let (run, trial) =
        longest.ok_or_else(|| InputError::fault(&file.name, "holds no movement to draw"))?;
    let look = MotionLook::new(body, side, trial)?;
    let title = format!("{}, {} hand", file.name, side.name());
    import_figure(&ImportPicture { title: &title, body, look: &look, quality: &run.segments })
        .map_err(|e| InputError::fault(&file.name, e.to_string()))
}

/// A file of its own for each recording: its name, counted where two are alike.
fn names(done: &Import) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for file in &done.files {
        let stem = Path::new(&file.name).file_stem().unwrap_or_default().to_string_lossy();
        let free = |n: &usize| {
            let name = if *n == 1 { format!("{stem}.csv") } else { format!("{stem}_{n}.csv") };
            name != QUALITY_FILE && !names.contains(&name)
        };
        // Of as many and two more names one is free.
        let n = (1..=names.len() + 2).find(free).unwrap_or(1);
        names.push(if n == 1 { format!("{stem}.csv") } else { format!("{stem}_{n}.csv") });
    }
    names
}

/// The two files of the body of an import: made again, or copied where they are a file of the user's.
fn body_files(asked: &str, body: &Body) -> Result<BodyFiles, InputError> {
    let is_shipped = asked == AUTO || PRESETS.iter().any(|(name, _)| *name == asked);
    if is_shipped {
        return generate(&body.name, body.size).map_err(|e| InputError::new(&body.name, e));
    }
    let urdf = Path::new(asked);
    Ok(BodyFiles { urdf: read_text(urdf)?, sheet: read_text(&urdf.with_extension("body.toml"))? })
}
