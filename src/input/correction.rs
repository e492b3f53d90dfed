//! The law that a diagnosis recovered at a place (formats.md, section 7) to [`ModelCorrection`].

use super::error::InputError;
use super::shipped::text;
use super::table::{Columns, at, each_row, first_line, number};
use crate::linalg::c64;
use crate::spindle::Machine;
use crate::spindle::correction::{ModelCorrection, RecoveredLaw};
use std::f64::consts::TAU;

/// The file of a diagnosis, and of a machine that was designed with it.
pub(crate) const CORRECTION_FILE: &str = "correction.csv";
/// What the header must be.
const HEADER: &str =
    "frequency_hz, then law_re, law_im, law_sd with unit (law_n_per_m_re) once for each law, then place";

/// The machine with the law of a file beside its effects (correction.csv of a diagnosis).
///
/// # Errors
/// [`InputError`] with file, line and column for a bad table, a place whose law no model takes, and a law that no
/// stable transfer function carries.
pub fn with_correction(machine: Machine, file: &str) -> Result<Machine, InputError> {
    let text = text(file, "correction", &[])?;
    let (place, laws) = read_laws(file, &text)?;
    let rule = |error| InputError::rule(file, &error);
    let correction = ModelCorrection::fit(&place, &laws, text).map_err(rule)?;
    machine.with_correction(correction).map_err(rule)
}

/// The place and its laws.
fn read_laws(file: &str, text: &str) -> Result<(String, Vec<RecoveredLaw>), InputError> {
    let header = first_line(file, text.as_bytes())?;
    let names: Vec<String> = header.split(',').map(|name| name.trim().trim_matches('"').to_owned()).collect();
    let bad_header = || at(file, 1, format!("the header is {header:?}")).with_hint(format!("it must be {HEADER}"));
    let (Some("frequency_hz"), Some("place")) = (names.first().map(String::as_str), names.last().map(String::as_str))
    else {
        return Err(bad_header());
    };
    let columns = &names[1..names.len() - 1];
    let mut laws = vec![];
    for law in columns.chunks(3) {
        let name = law_name(law).ok_or_else(bad_header)?;
        laws.push(RecoveredLaw { name, lines: vec![] });
    }
    if laws.is_empty() {
        return Err(bad_header());
    }
    let mut place = String::new();
    let table = Columns { names: &names, optional: 0 };
    each_row(file, text.as_bytes(), &table, &mut |line, fields| {
        let values: Result<Vec<f64>, InputError> = names[..names.len() - 1]
            .iter()
            .zip(fields)
            // Where the law cannot be seen its cell is empty.
            .map(|(name, field)| if field.is_empty() { Ok(f64::NAN) } else { number(file, line, name, field) })
            .collect();
        let values = values?;
        let here = fields.last().copied().unwrap_or_default();
        if !place.is_empty() && place != here {
            return Err(at(file, line, format!("the place {here:?} is another than {place:?} above"))
                .with_hint("a file holds the laws of one place"));
        }
        here.clone_into(&mut place);
        for (law, own) in laws.iter_mut().zip(values[1..].chunks(3)) {
            law.lines.push((TAU * values[0], c64::new(own[0], own[1]), own[2]));
        }
        Ok(())
    })?;
    Ok((place, laws))
}

/// The name of the law of three columns `law_NAME_UNIT_re`, `…_im` and `…_sd`, empty where there is none.
fn law_name(columns: &[String]) -> Option<String> {
    let stem = columns.first()?.strip_suffix("_re")?;
    let complete = columns.len() == 3 && columns[1] == format!("{stem}_im") && columns[2] == format!("{stem}_sd");
    let named = stem.strip_prefix("law")?;
    let named = ["_n_per_m", "_relative"].into_iter().find_map(|unit| named.strip_suffix(unit))?;
    complete.then(|| named.trim_start_matches('_').replace('_', " "))
}
