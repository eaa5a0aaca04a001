//! A batch file: its cells one by one, each written whole, then tables and page of all.

use super::batch::Wanted;
use super::batch_print::{junit, print, print_shard};
use super::batch_slurm;
use super::plan::{canonical, with_threads};
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::batch::{
    Batch, CellPlan, CellRecord, CellState, Finished, Gate, Jobs, Kept, Manifest, read_batch,
    tables,
};
use crate::files::{InputError, Outputs, sweep_killed};
use crate::planner::{self, PlanError, Request, RunResult, Step};
use crate::report;
use clap::ValueEnum;
use miette::Diagnostic as _;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Which cells get everything that `plan` writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Pages {
    /// All of them.
    All,
    /// Those without a path that may be used.
    Failed,
    /// Of each workstation the cell that scores lowest.
    Best,
    /// None.
    None,
}

/// A share of the cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shard {
    /// From 1.
    pub number: usize,
    pub of: usize,
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts =
            text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err("write I/N, such as 1/4 for the first of four"),
        }
    }
}

/// Name of the page of a cell in its folder.
const PAGE: &str = "report.html";

/// A batch file that was read, and the folder for it.
pub(super) struct Batched<'a> {
    pub file: &'a Path,
    pub batch: &'a Batch,
    pub jobs: &'a Jobs<'a>,
    pub output: &'a Path,
}

/// Runs the cells that have no result yet, then writes tables and page.
pub(super) fn run(
    file: &Path,
    output: &Path,
    wanted: &Wanted,
    outputs: &Outputs,
) -> Result<Outcome, Failure> {
    let batch = read_batch(file)?;
    let jobs = Jobs::of(&batch)?;
    let plan = Manifest::of(&batch, &jobs)?;
    outputs.expect_folder(output)?;
    keep_plan(&plan, output, outputs)?;
    sweep_killed(&output.join(Manifest::CELLS));
    let shard = wanted.shard.unwrap_or(Shard { number: 1, of: 1 });
    let own: Vec<&CellPlan> = plan
        .cells
        .iter()
        .enumerate()
        .filter(|(k, _)| k % shard.of + 1 == shard.number)
        .map(|(_, c)| c)
        .collect();
    let runner =
        Runner { batch: &batch, jobs: &jobs, output, outputs, stopped: AtomicBool::new(false) };
    let mut pending: Vec<(&CellPlan, bool)> = Vec::new();
    let mut seen = BTreeSet::new();
    for cell in own.iter().filter(|c| seen.insert(&c.key)) {
        if runner.is_pending(cell, wanted)? {
            pending.push((cell, wanted.pages == Pages::All));
        }
    }
    if let Some(args) = wanted.slurm.filter(|_| !pending.is_empty()) {
        let cells: Vec<CellPlan> = pending.iter().map(|(c, _)| (*c).clone()).collect();
        let batched = Batched { file, batch: &batch, jobs: &jobs, output };
        return batch_slurm::run(&batched, (&cells, plan), (args, wanted), outputs);
    }
    runner.run(&pending, wanted)?;
    if wanted.shard.is_some() {
        let mut failed = 0;
        for cell in &own {
            let record = CellRecord::read(&output.join(cell.folder()), &cell.key)?;
            failed += usize::from(record.is_some_and(|r| r.state == CellState::Failed));
        }
        print_shard(shard, own.len(), failed, output);
        return Ok(if failed > 0 { Outcome::SomeFailed } else { Outcome::Done });
    }
    let finished = finished(plan, output)?;
    if wanted.pages == Pages::Best {
        let best = best_of_stations(&finished);
        let cells: Vec<(&CellPlan, bool)> = best
            .iter()
            .map(|k| (&finished.plan.cells[*k], true))
            .filter(|(c, _)| !output.join(c.folder()).join(PAGE).is_file())
            .collect();
        runner.run(&cells, wanted)?;
    }
    finish(&finished, output, wanted.gate.as_ref(), outputs)
}

/// Joins shards.
pub(super) fn merge(
    folder: &Path,
    gate: Option<&Gate>,
    outputs: &Outputs,
) -> Result<Outcome, Failure> {
    let plan = Manifest::read(folder)?;
    finish(&finished(plan, folder)?, folder, gate, outputs)
}

/// The plan beside the cells, unless it is there already: shards write the same.
fn keep_plan(plan: &Manifest, output: &Path, outputs: &Outputs) -> Result<(), Failure> {
    let (name, bytes) = plan.file()?;
    if std::fs::read(output.join(&name)).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    let mut folder = outputs.another();
    folder.add_to_folder(output, [(name, bytes)])?;
    Ok(folder.write()?)
}

/// Cells by their numbers, the first of them.
pub(super) fn listed(cells: &[usize]) -> String {
    let first: Vec<String> = cells.iter().take(5).map(|k| (k + 1).to_string()).collect();
    let more = if cells.len() > first.len() { " ..." } else { "" };
    format!("{}{more}", first.join(", "))
}

pub(super) fn finished(plan: Manifest, folder: &Path) -> Result<Finished, Failure> {
    let count = plan.cells.len();
    plan.records(folder)?.map_err(|missing| {
        let (number, which) = (missing.len(), listed(&missing));
        let message = format!("{number} of {count} cells have no result yet: {which}");
        InputError::new(folder, message)
            .remedy("run the shards that are missing, or the batch without --shard")
            .into()
    })
}

/// Of each station the cell whose lead has the lowest expected RULA.
fn best_of_stations(finished: &Finished) -> Vec<usize> {
    let mut best: Vec<Option<(f64, usize)>> = vec![None; finished.plan.stations.len()];
    for (k, cell) in finished.plan.cells.iter().enumerate() {
        if let Some(rula) = finished.row(k).and_then(|r| r.number("rula_expected"))
            && best[cell.station].is_none_or(|(least, _)| rula < least)
        {
            best[cell.station] = Some((rula, k));
        }
    }
    best.into_iter().flatten().map(|(_, k)| k).collect()
}

/// Tables, page and gate.
pub(super) fn finish(
    finished: &Finished,
    folder: &Path,
    gate: Option<&Gate>,
    outputs: &Outputs,
) -> Result<Outcome, Failure> {
    let fault = |e: String| InputError::fault("batch", e);
    let mut files = tables(finished).map_err(|e| fault(e.to_string()))?;
    let has_page = |k: usize| folder.join(finished.plan.cells[k].folder()).join(PAGE).is_file();
    let pages: Vec<bool> = (0..finished.plan.cells.len()).map(has_page).collect();
    files.push(("batch.html".to_owned(), report::batch_page(finished, &pages).into_bytes()));
    let asked = gate.map(|g| g.ask(finished));
    if let Some(rows) = &asked {
        files.push(("gate.xml".to_owned(), junit(finished, rows).map_err(fault)?));
    }
    let mut all = outputs.another();
    all.add_to_folder(folder, files)?;
    all.write()?;
    print(finished, asked.as_deref(), folder);
    let count = |state: CellState| finished.records.iter().filter(|r| r.state == state).count();
    let is_broken = |rows: &Vec<crate::batch::GateRow>| {
        rows.iter().any(|r| r.broken.iter().any(|k| *k != Kept::Yes))
    };
    Ok(if asked.as_ref().is_some_and(is_broken) {
        Outcome::GateFailed
    } else if count(CellState::Failed) > 0 {
        Outcome::SomeFailed
    } else if count(CellState::NoFeasiblePath) == finished.records.len() {
        Outcome::NothingFeasible
    } else {
        Outcome::Done
    })
}

struct Runner<'a> {
    batch: &'a Batch,
    jobs: &'a Jobs<'a>,
    output: &'a Path,
    outputs: &'a Outputs,
    /// A cell could not be written: the others end too.
    stopped: AtomicBool,
}

impl Runner<'_> {
    /// Whether a cell has no result, or not the one that is wanted.
    fn is_pending(&self, cell: &CellPlan, wanted: &Wanted) -> Result<bool, Failure> {
        let folder = self.output.join(cell.folder());
        let Some(record) = CellRecord::read(&folder, &cell.key)? else { return Ok(true) };
        if record.state == CellState::Failed {
            return Ok(wanted.retries);
        }
        let wants_page = match wanted.pages {
            Pages::All => true,
            Pages::Failed => record.state != CellState::Ok,
            Pages::Best | Pages::None => false,
        };
        Ok(wants_page && !folder.join(PAGE).is_file())
    }

    /// Cells in order, each with whether it gets a page in any case. Each core has a cell of its own, so that as
    /// few as possible are under work at a time; where there are fewer cells than cores, they share these.
    fn run(&self, cells: &[(&CellPlan, bool)], wanted: &Wanted) -> Result<(), Failure> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = with_threads(wanted.threads, rayon::current_num_threads)?;
        let threads = if wanted.threads.is_some() { threads } else { cores };
        let workers = threads.min(cells.len());
        let progress = Progress::with_time_left();
        let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let work = || -> Result<(), Stop> {
            while let Some((cell, has_page)) = cells.get(next.fetch_add(1, Ordering::Relaxed)) {
                if let Err(stop) = self.one(cell, *has_page, wanted.pages) {
                    self.stopped.store(true, Ordering::Relaxed);
                    return Err(stop);
                }
                progress.tell("cells", done.fetch_add(1, Ordering::Relaxed) + 1, cells.len());
            }
            Ok(())
        };
        let outcomes: Vec<Result<(), Stop>> = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..workers)
                .map(|_| scope.spawn(|| with_threads(Some(threads / workers), work)?))
                .collect();
            let lost = |_| Err(InputError::fault("batch", "a thread of the program failed").into());
            workers.into_iter().map(|w| w.join().unwrap_or_else(lost)).collect()
        });
        let stops: Vec<Stop> = outcomes.into_iter().filter_map(Result::err).collect();
        if stops.is_empty() {
            return Ok(());
        }
        let failure = stops.into_iter().find_map(|stop| match stop {
            Stop::Failed(failure) => Some(failure),
            Stop::Interrupted => None,
        });
        Err(failure.unwrap_or_else(|| {
            InputError::new("batch", "interrupted; cells that were finished are kept")
                .remedy("run the same command again to go on")
                .into()
        }))
    }

    fn goes_on(&self) -> bool {
        !Progress::is_interrupted() && !self.stopped.load(Ordering::Relaxed)
    }

    fn one(&self, cell: &CellPlan, has_page: bool, pages: Pages) -> Result<(), Stop> {
        if !self.goes_on() {
            return Err(Stop::Interrupted);
        }
        let job = self.jobs.job(&cell.levels)?;
        let (scenario, seed) = (&job.scenario, job.scenario.seed);
        let command = canonical(self.batch.mode.verb(), scenario, &job.planner, seed);
        let request =
            Request { command, seed, preset: job.preset, keeps_rollouts: false, resume: None };
        let tell = |_: Step| self.goes_on();
        let planner = if self.batch.mode.is_assess() { planner::assess } else { planner::plan };
        // A fault of the program in one cell is a failure of that cell.
        let run = catch_unwind(AssertUnwindSafe(|| planner(scenario, &request, &tell)));
        let failed = |reason: String| -> (CellRecord, Option<RunResult>) {
            (CellRecord::failed(&cell.key, reason), None)
        };
        let (record, result) = match run {
            Ok(Ok(result)) => (CellRecord::of(&cell.key, scenario, &result), Some(result)),
            Ok(Err(PlanError::Interrupted(_))) => return Err(Stop::Interrupted),
            Ok(Err(PlanError::Input(e))) if e.is_fault() => return Err(e.into()),
            Ok(Err(PlanError::Input(e))) => failed(in_a_line(&e)),
            Err(_) => failed("the program failed in this cell; please report it".to_owned()),
        };
        let gets_page = has_page || (pages == Pages::Failed && record.state != CellState::Ok);
        let mut files = vec![record.file()?];
        if let Some(result) = result.filter(|_| gets_page) {
            let made =
                report::files(&result).map_err(|e| InputError::fault("report", e.to_string()))?;
            files.extend(made);
        }
        let mut outputs = self.outputs.another();
        outputs.folder(&self.output.join(cell.folder()), files)?;
        Ok(outputs.write()?)
    }
}

/// Why a worker ended before all cells were done.
enum Stop {
    /// What it was doing went wrong.
    Failed(Failure),
    /// A signal, or the failure of another.
    Interrupted,
}

impl<E: Into<Failure>> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::Failed(error.into())
    }
}

/// A refusal in one line.
fn in_a_line(error: &InputError) -> String {
    error.help().map_or_else(|| error.to_string(), |help| format!("{error} ({help})"))
}
