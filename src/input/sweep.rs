//! Sweep CSV (formats.md, section 4) to a [`SweepRecord`]: one row per line, experiment and repeat. Rows may come in
//! any order; what is doubled or no number is refused with its line. Lines where an experiment is missing that others
//! have, repeats that one experiment has more than another, and 0 Hz are left out, which the record says. An experiment
//! that no line has was not taken.

use super::error::InputError;
use super::file::{self, Watch};
use super::table::{Columns, at, each_row, keep, number};
use crate::identify::SweepRecord;
use crate::identify::frf::{AXES, AXIS_NAMES};
use crate::linalg::c64;
use ndarray::Array4;
use std::io::BufRead;
use std::path::Path;

/// Most repeats of an experiment: more than this is a column mix-up.
const MOST_REPEATS: usize = 10_000;

struct SweepRow {
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
/// [`InputError`] with the line: wrong columns, no number, frequency not positive, unknown experiment, doubled row, no
/// frequency with all experiments that the file has.
pub fn read_sweep(file: &str, bytes: &[u8], speed_rpm: f64) -> Result<SweepRecord, InputError> {
    read_sweep_from(file, bytes, speed_rpm)
}

/// As [`read_sweep`], from a file that is read line by line; `watch` hears how far that has come.
pub(crate) fn load_sweep(path: &Path, speed_rpm: f64, watch: Watch<'_>) -> Result<SweepRecord, InputError> {
    let name = path.display().to_string();
    let reader = file::open_rows(path, watch).map_err(|error| error.of(&name))?;
    read_sweep_from(&name, reader, speed_rpm)
}

fn read_sweep_from(file: &str, reader: impl BufRead, speed_rpm: f64) -> Result<SweepRecord, InputError> {
    let (mut rows, at_zero) = rows(file, reader)?;
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
    let groups: Vec<&[SweepRow]> = rows.chunk_by(|a, b| a.frequency_hz == b.frequency_hz).collect();
    let taken: Vec<usize> = (0..AXES).filter(|e| rows.iter().any(|row| row.experiment == e + 1)).collect();
    let counts: Vec<Vec<usize>> = groups.iter().map(|group| repeats_of_experiments(group, &taken)).collect();
    let repeats = usable_repeats(file, &groups, &counts, &taken)?;
    let usable = groups.iter().zip(&counts).filter(|(_, counts)| fewest(counts) >= repeats);
    let used: Vec<Vec<&SweepRow>> = usable.map(|(group, counts)| first_repeats(group, counts, repeats)).collect();
    let take = |offset: usize| {
        Array4::from_shape_fn((used.len(), AXES, repeats, AXES), |(l, e, p, axis)| {
            let Some(place) = taken.iter().position(|own| *own == e) else {
                return c64::new(0.0, 0.0);
            };
            let v = &used[l][place * repeats + p].values;
            let k = offset + 2 * axis;
            c64::new(v[k], v[k + 1])
        })
    };
    let (current, signal) = (take(0), take(2 * AXES));
    let record = SweepRecord {
        name: file.to_owned(),
        speed_rpm,
        frequency_hz: used.iter().map(|rows| rows[0].frequency_hz).collect(),
        current,
        signal,
        run_out: false,
        left_out: at_zero.then(|| AT_ZERO.to_owned()).into_iter().chain(left_out(&groups, &counts, repeats)).collect(),
    };
    Ok(record.without_odd_repeats())
}

/// What is said of a line that has no frequency.
pub(super) const AT_ZERO: &str = "the line at 0 Hz is left out: a mean value is no response";

/// Number of repeats of each experiment that was taken among the rows of a line.
fn repeats_of_experiments(group: &[SweepRow], taken: &[usize]) -> Vec<usize> {
    taken.iter().map(|e| group.iter().filter(|row| row.experiment == e + 1).count()).collect()
}

fn fewest(counts: &[usize]) -> usize {
    counts.iter().copied().min().unwrap_or(0)
}

/// The first repeats of every experiment of a line, experiment by experiment.
fn first_repeats<'a>(group: &'a [SweepRow], counts: &[usize], repeats: usize) -> Vec<&'a SweepRow> {
    let mut rows = Vec::with_capacity(counts.len() * repeats);
    let mut first = 0;
    for count in counts {
        rows.extend(&group[first..first + repeats]);
        first += count;
    }
    rows
}

/// Number of repeats with which most rows are used: lines where an experiment has fewer are left out.
fn usable_repeats(
    file: &str,
    groups: &[&[SweepRow]],
    counts: &[Vec<usize>],
    taken: &[usize],
) -> Result<usize, InputError> {
    let lines_with = |repeats: usize| counts.iter().filter(|own| fewest(own) >= repeats).count();
    let most = counts.iter().map(|own| fewest(own)).max().unwrap_or(0);
    if let Some(best) = (1..=most).max_by_key(|repeats| repeats * lines_with(*repeats)) {
        return Ok(best);
    }
    let (line, frequency_hz) = groups.first().map_or((1, 0.0), |group| (group[0].line, group[0].frequency_hz));
    let missing = counts.first().and_then(|own| own.iter().position(|count| *count == 0));
    let missing = missing.and_then(|k| taken.get(k)).copied().unwrap_or(0);
    Err(at(
        file,
        line,
        format!("at {frequency_hz} Hz experiment {} (injection into {}) is missing", missing + 1, AXIS_NAMES[missing]),
    )
    .with_hint("G = Y U⁻¹ needs the injections at the same frequencies; no line has all that the file has"))
}

/// Frequencies that a note names.
const NAMED_LINES: usize = 3;

/// What of a record is not used, in words.
fn left_out(groups: &[&[SweepRow]], counts: &[Vec<usize>], repeats: usize) -> Vec<String> {
    let mut notes = vec![];
    let short: Vec<f64> = groups
        .iter()
        .zip(counts)
        .filter(|(_, own)| fewest(own) < repeats)
        .map(|(group, _)| group[0].frequency_hz)
        .collect();
    if !short.is_empty() {
        let named: Vec<String> = short.iter().take(NAMED_LINES).map(|hz| format!("{hz} Hz")).collect();
        let more = if short.len() > NAMED_LINES { " and others" } else { "" };
        notes.push(format!(
            "{} of {} frequencies are left out, an experiment or a repeat is missing there: {}{more}",
            short.len(),
            groups.len(),
            named.join(", ")
        ));
    }
    let unused: usize = counts
        .iter()
        .filter(|own| fewest(own) >= repeats)
        .map(|own| own.iter().map(|count| count - repeats).sum::<usize>())
        .sum();
    if unused > 0 {
        notes.push(format!(
            "{unused} rows are not used: an experiment has more repeats than another one, and {repeats} of each enter"
        ));
    }
    notes
}

/// The rows above 0 Hz, and whether there are others.
fn rows(file: &str, reader: impl BufRead) -> Result<(Vec<SweepRow>, bool), InputError> {
    let names = header();
    let (mut rows, mut at_zero) = (vec![], false);
    each_row(file, reader, &Columns { names: &names, optional: 0 }, &mut |line, record| {
        let number = |k: usize| number(file, line, &names[k], record[k]);
        let whole = |k: usize, most: usize| {
            let v = number(k)?;
            if v.fract() == 0.0 && v >= 1.0 && v <= most as f64 {
                return Ok(v as usize);
            }
            Err(at(file, line, format!("{}: {v} must be a whole number from 1 to {most}", names[k])))
        };
        let frequency_hz = number(0)?;
        if frequency_hz < 0.0 {
            return Err(at(file, line, format!("frequency_hz: {frequency_hz} must be positive")));
        }
        let mut values = [0.0; 4 * AXES];
        for (k, v) in values.iter_mut().enumerate() {
            *v = number(3 + k)?;
        }
        let (experiment, repeat) = (whole(1, AXES)?, whole(2, MOST_REPEATS)?);
        if frequency_hz == 0.0 {
            at_zero = true;
            return Ok(());
        }
        keep(file, line, &mut rows, SweepRow { line, frequency_hz, experiment, repeat, values })
    })?;
    if rows.is_empty() {
        return Err(
            InputError::new(file, "no frequency lines").with_hint(format!("the first line is {}", names.join(",")))
        );
    }
    Ok((rows, at_zero))
}
