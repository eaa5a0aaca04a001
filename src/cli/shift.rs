//! `ergopath shift`: finished runs and scored motions as the tasks of one worker's shift.

use super::bars::{bad_share, table};
use super::{Failure, Outcome};
use crate::ergonomics::ScoringMethod;
use crate::files::{InputError, Outputs};
use crate::report::shift_files;
use crate::shift::{ShiftResult, read_shift};
use crate::words::number::percent;
use crate::words::shift as words;
use comfy_table::Cell;
use std::path::PathBuf;

/// Arguments of `shift`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Shift file (TOML): tasks with their results and their time, and breaks.
    shift: PathBuf,
    /// Folder to write shift.html, shift.json and shift.csv to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Print shift.json instead of the table.
    #[arg(long, conflicts_with = "quiet")]
    json: bool,
    /// Print nothing.
    #[arg(short, long)]
    quiet: bool,
}

/// Adds up the tasks.
pub(super) fn run(args: &Args, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let result = read_shift(&args.shift)?.assess(&args.shift)?;
    let fault = |e: crate::report::ReportError| InputError::fault("shift", e.to_string());
    let files = shift_files(&result).map_err(fault)?;
    let json = files.iter().find(|(name, _)| name == "shift.json").map(|(_, b)| b.clone());
    outputs.folder(&args.output, files)?;
    outputs.write()?;
    if args.json {
        let text = json.map(|b| String::from_utf8_lossy(&b).into_owned()).unwrap_or_default();
        say!("{}", text.trim_end());
    } else if !args.quiet {
        print(&result);
        say!("\n{}", args.output.join("shift.html").display());
    }
    Ok(Outcome::Done)
}

fn print(result: &ShiftResult) {
    let plain = |text: String| text.replace('\u{a0}', " ");
    say!("{}", plain(words::headline(result)));
    let Some(body) = words::worst_body(result) else { return };
    let lead = ScoringMethod::ALL[0];
    let spread = words::spread(&body.methods[lead].high, body.units);
    for line in [spread, words::most(result), words::whose(result)].into_iter().flatten() {
        say!("  {}", plain(line));
    }
    for caveat in words::caveats(result) {
        say!("[{caveat}]");
    }
    say!();
    let names = ScoringMethod::ALL.map(|m| format!("{} 3+", m.name()));
    let header = [
        "",
        "cycles",
        "time",
        "in movement",
        "of movement",
        "",
        &names[0],
        "90 % band",
        "part",
        &names[1],
        "90 % band",
    ];
    let mut shown = table(&header, &[1, 2, 3, 5, 6, 8, 9]);
    let band = |pair: Option<[f64; 2]>| pair.map_or_else(|| "not known".to_owned(), words::range);
    for (k, t) in result.tasks.iter().enumerate() {
        let [Some(first), Some(second)] = ScoringMethod::ALL.map(|m| body.methods[m].tasks.get(k))
        else {
            continue;
        };
        shown.add_row([
            Cell::new(&t.name),
            Cell::new(format!("{:.0}", t.cycles)),
            Cell::new(words::minutes(t.minutes)),
            Cell::new(words::minutes(t.moving_min)),
            bad_share(first.share_of_movement),
            Cell::new(percent(first.share_of_movement)),
            Cell::new(words::minutes(first.high.mean_min)),
            Cell::new(band(first.high.band90_min)),
            Cell::new(percent(first.share_of_high)),
            Cell::new(words::minutes(second.high.mean_min)),
            Cell::new(band(second.high.band90_min)),
        ]);
    }
    let time = &result.time;
    let rest = |name: &str, minutes: f64| {
        let mut row = vec![Cell::new(name), Cell::new(""), Cell::new(words::minutes(minutes))];
        row.push(Cell::new("not scored"));
        row
    };
    if time.other_min > 0.0 {
        shown.add_row(rest("other work", time.other_min));
    }
    if time.breaks_min > 0.0 {
        let mut row = rest("breaks", time.breaks_min);
        row.truncate(3);
        shown.add_row(row);
    }
    let [first, second] = ScoringMethod::ALL.map(|m| &body.methods[m].high);
    let share = first.mean_min / time.scored_min;
    shown.add_row([
        Cell::new("shift"),
        Cell::new(""),
        Cell::new(words::minutes(time.shift_min)),
        Cell::new(words::minutes(time.scored_min)),
        bad_share(share),
        Cell::new(percent(share)),
        Cell::new(words::minutes(first.mean_min)),
        Cell::new(band(first.band90_min)),
        Cell::new(""),
        Cell::new(words::minutes(second.mean_min)),
        Cell::new(band(second.band90_min)),
    ]);
    say!("{}", shown.trim_fmt());
    for (title, lines) in [
        ("Lifting", words::lifting(result)),
        ("Hand exertions (DUET)", words::exertion(result)),
        ("Assumed, or to mind", words::notes(result)),
    ] {
        if lines.is_empty() {
            continue;
        }
        say!("\n{title}");
        for line in lines {
            say!("  {}", plain(line));
        }
    }
}
