//! What `--engine slurm` says.

use super::batch_file::listed;
use crate::batch::{Queued, SlurmJobs, reasons};
use crate::files::InputError;
use std::fmt::Write as _;
use std::path::Path;

/// Tasks whose last words are shown.
const MOST_SHOWN: usize = 5;

fn count(n: usize, one: &str) -> String {
    if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") }
}

/// The tasks in a line.
fn tasks(jobs: &SlurmJobs, cells: usize) -> String {
    let minutes = jobs.minutes;
    let long =
        if minutes < 1.0 { "under a minute".to_owned() } else { format!("about {minutes:.0} min") };
    format!(
        "{}, {} of {long} each on {}",
        count(cells, "cell"),
        count(jobs.bundles.missing.len(), "task"),
        count(jobs.threads, "core")
    )
}

/// The scripts stand in the folder, and nothing was submitted.
pub(super) fn written(jobs: &SlurmJobs, folder: &Path, cells: usize) {
    say!("{}: nothing was submitted", tasks(jobs, cells));
    say!("to submit, in {}:", folder.display());
    say!("  sbatch {}", SlurmJobs::CELLS);
    say!("  sbatch --dependency=afterany:JOB {}", SlurmJobs::MERGE);
}

/// Both jobs are queued; without the second, why not.
pub(super) fn submitted(
    jobs: &SlurmJobs,
    array: u64,
    merge: Result<&u64, &str>,
    folder: &Path,
    cells: usize,
) {
    say!("job array {array}: {}", tasks(jobs, cells));
    match merge {
        Ok(merge) => say!("job {merge}: joins the cells when all tasks have ended"),
        Err(why) => say!("the cells will be joined here, not by a job: {why}"),
    }
    say!("scripts and logs: {}", folder.join(SlurmJobs::FOLDER).display());
    how_to_leave(&jobs.name);
}

/// Jobs of an earlier call are in the queue.
pub(super) fn already(job: u64, name: &str) {
    say!("job array {job} for this folder is queued or running already: nothing is submitted");
    how_to_leave(name);
}

fn how_to_leave(name: &str) {
    say!("Ctrl-C stops following, not the jobs; to cancel them: scancel --name={name}");
}

/// How many tasks run and wait, and why they wait.
pub(super) fn state(queued: &[Queued]) -> String {
    let (running, waiting): (Vec<&Queued>, Vec<&Queued>) =
        queued.iter().filter(|q| q.shard.is_some()).partition(|q| q.is_running());
    if running.is_empty() && waiting.is_empty() {
        return "joining".to_owned();
    }
    let why = reasons(queued);
    let why = if why.is_empty() { String::new() } else { format!(" ({})", why.join(", ")) };
    format!("{} running, {} waiting{why}", count(running.len(), "task"), waiting.len())
}

/// Where it stands, for a file or a pipe.
pub(super) fn line(state: &str, done: usize, total: usize) {
    say!("{done} of {total} cells; {state}");
}

/// Slurm does not answer.
pub(super) fn silent(error: &InputError) {
    complain!("{error}; asked again until it answers");
}

/// The user stops following.
pub(super) fn left(name: &str) -> InputError {
    InputError::new("batch", "no longer followed; the jobs go on").remedy(format!(
        "run the same command again to follow them; to cancel them: scancel --name={name}"
    ))
}

/// All jobs have ended, and cells are missing.
pub(super) fn unfinished(
    missing: &[usize],
    known: &[Queued],
    array: Option<u64>,
    folder: &Path,
) -> InputError {
    let mut message = format!(
        "the jobs have ended, and {} no result: {}",
        if missing.len() == 1 {
            "1 cell has".to_owned()
        } else {
            format!("{} cells have", missing.len())
        },
        listed(missing)
    );
    let ended: Vec<&Queued> = known
        .iter()
        .filter(|q| Some(q.job) == array && q.shard.is_some() && !q.is_completed())
        .collect();
    let mut without_log = 0;
    for task in &ended {
        let log = folder.join(SlurmJobs::log(task.job, task.shard.unwrap_or_default()));
        without_log += usize::from(!log.exists());
    }
    for task in ended.iter().take(MOST_SHOWN) {
        let shard = task.shard.unwrap_or_default();
        let log = folder.join(SlurmJobs::log(task.job, shard));
        let text = std::fs::read(&log).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let last = text.lines().rev().map(str::trim).find(|l| !l.is_empty());
        let last = last.map_or(String::new(), |l| format!(": {l}"));
        let reason =
            if task.reason == "None" { String::new() } else { format!(", {}", task.reason) };
        let _ = write!(message, "\n  task {}_{shard} ({}{reason}){last}", task.job, task.state);
    }
    if ended.len() > MOST_SHOWN {
        let _ = write!(message, "\n  and {} more tasks", ended.len() - MOST_SHOWN);
    }
    let remedy = if !ended.is_empty() && without_log == ended.len() {
        format!(
            "no task has left a log in {}: nodes that do not see this folder are the usual cause (`srun ls -d` with \
             its path tells); write to a folder that all nodes share, not to /tmp or a disk of this machine",
            folder.join(SlurmJobs::FOLDER).display()
        )
    } else {
        format!(
            "mend the cause (logs: {}) and run the same command again: only what is missing is computed",
            folder.join(SlurmJobs::FOLDER).display()
        )
    };
    InputError::fault(folder, message).remedy(remedy)
}
