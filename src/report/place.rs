//! Where a results folder is: links and `..` resolved, tried before a run computes, and locked while it is written.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// An error of the file system with the path that it concerns.
pub(crate) type At<T> = Result<T, (PathBuf, io::Error)>;

pub(super) fn at<T>(path: &Path, result: io::Result<T>) -> At<T> {
    result.map_err(|error| (path.to_owned(), error))
}

/// The folder that holds a path.
pub(super) fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// The absolute path of a folder that may not exist yet: links are followed and `..` is resolved.
pub(super) fn absolute(target: &Path) -> io::Result<PathBuf> {
    let mut there = target.to_owned();
    let mut missing: Vec<OsString> = vec![];
    while fs::symlink_metadata(&there).is_err() {
        let Some(last) = there.components().next_back() else {
            break;
        };
        missing.push(last.as_os_str().to_owned());
        there.pop();
    }
    let here = there.as_os_str().is_empty();
    let mut found = fs::canonicalize(if here { Path::new(".") } else { &there })?;
    for part in missing.iter().rev() {
        match Path::new(part).components().next() {
            Some(Component::ParentDir) => drop(found.pop()),
            Some(Component::CurDir) | None => {}
            Some(_) => found.push(part),
        }
    }
    Ok(found)
}

/// A folder of temporary name from which files can be renamed into the target, which exists: beside it, or in it where
/// the target is a mount point or nothing can be made beside it.
pub(super) enum Staging {
    Beside(tempfile::TempDir),
    Inside(tempfile::TempDir),
}

impl Staging {
    /// # Errors
    /// What the system refused.
    pub(super) fn of(target: &Path) -> At<Self> {
        match staging_in(parent(target)) {
            Ok(beside) if !is_mounted(target, beside.path()) => Ok(Self::Beside(beside)),
            _ => Ok(Self::Inside(staging_in(target)?)),
        }
    }

    pub(super) fn path(&self) -> &Path {
        match self {
            Self::Beside(folder) | Self::Inside(folder) => folder.path(),
        }
    }

    /// Whether the target can be exchanged as a whole.
    pub(super) fn is_beside(&self) -> bool {
        matches!(self, Self::Beside(_))
    }
}

/// Whether a rename from the folder beside ends at the border of the target. Devices do not tell: a folder that is
/// mounted twice has the same one. What is renamed does not exist, so that nothing is left: Linux looks at the border
/// first. Where a system does not, files are copied over it one by one.
fn is_mounted(target: &Path, beside: &Path) -> bool {
    let renamed = fs::rename(beside.join("absent"), target.join(".muspin-absent"));
    renamed.is_err_and(|error| error.kind() == io::ErrorKind::CrossesDevices)
}

/// A folder of temporary name.
pub(super) fn staging_in(folder: &Path) -> At<tempfile::TempDir> {
    let mut builder = tempfile::Builder::new();
    at(folder, builder.prefix(".muspin-").tempdir_in(folder))
}

/// Tries that files can be put into a folder, or that it can be made, and leaves nothing.
pub(super) fn try_writing(target: &Path) -> At<()> {
    if target.exists() {
        return Staging::of(target).map(drop);
    }
    let nearest = target.ancestors().skip(1).find(|folder| folder.exists());
    staging_in(nearest.unwrap_or(Path::new("."))).map(drop)
}

/// Keeps other runs out of a folder, and of those beside it, until it is dropped.
pub(super) struct Lock {
    #[cfg(unix)]
    _folder: Option<std::os::fd::OwnedFd>,
}

impl Lock {
    /// Waits for its turn. Where the system has no locks on folders, there is none.
    #[cfg(unix)]
    pub(super) fn beside(target: &Path) -> At<Self> {
        use rustix::fs::{FlockOperation, Mode, OFlags, flock, open};
        use std::time::{Duration, Instant};
        /// Longest wait: files of a run are written within seconds.
        const LONGEST: Duration = Duration::from_secs(60);
        const PAUSE: Duration = Duration::from_millis(20);
        let folder = parent(target);
        let Ok(opened) = open(folder, OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty()) else {
            return Ok(Self { _folder: None });
        };
        let begun = Instant::now();
        loop {
            match flock(&opened, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => return Ok(Self { _folder: Some(opened) }),
                Err(rustix::io::Errno::WOULDBLOCK | rustix::io::Errno::INTR) if begun.elapsed() < LONGEST => {
                    std::thread::sleep(PAUSE);
                }
                Err(rustix::io::Errno::WOULDBLOCK) => {
                    return Err((folder.to_owned(), io::Error::other("another program keeps the folder locked")));
                }
                Err(_) => return Ok(Self { _folder: None }),
            }
        }
    }

    /// No lock: the system has none that ends with its program.
    #[cfg(not(unix))]
    pub(super) fn beside(_: &Path) -> At<Self> {
        Ok(Self {})
    }
}
