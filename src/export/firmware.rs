//! The files of a controller for firmware: JSON, `.mat`, C, coefficient table, test vectors. Nothing is written here:
//! every file comes back as its name and bytes, so that a results folder can stage them whole.

use super::c::{FirmwareLabels, header, source};
pub use super::error::FirmwareError;
use super::json::{channel_name, controller_json};
use super::mat::mat_file;
use super::sections::section_tables;
use crate::controller::arithmetic::{Float32Program, Q31Program, float32, q31};
use crate::controller::continuous::continuous_fit;
use crate::controller::hand_over::hand_over;
use crate::controller::scaling::ScaledRealisation;
use crate::controller::verification::Verification;
use crate::controller::{ControlLaw, Controller, MachineTag};
use crate::linalg::Mat;
use crate::lti::{Discrete, StateSpace};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// Samples in the test vectors.
const TEST_SAMPLES: usize = 256;
/// Seed of the random part of the test vectors.
const TEST_SEED: u64 = 20_000;

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// `controller.h`, `controller.c`, `test_vectors.csv`; `sections.h` for a decentralised controller whose sections
    /// hold it.
    C,
    /// `coefficients.csv`, `test_vectors.csv`.
    Csv,
    /// `controller.mat`.
    Mat,
    /// `discrete.json`, `continuous.json` and, when that is an approximation, `continuous_error.csv`.
    Json,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::C, Self::Csv, Self::Mat, Self::Json];
}

/// Everything the files say.
#[derive(Clone, Copy, Debug)]
pub struct Firmware<'a> {
    /// The sampled controller as designed (double precision).
    pub discrete: &'a Controller,
    /// The continuous controller it came from by sampling; without one, K(s) is fitted to the sampled controller.
    pub continuous: Option<&'a Controller>,
    /// The same controller as firmware computes it.
    pub scaled: &'a ScaledRealisation,
    /// What is known about its loop.
    pub verification: &'a Verification,
    /// Spindle and tool, for the reader.
    pub machine: &'a str,
    /// The same for programs: files and hash, in the JSON files.
    pub tag: Option<&'a MachineTag>,
    /// What every C symbol of the controller begins with, see [`crate::export::c::is_prefix`].
    pub prefix: &'a str,
}

/// SHA-256 of a byte string, hex.
pub(crate) fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}

/// The files of a controller, and what a reader should know about them.
#[derive(Clone, Debug, PartialEq)]
pub struct FirmwareFiles {
    /// (Relative name, bytes), in a fixed order.
    pub files: Vec<(String, Vec<u8>)>,
    /// A sentence each: what is not among the files although it was asked for, and why.
    pub notes: Vec<String>,
}

/// The files of the formats asked.
///
/// # Errors
/// [`FirmwareError`] when the controller is continuous, or does not fit the arithmetic.
pub fn write_all(firmware: &Firmware<'_>, formats: &[Format]) -> Result<FirmwareFiles, FirmwareError> {
    let ControlLaw::Discrete(law) = &firmware.discrete.law else {
        return Err(FirmwareError::Continuous(firmware.discrete.name.clone()));
    };
    let json = controller_json(firmware.discrete, firmware.tag);
    let (float, fixed) = (float32(firmware.scaled)?, q31(firmware.scaled)?);
    let wants = |format| formats.contains(&format);
    let (mut files, mut notes): (Vec<(String, Vec<u8>)>, Vec<String>) = (Vec::new(), Vec::new());
    if wants(Format::Json) {
        files.extend(continuous_files(firmware, law)?);
    }
    if wants(Format::Mat) {
        let period = Mat::from_fn(1, 1, |_, _| law.time.period_s);
        let matrices = [("A", &law.a), ("B", &law.b), ("C", &law.c), ("D", &law.d), ("Ts", &period)];
        files.push(("controller.mat".to_owned(), mat_file(&matrices)?));
    }
    if wants(Format::C) {
        let labels = FirmwareLabels {
            prefix: firmware.prefix.to_owned(),
            name: firmware.discrete.name.clone(),
            machine: firmware.machine.to_owned(),
            input_sha256: sha256_hex(&json),
        };
        let bound = fixed.error_bound_a(TEST_SAMPLES);
        files.push(("controller.h".to_owned(), header(firmware.scaled, firmware.verification, &labels)?.into_bytes()));
        files.push((
            "controller.c".to_owned(),
            source(firmware.prefix, &float, &fixed, &hand_over(firmware.scaled)?, bound)?.into_bytes(),
        ));
        let sections = section_tables(law, firmware.prefix, &firmware.discrete.name)?;
        files.extend(sections.header.map(|header| ("sections.h".to_owned(), header.into_bytes())));
        notes.extend(sections.notes);
    }
    if wants(Format::Csv) {
        let table = coefficient_table(firmware.scaled, &float, &fixed);
        files.push(("coefficients.csv".to_owned(), table.into_bytes()));
    }
    if wants(Format::Json) {
        files.push(("discrete.json".to_owned(), json));
    }
    if wants(Format::C) || wants(Format::Csv) {
        let table = test_vectors(firmware.scaled, float, fixed);
        files.push(("test_vectors.csv".to_owned(), table.into_bytes()));
    }
    Ok(FirmwareFiles { files, notes })
}

/// The continuous controller that the sampled one came from, or else the fitted one with its error over frequency.
fn continuous_files(
    firmware: &Firmware<'_>,
    law: &StateSpace<Discrete>,
) -> Result<Vec<(String, Vec<u8>)>, FirmwareError> {
    if let Some(continuous) = firmware.continuous {
        return Ok(vec![("continuous.json".to_owned(), controller_json(continuous, firmware.tag))]);
    }
    let fit = continuous_fit(law)?;
    let mut table = String::from("frequency_hz,relative_error\n");
    for (frequency_hz, error) in &fit.relative_error {
        let _ = writeln!(table, "{frequency_hz:e},{error:e}");
    }
    let controller = Controller { name: firmware.discrete.name.clone(), law: ControlLaw::Continuous(fit.law) };
    Ok(vec![
        ("continuous.json".to_owned(), controller_json(&controller, firmware.tag)),
        ("continuous_error.csv".to_owned(), table.into_bytes()),
    ])
}

/// One line per product: row, source, coefficient in double, float32 and Q31, post shift of the row.
fn coefficient_table(scaled: &ScaledRealisation, float: &Float32Program, fixed: &Q31Program) -> String {
    let rows = &scaled.rows;
    let (n, m, outputs) = (rows.order(), rows.inputs, rows.outputs.len());
    let label = |kind: &str, k: usize| format!("{kind}_{k}");
    let source = |k: usize| {
        if k < n {
            label("state", k)
        } else if k < n + m {
            format!("input_{}", channel_name(k - n, m))
        } else {
            label("signal", k - n - m)
        }
    };
    let names = (0..rows.signals.len())
        .map(|k| label("signal", k))
        .chain((0..outputs).map(|k| format!("output_{}", channel_name(k, outputs))))
        .chain((0..n).map(|k| label("next_state", k)));
    let fixed_rows = fixed.signals.iter().chain(&fixed.outputs).chain(&fixed.states);
    let mut text = String::from("row,source,coefficient,coefficient_float32,coefficient_q31,right_shift_q31\n");
    for (((name, exact), single), fixed_row) in names.zip(rows.rows()).zip(float.rows.rows()).zip(fixed_rows) {
        for ((term, single), integer) in exact.iter().zip(single).zip(&fixed_row.terms) {
            let _ = writeln!(
                text,
                "{name},{},{:e},{:e},{},{}",
                source(term.source),
                term.coefficient,
                single.coefficient as f32,
                integer.1,
                fixed_row.shift,
            );
        }
    }
    text
}

/// Inputs and expected outputs: an impulse on each axis, a random stretch within all limits, a step that saturates,
/// and rest. Both programs start from zero states.
fn test_vectors(scaled: &ScaledRealisation, mut float: Float32Program, mut fixed: Q31Program) -> String {
    let (inputs, outputs) = (float.rows.inputs, float.rows.outputs.len());
    let limit = fixed.input_full_scale_m;
    // Half the output limit at most: the states stay within ±1 for inputs at theirs.
    let linear = limit * (0.5 * scaled.limits.output_a / scaled.output_reach_a).min(0.1);
    let mut random = ChaCha8Rng::seed_from_u64(TEST_SEED);
    let mut text = String::from("sample");
    for unit in ["m", "a", "q31", "q31"].into_iter().enumerate() {
        let (prefix, count) = if unit.0 % 2 == 0 { ("y", inputs) } else { ("u", outputs) };
        for k in 0..count {
            let _ = write!(text, ",{prefix}_{}_{}", channel_name(k, count), unit.1);
        }
    }
    text.push('\n');
    for sample in 0..TEST_SAMPLES {
        let y: Vec<f64> = (0..inputs)
            .map(|j| {
                let noise = random.random_range(-1.0..1.0);
                match sample {
                    // Impulses of a hundredth of the range, 24 samples apart.
                    0..96 => f64::from(u8::from(sample == 24 * j)) * 0.01 * limit,
                    96..176 => linear * noise,
                    176..216 => (0.5 + 0.1 * noise) * limit * if j % 2 == 0 { 1.0 } else { -1.0 },
                    _ => 0.0,
                }
            })
            .collect();
        let y_single: Vec<f32> = y.iter().map(|v| *v as f32).collect();
        let y_fixed: Vec<i32> = y.iter().map(|v| fixed.encode_input(*v)).collect();
        let _ = write!(text, "{sample}");
        let (u_single, u_fixed) = (float.step(&y_single), fixed.step(&y_fixed));
        for value in y_single.iter().chain(&u_single) {
            let _ = write!(text, ",{value:e}");
        }
        for value in y_fixed.iter().chain(&u_fixed) {
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
    text
}
