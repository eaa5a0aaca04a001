//! What this process has read: no output of the same call may land on it.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

type Names = Mutex<BTreeSet<PathBuf>>;

static READ: Names = Mutex::new(BTreeSet::new());
/// Every name that was asked for, whether there was a file or not.
static NAMED: Names = Mutex::new(BTreeSet::new());

thread_local! {
    /// What this thread reads while it is asked; none while it is not.
    static NOTED: RefCell<Option<BTreeSet<PathBuf>>> = const { RefCell::new(None) };
}

fn open(names: &'static Names) -> MutexGuard<'static, BTreeSet<PathBuf>> {
    names.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Notes a file that is read. The readers of this module do so themselves; whoever opens a file in
/// another way says so here.
pub fn note_input(path: &Path) {
    if let Ok(named) = std::path::absolute(path) {
        open(&NAMED).insert(named);
    }
    if let Ok(whole) = path.canonicalize()
        && whole.is_file()
    {
        NOTED.with_borrow_mut(|noted| noted.as_mut().map(|n| n.insert(whole.clone())));
        open(&READ).insert(whole);
    }
}

/// The files that were asked for since the last call, also those that are not there: what depends on
/// them may be another when they change. Links are not followed.
pub fn take_named_inputs() -> Vec<PathBuf> {
    std::mem::take(&mut *open(&NAMED)).into_iter().collect()
}

/// Does some work, and tells which files this thread has read in it: whole paths without links. What other
/// threads read for it is not told.
pub fn files_read<T>(work: impl FnOnce() -> T) -> (T, BTreeSet<PathBuf>) {
    let before = NOTED.replace(Some(BTreeSet::new()));
    let done = work();
    (done, NOTED.replace(before).unwrap_or_default())
}

/// Whether a file is one that was read, under whichever of its names.
pub(super) fn is_input(path: &Path) -> bool {
    let Ok(whole) = path.canonicalize() else { return false };
    let inputs = open(&READ);
    inputs.contains(&whole) || inputs.iter().any(|input| is_same_file(input, &whole))
}

/// Whether two names are hard links to one file.
#[cfg(unix)]
pub(super) fn is_same_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (Ok(a), Ok(b)) = (a.metadata(), b.metadata()) else { return false };
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
pub(super) fn is_same_file(a: &Path, b: &Path) -> bool {
    a.canonicalize().ok() == b.canonicalize().ok() && a.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_thread_reads_is_told() {
        let room = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|n| room.path().canonicalize().unwrap().join(n));
        for file in [&a, &b] {
            std::fs::write(file, "x").unwrap();
        }
        note_input(&a);
        let (inner, files) = files_read(|| {
            note_input(&b);
            std::thread::scope(|s| s.spawn(|| note_input(&a)).join().unwrap());
            files_read(|| note_input(&a)).1
        });
        assert_eq!((inner.len(), files), (1, [b].into()));
    }

    #[test]
    fn an_input_is_known_by_all_its_names() {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("a.toml");
        std::fs::write(&file, "x").unwrap();
        assert!(!is_input(&file));
        note_input(&file);
        assert!(is_input(&file) && is_input(&room.path().join("./a.toml")));
        let other = room.path().join("b.toml");
        std::fs::write(&other, "x").unwrap();
        assert!(!is_input(&other));
        #[cfg(unix)]
        {
            let (hard, soft) = (room.path().join("hard"), room.path().join("soft"));
            std::fs::hard_link(&file, &hard).unwrap();
            std::os::unix::fs::symlink(&file, &soft).unwrap();
            assert!(is_input(&hard) && is_input(&soft));
        }
    }
}
