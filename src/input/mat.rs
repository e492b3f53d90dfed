//! MATLAB level-5 files: the names and sizes of their matrices, as far as they are not compressed.
//!
//! Source: MathWorks, MAT-File Format, level 5: a header of 128 bytes, then elements with tag (type, bytes) on
//! multiples of 8.

use super::error::InputError;

const HEADER: usize = 128;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// A matrix of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Its sizes.
    pub sizes: Vec<u32>,
}

/// Matrices of a file, those in compressed elements left out.
///
/// # Errors
/// [`InputError`] with the byte at which the file is not what the format says.
pub fn variables(file: &str, bytes: &[u8]) -> Result<Vec<Variable>, InputError> {
    let fail = |at: usize, rule: &str| {
        InputError::new(file, format!("byte {at}: {rule}"))
            .with_hint("write the controller again with `muspin export --format mat`")
    };
    let little = match bytes.get(HEADER - 2..HEADER) {
        Some(b"IM") => true,
        Some(b"MI") => false,
        _ => {
            return Err(fail(
                HEADER - 2,
                "no byte order mark: not a MATLAB level-5 file",
            ));
        }
    };
    let mut found = vec![];
    let mut at = HEADER;
    while at < bytes.len() {
        let element = element(bytes, at, little)
            .ok_or_else(|| fail(at, "an element does not fit into the file"))?;
        if element.kind == MATRIX {
            let variable = variable(element.data, little);
            found.push(variable.ok_or_else(|| fail(at, "a matrix without sizes or name"))?);
        } else if element.kind != COMPRESSED {
            return Err(fail(at, "neither a matrix nor a compressed one"));
        }
        at = element.end;
    }
    Ok(found)
}

/// Whether the matrices are a controller: A n×n, B n×4, C 4×n, D 4×4 and Ts.
///
/// # Errors
/// [`InputError`] with the matrix that is missing or has other sizes.
pub fn check_controller(file: &str, bytes: &[u8]) -> Result<(), InputError> {
    let found = variables(file, bytes)?;
    let sizes = |name: &str| {
        let named = found.iter().find(|v| v.name == name);
        named.map(|v| v.sizes.clone()).ok_or_else(|| {
            let names: Vec<&str> = found.iter().map(|v| v.name.as_str()).collect();
            InputError::new(
                file,
                format!("has no matrix {name}; it has: {}", names.join(", ")),
            )
            .with_hint("a controller has A, B, C, D and Ts, not compressed (save with -v6)")
        })
    };
    let n = sizes("A")?.first().copied().unwrap_or_default();
    for (name, expected) in [
        ("A", [n, n]),
        ("B", [n, 4]),
        ("C", [4, n]),
        ("D", [4, 4]),
        ("Ts", [1, 1]),
    ] {
        let found = sizes(name)?;
        if found != expected {
            let rule = format!("{name}: has the sizes {found:?}, must have {expected:?}");
            return Err(InputError::new(file, rule)
                .with_hint("A is n×n, B n×4, C 4×n, D 4×4, Ts one number"));
        }
    }
    Ok(())
}

struct Element<'a> {
    kind: u32,
    data: &'a [u8],
    /// Where the next element begins.
    end: usize,
}

fn word(bytes: &[u8], at: usize, little: bool) -> Option<u32> {
    let raw: [u8; 4] = bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
    Some(if little {
        u32::from_le_bytes(raw)
    } else {
        u32::from_be_bytes(raw)
    })
}

fn element(bytes: &[u8], at: usize, little: bool) -> Option<Element<'_>> {
    let first = word(bytes, at, little)?;
    // Small elements carry type and size in one word and up to four bytes behind it.
    if first >> 16 != 0 {
        let size = (first >> 16) as usize;
        let data = bytes.get(at + 4..at + 4 + size.min(4))?;
        return Some(Element {
            kind: first & 0xffff,
            data,
            end: at + 8,
        });
    }
    let size = word(bytes, at + 4, little)? as usize;
    let data = bytes.get(at + 8..at.checked_add(8 + size)?)?;
    // Compressed elements are not padded.
    let padded = if first == COMPRESSED {
        size
    } else {
        size.next_multiple_of(8)
    };
    Some(Element {
        kind: first,
        data,
        end: at + 8 + padded,
    })
}

/// Array flags, sizes, name: the first three elements of a matrix.
fn variable(data: &[u8], little: bool) -> Option<Variable> {
    let flags = element(data, 0, little)?;
    let sizes = element(data, flags.end, little)?;
    let name = element(data, sizes.end, little)?;
    let count = sizes.data.len() / 4;
    Some(Variable {
        name: String::from_utf8_lossy(name.data).into_owned(),
        sizes: (0..count)
            .filter_map(|k| word(sizes.data, 4 * k, little))
            .collect(),
    })
}
