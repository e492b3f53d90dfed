//! MATLAB level-5 files: matrices of doubles under their names, readable by MATLAB, Octave and SciPy (MathWorks,
//! "MAT-File Format", chapter 1). No clock is written, because the same input must give the same bytes.

use crate::linalg::Mat;
use std::io;

/// Every level-5 reader looks for this beginning.
const TEXT: &str = "MATLAB 5.0 MAT-file, written by muspin";
/// Length of the text, of the room behind it, and of both with version and byte order.
const TEXT_LENGTH: usize = 116;
const SUBSYSTEM_LENGTH: usize = 8;
/// Types of data elements.
const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// The class of a full real matrix of doubles.
const DOUBLE_CLASS: u32 = 6;

/// A level-5 file of real matrices, uncompressed, as bytes.
///
/// # Errors
/// [`io::Error`] where a matrix is too large for the format, 4 GiB.
pub fn mat_file(matrices: &[(&str, &Mat<f64>)]) -> io::Result<Vec<u8>> {
    let mut bytes = format!("{TEXT:TEXT_LENGTH$}").into_bytes();
    bytes.extend([0; SUBSYSTEM_LENGTH]);
    bytes.extend(0x0100_u16.to_le_bytes());
    bytes.extend(b"IM");
    for (name, matrix) in matrices {
        let sizes = [to_length(matrix.nrows())?, to_length(matrix.ncols())?];
        let values = (0..matrix.ncols()).flat_map(|j| (0..matrix.nrows()).map(move |i| matrix[(i, j)]));
        let mut element = vec![];
        push_element(&mut element, UINT32, &[DOUBLE_CLASS, 0].map(u32::to_le_bytes).concat())?;
        push_element(&mut element, INT32, &sizes.map(u32::to_le_bytes).concat())?;
        push_element(&mut element, INT8, name.as_bytes())?;
        push_element(&mut element, DOUBLE, &values.flat_map(f64::to_le_bytes).collect::<Vec<u8>>())?;
        push_element(&mut bytes, MATRIX, &element)?;
    }
    Ok(bytes)
}

/// Appends an element: type and length before its data, which end on a multiple of eight; up to four bytes stand in
/// one word with both.
fn push_element(bytes: &mut Vec<u8>, kind: u32, data: &[u8]) -> io::Result<()> {
    let length = to_length(data.len())?;
    if data.is_empty() || data.len() > 4 {
        bytes.extend([kind, length].map(u32::to_le_bytes).concat());
    } else {
        bytes.extend((length << 16 | kind).to_le_bytes());
    }
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    Ok(())
}

fn to_length(length: usize) -> io::Result<u32> {
    u32::try_from(length).map_err(io::Error::other)
}
