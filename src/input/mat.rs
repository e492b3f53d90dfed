//! MATLAB level-5 files: a controller as A, B, C, D and Ts, as MATLAB (`save`, compressed or not), SciPy and muspin
//! write it.
//!
//! Source: MathWorks, MAT-File Format, level 5: a header of 128 bytes, then elements with tag (type, bytes) on
//! multiples of 8; a compressed element is one matrix behind zlib. MATLAB stores whole numbers in small types whatever
//! the class of the matrix.

use super::controller_law::{TaggedController, from_matrices};
use super::error::InputError;
use flate2::read::ZlibDecoder;
use std::io::Read;

const HEADER: usize = 128;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Largest matrix that is unpacked, bytes: a controller of a thousand states has eight megabytes.
const LARGEST: u64 = 64 << 20;
/// Flag of complex matrices.
const COMPLEX: u32 = 0x0800;

/// A real matrix of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    /// Its name.
    pub name: String,
    /// Its sizes.
    pub sizes: Vec<u32>,
    /// Its numbers, column after column; `None` for what is no full real matrix (text, structures, complex numbers).
    pub values: Option<Vec<f64>>,
}

impl Matrix {
    /// Rows of numbers, of a matrix with two sizes.
    fn rows(&self) -> Option<Vec<Vec<f64>>> {
        let (&[rows, columns], Some(values)) = (self.sizes.as_slice(), &self.values) else {
            return None;
        };
        let (rows, columns) = (rows as usize, columns as usize);
        if values.len() != rows.checked_mul(columns)? {
            return None;
        }
        let row = |i: usize| (0..columns).map(|j| values[i + j * rows]).collect();
        Some((0..rows).map(row).collect())
    }
}

/// The matrices of a file.
///
/// # Errors
/// [`InputError`] with the byte at which the file is not what the format says.
pub fn matrices(file: &str, bytes: &[u8]) -> Result<Vec<Matrix>, InputError> {
    let fail = |at: usize, rule: &str| {
        InputError::new(file, format!("byte {at}: {rule}")).with_hint(
            "a controller has A, B, C, D and Ts: save them with MATLAB's `save` (not -v7.3) or SciPy's \
                `savemat`",
        )
    };
    let little = match bytes.get(HEADER - 2..HEADER) {
        Some(b"IM") => true,
        Some(b"MI") => false,
        _ => {
            return Err(fail(HEADER - 2, "no byte order mark: not a MATLAB level-5 file"));
        }
    };
    let mut found = vec![];
    let mut at = HEADER;
    while at < bytes.len() {
        let element = element(bytes, at, little).ok_or_else(|| fail(at, "an element does not fit into the file"))?;
        let read = match element.kind {
            MATRIX => matrix(element.data, little),
            COMPRESSED => {
                unpacked(element.data, little).ok_or_else(|| fail(at, "a compressed element cannot be unpacked"))?
            }
            _ => return Err(fail(at, "neither a matrix nor a compressed one")),
        };
        found.push(read.ok_or_else(|| fail(at, "a matrix without sizes or name"))?);
        at = element.end;
    }
    Ok(found)
}

/// The matrix in a compressed element; none in it when it is something else.
fn unpacked(data: &[u8], little: bool) -> Option<Option<Matrix>> {
    let mut raw = vec![];
    let mut reader = ZlibDecoder::new(data).take(LARGEST);
    reader.read_to_end(&mut raw).ok()?;
    let inner = element(&raw, 0, little)?;
    (inner.kind == MATRIX).then(|| matrix(inner.data, little))
}

/// The controller of a file: A n×n, B n×4, C 4×n, D 4×4 and Ts; 0 is continuous time.
///
/// # Errors
/// [`InputError`] with the matrix that is missing or has other sizes.
pub fn read_controller(file: &str, bytes: &[u8]) -> Result<TaggedController, InputError> {
    let found = matrices(file, bytes)?;
    let named = |name: &str| {
        let matrix = found.iter().find(|m| m.name == name).ok_or_else(|| {
            let names: Vec<&str> = found.iter().map(|m| m.name.as_str()).collect();
            InputError::new(file, format!("has no matrix {name}; it has: {}", names.join(", ")))
                .with_hint("a controller has A, B, C, D and Ts")
        })?;
        matrix.rows().ok_or_else(|| {
            InputError::new(file, format!("{name}: is no full real matrix of two sizes"))
                .with_hint("write it with full(double(...))")
        })
    };
    let period = named("Ts")?;
    let [[period_s]] = [period.first().map_or(&[][..], Vec::as_slice)] else {
        return Err(InputError::new(file, "Ts: must be one number").with_hint("0 means continuous time"));
    };
    let parts = [named("A")?, named("B")?, named("C")?, named("D")?];
    let stem = std::path::Path::new(file).file_stem();
    let name = stem.map_or("controller".into(), |s| s.to_string_lossy());
    from_matrices(file, &name, parts, *period_s)
}

struct Element<'a> {
    kind: u32,
    data: &'a [u8],
    /// Where the next element begins.
    end: usize,
}

fn word(bytes: &[u8], at: usize, little: bool) -> Option<u32> {
    let raw: [u8; 4] = bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
    Some(if little { u32::from_le_bytes(raw) } else { u32::from_be_bytes(raw) })
}

fn element(bytes: &[u8], at: usize, little: bool) -> Option<Element<'_>> {
    let first = word(bytes, at, little)?;
    // Small elements carry type and size in one word and up to four bytes behind it.
    if first >> 16 != 0 {
        let size = (first >> 16) as usize;
        let data = bytes.get(at + 4..at + 4 + size.min(4))?;
        return Some(Element { kind: first & 0xffff, data, end: at + 8 });
    }
    let size = word(bytes, at + 4, little)? as usize;
    let data = bytes.get(at + 8..at.checked_add(8 + size)?)?;
    // Compressed elements are not padded.
    let padded = if first == COMPRESSED { size } else { size.next_multiple_of(8) };
    Some(Element { kind: first, data, end: at + 8 + padded })
}

/// Array flags, sizes, name, numbers: the first four elements of a matrix.
fn matrix(data: &[u8], little: bool) -> Option<Matrix> {
    let flags = element(data, 0, little)?;
    let sizes = element(data, flags.end, little)?;
    let name = element(data, sizes.end, little)?;
    let count = sizes.data.len() / 4;
    let flag = word(flags.data, 0, little)?;
    // Classes 6 to 15: double, single and the whole numbers.
    let real = (6..=15).contains(&(flag & 0xff)) && flag & COMPLEX == 0;
    let values = if real { element(data, name.end, little).and_then(|e| numbers(&e, little)) } else { None };
    Some(Matrix {
        name: String::from_utf8_lossy(name.data).into_owned(),
        sizes: (0..count).filter_map(|k| word(sizes.data, 4 * k, little)).collect(),
        values,
    })
}

/// The numbers of an element of any numeric type.
fn numbers(element: &Element<'_>, little: bool) -> Option<Vec<f64>> {
    let width = match element.kind {
        1 | 2 => 1,
        3 | 4 => 2,
        5..=7 => 4,
        9 | 12 | 13 => 8,
        _ => return None,
    };
    let one = |raw: &[u8]| {
        let mut bytes = [0u8; 8];
        for (k, byte) in raw.iter().enumerate() {
            bytes[if little { k } else { width - 1 - k }] = *byte;
        }
        let [a, b, c, d, ..] = bytes;
        match element.kind {
            1 => f64::from(a as i8),
            2 => f64::from(a),
            3 => f64::from(i16::from_le_bytes([a, b])),
            4 => f64::from(u16::from_le_bytes([a, b])),
            5 => f64::from(i32::from_le_bytes([a, b, c, d])),
            6 => f64::from(u32::from_le_bytes([a, b, c, d])),
            7 => f64::from(f32::from_le_bytes([a, b, c, d])),
            12 => i64::from_le_bytes(bytes) as f64,
            13 => u64::from_le_bytes(bytes) as f64,
            _ => f64::from_le_bytes(bytes),
        }
    };
    Some(element.data.chunks_exact(width).map(one).collect())
}
