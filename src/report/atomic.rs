//! Outputs appear whole or not at all: everything is written beside its place, then renamed into it.

use std::io::{self, Write};
use std::path::Path;

/// Writes a file through a temporary sibling and a rename; creates parent folders.
///
/// # Errors
/// Any error of the file system, with nothing left at `path` that was not there before.
pub fn write_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let parent = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(parent)?;
    let mut file = readable(tempfile::Builder::new()).tempfile_in(parent)?;
    file.write_all(bytes)?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// A temporary file is private; what it becomes is a result that others may read, as far as the user's mask allows.
#[cfg(unix)]
fn readable<'a, 'b>(mut builder: tempfile::Builder<'a, 'b>) -> tempfile::Builder<'a, 'b> {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(std::fs::Permissions::from_mode(0o666));
    builder
}

#[cfg(not(unix))]
fn readable<'a, 'b>(builder: tempfile::Builder<'a, 'b>) -> tempfile::Builder<'a, 'b> {
    builder
}
