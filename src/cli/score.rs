//! `ergopath score`: RULA and REBA of worksheets, of recorded motions and of sampled postures.

use super::{Failure, Outcome};
use crate::ergonomics::Profile;
use crate::files::{read_bytes, suggest, write_whole};
use crate::scoring::score_table;
use std::path::{Path, PathBuf};

/// Arguments of `score`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// A CSV table of worksheets, a row for each posture and side: scores every row.
    #[arg(long, value_name = "IN.csv", required = true)]
    worksheet: Option<PathBuf>,
    /// File to write; `-` or nothing prints the table.
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    /// Convention of scoring: vignais2017, paper_strict, cornell2001 or reference.
    #[arg(long, value_parser = parse_profile, default_value = "vignais2017", value_name = "NAME")]
    profile: Profile,
}

fn parse_profile(text: &str) -> Result<Profile, String> {
    let names = Profile::names();
    Profile::by_name(text).ok_or_else(|| {
        suggest(text, names).unwrap_or_else(|| format!("known are: {}", names.join(", ")))
    })
}

/// Scores and writes or prints.
pub(super) fn run(args: &Args) -> Result<Outcome, Failure> {
    if let Some(table) = &args.worksheet {
        return worksheet(table, args);
    }
    Ok(Outcome::Done)
}

/// The output, unless it is standard output.
fn file(output: Option<&PathBuf>) -> Option<&Path> {
    output.map(PathBuf::as_path).filter(|p| *p != Path::new("-"))
}

fn worksheet(table: &Path, args: &Args) -> Result<Outcome, Failure> {
    let scored = score_table(table, &read_bytes(table)?, &args.profile)?;
    match file(args.output.as_ref()) {
        Some(path) => {
            write_whole(path, &scored.csv)?;
            let name = args.profile.name;
            say!("{}: {} rows scored, profile {name}", path.display(), scored.rows);
        }
        None => {
            // A reader that has gone (`| head`) is no reason to fail.
            let _ = std::io::Write::write_all(&mut std::io::stdout(), &scored.csv);
        }
    }
    Ok(Outcome::Done)
}
