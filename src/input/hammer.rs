//! Hammer FRFs: CSV (formats.md, section 4), or a universal file with one usable dataset 58; mode shapes CSV.

use super::error::InputError;
use super::table::{at, numbers};
use super::uff;
use super::uff_frf::{self, UffFrf};
use crate::identify::HammerFrf;
use crate::linalg::c64;
use crate::update::MeasuredShape;

/// A hammer FRF from the bytes of its file; the extension tells CSV from universal file.
///
/// # Errors
/// [`InputError`] with the line of what is wrong, or why no dataset of a universal file can be used.
pub fn read_hammer(file: &str, bytes: &[u8], speed_rpm: f64) -> Result<HammerFrf, InputError> {
    let lower = file.to_ascii_lowercase();
    if lower.ends_with(".uff") || lower.ends_with(".unv") {
        return from_universal(file, bytes, speed_rpm);
    }
    let names: Vec<String> = ["frequency_hz", "h_re", "h_im", "coherence", "averages"].map(str::to_owned).to_vec();
    let mut frf = HammerFrf {
        speed_rpm,
        frequency_hz: vec![],
        compliance: vec![],
        coherence: Some(vec![]),
        averages: Some(vec![]),
    };
    for (line, row) in numbers(file, bytes, &names)? {
        let (f, coherence, averages) = (row[0], row[3], row[4]);
        let rule = |message: String| Err(at(file, line, message));
        if f <= 0.0 {
            return rule(format!("frequency_hz: {f} must be positive"));
        }
        if frf.frequency_hz.last().is_some_and(|last| f <= *last) {
            return rule(format!("frequency_hz: {f} does not exceed the line before; frequencies must ascend"));
        }
        if !(coherence > 0.0 && coherence <= 1.0) {
            return rule(format!("coherence: {coherence} must be above 0 and at most 1"));
        }
        if averages < 1.0 {
            return rule(format!("averages: {averages} must be at least 1"));
        }
        frf.frequency_hz.push(f);
        frf.compliance.push(c64::new(row[1], row[2]));
        frf.coherence.get_or_insert_default().push(coherence);
        frf.averages.get_or_insert_default().push(averages);
    }
    Ok(frf)
}

fn from_universal(file: &str, bytes: &[u8], speed_rpm: f64) -> Result<HammerFrf, InputError> {
    let functions = uff::read(file, bytes)?;
    let frfs: Vec<UffFrf> = uff_frf::frfs(file, &functions)?;
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
    let coherence = uff_frf::coherence_for(&functions, chosen);
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
    let names: Vec<String> = ["mode", "position_m", "amplitude"].map(str::to_owned).to_vec();
    let mut shapes: Vec<MeasuredShape> = vec![];
    for (line, row) in numbers(file, bytes, &names)? {
        if row[0].fract() != 0.0 || row[0] < 1.0 {
            return Err(at(file, line, format!("mode: {} must be a whole number from 1", row[0])));
        }
        let mode = row[0] as usize;
        let known = shapes.iter().position(|s| s.mode == mode);
        let k = known.unwrap_or_else(|| {
            shapes.push(MeasuredShape { mode, points: vec![] });
            shapes.len() - 1
        });
        shapes[k].points.push((row[1], row[2]));
    }
    shapes.sort_by_key(|s| s.mode);
    for shape in &mut shapes {
        shape.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    Ok(shapes)
}
