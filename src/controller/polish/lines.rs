//! Lines of a polish: dense enough for every peak that the loop can have between rest and top speed.

use super::responses::Plants;
use super::structure::LoopLine;
use crate::linalg::c64;
use crate::lti::response::even_in_logarithm;
use std::f64::consts::{PI, TAU};

/// Last line as a share of the Nyquist frequency.
const LAST: f64 = 0.9995;
/// Lines at a lightly damped pole, in half-power half-widths from its frequency.
const FLANKS: [f64; 5] = [-1.6, -0.6, 0.0, 0.6, 1.6];
/// Poles damped more than this are seen by the plain steps.
const LIGHTLY: f64 = 0.1;
/// Lines below the first plain one, as shares of its frequency.
const QUASI_STATIC: [f64; 4] = [1e-3, 0.03, 0.1, 0.3];
/// Two lines of one pole closer than this share of its half-width show the same.
const SAME: f64 = 0.25;

/// `from_hz` to Nyquist, packed round the plant's modes and the poles of the loop, those closer than a share of their
/// frequency once.
pub(crate) fn lines(plants: &Plants, from_hz: f64, poles_rad_s: &[c64], apart: f64) -> Vec<LoopLine> {
    let period_s = plants.period_s();
    let last = LAST * PI / period_s;
    let steps = |from: f64, to: f64, ratio: f64| {
        let count = ((to / from).ln() / ratio).ceil().max(2.0) as usize;
        even_in_logarithm(from, to, count + 1)
    };
    let knee = (TAU * 20.0).min(0.25 * last);
    let mut omega: Vec<f64> =
        steps((TAU * from_hz).min(0.5 * knee), knee, 0.12).chain(steps(knee, last, 0.025)).collect();
    let flexible = plants.at_rest().flexible_rad_s();
    for mode in flexible {
        omega.extend((-4..=4).map(|k| mode * (1.0 + 0.01 * f64::from(k))));
    }
    for pole in poles_rad_s {
        let (centre, width) = (pole.im.abs(), pole.re.abs());
        if width < LIGHTLY * centre {
            omega.extend(FLANKS.map(|k| centre + width * k));
        }
    }
    omega.retain(|w| *w > 0.0 && *w <= last);
    omega.sort_by(f64::total_cmp);
    omega.dedup_by(|b, a| *b < *a * (1.0 + apart));
    omega.into_iter().map(|w| LoopLine::new(w, period_s)).collect()
}

/// The plain lines of [`lines`] with lines at every lightly damped pole of plant and loop, however sharp, and round the
/// frequencies `peaks_rad_s` where a peak was found, by a share of the half-width of the nearest pole.
pub(crate) fn sharp_lines(
    plants: &Plants,
    from_hz: f64,
    poles_rad_s: &[c64],
    peaks_rad_s: &[f64],
    apart: f64,
) -> Vec<LoopLine> {
    let period_s = plants.period_s();
    let last = LAST * PI / period_s;
    // Frequency, and the distance within which another line shows the same.
    let mut sharp: Vec<(f64, f64)> = vec![];
    for pole in poles_rad_s {
        let (centre, width) = (pole.im.abs(), pole.re.abs());
        if width < LIGHTLY * centre {
            sharp.extend(FLANKS.map(|k| (centre + width * k, SAME * width)));
        }
    }
    for peak in peaks_rad_s {
        let nearest = poles_rad_s.iter().min_by(|a, b| (a.im - peak).abs().total_cmp(&(b.im - peak).abs()));
        let width = nearest.map_or(apart * peak, |p| p.re.abs().min(0.1 * peak));
        sharp.extend(FLANKS.map(|k| (peak + SAME * width * k, 0.0)));
    }
    sharp.retain(|(w, _)| *w > 0.0 && *w <= last);
    // The sharpest first: a wider pole beside it needs no line of its own there.
    sharp.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.total_cmp(&b.0)));
    // Ascending.
    let mut omega: Vec<f64> = vec![];
    for (w, same) in sharp {
        let above = omega.partition_point(|o| *o < w);
        let neighbours = &omega[above.saturating_sub(1)..omega.len().min(above + 1)];
        if neighbours.iter().all(|o| (o - w).abs() > same) {
            omega.insert(above, w);
        }
    }
    // Without integrators the loads at rest bind below every bearing's bandwidth: a few lines down to there.
    omega.extend(QUASI_STATIC.map(|share| TAU * from_hz * share));
    omega.extend(lines(plants, from_hz, &[], apart).iter().map(|l| l.omega_rad_s));
    ascending(omega, period_s)
}

/// Lines at some frequencies, each once.
fn ascending(mut omega_rad_s: Vec<f64>, period_s: f64) -> Vec<LoopLine> {
    omega_rad_s.sort_by(f64::total_cmp);
    omega_rad_s.dedup();
    let lines = omega_rad_s.into_iter();
    lines.map(|w| LoopLine::new(w, period_s)).collect()
}

/// Frequencies half way to both neighbours of each line at which a value is at least `floor` and a local maximum,
/// rad/s. Between two lines that are 0.6 half-widths of a resonance apart its peak can be 4 % higher than on them,
/// where they are 0.3 half-widths apart 1 %.
pub(super) fn beside_peaks(lines: &[LoopLine], value: impl Fn(usize) -> f64, floor: f64) -> Vec<f64> {
    let at = |k: usize| lines[k].omega_rad_s;
    let is_peak = |k: &usize| value(*k) >= floor && value(*k) >= value(*k - 1) && value(*k) >= value(*k + 1);
    (1..lines.len().saturating_sub(1))
        .filter(is_peak)
        .flat_map(|k| [0.5 * (at(k - 1) + at(k)), 0.5 * (at(k) + at(k + 1))])
        .collect()
}

pub(super) fn with_further(lines: &[LoopLine], omega_rad_s: &[f64], period_s: f64) -> Vec<LoopLine> {
    let own = lines.iter().map(|l| l.omega_rad_s);
    ascending(own.chain(omega_rad_s.iter().copied()).collect(), period_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_between_two_lines_gets_lines_on_both_sides() {
        let lines: Vec<LoopLine> = (1..=6).map(|k| LoopLine::new(f64::from(k), 1e-4)).collect();
        let values = [0.9, 0.2, 0.95, 0.94, 0.1, 0.5];
        let found = beside_peaks(&lines, |k| values[k], 0.9);
        assert_eq!(found, [2.5, 3.5]);
        let more: Vec<f64> = with_further(&lines, &found, 1e-4).iter().map(|l| l.omega_rad_s).collect();
        assert_eq!(more, [1.0, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0]);
    }

    #[test]
    fn lines_half_way_to_the_neighbours_leave_one_percent_of_a_resonance_unseen() {
        // A resonance at 100 rad/s with a half-width of 1, between two lines 0.6 half-widths apart.
        let magnitude = |w: f64| 1.0 / (w - 100.0).hypot(1.0);
        let lines: Vec<LoopLine> = [98.5, 99.1, 99.7, 100.3, 100.9, 101.5].map(|w| LoopLine::new(w, 1e-4)).to_vec();
        let largest = |lines: &[LoopLine]| {
            let values = lines.iter().map(|l| magnitude(l.omega_rad_s));
            values.fold(0.0, f64::max)
        };
        assert!((1.0 / largest(&lines) - 1.044).abs() < 1e-3);
        let found = beside_peaks(&lines, |k| magnitude(lines[k].omega_rad_s), 0.5);
        assert!(largest(&with_further(&lines, &found, 1e-4)) > 0.999);
        // At worst the peak is half way between a line and one of those.
        assert!((1.0 / magnitude(100.15) - 1.011).abs() < 1e-3);
    }
}
