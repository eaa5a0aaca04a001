//! `ergopath evaluate`: how well each method predicts held-out rows of a data file or a recording.

use super::evaluate_data::{Split, problems};
use super::evaluate_print::{as_json, print_text};
use super::progress::Progress;
use super::train::{parse_pelvis, parse_side};
use super::{Failure, Outcome};
use crate::files::{InputError, suggest};
use crate::human::{Pelvis, Side};
use crate::posture::{Hold, Method, Sampling};
use crate::training::{
    Evaluation, Judging, Lengths, MethodScore, Objective, Optimiser, PullRule, TrainSettings,
    evaluate,
};
use std::path::PathBuf;

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
#[allow(clippy::struct_excessive_bools, reason = "flags of a command line")]
pub(super) struct Args {
    /// Data files (CSV with columns q0.., xdot0.., qdot0.., train, traj; SI and radians) with --chain; or
    /// recordings with --body.
    #[arg(required = true, value_name = "DATA")]
    pub data: Vec<PathBuf>,
    /// Chain of the data files: a URDF, base link and tip link.
    #[arg(long, value_name = "FILE:BASE:TIP", required_unless_present = "body")]
    pub chain: Option<String>,
    /// Body of the person in recordings: a shipped one by name, or a URDF made by `ergopath body`.
    #[arg(long, conflicts_with = "chain")]
    pub body: Option<String>,
    /// Which person of a folder with several.
    #[arg(long, requires = "body")]
    pub person: Option<String>,
    /// What makes the markers of C3D and TRC files, or the points of tables, the segments of a person.
    #[arg(long, value_name = "MAP.toml", requires = "body")]
    pub map: Option<PathBuf>,
    /// The hand that holds on to the robot.
    #[arg(long, value_parser = parse_side, default_value = "right", value_name = "right|left")]
    pub side: Side,
    /// Whether the pelvis of recordings rests, as in the paper, or moves over feet that must be recorded.
    #[arg(long, value_parser = parse_pelvis, default_value = "rests", value_name = "moves|rests")]
    pub pelvis: Pelvis,
    /// Task of the chain: planar (2 rows), position (3) or pose (6); by default by the xdot columns.
    #[arg(long, value_parser = parse_task, value_name = "planar|position|pose")]
    pub task: Option<Hold>,
    /// Methods, separated by commas: all, or some of mi-nsgp, gp, w-ik, nsgp, sb-m, promp, full-w,
    /// full-w-gp, plain-ik.
    #[arg(long, value_delimiter = ',', default_value = "all", value_name = "NAME,...")]
    methods: Vec<String>,
    /// Standard deviation of the task velocity, m/s and rad/s; by default from the training rows.
    #[arg(long, value_name = "SD")]
    task_noise: Option<f64>,
    /// Data to judge on: with it the methods learn from all of DATA, and from nothing else.
    #[arg(long, num_args = 1.., value_name = "DATA", conflicts_with = "split")]
    pub test: Vec<PathBuf>,
    /// Which rows are held out: train-column, trials, blocks:N or time:SHARE. By default the train
    /// column where there is one, else trials, else blocks:5. With trials all files are one person's;
    /// otherwise each file is a problem of its own.
    #[arg(long, value_name = "SPLIT")]
    pub split: Option<Split>,
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
    pub rate: Option<f64>,
    /// Seed of everything random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print JSON at full precision.
    #[arg(long)]
    json: bool,
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

/// The methods of these names; `all` for eight of them.
pub(super) fn methods(names: &[String]) -> Result<Vec<Method>, InputError> {
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
