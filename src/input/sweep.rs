//! Sweep CSV (formats.md, section 4) to a [`SweepRecord`]: one row per line, experiment and repeat. Rows may come in
//! any order; what is missing, doubled or no number is refused with its line.

use super::error::InputError;
use super::file::{self, Watch};
use super::table::{at, each_row, keep, number};
use crate::identify::SweepRecord;
use crate::identify::frf::{AXES, AXIS_NAMES};
use crate::linalg::c64;
use ndarray::Array4;
use std::io::BufRead;
use std::path::Path;

/// Most repeats of an experiment: more than this is a column mix-up.
const MOST_REPEATS: usize = 10_000;

struct Row {
    line: usize,
    frequency_hz: f64,
    experiment: usize,
    repeat: usize,
    values: [f64; 4 * AXES],
}

/// The header line that a sweep file must have.
pub fn header() -> Vec<String> {
    let mut names: Vec<String> = ["frequency_hz", "experiment", "repeat"].map(str::to_owned).to_vec();
    for quantity in ["u", "y"] {
        for axis in 1..=AXES {
            names.push(format!("{quantity}{axis}_re"));
            names.push(format!("{quantity}{axis}_im"));
        }
    }
    names
}

/// A sweep from the bytes of its file; `file` names it in messages.
///
/// # Errors
/// [`InputError`] with the line: wrong columns, no number, frequency not positive, unknown or missing experiment,
/// doubled row, unequal repeats.
pub fn read_sweep(file: &str, bytes: &[u8], speed_rpm: f64) -> Result<SweepRecord, InputError> {
    read_sweep_from(file, bytes, speed_rpm)
}

/// As [`read_sweep`], from a file that is read line by line; `watch` hears how far that has come.
///
/// # Errors
/// As [`read_sweep`], and when the file cannot be read.
pub(crate) fn load_sweep(path: &Path, speed_rpm: f64, watch: Watch<'_>) -> Result<SweepRecord, InputError> {
    let name = path.display().to_string();
    let reader = file::open_rows(path, watch).map_err(|error| error.of(&name))?;
    read_sweep_from(&name, reader, speed_rpm)
}

fn read_sweep_from(file: &str, reader: impl BufRead, speed_rpm: f64) -> Result<SweepRecord, InputError> {
    let mut rows = rows(file, reader)?;
    rows.sort_by(|a, b| {
        a.frequency_hz
            .total_cmp(&b.frequency_hz)
            .then(a.experiment.cmp(&b.experiment))
            .then(a.repeat.cmp(&b.repeat))
            .then(a.line.cmp(&b.line))
    });
    for pair in rows.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        let same = (a.frequency_hz, a.experiment, a.repeat) == (b.frequency_hz, b.experiment, b.repeat);
        if same {
            return Err(at(
                file,
                b.line,
                format!(
                    "{} Hz, experiment {}, repeat {} stands in line {} already",
                    b.frequency_hz, b.experiment, b.repeat, a.line
                ),
            )
            .with_hint("every frequency, experiment and repeat may appear once; a second sweep is a second record"));
        }
    }
    let mut groups: Vec<&[Row]> = rows.chunk_by(|a, b| a.frequency_hz == b.frequency_hz).collect();
    groups.sort_by(|a, b| a[0].frequency_hz.total_cmp(&b[0].frequency_hz));
    let repeats = groups.first().map_or(0, |g| g.iter().filter(|r| r.experiment == 1).count());
    for group in &groups {
        for experiment in 1..=AXES {
            check_repeats(file, group, experiment, repeats)?;
        }
    }
    let take = |offset: usize| {
        Array4::from_shape_fn((groups.len(), AXES, repeats, AXES), |(l, e, p, axis)| {
            let v = &groups[l][e * repeats + p].values;
            let k = offset + 2 * axis;
            c64::new(v[k], v[k + 1])
        })
    };
    let (current, signal) = (take(0), take(2 * AXES));
    Ok(SweepRecord {
        name: file.to_owned(),
        speed_rpm,
        frequency_hz: groups.iter().map(|g| g[0].frequency_hz).collect(),
        current,
        signal,
    })
}

/// Repeats 1…P of one experiment at one frequency, P as everywhere else.
fn check_repeats(file: &str, group: &[Row], experiment: usize, repeats: usize) -> Result<(), InputError> {
    let frequency = group[0].frequency_hz;
    let found: Vec<usize> = group.iter().filter(|r| r.experiment == experiment).map(|r| r.repeat).collect();
    if found.is_empty() {
        return Err(at(
            file,
            group[0].line,
            format!(
                "at {frequency} Hz experiment {experiment} (injection into {}) is missing",
                AXIS_NAMES[experiment - 1]
            ),
        )
        .with_hint("G = Y U⁻¹ needs one injection into each of the four axes at every frequency"));
    }
    if found.len() != repeats || found.iter().enumerate().any(|(k, r)| *r != k + 1) {
        return Err(at(
            file,
            group[0].line,
            format!("at {frequency} Hz experiment {experiment} has repeats {found:?}, others have 1 to {repeats}"),
        )
        .with_hint("the scatter over repeats is the noise: every experiment needs the same repeats, numbered from 1"));
    }
    Ok(())
}

fn rows(file: &str, reader: impl BufRead) -> Result<Vec<Row>, InputError> {
    let names = header();
    let mut rows = vec![];
    each_row(file, reader, &names, &mut |line, record| {
        let number = |k: usize| number(file, line, &names[k], record[k]);
        let whole = |k: usize, most: usize| {
            let v = number(k)?;
            if v.fract() == 0.0 && v >= 1.0 && v <= most as f64 {
                return Ok(v as usize);
            }
            Err(at(file, line, format!("{}: {v} must be a whole number from 1 to {most}", names[k])))
        };
        let frequency_hz = number(0)?;
        if frequency_hz <= 0.0 {
            return Err(at(file, line, format!("frequency_hz: {frequency_hz} must be positive")));
        }
        let mut values = [0.0; 4 * AXES];
        for (k, v) in values.iter_mut().enumerate() {
            *v = number(3 + k)?;
        }
        let (experiment, repeat) = (whole(1, AXES)?, whole(2, MOST_REPEATS)?);
        keep(file, line, &mut rows, Row { line, frequency_hz, experiment, repeat, values })
    })?;
    if rows.is_empty() {
        return Err(
            InputError::new(file, "no frequency lines").with_hint(format!("the first line is {}", names.join(",")))
        );
    }
    Ok(rows)
}
