//! A folder of results: which of its files may be replaced, and how they come in together.
//!
//! A new folder appears by one renaming. In a folder that is there already each file is moved, so the
//! folder holds files of two runs for a moment; while it does, `INCOMPLETE.txt` stands in it and the
//! list of files names those to come. A run that fails puts everything back; one that is killed leaves
//! that notice, and the next run may replace the files of both.

use super::error::InputError;
use super::inputs::is_input;
use super::marker::{
    Coming, Found, INCOMPLETE, INCOMPLETE_TEXT, Listed, MARKER, Marker, STAGING, is_inside, listed,
    look, refuse_incomplete,
};
use super::place::{NewFolders, end_of_links, whole};
use super::text::sha256_hex;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// The list of before, in the working folder.
const OLD_LIST: &str = "old-list";
const ELSEWHERE: &str = "choose another folder, or an empty one";

/// A folder that is to be written.
#[derive(Debug)]
pub(super) struct FolderOutput {
    /// As the user named it.
    pub shown: PathBuf,
    /// Without links.
    pub target: PathBuf,
    pub files: BTreeMap<String, Vec<u8>>,
    /// Files of ours that are not written anew stay; otherwise they go.
    keeps_others: bool,
    /// Files that ergopath did not write, or that were changed since, may be replaced too.
    overwrites: bool,
}

impl FolderOutput {
    pub(super) fn new(
        shown: &Path,
        files: BTreeMap<String, Vec<u8>>,
        keeps_others: bool,
        overwrites: bool,
    ) -> Result<Self, InputError> {
        let target = end_of_links(shown).and_then(|p| whole(&p));
        let target = target.map_err(|e| InputError::unwritable(shown, &e))?;
        if let Some(name) = files.keys().find(|name| !is_inside(name)) {
            return Err(InputError::fault(shown, format!("`{name}` is no name of a file in it")));
        }
        Ok(Self { shown: shown.to_owned(), target, files, keeps_others, overwrites })
    }

    fn error(&self, message: impl Into<String>) -> InputError {
        InputError::new(&self.shown, message)
    }

    fn io(&self, e: &io::Error) -> InputError {
        InputError::unwritable(&self.shown, e)
    }

    /// The list of what is ours in the folder; none where there is no folder. Refused: a folder that is
    /// not ours, and any file in the way that must not be lost.
    pub(super) fn check(&self) -> Result<Option<Marker>, InputError> {
        if !self.target.exists() {
            return Ok(None);
        }
        if !self.target.is_dir() {
            return Err(self.error("is a file, not a folder").remedy("choose another folder"));
        }
        let marker = match Marker::read(&self.target)? {
            Some(marker) => marker,
            // Beside whatever is there no file is lost: each is looked at below.
            None if self.keeps_others || self.is_empty()? => Marker::new(Listed::new()),
            None => {
                return Err(self
                    .error("exists and is not an ergopath output folder")
                    .remedy(ELSEWHERE));
            }
        };
        if let Ok(text) = fs::read(self.target.join(INCOMPLETE))
            && text != INCOMPLETE_TEXT.as_bytes()
        {
            let message = format!("holds a file `{INCOMPLETE}` that ergopath did not write");
            return Err(self.error(message).remedy("rename that file, or choose another folder"));
        }
        let names = marker.names();
        for (name, hashes) in &names {
            self.check_one(name, hashes)?;
        }
        for name in self.files.keys().filter(|name| !names.contains_key(name.as_str())) {
            self.check_one(name, &[])?;
        }
        Ok(Some(marker))
    }

    /// A place that cannot be written is found out before the work.
    pub(super) fn probe(&self) -> Result<(), InputError> {
        let there = self.target.ancestors().find(|p| p.is_dir()).unwrap_or(Path::new("/"));
        tempfile::Builder::new()
            .prefix(STAGING)
            .tempfile_in(there)
            .map(drop)
            .map_err(|e| self.io(&e))
    }

    fn is_empty(&self) -> Result<bool, InputError> {
        Ok(self.target.read_dir().map_err(|e| self.io(&e))?.next().is_none())
    }

    /// One file that the run would write or take away; `ours` are the hashes by which it is ours.
    fn check_one(&self, name: &str, ours: &[&str]) -> Result<(), InputError> {
        let new = self.files.get(name);
        if new.is_none() && self.keeps_others {
            return Ok(());
        }
        let found = look(&self.target, name).map_err(|e| self.io(&e))?;
        let hash = match found {
            Found::Other(at) if new.is_some() => {
                let what = at.strip_prefix(&self.target).unwrap_or(&at).display();
                let message = format!(
                    "holds `{what}`, which is no plain file, where `{name}` would be written"
                );
                return Err(self.error(message).remedy(ELSEWHERE));
            }
            // Whatever it is, it is not what ergopath wrote: it stays.
            Found::Nothing | Found::Other(_) => return Ok(()),
            Found::File(hash) => hash,
        };
        if is_input(&self.target.join(name)) {
            let message = format!("`{name}` in it is an input of this run and would be replaced");
            return Err(self.error(message).remedy("choose another folder"));
        }
        let is_same = new.is_some_and(|bytes| sha256_hex(bytes) == hash);
        if is_same || self.overwrites || ours.contains(&hash.as_str()) {
            return Ok(());
        }
        let message = if ours.is_empty() {
            format!("holds a file `{name}` that ergopath did not write")
        } else {
            format!("`{name}` in it was changed since ergopath wrote it")
        };
        Err(self
            .error(message)
            .remedy("move that file, choose another folder, or replace it with --overwrite"))
    }

    /// Puts all files in their places. What was there is kept until [`Swapped::finish`].
    pub(super) fn swap_in(&self) -> Result<Swapped, InputError> {
        if !self.target.exists() {
            match self.appear() {
                // Another run was quicker: its folder is replaced.
                Err(_) if self.target.is_dir() => {}
                other => return other.map_err(|e| self.io(&e)),
            }
        }
        // Runs into the same folder take turns; the lock ends with the file or the process.
        let lock = File::open(&self.target).ok();
        if let Some(lock) = &lock {
            let _ = lock.lock();
        }
        let Some(marker) = self.check()? else {
            return Err(InputError::fault(&self.shown, "was removed while ergopath wrote to it"));
        };
        let io = |e: io::Error| self.io(&e);
        self.sweep(&marker).map_err(io)?;
        let standing = self.standing(&marker).map_err(io)?;
        let mut swapped = Swapped::begin(&self.target, &standing, lock).map_err(io)?;
        let moved =
            self.prepare(&swapped, &standing).and_then(|()| swapped.move_all(self, &marker));
        match moved {
            Ok(()) => Ok(swapped),
            Err(e) => {
                swapped.undo();
                Err(io(e))
            }
        }
    }

    /// A folder that was not there, by one renaming.
    fn appear(&self) -> io::Result<Swapped> {
        let parent = self.target.parent().unwrap_or(Path::new("/"));
        let mut parents = NewFolders::default();
        parents.make(parent)?;
        let staging = working_folder(parent)?;
        write_all(staging.path(), &self.files)?;
        write_list(&staging.path().join(MARKER), &Marker::new(listed(&self.files)))?;
        fs::rename(staging.path(), &self.target)?;
        // Renamed away: nothing is left to clean up.
        let _ = staging.keep();
        Ok(Swapped {
            target: self.target.clone(),
            staging: None,
            moved: self.files.keys().map(|n| (n.clone(), false)).collect(),
            parents,
            _lock: None,
        })
    }

    /// The files of ours by the hashes that they have now: after a run that was killed each is of one
    /// of two runs. One that was changed since keeps the hash by which that is known.
    fn standing(&self, marker: &Marker) -> io::Result<Listed> {
        let mut standing = Listed::new();
        for (name, hashes) in marker.names() {
            let hash = match look(&self.target, name)? {
                Found::File(hash) if hashes.contains(&hash.as_str()) => hash,
                _ => hashes[0].to_owned(),
            };
            standing.insert(name.to_owned(), hash);
        }
        Ok(standing)
    }

    /// Takes away the working folder of a run that was killed: copies of files that the list names.
    fn sweep(&self, marker: &Marker) -> io::Result<()> {
        let Some(left) = &marker.coming else { return Ok(()) };
        let left = self.target.join(&left.staging);
        let is_folder = left.symlink_metadata().is_ok_and(|m| m.is_dir());
        if is_folder { fs::remove_dir_all(left) } else { Ok(()) }
    }

    /// Everything into the working folder; then the notice, and the list that says what is coming.
    fn prepare(&self, swapped: &Swapped, standing: &Listed) -> io::Result<()> {
        let Some(staging) = &swapped.staging else { return Ok(()) };
        write_all(&staging.path().join("new"), &self.files)?;
        let mut ours: Listed = listed(&self.files);
        if self.keeps_others {
            for (name, hash) in standing {
                ours.entry(name.clone()).or_insert_with(|| hash.clone());
            }
        }
        write_list(&staging.path().join("list"), &Marker::new(ours))?;
        // A notice that is there is that of a run that was killed.
        if !self.target.join(INCOMPLETE).exists() {
            write_new(&self.target.join(INCOMPLETE), INCOMPLETE_TEXT.as_bytes())?;
        }
        swapped.announce(standing, listed(&self.files))
    }
}

/// Files of a run in their places, and how to take them out again.
#[derive(Debug)]
pub(super) struct Swapped {
    target: PathBuf,
    /// Working folder inside the target; none where the folder is new.
    staging: Option<tempfile::TempDir>,
    /// Names, and whether the old file of that name stands in the working folder.
    moved: Vec<(String, bool)>,
    parents: NewFolders,
    _lock: Option<File>,
}

impl Swapped {
    /// A working folder inside the target, and the list that names it, so that it is found after a kill.
    fn begin(target: &Path, standing: &Listed, lock: Option<File>) -> io::Result<Self> {
        let staging = working_folder(target)?;
        // Put back by renaming alone, which a full disk does not hinder.
        let (list, copy) = (target.join(MARKER), staging.path().join(OLD_LIST));
        if list.exists() && fs::hard_link(&list, &copy).is_err() {
            fs::copy(&list, &copy)?;
        }
        let swapped = Self {
            target: target.to_owned(),
            staging: Some(staging),
            moved: Vec::new(),
            parents: NewFolders::default(),
            _lock: lock,
        };
        swapped.announce(standing, Listed::new())?;
        Ok(swapped)
    }

    /// Writes the list with the files to come.
    fn announce(&self, standing: &Listed, files: Listed) -> io::Result<()> {
        let Some(staging) = &self.staging else { return Ok(()) };
        let name = staging.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut between = Marker::new(standing.clone());
        between.coming = Some(Coming { staging: name, files });
        let new = staging.path().join("between");
        write_list(&new, &between)?;
        fs::rename(new, self.target.join(MARKER))
    }

    fn move_all(&mut self, wanted: &FolderOutput, marker: &Marker) -> io::Result<()> {
        let Some(staging) = self.staging.as_ref().map(|s| s.path().to_owned()) else {
            return Ok(());
        };
        let old = |name: &str| staging.join("old").join(name);
        for (name, hashes) in marker.names() {
            let goes = !wanted.keeps_others && !wanted.files.contains_key(name);
            let Found::File(hash) = look(&self.target, name)? else { continue };
            if goes && (wanted.overwrites || hashes.contains(&hash.as_str())) {
                rename_into(&self.target.join(name), &old(name))?;
                self.moved.push((name.to_owned(), true));
            }
        }
        for name in wanted.files.keys() {
            let place = self.target.join(name);
            let had_old = place.symlink_metadata().is_ok();
            if had_old {
                rename_into(&place, &old(name))?;
            }
            // Noted before the second step: should that fail, the old one is put back.
            self.moved.push((name.clone(), had_old));
            self.parents.make(place.parent().unwrap_or(Path::new("/")))?;
            fs::rename(staging.join("new").join(name), &place)?;
        }
        Ok(())
    }

    /// Everything as it was before.
    pub(super) fn undo(mut self) {
        let Some(staging) = self.staging.take() else {
            for name in self.moved.iter().map(|(name, _)| name.as_str()).chain([MARKER]) {
                let _ = fs::remove_file(self.target.join(name));
                prune(&self.target, name);
            }
            let _ = fs::remove_dir(&self.target);
            return;
        };
        let mut is_whole = true;
        for (name, had_old) in self.moved.iter().rev() {
            let place = self.target.join(name);
            if *had_old {
                is_whole &= rename_into(&staging.path().join("old").join(name), &place).is_ok();
            } else {
                let _ = fs::remove_file(place);
            }
        }
        let (list, old) = (self.target.join(MARKER), staging.path().join(OLD_LIST));
        let restored = if old.exists() { fs::rename(old, list) } else { fs::remove_file(list) };
        if restored.is_err() || !is_whole {
            // What could not be put back stays in the working folder.
            let _ = staging.keep();
        } else if refuse_incomplete(&self.target).is_ok() {
            let _ = fs::remove_file(self.target.join(INCOMPLETE));
        }
    }

    /// The new files stay, the old ones go.
    pub(super) fn finish(self) -> io::Result<()> {
        self.parents.keep();
        let Some(staging) = self.staging else { return Ok(()) };
        fs::rename(staging.path().join("list"), self.target.join(MARKER))?;
        fs::remove_file(self.target.join(INCOMPLETE))?;
        for (name, _) in &self.moved {
            prune(&self.target, name);
        }
        staging.close()
    }
}

fn working_folder(parent: &Path) -> io::Result<tempfile::TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(STAGING);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Those of any new folder: it becomes the folder of the results.
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    builder.tempdir_in(parent)
}

fn write_all(folder: &Path, files: &BTreeMap<String, Vec<u8>>) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    for (name, bytes) in files {
        let place = folder.join(name);
        fs::create_dir_all(place.parent().unwrap_or(folder))?;
        write_new(&place, bytes)?;
    }
    Ok(())
}

/// A file that is not there yet. That it reached the disk is made sure: a full one may tell only then.
fn write_new(place: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create_new(place)?;
    file.write_all(bytes)?;
    file.sync_data()
}

fn write_list(place: &Path, marker: &Marker) -> io::Result<()> {
    write_new(place, &marker.bytes().map_err(io::Error::other)?)
}

fn rename_into(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to.parent().unwrap_or(Path::new("/")))?;
    fs::rename(from, to)
}

/// Takes away the folders above a file that have become empty.
fn prune(target: &Path, name: &str) {
    let mut at = target.join(name);
    while at.pop() && at != target && fs::remove_dir(&at).is_ok() {}
}
