//! Open-loop frequency responses from closed-loop sweeps:  Ĝ = Ȳ Ū⁻¹  line by line, experiments as columns, bars over
//! repeats.
//!
//! Never Y/U per channel: the loop is closed and every axis answers every injection. With v = y − Ĝu of each repeat,
//!   Σ_v = Σ v vᴴ / (E (P − 1)),   Cov(vec Ĝ) = (Ū Ūᴴ)⁻ᵀ ⊗ Σ_v / P,
//! so noise that the controller feeds back into u is accounted for. Complex covariances: real and imaginary part of an
//! entry have half its variance each. Symbols: n = 4 axes, E = 4 experiments, P repeats, vec stacks columns (index =
//! output + 4·input). Limits: where the excitation is weak Ĝ tends to −K⁻¹; the condition number of Ū is kept for every
//! line.

use super::IdentifyError;
use crate::linalg::{Mat, c64, max_singular_value_complex, solve_complex};
use crate::lti::held::hold_magnitude;
use ndarray::{Array2, Array3, Array4, Axis, s};
use std::f64::consts::TAU;
use std::ops::Range;

/// Axes of the plant: front_x, front_y, rear_x, rear_y.
pub const AXES: usize = 4;
pub(crate) const AXIS_NAMES: [&str; AXES] = ["front_x", "front_y", "rear_x", "rear_y"];
/// Condition number of Ū above which a line is refused: rounding and the weakest noise would both be amplified a
/// million times.
const WORST_CONDITION: f64 = 1e6;
/// Noise matrices of this many lines on either side are averaged: sensor noise varies slowly along the lines, and three
/// repeats give only eight degrees of freedom a line.
const SMOOTHING: usize = 2;
/// Relative standard deviation of an entry when there is only one repeat and hence no scatter to look at.
const SINGLE_REPEAT_SD: f64 = 0.005;

/// Fourier coefficients of one sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRecord {
    /// Where it was read from, for messages.
    pub name: String,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Lines, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// Commanded currents, A: [line, experiment, repeat, axis].
    pub current: Array4<c64>,
    /// Sensor signals, m: [line, experiment, repeat, axis].
    pub signal: Array4<c64>,
    /// What of the file is not used, in words.
    pub left_out: Vec<String>,
}

impl SweepRecord {
    /// Number of repeats.
    pub fn repeats(&self) -> usize {
        self.current.dim().2
    }

    /// The lines with these numbers alone.
    #[must_use]
    pub(crate) fn with_lines(&self, lines: &[usize]) -> Self {
        Self {
            frequency_hz: lines.iter().map(|k| self.frequency_hz[*k]).collect(),
            current: self.current.select(Axis(0), lines),
            signal: self.signal.select(Axis(0), lines),
            ..self.clone()
        }
    }

    /// The same record with currents that were logged as samples, before the hold, brought behind it: their fundamental
    /// at the amplifier has the magnitude sinc(fT). Its half sample is part of `delay_s`, as for every record.
    #[must_use]
    pub(crate) fn behind_hold(mut self, period_s: f64) -> Self {
        for (mut line, hz) in self.current.outer_iter_mut().zip(&self.frequency_hz) {
            let magnitude = hold_magnitude(TAU * hz, period_s);
            line.mapv_inplace(|u| u * magnitude);
        }
        self
    }
}

/// An open-loop plant as measured, with its covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredFrf {
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Lines, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// Ĝ, m/A: [line, output, input].
    pub response: Array3<c64>,
    /// Cov(vec Ĝ), m²/A²: [line, 16, 16], vec index = output + 4·input.
    pub covariance: Array3<c64>,
    /// Mean currents Ū, A: [line, axis, experiment].
    pub current: Array3<c64>,
    /// Mean sensor signals Ȳ, m: [line, axis, experiment].
    pub signal: Array3<c64>,
    /// Repeats behind every mean.
    pub repeats: usize,
    /// Condition number of Ū per line.
    pub condition: Vec<f64>,
}

impl MeasuredFrf {
    /// Number of lines.
    pub fn len(&self) -> usize {
        self.frequency_hz.len()
    }

    /// True without lines.
    pub fn is_empty(&self) -> bool {
        self.frequency_hz.is_empty()
    }

    /// Standard deviation of a complex entry, √E|δG|², m/A, with `floor` × |G| added in squares (0.005 is customary:
    /// re-levitation and amplitude dependence that repeats do not show).
    pub fn sigma(&self, line: usize, output: usize, input: usize, floor: f64) -> f64 {
        let k = output + AXES * input;
        let noise = self.covariance[(line, k, k)].re.max(0.0);
        let size = self.response[(line, output, input)].norm();
        (noise + (floor * size).powi(2)).sqrt()
    }
}

/// The lines over which the noise of a line is averaged, it among them.
pub(super) fn neighbours(line: usize, lines: usize) -> Range<usize> {
    line.saturating_sub(SMOOTHING)..(line + SMOOTHING + 1).min(lines)
}

/// Ĝ with its covariance.
///
/// # Errors
/// [`IdentifyError::Singular`] for a line whose experiments are linearly dependent, [`IdentifyError::Empty`] without
/// lines.
pub fn open_loop(record: &SweepRecord) -> Result<MeasuredFrf, IdentifyError> {
    let (lines, experiments, repeats, axes) = record.current.dim();
    if lines == 0 || repeats == 0 {
        return Err(IdentifyError::Empty { name: record.name.clone() });
    }
    if experiments != AXES || axes != AXES || record.signal.dim() != record.current.dim() {
        return Err(IdentifyError::Experiments { name: record.name.clone(), found: experiments });
    }
    let mean = |data: &Array4<c64>, line: usize| {
        Array2::from_shape_fn((AXES, AXES), |(axis, experiment)| {
            let column = data.slice(s![line, experiment, .., axis]);
            column.iter().fold(c64::new(0.0, 0.0), |a, b| a + b) / repeats as f64
        })
    };
    let mut frf = MeasuredFrf {
        speed_rpm: record.speed_rpm,
        frequency_hz: record.frequency_hz.clone(),
        response: Array3::from_elem((lines, AXES, AXES), c64::new(0.0, 0.0)),
        covariance: Array3::from_elem((lines, AXES * AXES, AXES * AXES), c64::new(0.0, 0.0)),
        current: Array3::from_elem((lines, AXES, AXES), c64::new(0.0, 0.0)),
        signal: Array3::from_elem((lines, AXES, AXES), c64::new(0.0, 0.0)),
        repeats,
        condition: vec![0.0; lines],
    };
    let mut scatter = Vec::with_capacity(lines);
    let mut inverses = Vec::with_capacity(lines);
    for line in 0..lines {
        let (u, y) = (mean(&record.current, line), mean(&record.signal, line));
        let u_mat = Mat::from_fn(AXES, AXES, |i, j| u[(i, j)]);
        let identity = Mat::from_fn(AXES, AXES, |i, j| c64::new(if i == j { 1.0 } else { 0.0 }, 0.0));
        let inverse = solve_complex(&u_mat, &identity);
        let condition = max_singular_value_complex(&u_mat) * max_singular_value_complex(&inverse);
        if condition.partial_cmp(&WORST_CONDITION) != Some(std::cmp::Ordering::Less) {
            return Err(IdentifyError::Singular {
                name: record.name.clone(),
                frequency_hz: record.frequency_hz[line],
                condition,
            });
        }
        let g = Mat::from_fn(AXES, AXES, |i, j| y[(i, j)]) * &inverse;
        frf.condition[line] = condition;
        for i in 0..AXES {
            for j in 0..AXES {
                frf.response[(line, i, j)] = g[(i, j)];
                frf.current[(line, i, j)] = u[(i, j)];
                frf.signal[(line, i, j)] = y[(i, j)];
            }
        }
        scatter.push(noise(record, line, &g));
        inverses.push(inverse);
    }
    for (line, inverse) in inverses.iter().enumerate() {
        let window = neighbours(line, lines);
        let count = window.len() as f64;
        let sigma_v = window.fold(Mat::<c64>::zeros(AXES, AXES), |sum, k| sum + &scatter[k]);
        for j in 0..AXES {
            for l in 0..AXES {
                // (U Uᴴ)⁻ᵀ = U⁻ᵀ (U⁻ᵀ)ᴴ
                let u = (0..AXES).fold(c64::new(0.0, 0.0), |sum, e| sum + inverse[(e, j)] * inverse[(e, l)].conj());
                for i in 0..AXES {
                    for k in 0..AXES {
                        frf.covariance[(line, i + AXES * j, k + AXES * l)] =
                            u * sigma_v[(i, k)] / (count * repeats as f64);
                    }
                }
            }
        }
    }
    if repeats == 1 {
        for line in 0..lines {
            for j in 0..AXES {
                for i in 0..AXES {
                    let size = SINGLE_REPEAT_SD * frf.response[(line, i, j)].norm();
                    let k = i + AXES * j;
                    frf.covariance[(line, k, k)] = c64::new(size * size, 0.0);
                }
            }
        }
    }
    Ok(frf)
}

/// Σ_v of one line from the scatter over repeats; zero for a single repeat.
fn noise(record: &SweepRecord, line: usize, g: &Mat<c64>) -> Mat<c64> {
    let (_, experiments, repeats, _) = record.current.dim();
    let mut sum = Mat::<c64>::zeros(AXES, AXES);
    if repeats < 2 {
        return sum;
    }
    for e in 0..experiments {
        for p in 0..repeats {
            let v: Vec<c64> = (0..AXES)
                .map(|i| {
                    (0..AXES).fold(record.signal[(line, e, p, i)], |rest, j| {
                        rest - g[(i, j)] * record.current[(line, e, p, j)]
                    })
                })
                .collect();
            for i in 0..AXES {
                for k in 0..AXES {
                    sum[(i, k)] += v[i] * v[k].conj();
                }
            }
        }
    }
    let freedom = (experiments * (repeats - 1)) as f64;
    Mat::from_fn(AXES, AXES, |i, k| sum[(i, k)] / freedom)
}
