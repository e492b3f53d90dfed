//! Frequency responses from samples of a force and a response: averaged spectra of windowed segments (Welch, IEEE
//! Trans. AU-15, 1967; Bendat and Piersol, Random Data, ch. 11).
//!
//! S_xy = Σ X* Y over the segments, their mean removed;  H1 = S_xy/S_xx holds for noise of the response, H2 = S_yy/S_yx
//! for noise of the force, Hv = S_xy/|S_xy| √(S_yy/S_xx) for equal shares;  γ² = |S_xy|²/(S_xx S_yy).
//! Segments that overlap are not independent: n of a record count as n/(1 + 2 Σ (1 − k/n) ρ_k²) averages, ρ_k the
//! correlation of the window with itself k steps on.

use super::fourier::{fourier, largest_factor, smooth_length};
use crate::linalg::c64;
use std::f64::consts::{LN_10, TAU};

/// Window over the samples of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpectralWindow {
    /// sin² over the segment: for noise, sweeps and everything else that goes on.
    Hann,
    /// None: for taps whose response dies away within the segment, and for what is periodic in it.
    Rectangular,
    /// Falls to a hundredth at the end: for taps whose response does not die away. It adds to every damping.
    Exponential,
}

/// How the response is estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// S_xy/S_xx.
    H1,
    /// S_yy/S_yx.
    H2,
    /// S_xy/|S_xy| √(S_yy/S_xx).
    Hv,
}

/// What the response channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// m.
    Displacement,
    /// m/s.
    Velocity,
    /// m/s².
    Acceleration,
}

impl Motion {
    /// Displacement over the motion at a frequency above zero, Hz, in signals with so much damping added, Hz: the
    /// spectra of signals times e^(−at) are those at jω + a.
    pub(crate) fn to_displacement(self, frequency_hz: f64, added_damping_hz: f64) -> c64 {
        let s = c64::new(TAU * added_damping_hz, TAU * frequency_hz);
        let one = c64::new(1.0, 0.0);
        match self {
            Self::Displacement => one,
            Self::Velocity => one / s,
            Self::Acceleration => one / (s * s),
        }
    }
}

/// How segments are taken and averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Averaging {
    /// Window of every segment.
    pub window: SpectralWindow,
    /// Estimator of the response.
    pub estimator: Estimator,
    /// Samples of a segment; none: the whole record, with a Hann window a quarter of it, made a little shorter so that
    /// it has no large prime factor.
    pub segment: Option<usize>,
    /// Share of a segment that the next one takes up again, 0 to below 1.
    pub overlap: f64,
}

/// Samples of force and response that were taken together.
#[derive(Clone, Copy, Debug)]
pub struct Excitation<'a> {
    /// Force, N.
    pub force: &'a [f64],
    /// Response, as many.
    pub response: &'a [f64],
}

/// An averaged response.
#[derive(Clone, Debug, PartialEq)]
pub struct AveragedFrf {
    /// Lines above 0 Hz up to half of the sample rate, Hz.
    pub frequency_hz: Vec<f64>,
    /// Response over force, one a line.
    pub response: Vec<c64>,
    /// Coherence, one a line; 1 throughout for a single segment.
    pub coherence: Vec<f64>,
    /// Samples of a segment.
    pub segment: usize,
    /// Segments.
    pub segments: usize,
    /// Independent segments that tell as much.
    pub averages: f64,
    /// How far the segments are too short.
    pub leakage: Leakage,
    /// What an exponential window adds to ζf of every mode, Hz; zero for the others.
    pub added_damping_hz: f64,
}

/// How far segments are too short for the decay of the response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Leakage {
    /// Windowed at both ends: error of the line with most response to the force, relative to it, from segments half as
    /// long, whose error is four times that.
    OfPeak {
        /// The line, Hz.
        frequency_hz: f64,
        /// Relative error.
        relative_error: f64,
    },
    /// Root mean square of the last twentieth of the segments, windowed, over that of the strongest one.
    LeftAtEnd(f64),
}

/// Largest prime factor of a segment: the transform takes as many operations a sample.
const LARGEST_FACTOR: usize = 1000;
/// Parts of a segment in which its decay is looked at.
const PARTS: usize = 20;
/// Least samples of a segment.
const LEAST_SEGMENT: usize = 2 * PARTS;

/// The response that records share.
///
/// # Errors
/// Why the samples or the way of averaging give none, in words.
pub fn averaged_frf(
    records: &[Excitation<'_>],
    sample_rate_hz: f64,
    averaging: &Averaging,
) -> Result<AveragedFrf, String> {
    let shortest = records.iter().map(|r| r.force.len().min(r.response.len())).min().unwrap_or(0);
    let hann = averaging.window == SpectralWindow::Hann;
    let segment = averaging.segment.unwrap_or_else(|| smooth_length(if hann { shortest / 4 } else { shortest }));
    if segment > shortest || segment < LEAST_SEGMENT {
        return Err(format!(
            "a segment of {segment} samples: the shortest record has {shortest}, and {LEAST_SEGMENT} are needed"
        ));
    }
    if largest_factor(segment) > LARGEST_FACTOR {
        return Err(format!(
            "a segment of {segment} samples has the prime factor {}: {} samples have none above 7",
            largest_factor(segment),
            smooth_length(segment)
        ));
    }
    if !(0.0..1.0).contains(&averaging.overlap) {
        return Err(format!("an overlap of {}: it is a share of the segment, 0 to below 1", averaging.overlap));
    }
    let sums = Sums::of(records, segment, averaging);
    if sums.force.iter().all(|s| *s == 0.0) {
        return Err("the force is the same at all samples".to_owned());
    }
    let lines = 1..segment / 2 + 1;
    let frequency_hz: Vec<f64> = lines.clone().map(|k| k as f64 * sample_rate_hz / segment as f64).collect();
    let response: Vec<c64> = lines.clone().map(|k| sums.response_at(k, averaging.estimator)).collect();
    let leakage = if hann {
        let half = Sums::of(records, segment / 2, averaging);
        let even = (1..segment / 4).map(|k| 2 * k);
        // Where the force has no power the ratio is one of noises.
        let explained = |k: usize| sums.cross[k].norm_sqr() / sums.force[k].max(f64::MIN_POSITIVE);
        let peak = even.max_by(|a, b| explained(*a).total_cmp(&explained(*b))).unwrap_or(2);
        let change = response[peak - 1] - half.response_at(peak / 2, averaging.estimator);
        Leakage::OfPeak {
            frequency_hz: frequency_hz[peak - 1],
            relative_error: change.norm() / (3.0 * response[peak - 1].norm()),
        }
    } else {
        Leakage::LeftAtEnd(sums.left_at_end())
    };
    let added_damping_hz = match averaging.window {
        SpectralWindow::Exponential => 2.0 * LN_10 * sample_rate_hz / (TAU * segment as f64),
        _ => 0.0,
    };
    Ok(AveragedFrf {
        frequency_hz,
        response,
        coherence: lines.map(|k| sums.coherence(k)).collect(),
        segment,
        segments: sums.segments(),
        averages: sums.averages(segment, averaging),
        leakage,
        added_damping_hz,
    })
}

/// Equal samples in turn at a limit that make it one that something is cut off at.
const FLAT: usize = 3;
/// Steps into such a row of samples above the smallest step of a signal, in multiples of that: one that is rounded
/// coarsely comes to rest at its peaks by single steps.
const ABRUPT: f64 = 10.0;

/// Samples of a signal in rows at its largest or smallest value that begin or end abruptly: a limit cuts it off. Zero
/// of one that is not cut off.
pub fn clipped_samples(samples: &[f64]) -> usize {
    let extreme = |larger: fn(f64, f64) -> f64| samples.iter().copied().fold(f64::NAN, larger);
    let (high, low) = (extreme(f64::max), extreme(f64::min));
    let steps = samples.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|step| *step > 0.0);
    let least = steps.fold(f64::INFINITY, f64::min);
    let mut clipped = 0;
    // The level of rest is no limit.
    for limit in [high, low].into_iter().filter(|x| x.abs() >= 0.5 * high.abs().max(low.abs())) {
        let mut k = 0;
        while k < samples.len() {
            let row = samples[k..].iter().take_while(|x| **x == limit).count();
            let beside = [k.checked_sub(1), Some(k + row)].map(|j| j.and_then(|j| samples.get(j)));
            let abrupt = beside.into_iter().flatten().any(|x| (x - limit).abs() > ABRUPT * least);
            if row >= FLAT && abrupt {
                clipped += row;
            }
            k += row.max(1);
        }
    }
    clipped
}

impl SpectralWindow {
    /// Its value at every sample of a segment.
    fn samples(self, segment: usize) -> Vec<f64> {
        let share = |k: usize| k as f64 / segment as f64;
        let value = |k: usize| match self {
            Self::Hann => (0.5 * TAU * share(k)).sin().powi(2),
            Self::Rectangular => 1.0,
            Self::Exponential => (-2.0 * LN_10 * share(k)).exp(),
        };
        (0..segment).map(value).collect()
    }
}

/// Samples from the start of a segment to that of the next one.
fn step(segment: usize, averaging: &Averaging) -> usize {
    segment - ((segment as f64 * averaging.overlap) as usize).min(segment - 1)
}

/// Sums over the segments.
struct Sums {
    force: Vec<f64>,
    response: Vec<f64>,
    cross: Vec<c64>,
    /// Number of segments of every record.
    segments: Vec<usize>,
    /// Squares of the response in each part of a segment.
    parts: [f64; PARTS],
}

impl Sums {
    fn of(records: &[Excitation<'_>], segment: usize, averaging: &Averaging) -> Self {
        let window = averaging.window.samples(segment);
        let lines = segment / 2 + 1;
        let mut sums = Self {
            force: vec![0.0; lines],
            response: vec![0.0; lines],
            cross: vec![c64::new(0.0, 0.0); lines],
            segments: vec![],
            parts: [0.0; PARTS],
        };
        for record in records {
            let samples = record.force.len().min(record.response.len());
            let starts = (0..=samples.saturating_sub(segment)).step_by(step(segment, averaging));
            let starts = starts.filter(|start| start + segment <= samples);
            sums.segments.push(starts.clone().count());
            for start in starts {
                let cut = |signal: &[f64]| {
                    let own = &signal[start..start + segment];
                    let mean = own.iter().sum::<f64>() / segment as f64;
                    own.iter().zip(&window).map(|(x, w)| (x - mean) * w).collect::<Vec<f64>>()
                };
                sums.add(&cut(record.force), &cut(record.response));
            }
        }
        sums
    }

    fn add(&mut self, force: &[f64], response: &[f64]) {
        let n = force.len();
        // Two real signals in one transform.
        let both: Vec<c64> = force.iter().zip(response).map(|(x, y)| c64::new(*x, *y)).collect();
        let z = fourier(&both);
        for k in 0..self.force.len() {
            let mirror = z[(n - k) % n].conj();
            let (x, y) = (0.5 * (z[k] + mirror), c64::new(0.0, -0.5) * (z[k] - mirror));
            self.force[k] += x.norm_sqr();
            self.response[k] += y.norm_sqr();
            self.cross[k] += x.conj() * y;
        }
        for (k, y) in response.iter().enumerate() {
            self.parts[k * PARTS / n] += y * y;
        }
    }

    fn response_at(&self, line: usize, estimator: Estimator) -> c64 {
        let (x, y, cross) = (self.force[line], self.response[line], self.cross[line]);
        let ratio = |top: c64, bottom: c64| if bottom.norm() > 0.0 { top / bottom } else { c64::new(0.0, 0.0) };
        let real = |x: f64| c64::new(x, 0.0);
        match estimator {
            Estimator::H1 => ratio(cross, real(x)),
            Estimator::H2 => ratio(real(y), cross.conj()),
            Estimator::Hv => ratio(cross, real(cross.norm())) * ratio(real(y.sqrt()), real(x.sqrt())),
        }
    }

    fn coherence(&self, line: usize) -> f64 {
        let both = self.force[line] * self.response[line];
        if both > 0.0 { (self.cross[line].norm_sqr() / both).min(1.0) } else { 0.0 }
    }

    fn left_at_end(&self) -> f64 {
        let strongest = self.parts.iter().copied().fold(0.0, f64::max);
        if strongest > 0.0 { (self.parts[PARTS - 1] / strongest).sqrt() } else { 0.0 }
    }

    fn averages(&self, segment: usize, averaging: &Averaging) -> f64 {
        let window = averaging.window.samples(segment);
        let energy: f64 = window.iter().map(|w| w * w).sum();
        let apart = step(segment, averaging);
        let shared = |k: usize| {
            let overlap = window.iter().zip(&window[k * apart..]).map(|(a, b)| a * b).sum::<f64>();
            (overlap / energy).powi(2)
        };
        let of_record = |segments: &usize| {
            let again = (1..*segments).take_while(|k| k * apart < segment).map(|k| (segments - k) as f64 * shared(k));
            *segments as f64 + 2.0 * again.sum::<f64>()
        };
        let all = self.segments() as f64;
        all * all / self.segments.iter().map(of_record).sum::<f64>()
    }

    fn segments(&self) -> usize {
        self.segments.iter().sum()
    }
}
