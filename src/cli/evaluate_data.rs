//! What `ergopath evaluate` judges on: data files or recordings, and which of their rows are held out.

use super::evaluate::Args;
use crate::files::{InputError, suggest};
use crate::human::Body;
use crate::kinematics::{Linkage, read_urdf};
use crate::recording::read_map;
use crate::training::{
    DataFile, Dataset, Fold, Source, Trial, Whom, read_data, read_source, refuse_twice, remarks_of,
};
use std::path::{Path, PathBuf};

/// A way to hold rows out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Split {
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

/// One data set with the splits on which it is judged.
pub(super) struct Problem {
    pub name: String,
    pub dataset: Dataset,
    /// Names of its trials, by index.
    pub trials: Vec<String>,
    pub folds: Vec<Fold>,
    pub split: String,
    pub step: Option<(f64, &'static str)>,
}

/// What is to be judged, one data set after another.
pub(super) fn problems(args: &Args) -> Result<Vec<Problem>, InputError> {
    match &args.body {
        Some(body) => recorded(args, &Body::load(body, Path::new("."))?),
        None => from_files(args),
    }
}

fn from_files(args: &Args) -> Result<Vec<Problem>, InputError> {
    let chain = chain(args.chain.as_deref().unwrap_or_default())?;
    if let Some(path) = args.test.iter().find(|path| args.data.contains(path)) {
        return Err(InputError::new(path, "is given twice").remedy("what trains cannot test"));
    }
    let read = |path: &PathBuf| read_data(path, &chain, args.task, args.rate);
    let files: Result<Vec<DataFile>, InputError> =
        args.data.iter().chain(&args.test).map(read).collect();
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
    let trials = |file: &DataFile| -> Vec<String> {
        let name = |i: usize| match file.dataset.trials {
            1 => file.source.clone(),
            _ => format!("{} trajectory {}", file.source, i + 1),
        };
        (0..file.dataset.trials).map(name).collect()
    };
    if split != Split::Trials && args.test.is_empty() {
        return files
            .into_iter()
            .map(|f| {
                let trials = trials(&f);
                problem((f.source, trials), f.dataset, split, f.train_column, Some(f.step_s))
            })
            .collect();
    }
    let step = files.first().map(|f| f.step_s);
    let (train, test) = files.split_at(args.data.len());
    let named = (names(train.iter().map(|f| &f.source)), files.iter().flat_map(trials).collect());
    let taught: usize = train.iter().map(|f| f.dataset.trials).sum();
    let tested = names(test.iter().map(|f| &f.source));
    let dataset = Dataset::joined(files.into_iter().map(|f| f.dataset).collect())?;
    Ok(vec![if args.test.is_empty() {
        problem(named, dataset, split, None, step)?
    } else {
        problem_of_two(named, dataset, (taught, &tested), step)?
    }])
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
        args.data.iter().chain(&args.test).map(|path| read_source(path, &whom)).collect();
    let sources = sources?;
    refuse_twice(&sources.iter().collect::<Vec<_>>())?;
    for remark in remarks_of(&sources) {
        complain!("warning: {remark}");
    }
    let count: usize = sources.iter().map(|s| s.trials.len()).sum();
    let split = match args.split {
        Some(Split::TrainColumn) => {
            return Err(InputError::new("--split", "train-column needs data files")
                .remedy("use trials, blocks:5 or time:0.6 for recordings"));
        }
        Some(split) => split,
        None if count > 1 => Split::Trials,
        None => Split::Blocks(5),
    };
    if split != Split::Trials && args.test.is_empty() {
        let one = |s: Source| {
            let dataset = Dataset::new(&s.trials, body, args.side)?;
            problem((s.name, trial_names(&s.trials)), dataset, split, None, None)
        };
        return sources.into_iter().map(one).collect();
    }
    let (train, test) = sources.split_at(args.data.len());
    let tested = names(test.iter().map(|s| &s.name));
    let taught: usize = train.iter().map(|s| s.trials.len()).sum();
    let name = names(train.iter().map(|s| &s.name));
    let trials: Vec<Trial> = sources.into_iter().flat_map(|s| s.trials).collect();
    let named = (name, trial_names(&trials));
    let dataset = Dataset::new(&trials, body, args.side)?;
    Ok(vec![if args.test.is_empty() {
        problem(named, dataset, split, None, None)?
    } else {
        problem_of_two(named, dataset, (taught, &tested), None)?
    }])
}

fn names<'a>(sources: impl Iterator<Item = &'a String>) -> String {
    sources.cloned().collect::<Vec<_>>().join(", ")
}

fn trial_names(trials: &[Trial]) -> Vec<String> {
    trials.iter().map(|t| t.source.clone()).collect()
}

/// The first `taught` trials train, the others test.
fn problem_of_two(
    (name, trials): (String, Vec<String>),
    dataset: Dataset,
    (taught, tested): (usize, &str),
    step: Option<(f64, &'static str)>,
) -> Result<Problem, InputError> {
    let trains = |i: &usize| dataset.frames[*i].trial < taught;
    let (train, test) = (0..dataset.frames.len()).partition(trains);
    let folds = vec![Fold { train, test }];
    checked(Problem { name, trials, dataset, folds, split: tested.to_owned(), step })
}

fn problem(
    (name, trials): (String, Vec<String>),
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
    checked(Problem { name, trials, dataset, folds, split: said, step })
}

fn checked(problem: Problem) -> Result<Problem, InputError> {
    if problem.folds.iter().any(|f| f.train.len() < 20 || f.test.is_empty()) {
        let message = "leaves too few rows to learn from or to judge on";
        return Err(InputError::new(&problem.name, message)
            .remedy("give more movement to learn from, or choose another --split"));
    }
    Ok(problem)
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
