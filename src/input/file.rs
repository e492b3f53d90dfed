//! The one place where files are opened for reading: regular files only, of at most as many bytes as their kind has.
//!
//! A pipe, a device or a socket is told before anything waits for it, and reading ends at the limit even where the size
//! that the system states is wrong, as in `/proc`.

use super::error::InputError;
use std::fs::{File, FileType, Metadata, OpenOptions};
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Most bytes of a kind of file, and what to do with a larger one.
#[derive(Clone, Copy, Debug)]
pub struct SizeLimit {
    most_bytes: u64,
    advice: &'static str,
}

/// Files of keys (YAML, TOML): a machine of three hundred elements takes fifty kilobytes, and the parser three hundred
/// bytes of memory for a byte of braces.
pub const KEYS: SizeLimit = SizeLimit { most_bytes: 1 << 20, advice: "records belong into CSV files" };
/// Controllers and problems in JSON: twenty bytes a number, a thousand states.
pub const MATRICES: SizeLimit =
    SizeLimit { most_bytes: 32 << 20, advice: "a thousand states take about 20 MB: reduce the order first" };
/// MATLAB files: other variables of a workspace may stand beside the controller.
pub const MATLAB: SizeLimit = SizeLimit {
    most_bytes: 256 << 20,
    advice: "save the controller alone: save('controller.mat', 'A', 'B', 'C', 'D', 'Ts')",
};
/// Records in CSV; they are read row by row.
pub const RECORD: SizeLimit =
    SizeLimit { most_bytes: 4 << 30, advice: "split the record, or leave out frequencies and repeats" };
/// Universal files; they are held whole.
pub const UNIVERSAL: SizeLimit =
    SizeLimit { most_bytes: 128 << 20, advice: "export the function of the tool plane alone" };
/// Files that a run wrote: summaries, pictures, manifests.
pub const RESULT: SizeLimit = SizeLimit { most_bytes: 64 << 20, advice: "run the command that wrote it again" };
/// Files of any kind that a run wrote and that are compared with their hash.
pub const WRITTEN: SizeLimit = SizeLimit { most_bytes: 4 << 30, advice: "move it away" };

/// Why a file is not read.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The system refused.
    #[error("cannot be read: {0}")]
    System(#[from] io::Error),
    /// A folder, pipe, device or socket.
    #[error("is {kind}, not a file")]
    NotAFile {
        /// What it is.
        kind: &'static str,
    },
    /// A link where none is followed.
    #[error("is a link; only files themselves are taken from this folder")]
    Link,
    /// More bytes than its kind has.
    #[error("has more than {most_bytes} bytes, the most that is read of a file of its kind")]
    TooLarge {
        /// The limit.
        most_bytes: u64,
        /// What to do.
        advice: &'static str,
    },
}

impl SizeLimit {
    /// What to do with a larger file.
    pub(super) fn advice(self) -> &'static str {
        self.advice
    }

    /// Whether a text of this length may be read.
    pub(super) fn admit(self, bytes: usize) -> Result<(), FileError> {
        if bytes as u64 > self.most_bytes {
            return Err(too_large(self));
        }
        Ok(())
    }
}

/// How much of a file has been read.
#[derive(Clone, Copy, Debug)]
pub struct ReadShare<'a> {
    /// The file.
    pub file: &'a Path,
    /// Bytes that have been read.
    pub done_bytes: u64,
    /// Bytes that it has.
    pub all_bytes: u64,
}

/// Hears how far the reading of a long file has come.
pub type Watch<'a> = &'a dyn Fn(ReadShare<'_>);

impl FileError {
    /// The same about a file, as the user reads it.
    pub(crate) fn of(&self, file: &str) -> InputError {
        InputError::new(file, self.to_string()).with_hint(match self {
            Self::System(_) => "check the path and the access rights of the file",
            Self::NotAFile { .. } => "write what it holds into a file first",
            Self::Link => "copy the file that it leads to",
            Self::TooLarge { advice, .. } => advice,
        })
    }

    /// Whether there is nothing at the path.
    pub(crate) fn is_absence(&self) -> bool {
        matches!(self, Self::System(error) if error.kind() == io::ErrorKind::NotFound)
    }
}

impl From<FileError> for io::Error {
    fn from(error: FileError) -> Self {
        match error {
            FileError::System(error) => error,
            other => Self::other(other),
        }
    }
}

/// An open file that yields no more bytes than its limit.
#[derive(Debug)]
pub struct Opened {
    file: File,
    stated_bytes: u64,
    left_bytes: u64,
    limit: SizeLimit,
}

impl Opened {
    /// The rest of the file.
    fn bytes(mut self) -> Result<Vec<u8>, FileError> {
        /// First room for a file whose size the system does not state.
        const FIRST_BYTES: u64 = 64 << 10;
        let mut bytes: Vec<u8> = vec![];
        let mut room = self.stated_bytes.min(self.limit.most_bytes) + 1;
        loop {
            let more = usize::try_from(room.max(FIRST_BYTES)).unwrap_or(usize::MAX);
            bytes.try_reserve_exact(more).map_err(|e| io::Error::new(io::ErrorKind::OutOfMemory, e))?;
            let read = self.by_ref().take(more as u64).read_to_end(&mut bytes)?;
            if read < more {
                return Ok(bytes);
            }
            room = bytes.len() as u64;
        }
    }
}

impl Read for Opened {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(buffer)?;
        match self.left_bytes.checked_sub(read as u64) {
            Some(left) => self.left_bytes = left,
            None => return Err(too_large(self.limit).into()),
        }
        Ok(read)
    }
}

/// Opens a file; links are followed.
///
/// # Errors
/// [`FileError`]: nothing there, no regular file, or larger than the limit.
pub fn open(path: &Path, limit: SizeLimit) -> Result<Opened, FileError> {
    open_checked(&std::fs::metadata(path)?, path, limit, Links::Followed)
}

/// A record opened for reading row by row; `watch` hears how far that has come.
pub(super) fn open_rows<'a>(path: &'a Path, watch: Watch<'a>) -> Result<impl BufRead + use<'a>, FileError> {
    let opened = open(path, RECORD)?;
    let all_bytes = opened.stated_bytes;
    let watched = Watched { opened, watch, share: ReadShare { file: path, done_bytes: 0, all_bytes } };
    Ok(BufReader::with_capacity(BYTES_AT_A_TIME, watched))
}

/// Bytes that are asked for at a time.
const BYTES_AT_A_TIME: usize = 1 << 20;

/// A file whose reading is watched.
struct Watched<'a> {
    opened: Opened,
    watch: Watch<'a>,
    share: ReadShare<'a>,
}

impl Read for Watched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.opened.read(buffer)?;
        self.share.done_bytes += read as u64;
        (self.watch)(self.share);
        Ok(read)
    }
}

/// The bytes of a file; links are followed.
///
/// # Errors
/// As [`open`], and when reading fails.
pub fn read(path: &Path, limit: SizeLimit) -> Result<Vec<u8>, FileError> {
    open(path, limit)?.bytes()
}

/// The bytes of a file that is no link.
///
/// # Errors
/// As [`read`], and [`FileError::Link`].
pub fn read_unlinked(path: &Path, limit: SizeLimit) -> Result<Vec<u8>, FileError> {
    open_checked(&std::fs::symlink_metadata(path)?, path, limit, Links::Refused)?.bytes()
}

/// The text of a file that muspin wrote; links are followed.
pub(crate) fn read_text(path: &Path, limit: SizeLimit) -> Result<String, FileError> {
    let bytes = read(path, limit)?;
    String::from_utf8(bytes).map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e.utf8_error()).into())
}

/// What is done with a link at the end of a path.
#[derive(Clone, Copy)]
enum Links {
    Followed,
    Refused,
}

/// Opens the file that was looked at; what has taken its place meanwhile is not waited for either.
fn open_checked(before: &Metadata, path: &Path, limit: SizeLimit, links: Links) -> Result<Opened, FileError> {
    check_regular(before.file_type())?;
    let mut options = OpenOptions::new();
    options.read(true);
    set_flags(&mut options, links);
    let file = options.open(path)?;
    let found = file.metadata()?;
    check_regular(found.file_type())?;
    if found.len() > limit.most_bytes {
        return Err(too_large(limit));
    }
    Ok(Opened { file, stated_bytes: found.len(), left_bytes: limit.most_bytes, limit })
}

fn too_large(limit: SizeLimit) -> FileError {
    FileError::TooLarge { most_bytes: limit.most_bytes, advice: limit.advice }
}

fn check_regular(found: FileType) -> Result<(), FileError> {
    match kind_of_special(found) {
        _ if found.is_file() => Ok(()),
        _ if found.is_dir() => Err(FileError::NotAFile { kind: "a folder" }),
        _ if found.is_symlink() => Err(FileError::Link),
        kind => Err(FileError::NotAFile { kind }),
    }
}

#[cfg(unix)]
fn kind_of_special(found: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match () {
        () if found.is_fifo() => "a pipe",
        () if found.is_socket() => "a socket",
        () => "a device",
    }
}

#[cfg(not(unix))]
fn kind_of_special(_: FileType) -> &'static str {
    "a device"
}

/// Opening a pipe must not wait for its writer, nor a terminal become that of the program.
#[cfg(unix)]
fn set_flags(options: &mut OpenOptions, links: Links) {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt;
    let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    let flags = match links {
        Links::Followed => flags,
        Links::Refused => flags | OFlags::NOFOLLOW,
    };
    options.custom_flags(flags.bits().cast_signed());
}

#[cfg(not(unix))]
fn set_flags(_: &mut OpenOptions, _: Links) {}
