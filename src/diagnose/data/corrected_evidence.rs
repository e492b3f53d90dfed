//! Evidence of fewer lines, and of records without a fault that acts on whitened records directly.
//!
//! What a clock, a calibration, a drift, another speed or another controller changes follows from the evidence itself:
//! noise and response are scaled alike. A fit of such a number need not read the records again.

use super::common_error::Known;
use super::evidence::{Evidence, SweepEvidence, TapEvidence, held};
use super::measurement::RecordId;
use crate::identify::plausibility::{RecordFault, Signal};
use crate::linalg::c64;
use crate::lti::HeldResponse;
use std::f64::consts::TAU;

fn some<T: Clone>(all: &[T], lines: &[usize]) -> Vec<T> {
    lines.iter().map(|k| all[*k].clone()).collect()
}

impl Evidence {
    /// Every n-th line of all records; noise and magnitudes stay averaged over all lines.
    #[must_use]
    pub fn thin_lines(&self, stride: usize) -> Self {
        let of = |lines: usize| (0..lines).step_by(stride.max(1)).collect::<Vec<_>>();
        let sweeps = self.sweeps.iter();
        let taps = self.taps.iter();
        Self {
            sweeps: sweeps.map(|s| s.thinned_to(&of(s.omega_rad_s.len()))).collect(),
            taps: taps.map(|t| t.thinned_to(&of(t.omega_rad_s.len()))).collect(),
            smooth: Known::default(),
        }
    }

    /// Most lines of a record.
    pub fn lines(&self) -> usize {
        let sweeps = self.sweeps.iter().map(|s| s.omega_rad_s.len());
        let taps = self.taps.iter().map(|t| t.omega_rad_s.len());
        sweeps.chain(taps).max().unwrap_or_default()
    }

    /// With those lines of a sweep that are wanted, counted as in its record of so many lines.
    #[must_use]
    pub(crate) fn with_lines(&self, sweep: usize, count: usize, wanted: impl Fn(usize) -> bool) -> Self {
        let mut right = self.clone();
        right.smooth = Known::default();
        if let Some(own) = right.sweeps.get_mut(sweep) {
            let line = |k: usize| (own.position[k] * (count.max(2) - 1) as f64).round() as usize;
            let all = 0..own.omega_rad_s.len();
            let lines: Vec<usize> = all.filter(|k| wanted(line(*k))).collect();
            *own = own.thinned_to(&lines);
        }
        right
    }

    /// A record alone, and all others; the records that are not there are without lines, so that they keep their
    /// numbers.
    pub fn apart(&self, record: RecordId) -> (Self, Self) {
        let (mut own, mut rest) = (self.clone(), self.clone());
        own.smooth = Known::default();
        rest.smooth = Known::default();
        for (s, sweep) in self.sweeps.iter().enumerate() {
            let gone = if record == RecordId::Sweep(s) { &mut rest } else { &mut own };
            gone.sweeps[s] = sweep.thinned_to(&[]);
        }
        for (t, tap) in self.taps.iter().enumerate() {
            let gone = if record == RecordId::Hammer(t) { &mut rest } else { &mut own };
            gone.taps[t] = tap.thinned_to(&[]);
        }
        (own, rest)
    }

    /// Without a fault of one record. Only those that scale responses, frequencies or the speed are taken out; the
    /// controller of a hammer test is needed where frequencies change.
    #[must_use]
    pub fn correct_record(&self, record: RecordId, fault: RecordFault, controller: Option<&dyn HeldResponse>) -> Self {
        let mut right = self.clone();
        // The order of the lines, on which smooth errors that were made depend, may change.
        right.smooth = Known::default();
        match record {
            RecordId::Sweep(s) => {
                if let Some(sweep) = right.sweeps.get_mut(s) {
                    sweep.correct(fault);
                }
            }
            RecordId::Hammer(t) => {
                if let Some(tap) = right.taps.get_mut(t) {
                    tap.correct(fault, controller);
                }
            }
        }
        right
    }
}

impl SweepEvidence {
    fn thinned_to(&self, lines: &[usize]) -> Self {
        Self {
            speed_rad_s: self.speed_rad_s,
            omega_rad_s: some(&self.omega_rad_s, lines),
            response: some(&self.response, lines),
            spread: some(&self.spread, lines),
            common: some(&self.common, lines),
            shares: self.shares,
            noise: some(&self.noise, lines),
            size: some(&self.size, lines),
            gap_sigma: some(&self.gap_sigma, lines),
            position: some(&self.position, lines),
            axis_gain_sd: self.axis_gain_sd,
        }
    }

    fn correct(&mut self, fault: RecordFault) {
        match fault {
            RecordFault::Clock { factor } => {
                self.omega_rad_s.iter_mut().for_each(|w| *w /= factor);
            }
            RecordFault::SpeedLabel { speed_rpm } => self.speed_rad_s = speed_rpm * TAU / 60.0,
            RecordFault::Alias { sample_rate_hz } => {
                for k in 0..self.omega_rad_s.len() {
                    let omega = &mut self.omega_rad_s[k];
                    if *omega > 0.5 * TAU * sample_rate_hz {
                        *omega = TAU * sample_rate_hz - *omega;
                        let conjugate = |all: &mut [c64; 16]| *all = all.map(|v| v.conj());
                        conjugate(&mut self.response[k]);
                        conjugate(&mut self.spread[k]);
                        conjugate(&mut self.common[k]);
                    }
                }
            }
            RecordFault::Drift { signal, relative_change } => {
                for k in 0..self.omega_rad_s.len() {
                    let read = 1.0 + relative_change * self.position[k];
                    // What is read too large in a sensor makes the response too large, in a current too small.
                    let factor = match signal {
                        Signal::Current => read,
                        _ => read.recip(),
                    };
                    let square = factor * factor;
                    self.response[k].iter_mut().for_each(|g| *g *= factor);
                    self.noise[k].iter_mut().for_each(|s| *s *= square);
                    self.size[k].iter_mut().for_each(|s| *s *= square);
                    self.gap_sigma[k].iter_mut().for_each(|s| *s *= factor);
                }
            }
            _ => {}
        }
    }
}

impl TapEvidence {
    fn thinned_to(&self, lines: &[usize]) -> Self {
        Self {
            speed_rad_s: self.speed_rad_s,
            omega_rad_s: some(&self.omega_rad_s, lines),
            compliance: some(&self.compliance, lines),
            noise: some(&self.noise, lines),
            size: some(&self.size, lines),
            gap_sigma: some(&self.gap_sigma, lines),
            controller: some(&self.controller, lines),
            axis: self.axis,
        }
    }

    fn correct(&mut self, fault: RecordFault, controller: Option<&dyn HeldResponse>) {
        match fault {
            RecordFault::Clock { factor } => {
                self.omega_rad_s.iter_mut().for_each(|w| *w /= factor);
                if let Some(controller) = controller {
                    self.controller = held(controller, &self.omega_rad_s);
                }
            }
            RecordFault::Controller => {
                if let Some(controller) = controller {
                    self.controller = held(controller, &self.omega_rad_s);
                }
            }
            RecordFault::SpeedLabel { speed_rpm } => self.speed_rad_s = speed_rpm * TAU / 60.0,
            _ => {
                for k in 0..self.compliance.len() {
                    if let Some((own, by)) = fault.true_compliance(self.compliance[k], self.omega_rad_s[k]) {
                        self.compliance[k] = own;
                        self.noise[k] *= by * by;
                        self.size[k] *= by * by;
                        self.gap_sigma[k] *= by;
                    }
                }
            }
        }
    }
}
