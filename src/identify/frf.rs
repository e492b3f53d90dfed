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
use ndarray::{Array3, Array4, Axis, s};
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
    /// Commanded currents, A: [line, experiment, repeat, axis]; zero throughout an experiment that was not taken.
    pub current: Array4<c64>,
    /// Sensor signals, m: [line, experiment, repeat, axis].
    pub signal: Array4<c64>,
    /// What of the file is not used, in words.
    pub left_out: Vec<String>,
    /// Whether run-out was seen, which leaks into all lines in one phase a repeat.
    pub run_out: bool,
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
    /// Columns that the injections determine; the others are zero.
    pub determined: [bool; AXES],
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

    /// Coherence of an entry at a line: that of one input and one output whose response scatters as much over the
    /// repeats, γ² = |G|²/(|G|² + P E|δG|²) (Bendat and Piersol, Random Data, sec. 9.2); with one repeat that of the
    /// scatter that is assumed.
    pub fn coherence(&self, line: usize, output: usize, input: usize) -> f64 {
        let size = self.response[(line, output, input)].norm_sqr();
        size / (size + self.repeats.max(1) as f64 * self.sigma(line, output, input, 0.0).powi(2))
    }
}

/// The lines over which the noise of a line is averaged, it among them.
pub(super) fn neighbours(line: usize, lines: usize) -> Range<usize> {
    line.saturating_sub(SMOOTHING)..(line + SMOOTHING + 1).min(lines)
}

/// Share of the current of an injection that the other bearing of its plane may have: the column is then off by as
/// much.
const OTHER_CURRENT: f64 = 0.01;

/// Ĝ with its covariance from four injections.
///
/// # Errors
/// [`IdentifyError::Singular`] for a line whose experiments are linearly dependent, [`IdentifyError::Empty`] without
/// lines, [`IdentifyError::Experiments`] when one was not taken.
pub fn open_loop(record: &SweepRecord) -> Result<MeasuredFrf, IdentifyError> {
    record.check_shape()?;
    let taken = record.taken();
    if taken.len() != AXES {
        return Err(IdentifyError::Experiments { name: record.name.clone(), found: taken.len() });
    }
    columns(record, &[&[0, 1, 2, 3]])
}

/// The columns of Ĝ that the injections of a record determine, with their covariance; at rest each plane alone. What is
/// not determined is zero and said in words.
///
/// # Errors
/// As [`open_loop`]; [`IdentifyError::Experiments`] for a record at speed without four injections;
/// [`IdentifyError::Undetermined`] when no column is determined.
pub fn open_loop_columns(record: &SweepRecord) -> Result<(MeasuredFrf, Vec<String>), IdentifyError> {
    record.check_shape()?;
    let taken = record.taken();
    if taken.len() == AXES {
        return Ok((open_loop(record)?, vec![]));
    }
    let (mut groups, mut notes): (Vec<&[usize]>, Vec<String>) = (vec![], vec![]);
    for plane in [[0, 2], [1, 3]] {
        match taken.iter().filter(|axis| plane.contains(axis)).collect::<Vec<_>>()[..] {
            [_, _] => groups.push(if plane[0] == 0 { &[0, 2] } else { &[1, 3] }),
            [own] => {
                let other = plane[0] + plane[1] - own;
                let share = record.share_of_current(*own, other);
                let (injected, answers) = (AXIS_NAMES[*own], AXIS_NAMES[other]);
                if share <= OTHER_CURRENT {
                    groups.push(&[[0], [1], [2], [3]][*own]);
                    notes.push(format!("no injection into {answers}: the responses to its current are not determined"));
                } else {
                    notes.push(format!(
                        "the current of {answers} answers the injection into {injected} with up to {:.0} % of it: \
                         without an injection into {answers} no response to either is determined",
                        100.0 * share
                    ));
                }
            }
            _ => notes.push(format!(
                "no injection into {} and {}: nothing of that plane is determined",
                AXIS_NAMES[plane[0]], AXIS_NAMES[plane[1]]
            )),
        }
    }
    if groups.is_empty() && record.speed_rpm == 0.0 {
        return Err(IdentifyError::Undetermined { name: record.name.clone(), why: notes.join("; ") });
    }
    if record.speed_rpm != 0.0 {
        return Err(IdentifyError::Experiments { name: record.name.clone(), found: taken.len() });
    }
    Ok((columns(record, &groups)?, notes))
}

impl SweepRecord {
    fn check_shape(&self) -> Result<(), IdentifyError> {
        let (lines, experiments, repeats, axes) = self.current.dim();
        if lines == 0 || repeats == 0 {
            return Err(IdentifyError::Empty { name: self.name.clone() });
        }
        if experiments != AXES || axes != AXES || self.signal.dim() != self.current.dim() {
            return Err(IdentifyError::Experiments { name: self.name.clone(), found: experiments });
        }
        Ok(())
    }

    /// Axes that were injected into: an experiment without any current was not taken.
    fn taken(&self) -> Vec<usize> {
        (0..AXES).filter(|e| self.current.slice(s![.., *e, .., ..]).iter().any(|u| u.norm() > 0.0)).collect()
    }

    /// Largest current of an axis over that of the injection, of all lines.
    fn share_of_current(&self, injected: usize, other: usize) -> f64 {
        let size = |line: usize, axis: usize| {
            let repeats = self.current.slice(s![line, injected, .., axis]);
            repeats.iter().copied().sum::<c64>().norm()
        };
        (0..self.frequency_hz.len()).map(|l| size(l, other) / size(l, injected)).fold(0.0, f64::max)
    }
}

/// Ĝ in groups of axes, each injected into as often as it has axes; currents outside a group count as none.
fn columns(record: &SweepRecord, groups: &[&[usize]]) -> Result<MeasuredFrf, IdentifyError> {
    let (lines, _, repeats, _) = record.current.dim();
    let mean = |data: &Array4<c64>| {
        let mean = data.sum_axis(Axis(2)).mapv(|sum| sum / repeats as f64);
        mean.permuted_axes([0, 2, 1]).as_standard_layout().to_owned()
    };
    let mut frf = MeasuredFrf {
        speed_rpm: record.speed_rpm,
        frequency_hz: record.frequency_hz.clone(),
        response: Array3::from_elem((lines, AXES, AXES), c64::new(0.0, 0.0)),
        covariance: Array3::from_elem((lines, AXES * AXES, AXES * AXES), c64::new(0.0, 0.0)),
        current: mean(&record.current),
        signal: mean(&record.signal),
        repeats,
        condition: vec![0.0; lines],
        determined: std::array::from_fn(|axis| groups.iter().any(|group| group.contains(&axis))),
    };
    for group in groups {
        add_columns(&mut frf, record, group)?;
    }
    if repeats == 1 {
        for ((line, i, j), g) in frf.response.indexed_iter() {
            let size = SINGLE_REPEAT_SD * g.norm();
            let k = i + AXES * j;
            frf.covariance[(line, k, k)] = c64::new(size * size, 0.0);
        }
    }
    Ok(frf)
}

fn add_columns(frf: &mut MeasuredFrf, record: &SweepRecord, group: &[usize]) -> Result<(), IdentifyError> {
    let (lines, size) = (frf.len(), group.len());
    let mut scatter = Vec::with_capacity(lines);
    let mut inverses = Vec::with_capacity(lines);
    for line in 0..lines {
        let u = Mat::from_fn(size, size, |i, e| frf.current[(line, group[i], group[e])]);
        let identity = Mat::from_fn(size, size, |i, j| c64::new(if i == j { 1.0 } else { 0.0 }, 0.0));
        let inverse = solve_complex(&u, &identity);
        let condition = max_singular_value_complex(&u) * max_singular_value_complex(&inverse);
        if condition.partial_cmp(&WORST_CONDITION) != Some(std::cmp::Ordering::Less) {
            return Err(IdentifyError::Singular {
                name: record.name.clone(),
                frequency_hz: record.frequency_hz[line],
                condition,
            });
        }
        let g = Mat::from_fn(AXES, size, |i, e| frf.signal[(line, i, group[e])]) * &inverse;
        frf.condition[line] = condition.max(frf.condition[line]);
        for i in 0..AXES {
            for (j, axis) in group.iter().enumerate() {
                frf.response[(line, i, *axis)] = g[(i, j)];
            }
        }
        scatter.push(noise(record, line, &g, group));
        inverses.push(inverse);
    }
    for (line, inverse) in inverses.iter().enumerate() {
        let window = neighbours(line, lines);
        let count = window.len() as f64 * frf.repeats as f64;
        let sigma_v = window.fold(Mat::<c64>::zeros(AXES, AXES), |sum, k| sum + &scatter[k]);
        for (j, column) in group.iter().enumerate() {
            for (l, other) in group.iter().enumerate() {
                // (U Uᴴ)⁻ᵀ = U⁻ᵀ (U⁻ᵀ)ᴴ
                let u = (0..size).fold(c64::new(0.0, 0.0), |sum, e| sum + inverse[(e, j)] * inverse[(e, l)].conj());
                for i in 0..AXES {
                    for k in 0..AXES {
                        frf.covariance[(line, i + AXES * column, k + AXES * other)] = u * sigma_v[(i, k)] / count;
                    }
                }
            }
        }
    }
    Ok(())
}

/// Σ_v of one line from the scatter over repeats; zero for a single repeat.
fn noise(record: &SweepRecord, line: usize, g: &Mat<c64>, group: &[usize]) -> Mat<c64> {
    let repeats = record.repeats();
    let mut sum = Mat::<c64>::zeros(AXES, AXES);
    if repeats < 2 {
        return sum;
    }
    for e in group {
        for p in 0..repeats {
            let v: Vec<c64> = (0..AXES)
                .map(|i| {
                    group.iter().enumerate().fold(record.signal[(line, *e, p, i)], |rest, (j, axis)| {
                        rest - g[(i, j)] * record.current[(line, *e, p, *axis)]
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
    let freedom = (group.len() * (repeats - 1)) as f64;
    Mat::from_fn(AXES, AXES, |i, k| sum[(i, k)] / freedom)
}
