//! Who teaches and who tests: the paper's three experiments as training sets.

use crate::files::InputError;
use crate::human::{Body, Side};
use crate::training::Trial;
use serde::Serialize;

/// Fewest repetitions of a task of which half teach and half test.
const FEWEST_REPETITIONS: usize = 4;

/// One of the paper's experiments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PaperExperiment {
    /// The same primitive: repetitions 1 to 5 teach, 6 to 10 test.
    Exp1,
    /// Random movements teach, the primitive tests.
    Exp2,
    /// Another body, seated.
    Exp3,
}

impl PaperExperiment {
    /// Its name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exp1 => "exp1",
            Self::Exp2 => "exp2",
            Self::Exp3 => "exp3",
        }
    }
}

/// Repetitions of one movement.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// Its name, the same for all performers.
    pub name: String,
    /// Whether the movement is always the same; random ones only teach.
    pub is_primitive: bool,
    /// In the order in which they were done.
    pub repetitions: Vec<Trial>,
}

/// Somebody who moved.
#[derive(Debug, Clone)]
pub struct Performer {
    /// Code of the person, or number and kind of a simulated one.
    pub name: String,
    /// Their body.
    pub body: Body,
    /// The hand that leads.
    pub side: Side,
    /// Whether they sat.
    pub is_seated: bool,
    /// What they did.
    pub tasks: Vec<Task>,
}

/// What teaches and what tests.
#[derive(Debug, Clone)]
pub struct TrainingSet {
    /// Who is predicted.
    pub who: String,
    /// What they do meanwhile.
    pub task: String,
    /// Their body, in which all postures of the set are taken.
    pub body: Body,
    /// The hand that leads.
    pub side: Side,
    /// Whether they sit.
    pub is_seated: bool,
    /// Whether others teach instead of the person's own movements.
    pub is_by_others: bool,
    /// Movements that teach, by person.
    pub train: Vec<Vec<Trial>>,
    /// Movements that test.
    pub test: Vec<Trial>,
}

/// The sets of an experiment, in the order of performers and tasks. `by_others`: whether exp3 is taught by the
/// other performers instead of the person's own first half.
///
/// # Errors
/// Where nobody did what the experiment asks for.
pub fn training_sets(
    experiment: PaperExperiment,
    performers: &[Performer],
    by_others: bool,
) -> Result<Vec<TrainingSet>, InputError> {
    let found: Vec<TrainingSet> = performers
        .iter()
        .flat_map(|own| own.tasks.iter().filter(|t| t.is_primitive).map(move |task| (own, task)))
        .filter_map(|(own, task)| {
            let (train, test) = match experiment {
                PaperExperiment::Exp2 => (vec![other_tasks(own, task)], second_half(task)),
                PaperExperiment::Exp3 if by_others => {
                    (others(performers, own, task), task.repetitions.clone())
                }
                PaperExperiment::Exp1 | PaperExperiment::Exp3 => halves(task)?,
            };
            let teaches = train.iter().any(|t| !t.is_empty());
            (teaches && !test.is_empty()).then(|| TrainingSet {
                who: own.name.clone(),
                task: task.name.clone(),
                body: own.body.clone(),
                side: own.side,
                is_seated: own.is_seated,
                is_by_others: by_others && experiment == PaperExperiment::Exp3,
                train,
                test,
            })
        })
        .collect();
    if found.is_empty() { Err(nobody(experiment, by_others)) } else { Ok(found) }
}

fn nobody(experiment: PaperExperiment, by_others: bool) -> InputError {
    let (message, remedy) = match experiment {
        PaperExperiment::Exp2 => (
            "nobody did two tasks".to_owned(),
            "give recordings of several tasks of one person; a task is what file names share but for \
             numbers and the person's name",
        ),
        PaperExperiment::Exp3 if by_others => (
            "no two people did the same task".to_owned(),
            "give people whose files are named alike but for numbers and the person's name",
        ),
        _ => (
            format!("nobody repeated a task {FEWEST_REPETITIONS} times"),
            "give more repetitions; a task is what file names share but for numbers and the person's name",
        ),
    };
    InputError::new("recordings", message).remedy(remedy)
}

type Halves = (Vec<Vec<Trial>>, Vec<Trial>);

/// Of an odd number one more teaches.
fn middle(task: &Task) -> usize {
    task.repetitions.len().div_ceil(2)
}

fn halves(task: &Task) -> Option<Halves> {
    let (first, second) = task.repetitions.split_at(middle(task));
    let is_enough = task.repetitions.len() >= FEWEST_REPETITIONS;
    is_enough.then(|| (vec![first.to_vec()], second.to_vec()))
}

/// What exp1 tests on, so that both can be compared.
fn second_half(task: &Task) -> Vec<Trial> {
    task.repetitions[middle(task).min(task.repetitions.len().saturating_sub(1))..].to_vec()
}

/// Where random movements were done these teach, as in the paper; else all other tasks.
fn other_tasks(own: &Performer, task: &Task) -> Vec<Trial> {
    let has_random = own.tasks.iter().any(|t| !t.is_primitive);
    let teaches = |t: &&Task| t.name != task.name && !(has_random && t.is_primitive);
    own.tasks.iter().filter(teaches).flat_map(|t| t.repetitions.clone()).collect()
}

fn others(performers: &[Performer], own: &Performer, task: &Task) -> Vec<Vec<Trial>> {
    let alike = |p: &&Performer| p.name != own.name && p.side == own.side;
    let same = |p: &Performer| -> Vec<Trial> {
        let tasks = p.tasks.iter().filter(|t| t.name == task.name);
        tasks.flat_map(|t| t.repetitions.clone()).collect()
    };
    performers.iter().filter(alike).map(same).filter(|t| !t.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn trial(name: &str) -> Trial {
        Trial {
            source: name.to_owned(),
            rate_hz: 30.0,
            q: vec![vec![0.0; 24]; 3],
            qdot: vec![vec![0.0; 24]; 3],
            stepping: Vec::new(),
            turn: Vec::new(),
        }
    }

    fn task(name: &str, is_primitive: bool, count: usize) -> Task {
        let repetitions = (1..=count).map(|i| trial(&format!("{name} {i}"))).collect();
        Task { name: name.to_owned(), is_primitive, repetitions }
    }

    fn person(name: &str, tasks: Vec<Task>) -> Performer {
        let body = Body::load("male_p50", Path::new(".")).unwrap();
        Performer { name: name.to_owned(), body, side: Side::Right, is_seated: false, tasks }
    }

    fn names(trials: &[Trial]) -> Vec<&str> {
        trials.iter().map(|t| t.source.as_str()).collect()
    }

    #[test]
    fn the_first_half_of_a_task_teaches_and_the_second_tests() {
        let people = [person("a", vec![task("lift", true, 5), task("wave", true, 3)])];
        let sets = training_sets(PaperExperiment::Exp1, &people, false).unwrap();
        assert_eq!(sets.len(), 1, "three repetitions are too few");
        assert_eq!(names(&sets[0].train[0]), ["lift 1", "lift 2", "lift 3"]);
        assert_eq!(names(&sets[0].test), ["lift 4", "lift 5"]);
        let few = [person("a", vec![task("wave", true, 3)])];
        let refused = training_sets(PaperExperiment::Exp1, &few, false).unwrap_err();
        assert!(refused.to_string().contains("nobody repeated"), "{refused}");
    }

    #[test]
    fn other_movements_teach_the_second_half() {
        let tasks = vec![task("lift", true, 4), task("wave", true, 1), task("dance", true, 2)];
        let sets = training_sets(PaperExperiment::Exp2, &[person("a", tasks)], false).unwrap();
        assert_eq!(sets.len(), 3);
        assert_eq!(names(&sets[0].train[0]), ["wave 1", "dance 1", "dance 2"]);
        assert_eq!(names(&sets[0].test), ["lift 3", "lift 4"]);
        assert_eq!(names(&sets[1].test), ["wave 1"]);
        // Random movements are what teaches, where there are some, and are never tested.
        let tasks = vec![task("lift", true, 4), task("wave", true, 1), task("random", false, 2)];
        let sets = training_sets(PaperExperiment::Exp2, &[person("a", tasks)], false).unwrap();
        assert_eq!(sets.len(), 2);
        assert_eq!(names(&sets[0].train[0]), ["random 1", "random 2"]);
        let one = [person("a", vec![task("lift", true, 4)])];
        assert!(training_sets(PaperExperiment::Exp2, &one, false).is_err());
    }

    #[test]
    fn others_of_the_same_hand_and_task_teach() {
        let mut left = person("c", vec![task("lift", true, 2)]);
        left.side = Side::Left;
        let people = [
            person("a", vec![task("lift", true, 2), task("wave", true, 2)]),
            person("b", vec![task("lift", true, 1)]),
            left,
        ];
        let sets = training_sets(PaperExperiment::Exp3, &people, true).unwrap();
        let found: Vec<_> = sets.iter().map(|s| (s.who.as_str(), s.train.len())).collect();
        assert_eq!(found, [("a", 1), ("b", 1)]);
        assert_eq!(names(&sets[0].train[0]), ["lift 1"]);
        assert_eq!(names(&sets[0].test), ["lift 1", "lift 2"]);
        assert!(training_sets(PaperExperiment::Exp3, &people[..1], true).is_err());
    }
}
