//! `ergopath compare`: finished runs side by side, with intervals that are paired where they may be.

use super::bars::{bad_share, table};
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, suggest};
use crate::planner::{read_result, result_file};
use crate::report::{self, ComparedRun, Comparison, NamedRun, RowState, RunDifference};
use crate::words::number::percent;
use comfy_table::Cell;
use std::path::{Path, PathBuf};

/// Arguments of `compare`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folders that `plan`, `assess` or `batch` have written, or their result.json.
    #[arg(required = true, value_name = "RESULT")]
    results: Vec<PathBuf>,
    /// Page to write (FILE.html, with FILE.csv beside it), or a folder for comparison.html and .csv.
    #[arg(short, long, value_name = "FILE.html|DIR")]
    output: PathBuf,
    /// Run that the others are compared with: its name in the table. Without it, the first.
    #[arg(long, value_name = "NAME")]
    against: Option<String>,
    /// Print the comparison as JSON instead of the table.
    #[arg(long, conflicts_with = "quiet")]
    json: bool,
    /// Print nothing.
    #[arg(short, long)]
    quiet: bool,
}

/// What is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shown {
    Table,
    Json,
    Nothing,
}

/// Compares finished runs; a folder of a batch stands for its runs.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let mut places = Vec::new();
    for place in &args.results {
        places.extend(runs_in(place)?);
    }
    let short: Vec<String> = places.iter().map(|p| name_of(p)).collect();
    let mut runs: Vec<NamedRun> = Vec::new();
    for (place, name) in places.iter().zip(&short) {
        // Two folders of one name are told apart by the way to them.
        let is_shared = short.iter().filter(|n| *n == name).count() > 1;
        let name = if is_shared { place.display().to_string() } else { name.clone() };
        if runs.iter().any(|(n, _)| *n == name) {
            let message = "is named twice";
            return Err(InputError::new(place, message).remedy("name every run once").into());
        }
        let result = read_result(place)?;
        super::warn_of_unsealed(&result);
        runs.push((name, Ok(result)));
    }
    if let Some(against) = &args.against
        && !runs.iter().any(|(n, _)| n == against)
    {
        let names: Vec<&str> = runs.iter().map(|(n, _)| n.as_str()).collect();
        let help = suggest(against, names.iter().copied())
            .unwrap_or_else(|| format!("the runs are: {}", names.join(", ")));
        let message = format!("there is no run `{against}`");
        return Err(InputError::new("--against", message).remedy(help).into());
    }
    let shown = match (args.json, args.quiet) {
        (true, _) => Shown::Json,
        (_, true) => Shown::Nothing,
        _ => Shown::Table,
    };
    let compared = compared(&runs, args.against.as_deref());
    let is_page = args.output.extension().is_some_and(|x| x.eq_ignore_ascii_case("html"));
    let html = if is_page { args.output.clone() } else { args.output.join("comparison.html") };
    for (ending, bytes) in pages(&compared, &runs)? {
        outputs.file(&html.with_extension(ending), bytes)?;
    }
    outputs.write()?;
    show(&compared, &html, shown)
}

/// The runs that a folder stands for: itself, or those below it.
fn runs_in(place: &Path) -> Result<Vec<PathBuf>, Failure> {
    if result_file(place).is_file() || !place.is_dir() {
        return Ok(vec![place.to_owned()]);
    }
    let io = |e: std::io::Error| InputError::new(place, format!("cannot be read: {e}"));
    let entries = place.read_dir().map_err(io)?;
    let mut runs: Vec<PathBuf> = entries
        .filter_map(|e| Some(e.ok()?.path()))
        .filter(|p| p.join("result.json").is_file())
        .collect();
    runs.sort();
    // Nothing in it: reading it says what is missing.
    Ok(if runs.is_empty() { vec![place.to_owned()] } else { runs })
}

fn name_of(place: &Path) -> String {
    let named =
        if place.ends_with("result.json") { place.parent().unwrap_or(place) } else { place };
    let absolute = std::path::absolute(named).unwrap_or_else(|_| named.to_owned());
    absolute.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The comparison; a wish for a run that cannot be compared with is answered with a warning.
pub(super) fn compared(runs: &[NamedRun], against: Option<&str>) -> Comparison {
    let compared = Comparison::of(runs, against);
    if let (Some(wanted), Some(used)) = (against, &compared.against)
        && wanted != used
    {
        complain!("warning: `{wanted}` has no feasible path; the runs are compared with `{used}`");
    }
    compared
}

/// Page and table, each by the ending of its name.
pub(super) fn pages(
    compared: &Comparison,
    runs: &[NamedRun],
) -> Result<Vec<(&'static str, Vec<u8>)>, InputError> {
    report::comparison(compared, runs).map_err(|e| InputError::fault("report", e.to_string()))
}

/// Prints what was written to `html` and beside it.
pub(super) fn show(compared: &Comparison, html: &Path, shown: Shown) -> Result<Outcome, Failure> {
    match shown {
        Shown::Table => {
            print(compared);
            say!("\n{}", html.display());
        }
        Shown::Json => {
            let text = serde_json::to_string_pretty(compared);
            say!("{}", text.map_err(|e| InputError::fault("comparison", e.to_string()))?);
        }
        Shown::Nothing => {}
    }
    let is = |state: fn(&RowState) -> bool| compared.runs.iter().any(|r| state(&r.state));
    Ok(if is(|s| matches!(s, RowState::Failed(_))) {
        Outcome::SomeFailed
    } else if is(|s| *s == RowState::Ok) {
        Outcome::Done
    } else {
        Outcome::NothingFeasible
    })
}

/// The runs, best first.
fn print(comparison: &Comparison) {
    let against = comparison.against.as_deref().unwrap_or("–");
    let held = format!("RULA against {against}");
    let mut table = table(
        &[
            "run",
            "best path",
            "body",
            "time at 3+",
            "",
            "RULA",
            "90 % band",
            &held,
            "",
            "out of reach",
        ],
        &[4, 5, 9],
    );
    for r in comparison.ranked() {
        let (Some(body), Some(best)) = (r.worst_body(), r.best()) else {
            let (state, _) = r.state_words();
            table.add_row([r.name.clone(), state.to_owned()]);
            continue;
        };
        let (difference, how) = in_words(body.against.as_ref());
        table.add_row([
            Cell::new(&r.name),
            Cell::new(&best.id),
            Cell::new(&body.body),
            bad_share(best.exposure_rula_5[0]),
            Cell::new(percent(best.exposure_rula_5[0])),
            Cell::new(format!("{:.2}", best.expected_rula)),
            Cell::new(format!("{:.2} to {:.2}", best.p05_rula, best.p95_rula)),
            Cell::new(difference),
            Cell::new(how),
            Cell::new(percent(best.reach_exceeded)),
        ]);
    }
    say!("{}", table.trim_fmt());
    for note in notes(comparison) {
        say!("  {note}");
    }
}

fn in_words(difference: Option<&RunDifference>) -> (String, String) {
    let Some(d) = difference else { return ("–".to_owned(), String::new()) };
    let clear = if d.clear { "" } else { " (not clear)" };
    let how = match &d.unpaired_because {
        None => format!("paired, {} repetitions", d.repetitions[0]),
        Some(why) => format!("unpaired: {why}"),
    };
    (format!("{:+.2}, {:+.2} to {:+.2}{clear}", d.mean, d.low95, d.high95), how)
}

/// What the table cannot say: reasons, and tasks that are not alike.
fn notes(comparison: &Comparison) -> Vec<String> {
    let reference = comparison.runs.iter().find(|r| Some(&r.name) == comparison.against.as_ref());
    let differs = |r: &ComparedRun| {
        reference.is_some_and(|o| o.load_kg != r.load_kg || o.duration_s != r.duration_s)
    };
    let of = |r: &ComparedRun| match r.state_words() {
        (_, reason) if r.state != RowState::Ok => Some(format!("{}: {reason}", r.name)),
        _ if differs(r) => Some(format!(
            "{}: another load or duration than {}, so not like for like",
            r.name,
            comparison.against.as_deref().unwrap_or_default()
        )),
        _ => None,
    };
    comparison.runs.iter().filter_map(of).collect()
}
