//! `ergopath evaluate`: how well each method predicts held-out rows of a data file or a recording.

use super::evaluate_print::{as_json, print_text};
use super::progress::Progress;
use super::train::{parse_pelvis, parse_side};
use super::{Failure, Outcome};
use crate::files::{InputError, suggest};
use crate::human::{Body, Pelvis, Side};
use crate::kinematics::{Linkage, read_urdf};
use crate::posture::{Hold, Method, Sampling};
use crate::recording::read_map;
use crate::training::{
    DataFile, Dataset, Evaluation, Fold, Judging, Lengths, MethodScore, Objective, Optimiser,
    PullRule, Source, TrainSettings, Trial, Whom, evaluate, read_data, read_source, remarks_of,
};
use std::path::{Path, PathBuf};

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
#[allow(clippy::struct_excessive_bools, reason = "flags of a command line")]
pub(super) struct Args {
    /// Data files (CSV with columns q0.., xdot0.., qdot0.., train, traj; SI and radians) with --chain; or
    /// recordings with --body.
    #[arg(required = true, value_name = "DATA")]
    data: Vec<PathBuf>,
    /// Chain of the data files: a URDF, base link and tip link.
    #[arg(long, value_name = "FILE:BASE:TIP", required_unless_present = "body")]
    chain: Option<String>,
    /// Body of the person in recordings: a shipped one by name, or a URDF made by `ergopath body`.
    #[arg(long, conflicts_with = "chain")]
    body: Option<String>,
    /// Which person of a folder with several.
    #[arg(long, requires = "body")]
    person: Option<String>,
    /// What makes the markers of C3D and TRC files, or the points of tables, the segments of a person.
    #[arg(long, value_name = "MAP.toml", requires = "body")]
    map: Option<PathBuf>,
    /// The hand that holds on to the robot.
    #[arg(long, value_parser = parse_side, default_value = "right", value_name = "right|left")]
    side: Side,
    /// Whether the pelvis of recordings rests, as in the paper, or moves over feet that must be recorded.
    #[arg(long, value_parser = parse_pelvis, default_value = "rests", value_name = "moves|rests")]
    pelvis: Pelvis,
    /// Task of the chain: planar (2 rows), position (3) or pose (6); by default by the xdot columns.
    #[arg(long, value_parser = parse_task, value_name = "planar|position|pose")]
    task: Option<Hold>,
    /// Methods, separated by commas: all, or some of mi-nsgp, gp, w-ik, nsgp, sb-m, promp, full-w,
    /// full-w-gp, plain-ik.
    #[arg(long, value_delimiter = ',', default_value = "all", value_name = "NAME,...")]
    methods: Vec<String>,
    /// Standard deviation of the task velocity, m/s and rad/s; by default from the training rows.
    #[arg(long, value_name = "SD")]
    task_noise: Option<f64>,
    /// Which rows are held out: train-column, trials, blocks:N or time:SHARE. By default the train
    /// column where there is one, else trials, else blocks:5. With trials all files are one person's;
    /// otherwise each file is a problem of its own.
    #[arg(long, value_name = "SPLIT")]
    split: Option<Split>,
    /// Also walk along held-out paths: joint error, drift over round trips, coverage of the bands.
    #[arg(long)]
    rollout: bool,
    /// What the search for weights maximises: marginal, leave-one-out, leave-trial-out or in-sample; by
    /// default leave-trial-out where at least three movements train, else marginal.
    #[arg(long, value_parser = parse_objective)]
    objective: Option<Objective>,
    /// How it searches: lbfgs or bipop-cma-es.
    #[arg(long, value_parser = parse_optimiser, default_value = "lbfgs")]
    optimiser: Optimiser,
    /// One length-scale for all inputs of the kernel, as in the paper, instead of one for postures and
    /// one for velocities.
    #[arg(long)]
    isotropic: bool,
    /// Kernel parameters for each joint of its own.
    #[arg(long)]
    separate_kernels: bool,
    /// Smallest noise ratio of a process.
    #[arg(long, value_name = "RATIO", default_value_t = TrainSettings::default().noise_ratio_floor)]
    noise_ratio_floor: f64,
    /// Most rows behind an exact process; beyond, inducing centres.
    #[arg(long, value_name = "N", default_value_t = TrainSettings::default().exact_samples)]
    exact_samples: usize,
    /// Number of inducing centres; by default the number that held-out blocks ask for.
    #[arg(long, value_name = "M")]
    inducing: Option<usize>,
    /// How repetitions are pulled towards their own postures: by the hand's travel (per-metre, the
    /// default with --body), by time (per-second, the default with --chain and --independent), or not
    /// at all (none). Joint errors are shown for all three.
    #[arg(long, value_parser = parse_pull, value_name = "RULE")]
    pull: Option<PullRule>,
    /// Draw repetitions as published: a fresh joint velocity at each sample, not calibrated.
    #[arg(long)]
    independent: bool,
    /// Rows per second of files without `time_s`; by default found from q and qdot.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Seed of everything random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
}

/// A way to hold rows out.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Split {
    TrainColumn,
    Trials,
    Blocks(usize),
    Time(f64),
}

impl std::str::FromStr for Split {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let help = || "use train-column, trials, blocks:5 or time:0.6".to_owned();
        match text.split_once(':') {
            None if text == "train-column" => Ok(Self::TrainColumn),
            None if text == "trials" => Ok(Self::Trials),
            None if text == "blocks" => Ok(Self::Blocks(5)),
            Some(("blocks", n)) => match n.parse() {
                Ok(n) if (2..=100).contains(&n) => Ok(Self::Blocks(n)),
                _ => Err("blocks:N needs a whole number from 2 to 100".to_owned()),
            },
            Some(("time", share)) => {
                match share.parse() {
                    Ok(share) if share > 0.0 && share < 1.0 => Ok(Self::Time(share)),
                    _ => Err("time:SHARE needs a number between 0 and 1, for example time:0.6"
                        .to_owned()),
                }
            }
            _ => Err(suggest(text, ["train-column", "trials", "blocks:5", "time:0.6"])
                .unwrap_or_else(help)),
        }
    }
}

fn parse_task(text: &str) -> Result<Hold, String> {
    match text {
        "planar" => Ok(Hold::Planar),
        "position" => Ok(Hold::Point),
        "pose" => Ok(Hold::Rigid),
        _ => Err("use planar, position or pose".to_owned()),
    }
}

fn by_name<T: Copy>(text: &str, all: &[T], name: fn(T) -> &'static str) -> Result<T, String> {
    let names: Vec<&str> = all.iter().map(|t| name(*t)).collect();
    all.iter().copied().find(|t| name(*t) == text).ok_or_else(|| {
        suggest(text, names.iter().copied())
            .unwrap_or_else(|| format!("known are: {}", names.join(", ")))
    })
}

pub(super) fn parse_objective(text: &str) -> Result<Objective, String> {
    by_name(text, &Objective::ALL, Objective::name)
}

pub(super) fn parse_pull(text: &str) -> Result<PullRule, String> {
    by_name(text, &PullRule::ALL, PullRule::name)
}

pub(super) fn parse_optimiser(text: &str) -> Result<Optimiser, String> {
    by_name(text, &Optimiser::ALL, Optimiser::name)
}

fn methods(names: &[String]) -> Result<Vec<Method>, InputError> {
    if names.iter().any(|n| n == "all") {
        return Ok(Method::EIGHT.to_vec());
    }
    let one = |n: &String| by_name(n, &Method::ALL, Method::name);
    names
        .iter()
        .map(|n| {
            one(n).map_err(|help| {
                InputError::new("--methods", format!("there is no method `{n}`")).remedy(help)
            })
        })
        .collect()
}

/// One data set with the splits on which it is judged.
pub(super) struct Problem {
    pub name: String,
    pub dataset: Dataset,
    folds: Vec<Fold>,
    pub split: String,
    pub step: Option<(f64, &'static str)>,
}

/// Judges and prints.
pub(super) fn run(args: &Args) -> Result<Outcome, Failure> {
    let settings = settings(args)?;
    let judging = Judging {
        methods: methods(&args.methods)?,
        task_sd: args.task_noise,
        has_rollouts: args.rollout,
    };
    let problems = problems(args)?;
    let progress = Progress::new();
    let mut judged: Vec<Evaluation> = Vec::new();
    let total = problems.len() * judging.methods.len();
    for problem in &problems {
        // Method by method, so that progress shows and Ctrl-C is heard.
        let mut whole: Option<Evaluation> = None;
        for method in &judging.methods {
            let done = judged.len() * judging.methods.len()
                + whole.as_ref().map_or(0, |w| w.methods.len());
            if !progress.tell("judging methods", done, total) {
                return Err(
                    InputError::new("evaluate", "was interrupted; nothing is printed").into()
                );
            }
            let own = Judging { methods: vec![*method], ..judging.clone() };
            let found = evaluate(&problem.dataset, &problem.folds, &own, &settings)?;
            match &mut whole {
                None => whole = Some(found),
                Some(whole) => whole.methods.extend(found.methods),
            }
        }
        judged.extend(whole);
    }
    progress.tell("judging methods", total, total);
    let merged = merged(&judged);
    if args.json {
        say!("{}", as_json(&problems, &judged, &merged));
    } else {
        print_text(&problems, &judged, &merged, args.rollout);
    }
    Ok(Outcome::Done)
}

fn settings(args: &Args) -> Result<TrainSettings, InputError> {
    if args.task_noise.is_some_and(|sd| !(sd.is_finite() && sd > 0.0)) {
        return Err(InputError::new("--task-noise", "is not a positive number")
            .remedy("give a standard deviation in m/s (and rad/s), for example 0.001"));
    }
    if args.rate.is_some_and(|r| !(r.is_finite() && r > 0.0)) {
        return Err(InputError::new("--rate", "is not a positive number").remedy("give Hz"));
    }
    let settings = TrainSettings {
        objective: args.objective,
        optimiser: args.optimiser,
        lengths: if args.isotropic { Lengths::Isotropic } else { Lengths::Groups },
        separate_kernels: args.separate_kernels,
        noise_ratio_floor: args.noise_ratio_floor,
        exact_samples: args.exact_samples,
        inducing: args.inducing,
        pull: args.pull,
        sampling: if args.independent { Sampling::Independent } else { Sampling::Pathwise },
        seed: args.seed,
        ..TrainSettings::default()
    };
    settings.check()?;
    Ok(settings)
}

fn problems(args: &Args) -> Result<Vec<Problem>, InputError> {
    if let Some(body) = &args.body {
        return recorded(args, &Body::load(body, Path::new("."))?);
    }
    let chain = chain(args.chain.as_deref().unwrap_or_default())?;
    let files: Result<Vec<DataFile>, InputError> =
        args.data.iter().map(|path| read_data(path, &chain, args.task, args.rate)).collect();
    let files = files?;
    for file in &files {
        for warning in &file.warnings {
            complain!("warning: {}: {warning}", file.source);
        }
    }
    let several = files.len() > 1 || files.iter().any(|f| f.dataset.trials > 1);
    let split = args.split.unwrap_or_else(|| {
        if files.iter().all(|f| f.train_column.is_some()) {
            Split::TrainColumn
        } else if several {
            Split::Trials
        } else {
            Split::Blocks(5)
        }
    });
    if split == Split::Trials {
        let step = files.first().map(|f| f.step_s);
        let name = files.iter().map(|f| f.source.clone()).collect::<Vec<_>>().join(", ");
        let parts: Vec<Dataset> = files.into_iter().map(|f| f.dataset).collect();
        return Ok(vec![problem(name, Dataset::joined(parts)?, split, None, step)?]);
    }
    files
        .into_iter()
        .map(|f| problem(f.source, f.dataset, split, f.train_column, Some(f.step_s)))
        .collect()
}

/// Recordings of a person: trials of one data set, or a problem each.
fn recorded(args: &Args, body: &Body) -> Result<Vec<Problem>, InputError> {
    let map = args.map.as_deref().map(read_map).transpose()?;
    let whom = Whom {
        person: args.person.as_deref(),
        side: args.side,
        body,
        pelvis: Some(args.pelvis),
        map: map.as_ref(),
    };
    let sources: Result<Vec<Source>, InputError> =
        args.data.iter().map(|path| read_source(path, &whom)).collect();
    let sources = sources?;
    for remark in remarks_of(&sources) {
        complain!("warning: {remark}");
    }
    let sources: Vec<(String, Vec<Trial>)> =
        sources.into_iter().map(|s| (s.name, s.trials)).collect();
    let count: usize = sources.iter().map(|s| s.1.len()).sum();
    let split = match args.split {
        Some(Split::TrainColumn) => {
            return Err(InputError::new("--split", "train-column needs data files")
                .remedy("use trials, blocks:5 or time:0.6 for recordings"));
        }
        Some(split) => split,
        None if count > 1 => Split::Trials,
        None => Split::Blocks(5),
    };
    if split == Split::Trials {
        let name = sources.iter().map(|s| s.0.clone()).collect::<Vec<_>>().join(", ");
        let trials: Vec<Trial> = sources.into_iter().flat_map(|s| s.1).collect();
        let dataset = Dataset::new(&trials, body, args.side)?;
        return Ok(vec![problem(name, dataset, split, None, None)?]);
    }
    sources
        .into_iter()
        .map(|(name, trials)| {
            problem(name, Dataset::new(&trials, body, args.side)?, split, None, None)
        })
        .collect()
}

fn problem(
    name: String,
    dataset: Dataset,
    split: Split,
    train_column: Option<Fold>,
    step: Option<(f64, &'static str)>,
) -> Result<Problem, InputError> {
    let (folds, said) = match split {
        Split::TrainColumn => {
            let fold = train_column.ok_or_else(|| {
                InputError::new(&name, "has no column `train`").remedy(
                    "add it (1 trains, 0 tests), or choose --split trials|blocks:5|time:0.6",
                )
            })?;
            (vec![fold], "rows with train = 0".to_owned())
        }
        Split::Trials => {
            if dataset.trials < 2 {
                return Err(InputError::new(&name, "holds a single trajectory")
                    .remedy("use --split blocks:5 or time:0.6"));
            }
            (dataset.blocks(), format!("whole trajectories, {} in all", dataset.trials))
        }
        Split::Blocks(n) => (dataset.blocks_in_time(n), format!("{n} contiguous blocks in turn")),
        Split::Time(share) => (
            vec![dataset.split_in_time(share, 0.0)],
            format!("the last {:.0} % of the time", 100.0 * (1.0 - share)),
        ),
    };
    if folds.iter().any(|f| f.train.len() < 20 || f.test.is_empty()) {
        return Err(InputError::new(&name, "leaves too few rows to learn from or to judge on")
            .remedy("choose another --split"));
    }
    Ok(Problem { name, dataset, folds, split: said, step })
}

/// `FILE:BASE:TIP`; file and link names may hold colons.
fn chain(text: &str) -> Result<Linkage, InputError> {
    let form = || {
        InputError::new("--chain", format!("`{text}` is not of the form FILE:BASE:TIP"))
            .remedy("for example --chain arm.urdf:base:tip")
    };
    let cuts: Vec<usize> = text.match_indices(':').map(|(i, _)| i).collect();
    let file_end = cuts
        .iter()
        .copied()
        .find(|&i| Path::new(&text[..i]).is_file())
        .or_else(|| cuts.len().checked_sub(2).map(|i| cuts[i]))
        .ok_or_else(form)?;
    let model = read_urdf(Path::new(&text[..file_end]))?;
    let links = &text[file_end + 1..];
    let known = |n: &str| model.link_index(n).is_some();
    let splits = links.match_indices(':').map(|(i, _)| (&links[..i], &links[i + 1..]));
    let (base, tip) = splits
        .clone()
        .find(|(b, t)| known(b) && known(t))
        .or_else(|| splits.clone().next())
        .ok_or_else(form)?;
    Linkage::chain(&model, base, tip).map_err(|e| {
        InputError::new(&text[..file_end], e.to_string())
            .remedy(format!("the root link is `{}`; give two links of one branch", model.root()))
    })
}

/// The same methods over several problems.
fn merged(judged: &[Evaluation]) -> Vec<MethodScore> {
    let mut whole: Vec<MethodScore> = Vec::new();
    for evaluation in judged {
        for (i, score) in evaluation.methods.iter().enumerate() {
            match whole.get_mut(i) {
                None => whole.push(score.clone()),
                Some(sum) => {
                    sum.groups.extend(&score.groups);
                    sum.weights.extend(score.weights.iter().cloned());
                    sum.uncertainty.extend(score.uncertainty.iter().cloned());
                    sum.rollouts.extend(&score.rollouts);
                    sum.train_s += score.train_s;
                    sum.predict_s += score.predict_s;
                }
            }
        }
    }
    for score in &mut whole {
        score.train_s /= judged.len().max(1) as f64;
        score.predict_s /= judged.len().max(1) as f64;
    }
    whole
}
