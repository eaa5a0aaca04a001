//! `--engine slurm`: a batch as jobs of the cluster that is there, followed to their end.
//!
//! What is done stands in the folder of the batch, and what is queued Slurm is asked: nothing else is kept, so the
//! same command goes on wherever it was left.

use super::batch::Wanted;
use super::batch_file::{Batched, Pages, finish, finished};
use super::batch_slurm_print as print;
use super::plan::with_threads;
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::batch::{
    Bundles, CellPlan, Manifest, QUEUE_FORMAT, Queued, SlurmJobs, core_seconds, largest_index,
    submitted_job,
};
use crate::files::{InputError, Outputs};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// Indices of arrays where Slurm does not say: its default.
const MOST_SHARDS: usize = 1000;
/// Cells whose cost is estimated; the others are taken to be like them.
const SAMPLED: usize = 20;
/// Between two looks: a tenth of the time since the last change, within these bounds, s.
const LOOK_S: [f64; 2] = [0.5, 15.0];
/// Slept at a time, so that Ctrl-C is heard.
const NAP: Duration = Duration::from_millis(100);
/// Between two lines where nobody watches a terminal, s.
const LINE_S: f64 = 60.0;
/// `sbatch` options that are ours to set.
const OWN_OPTIONS: [&str; 10] = [
    "--array",
    "-a",
    "--dependency",
    "-d",
    "--job-name",
    "-J",
    "--chdir",
    "-D",
    "--wrap",
    "--output",
];

/// What `--engine slurm` may be told.
#[derive(Debug, clap::Args)]
pub(super) struct SlurmArgs {
    /// With `--engine slurm`: the partition, as for sbatch.
    #[arg(long, value_name = "NAME", requires = "engine")]
    partition: Option<String>,
    /// With `--engine slurm`: how long a task of the job array should take.
    #[arg(long, value_name = "MIN", default_value_t = 10.0, requires = "engine")]
    minutes_per_job: f64,
    /// With `--engine slurm`: how long a cell takes on one core; without it, an estimate.
    #[arg(long, value_name = "S", requires = "engine")]
    seconds_per_cell: Option<f64>,
    /// With `--engine slurm`: a further option of sbatch, such as --sbatch=--account=lab; may be repeated.
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true, requires = "engine")]
    sbatch: Vec<String>,
    /// With `--engine slurm`: write the scripts and submit nothing.
    #[arg(long, requires = "engine")]
    no_submit: bool,
}

impl SlurmArgs {
    /// Refuses what cannot be meant, before anything is read.
    pub(super) fn check(&self) -> Result<(), InputError> {
        let times = [
            ("--minutes-per-job", Some(self.minutes_per_job), 0.01, 1e5),
            ("--seconds-per-cell", self.seconds_per_cell, 1e-3, 1e7),
        ];
        for (option, value, low, high) in times {
            if let Some(value) = value.filter(|v| !(low..=high).contains(v)) {
                let message = format!("{value} is outside {low} to {high}");
                return Err(InputError::new(option, message));
            }
        }
        let given = self.sbatch.iter().chain(&self.partition);
        if let Some(odd) = given.clone().find(|o| o.chars().any(char::is_control)) {
            return Err(InputError::new("--sbatch", format!("{odd:?} is more than one line")));
        }
        for option in &self.sbatch {
            let name = option.split(['=', ' ']).next().unwrap_or_default();
            if !name.starts_with('-') {
                return Err(InputError::new("--sbatch", format!("`{option}` is no option"))
                    .remedy("write it as sbatch has it: --sbatch=--account=lab"));
            }
            if OWN_OPTIONS.contains(&name) {
                return Err(InputError::new("--sbatch", format!("`{name}` is set by ergopath"))
                    .remedy("leave it out; cores of a task are set by --threads"));
            }
        }
        Ok(())
    }
}

/// Submits what is missing, follows it to its end and joins the cells; `pending` are those that are missing.
pub(super) fn run(
    batched: &Batched,
    (pending, plan): (&[CellPlan], Manifest),
    (args, wanted): (&SlurmArgs, &Wanted),
    outputs: &Outputs,
) -> Result<Outcome, Failure> {
    let folder = batched.output;
    let whole = folder.canonicalize().map_err(|e| InputError::unwritable(folder, &e))?;
    let mut slurm =
        Slurm { name: SlurmJobs::name_of(&whole), folder: folder.to_owned(), followed: None };
    let watched = Watched::of(&plan, pending);
    if !args.no_submit {
        let queued = slurm.queued(false)?;
        slurm.followed = queued.iter().find(|q| q.shard.is_some()).map(|q| q.job);
        if let Some(job) = slurm.followed {
            print::already(job, &slurm.name);
        } else if !queued.is_empty() {
            // Only the job that joins is left, and it will find cells missing.
            slurm.follow(&Watched::default())?;
        }
    }
    if slurm.followed.is_none() {
        let missing: Vec<usize> = watched.cells.keys().copied().collect();
        let jobs = scripts(batched, &missing, (args, wanted), &slurm)?;
        let mut files = outputs.another();
        files.add_to_folder(folder, jobs.files())?;
        files.write()?;
        if args.no_submit {
            print::written(&jobs, folder, missing.len());
            return Ok(Outcome::Done);
        }
        let array = slurm.submit(&[SlurmJobs::CELLS])?;
        slurm.followed = Some(array);
        let after = format!("--dependency=afterany:{array}");
        let merge = slurm.submit(&[&after, SlurmJobs::MERGE]);
        print::submitted(
            &jobs,
            array,
            merge.as_ref().map_err(InputError::message),
            folder,
            missing.len(),
        );
    }
    slurm.follow(&watched)?;
    let missing = watched.missing(folder);
    if missing.is_empty() {
        return finish(&finished(plan, folder)?, folder, wanted.gate.as_ref(), outputs);
    }
    // What Slurm still remembers of the tasks.
    let known = slurm.queued(true).unwrap_or_default();
    Err(print::unfinished(&missing, &known, slurm.followed, folder).into())
}

/// The cells that jobs compute, by their places in the plan.
#[derive(Debug, Default)]
struct Watched {
    cells: BTreeMap<usize, PathBuf>,
}

impl Watched {
    fn of(plan: &Manifest, pending: &[CellPlan]) -> Self {
        let keys: BTreeMap<&str, usize> =
            plan.cells.iter().enumerate().rev().map(|(k, c)| (c.key.as_str(), k)).collect();
        let place = |c: &CellPlan| Some((*keys.get(c.key.as_str())?, c.record()));
        Self { cells: pending.iter().filter_map(place).collect() }
    }

    fn missing(&self, folder: &Path) -> Vec<usize> {
        // On a network file system a look into the folder is what makes new files of others seen.
        let _ = folder.join(Manifest::CELLS).read_dir();
        let all = self.cells.iter();
        all.filter(|(_, record)| !folder.join(record).is_file()).map(|(k, _)| *k).collect()
    }
}

/// How the missing cells are bundled, and what the scripts say.
fn scripts(
    batched: &Batched,
    missing: &[usize],
    (args, wanted): (&SlurmArgs, &Wanted),
    slurm: &Slurm,
) -> Result<SlurmJobs, Failure> {
    let seconds = match args.seconds_per_cell {
        Some(seconds) => seconds,
        None => estimate(batched, missing)?,
    };
    let threads = wanted.threads.unwrap_or(1);
    with_threads(wanted.threads, || ())?;
    let per_core = seconds / threads as f64;
    let wanted_shards = missing.len() as f64 * per_core / (60.0 * args.minutes_per_job);
    let most = if args.no_submit { MOST_SHARDS } else { slurm.most_shards() };
    let bundles = Bundles::of(missing, wanted_shards.ceil() as usize, most);
    let minutes = bundles.largest() as f64 * per_core / 60.0;
    let program = std::env::current_exe()
        .map_err(|e| InputError::fault("ergopath", format!("does not know its own place: {e}")))?;
    let text = |path: &Path| -> Result<String, InputError> {
        let whole = std::path::absolute(path).map_err(|e| InputError::unwritable(path, &e))?;
        let text = whole.to_str().filter(|t| !t.chars().any(char::is_control));
        text.map(str::to_owned).ok_or_else(|| {
            InputError::new(path, "has a name that no script can hold")
                .remedy("use a path of printable characters")
        })
    };
    let pages = match wanted.pages {
        Pages::All => "all",
        Pages::Failed => "failed",
        Pages::Best | Pages::None => "none",
    };
    let mut of_cells = vec!["--pages".to_owned(), pages.to_owned()];
    of_cells.extend(wanted.retries.then(|| "--retry-failed".to_owned()));
    let gate = wanted.bounds.iter().flat_map(|b| ["--gate".to_owned(), (*b).to_owned()]);
    Ok(SlurmJobs {
        name: slurm.name.clone(),
        title: batched.batch.name.clone(),
        program: text(&program)?,
        batch: text(batched.file)?,
        folder: text(batched.output)?,
        bundles,
        threads,
        minutes,
        partition: args.partition.clone(),
        options: args.sbatch.clone(),
        of_cells,
        of_merge: gate.collect(),
        has_best_pages: wanted.pages == Pages::Best,
    })
}

/// Mean seconds of a cell on one core, of some that are spread over the missing ones.
fn estimate(batched: &Batched, missing: &[usize]) -> Result<f64, Failure> {
    let sampled: Vec<&usize> =
        missing.iter().step_by(missing.len().div_ceil(SAMPLED).max(1)).collect();
    let mut sum = 0.0;
    for k in &sampled {
        sum += core_seconds(&batched.jobs.job(&batched.batch.cells[**k])?, batched.batch.mode);
    }
    Ok(sum / sampled.len().max(1) as f64)
}

/// The jobs for one folder.
struct Slurm {
    name: String,
    folder: PathBuf,
    /// The job array that is followed.
    followed: Option<u64>,
}

impl Slurm {
    /// Runs a command of Slurm in the folder of the batch and gives what it prints.
    fn ask(&self, program: &str, options: &[&str]) -> Result<String, InputError> {
        let mut command = Command::new(program);
        command.args(options).current_dir(&self.folder);
        // What the user has set for their own eyes would change the answer.
        for (name, _) in std::env::vars_os() {
            if name.to_string_lossy().starts_with("SQUEUE_") {
                command.env_remove(name);
            }
        }
        let missing = |e: std::io::Error| {
            let message = match e.kind() {
                std::io::ErrorKind::NotFound => "is not on this machine".to_owned(),
                _ => format!("could not be run: {e}"),
            };
            InputError::new(program, message).remedy(
                "run this on a machine from which you submit jobs to Slurm, or use --shard with another engine \
                 (docs/batches.md)",
            )
        };
        let output = command.output().map_err(missing)?;
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        let said =
            said.lines().map(str::trim).filter(|l| !l.is_empty()).collect::<Vec<_>>().join("; ");
        let message = format!("Slurm refused: {said}");
        Err(InputError::new(program, message).remedy(format!(
            "mend this (--partition and --sbatch go to sbatch as they are) and run the same command again; scripts: {}",
            self.folder.join(SlurmJobs::FOLDER).display()
        )))
    }

    fn submit(&self, options: &[&str]) -> Result<u64, InputError> {
        let printed = self.ask("sbatch", &[&["--parsable"], options].concat())?;
        submitted_job(&printed).ok_or_else(|| {
            InputError::fault("sbatch", format!("gave no number of a job: {}", printed.trim()))
        })
    }

    /// The jobs for this folder that wait or run, or all that Slurm remembers.
    fn queued(&self, all: bool) -> Result<Vec<Queued>, InputError> {
        let name = format!("--name={}", self.name);
        let format = format!("--format={QUEUE_FORMAT}");
        let mut options = vec!["--noheader", "--array", &name, &format];
        options.extend(all.then_some("--states=all"));
        Ok(Queued::parse(&self.ask("squeue", &options)?))
    }

    fn most_shards(&self) -> usize {
        let config = self.ask("scontrol", &["show", "config"]).ok();
        config.and_then(|c| largest_index(&c)).unwrap_or(MOST_SHARDS)
    }

    /// Waits until no job is left. A Slurm that does not answer for a while is asked again.
    fn follow(&self, watched: &Watched) -> Result<(), InputError> {
        let progress = Progress::with_time_left();
        let (mut changed, mut told, mut shown) = (Instant::now(), None::<Instant>, String::new());
        let (mut before, mut is_silent) = (usize::MAX, false);
        loop {
            let queued = match self.queued(false) {
                Ok(queued) if queued.is_empty() => return Ok(()),
                Ok(queued) => Some(queued),
                Err(_) if Progress::is_interrupted() => None,
                Err(e) => {
                    if !is_silent {
                        print::silent(&e);
                    }
                    None
                }
            };
            is_silent = queued.is_none();
            if Progress::is_interrupted() {
                return Err(print::left(&self.name));
            }
            let total = watched.cells.len();
            let done = total - watched.missing(&self.folder).len();
            if done != before {
                (before, changed) = (done, Instant::now());
            }
            if let Some(queued) = queued.filter(|_| total > 0) {
                let state = print::state(&queued);
                let is_due = told.is_none_or(|t| t.elapsed().as_secs_f64() > LINE_S);
                if !progress.tell_state(&state, done, total) && is_due && state != shown {
                    print::line(&state, done, total);
                    (told, shown) = (Some(Instant::now()), state);
                }
            }
            let wait = (0.1 * changed.elapsed().as_secs_f64()).clamp(LOOK_S[0], LOOK_S[1]);
            let until = Instant::now() + Duration::from_secs_f64(wait);
            while Instant::now() < until && !Progress::is_interrupted() {
                std::thread::sleep(NAP);
            }
        }
    }
}
