//! MATLAB level-5 files: matrices of doubles under their names, readable by MATLAB, Octave and SciPy.
//! The library writes the clock into the 116 bytes of text at the start; they are replaced by a fixed text, because
//! the same input must give the same bytes.

use crate::input::file;
use crate::linalg::Mat;
use matrw::{MatFile, MatVariable, MatlabType, NumericArray, save_matfile_v7};
use std::io;

/// Length of the descriptive text of a level-5 file.
const TEXT_LENGTH: usize = 116;
/// Every level-5 reader looks for this beginning.
const TEXT: &str = "MATLAB 5.0 MAT-file, written by muspin";

/// A level-5 file of real matrices, uncompressed, as bytes.
///
/// # Errors
/// An I/O error when the temporary file cannot be written, or when a matrix is refused by the format.
pub fn mat_file(matrices: &[(&str, &Mat<f64>)]) -> io::Result<Vec<u8>> {
    let mut file = MatFile::new();
    for (name, matrix) in matrices {
        let (rows, columns) = (matrix.nrows(), matrix.ncols());
        let data = (0..rows * columns).map(|k| matrix[(k % rows.max(1), k / rows.max(1))]).collect();
        let array = NumericArray::new(vec![rows, columns], MatlabType::F64(data), None)
            .map_err(|e| io::Error::other(format!("matrix {name}: {e:?}")))?;
        file.insert(name, MatVariable::NumericArray(array));
    }
    // The library writes to a path only.
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("matrices.mat");
    let text = path.to_str().ok_or_else(|| io::Error::other("temporary folder has a name that is not UTF-8"))?;
    save_matfile_v7(text, file, false).map_err(|e| io::Error::other(format!("{e:?}")))?;
    let mut bytes = file::read(&path, file::WRITTEN)?;
    let header =
        bytes.get_mut(..TEXT_LENGTH).ok_or_else(|| io::Error::other("level-5 file is shorter than its header"))?;
    header.fill(b' ');
    for (place, byte) in header.iter_mut().zip(TEXT.bytes()) {
        *place = byte;
    }
    Ok(bytes)
}
