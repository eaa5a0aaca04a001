//! `ergopath watch`: on every save of a scenario, or of a file that it names, the cell is checked, drawn
//! and planned again, and the open page shows it.

use super::check_scenario::in_words;
use super::plan::{canonical, failure, with_threads};
use super::progress::Progress;
use super::watch_desk::Desk;
use super::watch_files::WatchedFiles;
use super::watch_server::serve;
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs, read_bytes, read_text, take_named_inputs};
use crate::planner::{PlanError, Request, Step, load_preset, look_at_cell, plan};
use crate::report::{self, WatchedCheck, cell_figure};
use crate::scenario::read_scenario;
use crate::words;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How often the files are looked at.
const EVERY: Duration = Duration::from_millis(100);

/// Arguments of `watch`.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct Args {
    /// Scenario file (TOML).
    scenario: PathBuf,
    /// Port of the page on this machine; where it is taken, the next free one. 0 is any free one.
    #[arg(long, value_name = "PORT", default_value_t = 7350)]
    port: u16,
    /// Planner: quick, default, careful, tail, `whole_body`, or a TOML file.
    #[arg(long, default_value = "quick", value_name = "NAME|FILE")]
    planner: String,
    /// Seed of all randomness; without it the scenario's, else 0.
    #[arg(long)]
    seed: Option<u64>,
    /// Number of threads; results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Also write the files of each finished run to this folder, as `plan` does; without it nothing is
    /// written.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// One look at what was saved: on a thread of its own, so that a newer save can end it.
struct Round {
    work: Option<JoinHandle<Result<(), Failure>>>,
    is_over: Arc<AtomicBool>,
}

/// Serves the page until a signal ends it.
pub(super) fn run(args: &Args, outputs: &Outputs) -> Result<Outcome, Failure> {
    // What is wrong with the call itself fails now; what is wrong in the scenario is shown in the page.
    read_bytes(&args.scenario)?;
    load_preset(&args.planner)?;
    with_threads(args.threads, || ())?;
    if let Some(folder) = &args.output {
        outputs.expect_folder(folder)?;
    }
    let name = args.scenario.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let desk = Arc::new(Desk::new(name));
    let mut files = WatchedFiles::default();
    files.add([args.scenario.clone()]);
    let port = serve(args.port, &desk)?;
    say!("http://127.0.0.1:{port}/");
    say!("Open this address in a browser on this machine. Ctrl-C ends it.");
    let mut round = Round::start(args, &desk, outputs);
    loop {
        thread::sleep(EVERY);
        files.add(desk.take_files());
        let is_saved = files.poll(Instant::now());
        if is_saved {
            desk.reading();
            round.end()?;
            files.add(desk.take_files());
            round = Round::start(args, &desk, outputs);
        } else if Progress::is_interrupted() {
            round.end()?;
            return Ok(Outcome::Interrupted);
        } else if round.is_done() {
            round.end()?;
        }
    }
}

impl Round {
    fn start(args: &Args, desk: &Arc<Desk>, outputs: &Outputs) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let (args, desk, outputs) = (args.clone(), Arc::clone(desk), outputs.another());
        let over = Arc::clone(&is_over);
        let work = thread::spawn(move || {
            let done = look(&args, &desk, outputs, &over);
            desk.note_files(take_named_inputs());
            if let Err(failure) = &done
                && !over.load(Ordering::Relaxed)
            {
                desk.failed(shown(&failure.0));
            }
            match done {
                // The page shows it and the next save may mend it.
                Err(failure) if !failure.0.is_fault() => {
                    complain!("{:?}", miette::Report::new(*failure.0));
                    Ok(())
                }
                other => other,
            }
        });
        Self { work: Some(work), is_over }
    }

    fn is_done(&self) -> bool {
        self.work.as_ref().is_some_and(JoinHandle::is_finished)
    }

    /// Ends the work where it still runs.
    fn end(&mut self) -> Result<(), Failure> {
        self.is_over.store(true, Ordering::Relaxed);
        let Some(work) = self.work.take() else { return Ok(()) };
        let fault = |_| InputError::fault("watch", "the planning broke down");
        work.join().map_err(fault)?
    }
}

/// Checks, draws and plans what is saved now. Once it is over, nothing more is shown or written.
fn look(args: &Args, desk: &Desk, mut outputs: Outputs, over: &AtomicBool) -> Result<(), Failure> {
    let is_over = || over.load(Ordering::Relaxed) || Progress::is_interrupted();
    desk.reading();
    let scenario = read_scenario(&args.scenario)?;
    let preset = load_preset(&args.planner)?;
    desk.note_files(take_named_inputs());
    let look = look_at_cell(&scenario)?;
    let explained = in_words(&scenario, &look, &read_text(&args.scenario)?);
    let fault = |e: report::ReportError| InputError::fault("report", e.to_string());
    let cell = cell_figure(&look).map_err(fault)?;
    if is_over() {
        return Ok(());
    }
    let check = WatchedCheck {
        says: explained.says,
        notes: explained.notes,
        warnings: explained.warnings,
        errors: explained.errors,
    };
    desk.checked(check, cell);
    let seed = args.seed.unwrap_or(scenario.seed);
    let command = canonical("plan", &scenario, &args.planner, seed);
    let request = Request { command, seed, preset, keeps_rollouts: false, resume: None };
    let tell = |step: Step| {
        desk.planning(&step);
        !is_over()
    };
    let result = match with_threads(args.threads, || plan(&scenario, &request, &tell))? {
        Err(PlanError::Interrupted(_)) => return Ok(()),
        other => other.map_err(failure)?,
    };
    let files = report::files(&result).map_err(fault)?;
    if is_over() {
        return Ok(());
    }
    let page = files.iter().find(|(name, _)| name == "report.html");
    desk.planned(page.map(|(_, bytes)| bytes.clone()).unwrap_or_default());
    say!("{}", words::verdict::headline(&result));
    if let Some(folder) = &args.output {
        outputs.folder(folder, files)?;
        outputs.write()?;
    }
    Ok(())
}

/// An error as on a terminal, with line and caret, without colours.
fn shown(error: &InputError) -> String {
    let theme = miette::GraphicalTheme::unicode_nocolor();
    let handler = miette::GraphicalReportHandler::new_themed(theme).with_width(100);
    let mut text = String::new();
    match handler.render_report(&mut text, error) {
        Ok(()) => text,
        Err(_) => error.to_string(),
    }
}
