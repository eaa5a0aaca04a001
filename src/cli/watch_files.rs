//! Which of some files were saved. They are looked at by name, again and again: so it does not matter
//! whether an editor writes into a file, renames another over it, or deletes it and makes it anew, nor
//! whether the folder is one of this machine.

use crate::files::sha256_hex;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How long files must stay the same before a save counts as finished, and how long a file may be gone.
const SETTLED: Duration = Duration::from_millis(150);
const GONE: Duration = Duration::from_millis(800);

/// By what a change is noticed without reading the file; none where there is no file.
type Stamp = Option<(Option<SystemTime>, u64, u64)>;

/// A file as it was when it was last looked into.
#[derive(Debug)]
struct Known {
    stamp: Stamp,
    /// SHA-256; none where it cannot be read.
    content: Option<String>,
}

/// The files.
#[derive(Debug, Default)]
pub(super) struct WatchedFiles {
    files: BTreeMap<PathBuf, Known>,
    /// A change that has not settled: since when the files are so, and how.
    moving: Option<(Instant, Vec<Stamp>)>,
}

impl WatchedFiles {
    /// More files, as they are now; those that are watched already stay as they were.
    pub(super) fn add(&mut self, files: impl IntoIterator<Item = PathBuf>) {
        for file in files {
            let file = std::path::absolute(&file).unwrap_or(file);
            self.files.entry(file).or_insert_with_key(|f| Known::of(f));
        }
    }

    /// Whether the content of a file has changed since the last time that this was true, and has settled.
    pub(super) fn poll(&mut self, now: Instant) -> bool {
        let stamps: Vec<Stamp> = self.files.keys().map(|f| stamp(f)).collect();
        if self.files.values().map(|k| &k.stamp).eq(&stamps) {
            self.moving = None;
            return false;
        }
        let since = match &self.moving {
            Some((since, before)) if *before == stamps => *since,
            _ => {
                self.moving = Some((now, stamps));
                return false;
            }
        };
        let mut pairs = self.files.values().zip(&stamps);
        let is_gone = pairs.any(|(known, now)| known.stamp.is_some() && now.is_none());
        if now.duration_since(since) < if is_gone { GONE } else { SETTLED } {
            return false;
        }
        self.moving = None;
        let mut is_saved = false;
        for ((file, known), now) in self.files.iter_mut().zip(stamps) {
            if known.stamp != now {
                let new = Known::of(file);
                is_saved |= new.content != known.content;
                *known = new;
            }
        }
        is_saved
    }
}

impl Known {
    fn of(file: &Path) -> Self {
        // The stamp first: what is written in between is seen at the next look.
        let stamp = stamp(file);
        let content = stamp.and_then(|_| std::fs::read(file).ok()).map(|b| sha256_hex(&b));
        Self { stamp, content }
    }
}

fn stamp(file: &Path) -> Stamp {
    let about = file.metadata().ok().filter(std::fs::Metadata::is_file)?;
    Some((about.modified().ok(), about.len(), inode(&about)))
}

/// Tells a file that was put in the place of another.
#[cfg(unix)]
fn inode(about: &std::fs::Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::ino(about)
}

#[cfg(not(unix))]
fn inode(_: &std::fs::Metadata) -> u64 {
    0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polls as time goes by, and says how often something was saved.
    fn saves(files: &mut WatchedFiles, from: Instant, for_ms: u64) -> usize {
        let times = (0..=for_ms).step_by(50).map(|ms| from + Duration::from_millis(ms));
        times.filter(|now| files.poll(*now)).count()
    }

    #[test]
    fn a_save_is_seen_however_it_is_made_and_once() {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("cell.toml");
        std::fs::write(&file, "a = 1").unwrap();
        let mut files = WatchedFiles::default();
        files.add([file.clone()]);
        let start = Instant::now();
        assert_eq!(saves(&mut files, start, 2000), 0);
        // In place.
        std::fs::write(&file, "a = 22").unwrap();
        assert_eq!(saves(&mut files, start, 2000), 1);
        // By renaming, with the same length.
        let new = room.path().join("new");
        std::fs::write(&new, "a = 33").unwrap();
        std::fs::rename(&new, &file).unwrap();
        assert_eq!(saves(&mut files, start, 2000), 1);
        // Gone for a moment, then there anew.
        std::fs::remove_file(&file).unwrap();
        assert_eq!(saves(&mut files, start, 500), 0);
        std::fs::write(&file, "a = 44").unwrap();
        assert_eq!(saves(&mut files, start, 2000), 1);
        // Saved without a change.
        std::fs::write(&new, "a = 44").unwrap();
        std::fs::rename(&new, &file).unwrap();
        assert_eq!(saves(&mut files, start, 2000), 0);
        // Gone for good.
        std::fs::remove_file(&file).unwrap();
        assert_eq!(saves(&mut files, start, 2000), 1);
        assert_eq!(saves(&mut files, start, 2000), 0);
    }

    #[test]
    fn a_file_that_is_missing_is_waited_for() {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("today.csv");
        let mut files = WatchedFiles::default();
        files.add([file.clone()]);
        assert_eq!(saves(&mut files, Instant::now(), 2000), 0);
        std::fs::write(&file, "").unwrap();
        assert_eq!(saves(&mut files, Instant::now(), 2000), 1);
    }
}
