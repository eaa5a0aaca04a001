//! Minutes at each action level: added up over tasks, with the same people where the tasks have the same.

use super::read::{Shift, ShiftTask, TaskSource};
use super::result::{
    BodyDose, Dose, LevelDose, MethodDose, SHIFT_RESULT_SCHEMA, ShiftNote, ShiftResult, ShiftTime,
    TaskApart, TaskDose, TaskFacts, TaskKind, Units, WhyApart, WorstPerson,
};
use super::sums::dose;
use super::{exertion, lifting};
use crate::ergonomics::{ScoringMethod, by_person};
use crate::files::InputError;
use crate::human::BodySize;
use crate::planner::{BodyScores, Status, apart};
use std::collections::BTreeSet;
use std::path::Path;

/// Movements a minute above which RULA and REBA count a task as repeated.
const REPEATED_PER_MIN: f64 = 4.0;
/// Share of samples beyond the recordings from which it is said.
const BEYOND: f64 = 0.1;

/// The scores of one task for one body.
struct OfTask<'a> {
    task: usize,
    body: Option<&'a BodyScores>,
    source: &'a TaskSource,
    /// Minutes in the movement.
    minutes: f64,
}

impl OfTask<'_> {
    /// By action level from the lowest: share of time at it or above, for each repetition.
    fn at_least(&self, method: ScoringMethod) -> Vec<Vec<f64>> {
        match (self.body, self.source) {
            (Some(body), _) => {
                let scores = &body.scores[method];
                let all = vec![1.0; scores.by_rollout.len()];
                let rest = scores.levels.iter().skip(1).map(|l| l.by_rollout.clone());
                std::iter::once(all).chain(rest).collect()
            }
            (None, TaskSource::Motion { side, .. }) => side.at_least[method].clone(),
            (None, TaskSource::Run { .. }) => Vec::new(),
        }
    }

    fn persons(&self) -> Option<usize> {
        self.body.and_then(|b| b.scores[ScoringMethod::Rula].persons())
    }

    fn repetitions(&self) -> usize {
        match (self.body, self.source) {
            (Some(body), _) => body.scores[ScoringMethod::Rula].by_rollout.len(),
            (None, TaskSource::Motion { side, .. }) => {
                side.at_least[ScoringMethod::Rula].first().map_or(0, Vec::len)
            }
            (None, TaskSource::Run { .. }) => 0,
        }
    }

    /// Minutes at a level or above, for each person, or each repetition where nobody repeats.
    fn minutes_at_least(&self, method: ScoringMethod, level: usize) -> Vec<f64> {
        let shares = self.at_least(method).into_iter().nth(level).unwrap_or_default();
        by_person(&shares, self.persons()).into_iter().map(|s| s * self.minutes).collect()
    }

    /// Why the people of the two tasks are not the same; none if they are.
    fn apart(&self, other: &Self) -> Option<WhyApart> {
        let (Some(a), Some(b)) = (self.body, other.body) else { return Some(WhyApart::Sampled) };
        let (TaskSource::Run { result: ra, .. }, TaskSource::Run { result: rb, .. }) =
            (self.source, other.source)
        else {
            return Some(WhyApart::Sampled);
        };
        if let Some(why) = apart((ra, &a.body), (rb, &b.body)) {
            return Some(WhyApart::Runs(why));
        }
        let counts = [self.repetitions(), other.repetitions()];
        // With people in turn their means are the same people's, however often they repeat.
        let same_people = self.persons().is_some() && self.persons() == other.persons();
        (counts[0] != counts[1] && !same_people).then_some(WhyApart::Counts(counts))
    }
}

/// Tasks with the same people together; a motion that was measured once stands alone.
fn grouped<'a, 'b>(units: &'b [OfTask<'a>]) -> Vec<Vec<&'b OfTask<'a>>> {
    let mut groups: Vec<Vec<&OfTask>> = Vec::new();
    for unit in units {
        let own = groups.iter_mut().find(|g| {
            g.first().is_some_and(|first| first.repetitions() > 1 && first.apart(unit).is_none())
        });
        match own {
            Some(group) => group.push(unit),
            None => groups.push(vec![unit]),
        }
    }
    groups
}

/// The sum of each person or repetition over the tasks of a group.
fn summed(group: &[&OfTask], method: ScoringMethod, level: usize) -> Vec<f64> {
    let mut all = group.iter().map(|u| u.minutes_at_least(method, level));
    let first = all.next().unwrap_or_default();
    all.fold(first, |sum, more| sum.iter().zip(&more).map(|(a, b)| a + b).collect())
}

impl Shift {
    /// What the shift comes to. `path` is only named in errors.
    ///
    /// # Errors
    /// Where no body is known to all tasks.
    pub fn assess(&self, path: &Path) -> Result<ShiftResult, InputError> {
        let (names, left_out) = self.bodies(path)?;
        let mut bodies: Vec<BodyDose> = Vec::new();
        for name in &names {
            bodies.push(self.body(name));
        }
        let high = |b: &BodyDose| b.methods[ScoringMethod::Rula].high.mean_min;
        let mut worst = 0;
        for (k, body) in bodies.iter().enumerate() {
            if bodies.get(worst).is_some_and(|w| high(body) > high(w)) {
                worst = k;
            }
        }
        let name = names.get(worst).map_or("", String::as_str);
        let time = self.time();
        Ok(ShiftResult {
            schema: SHIFT_RESULT_SCHEMA,
            program_version: env!("CARGO_PKG_VERSION"),
            name: self.name.clone(),
            description: self.description.clone(),
            order: self.order,
            time,
            tasks: self.tasks.iter().map(facts).collect(),
            worst,
            left_out,
            apart: self.apart(name),
            lifting: lifting::lifting(self, name),
            exertion: exertion::exertion(&self.tasks),
            notes: self.notes(name, &time),
            bodies,
            inputs: self.inputs.clone(),
        })
    }

    fn time(&self) -> ShiftTime {
        let breaks_min: f64 = self.breaks.iter().map(|(_, m)| m).sum();
        let on_tasks: f64 = self.tasks.iter().map(|t| t.minutes).sum();
        let scored_min: f64 = self.tasks.iter().map(ShiftTask::moving_min).sum();
        // What rounding leaves is nothing.
        let left = |v: f64| if v < 1e-6 { 0.0 } else { v };
        ShiftTime {
            shift_min: self.minutes,
            breaks_min,
            scored_min,
            between_min: left(on_tasks - scored_min),
            other_min: left(self.minutes - breaks_min - on_tasks),
        }
    }

    /// Bodies that all runs know, in the order of the first; and those that only some know.
    fn bodies(&self, path: &Path) -> Result<(Vec<String>, Vec<String>), InputError> {
        let of = |t: &ShiftTask| -> Option<Vec<String>> {
            let (_, candidate) = t.source.candidate()?;
            Some(candidate.bodies.iter().map(|b| b.body.clone()).collect())
        };
        let runs: Vec<(&str, Vec<String>)> =
            self.tasks.iter().filter_map(|t| Some((t.name.as_str(), of(t)?))).collect();
        let Some((_, first)) = runs.first() else {
            // Only scored motions: one person, by the name of the body they were scored on.
            let names: BTreeSet<&str> = self
                .tasks
                .iter()
                .filter_map(|t| match &t.source {
                    TaskSource::Motion { score, .. } => Some(score.body.as_str()),
                    TaskSource::Run { .. } => None,
                })
                .collect();
            return Ok((vec![names.into_iter().collect::<Vec<_>>().join(", ")], Vec::new()));
        };
        let is_everywhere = |name: &String| runs.iter().all(|(_, own)| own.contains(name));
        let shared: Vec<String> = first.iter().filter(|n| is_everywhere(n)).cloned().collect();
        if shared.is_empty() {
            let each: Vec<String> =
                runs.iter().map(|(task, own)| format!("`{task}`: {}", own.join(", "))).collect();
            let message = format!("no body is in all tasks ({})", each.join("; "));
            return Err(InputError::new(path, message)
                .remedy("one worker does the shift: plan every task for the same bodies"));
        }
        let all: BTreeSet<&String> = runs.iter().flat_map(|(_, own)| own).collect();
        let left_out = all.into_iter().filter(|n| !shared.contains(n)).cloned().collect();
        Ok((shared, left_out))
    }

    fn units<'a>(&'a self, body: &str) -> Vec<OfTask<'a>> {
        let unit = |(task, t): (usize, &'a ShiftTask)| OfTask {
            task,
            body: t.source.candidate().and_then(|(_, c)| c.bodies.iter().find(|b| b.body == body)),
            source: &t.source,
            minutes: t.moving_min(),
        };
        self.tasks.iter().enumerate().map(unit).collect()
    }

    fn body(&self, name: &str) -> BodyDose {
        let units = self.units(name);
        let groups = grouped(&units);
        let spreading: Vec<_> =
            groups.iter().filter(|g| g.iter().any(|u| u.repetitions() > 1)).collect();
        let over = match spreading.as_slice() {
            [] => Units::Nothing,
            [only] => match only.first() {
                Some(u) => u.persons().map_or(Units::Repetitions(u.repetitions()), Units::People),
                None => Units::Nothing,
            },
            _ => Units::Independent,
        };
        let high_level = |m: ScoringMethod| usize::from(3 - m.level(1));
        let method = |m: ScoringMethod| {
            let count = usize::from(m.level(m.worst()) - m.level(1)) + 1;
            let at_least: Vec<Dose> = (0..count)
                .map(|l| dose(&groups.iter().map(|g| summed(g, m, l)).collect::<Vec<_>>()))
                .collect();
            let minutes = |l: usize| at_least.get(l).map_or(0.0, |d| d.mean_min);
            let levels =
                at_least.iter().zip(m.level(1)..).enumerate().map(|(l, (d, level))| LevelDose {
                    level,
                    words: m.level_words(level),
                    at_min: (d.mean_min - minutes(l + 1)).max(0.0),
                    at_least: *d,
                });
            let high =
                dose(&groups.iter().map(|g| summed(g, m, high_level(m))).collect::<Vec<_>>());
            let tasks: Vec<TaskDose> = units
                .iter()
                .map(|u| task_dose(u, m, (count, high_level(m)), high.mean_min))
                .collect();
            let most = tasks.iter().enumerate().fold(None, |most: Option<(usize, f64)>, (k, t)| {
                let minutes = t.high.mean_min;
                let is_more = most.map_or(minutes > 0.0, |(_, so_far)| minutes > so_far);
                if is_more { Some((k, minutes)) } else { most }
            });
            MethodDose { levels: levels.collect(), high, tasks, most: most.map(|(k, _)| k) }
        };
        BodyDose {
            body: name.to_owned(),
            units: over,
            methods: crate::ergonomics::PerMethod::of(method),
            worst_person: match (over, spreading.as_slice()) {
                (Units::People(of), [group]) => {
                    let rula = ScoringMethod::Rula;
                    let by_person = summed(group, rula, high_level(rula));
                    let once: f64 = groups
                        .iter()
                        .filter(|g| g.iter().all(|u| u.repetitions() <= 1))
                        .flat_map(|g| summed(g, rula, high_level(rula)))
                        .sum();
                    let sizes = group.first().map(|u| members(u, name)).unwrap_or_default();
                    worst_person(&by_person, once, of, &sizes)
                }
                _ => None,
            },
        }
    }

    /// Tasks that are not of the people of the first task with people.
    fn apart(&self, body: &str) -> Vec<TaskApart> {
        let units = self.units(body);
        let mut with_people = units.iter().filter(|u| u.repetitions() > 1);
        let Some(first) = with_people.next() else { return Vec::new() };
        let of =
            |u: &OfTask| Some(TaskApart { task: u.task, other: first.task, why: first.apart(u)? });
        with_people.filter_map(of).collect()
    }

    fn notes(&self, body: &str, time: &ShiftTime) -> Vec<ShiftNote> {
        let mut notes = Vec::new();
        let units = self.units(body);
        for (task, (t, unit)) in self.tasks.iter().zip(&units).enumerate() {
            if t.without_pause {
                notes.push(ShiftNote::WithoutPause { task });
            }
            if t.source.is_unsealed() {
                notes.push(ShiftNote::NoChecksum { task });
            }
            match &t.source {
                TaskSource::Motion { score, .. } => {
                    if !score.is_sampled {
                        let body = score.body.clone();
                        notes.push(ShiftNote::MeasuredOnce { task, body });
                    }
                }
                TaskSource::Run { result, .. } => {
                    let scored = result.setting.task.cycles_per_min;
                    let was_repeated = scored.is_some_and(|r| r > REPEATED_PER_MIN);
                    let held = result.setting.task.hold_s.is_some_and(|s| s > 60.0);
                    // How cycles without a time lie in the shift is not known.
                    let per_min = t.time_is_given.then(|| t.cycles / t.minutes);
                    match per_min {
                        Some(per_min) if per_min > REPEATED_PER_MIN && !was_repeated && !held => {
                            let scored_per_min = scored;
                            notes.push(ShiftNote::RepeatedMore { task, per_min, scored_per_min });
                        }
                        Some(per_min) if per_min <= REPEATED_PER_MIN && was_repeated => {
                            notes.push(ShiftNote::RepeatedLess { task, per_min });
                        }
                        _ => {}
                    }
                }
            }
            if let Some((_, c)) = t.source.candidate()
                && c.status != Status::Feasible
            {
                notes.push(ShiftNote::LimitsBroken { task });
            }
            if let Some(b) = unit.body {
                if b.reach_exceeded > 0.0 {
                    notes.push(ShiftNote::OutOfReach { task, share: b.reach_exceeded });
                }
                if b.extrapolation_share > BEYOND {
                    notes.push(ShiftNote::Beyond { task, share: b.extrapolation_share });
                }
            }
        }
        if units.iter().any(|u| u.repetitions() > 1 && u.persons().is_none()) {
            notes.push(ShiftNote::OnePerson);
        }
        let mut hands = self.tasks.iter().map(ShiftTask::hands);
        if let Some(first) = hands.next()
            && hands.any(|h| h != first)
        {
            notes.push(ShiftNote::OtherHands);
        }
        if time.unscored_min() > 0.0 {
            notes.push(ShiftNote::NotScored);
        }
        notes.push(ShiftNote::NoFatigue);
        notes
    }
}

fn task_dose(
    unit: &OfTask,
    method: ScoringMethod,
    (count, high_level): (usize, usize),
    all: f64,
) -> TaskDose {
    let high = dose(&[unit.minutes_at_least(method, high_level)]);
    let mean = |l: usize| {
        let minutes = unit.minutes_at_least(method, l);
        if l < count { minutes.iter().sum::<f64>() / minutes.len().max(1) as f64 } else { 0.0 }
    };
    let mut at_min = [0.0; 5];
    for (l, at) in at_min.iter_mut().enumerate().take(count) {
        *at = (mean(l) - mean(l + 1)).max(0.0);
    }
    TaskDose {
        high,
        share_of_movement: if unit.minutes > 0.0 { high.mean_min / unit.minutes } else { 0.0 },
        share_of_high: if all > 0.0 { high.mean_min / all } else { 0.0 },
        at_min,
    }
}

/// Sizes of the people for whom a body stands.
fn members(unit: &OfTask, body: &str) -> Vec<BodySize> {
    let TaskSource::Run { result, .. } = unit.source else { return Vec::new() };
    let found = result.setting.bodies.iter().find(|b| b.name == body);
    found.map(|b| b.members.clone()).unwrap_or_default()
}

fn worst_person(
    by_person: &[f64],
    once: f64,
    of: usize,
    sizes: &[BodySize],
) -> Option<WorstPerson> {
    let mut worst: Option<(usize, f64)> = None;
    for (k, minutes) in by_person.iter().enumerate() {
        if worst.is_none_or(|(_, so_far)| *minutes > so_far) {
            worst = Some((k, *minutes));
        }
    }
    let (k, minutes) = worst?;
    let size = (sizes.len() == of).then(|| sizes.get(k).copied()).flatten();
    Some(WorstPerson { person: k + 1, of, size, high_min: minutes + once })
}

fn facts(task: &ShiftTask) -> TaskFacts {
    let (path, source, kind, load_kg, caveat) = match &task.source {
        TaskSource::Run { result, candidate } => (
            result.candidates.get(*candidate).map(|c| c.id.clone()),
            result.setting.name.clone(),
            TaskKind::Path,
            Some(result.setting.task.load_kg),
            result.verdict.caveat,
        ),
        TaskSource::Motion { score, .. } => {
            let kind = if score.is_sampled { TaskKind::Sampled } else { TaskKind::Motion };
            (None, score.source.clone(), kind, None, None)
        }
    };
    TaskFacts {
        name: task.name.clone(),
        result: task.result.clone(),
        path,
        source,
        kind,
        hands: task.hands(),
        load_kg,
        duration_s: task.duration_s,
        cycles: task.cycles,
        minutes: task.minutes,
        moving_min: task.moving_min(),
        caveat,
    }
}
