//! Hammer FRFs: CSV (formats.md, section 4), or a dataset 58 of a universal file; mode shapes CSV.

use super::error::InputError;
use super::file::{self, Watch};
use super::sweep::AT_ZERO;
use super::table::{Columns, at, each_number_row, keep};
use super::uff::{self, UffFunction};
use super::uff_frf::{self, UffFrf};
use crate::identify::HammerFrf;
use crate::linalg::c64;
use crate::update::MeasuredShape;
use std::io::BufRead;
use std::path::Path;

/// Highest number of a mode: no shaft is measured that far.
const MOST_MODES: usize = 1000;

/// What the list of a measurement says of a hammer record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HammerKeys {
    /// Speed of the rotor, 1/min.
    pub speed_rpm: f64,
    /// Axis of force and displacement, 0 for x and 1 for y; none: that of a universal file, else x.
    pub axis: Option<usize>,
    /// Function of a universal file, from 1; none: the only FRF, or the only one at the driving point.
    pub function: Option<usize>,
    /// Where response and force are, if the list says it; none: at the tool plane.
    pub places_m: Option<[f64; 2]>,
}

/// A coherence is printed in single precision by most recorders.
const COHERENCE_ROUNDING: f64 = 1e-6;

/// A hammer record.
#[derive(Clone, Debug)]
pub struct Tap {
    /// Its FRF along the axis.
    pub frf: HammerFrf,
    /// Axis of force and displacement: 0 for x, 1 for y.
    pub axis: usize,
    /// What the file does not say and was taken for granted, and what was turned round; one sentence each.
    pub notes: Vec<String>,
}

/// A hammer FRF from the bytes of its file; the extension tells CSV from universal file.
///
/// # Errors
/// As [`read_tap`].
pub fn read_hammer(file: &str, bytes: &[u8], speed_rpm: f64) -> Result<HammerFrf, InputError> {
    Ok(read_tap(file, bytes, &HammerKeys { speed_rpm, ..HammerKeys::default() })?.frf)
}

/// A hammer record from the bytes of its file and the keys of its list.
///
/// # Errors
/// [`InputError`] with the line of what is wrong, or why no dataset of a universal file can be used.
pub fn read_tap(file: &str, bytes: &[u8], keys: &HammerKeys) -> Result<Tap, InputError> {
    if is_universal(file) {
        return from_universal(file, &uff::read(file, bytes)?, keys);
    }
    refuse_function(file, keys)?;
    from_table(file, bytes, keys)
}

/// As [`read_tap`], from a file; a table is read line by line and `watch` hears how far that has come.
pub(crate) fn load_hammer(path: &Path, keys: &HammerKeys, watch: Watch<'_>) -> Result<Tap, InputError> {
    let name = path.display().to_string();
    if is_universal(&name) {
        return from_universal(&name, &uff::load(&name)?, keys);
    }
    refuse_function(&name, keys)?;
    let rows = file::open_rows(path, watch).map_err(|e| e.of(&name))?;
    from_table(&name, rows, keys)
}

pub(super) fn is_universal(file: &str) -> bool {
    let lower = file.to_ascii_lowercase();
    lower.ends_with(".uff") || lower.ends_with(".unv")
}

fn refuse_function(file: &str, keys: &HammerKeys) -> Result<(), InputError> {
    match keys.function {
        Some(_) => Err(InputError::new(file, "function: only a universal file has several functions")
            .with_hint("remove the key, or name a file that ends in .uff or .unv")),
        None => Ok(()),
    }
}

/// A table with or without coherence and averages.
fn from_table(file: &str, reader: impl BufRead, keys: &HammerKeys) -> Result<Tap, InputError> {
    let names: Vec<String> = ["frequency_hz", "h_re", "h_im", "coherence", "averages"].map(str::to_owned).to_vec();
    let (mut frequency_hz, mut compliance) = (vec![], vec![]);
    let (mut coherences, mut all_averages) = (vec![], vec![]);
    let mut notes = vec![];
    each_number_row(file, reader, &Columns { names: &names, optional: 2 }, &mut |line, row| {
        let rule = |message: String| Err(at(file, line, message));
        let f = row[0];
        if f < 0.0 {
            return rule(format!("frequency_hz: {f} must be positive"));
        }
        if frequency_hz.last().is_some_and(|last| f <= *last) {
            return rule(format!("frequency_hz: {f} does not exceed the line before; frequencies must ascend"));
        }
        if f == 0.0 {
            notes.push(format!("{file}: {AT_ZERO}"));
            return Ok(());
        }
        if let [_, _, _, coherence, averages] = *row {
            if !(0.0..=1.0 + COHERENCE_ROUNDING).contains(&coherence) {
                return rule(format!("coherence: {coherence} must be from 0 to 1"));
            }
            if averages < 1.0 {
                return rule(format!("averages: {averages} must be at least 1"));
            }
            // A line that tells nothing has next to none.
            keep(file, line, &mut coherences, coherence.clamp(f64::MIN_POSITIVE, 1.0))?;
            keep(file, line, &mut all_averages, averages)?;
        }
        keep(file, line, &mut frequency_hz, f)?;
        keep(file, line, &mut compliance, c64::new(row[1], row[2]))
    })?;
    if frequency_hz.is_empty() {
        return Err(InputError::new(file, "no line above 0 Hz").with_hint("frequencies are in Hz and ascend"));
    }
    let told = |list: Vec<f64>| (!list.is_empty()).then_some(list);
    if coherences.is_empty() {
        notes.push(format!("{file}: without coherence the noise is estimated from line to line"));
    }
    let (coherence, averages) = (told(coherences), told(all_averages));
    let frf = HammerFrf { speed_rpm: keys.speed_rpm, frequency_hz, compliance, coherence, averages };
    Ok(Tap { frf, axis: keys.axis.unwrap_or(0), notes })
}

fn from_universal(file: &str, functions: &[UffFunction], keys: &HammerKeys) -> Result<Tap, InputError> {
    let found = match keys.function {
        Some(number) => take_function(file, functions, number)?,
        None => only_one(file, functions, keys.axis)?,
    };
    let (axis, sign, mut notes) = along_axis(&found, keys.axis).map_err(|message| {
        InputError::new(file, format!("function {}: {message}", found.label())).with_hint(
            "a hammer record has force and response along its `axis`, in universal files direction 1 for x and 2 for \
             y: correct `axis`, choose another function with `function`, or correct the file",
        )
    })?;
    notes.extend(found.notes.iter().cloned());
    if found.response.0 != found.reference.0 && keys.places_m.is_none() {
        let (response, force) = (found.response.0, found.reference.0);
        notes.push(format!("response at node {response}, force at node {force}: both are taken as the tool plane"));
    }
    let coherence = uff_frf::coherence_for(functions, &found);
    let frf = HammerFrf {
        speed_rpm: keys.speed_rpm,
        compliance: found.compliance.iter().map(|h| h * sign).collect(),
        frequency_hz: found.frequency_hz,
        coherence,
        averages: None,
    };
    let notes = notes.into_iter().map(|words| format!("{file}: {words}")).collect();
    Ok(Tap { frf, axis, notes })
}

/// The function that the list names by its number.
fn take_function(file: &str, functions: &[UffFunction], number: usize) -> Result<UffFrf, InputError> {
    let function = number.checked_sub(1).and_then(|k| functions.get(k)).ok_or_else(|| {
        InputError::new(file, format!("function: there is no function {number}, the file has {}", functions.len()))
            .with_hint("functions count from 1 in the order of the file")
    })?;
    uff_frf::frf_of(number, function).map_err(|reason| {
        InputError::new(file, format!("function {number}, {:?}: {reason}", function.description))
            .with_hint("choose a frequency response of displacement, velocity or acceleration over force")
    })
}

/// The only frequency response, or the only one at the driving point, along the axis where that is given.
fn only_one(file: &str, functions: &[UffFunction], axis: Option<usize>) -> Result<UffFrf, InputError> {
    let frfs = uff_frf::frfs(file, functions)?;
    let along =
        |f: &&UffFrf| axis.is_none_or(|axis| matches!(f.response.1.abs(), 0) || axis_of(f.response.1) == Some(axis));
    let driving: Vec<&UffFrf> = frfs.iter().filter(|f| f.is_driving_point()).collect();
    let on_axis: Vec<&UffFrf> = driving.iter().copied().filter(along).collect();
    match (frfs.as_slice(), driving.as_slice(), on_axis.as_slice()) {
        ([one], ..) => Ok(one.clone()),
        (_, [one], _) | (_, _, [one]) => Ok((*one).clone()),
        _ => {
            let list: Vec<String> = frfs.iter().map(UffFrf::label).collect();
            let rule = format!(
                "{} FRFs, and none or several of them with response and reference at the same point: {}",
                frfs.len(),
                list.join("; ")
            );
            Err(InputError::new(file, rule)
                .with_hint("a hammer record is one FRF: choose it with `function: N`, N the number in front of it"))
        }
    }
}

/// Axis of a direction of a universal file: 0 for ±1, 1 for ±2.
fn axis_of(direction: i64) -> Option<usize> {
    match direction {
        1 | -1 => Some(0),
        2 | -2 => Some(1),
        _ => None,
    }
}

/// Axis of an FRF, the sign that turns it to positive directions, and what is to be said; `stated` is that of the list.
fn along_axis(frf: &UffFrf, stated: Option<usize>) -> Result<(usize, f64, Vec<String>), String> {
    let name = |direction: i64| {
        let letter = match direction.abs() {
            1 => "x",
            2 => "y",
            3 => "z",
            _ => return format!("direction {direction}"),
        };
        format!("{}{letter}", if direction < 0 { "-" } else { "" })
    };
    let (response, force) = (frf.response.1, frf.reference.1);
    let known: Vec<i64> = [response, force].into_iter().filter(|d| *d != 0).collect();
    if let [a, b] = known[..]
        && a.abs() != b.abs()
    {
        return Err(format!("the direction of the response is {}, that of the force {}", name(a), name(b)));
    }
    let Some(direction) = known.first().copied() else {
        return Ok((stated.unwrap_or(0), 1.0, vec![]));
    };
    let Some(axis) = axis_of(direction) else {
        return Err(format!("the direction of response and force is {}, no axis of the spindle", name(direction)));
    };
    if let Some(stated) = stated.filter(|stated| *stated != axis) {
        let letter = ["x", "y"][stated.min(1)];
        return Err(format!(
            "the direction of response and force is {}, the record says axis {letter}",
            name(direction)
        ));
    }
    let sign = known.iter().map(|d| d.signum() as f64).product();
    let mut notes = vec![];
    if sign < 0.0 {
        notes.push(format!(
            "the direction of the response is {}, that of the force {}: the response is turned to that of the force",
            name(response),
            name(force)
        ));
    }
    Ok((axis, sign, notes))
}

/// Measured mode shapes from the bytes of their CSV: `mode,position_m,amplitude`.
///
/// # Errors
/// [`InputError`] with the line of what is wrong.
pub fn read_mode_shapes(file: &str, bytes: &[u8]) -> Result<Vec<MeasuredShape>, InputError> {
    read_mode_shapes_from(file, bytes)
}

/// As [`read_mode_shapes`], from a file that is read line by line.
pub(crate) fn load_mode_shapes(path: &Path, watch: Watch<'_>) -> Result<Vec<MeasuredShape>, InputError> {
    let name = path.display().to_string();
    read_mode_shapes_from(&name, file::open_rows(path, watch).map_err(|error| error.of(&name))?)
}

fn read_mode_shapes_from(file: &str, reader: impl BufRead) -> Result<Vec<MeasuredShape>, InputError> {
    let names: Vec<String> = ["mode", "position_m", "amplitude"].map(str::to_owned).to_vec();
    let mut shapes: Vec<MeasuredShape> = vec![];
    each_number_row(file, reader, &Columns { names: &names, optional: 0 }, &mut |line, row| {
        if row[0].fract() != 0.0 || !(1.0..=MOST_MODES as f64).contains(&row[0]) {
            let rule = format!("mode: {} must be a whole number from 1 to {MOST_MODES}", row[0]);
            return Err(at(file, line, rule));
        }
        let mode = row[0] as usize;
        let known = shapes.iter().position(|s| s.mode == mode);
        let k = known.unwrap_or_else(|| {
            shapes.push(MeasuredShape { mode, points: vec![] });
            shapes.len() - 1
        });
        keep(file, line, &mut shapes[k].points, (row[1], row[2]))
    })?;
    shapes.sort_by_key(|s| s.mode);
    for shape in &mut shapes {
        shape.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    Ok(shapes)
}
