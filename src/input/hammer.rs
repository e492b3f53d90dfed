//! Hammer FRFs: CSV (formats.md, section 4), or a universal file with one usable dataset 58; mode shapes CSV.

use super::error::InputError;
use super::file::{self, Watch};
use super::table::{at, each_number_row, keep};
use super::uff::{self, UffFunction};
use super::uff_frf::{self, UffFrf};
use crate::identify::HammerFrf;
use crate::linalg::c64;
use crate::update::MeasuredShape;
use std::io::BufRead;
use std::path::Path;

/// Highest number of a mode: no shaft is measured that far.
const MOST_MODES: usize = 1000;

/// A hammer FRF from the bytes of its file; the extension tells CSV from universal file.
///
/// # Errors
/// [`InputError`] with the line of what is wrong, or why no dataset of a universal file can be used.
pub fn read_hammer(file: &str, bytes: &[u8], speed_rpm: f64) -> Result<HammerFrf, InputError> {
    if is_universal(file) {
        return from_functions(file, &uff::read(file, bytes)?, speed_rpm);
    }
    from_table(file, bytes, speed_rpm)
}

/// As [`read_hammer`], from a file; a table is read line by line and `watch` hears how far that has come.
///
/// # Errors
/// As [`read_hammer`], and when the file cannot be read.
pub(crate) fn load_hammer(path: &Path, speed_rpm: f64, watch: Watch<'_>) -> Result<HammerFrf, InputError> {
    let name = path.display().to_string();
    if is_universal(&name) {
        return from_functions(&name, &uff::load(&name)?, speed_rpm);
    }
    from_table(&name, file::open_rows(path, watch).map_err(|e| e.of(&name))?, speed_rpm)
}

fn is_universal(file: &str) -> bool {
    let lower = file.to_ascii_lowercase();
    lower.ends_with(".uff") || lower.ends_with(".unv")
}

fn from_table(file: &str, reader: impl BufRead, speed_rpm: f64) -> Result<HammerFrf, InputError> {
    let names: Vec<String> = ["frequency_hz", "h_re", "h_im", "coherence", "averages"].map(str::to_owned).to_vec();
    let (mut frequency_hz, mut compliance) = (vec![], vec![]);
    let (mut coherences, mut all_averages) = (vec![], vec![]);
    each_number_row(file, reader, &names, &mut |line, row| {
        let (f, coherence, averages) = (row[0], row[3], row[4]);
        let rule = |message: String| Err(at(file, line, message));
        if f <= 0.0 {
            return rule(format!("frequency_hz: {f} must be positive"));
        }
        if frequency_hz.last().is_some_and(|last| f <= *last) {
            return rule(format!("frequency_hz: {f} does not exceed the line before; frequencies must ascend"));
        }
        if !(coherence > 0.0 && coherence <= 1.0) {
            return rule(format!("coherence: {coherence} must be above 0 and at most 1"));
        }
        if averages < 1.0 {
            return rule(format!("averages: {averages} must be at least 1"));
        }
        keep(file, line, &mut frequency_hz, f)?;
        keep(file, line, &mut compliance, c64::new(row[1], row[2]))?;
        keep(file, line, &mut coherences, coherence)?;
        keep(file, line, &mut all_averages, averages)
    })?;
    Ok(HammerFrf { speed_rpm, frequency_hz, compliance, coherence: Some(coherences), averages: Some(all_averages) })
}

fn from_functions(file: &str, functions: &[UffFunction], speed_rpm: f64) -> Result<HammerFrf, InputError> {
    let frfs: Vec<UffFrf> = uff_frf::frfs(file, functions)?;
    let driving: Vec<&UffFrf> = frfs.iter().filter(|f| f.is_driving_point()).collect();
    let chosen = match (frfs.as_slice(), driving.as_slice()) {
        ([one], _) => one,
        (_, [one]) => one,
        _ => {
            let list: Vec<String> = frfs.iter().map(UffFrf::label).collect();
            return Err(InputError::new(
                file,
                format!(
                    "{} FRFs, and none or several of them with response and reference at the same point: {}",
                    frfs.len(),
                    list.join("; ")
                ),
            )
            .with_hint("a hammer record is one FRF: force and displacement at the tool plane"));
        }
    };
    let coherence = uff_frf::coherence_for(functions, chosen);
    Ok(HammerFrf {
        speed_rpm,
        frequency_hz: chosen.frequency_hz.clone(),
        compliance: chosen.compliance.clone(),
        coherence,
        averages: None,
    })
}

/// Measured mode shapes from the bytes of their CSV: `mode,position_m,amplitude`.
///
/// # Errors
/// [`InputError`] with the line of what is wrong.
pub fn read_mode_shapes(file: &str, bytes: &[u8]) -> Result<Vec<MeasuredShape>, InputError> {
    read_mode_shapes_from(file, bytes)
}

/// As [`read_mode_shapes`], from a file that is read line by line.
///
/// # Errors
/// As [`read_mode_shapes`], and when the file cannot be read.
pub(crate) fn load_mode_shapes(path: &Path, watch: Watch<'_>) -> Result<Vec<MeasuredShape>, InputError> {
    let name = path.display().to_string();
    read_mode_shapes_from(&name, file::open_rows(path, watch).map_err(|error| error.of(&name))?)
}

fn read_mode_shapes_from(file: &str, reader: impl BufRead) -> Result<Vec<MeasuredShape>, InputError> {
    let names: Vec<String> = ["mode", "position_m", "amplitude"].map(str::to_owned).to_vec();
    let mut shapes: Vec<MeasuredShape> = vec![];
    each_number_row(file, reader, &names, &mut |line, row| {
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
