//! Rows of a CSV file under a fixed header, each with its line for messages.

use super::error::InputError;

/// The rows below the header, each with its line and as many fields as `names`.
pub(super) fn records<'a>(
    file: &'a str,
    bytes: &'a [u8],
    names: &'a [String],
) -> impl Iterator<Item = Result<(usize, csv::StringRecord), InputError>> + 'a {
    let reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(bytes);
    let read = move |(number, record): (usize, csv::Result<csv::StringRecord>)| {
        let record = record.map_err(|e| csv_error(file, &e))?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        if number == 0 {
            check_header(file, line, &record, names)?;
            return Ok(None);
        }
        if record.len() != names.len() {
            let rule = format!("{} columns, the header has {}", record.len(), names.len());
            return Err(at(file, line, rule));
        }
        Ok(Some((line, record)))
    };
    let numbered = reader.into_records().enumerate();
    numbered.filter_map(move |record| read(record).transpose())
}

/// Rows of numbers, each with its line.
///
/// # Errors
/// [`InputError`] with the line of what is no number, and for a file without a row.
pub(super) fn numbers(file: &str, bytes: &[u8], names: &[String]) -> Result<Vec<(usize, Vec<f64>)>, InputError> {
    let mut rows = vec![];
    for record in records(file, bytes, names) {
        let (line, record) = record?;
        let values = names
            .iter()
            .zip(&record)
            .map(|(name, text)| number(file, line, name, text))
            .collect::<Result<Vec<f64>, _>>()?;
        rows.push((line, values));
    }
    if rows.is_empty() {
        return Err(
            InputError::new(file, "no rows of numbers").with_hint(format!("the first line is {}", names.join(",")))
        );
    }
    Ok(rows)
}

/// A finite number in a named column.
pub(super) fn number(file: &str, line: usize, name: &str, text: &str) -> Result<f64, InputError> {
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err(at(file, line, format!("{name}: {text:?} is not a number"))
            .with_hint("numbers are written plainly with a decimal point, like 1.25e-6")),
    }
}

/// The header must name exactly the expected columns in their order.
fn check_header(file: &str, line: usize, record: &csv::StringRecord, names: &[String]) -> Result<(), InputError> {
    let expected = || names.join(",");
    for (k, name) in names.iter().enumerate() {
        let found = record.get(k).map(|f| f.trim_start_matches('\u{feff}').to_owned());
        match found {
            Some(found) if &found == name => {}
            Some(found) => {
                return Err(at(file, line, format!("column {} is {found:?}, expected {name:?}", k + 1))
                    .with_hint(format!("the first line is {}", expected())));
            }
            None => {
                return Err(at(file, line, format!("column {name:?} is missing"))
                    .with_hint(format!("the first line is {}", expected())));
            }
        }
    }
    if record.len() > names.len() {
        return Err(at(file, line, format!("unknown column {:?}", &record[names.len()]))
            .with_hint(format!("the first line is {}", expected())));
    }
    Ok(())
}

fn csv_error(file: &str, error: &csv::Error) -> InputError {
    let mut e = InputError::new(file, format!("not readable as CSV: {error}"));
    e.line = error.position().map(|p| p.line() as usize);
    e.with_hint("the file must be comma-separated UTF-8 text with one header line")
}

pub(super) fn at(file: &str, line: usize, message: String) -> InputError {
    let mut e = InputError::new(file, message);
    e.line = Some(line);
    e.with_hint("correct the line; the header names columns and units")
}
