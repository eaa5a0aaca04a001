//! The list of files in an output folder that ergopath wrote: the only ones that it may replace.

use super::error::InputError;
use super::text::sha256_hex;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Name of the list in its folder.
pub(super) const MARKER: &str = ".ergopath-output.json";
/// Stands in a folder while its files are being replaced, and after a run that was killed then.
pub(super) const INCOMPLETE: &str = "INCOMPLETE.txt";
pub(super) const INCOMPLETE_TEXT: &str = "ergopath was replacing the files of this folder. If it no longer \
    runs, it was stopped in the middle:\nsome files are of the old run and some of the new one. Run the same \
    command again.\n";
/// How working folders begin that are never left but by a kill.
pub(super) const STAGING: &str = ".ergopath-";
const SCHEMA: &str = "ergopath/output/1";
const ABOUT: &str = "ergopath wrote these files (SHA-256 of each) and may replace them; whatever else lies \
                     in this folder it leaves alone";

/// Files by name (relative, with `/`), each with the SHA-256 of its bytes.
pub(super) type Listed = BTreeMap<String, String>;

/// What the list says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Marker {
    schema: String,
    about: String,
    pub files: Listed,
    /// Only while files are replaced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coming: Option<Coming>,
}

/// Files on their way into the folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Coming {
    /// Working folder, beside the list. As long as no file is named nothing was moved yet.
    pub staging: String,
    pub files: Listed,
}

impl Marker {
    pub(super) fn new(files: Listed) -> Self {
        Self { schema: SCHEMA.to_owned(), about: ABOUT.to_owned(), files, coming: None }
    }

    /// As bytes of the file.
    pub(super) fn bytes(&self) -> Result<Vec<u8>, InputError> {
        let text = serde_json::to_string_pretty(self);
        Ok((text.map_err(|e| InputError::fault(MARKER, e.to_string()))? + "\n").into_bytes())
    }

    /// The list of a folder, if it has one. A list that was edited or that names anything outside the
    /// folder is refused: it is followed nowhere.
    pub(super) fn read(folder: &Path) -> Result<Option<Self>, InputError> {
        let file = folder.join(MARKER);
        let broken = |what: &str| {
            InputError::new(&file, format!("{what}, so it cannot be told what ergopath wrote here"))
                .remedy("choose another folder, or an empty one")
        };
        match file.symlink_metadata() {
            Err(_) => return Ok(None),
            Ok(kind) if !kind.is_file() => return Err(broken("is not a plain file")),
            Ok(_) => {}
        }
        let text = std::fs::read(&file).map_err(|e| broken(&format!("cannot be read ({e})")))?;
        let marker: Self = serde_json::from_slice(&text).map_err(|_| broken("was edited"))?;
        if marker.schema != SCHEMA {
            return Err(broken(&format!("has the schema `{}`", marker.schema)));
        }
        let coming = marker.coming.iter();
        for name in marker.files.keys().chain(coming.clone().flat_map(|c| c.files.keys())) {
            if !is_inside(name) {
                return Err(broken(&format!("lists `{name}`, which is no file of this folder")));
            }
        }
        for staging in coming.map(|c| &c.staging) {
            if !staging.starts_with(STAGING) || staging == MARKER || staging.contains(['/', '\\']) {
                return Err(broken(&format!("names `{staging}` as a working folder")));
            }
        }
        Ok(Some(marker))
    }

    /// All names that may be ours, with the hashes that each may have.
    pub(super) fn names(&self) -> BTreeMap<&str, Vec<&str>> {
        let mut all: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        let coming = self.coming.iter().flat_map(|c| &c.files);
        for (name, hash) in self.files.iter().chain(coming) {
            all.entry(name).or_default().push(hash);
        }
        all
    }
}

/// Hashes of files.
pub(super) fn listed(files: &BTreeMap<String, Vec<u8>>) -> Listed {
    files.iter().map(|(name, bytes)| (name.clone(), sha256_hex(bytes))).collect()
}

/// Whether a name stays inside a folder and is not the list itself.
pub(super) fn is_inside(name: &str) -> bool {
    let parts: Vec<Component> = Path::new(name).components().collect();
    !name.is_empty()
        && !name.contains(['\\', ':'])
        && ![MARKER, INCOMPLETE].iter().any(|own| name.eq_ignore_ascii_case(own))
        && parts.iter().all(|p| matches!(p, Component::Normal(_)))
}

/// What lies in a folder under a name.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    Nothing,
    /// A plain file, by the SHA-256 of its bytes.
    File(String),
    /// A link, a folder or a device, there or on the way there.
    Other(PathBuf),
}

/// Looks without following links.
pub(super) fn look(folder: &Path, name: &str) -> io::Result<Found> {
    let mut at = folder.to_owned();
    let parts: Vec<Component> = Path::new(name).components().collect();
    for (i, part) in parts.iter().enumerate() {
        at.push(part);
        let is_last = i + 1 == parts.len();
        match at.symlink_metadata() {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Found::Nothing),
            Err(e) => return Err(e),
            Ok(kind) if !is_last && kind.is_dir() => {}
            Ok(kind) if is_last && kind.is_file() => {
                return Ok(Found::File(sha256_hex(&std::fs::read(&at)?)));
            }
            Ok(_) => break,
        }
    }
    Ok(Found::Other(at))
}

/// An error where the files of a folder may be of two runs, because a run was killed while it
/// replaced them.
pub fn refuse_incomplete(folder: &Path) -> Result<(), InputError> {
    match Marker::read(folder) {
        Ok(Some(marker)) if marker.coming.is_some() => Err(InputError::new(
            folder,
            "is incomplete: a run was stopped while it replaced these files",
        )
        .remedy("run the command that wrote this folder again")),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_leads_out_of_the_folder() {
        for good in ["a.csv", "paths/1.csv", "deep/er/x.png"] {
            assert!(is_inside(good), "{good}");
        }
        for bad in ["", "/etc/passwd", "../a", "a/../../b", "./a/..", "c:\\x", MARKER] {
            assert!(!is_inside(bad), "{bad}");
        }
    }

    #[test]
    fn an_edited_list_is_refused() {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join(MARKER);
        assert_eq!(Marker::read(room.path()).unwrap(), None);
        let marker = Marker::new([("a.csv".to_owned(), sha256_hex(b"a"))].into());
        let good = String::from_utf8(marker.bytes().unwrap()).unwrap();
        std::fs::write(&file, &good).unwrap();
        assert_eq!(Marker::read(room.path()).unwrap(), Some(marker));
        let staging =
            "\"about\": \"\", \"coming\": {\"files\": {}, \"staging\": \"../x\"}, \"about2\"";
        for (from, to) in
            [("a.csv", "../a.csv"), ("output/1", "output/9"), ("{", "["), ("\"about\"", staging)]
        {
            std::fs::write(&file, good.replacen(from, to, 1)).unwrap();
            assert!(Marker::read(room.path()).is_err(), "{to}");
        }
    }
}
