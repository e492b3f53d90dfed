//! Faults taken out of records: the Fourier coefficients of a sweep, the compliance of a hammer test.

use super::faults::{RecordFault, Signal};
use crate::identify::{HammerFrf, SweepRecord};
use crate::linalg::c64;
use ndarray::{Array4, Axis};
use std::f64::consts::TAU;

impl RecordFault {
    /// The sweep without this fault; one that concerns other records, or that nothing undoes, leaves it as it is.
    #[must_use]
    pub fn corrected_sweep(&self, record: &SweepRecord) -> SweepRecord {
        let mut right = record.clone();
        match *self {
            Self::ChannelsSwapped { a, b, signal } => exchange(of(&mut right, signal), a, b),
            Self::PlanesSwapped { signal } => {
                exchange(of(&mut right, signal), 0, 2);
                exchange(of(&mut right, signal), 1, 3);
            }
            Self::Sign { channel, signal } => scale(of(&mut right, signal), channel, -1.0),
            Self::Unit { signal, decades, channel } => scale(of(&mut right, signal), channel, 10f64.powi(-decades)),
            Self::Conjugate => {
                right.current.mapv_inplace(|u| u.conj());
                right.signal.mapv_inplace(|y| y.conj());
            }
            Self::Clock { factor } => right.frequency_hz.iter_mut().for_each(|f| *f /= factor),
            Self::SpeedLabel { speed_rpm } => right.speed_rpm = speed_rpm,
            Self::Drift { signal, relative_change } => {
                let last = record.frequency_hz.len().max(2) - 1;
                for (k, mut line) in of(&mut right, signal).outer_iter_mut().enumerate() {
                    let factor = 1.0 + relative_change * k as f64 / last as f64;
                    line.mapv_inplace(|v| v / factor);
                }
            }
            Self::Clipping { limit, signal } => {
                let lines: Vec<usize> =
                    (0..record.frequency_hz.len()).filter(|k| largest(record, signal, *k) < limit).collect();
                right = record.with_lines(&lines);
            }
            Self::Alias { sample_rate_hz } => {
                for (k, f) in right.frequency_hz.iter_mut().enumerate() {
                    if *f > 0.5 * sample_rate_hz {
                        *f = sample_rate_hz - *f;
                        for values in [&mut right.current, &mut right.signal] {
                            let mut line = values.index_axis_mut(Axis(0), k);
                            line.mapv_inplace(|v| v.conj());
                        }
                    }
                }
                right = ascending(&right);
            }
            Self::HammerCalibration { .. } | Self::HammerDelay { .. } | Self::HammerMass { .. } => {}
            Self::Tool | Self::Controller | Self::Quantity(_) | Self::Disagrees => {}
        }
        right
    }

    /// The hammer test without this fault; one that concerns other records, or that nothing undoes, leaves it as it is.
    #[must_use]
    pub(crate) fn corrected_hammer(&self, frf: &HammerFrf) -> HammerFrf {
        let mut right = frf.clone();
        let by = |factor: f64, right: &mut HammerFrf| {
            right.compliance.iter_mut().for_each(|h| *h *= factor);
        };
        match *self {
            Self::Sign { .. } => by(-1.0, &mut right),
            Self::Unit { decades, .. } => by(10f64.powi(-decades), &mut right),
            Self::Conjugate => right.compliance.iter_mut().for_each(|h| *h = h.conj()),
            Self::Clock { factor } => right.frequency_hz.iter_mut().for_each(|f| *f /= factor),
            Self::SpeedLabel { speed_rpm } => right.speed_rpm = speed_rpm,
            Self::Quantity(quantity) => {
                for (h, f) in right.compliance.iter_mut().zip(&frf.frequency_hz) {
                    let s = c64::new(0.0, TAU * f);
                    *h /= (0..quantity.order()).fold(c64::new(1.0, 0.0), |p, _| p * s);
                }
            }
            _ => {
                for (h, hz) in right.compliance.iter_mut().zip(&frf.frequency_hz) {
                    *h = self.true_compliance(*h, TAU * hz).map_or(*h, |(h, _)| h);
                }
            }
        }
        right
    }

    /// A compliance, m/N, at an angular frequency, rad/s, without a fault of the hammer test that changes all of its
    /// lines, and the factor on its standard deviation; none for other faults.
    pub(crate) fn true_compliance(&self, measured: c64, omega_rad_s: f64) -> Option<(c64, f64)> {
        match *self {
            Self::HammerCalibration { factor } => Some((measured / factor, factor.recip().abs())),
            Self::HammerDelay { delay_s } => Some((measured * c64::from_polar(1.0, omega_rad_s * delay_s), 1.0)),
            // x = h (f + mω² x).
            Self::HammerMass { mass_kg } => {
                let loaded = measured * (mass_kg * omega_rad_s * omega_rad_s) + 1.0;
                Some((measured / loaded, loaded.norm_sqr().recip()))
            }
            _ => None,
        }
    }
}

/// Largest magnitude of a signal at a line, over axes, experiments and repeats.
pub(crate) fn largest(record: &SweepRecord, signal: Signal, line: usize) -> f64 {
    let values = match signal {
        Signal::Current => &record.current,
        _ => &record.signal,
    };
    let line = values.index_axis(Axis(0), line);
    line.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// Lines in ascending order, each frequency above zero once.
fn ascending(record: &SweepRecord) -> SweepRecord {
    let hz = &record.frequency_hz;
    let mut lines: Vec<usize> = (0..hz.len()).filter(|k| hz[*k] > 0.0).collect();
    lines.sort_by(|a, b| hz[*a].total_cmp(&hz[*b]));
    lines.dedup_by(|a, b| hz[*a] == hz[*b]);
    record.with_lines(&lines)
}

fn of(record: &mut SweepRecord, signal: Signal) -> &mut Array4<c64> {
    match signal {
        Signal::Current => &mut record.current,
        _ => &mut record.signal,
    }
}

fn exchange(values: &mut Array4<c64>, a: usize, b: usize) {
    let first = values.index_axis(Axis(3), a).to_owned();
    let second = values.index_axis(Axis(3), b).to_owned();
    values.index_axis_mut(Axis(3), a).assign(&second);
    values.index_axis_mut(Axis(3), b).assign(&first);
}

fn scale(values: &mut Array4<c64>, channel: Option<usize>, by: f64) {
    match channel {
        Some(k) => values.index_axis_mut(Axis(3), k).mapv_inplace(|v| v * by),
        None => values.mapv_inplace(|v| v * by),
    }
}
