//! Files that are there whole, or not at all.

use std::{
    fs::{self, File},
    io::{self, ErrorKind, Write as _},
    path::{Path, PathBuf},
};

/// A file that is written beside its place, with [`Self::PART`] behind its name, and takes the place once it is whole.
/// Dropped before that, it leaves the place as it was and nothing beside it.
///
/// A link in either place is replaced itself, and its target stays as it is.
#[derive(Debug)]
pub struct AtomicFile {
    place: PathBuf,
    part: PathBuf,
}

impl AtomicFile {
    /// Suffix of a file's name until the file is whole.
    pub const PART: &str = ".part";

    /// A file for this place. The part that an earlier one left, as it was killed, is removed.
    ///
    /// # Errors
    /// The system's error if that part cannot be removed. Where there is something else than a file or a link, as a
    /// device: that it is none.
    pub fn new(place: impl AsRef<Path>) -> io::Result<Self> {
        let place = place.as_ref().to_path_buf();
        check_replaceable(&place)?;
        let mut part = place.clone().into_os_string();
        part.push(Self::PART);
        let part = PathBuf::from(part);
        remove(&part)?;
        Ok(Self { place, part })
    }

    /// Where it is written until it is whole.
    #[must_use]
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Makes the part, empty.
    ///
    /// # Errors
    /// The system's error, also if another process has put something there meanwhile.
    pub fn create(&self) -> io::Result<File> {
        File::create_new(&self.part)
    }

    /// Moves the part, which is whole and closed, to its place.
    ///
    /// # Errors
    /// The system's error; the place is as it was then.
    pub fn finish(self) -> io::Result<()> {
        fs::rename(&self.part, &self.place)
    }

    /// Writes a file of these bytes, at the end of a link where `path` is one, and hands it to the disk. A path
    /// that is no file, as a pipe, takes the bytes as they come.
    ///
    /// # Errors
    /// The system's error; a file that was there is as it was then.
    pub fn write(path: impl AsRef<Path>, bytes: &[u8]) -> io::Result<()> {
        let path = path.as_ref();
        if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return File::options().write(true).open(path)?.write_all(bytes);
        }
        let whole = Self::new(fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()))?;
        let mut file = whole.create()?;
        file.write_all(bytes)?;
        file.sync_all()?;
        drop(file);
        whole.finish()
    }
}

/// Whether a file may take a place: a device or a pipe is there for others too.
fn check_replaceable(place: &Path) -> io::Result<()> {
    match fs::symlink_metadata(place) {
        Ok(found) if !(found.is_file() || found.is_symlink() || found.is_dir()) => {
            Err(io::Error::new(ErrorKind::AlreadyExists, "something else than a file is there"))
        }
        _ => Ok(()),
    }
}

/// Removes a file or a link, if it is there.
///
/// # Errors
/// The system's error; where there is something else, as a device: that it is no file.
pub fn remove(path: impl AsRef<Path>) -> io::Result<()> {
    check_replaceable(path.as_ref())?;
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        // Once it has moved there is none; and why there is no file is known already.
        let _ = fs::remove_file(&self.part);
    }
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used)] // a test may panic

    use std::os::unix::{fs::symlink, net::UnixListener};

    use super::*;

    /// A file is replaced once the new one is whole, at the end of a link too; a link beside it leads nowhere, and what
    /// is no file stays.
    #[test]
    fn a_file_is_whole_or_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link, other] = ["file", "link", "other"].map(|name| folder.path().join(name));
        fs::write(&other, "precious").unwrap();
        symlink("file", &link).unwrap();
        for text in ["one", "two"] {
            symlink("other", folder.path().join("file.part")).unwrap();
            AtomicFile::write(&file, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&link).unwrap(), text);
        }
        AtomicFile::write(&link, b"three").unwrap();
        assert!(link.is_symlink());
        // A part that is dropped costs nothing.
        let part = AtomicFile::new(&file).unwrap();
        part.create().unwrap().write_all(b"half").unwrap();
        assert!(part.create().is_err(), "somebody else's is not taken");
        drop(part);
        assert_eq!([&file, &other].map(|path| fs::read_to_string(path).unwrap()), ["three", "precious"]);
        let mut names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        assert_eq!(names, ["file", "link", "other"]);
        AtomicFile::write("/dev/null", b"gone").unwrap();
        assert!(!Path::new("/dev/null").is_file());
        assert!(AtomicFile::write(folder.path(), b"no file").is_err());
    }

    /// A socket or a device, which is no file, is neither replaced nor removed.
    #[test]
    fn what_is_no_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = UnixListener::bind(&socket).unwrap();
        for refused in [AtomicFile::new(&socket).map(drop), remove(&socket)] {
            assert_eq!(refused.unwrap_err().to_string(), "something else than a file is there");
        }
        assert!(fs::symlink_metadata(&socket).is_ok());
    }
}
