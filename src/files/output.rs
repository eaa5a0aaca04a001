//! Writing whole or not at all: into a temporary place beside the target, then renamed.

use super::error::InputError;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The files by which a folder is known to be an output of ergopath and may be replaced.
const MARKS: [&str; 5] =
    ["result.json", "comparison.csv", "size.json", "toy-5r.json", "summary.json"];

/// The pictures of a training. A folder of nothing else may be replaced too; one that holds anything
/// beside them may be somebody's collection of figures.
const PICTURES: [&str; 2] = ["held_out.png", "weights.png"];

/// A folder of results that appears complete or not at all.
#[derive(Debug)]
pub struct OutputFolder {
    target: PathBuf,
    staging: tempfile::TempDir,
}

impl OutputFolder {
    /// Opens a staging folder beside `target`. Fails at once, before any work, where the target
    /// cannot be written or holds something that ergopath did not make.
    pub fn create(target: &Path) -> Result<Self, InputError> {
        let io = |e: std::io::Error| InputError::new(target, format!("cannot be written: {e}"));
        let target = std::path::absolute(target).map_err(io)?;
        if target.is_dir() {
            if !MARKS.iter().any(|mark| target.join(mark).is_file())
                && !holds_pictures_only(&target).map_err(io)?
            {
                return Err(InputError::new(
                    &target,
                    "exists and is not an ergopath output folder",
                )
                .remedy("choose another folder, or remove this one yourself"));
            }
        } else if target.exists() {
            return Err(
                InputError::new(&target, "is a file, not a folder").remedy("choose another folder")
            );
        }
        let parent = target.parent().unwrap_or(Path::new("/"));
        std::fs::create_dir_all(parent).map_err(io)?;
        let staging =
            tempfile::Builder::new().prefix(".ergopath-").tempdir_in(parent).map_err(io)?;
        Ok(Self { target, staging })
    }

    /// Writes one file, with `/` in the name making sub-folders.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), InputError> {
        let path = self.staging.path().join(name);
        let io = |e| InputError::new(&path, format!("cannot be written: {e}"));
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(io)?;
        }
        std::fs::write(&path, bytes).map_err(io)
    }

    /// Puts the finished folder in place of the target.
    pub fn publish(self) -> Result<PathBuf, InputError> {
        let Self { target, staging } = self;
        let io = |e: std::io::Error| InputError::new(&target, format!("cannot be replaced: {e}"));
        let finished = staging.keep();
        set_usual_permissions(&finished).map_err(io)?;
        let old = target.with_file_name(format!(
            ".ergopath-old-{}",
            target.file_name().unwrap_or_default().to_string_lossy()
        ));
        let had_old = target.is_dir();
        if had_old {
            let _ = std::fs::remove_dir_all(&old);
            std::fs::rename(&target, &old).map_err(io)?;
        }
        if let Err(e) = std::fs::rename(&finished, &target) {
            if had_old {
                let _ = std::fs::rename(&old, &target);
            }
            let _ = std::fs::remove_dir_all(&finished);
            return Err(io(e));
        }
        if had_old {
            let _ = std::fs::remove_dir_all(&old);
        }
        Ok(target)
    }
}

/// Whether a folder is empty, or holds no other files than [`PICTURES`].
fn holds_pictures_only(folder: &Path) -> std::io::Result<bool> {
    for entry in folder.read_dir()? {
        let name = entry?.file_name();
        if !PICTURES.iter().any(|picture| name == *picture) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Temporary folders are private; a published folder gets the permissions of any new folder.
#[cfg(unix)]
fn set_usual_permissions(folder: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn set_usual_permissions(_: &Path) -> std::io::Result<()> {
    Ok(())
}

/// Writes one file whole or not at all.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    let io = |e: std::io::Error| InputError::new(path, format!("cannot be written: {e}"));
    let parent = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(parent).map_err(io)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".ergopath-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o644));
    }
    let mut file = builder.tempfile_in(parent).map_err(io)?;
    file.write_all(bytes).map_err(io)?;
    file.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn appears_whole_and_replaces_only_its_own() {
        let room = tempfile::tempdir().unwrap();
        let target = room.path().join("out");
        let folder = OutputFolder::create(&target).unwrap();
        folder.write("paths/1.csv", b"a").unwrap();
        folder.write(MARKS[0], b"{}").unwrap();
        assert!(!target.exists());
        folder.publish().unwrap();
        assert_eq!(std::fs::read(target.join("paths/1.csv")).unwrap(), b"a");

        let second = OutputFolder::create(&target).unwrap();
        second.write(MARKS[0], b"{2}").unwrap();
        second.publish().unwrap();
        assert!(!target.join("paths").exists());

        let foreign = room.path().join("mine");
        std::fs::create_dir(&foreign).unwrap();
        std::fs::write(foreign.join("thesis.tex"), b"x").unwrap();
        assert!(OutputFolder::create(&foreign).is_err());

        // Pictures of a training are replaced, unless something else lies beside them.
        let pictures = room.path().join("pictures");
        for _ in 0..2 {
            let folder = OutputFolder::create(&pictures).unwrap();
            folder.write(PICTURES[0], b"x").unwrap();
            folder.publish().unwrap();
        }
        std::fs::write(pictures.join("my_own.png"), b"x").unwrap();
        assert!(OutputFolder::create(&pictures).is_err());
        std::fs::remove_dir_all(&pictures).unwrap();
        // Nothing is left behind but the two folders.
        assert_eq!(room.path().read_dir().unwrap().count(), 2);
    }

    #[test]
    fn an_abandoned_folder_leaves_nothing() {
        let room = tempfile::tempdir().unwrap();
        let folder = OutputFolder::create(&room.path().join("out")).unwrap();
        folder.write("a", b"a").unwrap();
        drop(folder);
        assert_eq!(room.path().read_dir().unwrap().count(), 0);
    }
}
