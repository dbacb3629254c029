//! Writes a file whole or not at all: beside its place first, under another name, and renamed once all of it is there.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("answer.txt");
//! whole_file::write(&path, b"42")?;
//! assert_eq!(std::fs::read(&path)?, b"42");
//! # std::io::Result::Ok(())
//! ```

use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// How the name of an unfinished file begins. A process that was killed leaves such files behind.
pub const UNFINISHED: &str = ".unfinished-";

/// Writes these bytes as a file, and sees that they are on the disk. Missing folders are not made.
///
/// # Errors
/// The system refuses; then what was there before is still there, and nothing else is.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut draft = Draft::of(path)?;
    draft.file().write_all(bytes)?;
    draft.finish()
}

/// A file in the making. Dropped before it is finished, it leaves nothing.
#[derive(Debug)]
pub struct Draft {
    file: NamedTempFile,
    target: PathBuf,
}

impl Draft {
    /// Begins a file that is to replace, or become, `path`. Where that is a link, the file that it leads to is replaced; a
    /// file that was there keeps its permissions, and a new one gets those of the user's umask.
    ///
    /// # Errors
    /// The folder is missing, or nothing can be written there.
    pub fn of(path: &Path) -> io::Result<Self> {
        let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let folder = target.parent().filter(|folder| *folder != Path::new(""));
        let ending = target.extension().map(|extension| {
            let mut ending = std::ffi::OsString::from(".");
            ending.push(extension);
            ending
        });
        let file = tempfile::Builder::new()
            .prefix(UNFINISHED)
            // Some libraries choose the format by it.
            .suffix(&ending.unwrap_or_default())
            .permissions(Permissions::from_mode(0o666))
            .tempfile_in(folder.unwrap_or(Path::new(".")))?;
        if let Ok(there) = fs::metadata(&target)
            .as_ref()
            .map(fs::Metadata::permissions)
        {
            file.as_file().set_permissions(there)?;
        }
        Ok(Self { file, target })
    }

    /// The unfinished file, for what writes to an open file.
    pub fn file(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Its name until it is finished, for what opens files by their names. The ending is the target's.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Puts the file in its place, once all of it is on the disk.
    ///
    /// # Errors
    /// The system refuses; then what was there before is still there.
    pub fn finish(self) -> io::Result<()> {
        // By name, since a library may have opened the file for itself.
        File::open(self.file.path())?.sync_all()?;
        let target = self.target.clone();
        self.finish_unflushed()?;
        let folder = target.parent().filter(|folder| *folder != Path::new(""));
        File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
    }

    /// Puts the file in its place without waiting for the disk: if the machine loses its power soon after, the file can be
    /// cut short. For files that can be made again and whose reader knows their digest.
    ///
    /// # Errors
    /// As [`Draft::finish`].
    pub fn finish_unflushed(self) -> io::Result<()> {
        self.file
            .persist(self.target)
            .map_err(|error| error.error)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::os::unix::fs::symlink;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for bytes in [b"one".as_slice(), b"other"] {
            write(&path, bytes).unwrap();
            assert_eq!(fs::read(&path).unwrap(), bytes);
        }
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn a_draft_has_the_targets_ending_and_leaves_nothing_when_it_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        let mut draft = Draft::of(&path).unwrap();
        assert_eq!(draft.path().extension(), path.extension());
        draft.file().write_all(b"half").unwrap();
        drop(draft);
        assert_eq!(names(folder.path()), ["a.png"]);
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn what_a_library_wrote_by_name_is_put_in_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        let draft = Draft::of(&path).unwrap();
        fs::write(draft.path(), "by name").unwrap();
        draft.finish().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"by name");
    }

    #[test]
    fn links_stay_links_and_permissions_stay() {
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a"), folder.path().join("link"));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
        symlink(&path, &link).unwrap();
        write(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"new");
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        // A new file is not for this user alone, unless the umask says so.
        write(&folder.path().join("b"), b"new").unwrap();
        fs::write(folder.path().join("c"), "new").unwrap();
        let mode = |name| {
            fs::metadata(folder.path().join(name))
                .unwrap()
                .permissions()
                .mode()
        };
        assert_eq!(mode("b"), mode("c"));
    }

    #[test]
    fn what_the_system_refuses_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        write(&taken, b"").unwrap_err();
        write(&folder.path().join("missing/a"), b"").unwrap_err();
        assert_eq!(names(folder.path()), ["taken"]);
        assert!(names(&taken).is_empty());
    }
}
