//! Working folders of runs that were killed, where many runs write beside each other.
//!
//! A folder that is new is made under a working name and then renamed, which takes a moment. A run that is killed
//! in that moment leaves it, and nothing names it: what goes is a folder with such a name in which nothing has
//! changed for an hour.

use super::marker::STAGING;
use std::fs::{self, Metadata};
use std::path::Path;
use std::time::{Duration, SystemTime};

/// No run takes that long to write one folder.
const DEAD_AFTER: Duration = Duration::from_hours(1);
/// Letters and digits that make the names of working folders differ.
const RANDOM: usize = 6;

/// Takes away what killed runs have left in a folder in which ergopath alone makes folders. What cannot be read or
/// taken away stays: it is in nobody's way.
pub fn sweep_killed(parent: &Path) {
    let Ok(entries) = parent.read_dir() else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        if name.to_str().is_some_and(is_working_name) && is_dead(&entry.path()) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

fn is_working_name(name: &str) -> bool {
    let rest = name.strip_prefix(STAGING);
    rest.is_some_and(|r| r.len() == RANDOM && r.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// A plain folder that holds nothing but plain files and folders, all of them old.
fn is_dead(folder: &Path) -> bool {
    let is_old = |found: &Metadata| {
        let changed = found.modified().ok();
        let age = changed.and_then(|m| SystemTime::now().duration_since(m).ok());
        age.is_some_and(|a| a > DEAD_AFTER)
    };
    let Ok(found) = folder.symlink_metadata() else { return false };
    let Ok(entries) = folder.read_dir() else { return false };
    let is_old_entry = |entry: std::io::Result<fs::DirEntry>| {
        let Ok(entry) = entry else { return false };
        match entry.metadata() {
            Ok(found) if found.is_dir() => is_dead(&entry.path()),
            Ok(found) => found.is_file() && is_old(&found),
            Err(_) => false,
        }
    };
    found.is_dir() && is_old(&found) && entries.into_iter().all(is_old_entry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;

    #[test]
    fn only_old_working_folders_go() {
        let room = tempfile::tempdir().unwrap();
        let long_ago = SystemTime::now() - 2 * DEAD_AFTER;
        let make = |name: &str, is_old: bool| {
            let folder = room.path().join(name);
            fs::create_dir_all(folder.join("deep")).unwrap();
            fs::write(folder.join("cell.json"), "{}").unwrap();
            for at in ["cell.json", "deep", ""] {
                let file = File::open(folder.join(at)).unwrap();
                if is_old {
                    file.set_modified(long_ago).unwrap();
                }
            }
            folder
        };
        let dead = make(".ergopath-aB3dE9", true);
        let kept = [
            make(".ergopath-aB3dE8", false),
            make(".ergopath-notes", true),
            make(".ergopath-my_own", true),
            make("0123456789abcdef", true),
        ];
        let touched = make(".ergopath-aB3dE7", true);
        File::open(touched.join("cell.json")).unwrap().set_modified(SystemTime::now()).unwrap();
        fs::write(room.path().join(".ergopath-aB3dE6"), "a file").unwrap();
        sweep_killed(room.path());
        assert!(!dead.exists() && touched.exists());
        assert!(kept.iter().all(|k| k.join("cell.json").exists()));
        assert!(room.path().join(".ergopath-aB3dE6").exists());
        #[cfg(unix)]
        {
            // A link leads elsewhere: neither it nor what it leads to is touched.
            let linked = make(".ergopath-aB3dE5", true);
            std::os::unix::fs::symlink(&kept[3], linked.join("link")).unwrap();
            File::open(&linked).unwrap().set_modified(long_ago).unwrap();
            sweep_killed(room.path());
            assert!(linked.exists() && kept[3].exists());
        }
        sweep_killed(&room.path().join("nowhere"));
    }
}
