//! The file that names several people and their recordings.

use crate::files::{InputError, parse_toml, read_text};
use crate::human::{Body, Side};
use crate::recording::{Map, read_map};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// Version of the format.
pub const PEOPLE_SCHEMA: &str = "ergopath/people/1";
/// Most recordings of one person: more is a slip in a pattern.
const MOST_RECORDINGS: usize = 2000;

/// People with the paths of their recordings.
#[derive(Debug, Clone)]
pub struct PeopleFile {
    /// Where they were named.
    pub path: PathBuf,
    /// In the order of the file.
    pub(super) people: Vec<Entry>,
}

/// One person of the file.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub name: String,
    pub recordings: Vec<PathBuf>,
    /// As given; none where it is to be sized by the recordings.
    pub body: Option<Body>,
    pub side: Side,
    /// What makes markers segments.
    pub map: Option<Map>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Typed {
    schema: Spanned<String>,
    #[serde(default)]
    person: Vec<TypedPerson>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TypedPerson {
    name: Spanned<String>,
    recordings: Vec<Spanned<String>>,
    body: Option<Spanned<String>>,
    #[serde(default)]
    side: Option<Side>,
    map: Option<Spanned<String>>,
}

impl PeopleFile {
    /// How many people.
    pub fn count(&self) -> usize {
        self.people.len()
    }

    /// Name, number of recordings, side and body (none: sized by the recordings) of each.
    pub fn people(&self) -> impl Iterator<Item = (&str, usize, Side, Option<&Body>)> {
        self.people.iter().map(|p| (&*p.name, p.recordings.len(), p.side, p.body.as_ref()))
    }
}

/// Reads a people file: bodies are loaded, patterns of recordings become sorted lists of files.
///
/// # Errors
/// Where the file is no people file, a name is twice there, or a pattern finds nothing.
pub fn read_people_file(path: &Path) -> Result<PeopleFile, InputError> {
    let text = read_text(path)?;
    let typed: Typed = parse_toml(path, &text)?;
    let fault = |message: String, at: &Spanned<String>, remedy: &str| {
        InputError::new(path, message).at(&text, at.span()).remedy(remedy.to_owned())
    };
    if typed.schema.as_ref() != PEOPLE_SCHEMA {
        let message = format!("schema `{}` is not `{PEOPLE_SCHEMA}`", typed.schema.as_ref());
        return Err(fault(message, &typed.schema, "give the version of this format"));
    }
    if typed.person.is_empty() {
        return Err(InputError::new(path, "names nobody")
            .remedy("add a [[person]] with a name and recordings"));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut people: Vec<Entry> = Vec::new();
    for person in &typed.person {
        let name = person.name.as_ref();
        if name.trim().is_empty() {
            return Err(fault("a person without a name".into(), &person.name, "give a code"));
        }
        if people.iter().any(|p| p.name == *name) {
            let message = format!("person `{name}` is there twice");
            return Err(fault(message, &person.name, "put all recordings of a person together"));
        }
        let mut recordings = Vec::new();
        for pattern in &person.recordings {
            let found = matches(folder, pattern.as_ref())
                .map_err(|e| fault(format!("pattern {e}"), pattern, "use * and ? and [a-z]"))?;
            if found.is_empty() {
                let message = format!("`{}` finds no file", pattern.as_ref());
                return Err(fault(message, pattern, "paths are relative to this file"));
            }
            recordings.extend(found);
        }
        recordings.sort();
        recordings.dedup();
        if recordings.is_empty() || recordings.len() > MOST_RECORDINGS {
            let message = format!("person `{name}` has {} recordings", recordings.len());
            return Err(fault(message, &person.name, "give from one to 2000"));
        }
        let body = match &person.body {
            Some(body) => Some(Body::load(body.as_ref(), folder)?),
            None => None,
        };
        let side = person.side.unwrap_or(Side::Right);
        let map = person.map.as_ref().map(|map| {
            read_map(&folder.join(map.as_ref()))
                .map_err(|e| e.named_in(path, "map", &text, map.span()))
        });
        people.push(Entry { name: name.clone(), recordings, body, side, map: map.transpose()? });
    }
    Ok(PeopleFile { path: path.to_owned(), people })
}

/// Files that a pattern finds, or why it is none.
fn matches(folder: &Path, pattern: &str) -> Result<Vec<PathBuf>, String> {
    // What is special in the folder's own name is not meant as a pattern.
    let full = if Path::new(pattern).is_absolute() {
        pattern.to_owned()
    } else {
        let folder = glob::Pattern::escape(&folder.to_string_lossy());
        if folder.is_empty() { pattern.to_owned() } else { format!("{folder}/{pattern}") }
    };
    let paths = glob::glob(&full).map_err(|e| e.to_string())?;
    paths.collect::<Result<Vec<_>, _>>().map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<PeopleFile, String> {
        let folder = tempfile::tempdir().unwrap();
        // A name that would be a pattern.
        let inner = folder.path().join("day [1]");
        std::fs::create_dir_all(inner.join("anna")).unwrap();
        for name in ["b.mvnx", "a.mvnx", "c.amc"] {
            std::fs::write(inner.join("anna").join(name), "x").unwrap();
        }
        let path = inner.join("people.toml");
        std::fs::write(&path, text).unwrap();
        read_people_file(&path).map_err(|e| format!("{:?}", miette::Report::new(e)))
    }

    const ANNA: &str =
        "[[person]]\nname = \"anna\"\nrecordings = [\"anna/*.mvnx\", \"anna/a.mvnx\"]\n";

    fn with(people: &str) -> String {
        format!("schema = \"{PEOPLE_SCHEMA}\"\n{people}")
    }

    #[test]
    fn patterns_become_sorted_files() {
        let file = read(&with(ANNA)).unwrap();
        let names: Vec<_> =
            file.people[0].recordings.iter().map(|p| p.file_name().unwrap().to_owned()).collect();
        assert_eq!(names, ["a.mvnx", "b.mvnx"]);
        assert_eq!((file.count(), file.people[0].side), (1, Side::Right));
        let left = ANNA.replace("name", "side = \"left\"\nbody = \"female_p05\"\nname");
        let file = read(&with(&left)).unwrap();
        assert_eq!(file.people[0].side, Side::Left);
        assert_eq!(file.people[0].body.as_ref().unwrap().name, "female_p05");
    }

    #[test]
    fn faults_are_named() {
        let said = |text: String| read(&text).unwrap_err();
        assert!(said(with("")).contains("names nobody"));
        assert!(said(with(&format!("{ANNA}{ANNA}"))).contains("`anna` is there twice"));
        assert!(
            said(with(&ANNA.replace("*.mvnx", "*.bvh"))).contains("`anna/*.bvh` finds no file")
        );
        assert!(said(with(&ANNA.replace("*.mvnx", "[a.mvnx"))).contains("pattern"));
        assert!(said(with(&ANNA.replace("\"anna\"", "\" \""))).contains("without a name"));
        assert!(
            said(ANNA.replace("[[", "schema = \"ergopath/people/9\"\n[[")).contains("people/1")
        );
        assert!(said(with(&ANNA.replace("name", "nome"))).contains("nome"));
    }
}
