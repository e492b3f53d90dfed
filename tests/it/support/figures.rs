//! Closed-loop figures of a controller on a machine: tool stiffness and sensitivity of one axis, both whirl
//! directions together.

use super::controller::Law;
use super::rotor::{BEARINGS, Command, PLACES, Rotor};
use super::sampled;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A machine with a controller at a speed.
pub struct Loop<'a> {
    pub rotor: &'a Rotor,
    pub law: &'a Law,
    pub rpm: f64,
    /// Poles, z plane; empty for a law in continuous time.
    pub poles: Vec<c64>,
}

/// Lines of one axis: Hz, |F/x| at the tool, |S| front and rear.
type Line = (f64, f64, [f64; BEARINGS]);

/// What is stated about a controller at one speed.
#[derive(Debug)]
pub struct Figures {
    /// Smallest tool stiffness of the band, N/m, and its frequency, Hz.
    pub minimum: (f64, f64),
    /// Largest sensitivity of the band, front and rear, dB, with its frequency, Hz.
    pub sensitivity_db: [(f64, f64); BEARINGS],
}

/// Lines of the plain grid; half the lines round a pole; lines of a refinement.
const PLAIN: usize = 250;
const SIDE: usize = 5;
const FINER: usize = 9;
const ROUNDS: usize = 4;

impl<'a> Loop<'a> {
    pub fn new(rotor: &'a Rotor, law: &'a Law, rpm: f64) -> Self {
        let poles = if law.sample_time_s > 0.0 { sampled::poles(rotor, law, rpm) } else { vec![] };
        Self { rotor, law, rpm, poles }
    }

    /// Without poles: for lines at given frequencies, not for figures of a band.
    pub fn lines_only(rotor: &'a Rotor, law: &'a Law, rpm: f64) -> Self {
        Self { rotor, law, rpm, poles: vec![] }
    }

    pub fn growth_rate_per_s(&self) -> f64 {
        sampled::growth_rate_per_s(self.rotor, &self.poles)
    }

    fn command(&self) -> Command {
        if self.law.sample_time_s > 0.0 { Command::Held } else { Command::Continuous }
    }

    /// Tool compliance (m/N) and sensitivity of one whirl coordinate at a signed frequency.
    fn whirl(&self, hz: f64) -> (c64, [c64; BEARINGS]) {
        let p = self.rotor.response(hz, self.rpm, 0, self.command());
        let k = self.law.at(hz);
        let part = |r: usize, c: usize, h: usize, w: usize| p.submatrix(r, c, h, w).to_owned();
        let difference = Mat::<c64>::identity(BEARINGS, BEARINGS) - part(PLACES, PLACES, BEARINGS, BEARINGS) * &k;
        let s = difference.partial_piv_lu().solve(Mat::<c64>::identity(BEARINGS, BEARINGS));
        let fed_back = part(0, PLACES, 1, BEARINGS) * &k * &s * part(PLACES, 0, BEARINGS, 1);
        (p[(0, 0)] + fed_back[(0, 0)], [s[(0, 0)], s[(1, 1)]])
    }

    /// One axis: forward whirl and the conjugate of backward whirl, half each.
    pub fn line(&self, hz: f64) -> Line {
        let (x, s) = self.whirl(hz);
        let (back, turned) = if self.rpm == 0.0 { (x.conj(), s.map(|v| v.conj())) } else { self.whirl(-hz) };
        let compliance = 0.5 * (x + back.conj());
        let sensitivity = [0, 1].map(|b| (0.5 * (s[b] + turned[b].conj())).norm());
        (hz, 1.0 / compliance.norm(), sensitivity)
    }

    /// Tool stiffness of one axis at a frequency, N/m.
    pub fn stiffness_n_per_m(&self, hz: f64) -> f64 {
        self.line(hz).1
    }

    /// Frequencies of a band: evenly in its logarithm, and round every lightly damped pole.
    pub fn grid_hz(&self, band_hz: (f64, f64)) -> Vec<f64> {
        let ratio = band_hz.1 / band_hz.0;
        let mut grid: Vec<f64> = (0..PLAIN).map(|k| band_hz.0 * ratio.powf(k as f64 / (PLAIN - 1) as f64)).collect();
        let poles = self.poles.iter().filter(|z| z.norm() > 1e-6);
        for s in poles.map(|z| z.ln() / self.rotor.period_s) {
            let (centre, half) = (s.im.abs() / TAU, s.re.abs() / TAU);
            if half < 0.3 * centre {
                let side = SIDE as f64;
                let offsets = (0..=2 * SIDE).map(|k| (3.0 * (k as f64 - side) / side).sinh());
                grid.extend(offsets.map(|x| centre + half * x));
            }
        }
        grid.retain(|f| (band_hz.0..=band_hz.1).contains(f));
        grid.sort_by(f64::total_cmp);
        grid.dedup();
        grid
    }

    /// Extremes over a band, each refined between the neighbours of its line.
    pub fn figures(&self, band_hz: (f64, f64)) -> Figures {
        let mut lines: Vec<Line> = self.lines(self.grid_hz(band_hz));
        let heights: [fn(&Line) -> f64; 3] = [|l| 1.0 / l.1, |l| l.2[0], |l| l.2[1]];
        let top = |lines: &[Line], height: fn(&Line) -> f64| {
            (0..lines.len()).max_by(|a, b| height(&lines[*a]).total_cmp(&height(&lines[*b]))).expect("a band has lines")
        };
        for _ in 0..ROUNDS {
            let between: Vec<f64> = heights
                .iter()
                .flat_map(|height| {
                    let k = top(&lines, *height);
                    let lo = lines[k.saturating_sub(1)].0;
                    let hi = lines[(k + 1).min(lines.len() - 1)].0;
                    (1..FINER).map(move |i| lo + (hi - lo) * i as f64 / FINER as f64)
                })
                .collect();
            lines.extend(self.lines(between));
            lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let [soft, front, rear] = heights.map(|height| lines[top(&lines, height)]);
        Figures {
            minimum: (soft.1, soft.0),
            sensitivity_db: [(decibel(front.2[0]), front.0), (decibel(rear.2[1]), rear.0)],
        }
    }

    fn lines(&self, grid_hz: Vec<f64>) -> Vec<Line> {
        grid_hz.into_par_iter().map(|hz| self.line(hz)).collect()
    }
}

pub fn decibel(x: f64) -> f64 {
    20.0 * x.log10()
}

/// Zone of ISO 14839-3 of a peak in dB: below 3, 4 and 5.
pub fn zone(db: f64) -> &'static str {
    match 10f64.powf(db / 20.0) {
        p if p < 3.0 => "A",
        p if p < 4.0 => "B",
        p if p < 5.0 => "C",
        _ => "D",
    }
}
