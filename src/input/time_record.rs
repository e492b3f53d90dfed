//! Samples over time, from CSV (a header of names, `time_s` among them or a sample rate beside it), WAV, time responses
//! of a universal file (dataset 58, function type 1) and vectors of a MATLAB file.

use super::error::InputError;
use super::file::{self, MATLAB, UNIVERSAL};
use super::table::{Columns, each_number_row, first_line, keep};
use super::uff_units::{FORCE, UffUnit, read_unit};
use super::wav::read_wav;
use super::{mat, uff};
use crate::identify::spectra::Motion;
use std::path::Path;

/// Names of a vector of times, s, and of a sample rate, Hz.
const TIMES: [&str; 3] = ["time_s", "time", "t"];
const RATES: [&str; 3] = ["sample_rate_hz", "fs", "Fs"];
/// Part of a sample by which times may be off an even raster, besides the digits that they are printed with; and with
/// these: at half a sample one may be missing.
const UNEVEN: f64 = 0.05;
const MOST_UNEVEN: f64 = 0.45;
/// Most decimals of times that are printed with few.
const FEW_DECIMALS: i32 = 7;

/// Signals that were sampled together.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeRecord {
    /// The file.
    pub file: String,
    /// Samples a second, Hz; none where neither the file nor its reader says so.
    pub sample_rate_hz: Option<f64>,
    /// Signals of equal length.
    pub signals: Vec<TimeSignal>,
}

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSignal {
    /// Column, number of the channel from 1, `node:direction` or variable.
    pub name: String,
    /// Samples; in SI where the file states a unit.
    pub samples: Vec<f64>,
    /// Exponents of metre, second and newton in their unit, where the file states it.
    pub dimensions: Option<[i32; 3]>,
}

impl TimeSignal {
    fn new(name: String, samples: Vec<f64>) -> Self {
        Self { name, samples, dimensions: None }
    }
}

impl TimeRecord {
    /// The signal of a name; where several have it, `name#1` is the first of them.
    ///
    /// # Errors
    /// [`InputError`] with the names that there are.
    pub fn signal(&self, name: &str) -> Result<&TimeSignal, InputError> {
        let names = self.names();
        let found = names.iter().position(|own| own == name).map(|k| &self.signals[k]);
        found.ok_or_else(|| {
            InputError::new(&self.file, format!("has no signal {name:?}"))
                .with_hint(format!("its signals are {}", names.join(", ")))
        })
    }

    fn names(&self) -> Vec<String> {
        let names: Vec<&str> = self.signals.iter().map(|s| s.name.as_str()).collect();
        let name = |k: usize| {
            let same = |others: &[&str]| others.iter().filter(|other| **other == names[k]).count();
            if same(&names) > 1 { format!("{}#{}", names[k], same(&names[..=k])) } else { names[k].to_owned() }
        };
        (0..names.len()).map(name).collect()
    }
}

/// Reads a file; the extension tells its format.
///
/// # Errors
/// [`InputError`] with what is wrong.
pub fn load_time_record(file: &str) -> Result<TimeRecord, InputError> {
    let path = Path::new(file);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "wav" | "mat" | "uff" | "unv" => {
            let limit = if matches!(extension.as_str(), "uff" | "unv") { UNIVERSAL } else { MATLAB };
            read_time_record(file, &file::read(path, limit).map_err(|error| error.of(file))?)
        }
        _ => {
            let open = || file::open_rows(path, &|_| ()).map_err(|error| error.of(file));
            let header = first_line(file, open()?)?;
            from_table(file, &header, open()?)
        }
    }
}

/// A time record from the bytes of its file; the extension tells its format.
///
/// # Errors
/// As [`load_time_record`].
pub fn read_time_record(file: &str, bytes: &[u8]) -> Result<TimeRecord, InputError> {
    let lower = file.to_ascii_lowercase();
    if lower.ends_with(".wav") {
        let (rate, channels) = read_wav(file, bytes)?;
        let named = channels.into_iter().enumerate();
        let signals = named.map(|(k, samples)| TimeSignal::new((k + 1).to_string(), samples)).collect();
        return Ok(TimeRecord { file: file.to_owned(), sample_rate_hz: Some(rate), signals });
    }
    if lower.ends_with(".mat") {
        return from_matrices(file, &mat::matrices(file, bytes)?);
    }
    if lower.ends_with(".uff") || lower.ends_with(".unv") {
        return from_functions(file, &uff::read(file, bytes)?);
    }
    from_table(file, &first_line(file, bytes)?, bytes)
}

fn from_table(file: &str, header: &str, rows: impl std::io::BufRead) -> Result<TimeRecord, InputError> {
    let clean = |name: &str| name.trim().trim_start_matches('\u{feff}').trim_matches('"').trim().to_owned();
    let names: Vec<String> = header.split(',').map(clean).collect();
    let mut columns: Vec<Vec<f64>> = vec![vec![]; names.len()];
    each_number_row(file, rows, &Columns { names: &names, optional: 0 }, &mut |line, row| {
        columns.iter_mut().zip(row).try_for_each(|(column, x)| keep(file, line, column, *x))
    })?;
    let signals = names.into_iter().zip(columns).map(|(name, samples)| TimeSignal::new(name, samples)).collect();
    of_signals(file, signals)
}

/// A record whose times or sample rate are among the signals.
fn of_signals(file: &str, mut signals: Vec<TimeSignal>) -> Result<TimeRecord, InputError> {
    let mut sample_rate_hz = None;
    if let Some(k) = signals.iter().position(|s| RATES.contains(&s.name.as_str())) {
        sample_rate_hz = signals.remove(k).samples.first().copied();
    }
    if let Some(k) = signals.iter().position(|s| TIMES.contains(&s.name.as_str())) {
        sample_rate_hz = Some(rate_of(file, &signals.remove(k).samples)?);
    }
    let samples = signals.first().map_or(0, |s| s.samples.len());
    if samples == 0 || signals.iter().any(|s| s.samples.len() != samples) {
        return Err(InputError::new(file, "has no signals, or signals of different length")
            .with_hint("a time record has one signal a column, all as long as `time_s`"));
    }
    Ok(TimeRecord { file: file.to_owned(), sample_rate_hz, signals })
}

/// Samples a second of even times.
fn rate_of(file: &str, times: &[f64]) -> Result<f64, InputError> {
    // The straight line through all of them: a single one is rounded.
    let middle = 0.5 * times.len().saturating_sub(1) as f64;
    let mean = times.iter().sum::<f64>() / times.len().max(1) as f64;
    let (mut along, mut squares) = (0.0, 0.0);
    for (k, t) in times.iter().enumerate() {
        along += (k as f64 - middle) * (t - mean);
        squares += (k as f64 - middle).powi(2);
    }
    let step = along / squares;
    let tolerance = (UNEVEN * step + resolution(times)).min(MOST_UNEVEN * step);
    let off = |(k, t): (usize, &f64)| (t - mean - (k as f64 - middle) * step).abs() > tolerance;
    if step > 0.0 && !times.iter().enumerate().any(off) {
        return Ok(step.recip());
    }
    Err(InputError::new(file, "its times do not ascend evenly").with_hint("sample it again at an even rate"))
}

/// What the digits of times tell apart: the last decimal, or that of a number in single precision; zero for more.
fn resolution(times: &[f64]) -> f64 {
    let largest = times.iter().copied().fold(0.0, |a: f64, t| a.max(t.abs()));
    let all_multiples = |step: &f64| {
        // Decimals are binary numbers but for their rounding.
        times.iter().all(|t| (t / step - (t / step).round()).abs() <= 4.0 * f64::EPSILON * (t / step).abs())
    };
    let decimal = (0..=FEW_DECIMALS).map(|k| 10f64.powi(-k)).find(all_multiples);
    let single = || times.iter().all(|t| f64::from(*t as f32) == *t).then_some(f64::from(f32::EPSILON) * largest);
    decimal.or_else(single).unwrap_or(0.0)
}

/// Vectors of one length; a scalar named as a sample rate is one.
fn from_matrices(file: &str, matrices: &[mat::Matrix]) -> Result<TimeRecord, InputError> {
    let one_row = |m: &&mat::Matrix| m.sizes.iter().filter(|size| **size != 1).count() <= 1;
    let vectors = matrices.iter().filter(one_row).filter_map(|m| Some((m.name.clone(), m.values.clone()?)));
    let rated = |name: &str| RATES.contains(&name);
    let (scalars, vectors): (Vec<_>, Vec<_>) = vectors.partition(|(name, values)| rated(name) && values.len() == 1);
    let longest = vectors.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    let whole = vectors.into_iter().filter(|(_, values)| values.len() == longest);
    of_signals(file, scalars.into_iter().chain(whole).map(|(name, samples)| TimeSignal::new(name, samples)).collect())
}

/// The time responses of a universal file that are as long as the first one.
fn from_functions(file: &str, functions: &[uff::UffFunction]) -> Result<TimeRecord, InputError> {
    let mut responses = functions.iter().filter(|f| f.function_type == 1 && !f.complex).peekable();
    let Some(first) = responses.peek() else {
        return Err(InputError::new(file, "has no time response (function type 1)")
            .with_hint("needed are the samples of force and response, each a dataset 58"));
    };
    let samples = first.x.len();
    let second = label_of(file, &first.abscissa.units, "abscissa")?.map_or(1.0, |unit| unit.si);
    let sample_rate_hz = Some(rate_of(file, &first.x)? / second);
    let mut signals = vec![];
    for response in responses.filter(|f| f.x.len() == samples) {
        let (node, direction) = response.response;
        let (system, kind) = (response.system.as_ref(), response.ordinate.kind);
        let unit = match label_of(file, &response.ordinate.units, "ordinate")? {
            Some(unit) => Some((unit.si, unit.dimensions)),
            None if matches!(kind, 9 | 13) => Some((system.map_or(1.0, |s| s.force_n), FORCE)),
            None => Motion::of_type(response)
                .ok()
                .flatten()
                .map(|motion| (system.map_or(1.0, |s| s.length_m), motion.dimensions())),
        };
        // What points the other way is turned to the positive direction.
        let scale = unit.map_or(1.0, |(si, _)| si) * if direction < 0 { -1.0 } else { 1.0 };
        signals.push(TimeSignal {
            name: format!("{node}:{direction}"),
            samples: response.y.iter().map(|y| y.re * scale).collect(),
            dimensions: unit.map(|(_, dimensions)| dimensions),
        });
    }
    Ok(TimeRecord { file: file.to_owned(), sample_rate_hz, signals })
}

fn label_of(file: &str, label: &str, axis: &str) -> Result<Option<UffUnit>, InputError> {
    read_unit(label).map_err(|part| {
        InputError::new(file, format!("the unit {label:?} is not understood: {part}"))
            .with_hint(format!("correct the label of the {axis}"))
    })
}
