//! `ergopath batch`: a batch file, shards of one that are joined, or a list of scenarios.

use super::batch_file::{self, Pages, Shard};
use super::batch_slurm::SlurmArgs;
use super::{Failure, Outcome, batch_list};
use crate::batch::{Gate, is_batch};
use crate::files::{InputError, Outputs};
use std::path::{Path, PathBuf};

/// Arguments of `batch`.
#[derive(Debug, clap::Args)]
pub(super) struct BatchArgs {
    /// A batch file (TOML with schema "ergopath/batch/1"), or scenario files.
    #[arg(required_unless_present = "merge", value_name = "BATCH.toml|SCENARIO.toml")]
    pub(super) files: Vec<PathBuf>,
    /// Folder to write: of a batch file, `cells.csv`, `cells.parquet`, `columns.csv`, `batch.html` and a folder for each
    /// cell; of scenarios, a folder for each run, `comparison.csv` and `comparison.html`.
    #[arg(short, long, value_name = "DIR", required_unless_present = "merge")]
    output: Option<PathBuf>,
    /// Of scenarios: planners to run each with, separated by commas; without it, default.
    #[arg(long, value_delimiter = ',', value_name = "NAME|FILE,...")]
    pub(super) planner: Vec<String>,
    /// Of scenarios: seed of all randomness; without it each scenario's, else 0.
    #[arg(long)]
    pub(super) seed: Option<u64>,
    /// Number of threads; results do not depend on it.
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<usize>,
    /// Of a batch file: compute only every N-th cell from the I-th on; several processes may share a folder.
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Join the shards in a folder: its tables and page.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["files", "output", "shard", "retry_failed", "pages"])]
    merge: Option<PathBuf>,
    /// Of a batch file: run cells again that failed.
    #[arg(long)]
    retry_failed: bool,
    /// Of a batch file: cells that get everything that `plan` writes, among it their report.
    #[arg(long, value_enum, default_value_t = Pages::Best)]
    pages: Pages,
    /// Of a batch file: bounds that every cell has to keep, such as `p_rula_ge_5 < 0.1 and rula_peak <= 6`;
    /// `gate.xml`, a file for test servers, tells which do, and exit code 5 that not all do.
    #[arg(long, value_name = "BOUNDS")]
    gate: Option<String>,
    /// Of a batch file: compute the missing cells as jobs of this scheduler, and follow them.
    #[arg(long, value_enum, conflicts_with_all = ["merge", "shard"])]
    engine: Option<Engine>,
    #[command(flatten)]
    slurm: SlurmArgs,
}

/// Schedulers that a batch is given to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Engine {
    /// A job array, and a job that joins the cells.
    Slurm,
}

/// What is asked of a batch file besides the file itself.
#[derive(Debug)]
pub(super) struct Wanted<'a> {
    pub threads: Option<usize>,
    pub shard: Option<Shard>,
    pub retries: bool,
    pub pages: Pages,
    pub gate: Option<Gate>,
    /// The gate as it was written.
    pub bounds: Option<&'a str>,
    /// Cells are computed by jobs of Slurm.
    pub slurm: Option<&'a SlurmArgs>,
}

/// Runs a batch.
pub(super) fn batch(args: &BatchArgs, outputs: &Outputs) -> Result<Outcome, Failure> {
    let gate = args.gate.as_deref().map(Gate::parse).transpose()?;
    args.slurm.check()?;
    if let Some(folder) = &args.merge {
        return batch_file::merge(folder, gate.as_ref(), outputs);
    }
    let output = args.output.as_deref().unwrap_or(Path::new(""));
    let is_one = |p: &PathBuf| std::fs::read_to_string(p).is_ok_and(|text| is_batch(&text));
    let Some(file) = args.files.iter().find(|p| is_one(p)) else {
        let for_files = [
            (args.shard.is_some(), "--shard"),
            (args.retry_failed, "--retry-failed"),
            (gate.is_some(), "--gate"),
            (args.engine.is_some(), "--engine"),
        ];
        if let Some((_, option)) = for_files.iter().find(|(is_given, _)| *is_given) {
            return Err(InputError::new(option, "needs a batch file, and these are scenarios")
                .remedy("write a batch file with schema = \"ergopath/batch/1\" (docs/batches.md)")
                .into());
        }
        return batch_list::batch(args, output, outputs);
    };
    if args.files.len() > 1 {
        return Err(InputError::new(file, "is a batch file, and a call runs one of these alone")
            .remedy("name the scenarios in the batch file, or run each batch by itself")
            .into());
    }
    let of_lists = [
        (!args.planner.is_empty(), "--planner", "planners"),
        (args.seed.is_some(), "--seed", "seeds"),
    ];
    if let Some((_, option, key)) = of_lists.iter().find(|(is_given, ..)| *is_given) {
        return Err(InputError::new(option, "is for scenarios; a batch file says this itself")
            .remedy(format!("write {key} = [...] in the batch file"))
            .into());
    }
    let wanted = Wanted {
        threads: args.threads,
        shard: args.shard,
        retries: args.retry_failed,
        pages: args.pages,
        gate,
        bounds: args.gate.as_deref(),
        slurm: args.engine.map(|Engine::Slurm| &args.slurm),
    };
    batch_file::run(file, output, &wanted, outputs)
}
