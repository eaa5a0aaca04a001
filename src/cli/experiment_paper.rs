//! `ergopath experiment exp1|exp2|exp3`: the paper's experiments with people, simulated or recorded.

use super::experiment::interrupted;
use super::experiment_paper_print::print;
use super::progress::Progress;
use super::{Failure, Outcome};
use crate::ergobench;
use crate::files::{InputError, Outputs};
use crate::posture::Method;
use crate::report::paper_files;
use crate::training::paper::{
    Chain, PaperExperiment, PaperQuestion, PaperResult, TrainingSet, performers, run_paper,
    training_sets,
};
use crate::training::people::read_people_file;
use crate::training::{TrainSettings, remarks_of};
use std::path::PathBuf;

/// Arguments of `experiment exp1`, `exp2` and `exp3`.
#[derive(Debug, clap::Args)]
pub(super) struct PaperArgs {
    /// Recorded people in place of simulated ones: a TOML file with a [[person]] for each. Recordings whose
    /// names differ only in numbers, and by the person's name, are repetitions of one task.
    #[arg(long, value_name = "PEOPLE.toml")]
    recordings: Option<PathBuf>,
    /// Number of simulated people; their kinds and bodies change from one to the next.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=100), conflicts_with = "recordings")]
    operators: u64,
    /// What of the body is predicted: arm (from a pelvis that rests to the hand, as in the paper) or whole
    /// (the pelvis over its feet besides); by default both where the legs are known.
    #[arg(long, value_name = "arm|whole", value_parser = parse_chain)]
    chain: Option<Chain>,
    /// Methods, separated by commas: all, or some of those of `evaluate`.
    #[arg(long, value_delimiter = ',', default_value = "all", value_name = "NAME,...")]
    methods: Vec<String>,
    /// Methods of which bands of repetitions are judged, which costs most; none for no method.
    #[arg(long, value_delimiter = ',', default_value = "mi-nsgp,full-w", value_name = "NAME,...")]
    bands: Vec<String>,
    /// Seed of people, repetitions and searches.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Folder to write: tables (CSV), figures (PNG) and everything (JSON).
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

fn parse_chain(text: &str) -> Result<Chain, String> {
    let found = Chain::ALL.into_iter().find(|c| c.name() == text);
    found.ok_or_else(|| "use arm or whole".to_owned())
}

/// Runs one of the paper's experiments.
pub(super) fn paper(
    experiment: PaperExperiment,
    args: &PaperArgs,
    mut outputs: Outputs,
) -> Result<Outcome, Failure> {
    let question = question(experiment, args)?;
    // A folder that cannot be written must not cost minutes.
    args.output.as_deref().map_or(Ok(()), |folder| outputs.expect_folder(folder))?;
    let sets = sets(experiment, args)?;
    let progress = Progress::new();
    let told = |done: usize, total: usize| progress.tell("learning and judging", done, total);
    let settings = TrainSettings { seed: args.seed, ..TrainSettings::default() };
    let result = run_paper(&sets, &question, &settings, &told)?
        .ok_or_else(|| interrupted("nothing was written"))?;
    drop(progress);
    if args.json {
        say!("{}", as_json(&result)?);
    } else {
        print(&result);
    }
    if let Some(folder) = &args.output {
        let files = paper_files(&result);
        outputs.folder(folder, files.map_err(|e| InputError::fault("report", e.to_string()))?)?;
        outputs.write()?;
        if !args.json {
            say!("\nWrote {}", folder.display());
        }
    }
    Ok(Outcome::Done)
}

fn as_json(result: &PaperResult) -> Result<String, InputError> {
    serde_json::to_string(result).map_err(|e| InputError::fault("experiment", e.to_string()))
}

fn question(experiment: PaperExperiment, args: &PaperArgs) -> Result<PaperQuestion, InputError> {
    let methods = super::evaluate::methods(&args.methods)?;
    let methods =
        if args.methods.iter().any(|m| m == "all") { Method::ALL.to_vec() } else { methods };
    let banded =
        if args.bands == ["none"] { Vec::new() } else { super::evaluate::methods(&args.bands)? };
    Ok(PaperQuestion {
        experiment,
        simulated: args.recordings.is_none(),
        by_others: experiment == PaperExperiment::Exp3 && args.recordings.is_some(),
        chains: args.chain.map_or_else(|| Chain::ALL.to_vec(), |c| vec![c]),
        methods,
        banded,
    })
}

/// The training sets; what should be known of recordings goes to the error output.
fn sets(experiment: PaperExperiment, args: &PaperArgs) -> Result<Vec<TrainingSet>, InputError> {
    let Some(path) = &args.recordings else {
        let people = ergobench::performers(experiment, args.operators as usize, args.seed)?;
        return training_sets(experiment, &people, false);
    };
    let (people, sources) = performers(&read_people_file(path)?)?;
    for remark in remarks_of(&sources) {
        complain!("warning: {remark}");
    }
    training_sets(experiment, &people, true)
}
