//! What this process has read: no output of the same call may land on it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

type Names = Mutex<BTreeSet<PathBuf>>;

static READ: Names = Mutex::new(BTreeSet::new());
/// Every name that was asked for, whether there was a file or not.
static NAMED: Names = Mutex::new(BTreeSet::new());

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
        open(&READ).insert(whole);
    }
}

/// The files that were asked for since the last call, also those that are not there: what depends on
/// them may be another when they change. Links are not followed.
pub fn take_named_inputs() -> Vec<PathBuf> {
    std::mem::take(&mut *open(&NAMED)).into_iter().collect()
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
