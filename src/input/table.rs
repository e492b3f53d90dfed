//! Rows of a CSV file under a fixed header, each with its line for messages. A file is read line by line: memory grows
//! with what the reader keeps of the rows, not with the text.

use super::error::InputError;
use super::file::FileError;
use super::shipped::{BYTE_ORDER_MARK, not_utf8};
use std::io::{BufRead, ErrorKind};

/// Longest line, bytes: the nineteen columns of a sweep take about five hundred.
const LONGEST_LINE: usize = 4096;

/// Lines of a text, each with its number from 1, whatever ends them.
struct Lines<'a, R> {
    file: &'a str,
    reader: R,
    bytes: Vec<u8>,
    line: usize,
}

impl<'a, R: BufRead> Lines<'a, R> {
    fn of(file: &'a str, reader: R) -> Self {
        Self { file, reader, bytes: vec![], line: 0 }
    }

    /// Number and text, without its end, of the next line; none after the last one.
    fn next_line(&mut self) -> Result<Option<(usize, &str)>, InputError> {
        self.bytes.clear();
        self.line += 1;
        let mut any = false;
        loop {
            let there = match self.reader.fill_buf() {
                Ok(there) => there,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => return Err(FileError::System(error).of(self.file)),
            };
            if there.is_empty() {
                break;
            }
            any = true;
            let end = there.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let part = &there[..end.unwrap_or(there.len())];
            if self.bytes.len() + part.len() > LONGEST_LINE {
                let rule = format!("has more than {LONGEST_LINE} bytes in one line: it is no table of numbers");
                return Err(at(self.file, self.line, rule)
                    .with_hint("the file must be comma-separated UTF-8 text with one header line"));
            }
            self.bytes.extend_from_slice(part);
            let Some(end) = end else {
                let all = there.len();
                self.reader.consume(all);
                continue;
            };
            let is_return = there[end] == b'\r';
            self.reader.consume(end + 1);
            if is_return && self.reader.fill_buf().is_ok_and(|rest| rest.first() == Some(&b'\n')) {
                self.reader.consume(1);
            }
            break;
        }
        match std::str::from_utf8(&self.bytes) {
            _ if !any => Ok(None),
            Ok(text) => Ok(Some((self.line, text))),
            Err(_) => Err(not_utf8(self.file, self.line, &self.bytes)),
        }
    }
}

/// The first line of a file.
pub(super) fn first_line(file: &str, reader: impl BufRead) -> Result<String, InputError> {
    Ok(Lines::of(file, reader).next_line()?.map_or_else(String::new, |(_, text)| text.to_owned()))
}

pub(super) struct Columns<'a> {
    pub names: &'a [String],
    /// How many of the last ones may be missing, together.
    pub optional: usize,
}

/// Calls back for every row below the header: its line, and a field for every column that is there.
pub(super) fn each_row(
    file: &str,
    reader: impl BufRead,
    columns: &Columns<'_>,
    see: &mut dyn FnMut(usize, &[&str]) -> Result<(), InputError>,
) -> Result<(), InputError> {
    let mut lines = Lines::of(file, reader);
    let (mut below_header, mut names) = (false, columns.names);
    while let Some((line, text)) = lines.next_line()? {
        if text.trim().is_empty() {
            continue;
        }
        let fields: Vec<&str> = text.split(',').map(strip_quotes).collect();
        if !below_header {
            let least = names.len() - columns.optional;
            names = if fields.len() == least { &names[..least] } else { names };
            check_header(file, line, &fields, names)?;
            below_header = true;
            continue;
        }
        if fields.len() != names.len() {
            let rule = format!("{} columns, the header has {}", fields.len(), names.len());
            let error = at(file, line, rule);
            return Err(if names.len() == 1 {
                error.with_hint("the first line has the names of the columns, separated by commas")
            } else {
                error
            });
        }
        see(line, &fields)?;
    }
    Ok(())
}

/// A field without the blanks and the quotes around it.
fn strip_quotes(field: &str) -> &str {
    let field = field.trim().trim_start_matches(BYTE_ORDER_MARK);
    field.strip_prefix('"').and_then(|f| f.strip_suffix('"')).map_or(field, str::trim)
}

/// Calls back for every row of numbers with its line.
pub(super) fn each_number_row(
    file: &str,
    reader: impl BufRead,
    columns: &Columns<'_>,
    see: &mut dyn FnMut(usize, &[f64]) -> Result<(), InputError>,
) -> Result<(), InputError> {
    let mut values = vec![];
    each_row(file, reader, columns, &mut |line, fields| {
        values.clear();
        for (name, text) in columns.names.iter().zip(fields) {
            values.push(number(file, line, name, text)?);
        }
        see(line, &values)
    })?;
    if values.is_empty() {
        let head = columns.names.join(",");
        return Err(InputError::new(file, "no rows of numbers").with_hint(format!("the first line is {head}")));
    }
    Ok(())
}

/// Keeps a value of a row.
pub(super) fn keep<T>(file: &str, line: usize, list: &mut Vec<T>, value: T) -> Result<(), InputError> {
    let room = list.try_reserve(1);
    room.map_err(|_| {
        at(file, line, format!("the first {} rows fill the memory", list.len()))
            .with_hint("leave out frequencies or repeats, or take a machine with more memory")
    })?;
    list.push(value);
    Ok(())
}

/// A finite number in a named column.
pub(super) fn number(file: &str, line: usize, name: &str, text: &str) -> Result<f64, InputError> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => {
            Err(at(file, line, format!("{name}: {text:?} is not a number")).with_hint(if text.contains([';', '\t']) {
                "columns are separated by commas, and decimals by points"
            } else {
                "numbers are written plainly with a decimal point, like 1.25e-6"
            }))
        }
    }
}

/// The header must name exactly the expected columns in their order.
fn check_header(file: &str, line: usize, found: &[&str], names: &[String]) -> Result<(), InputError> {
    let refused = |rule: String| Err(at(file, line, rule).with_hint(format!("the first line is {}", names.join(","))));
    for (k, name) in names.iter().enumerate() {
        match found.get(k) {
            Some(found) if found == name => {}
            Some(found) => return refused(format!("column {} is {found:?}, expected {name:?}", k + 1)),
            None => return refused(format!("column {name:?} is missing")),
        }
    }
    match found.get(names.len()) {
        Some(other) => refused(format!("unknown column {other:?}")),
        None => Ok(()),
    }
}

pub(super) fn at(file: &str, line: usize, message: String) -> InputError {
    let mut e = InputError::new(file, message);
    e.line = Some(line);
    e.with_hint("correct the line; the header names columns and units")
}
