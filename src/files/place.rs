//! Where a named output goes: a file is replaced whole, a link is followed, and whatever is no plain
//! file (a device, a pipe, standard output) is written through and stays what it is.

use super::error::InputError;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Links that may lead to links before it is called a circle, as in Linux.
const MOST_LINKS: usize = 40;

/// Where bytes go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Place {
    /// A plain file, there or not; no part of it is a link.
    File(PathBuf),
    /// Something that is opened and written to.
    Through(PathBuf),
    /// Standard output, under whichever name.
    Stdout,
}

impl Place {
    /// What a path names.
    pub(super) fn of(path: &Path) -> Result<Self, InputError> {
        let unwritable = |e: io::Error| InputError::unwritable(path, &e);
        match path.metadata() {
            Ok(found) if found.is_dir() => {
                Err(InputError::new(path, "is a folder, not a file").remedy("name a file"))
            }
            Ok(found) if is_stdout(&found) => Ok(Self::Stdout),
            Ok(found) if !found.is_file() => Ok(Self::Through(path.to_owned())),
            // `/dev/fd/3` and the like: an open file, which cannot be replaced for who holds it.
            Ok(_) if leads_through_proc(path) => Ok(Self::Through(path.to_owned())),
            Ok(_) => path.canonicalize().map(Self::File).map_err(unwritable),
            Err(_) => {
                end_of_links(path).and_then(|p| whole(&p)).map(Self::File).map_err(unwritable)
            }
        }
    }
}

/// The path at the end of links, whether something is there or not.
pub(super) fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    let mut at = path.to_owned();
    for _ in 0..MOST_LINKS {
        if !at.is_symlink() {
            return Ok(at);
        }
        let next = fs::read_link(&at)?;
        at = at.parent().unwrap_or(Path::new("")).join(next);
    }
    Err(io::Error::new(io::ErrorKind::InvalidInput, "its links lead in a circle"))
}

/// The whole path without links, of which the last parts need not exist.
pub(super) fn whole(path: &Path) -> io::Result<PathBuf> {
    let absolute = std::path::absolute(path)?;
    let mut there = absolute.as_path();
    while !there.exists() {
        let Some(above) = there.parent() else { break };
        there = above;
    }
    let rest = absolute.strip_prefix(there).unwrap_or(Path::new(""));
    let start = there.canonicalize()?;
    Ok(if rest.as_os_str().is_empty() { start } else { start.join(rest) })
}

fn leads_through_proc(path: &Path) -> bool {
    let mut at = path.to_owned();
    for _ in 0..MOST_LINKS {
        let above = at.parent().and_then(|p| p.canonicalize().ok());
        if above.is_some_and(|p| p.starts_with("/proc")) {
            return true;
        }
        let Ok(next) = fs::read_link(&at) else { return false };
        at = at.parent().unwrap_or(Path::new("")).join(next);
    }
    false
}

#[cfg(unix)]
fn is_stdout(found: &Metadata) -> bool {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    let own = io::stdout().as_fd().try_clone_to_owned().map(File::from);
    own.and_then(|f| f.metadata()).is_ok_and(|m| (m.dev(), m.ino()) == (found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn is_stdout(_: &Metadata) -> bool {
    false
}

/// Writes to something that is no plain file, as it is.
pub(super) fn write_through(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut open = OpenOptions::new().append(true).open(path)?;
    open.write_all(bytes)?;
    open.flush()
}

/// Writes to standard output. A reader that has gone (`| head`) is no fault.
pub(super) fn write_stdout(bytes: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// The folder that is to hold a place, or the nearest above it that is there.
pub(super) fn nearest_folder(place: &Path) -> &Path {
    place.ancestors().skip(1).find(|p| p.is_dir()).unwrap_or(Path::new("/"))
}

/// A file near its place, complete but not yet there.
pub(super) fn stage(place: &Path, bytes: &[u8]) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(super::marker::STAGING);
    // A new file gets the permissions of any new file, an old one keeps its own.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(nearest_folder(place))?;
    file.as_file_mut().write_all(bytes)?;
    file.as_file().sync_data()?;
    if let Ok(old) = place.metadata() {
        file.as_file().set_permissions(old.permissions())?;
    }
    Ok(file)
}

/// Folders that were made on the way to a place; removed again, where still empty, unless kept.
#[derive(Debug, Default)]
pub(super) struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    pub(super) fn make(&mut self, folder: &Path) -> io::Result<()> {
        let mut missing: Vec<&Path> = folder.ancestors().take_while(|p| !p.exists()).collect();
        missing.reverse();
        for folder in missing {
            match fs::create_dir(folder) {
                Ok(()) => self.0.push(folder.to_owned()),
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists && folder.is_dir() => {}
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    pub(super) fn keep(mut self) {
        self.0.clear();
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Writes one file whole or not at all; links are followed, devices written through. What stood there
/// is replaced, whoever wrote it: for files that a caller owns.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    let io = |e: io::Error| InputError::unwritable(path, &e);
    match Place::of(path)? {
        Place::Stdout => write_stdout(bytes).map_err(io),
        Place::Through(place) => write_through(&place, bytes).map_err(io),
        Place::File(place) => {
            let mut folders = NewFolders::default();
            folders.make(place.parent().unwrap_or(Path::new("/"))).map_err(io)?;
            stage(&place, bytes)
                .and_then(|f| f.persist(&place).map_err(|e| e.error))
                .map_err(io)?;
            folders.keep();
            Ok(())
        }
    }
}
