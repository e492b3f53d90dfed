//! Universal files: dataset 58 (ASCII) and 58b (binary), functions at nodal degrees of freedom, with dataset 164
//! (units).
//!
//! Source: SDRC I-DEAS universal file documentation, dataset 58, as kept by UC-SDRL. Real and complex, single and
//! double precision, even and uneven abscissa, either byte order. Header text may be in any encoding. Byte counts in
//! 58b headers are often wrong in the wild: the length follows from the number of values, and the terminator after them
//! is checked.
//! Limits: VAX and IBM floating point are refused; other datasets are skipped.

use super::error::InputError;
use super::file::{self, UNIVERSAL};
use super::shipped::BYTE_ORDER_MARK;
pub use super::uff_units::UffSystem;
use super::uff_units::read_system;
use crate::linalg::c64;
use std::path::Path;

/// Header lines of a dataset 58 after its identifier line.
const HEADER_LINES: usize = 11;
/// Characters of a line that are looked at: the format has 80 columns.
const LONGEST_LINE: usize = 1024;
/// Most functions of a file: a modal test has thousands.
const MOST_FUNCTIONS: usize = 100_000;

/// Axis of a function: what is plotted and in which unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UffAxis {
    /// Specific data type: 8 displacement, 11 velocity, 12 acceleration, 13 excitation force, 17 time, 18 frequency, …
    pub kind: i64,
    /// Axis label.
    pub label: String,
    /// Units label.
    pub units: String,
}

/// One dataset 58.
#[derive(Clone, Debug, PartialEq)]
pub struct UffFunction {
    /// Line of its identifier, from 1.
    pub line: usize,
    /// ID line 1.
    pub description: String,
    /// Function type: 1 time response, 4 frequency response, 6 coherence, 9 power spectral density, …
    pub function_type: i64,
    /// Response node and direction.
    pub response: (i64, i64),
    /// Reference node and direction.
    pub reference: (i64, i64),
    /// Abscissa.
    pub abscissa: UffAxis,
    /// Ordinate numerator.
    pub ordinate: UffAxis,
    /// Ordinate denominator.
    pub denominator: UffAxis,
    /// Abscissa values.
    pub x: Vec<f64>,
    /// Ordinate values; imaginary part zero for real data.
    pub y: Vec<c64>,
    /// True for complex ordinates.
    pub complex: bool,
    /// Units of the file (dataset 164 before it), where it states them.
    pub system: Option<UffSystem>,
}

/// All functions of a universal file.
///
/// # Errors
/// As [`read`], and when the file cannot be read.
pub fn load(file: &str) -> Result<Vec<UffFunction>, InputError> {
    let bytes = file::read(Path::new(file), UNIVERSAL).map_err(|error| error.of(file))?;
    read(file, &bytes)
}

/// All functions of a universal file, from its bytes.
///
/// # Errors
/// [`InputError`] with the line of a dataset that is broken or in a number format that cannot be read.
pub fn read(file: &str, bytes: &[u8]) -> Result<Vec<UffFunction>, InputError> {
    let mark = BYTE_ORDER_MARK.to_string();
    let mut cursor = Cursor { bytes: bytes.strip_prefix(mark.as_bytes()).unwrap_or(bytes), at: 0, line: 1 };
    let mut functions = vec![];
    let mut system = None;
    let mut any = false;
    while let Some(text) = cursor.next_line() {
        if text.trim() != "-1" {
            continue;
        }
        let line = cursor.line;
        let Some(identifier) = cursor.next_line() else {
            break;
        };
        any = true;
        let head = identifier.trim_start();
        let number: String = head.chars().take_while(char::is_ascii_digit).collect();
        let binary = head[number.len()..].starts_with(['b', 'B']);
        match number.as_str() {
            "58" => {
                let mut function = function(file, &mut cursor, &identifier, line, binary)?;
                function.system.clone_from(&system);
                functions.push(function);
                if functions.len() > MOST_FUNCTIONS {
                    let rule = format!("has more than {MOST_FUNCTIONS} functions");
                    return Err(InputError::new(file, rule).with_hint(UNIVERSAL.advice()));
                }
                cursor.skip_dataset();
            }
            "164" => {
                system = Some(unit_system(file, &mut cursor, line)?);
                cursor.skip_dataset();
            }
            _ => cursor.skip_dataset(),
        }
    }
    if !any {
        return Err(InputError::new(file, "no dataset: not a universal file")
            .with_hint("a universal file consists of datasets between lines with -1 in columns 5 and 6"));
    }
    Ok(functions)
}

/// The system of units of a dataset 164 behind its identifier.
fn unit_system(file: &str, cursor: &mut Cursor<'_>, line: usize) -> Result<UffSystem, InputError> {
    let head = cursor.next_line().unwrap_or_default();
    let code = split_columns(&head, &[10])[0].trim().parse().ok();
    let text = cursor.next_line().unwrap_or_default();
    let by_blanks: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
    let by_width = || split_columns(text.trim_end(), &[25; 3]).iter().filter_map(|f| number(f)).collect();
    let factors = by_blanks.unwrap_or_else(by_width);
    read_system(code, &factors).map_err(|message| {
        let mut e = InputError::new(file, format!("dataset 164: {message}"));
        e.line = Some(line);
        e.with_hint("correct the units of the file: code 1 is SI, 7 inch and pound-force, 9 defined by its factors")
    })
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl Cursor<'_> {
    /// Next line without its end, any encoding; `None` at the end of the file.
    fn next_line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|r| !r.is_empty())?;
        let end = rest.iter().position(|b| *b == b'\n');
        let (text, step) = match end {
            Some(k) => (&rest[..k], k + 1),
            None => (rest, rest.len()),
        };
        self.at += step;
        self.line += 1;
        let text = text.strip_suffix(b"\r").unwrap_or(text);
        // Latin-1: every byte is a character, so that columns stay columns.
        Some(text.iter().take(LONGEST_LINE).map(|b| char::from(*b)).collect())
    }

    /// Skips to behind the terminator of the current dataset.
    fn skip_dataset(&mut self) {
        while let Some(text) = self.next_line() {
            if text.trim() == "-1" {
                return;
            }
        }
    }

    /// True when the next line that is not empty is a terminator, or the file ends.
    fn at_terminator(&self, from: usize) -> bool {
        let mut probe = Cursor { bytes: self.bytes, at: from, line: 0 };
        while let Some(text) = probe.next_line() {
            if !text.trim().is_empty() {
                return text.trim() == "-1";
            }
        }
        true
    }
}

fn function(
    file: &str,
    cursor: &mut Cursor<'_>,
    identifier: &str,
    line: usize,
    binary: bool,
) -> Result<UffFunction, InputError> {
    let fail = |message: String| {
        let mut e = InputError::new(file, format!("dataset 58: {message}"));
        e.line = Some(line);
        e.with_hint("export the function again as dataset 58, ASCII, or as 58b with IEEE numbers")
    };
    let header: Vec<String> = (0..HEADER_LINES).map_while(|_| cursor.next_line()).collect();
    if header.len() < HEADER_LINES {
        return Err(fail("the file ends inside the header".into()));
    }
    let dof = split_columns(&header[5], &[5, 10, 5, 10, 11, 10, 4, 11, 10, 4]);
    let data = split_columns(&header[6], &[10, 10, 10, 13, 13, 13]);
    let whole = |text: &str, what: &str| {
        text.trim().parse::<i64>().map_err(|_| fail(format!("{what} {:?} is not a whole number", text.trim())))
    };
    let real =
        |text: &str, what: &str| number(text).ok_or_else(|| fail(format!("{what} {:?} is not a number", text.trim())));
    let function_type = whole(&dof[0], "function type")?;
    let (kind, count) = (whole(&data[0], "ordinate data type")?, whole(&data[1], "number of values")?);
    let even = match whole(&data[2], "abscissa spacing")? {
        0 => false,
        1 => true,
        other => return Err(fail(format!("abscissa spacing {other} is neither 0 nor 1"))),
    };
    let (complex, double) =
        ordinate_type(kind).ok_or_else(|| fail(format!("ordinate data type {kind} is none of 2, 4, 5, 6")))?;
    let per_point = usize::from(!even) + if complex { 2 } else { 1 };
    // A number takes at least a digit and a blank: a larger count is a damaged header, not a reason to allocate.
    let fits = |n: &usize| n.checked_mul(2 * per_point).is_some_and(|bytes| bytes <= cursor.bytes.len());
    let count = usize::try_from(count).ok().filter(fits);
    let count = count.ok_or_else(|| fail(format!("{} values do not fit into the file", data[1].trim())))?;
    let (mut x, mut y) = (vec![], vec![]);
    if x.try_reserve_exact(count).is_err() || y.try_reserve_exact(count).is_err() {
        return Err(fail(format!("{count} values do not fit into the memory")));
    }
    let values = if binary {
        let order = identifier.get(7..13).map_or("", str::trim);
        let format = identifier.get(13..19).map_or("", str::trim);
        if !matches!(format, "" | "2") {
            return Err(fail(format!("floating-point format {format} (1 VAX, 2 IEEE, 5 IBM): only IEEE can be read")));
        }
        let little = match order {
            "1" | "" => true,
            "2" => false,
            other => {
                return Err(fail(format!("byte order {other:?} is neither 1 (little endian) nor 2")));
            }
        };
        binary_values(cursor, count, even, complex, double, little).map_err(fail)?
    } else {
        ascii_values(cursor, count * per_point, even, double).map_err(fail)?
    };
    let start = real(&data[3], "abscissa minimum")?;
    let step = real(&data[4], "abscissa increment")?;
    for (k, point) in values.chunks_exact(per_point).enumerate() {
        let (at, rest) = if even { (start + step * k as f64, point) } else { (point[0], &point[1..]) };
        x.push(at);
        y.push(c64::new(rest[0], if complex { rest[1] } else { 0.0 }));
    }
    let place = |a: &str, b: &str| (a.trim().parse().unwrap_or(0), b.trim().parse().unwrap_or(0));
    Ok(UffFunction {
        line,
        description: header[0].trim().to_owned(),
        function_type,
        response: place(&dof[5], &dof[6]),
        reference: place(&dof[8], &dof[9]),
        abscissa: axis(&header[7]),
        ordinate: axis(&header[8]),
        denominator: axis(&header[9]),
        x,
        y,
        complex,
        system: None,
    })
}

/// Fields of fixed width, short lines padded with nothing.
fn split_columns(text: &str, widths: &[usize]) -> Vec<String> {
    let chars: Vec<char> = text.chars().collect();
    let mut at = 0;
    widths
        .iter()
        .map(|w| {
            let field = chars.iter().skip(at).take(*w).collect();
            at += w;
            field
        })
        .collect()
}

/// A Fortran or C number.
fn number(text: &str) -> Option<f64> {
    let text = text.trim().replace(['D', 'd'], "e");
    if text.is_empty() {
        return Some(0.0);
    }
    text.parse().ok()
}

fn ascii_values(cursor: &mut Cursor<'_>, wanted: usize, even: bool, double: bool) -> Result<Vec<f64>, String> {
    // Widths of one line; fields may touch, so that blanks do not separate them.
    let widths: &[usize] = match (double, even, wanted) {
        (false, ..) => &[13; 6],
        (true, true, _) => &[20; 4],
        (true, false, _) => &[13, 20, 20],
    };
    let pair: &[usize] = &[13, 20, 13, 20];
    let mut values = vec![];
    values.try_reserve_exact(wanted).map_err(|_| format!("{wanted} numbers do not fit into the memory"))?;
    while values.len() < wanted {
        let line = cursor.line;
        let Some(text) = cursor.next_line() else {
            return Err(format!("the file ends after {} of {wanted} numbers", values.len()));
        };
        if text.trim() == "-1" {
            return Err(format!("line {line}: the dataset ends after {} of {wanted} numbers", values.len()));
        }
        let by_blanks: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        let by_width = |widths: &[usize]| -> Option<Vec<f64>> {
            split_columns(text.trim_end(), widths).iter().filter(|f| !f.trim().is_empty()).map(|f| number(f)).collect()
        };
        let row = by_blanks.or_else(|| by_width(widths)).or_else(|| by_width(pair));
        match row {
            Some(row) => values.extend(row),
            None => {
                return Err(format!("line {line}: {:?} is not a row of numbers", text.trim()));
            }
        }
    }
    values.truncate(wanted);
    Ok(values)
}

fn binary_values(
    cursor: &mut Cursor<'_>,
    count: usize,
    even: bool,
    complex: bool,
    double: bool,
    little: bool,
) -> Result<Vec<f64>, String> {
    let ordinates = if complex { 2 } else { 1 };
    let size = if double { 8 } else { 4 };
    // Uneven abscissae are single precision by the book and as wide as the ordinate in many files: the terminator
    // tells.
    let widths: &[usize] = match (even, double) {
        (true, _) => &[0],
        (false, false) => &[4],
        (false, true) => &[4, 8],
    };
    let start = cursor.at;
    let fits = |x: &usize| {
        let length = count * (x + ordinates * size);
        start + length <= cursor.bytes.len() && cursor.at_terminator(start + length)
    };
    let Some(x_size) = widths.iter().copied().find(fits) else {
        return Err(format!(
            "{count} values of {size} bytes are not followed by the end of the dataset: damaged, or another number \
             format"
        ));
    };
    let mut at = start;
    let mut take = |width: usize| -> f64 {
        let raw = &cursor.bytes[at..at + width];
        at += width;
        let mut wide = [0u8; 8];
        for (k, b) in raw.iter().enumerate() {
            wide[if little { k } else { width - 1 - k }] = *b;
        }
        if width == 4 {
            f64::from(f32::from_le_bytes([wide[0], wide[1], wide[2], wide[3]]))
        } else {
            f64::from_le_bytes(wide)
        }
    };
    let mut values = Vec::new();
    for _ in 0..count {
        if x_size > 0 {
            values.push(take(x_size));
        }
        for _ in 0..ordinates {
            values.push(take(size));
        }
    }
    cursor.at = at;
    Ok(values)
}

/// Kind, label and unit of an axis of a function.
fn axis(text: &str) -> UffAxis {
    let f = split_columns(text, &[10, 5, 5, 5, 21, 21]);
    UffAxis { kind: f[0].trim().parse().unwrap_or(0), label: f[4].trim().to_owned(), units: f[5].trim().to_owned() }
}

/// Whether the values of an ordinate data type are complex, and double precision.
fn ordinate_type(kind: i64) -> Option<(bool, bool)> {
    match kind {
        2 => Some((false, false)),
        4 => Some((false, true)),
        5 => Some((true, false)),
        6 => Some((true, true)),
        _ => None,
    }
}
