//! Several finished runs side by side: what is compared, and which intervals may be drawn.
//!
//! Rollout r of two runs is the same person where seed, posture model and body are the same and the same
//! program drew it: then the difference of two runs is paired over repetitions. Otherwise the interval is that
//! of two groups, and the reason stands beside it.

use super::ReportError;
use super::comparison_figure::cells;
use super::comparison_page::page;
use super::comparison_table::table;
use crate::ergonomics::{PairedDifference, by_person, paired_difference, unpaired_difference};
use crate::path::Family;
use crate::planner::{BodyScores, CandidateResult, Evaluated, RunResult, apart};
use crate::words;
use serde::Serialize;

/// How a run ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "state", content = "reason", rename_all = "kebab-case")]
pub enum RowState {
    /// A path was found.
    Ok,
    /// No path keeps all limits; the most frequent reason.
    NoFeasiblePath(String),
    /// The run could not be made; why.
    Failed(String),
}

/// What a path is in its run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// The best path.
    Best,
    /// The straight path, where it is not the best.
    Straight,
    /// The user's own, where it is not the best.
    Own,
}

/// Scores of one path for one body.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedPath {
    /// What it is.
    pub role: Role,
    /// Its name.
    pub id: String,
    /// Share of time at RULA 5 or more: mean over repetitions, 5th and 95th percentile.
    pub exposure_rula_5: [f64; 3],
    /// Shares of time at each RULA score or above, index the score.
    pub rula_at_least: Vec<f64>,
    /// Expected RULA.
    pub expected_rula: f64,
    /// 5th percentile of the mean RULA of a repetition.
    pub p05_rula: f64,
    /// 95th percentile.
    pub p95_rula: f64,
    /// Mean RULA of the worst tenth.
    pub cvar90_rula: f64,
    /// Expected REBA.
    pub expected_reba: f64,
    /// Share of repetitions in which the hand cannot follow.
    pub reach_exceeded: f64,
    /// Best minus this path, over the same repetitions; none for the best.
    pub best_minus_this: Option<PairedDifference>,
}

/// This run's best path minus the best path of the run that it is compared with, expected RULA.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunDifference {
    /// Body of the other run.
    pub other_body: String,
    /// Mean difference.
    pub mean: f64,
    /// Lower end of the 95 % interval.
    pub low95: f64,
    /// Upper end of the 95 % interval.
    pub high95: f64,
    /// Whether the interval leaves 0 out.
    pub clear: bool,
    /// People of this and of the other run that were compared.
    pub repetitions: [usize; 2],
    /// None if rollout r is the same person in both; else why it is not.
    pub unpaired_because: Option<String>,
}

/// One body size in a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedBody {
    /// Name of the body.
    pub body: String,
    /// The best path first, then the straight one and the user's own.
    pub paths: Vec<ComparedPath>,
    /// Against the other run; none for that run itself and for runs without a path.
    pub against: Option<RunDifference>,
}

/// One run of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ComparedRun {
    /// Name of the run: its folder or scenario.
    pub name: String,
    /// How it ended.
    #[serde(flatten)]
    pub state: RowState,
    /// Name of the scenario, as it calls itself.
    pub scenario: String,
    /// Duration of the movement, s.
    pub duration_s: Option<f64>,
    /// Load on the hand, kg.
    pub load_kg: Option<f64>,
    /// Robot.
    pub robot: String,
    /// Posture model.
    pub posture_model: String,
    /// The bodies; empty without a feasible path.
    pub bodies: Vec<ComparedBody>,
    /// Index of the body for which the best path scores worst.
    pub worst: Option<usize>,
    /// The words that stand in the verdict.
    pub caveat: Option<String>,
    /// SHA-256 of the scenario file.
    pub scenario_sha256: String,
    /// Version of ergopath.
    pub program_version: String,
    /// Seed.
    pub seed: Option<u64>,
}

/// Runs side by side, in the order in which they were named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Name of the run that the others are compared with; none where no run has a path.
    pub against: Option<String>,
    /// The runs.
    pub runs: Vec<ComparedRun>,
}

/// A run to compare: its name, and its result or why there is none.
pub type NamedRun = (String, Result<RunResult, String>);

impl Comparison {
    /// Compares runs. `against` names the run that the others are compared with; without it, or where it
    /// has no path, the first that has one.
    pub fn of(runs: &[NamedRun], against: Option<&str>) -> Self {
        let has_path = |run: &&NamedRun| run.1.as_ref().is_ok_and(|r| best(r).is_some());
        let named = runs.iter().filter(has_path).find(|r| Some(r.0.as_str()) == against);
        let reference = named.or_else(|| runs.iter().find(has_path));
        let against = reference.and_then(|(name, r)| Some((name.as_str(), r.as_ref().ok()?)));
        Self {
            against: against.map(|(name, _)| name.to_owned()),
            runs: runs.iter().map(|run| ComparedRun::of(run, against)).collect(),
        }
    }

    /// The runs by expected RULA of the body that scores worst; those without a path last.
    pub fn ranked(&self) -> Vec<&ComparedRun> {
        let key = |r: &ComparedRun| r.best().map_or(f64::INFINITY, |p| p.expected_rula);
        let mut sorted: Vec<&ComparedRun> = self.runs.iter().collect();
        sorted.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.name.cmp(&b.name)));
        sorted
    }
}

impl ComparedRun {
    fn of((name, result): &NamedRun, against: Option<(&str, &RunResult)>) -> Self {
        let result = match result {
            Ok(result) => result,
            Err(reason) => return Self::failed(name, reason),
        };
        let p = &result.provenance;
        let mut run = Self {
            scenario: result.setting.name.clone(),
            duration_s: Some(result.setting.duration_s),
            load_kg: Some(result.setting.task.load_kg),
            robot: result.setting.robot.name.clone(),
            posture_model: result.posture_model.name.clone(),
            caveat: result.verdict.caveat.map(|c| words::verdict::caveat(c).into_owned()),
            scenario_sha256: p.inputs.first().map(|(_, h)| h.clone()).unwrap_or_default(),
            program_version: p.program_version.clone().into_owned(),
            seed: Some(p.seed),
            ..Self::failed(name, "")
        };
        let Some(best) = best(result) else {
            let reason = words::refused::lines(result).into_iter().next();
            run.state =
                RowState::NoFeasiblePath(reason.unwrap_or_else(|| "no reason is stored".into()));
            return run;
        };
        run.state = RowState::Ok;
        let is_itself = against.is_none_or(|(other, _)| other == name);
        let other = against.filter(|_| !is_itself).map(|(_, r)| r);
        let of_body = |b: &BodyScores| ComparedBody {
            body: b.body.clone(),
            paths: paths(result, best, &b.body),
            against: other.and_then(|o| difference((result, b), o)),
        };
        run.bodies = best.bodies.iter().map(of_body).collect();
        let verdicts = result.verdict.body.as_deref();
        run.worst = best.bodies.iter().position(|b| Some(b.body.as_str()) == verdicts);
        run
    }

    fn failed(name: &str, reason: &str) -> Self {
        Self {
            name: name.to_owned(),
            state: RowState::Failed(reason.to_owned()),
            scenario: String::new(),
            duration_s: None,
            load_kg: None,
            robot: String::new(),
            posture_model: String::new(),
            bodies: Vec::new(),
            worst: None,
            caveat: None,
            scenario_sha256: String::new(),
            program_version: String::new(),
            seed: None,
        }
    }

    /// The body for which the best path scores worst.
    pub fn worst_body(&self) -> Option<&ComparedBody> {
        self.bodies.get(self.worst?)
    }

    /// The best path's scores for that body.
    pub fn best(&self) -> Option<&ComparedPath> {
        self.worst_body()?.paths.first()
    }

    /// State and reason in words.
    pub fn state_words(&self) -> (&'static str, &str) {
        match &self.state {
            RowState::Ok => ("ok", ""),
            RowState::NoFeasiblePath(reason) => ("no feasible path", reason),
            RowState::Failed(reason) => ("failed", reason),
        }
    }
}

/// The best path of a run, with scores.
fn best(result: &RunResult) -> Option<&CandidateResult> {
    let best = result.verdict.lead.as_ref().filter(|_| result.verdict.is_decided())?;
    result.candidates.iter().find(|c| c.id == *best && !c.bodies.is_empty())
}

/// Best, straight and the user's own paths, for one body.
fn paths(result: &RunResult, best: &CandidateResult, body: &str) -> Vec<ComparedPath> {
    let others = |role: Role, family: Family| {
        let is_one = move |c: &&CandidateResult| {
            c.family == family && c.evaluated == Evaluated::Reported && c.id != best.id
        };
        result.candidates.iter().filter(is_one).map(move |c| (role, c))
    };
    let all = std::iter::once((Role::Best, best))
        .chain(others(Role::Straight, Family::Straight))
        .chain(others(Role::Own, Family::Drawn));
    let of = |c: &CandidateResult| c.bodies.iter().find(|b| b.body == body).cloned();
    let lead = of(best);
    all.filter_map(|(role, c)| {
        let b = of(c)?;
        let pairs = lead.as_ref().filter(|_| role != Role::Best);
        Some(ComparedPath {
            role,
            id: c.id.clone(),
            exposure_rula_5: b.rula().high_band,
            rula_at_least: b.rula().distribution.exposure.clone(),
            expected_rula: b.rula().distribution.expected,
            p05_rula: b.rula().distribution.p05,
            p95_rula: b.rula().distribution.p95,
            cvar90_rula: b.rula().distribution.cvar90,
            expected_reba: b.reba().distribution.expected,
            reach_exceeded: b.reach_exceeded,
            best_minus_this: pairs.map(|l| l.rula().less(b.rula(), |s| &s.by_rollout)),
        })
    })
    .collect()
}

/// A body's best path against the best path of another run: for the same body where it has one, else
/// for the body that scores worst there.
fn difference(
    (result, own): (&RunResult, &BodyScores),
    other: &RunResult,
) -> Option<RunDifference> {
    let theirs = best(other)?;
    let worst = || super::view::worst_body(theirs);
    let other_body = theirs.bodies.iter().find(|b| b.body == own.body).or_else(worst)?;
    let because = apart((result, &own.body), (other, &other_body.body));
    let [a, b] = [own, other_body].map(|s| by_person(&s.rula().by_rollout, s.rula().persons()));
    let (mean, low95, high95, clear, repetitions) = if because.is_none() {
        let d = paired_difference(&a, &b);
        (d.mean, d.low95, d.high95, d.clear, [d.n, d.n])
    } else {
        let d = unpaired_difference(&a, &b);
        (d.mean, d.low95, d.high95, d.clear, d.n)
    };
    Some(RunDifference {
        other_body: other_body.body.clone(),
        mean,
        low95,
        high95,
        clear,
        repetitions,
        unpaired_because: because.as_ref().map(words::pairing::apart),
    })
}

/// The page and the table of a comparison, as (ending, bytes). The drawings of the cells need the results
/// themselves.
pub fn comparison(
    comparison: &Comparison,
    results: &[NamedRun],
) -> Result<Vec<(&'static str, Vec<u8>)>, ReportError> {
    let drawn = cells(comparison, results)?;
    Ok(vec![("csv", table(comparison)?), ("html", page(comparison, drawn.as_deref()).into_bytes())])
}
