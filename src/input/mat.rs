//! MATLAB level-5 files: a controller as A, B, C, D and Ts, as MATLAB (`save`, compressed or not), SciPy and muspin
//! write it.
//!
//! Source: MathWorks, MAT-File Format, level 5: a header of 128 bytes, then elements with tag (type, bytes) on
//! multiples of 8; a compressed element is one matrix behind zlib. MATLAB stores whole numbers in small types whatever
//! the class of the matrix.
//!
//! Sizes are checked before anything is made of them, all matrices of a file share one budget, and variables of other
//! names are passed over behind their name.

use super::controller_law::{MOST_STATES, TaggedController, from_matrices};
use super::error::InputError;
use super::error_list::ErrorList;
use super::file;
use flate2::read::ZlibDecoder;
use std::io::Read;
use std::path::Path;

const HEADER: usize = 128;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Flag of complex matrices.
const COMPLEX: u32 = 0x0800;
/// Class of objects, which have no sizes.
const OPAQUE: u32 = 17;
/// Most bytes of numbers that are unpacked of a file: a controller of a thousand states has eight megabytes.
const BUDGET_BYTES: u64 = 64 << 20;
const MOST_VARIABLES: usize = 10_000;
/// Most sizes of a matrix and longest name that are read, bytes: MATLAB's own names have 63 at most.
const MOST_SIZES_BYTES: u32 = 4 * 32;
const LONGEST_NAME_BYTES: u32 = 256;
/// First bytes of HDF5, at the beginning of a file or behind MATLAB's 512 bytes.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Matrices of a controller.
const CONTROLLER: [&str; 5] = ["A", "B", "C", "D", "Ts"];

/// A real matrix of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    /// Its name.
    pub name: String,
    /// Its sizes.
    pub sizes: Vec<u32>,
    /// Its numbers, column after column; `None` for what is no full real matrix (text, structures, complex numbers) and
    /// for what was passed over.
    pub values: Option<Vec<f64>>,
}

impl Matrix {
    /// Rows of numbers, of a matrix with two sizes that fit a controller.
    fn rows(&self, file: &str) -> Result<Vec<Vec<f64>>, InputError> {
        let name = &self.name;
        let (&[rows, columns], Some(values)) = (self.sizes.as_slice(), &self.values) else {
            return Err(InputError::new(file, format!("{name}: is no full real matrix of two sizes"))
                .with_hint("write it with full(double(...))"));
        };
        let (rows, columns) = (rows as usize, columns as usize);
        if rows.max(columns) > MOST_STATES {
            let rule = format!("{name}: is {rows} × {columns}; a controller has {MOST_STATES} states at most");
            return Err(InputError::new(file, rule).with_hint("reduce the order first"));
        }
        let row = |i: usize| (0..columns).map(|j| values[i + j * rows]).collect();
        Ok((0..rows).map(row).collect())
    }
}

/// The matrices of a file.
///
/// # Errors
/// [`InputError`] with the byte at which the file is not what the format says.
pub fn matrices(file: &str, bytes: &[u8]) -> Result<Vec<Matrix>, InputError> {
    let mut found = vec![];
    each_variable(file, bytes, &|_| true, &mut |matrix| found.push(matrix))?;
    Ok(found)
}

/// Calls back for every variable; the numbers of those that are not wanted are passed over.
fn each_variable(
    file: &str,
    bytes: &[u8],
    wanted: &dyn Fn(&str) -> bool,
    see: &mut dyn FnMut(Matrix),
) -> Result<(), InputError> {
    let fail = |at: usize, rule: &str| {
        InputError::new(file, format!("byte {at}: {rule}")).with_hint(
            "a controller has A, B, C, D and Ts: save them with MATLAB's `save` (not -v7.3) or SciPy's \
                `savemat`",
        )
    };
    let is_hdf5 = [0, 512].iter().any(|at| bytes.get(*at..).is_some_and(|rest| rest.starts_with(HDF5)));
    if is_hdf5 || bytes.starts_with(b"MATLAB 7.3") {
        return Err(InputError::new(file, "is a MATLAB file of version 7.3 (HDF5), which muspin does not read")
            .with_hint("save it again with save('controller.mat', 'A', 'B', 'C', 'D', 'Ts', '-v7')"));
    }
    let little = match bytes.get(HEADER - 2..HEADER) {
        Some(b"IM") => true,
        Some(b"MI") => false,
        _ => {
            return Err(fail(HEADER - 2, "no byte order mark: not a MATLAB level-5 file"));
        }
    };
    let mut reader = Variables { little, wanted, left_bytes: BUDGET_BYTES };
    let mut at = HEADER;
    for _ in 0..MOST_VARIABLES {
        if at >= bytes.len() {
            return Ok(());
        }
        let head = Head::read(&mut bytes.get(at..).unwrap_or_default(), little).map_err(|rule| fail(at, rule))?;
        let data_at = at + Head::BYTES;
        let end = data_at.checked_add(head.bytes as usize).filter(|end| *end <= bytes.len());
        let Some(data) = end.filter(|_| head.inline.is_none()).and_then(|end| bytes.get(data_at..end)) else {
            return Err(fail(at, "an element does not fit into the file"));
        };
        let read = match head.kind {
            MATRIX => reader.matrix(&mut &*data),
            COMPRESSED => reader.read_compressed(data),
            _ => Err("neither a matrix nor a compressed one"),
        };
        see(read.map_err(|rule| fail(at, rule))?);
        // Compressed elements are not padded.
        at = data_at + if head.kind == COMPRESSED { data.len() } else { data.len().next_multiple_of(8) };
    }
    if at < bytes.len() { Err(fail(at, "the file has too many variables")) } else { Ok(()) }
}

/// The controller of a file.
pub(crate) fn load_controller(source: &str) -> Result<TaggedController, InputError> {
    let bytes = file::read(Path::new(source), file::MATLAB).map_err(|error| error.of(source))?;
    read_controller(source, &bytes)
}

/// The controller of a file: A n×n, B n×4, C 4×n, D 4×4 and Ts; 0 is continuous time.
///
/// # Errors
/// [`InputError`] with the matrix that is missing or has other sizes.
pub fn read_controller(file: &str, bytes: &[u8]) -> Result<TaggedController, InputError> {
    let mut found: Vec<Matrix> = vec![];
    /// Names that are told when one is missing.
    const NAMED: usize = 20;
    let mut names: Vec<String> = vec![];
    each_variable(file, bytes, &|name| CONTROLLER.contains(&name), &mut |matrix| {
        if names.len() < NAMED {
            names.push(matrix.name.clone());
        }
        if CONTROLLER.contains(&matrix.name.as_str()) {
            found.push(matrix);
        }
    })?;
    let named = |name: &str| {
        let mut all = found.iter().filter(|m| m.name == name);
        match (all.next(), all.next()) {
            (Some(one), None) => one.rows(file),
            (Some(_), Some(_)) => Err(InputError::new(file, format!("has two matrices {name}"))
                .with_hint("save the controller alone: A, B, C, D and Ts")),
            (None, _) => Err(InputError::new(file, format!("has no matrix {name}; it has: {}", names.join(", ")))
                .with_hint("a controller has A, B, C, D and Ts")),
        }
    };
    let period = named("Ts")?;
    let [[period_s]] = [period.first().map_or(&[][..], Vec::as_slice)] else {
        return Err(InputError::new(file, "Ts: must be one number").with_hint("0 means continuous time"));
    };
    let parts = [named("A")?, named("B")?, named("C")?, named("D")?];
    let stem = std::path::Path::new(file).file_stem();
    let name = stem.map_or("controller".into(), |s| s.to_string_lossy());
    let mut errors = ErrorList::new(file, "");
    let controller = from_matrices(&mut errors, &name, parts, *period_s);
    errors.finish(controller)
}

/// What is wrong with an element.
type Fault = &'static str;

/// Type and size of an element; a small one has its up to four bytes in the same eight.
struct Head {
    kind: u32,
    bytes: u32,
    inline: Option<[u8; 4]>,
}

impl Head {
    const BYTES: usize = 8;

    fn read(reader: &mut dyn Read, little: bool) -> Result<Self, Fault> {
        let [a, b, c, d, rest @ ..] = array::<{ Self::BYTES }>(reader)?;
        let (first, second) = (word([a, b, c, d], little), word(rest, little));
        Ok(match first >> 16 {
            0 => Self { kind: first, bytes: second, inline: None },
            size => Self { kind: first & 0xffff, bytes: size.min(4), inline: Some(rest) },
        })
    }

    /// The data of an element that has few of them.
    fn data(&self, reader: &mut dyn Read, most: u32, too_long: Fault) -> Result<Vec<u8>, Fault> {
        if let Some(inline) = self.inline {
            return Ok(inline[..self.bytes as usize].to_vec());
        }
        if self.bytes > most {
            return Err(too_long);
        }
        let mut data = vec![0; self.bytes.next_multiple_of(8) as usize];
        reader.read_exact(&mut data).map_err(|_| ENDED)?;
        data.truncate(self.bytes as usize);
        Ok(data)
    }
}

const ENDED: Fault = "a matrix ends too early, or cannot be unpacked";

fn array<const N: usize>(reader: &mut dyn Read) -> Result<[u8; N], Fault> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes).map_err(|_| ENDED)?;
    Ok(bytes)
}

fn word(bytes: [u8; 4], little: bool) -> u32 {
    if little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }
}

/// Reads variables within what is left of the budget of their file.
struct Variables<'a> {
    little: bool,
    wanted: &'a dyn Fn(&str) -> bool,
    left_bytes: u64,
}

impl Variables<'_> {
    /// The matrix in a compressed element.
    fn read_compressed(&mut self, data: &[u8]) -> Result<Matrix, Fault> {
        let mut reader = ZlibDecoder::new(data);
        let head = Head::read(&mut reader, self.little)?;
        if head.kind != MATRIX {
            return Err("a compressed element that is no matrix");
        }
        let matrix = self.matrix(&mut reader)?;
        if matrix.values.is_some() {
            // The checksum stands at the end; nothing but padding lies in front of it.
            let mut rest = vec![];
            let ended = reader.take(Head::BYTES as u64 + 1).read_to_end(&mut rest).is_ok();
            if !ended || rest.len() > Head::BYTES {
                return Err("a compressed matrix that is damaged");
            }
        }
        Ok(matrix)
    }

    /// Array flags, sizes, name, numbers: the first four elements of a matrix.
    fn matrix(&mut self, reader: &mut dyn Read) -> Result<Matrix, Fault> {
        const UNNAMED: Fault = "a matrix without sizes or name";
        let few = |reader: &mut dyn Read, most: u32| Head::read(reader, self.little)?.data(reader, most, UNNAMED);
        let flags = few(reader, 8)?;
        let flag = flags.first_chunk().map(|raw| word(*raw, self.little)).ok_or(UNNAMED)?;
        let class = flag & 0xff;
        let sizes = if class == OPAQUE { vec![] } else { few(reader, MOST_SIZES_BYTES)? };
        let name = String::from_utf8_lossy(&few(reader, LONGEST_NAME_BYTES)?).into_owned();
        let (chunks, _) = sizes.as_chunks::<4>();
        let sizes: Vec<u32> = chunks.iter().map(|raw| word(*raw, self.little)).collect();
        // Classes 6 to 15: double, single and the whole numbers.
        let is_real = (6..=15).contains(&class) && flag & COMPLEX == 0;
        let values = if is_real && (self.wanted)(&name) { Some(self.numbers(reader, &sizes)?) } else { None };
        Ok(Matrix { name, sizes, values })
    }

    /// The numbers of a matrix of these sizes.
    fn numbers(&mut self, reader: &mut dyn Read, sizes: &[u32]) -> Result<Vec<f64>, Fault> {
        let count = sizes.iter().try_fold(1u64, |all, size| all.checked_mul(u64::from(*size)));
        let count = count.ok_or("a matrix of impossible sizes")?;
        let head = Head::read(reader, self.little)?;
        let width = width_of(head.kind).ok_or("a matrix of an unknown number type")?;
        if count.checked_mul(width as u64) != Some(u64::from(head.bytes)) {
            return Err("a matrix whose sizes do not fit its numbers");
        }
        // A number takes eight bytes here, whatever it takes in the file.
        let left = count.checked_mul(8).and_then(|bytes| self.left_bytes.checked_sub(bytes));
        self.left_bytes = left.ok_or("the matrices so far take more than 64 MiB; a thousand states take 8 MB")?;
        let inline = head.inline.unwrap_or_default();
        let mut inline = &inline[..];
        let data: &mut dyn Read = if head.inline.is_some() { &mut inline } else { reader };
        let mut values = Vec::with_capacity(count as usize);
        let mut bytes = [0; 8];
        for _ in 0..count {
            let raw = bytes.get_mut(..width).ok_or(ENDED)?;
            data.read_exact(raw).map_err(|_| ENDED)?;
            if !self.little {
                raw.reverse();
            }
            values.push(number(head.kind, bytes));
        }
        Ok(values)
    }
}

/// Bytes of a number of a type.
fn width_of(kind: u32) -> Option<usize> {
    match kind {
        1 | 2 => Some(1),
        3 | 4 => Some(2),
        5..=7 => Some(4),
        9 | 12 | 13 => Some(8),
        _ => None,
    }
}

/// A number of a type, lowest byte first.
fn number(kind: u32, bytes: [u8; 8]) -> f64 {
    let [a, b, c, d, ..] = bytes;
    match kind {
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
}
