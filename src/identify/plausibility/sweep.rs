//! Plausibility of a sweep: its open-loop response against that of the nominal machine at the speed of the record.

use super::Plausibility;
use super::channels::slips;
use super::checks::{MeasuredRecord, checks};
use super::hypotheses::of_sweep;
use super::search::Comparison;
use super::spectrum::{LogValue, Spectrum};
use crate::identify::frf::AXES;
use crate::identify::{IdentifyError, MeasuredFrf};
use crate::linalg::c64;
use crate::lti::response::even_in_logarithm;
use crate::lti::{HeldResponse, Response};
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// Lines that are compared, evenly spaced over the logarithm of frequency: enough to see each resonance of a few
/// modes.
const LINES: usize = 100;
/// Entries that are compared: those of one axis. Responses from x to y are zero in the model at rest.
const SAME_AXIS: [usize; 8] = [0, 2, 5, 7, 8, 10, 13, 15];

/// Plausibility of a sweep that was read from `record`; `controller` is the one that the record names.
///
/// # Errors
/// [`IdentifyError::Machine`] when the machine has no plant.
pub fn sweep_plausibility(
    record: &str,
    frf: &MeasuredFrf,
    machine: &Machine,
    controller: Option<&dyn HeldResponse>,
) -> Result<Plausibility, IdentifyError> {
    let plant = Plant::new(machine, frf.speed_rpm * TAU / 60.0, ModelDetail::Full)?;
    let lines = spread(&frf.frequency_hz, LINES);
    let data = Spectrum {
        frequency_hz: lines.iter().map(|l| frf.frequency_hz[*l]).collect(),
        entries: lines.iter().map(|l| measured_line(frf, *l)).collect(),
    };
    let model = |hz: &[f64]| model_spectrum(&plant, hz);
    let comparison = Comparison { data: &data, outputs: AXES, compared: &SAME_AXIS, model: &model };
    let faults = comparison.faults(&of_sweep());
    let nominal = model_spectrum(&plant, &data.frequency_hz);
    let measured = MeasuredRecord {
        frf,
        lines: &lines,
        data: &data,
        nominal: &nominal,
        machine,
        first_flexible_hz: plant.flexible_rad_s().first().map(|w| w / TAU),
        controller,
    };
    let mut checks = checks(&measured, comparison.agreement())?;
    checks.extend(slips(&measured));
    Ok(Plausibility { record: record.to_owned(), checks, faults })
}

fn measured_line(frf: &MeasuredFrf, line: usize) -> Vec<LogValue> {
    let entry = |k: usize| {
        let (i, j) = (k % AXES, k / AXES);
        LogValue::of(frf.response[(line, i, j)], frf.sigma(line, i, j, 0.0))
    };
    (0..AXES * AXES).map(entry).collect()
}

fn model_spectrum(plant: &Plant, hz: &[f64]) -> Spectrum {
    let line = |f: &f64| {
        let g = plant.at(TAU * f);
        let entry = |k: usize| -> c64 { g[(k % AXES, k / AXES)] };
        (0..AXES * AXES).map(|k| LogValue::of(entry(k), 0.0)).collect()
    };
    Spectrum { frequency_hz: hz.to_vec(), entries: hz.iter().map(line).collect() }
}

/// Indices of at most `most` lines, evenly spaced over the logarithm of frequency, ascending, none twice.
pub(super) fn spread(frequency_hz: &[f64], most: usize) -> Vec<usize> {
    let (Some(from), Some(to)) = (frequency_hz.first(), frequency_hz.last()) else {
        return vec![];
    };
    let mut lines: Vec<usize> = even_in_logarithm(*from, *to, most)
        .map(|wanted| {
            let above = frequency_hz.partition_point(|f| *f < wanted);
            let above = above.min(frequency_hz.len() - 1);
            let below = above.saturating_sub(1);
            let off = |l: usize| (frequency_hz[l] / wanted).ln().abs();
            if off(below) < off(above) { below } else { above }
        })
        .collect();
    lines.dedup();
    lines
}
