//! The one door for what a command writes: all of it or nothing, and nothing of the user's is lost.
//!
//! - A folder is replaced only where it carries our list of files, and only those files go.
//! - A file is replaced only where ergopath wrote that kind of file before, or on demand.
//! - No input of the call is ever replaced, under whichever of its names.
//! - Links are followed; devices and pipes are written through.

use super::error::InputError;
use super::folder::{FolderOutput, Swapped};
use super::inputs::{is_input, is_same_file};
use super::marker::STAGING;
use super::place::{NewFolders, Place, nearest_folder, stage, write_stdout, write_through};
use super::signature::signature;
use super::spreadsheet::without_formulas;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// What one call writes, gathered and then written at once.
#[derive(Debug, Default)]
pub struct Outputs {
    overwrites: bool,
    folders: Vec<FolderOutput>,
    files: Vec<FileOutput>,
}

#[derive(Debug)]
struct FileOutput {
    shown: PathBuf,
    place: Place,
    bytes: Vec<u8>,
    /// State of the program's own that it goes on with and renews.
    may_be_input: bool,
}

impl Outputs {
    /// With `overwrites` files that ergopath did not write are replaced too; inputs never.
    pub fn new(overwrites: bool) -> Self {
        Self { overwrites, ..Self::default() }
    }

    /// Nothing gathered, by the same rules.
    #[must_use]
    pub fn another(&self) -> Self {
        Self::new(self.overwrites)
    }

    /// Refuses a folder now that could not be written after the work.
    pub fn expect_folder(&self, target: &Path) -> Result<(), InputError> {
        let folder = FolderOutput::new(target, BTreeMap::new(), false, self.overwrites)?;
        folder.check()?;
        folder.probe()
    }

    /// Refuses a file now that could not be written after the work; `like` begins as it will.
    pub fn expect_file(&self, path: &Path, like: &[u8]) -> Result<(), InputError> {
        let file = FileOutput::new(path, like.to_vec(), false)?;
        file.check(self.overwrites)
    }

    /// A folder of these files; other files of ours in it go.
    pub fn folder(
        &mut self,
        target: &Path,
        files: impl IntoIterator<Item = (String, Vec<u8>)>,
    ) -> Result<(), InputError> {
        let files = files.into_iter().map(safe).collect();
        self.folders.push(FolderOutput::new(target, files, false, self.overwrites)?);
        Ok(())
    }

    /// Files beside those that ergopath wrote to a folder before.
    pub fn add_to_folder(
        &mut self,
        target: &Path,
        files: impl IntoIterator<Item = (String, Vec<u8>)>,
    ) -> Result<(), InputError> {
        let files = files.into_iter().map(safe).collect();
        self.folders.push(FolderOutput::new(target, files, true, self.overwrites)?);
        Ok(())
    }

    /// A file that the user named.
    pub fn file(&mut self, path: &Path, bytes: impl Into<Vec<u8>>) -> Result<(), InputError> {
        let bytes = without_formulas(path, bytes.into());
        self.files.push(FileOutput::new(path, bytes, false)?);
        Ok(())
    }

    /// State of the program's own, which may have been read by the same call.
    pub fn state(&mut self, path: &Path, bytes: impl Into<Vec<u8>>) -> Result<(), InputError> {
        self.files.push(FileOutput::new(path, bytes.into(), true)?);
        Ok(())
    }

    /// Writes everything. Where anything cannot be written, nothing is, but for what was written
    /// through to a device.
    pub fn write(self) -> Result<(), InputError> {
        self.refuse_same()?;
        for folder in &self.folders {
            folder.check()?;
        }
        let mut staged = Vec::new();
        for file in &self.files {
            file.check(self.overwrites)?;
            if let Some(temporary) = file.stage()? {
                staged.push((file, temporary));
            }
        }
        let mut parents = NewFolders::default();
        let mut swapped: Vec<Swapped> = Vec::new();
        let result = self.move_in(staged, &mut parents, &mut swapped);
        if result.is_err() {
            drop(parents);
            swapped.into_iter().rev().for_each(Swapped::undo);
            return result;
        }
        parents.keep();
        for (folder, swapped) in self.folders.iter().zip(swapped) {
            swapped.finish().map_err(|e| InputError::unwritable(&folder.target, &e))?;
        }
        Ok(())
    }

    fn move_in<'a>(
        &'a self,
        staged: Vec<(&'a FileOutput, tempfile::NamedTempFile)>,
        parents: &mut NewFolders,
        swapped: &mut Vec<Swapped>,
    ) -> Result<(), InputError> {
        for file in &self.files {
            file.write_through()?;
        }
        for folder in &self.folders {
            swapped.push(folder.swap_in()?);
        }
        let mut made: Vec<&Path> = Vec::new();
        for (file, temporary) in staged {
            let Place::File(place) = &file.place else { continue };
            let is_new = !place.exists();
            let moved = parents
                .make(place.parent().unwrap_or(Path::new("/")))
                .and_then(|()| temporary.persist(place).map_err(|e| e.error));
            if let Err(e) = moved {
                for path in made {
                    let _ = std::fs::remove_file(path);
                }
                return Err(file.unwritable(&e));
            }
            if is_new {
                made.push(place);
            }
        }
        Ok(())
    }

    /// Two outputs of one call in the same place: one of them would be lost.
    fn refuse_same(&self) -> Result<(), InputError> {
        let mut places: Vec<(PathBuf, PathBuf)> = Vec::new();
        for folder in &self.folders {
            places.push((folder.target.clone(), folder.shown.clone()));
            let names = folder.files.keys();
            places.extend(names.map(|n| (folder.target.join(n), folder.shown.join(n))));
        }
        for file in &self.files {
            let Place::File(place) = &file.place else { continue };
            let is_there = |(p, _): &&(PathBuf, PathBuf)| p == place || is_same_file(p, place);
            if let Some((_, same)) = places.iter().find(is_there) {
                let message =
                    format!("would be written twice: this call also writes `{}`", same.display());
                return Err(InputError::new(&file.shown, message)
                    .remedy("give each output a name of its own"));
            }
            places.push((place.clone(), file.shown.clone()));
        }
        Ok(())
    }
}

/// A file of a folder as it may be written.
fn safe((name, bytes): (String, Vec<u8>)) -> (String, Vec<u8>) {
    let bytes = without_formulas(Path::new(&name), bytes);
    (name, bytes)
}

impl FileOutput {
    fn new(path: &Path, bytes: Vec<u8>, may_be_input: bool) -> Result<Self, InputError> {
        Ok(Self { shown: path.to_owned(), place: Place::of(path)?, bytes, may_be_input })
    }

    fn unwritable(&self, e: &io::Error) -> InputError {
        InputError::unwritable(&self.shown, e)
    }

    /// Refused: an input of this call, and a file that is not known as one of ours.
    fn check(&self, overwrites: bool) -> Result<(), InputError> {
        let Place::File(place) = &self.place else { return Ok(()) };
        let error = |message: &str| {
            Err(InputError::new(&self.shown, message).remedy("write to another file"))
        };
        let Ok(found) = place.metadata() else { return self.probe(place) };
        if is_input(place) && !self.may_be_input {
            return error("is an input of this call and would be overwritten");
        }
        if found.permissions().readonly() {
            return error("is write-protected");
        }
        if !overwrites {
            let old = std::fs::read(place).map_err(|e| self.unwritable(&e))?;
            let kind = signature(&self.bytes);
            if old != self.bytes && !old.is_empty() && (kind.is_none() || signature(&old) != kind) {
                let message = "exists and does not look like a file that ergopath wrote";
                return Err(InputError::new(&self.shown, message)
                    .remedy("write to another file, or replace this one with --overwrite"));
            }
        }
        self.probe(place)
    }

    fn probe(&self, place: &Path) -> Result<(), InputError> {
        let probe = tempfile::Builder::new().prefix(STAGING).tempfile_in(nearest_folder(place));
        probe.map(drop).map_err(|e| self.unwritable(&e))
    }

    fn stage(&self) -> Result<Option<tempfile::NamedTempFile>, InputError> {
        let Place::File(place) = &self.place else { return Ok(None) };
        stage(place, &self.bytes).map(Some).map_err(|e| self.unwritable(&e))
    }

    fn write_through(&self) -> Result<(), InputError> {
        match &self.place {
            Place::File(_) => Ok(()),
            Place::Stdout => write_stdout(&self.bytes),
            Place::Through(path) => write_through(path, &self.bytes),
        }
        .map_err(|e| self.unwritable(&e))
    }
}

/// Takes away a file of the program's own state, if it is that.
pub fn remove_state(path: &Path) {
    let is_plain = path.symlink_metadata().is_ok_and(|m| m.is_file());
    if is_plain && std::fs::read(path).is_ok_and(|b| signature(&b) == Some("unfinished")) {
        let _ = std::fs::remove_file(path);
    }
}
