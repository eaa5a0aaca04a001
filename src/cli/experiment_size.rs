//! `ergopath experiment size`: cost and quality over the number of frames, on a simulated operator.

use super::experiment::interrupted;
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::files::{InputError, Outputs};
use crate::human::Body;
use crate::report;
use crate::training::{SizeExperiment, SizeQuestion, SizeRow, TrainSettings, size_experiment};
use comfy_table::{CellAlignment, Table, presets};
use std::path::{Path, PathBuf};

/// Arguments of `experiment size`.
#[derive(Debug, clap::Args)]
pub(super) struct SizeArgs {
    /// Numbers of frames that train, separated by commas.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "N,...",
        default_value = "250,500,1000,2000,4000,8000,16000,32000,100000"
    )]
    counts: Vec<usize>,
    /// Body of the simulated operator: a shipped one by name, or a URDF made by `ergopath body`.
    #[arg(long, default_value = "female_p50")]
    body: String,
    /// Most frames behind an exact process; beyond, inducing centres.
    #[arg(long, value_name = "N", default_value_t = TrainSettings::default().exact_samples)]
    exact_samples: usize,
    /// Number of inducing centres; by default the number that held-out movements ask for.
    #[arg(long, value_name = "M")]
    inducing: Option<usize>,
    /// Seed of the movements.
    #[arg(long, default_value_t = SizeQuestion::default().seed)]
    seed: u64,
    /// Folder to write: size.png, size.csv and size.json.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

/// Trains on more and more frames, prints, and writes.
pub(super) fn size(args: &SizeArgs, mut outputs: Outputs) -> Result<Outcome, Failure> {
    let body = Body::load(&args.body, Path::new("."))?;
    // A folder that cannot be written must not cost minutes.
    args.output.as_deref().map_or(Ok(()), |folder| outputs.expect_folder(folder))?;
    let question =
        SizeQuestion { counts: args.counts.clone(), seed: args.seed, ..SizeQuestion::default() };
    let settings = TrainSettings {
        exact_samples: args.exact_samples,
        inducing: args.inducing,
        seed: args.seed,
        ..TrainSettings::default()
    };
    let progress = Progress::new();
    let told = |stage: &'static str, done: usize, total: usize| progress.tell(stage, done, total);
    let result = size_experiment(&body, &question, &settings, &told)?
        .ok_or_else(|| interrupted("nothing was written"))?;
    if args.json {
        let text = serde_json::to_string_pretty(&result)
            .map_err(|e| InputError::fault("size.json", e.to_string()))?;
        say!("{text}");
    } else {
        print(&result);
    }
    if let Some(folder) = &args.output {
        let files = report::size_files(&result);
        outputs.folder(folder, files.map_err(|e| InputError::fault("report", e.to_string()))?)?;
        outputs.write()?;
        if !args.json {
            say!("\n{}", folder.join("size.png").display());
        }
    }
    Ok(Outcome::Done)
}

fn print(result: &SizeExperiment) {
    say!(
        "Simulated operator in {}: made-up reaches, nobody was recorded. Seed {}.\nJudged on {} \
         frames ({} reaches) at {:.0} Hz that no law has seen.\n",
        result.body,
        result.seed,
        result.test_frames,
        result.test_reaches,
        result.rate_hz
    );
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.set_header([
        "N",
        "method",
        "process",
        "training",
        "per row",
        "LL qdot",
        "relative RMSE",
        "peak memory",
    ]);
    for column in [0, 3, 4, 5, 6, 7] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    for row in &result.rows {
        table.add_row(cells(row));
    }
    say!("{}", table.trim_fmt());
    say!(
        "  N: frames that train, each of which a process learns from. Process: exact up to {} frames, \
         beyond on inducing\n  centres, as many as held-out movements ask for. Training: weights, \
         kernel, process and noise. LL: mean\n  log-likelihood, nats per row; S_x = ({} m/s, rad/s)^2. \
         Memory: of the whole program during that training.",
        result.exact_samples,
        result.task_sd
    );
}

fn cells(row: &SizeRow) -> [String; 8] {
    [
        row.samples.to_string(),
        row.method.to_owned(),
        match row.centres {
            None => "none".to_owned(),
            Some(0) => "exact".to_owned(),
            Some(centres) => format!("{centres} centres"),
        },
        format!("{:.2} s", row.train_s),
        format!("{:.0} us", 1e6 * row.predict_s),
        format!("{:.2}", row.ll_q),
        format!("{:.4}", row.relative_rmse_q),
        row.peak_mib.map_or_else(String::new, |m| format!("{m:.0} MiB")),
    ]
}
