//! Standard output: data, through one locked buffer. A reader that has gone away (`| head`) is a quiet end, not an
//! error.

use super::Failure;
use std::io::{BufWriter, ErrorKind, Write};

/// Runs `write` on locked, buffered standard output.
pub(super) fn data(write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<(), Failure> {
    let mut out = BufWriter::new(std::io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}
