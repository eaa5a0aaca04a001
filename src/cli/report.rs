//! `ergopath report`: the page, figures and tables of a finished run made again from its result.

use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, read_bytes};
use crate::planner::{Freshness, freshness, read_result, result_file};
use crate::report;
use std::path::{Path, PathBuf};

/// Arguments of `report`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder of a finished run, or its result.json.
    result: PathBuf,
    /// Folder to write; without it the files are made again beside the result.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// The scenario to compare the run with; without it, one of the recorded name is looked for beside
    /// the result, in the folder above, in the working folder and in ./scenarios.
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Also write `one_page.html`: the decision on one sheet of A4, to print or to keep as PDF.
    #[arg(long)]
    one_page: bool,
    /// Print nothing but what is out of date.
    #[arg(short, long)]
    quiet: bool,
}

/// Makes the files again.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let result = read_result(&args.result)?;
    super::warn_of_unsealed(&result);
    let freshness = freshness(&result, &args.result, args.scenario.as_deref())?;
    let out_of_date = out_of_date(&freshness);
    let fault = |e: report::ReportError| InputError::fault("report", e.to_string());
    let mut files = report::files_again(&result, out_of_date.as_deref()).map_err(fault)?;
    if args.one_page {
        files.push(report::one_page(&result, out_of_date.as_deref()).map_err(fault)?);
    }
    let source = result_file(&args.result);
    let own = source.parent().unwrap_or(Path::new(""));
    let own = if own.as_os_str().is_empty() { Path::new(".") } else { own };
    let target = args.output.as_deref().unwrap_or(own);
    files.retain(|(name, _)| name != "result.json");
    if target.canonicalize().ok() == own.canonicalize().ok() {
        outputs.add_to_folder(target, files)?;
    } else {
        // The result is copied, not written anew.
        files.push(("result.json".to_owned(), read_bytes(&source)?));
        outputs.folder(target, files)?;
    }
    outputs.write()?;
    if let Some(what) = &out_of_date {
        complain!("out of date: {what}");
    }
    if !args.quiet {
        say!("{}", crate::words::verdict::headline(&result));
        say!("  {}", checked(&freshness));
        say!("\n{}", target.join("report.html").display());
    }
    Ok(Outcome::Done)
}

/// What has changed since a run, in a sentence.
pub(super) fn out_of_date(freshness: &Freshness) -> Option<String> {
    let Freshness::OutOfDate { changed, .. } = freshness else { return None };
    let names: Vec<String> = changed.iter().map(|c| format!("`{c}`")).collect();
    let have = if names.len() == 1 { "has" } else { "have" };
    Some(format!(
        "{} {have} changed since this run; the figures are those of the run as it was made",
        names.join(", ")
    ))
}

fn checked(freshness: &Freshness) -> String {
    match freshness {
        Freshness::Current(path) => format!(
            "up to date: {} and the files that it names are those of the run",
            path.display()
        ),
        Freshness::OutOfDate { scenario, .. } => {
            format!("out of date: compared with {}", scenario.display())
        }
        Freshness::NotFound(name) => format!(
            "not known whether it is up to date: {name} was not found; name it with --scenario FILE"
        ),
    }
}
