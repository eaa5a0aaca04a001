//! From the shift file to tasks with their results and their minutes. Everything that contradicts itself is
//! refused here.

use super::file::{Order, SHIFT_SCHEMA, ShiftFile, TaskTable};
use crate::ergonomics::LiftCondition;
use crate::files::{InputError, Seal, parse_toml, read_bytes, read_text, sha256_hex, suggest};
use crate::human::Hands;
use crate::planner::{CandidateResult, RunResult, read_result, result_file};
use crate::scenario::Warning;
use crate::scoring::{StoredScore, StoredSide, read_score};
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// Minutes that may go missing in sums of typed numbers.
const ROUNDING_MIN: f64 = 1e-6;

/// A shift with the results of its tasks.
#[derive(Debug, Clone)]
pub struct Shift {
    /// Short name.
    pub name: String,
    /// What it is about.
    pub description: String,
    /// Length with breaks, min.
    pub minutes: f64,
    /// Breaks: name and minutes.
    pub breaks: Vec<(String, f64)>,
    /// How the tasks follow each other, if given.
    pub order: Option<Order>,
    /// The tasks as they stand in the file.
    pub tasks: Vec<ShiftTask>,
    /// (name as typed, SHA-256) of the shift file and every result.
    pub inputs: Vec<(String, String)>,
}

/// One task.
#[derive(Debug, Clone)]
pub struct ShiftTask {
    /// Its name.
    pub name: String,
    /// The result as it was typed.
    pub result: String,
    /// What was scored.
    pub source: TaskSource,
    /// Duration of one movement, s.
    pub duration_s: f64,
    /// Time that goes to the task, min.
    pub minutes: f64,
    /// How often the movement is made.
    pub cycles: f64,
    /// Whether the time is given, by share or minutes, and does not follow from the cycles.
    pub time_is_given: bool,
    /// Whether the number of cycles is not given but follows from movements without a pause.
    pub without_pause: bool,
    /// What the user says that the lifting equation excludes.
    pub excluded: Vec<LiftCondition>,
    /// Lowest and highest OMNI-RES rating, if given.
    pub omni_res: Option<[u8; 2]>,
    /// Exertions of the hand in each cycle.
    pub exertions: f64,
}

impl ShiftTask {
    /// Time in the movement itself, which is what was scored, min.
    pub fn moving_min(&self) -> f64 {
        self.cycles * self.duration_s / 60.0
    }

    /// The hands at work.
    pub fn hands(&self) -> Hands {
        match &self.source {
            TaskSource::Run { result, .. } => result.setting.worker.hands,
            TaskSource::Motion { side, .. } => side.side.into(),
        }
    }
}

/// What was scored.
#[derive(Debug, Clone)]
pub enum TaskSource {
    /// A path of a run.
    Run {
        /// The run.
        result: Box<RunResult>,
        /// Index of the path among its candidates.
        candidate: usize,
    },
    /// One side of a motion.
    Motion {
        /// The scores.
        score: StoredScore,
        /// The side.
        side: StoredSide,
    },
}

impl TaskSource {
    /// The path of a run.
    pub fn candidate(&self) -> Option<(&RunResult, &CandidateResult)> {
        match self {
            Self::Run { result, candidate } => Some((result, result.candidates.get(*candidate)?)),
            Self::Motion { .. } => None,
        }
    }

    /// Whether its file cannot say that nobody changed it.
    pub(super) fn is_unsealed(&self) -> bool {
        match self {
            Self::Run { result, .. } => {
                let unsealed = |w: &Warning| matches!(w, Warning::NoChecksum { .. });
                result.warnings.iter().any(unsealed)
            }
            Self::Motion { score, .. } => score.seal == Seal::Missing,
        }
    }
}

/// Reads a shift and all results that it names.
///
/// # Errors
/// Where a key, a result or a sum of times cannot be used; with its place in the file.
pub fn read_shift(path: &Path) -> Result<Shift, InputError> {
    let text = read_text(path)?;
    let file: ShiftFile = parse_toml(path, &text)?;
    let reader = Reader { path, text: &text, folder: path.parent().unwrap_or(Path::new("")) };
    if file.schema.get_ref() != SHIFT_SCHEMA {
        return Err(reader
            .error(file.schema.span(), format!("schema is not `{SHIFT_SCHEMA}`"))
            .remedy("this program reads that version only"));
    }
    let minutes = reader.positive(&file.shift.minutes, "minutes")?;
    if minutes > 24.0 * 60.0 {
        let message = format!("a shift of {minutes} min is longer than a day");
        return Err(reader
            .error(file.shift.minutes.span(), message)
            .remedy("minutes, not seconds; one shift, not a week"));
    }
    let mut rest = 0.0;
    let mut breaks = Vec::new();
    for b in &file.breaks {
        let minutes_of = reader.positive(&b.minutes, "minutes")?;
        rest += minutes_of;
        if rest >= minutes {
            let message = format!("breaks of {rest} min leave nothing of a shift of {minutes} min");
            return Err(reader.error(b.minutes.span(), message).remedy("shorten the breaks"));
        }
        breaks.push((b.name.clone(), minutes_of));
    }
    let working_min = minutes - rest;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut inputs = vec![(name, sha256_hex(text.as_bytes()))];
    let mut tasks: Vec<ShiftTask> = Vec::new();
    let mut used = 0.0;
    for table in &file.task {
        let name = table.name.get_ref();
        if name.trim().is_empty() || tasks.iter().any(|t| t.name == *name) {
            let message = if name.trim().is_empty() {
                "a task has no name".to_owned()
            } else {
                format!("there are two tasks named `{name}`")
            };
            return Err(reader.error(table.name.span(), message).remedy("name each task once"));
        }
        let (task, hash) = reader.task(table, working_min)?;
        used += task.minutes;
        if used > working_min + ROUNDING_MIN {
            let message = format!(
                "the tasks up to `{name}` take {used:.1} min; the shift has {working_min:.1} min without its breaks"
            );
            let at = time_of(table);
            return Err(reader.error(at, message).remedy(
                "shares add up to 1 at most; lower share, minutes or cycles, or shorten the breaks",
            ));
        }
        inputs.push((task.result.clone(), hash));
        tasks.push(task);
    }
    if tasks.is_empty() {
        let message = "a shift needs at least one [[task]]";
        return Err(InputError::new(path, message).remedy("add a task with name and result"));
    }
    let shift = file.shift;
    Ok(Shift {
        name: shift.name,
        description: shift.description,
        minutes,
        breaks,
        order: shift.order,
        tasks,
        inputs,
    })
}

/// The text behind a shift, for errors that show the place.
struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
    folder: &'a Path,
}

impl Reader<'_> {
    fn error(&self, at: Range<usize>, message: impl Into<String>) -> InputError {
        InputError::new(self.path, message).at(self.text, at)
    }

    fn positive(&self, value: &Spanned<f64>, key: &str) -> Result<f64, InputError> {
        let v = *value.get_ref();
        if v.is_finite() && v > 0.0 {
            return Ok(v);
        }
        Err(self
            .error(value.span(), format!("`{key}` is {v}, not a number above 0"))
            .remedy("leave a task or break without time out of the file"))
    }

    fn task(&self, table: &TaskTable, working_min: f64) -> Result<(ShiftTask, String), InputError> {
        let (source, file) = self.source(table)?;
        let hash = sha256_hex(&read_bytes(&file)?);
        let (duration_s, per_min) = match &source {
            TaskSource::Run { result, candidate } => {
                let path = result.candidates.get(*candidate).and_then(|c| c.path.as_ref());
                let end = path.and_then(|p| Some(p.time_s.last()? - p.time_s.first()?));
                let duration = end.unwrap_or(result.setting.duration_s);
                (duration, result.setting.task.cycles_per_min)
            }
            TaskSource::Motion { score, .. } => (score.duration_s, None),
        };
        if !(duration_s.is_finite() && duration_s > 0.0) {
            let message = format!("the movement of `{}` has no duration", table.result.get_ref());
            return Err(self.error(table.result.span(), message).remedy("make the run again"));
        }
        let (minutes, cycles, without_pause) =
            self.time(table, working_min, duration_s, per_min)?;
        let exertions = match &table.exertions {
            Some(n) => self.positive(n, "exertions")?,
            None => 1.0,
        };
        if let (Some(n), None) = (&table.exertions, &table.omni_res) {
            let message = "`exertions` without `omni_res` says nothing";
            return Err(self.error(n.span(), message).remedy("add omni_res, or take it out"));
        }
        let omni_res = match &table.omni_res {
            Some(ratings) => Some(self.ratings(ratings)?),
            None => None,
        };
        let task = ShiftTask {
            name: table.name.get_ref().clone(),
            result: table.result.get_ref().clone(),
            source,
            duration_s,
            minutes,
            cycles,
            time_is_given: table.share.is_some() || table.minutes.is_some(),
            without_pause,
            excluded: table.excluded.clone(),
            omni_res,
            exertions,
        };
        Ok((task, hash))
    }

    fn ratings(&self, ratings: &Spanned<super::file::Ratings>) -> Result<[u8; 2], InputError> {
        let [low, high] = ratings.get_ref().range();
        if low <= high && high <= 10 {
            return Ok([low, high]);
        }
        let message = format!("`omni_res` is {low} to {high}");
        let remedy =
            "whole numbers from 0 (extremely easy) to 10 (extremely hard), the lower one first";
        Err(self.error(ratings.span(), message).remedy(remedy))
    }

    /// Minutes of the task, cycles, and whether these follow from movements without a pause.
    fn time(
        &self,
        table: &TaskTable,
        working_min: f64,
        duration_s: f64,
        per_min: Option<f64>,
    ) -> Result<(f64, f64, bool), InputError> {
        let name = table.name.get_ref();
        let given = match (&table.share, &table.minutes) {
            (Some(share), Some(_)) => {
                let message = format!("`{name}` has both `share` and `minutes`");
                return Err(self.error(share.span(), message).remedy("keep one of them"));
            }
            (Some(share), None) => {
                let s = self.positive(share, "share")?;
                if s > 1.0 {
                    let message = format!("`share` is {s}, above 1");
                    let remedy = "a share of the working time from 0 to 1; 35 % is 0.35";
                    return Err(self.error(share.span(), message).remedy(remedy));
                }
                Some(s * working_min)
            }
            (None, Some(minutes)) => Some(self.positive(minutes, "minutes")?),
            (None, None) => None,
        };
        let cycles = match &table.cycles {
            Some(n) => Some(self.positive(n, "cycles")?),
            None => None,
        };
        let at = || time_of(table);
        match (given, cycles) {
            (None, None) => Err(self
                .error(table.name.span(), format!("`{name}` has no time"))
                .remedy("add share (of the working time), minutes or cycles (in the shift)")),
            (None, Some(n)) => Ok((n * duration_s / 60.0, n, false)),
            (Some(minutes), Some(n)) => {
                let moving = n * duration_s / 60.0;
                if moving <= minutes + ROUNDING_MIN {
                    return Ok((minutes, n, false));
                }
                let message = format!(
                    "{n} cycles of {duration_s:.2} s take {moving:.1} min, but `{name}` has {minutes:.1} min"
                );
                Err(self.error(at(), message).remedy("fewer cycles, or more time"))
            }
            (Some(minutes), None) => match per_min {
                Some(rate) if rate > 0.0 => {
                    let n = rate * minutes;
                    let moving = n * duration_s / 60.0;
                    if moving <= minutes + ROUNDING_MIN {
                        return Ok((minutes, n, false));
                    }
                    let message = format!(
                        "the scenario of `{name}` says {rate} cycles a minute, but one takes {duration_s:.2} s"
                    );
                    Err(self.error(table.result.span(), message).remedy(
                        "give the number of `cycles` in the shift, or mend task.cycles_per_min of the scenario",
                    ))
                }
                _ => Ok((minutes, minutes * 60.0 / duration_s, true)),
            },
        }
    }

    /// The result of a task, and its file.
    fn source(&self, table: &TaskTable) -> Result<(TaskSource, PathBuf), InputError> {
        let typed = &table.result;
        let place = self.folder.join(typed.get_ref());
        let named = |e: InputError| e.named_in(self.path, "task.result", self.text, typed.span());
        let is_score = |place: &Path| {
            let name = place.file_name().is_some_and(|n| n == "summary.json");
            name || (place.join("summary.json").is_file() && !result_file(place).is_file())
        };
        if is_score(&place) {
            let score = read_score(&place).map_err(named)?;
            if let Some(path) = &table.path {
                let message = "a scored motion has no paths";
                return Err(self.error(path.span(), message).remedy("take `path` out"));
            }
            let side = self.side(table, &score)?;
            let file = if place.is_dir() { place.join("summary.json") } else { place };
            return Ok((TaskSource::Motion { score, side }, file));
        }
        let result = read_result(&place).map_err(named)?;
        if let Some(side) = &table.side {
            let message = "`side` is for scored motions; a run is scored for the hand on the robot";
            return Err(self.error(side.span(), message).remedy("take `side` out"));
        }
        let candidate = self.candidate(table, &result)?;
        Ok((TaskSource::Run { result: Box::new(result), candidate }, result_file(&place)))
    }

    fn side(&self, table: &TaskTable, score: &StoredScore) -> Result<StoredSide, InputError> {
        let names: Vec<&str> = score.sides.iter().map(|s| s.side.name()).collect();
        let Some(wanted) = &table.side else {
            return match score.sides.as_slice() {
                [only] => Ok(only.clone()),
                _ => Err(self
                    .error(table.result.span(), "both sides of this motion were scored")
                    .remedy("say which one counts: side = \"right\" or side = \"left\"")),
            };
        };
        let found = score.sides.iter().find(|s| s.side == *wanted.get_ref());
        found.cloned().ok_or_else(|| {
            let message = format!("the {} side was not scored", wanted.get_ref().name());
            self.error(wanted.span(), message).remedy(format!("scored: {}", names.join(", ")))
        })
    }

    /// The path of a run that counts: one with scores of every repetition.
    fn candidate(&self, table: &TaskTable, result: &RunResult) -> Result<usize, InputError> {
        let by_id = |id: &str| result.candidates.iter().position(|c| c.id == id);
        let is_scored = |k: &usize| {
            result.candidates.get(*k).is_some_and(|c| !c.bodies.is_empty() && c.path.is_some())
        };
        let (k, at) = if let Some(wanted) = &table.path {
            let scored: Vec<&str> = (0..result.candidates.len())
                .filter(is_scored)
                .filter_map(|k| result.candidates.get(k).map(|c| c.id.as_str()))
                .collect();
            let found = by_id(wanted.get_ref()).filter(is_scored);
            let k = found.ok_or_else(|| {
                let help = suggest(wanted.get_ref(), scored.iter().copied())
                    .unwrap_or_else(|| format!("scored paths: {}", scored.join(", ")));
                let message = format!("the run has no scored path `{}`", wanted.get_ref());
                self.error(wanted.span(), message).remedy(help)
            })?;
            (k, wanted.span())
        } else {
            let lead = result.verdict.lead.as_deref().filter(|_| result.verdict.is_decided());
            let found = lead.and_then(by_id).filter(is_scored);
            let k = found.ok_or_else(|| {
                let message = format!("`{}` has no best path", table.result.get_ref());
                self.error(table.result.span(), message).remedy(
                    "name one of its scored paths with `path`, or mend the scenario and plan it again",
                )
            })?;
            (k, table.result.span())
        };
        let is_kept = result.candidates.get(k).is_some_and(|c| {
            c.bodies.iter().all(|b| {
                b.scores.iter().all(|(_, s)| {
                    s.levels.iter().skip(1).all(|l| l.by_rollout.len() == s.by_rollout.len())
                })
            })
        });
        if is_kept {
            return Ok(k);
        }
        let message = "the result does not hold the time at each action level of every repetition";
        Err(self
            .error(at, message)
            .remedy("it is of an older program: make the run again with this one"))
    }
}

/// Where the time of a task stands.
fn time_of(table: &TaskTable) -> Range<usize> {
    let keys = [&table.minutes, &table.share, &table.cycles];
    let found = keys.into_iter().flatten().next();
    found.map_or_else(|| table.name.span(), Spanned::span)
}
