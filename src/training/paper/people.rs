//! Recorded people as performers: a task is what the names of recordings share.

use super::sets::{Performer, Task};
use crate::files::InputError;
use crate::training::people::{PeopleFile, read_sources};
use crate::training::{Source, Trial};

/// Performers of a people file, with the recordings of all. Recordings whose names differ only in numbers, and by
/// the person's name, are repetitions of one task, in the order of their names.
///
/// # Errors
/// Where a recording cannot be read or fitted, or is there twice.
pub fn performers(file: &PeopleFile) -> Result<(Vec<Performer>, Vec<Source>), InputError> {
    let mut all = Vec::new();
    let mut performers = Vec::new();
    for own in read_sources(file)? {
        let mut tasks: Vec<Task> = Vec::new();
        for source in &own.sources {
            let name = task_name(&source.name, &own.name);
            let trials: Vec<Trial> = source.trials.clone();
            match tasks.iter_mut().find(|t| t.name == name) {
                Some(task) => task.repetitions.extend(trials),
                None => tasks.push(Task { name, is_primitive: true, repetitions: trials }),
            }
        }
        // Whether they sat is not said; it does not change what is learned.
        let is_seated = false;
        performers.push(Performer {
            name: own.name,
            body: own.body,
            side: own.side,
            is_seated,
            tasks,
        });
        all.extend(own.sources);
    }
    Ok((performers, all))
}

/// What is left of a file's name without its ending, numbers and the person's name.
fn task_name(file: &str, person: &str) -> String {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let person = person.to_lowercase();
    let is_kept = |word: &&str| {
        !word.is_empty()
            && word.to_lowercase() != person
            && !word.chars().all(|c| c.is_ascii_digit())
    };
    let words = stem.split(|c: char| !c.is_alphanumeric()).filter(is_kept);
    let bare = |word: &str| word.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned();
    let name = words.map(bare).collect::<Vec<_>>().join(" ");
    if name.is_empty() { "movement".to_owned() } else { name }
}

#[cfg(test)]
mod tests {
    use super::task_name;

    #[test]
    fn numbers_and_the_persons_name_do_not_make_a_task() {
        for (file, person, task) in [
            ("HDM_bd_depositFloorR_003_120.amc", "bd", "HDM depositFloorR"),
            ("HDM_BK_depositFloorR_012_120.amc", "bk", "HDM depositFloorR"),
            ("lift12.mvnx", "anna", "lift"),
            ("anna-lift box-2.bvh", "Anna", "lift box"),
            ("2024_01.c3d", "x", "movement"),
            ("handover_folder", "giver", "handover folder"),
        ] {
            assert_eq!(task_name(file, person), task, "{file}");
        }
    }
}
