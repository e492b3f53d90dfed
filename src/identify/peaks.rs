//! Resonances and antiresonances of a set of FRFs by local rational fits (`local`), each with a standard
//! deviation.
//!
//! Resonances: local maxima are tried as single poles over all FRFs of a group at once; where one pole leaves a
//! residual well above the noise, two are tried. Antiresonances: with the poles divided out an FRF is smooth; its
//! minima are fitted with the poles held fixed and the root of the fit is the zero. Between two neighbouring poles with
//! residues of equal sign an odd number of zeros must lie: where none is found, the antiresonance exists but cannot be
//! identified, and that is said. Limits: lightly damped peaks (ζ ≤ 2 %) at least four lines apart from the ends of the
//! band.

use super::local::{LocalChannel, LocalData, LocalFit, fit};
use crate::linalg::c64;

/// An FRF to look at.
#[derive(Clone, Debug, PartialEq)]
pub struct PeakChannel {
    /// Name for messages.
    pub name: String,
    /// Values, one a line; known electronics divided out as far as they are known.
    pub value: Vec<c64>,
    /// Standard deviation of the complex values.
    pub sigma: Vec<f64>,
}

/// An identified resonance.
#[derive(Clone, Debug, PartialEq)]
pub struct Resonance {
    /// Undamped natural frequency, Hz.
    pub frequency_hz: f64,
    /// Standard deviation, Hz.
    pub standard_deviation_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Real part of the residue over its standard deviation per channel: sign and visibility.
    pub residue_over_sd: Vec<f64>,
}

impl Resonance {
    /// The pole on the frequency axis, Hz: damped frequency + jζf.
    pub(crate) fn pole_hz(&self) -> c64 {
        let z = self.damping_ratio;
        c64::new(self.frequency_hz * (1.0 - z * z).max(0.0).sqrt(), z * self.frequency_hz)
    }
}

/// An antiresonance, or why there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Antiresonance {
    /// Identified.
    Found {
        /// Undamped frequency, Hz.
        frequency_hz: f64,
        /// Standard deviation, Hz.
        standard_deviation_hz: f64,
    },
    /// Known to exist between two frequencies, but not identifiable.
    NotIdentified {
        /// Lower end of where it must be, Hz.
        from_hz: f64,
        /// Upper end, Hz.
        to_hz: f64,
        /// Why.
        reason: String,
    },
}

impl Antiresonance {
    /// Frequency or the middle of where it must be, Hz: for ordering.
    pub fn place_hz(&self) -> f64 {
        match self {
            Self::Found { frequency_hz, .. } => *frequency_hz,
            Self::NotIdentified { from_hz, to_hz, .. } => (from_hz * to_hz).sqrt(),
        }
    }
}

/// Largest damping ratio of a peak: bending modes of shafts have 0.1–0.8 %, housings and electronics several per cent.
const MOST_DAMPING: f64 = 0.02;
/// Half width of a window relative to its centre, and its least number of lines on either side.
const WINDOW: f64 = 0.07;
const LINES_PER_SIDE: usize = 6;
/// A frequency with a relative standard deviation above this is not identified: readings off a plot are better.
const WORST_RELATIVE_SD: f64 = 0.005;
/// A zero counts when the slope of the FRF at it is this many standard deviations: random roots of noise reach three.
const SLOPE_SEEN: f64 = 6.0;
/// A residue counts as seen from this many standard deviations on.
const SEEN: f64 = 6.0;
/// Two poles replace one when χ² per degree of freedom falls by this factor and one pole left more than this residual.
const SPLIT_GAIN: f64 = 2.0;
const SPLIT_RESIDUAL: f64 = 3.0;
/// Degree of the smooth part round a pole and round a zero.
const POLE_DEGREE: usize = 2;
const ZERO_DEGREE: usize = 3;

struct Window {
    centre_hz: f64,
    half_hz: f64,
    lines: std::ops::Range<usize>,
}

impl Window {
    fn around_peak(frequency_hz: &[f64], at_hz: f64, widen: f64) -> Option<Self> {
        let half = widen * WINDOW * at_hz;
        let lo = frequency_hz.partition_point(|f| *f < at_hz - half);
        let hi = frequency_hz.partition_point(|f| *f <= at_hz + half);
        let at = frequency_hz.partition_point(|f| *f < at_hz);
        let lo = lo.min(at.saturating_sub(LINES_PER_SIDE));
        let hi = hi.max(at + LINES_PER_SIDE).min(frequency_hz.len());
        let (first, last) = (frequency_hz.get(lo)?, frequency_hz.get(hi.checked_sub(1)?)?);
        let half_hz = 0.5 * (last - first);
        (half_hz > 0.0).then(|| Self { centre_hz: 0.5 * (first + last), half_hz, lines: lo..hi })
    }

    fn data(&self, frequency_hz: &[f64], channels: &[&PeakChannel]) -> LocalData {
        let cut = |c: &&PeakChannel| LocalChannel {
            value: c.value[self.lines.clone()].to_vec(),
            sigma: c.sigma[self.lines.clone()].to_vec(),
        };
        LocalData {
            x: frequency_hz[self.lines.clone()].iter().map(|f| (f - self.centre_hz) / self.half_hz).collect(),
            channels: channels.iter().map(cut).collect(),
        }
    }

    fn normalise(&self, hz: c64) -> c64 {
        (hz - c64::new(self.centre_hz, 0.0)) / self.half_hz
    }

    fn hz(&self, x: c64) -> c64 {
        x * self.half_hz + c64::new(self.centre_hz, 0.0)
    }

    /// Known poles that shape the window: those within three half widths.
    fn nearby(&self, poles_hz: &[c64]) -> Vec<c64> {
        poles_hz.iter().map(|p| self.normalise(*p)).filter(|x| x.re.abs() < 3.0).collect()
    }
}

/// Resonances that the channels share, ascending. All channels have the same lines.
pub fn resonances(frequency_hz: &[f64], channels: &[PeakChannel]) -> Vec<Resonance> {
    let all: Vec<&PeakChannel> = channels.iter().collect();
    let mut found: Vec<(Resonance, f64)> = vec![];
    for line in candidates(frequency_hz, channels) {
        for (resonance, score) in try_poles(frequency_hz, &all, frequency_hz[line], &[]) {
            keep(&mut found, resonance, score);
        }
    }
    // Second pass with the other poles held fixed: neighbours no longer lean on the polynomial.
    let poles: Vec<c64> = found.iter().map(|(r, _)| r.pole_hz()).collect();
    let mut refined: Vec<(Resonance, f64)> = vec![];
    for (k, (first, score)) in found.into_iter().enumerate() {
        let others: Vec<c64> = poles.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, p)| *p).collect();
        let again = Window::around_peak(frequency_hz, first.frequency_hz, 1.0).and_then(|w| {
            let fixed = w.nearby(&others);
            let data = w.data(frequency_hz, &all);
            let f = fit(&data, &[w.normalise(first.pole_hz())], &fixed, POLE_DEGREE)?;
            accept_fit(&w, &f, 0, all.len())
        });
        let (r, s) = again.unwrap_or((first, score));
        keep(&mut refined, r, s);
    }
    refined.sort_by(|a, b| a.0.frequency_hz.total_cmp(&b.0.frequency_hz));
    refined.into_iter().map(|(r, _)| r).collect()
}

/// Keeps the better of two finds that are one pole: closer than three times their joint standard deviation or 0.1 %.
fn keep(found: &mut Vec<(Resonance, f64)>, new: Resonance, score: f64) {
    for (old, old_score) in found.iter_mut() {
        let apart = (old.frequency_hz - new.frequency_hz).abs();
        let joint = old.standard_deviation_hz.hypot(new.standard_deviation_hz);
        if apart < (3.0 * joint).max(1e-3 * new.frequency_hz) {
            if score > *old_score {
                (*old, *old_score) = (new, score);
            }
            return;
        }
    }
    found.push((new, score));
}

/// Lines where some channel has a local maximum or a local extremum of curvature that smooth curves do not have.
fn candidates(frequency_hz: &[f64], channels: &[PeakChannel]) -> Vec<usize> {
    let n = frequency_hz.len();
    let mut lines = vec![];
    for k in 2..n.saturating_sub(2) {
        let peaks = channels.iter().any(|c| {
            let size = |i: usize| c.value[i].norm();
            let top = size(k) >= size(k - 1) && size(k) > size(k + 1);
            let rise = 2.0 * size(k) - size(k - 2) - size(k + 2);
            // Second difference of the complex curve, several times what noise makes of it.
            let bend = (2.0 * c.value[k] - c.value[k - 1] - c.value[k + 1]).norm();
            let noise = (4.0 * c.sigma[k].powi(2) + c.sigma[k - 1].powi(2) + c.sigma[k + 1].powi(2)).sqrt();
            let around = (k - 2..=k + 2).map(|i| {
                let j = i.clamp(1, n - 2);
                (2.0 * c.value[j] - c.value[j - 1] - c.value[j + 1]).norm()
            });
            let sharpest = around.fold(0.0, f64::max) <= bend;
            (top && rise > SEEN * noise) || (sharpest && bend > 2.0 * SEEN * noise)
        });
        if peaks {
            lines.push(k);
        }
    }
    lines
}

fn try_poles(frequency_hz: &[f64], channels: &[&PeakChannel], at_hz: f64, fixed_hz: &[c64]) -> Vec<(Resonance, f64)> {
    let Some(window) = Window::around_peak(frequency_hz, at_hz, 1.0) else {
        return vec![];
    };
    let data = window.data(frequency_hz, channels);
    let fixed = window.nearby(fixed_hz);
    let start = |offset: f64| {
        // 0.4 %: the usual damping of a laminated rotor.
        window.normalise(c64::new(at_hz * (1.0 + offset), 0.004 * at_hz))
    };
    let single = fit(&data, &[start(0.0)], &fixed, POLE_DEGREE);
    let residual = single.as_ref().map_or(f64::INFINITY, |f| f.chi_squared);
    if residual > SPLIT_RESIDUAL {
        // One pole is not enough: two close ones, tried at two separations.
        let pair = [0.003, 0.012]
            .iter()
            .filter_map(|d| fit(&data, &[start(-d), start(*d)], &fixed, POLE_DEGREE))
            .min_by(|a, b| a.chi_squared.total_cmp(&b.chi_squared));
        if let Some(pair) = pair
            && pair.chi_squared * SPLIT_GAIN < residual
        {
            let both: Vec<_> = (0..2).filter_map(|k| accept_fit(&window, &pair, k, channels.len())).collect();
            if both.len() == 2 {
                return both;
            }
        }
    }
    single.and_then(|f| accept_fit(&window, &f, 0, channels.len())).into_iter().collect()
}

/// A fitted pole as a resonance when it is one: inside the window, lightly damped, seen in the residues.
fn accept_fit(window: &Window, f: &LocalFit, k: usize, channels: usize) -> Option<(Resonance, f64)> {
    let pole = window.hz(f.poles[k]);
    let frequency = pole.norm();
    let damping = pole.im / frequency;
    let sd = f.pole_sd[k] * window.half_hz;
    let seen: Vec<f64> =
        (0..channels).map(|c| f.residue(c, k).norm() / f.residue_sd(c, k).max(f64::MIN_POSITIVE)).collect();
    let strongest = seen.iter().copied().fold(0.0, f64::max);
    // A damping ratio of zero within its standard deviation is possible, a negative one beyond it is not a mode.
    let light = damping < MOST_DAMPING && damping > -3.0 * sd / frequency - 1e-5;
    let inside = f.poles[k].re.abs() < 0.8;
    if !(light && inside && strongest > SEEN && sd < WORST_RELATIVE_SD * frequency) {
        return None;
    }
    // Near the pole 1/(f_k² − f²) = −1/((f − f_k)·2f_k): a positive modal product has a negative residue in f.
    let residue_over_sd = (0..channels).map(|c| -f.residue(c, k).re.signum() * seen[c]).collect();
    let resonance = Resonance {
        frequency_hz: frequency,
        standard_deviation_hz: sd,
        damping_ratio: damping.max(0.0),
        residue_over_sd,
    };
    Some((resonance, strongest))
}

/// Antiresonances of one channel, ascending; `index` is its place in the channels that gave the resonances.
pub fn antiresonances(
    frequency_hz: &[f64],
    channel: &PeakChannel,
    index: usize,
    resonances: &[Resonance],
    from_hz: f64,
) -> Vec<Antiresonance> {
    let poles: Vec<c64> = resonances.iter().map(Resonance::pole_hz).collect();
    // Π (f² − p²)/f² over the poles, so that only zeros are left to see.
    let smooth: Vec<c64> = frequency_hz
        .iter()
        .zip(&channel.value)
        .map(|(f, g)| {
            poles.iter().fold(*g, |g, p| {
                let f = c64::new(*f, 0.0);
                g * (f - p) * (f + p.conj()) / p.norm_sqr()
            }) * f.powi(2)
        })
        .collect();
    let mut found: Vec<(f64, f64)> = vec![];
    let mut lost: Vec<(f64, String)> = vec![];
    for k in 1..frequency_hz.len().saturating_sub(1) {
        let size = |i: usize| smooth[i].norm();
        if frequency_hz[k] < from_hz || size(k) > size(k - 1) || size(k) >= size(k + 1) {
            continue;
        }
        match zero_near(frequency_hz, channel, &poles, frequency_hz[k]) {
            Ok(Some((f, sd))) if f >= from_hz => {
                if !found.iter().any(|(g, s)| (g - f).abs() < (3.0 * s.hypot(sd)).max(1e-3 * f)) {
                    found.push((f, sd));
                }
            }
            Ok(_) => {}
            Err(reason) => lost.push((frequency_hz[k], reason)),
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut list: Vec<Antiresonance> =
        found.iter().map(|(f, sd)| Antiresonance::Found { frequency_hz: *f, standard_deviation_hz: *sd }).collect();
    for pair in resonances.windows(2) {
        let sign = |r: &Resonance| r.residue_over_sd.get(index).copied().unwrap_or(0.0);
        let (a, b) = (sign(&pair[0]), sign(&pair[1]));
        let (lo, hi) = (pair[0].frequency_hz, pair[1].frequency_hz);
        let between = found.iter().filter(|(f, _)| *f > lo && *f < hi).count();
        let must = a * b > 0.0 && a.abs() > SEEN && b.abs() > SEEN;
        if must && between % 2 == 0 {
            let hint = lost.iter().find(|(f, _)| *f > lo && *f < hi);
            let reason = match hint {
                Some((f, why)) => format!("near {f:.0} Hz {why}"),
                None => "no minimum between the two resonances, whose residues have equal sign: too shallow, or too \
                    close to one of them"
                    .to_owned(),
            };
            list.push(Antiresonance::NotIdentified { from_hz: lo, to_hz: hi, reason });
        }
    }
    list.sort_by(|a, b| a.place_hz().total_cmp(&b.place_hz()));
    list
}

/// Zero next to a line: Ok(None) when the minimum is no lightly damped zero, Err with the reason when it cannot be
/// told.
fn zero_near(
    frequency_hz: &[f64],
    channel: &PeakChannel,
    poles_hz: &[c64],
    at_hz: f64,
) -> Result<Option<(f64, f64)>, String> {
    let mut widest = None;
    // A narrow window follows the curve best, a wide one averages more noise: take the narrow one if it is good enough.
    for widen in [1.0, 1.6] {
        let Some(window) = Window::around_peak(frequency_hz, at_hz, widen) else {
            continue;
        };
        let data = window.data(frequency_hz, &[channel]);
        let fixed = window.nearby(poles_hz);
        let Some(f) = fit(&data, &[], &fixed, ZERO_DEGREE) else {
            continue;
        };
        let Some(root) = f.root(0, window.normalise(c64::new(at_hz, 0.0))) else {
            continue;
        };
        let zero = window.hz(root.x);
        let (frequency, mut sd) = (zero.norm(), root.sd * window.half_hz);
        if root.x.re.abs() > 0.9 {
            continue;
        }
        if root.slope_over_sd < SLOPE_SEEN {
            // Without a slope there is no saying where the curve crosses: anywhere in the window.
            sd = sd.max(window.half_hz);
        }
        if zero.im.abs() > MOST_DAMPING * frequency + 3.0 * sd {
            return Ok(None);
        }
        if sd < 0.2 * WORST_RELATIVE_SD * frequency {
            return Ok(Some((frequency, sd)));
        }
        if widest.is_none_or(|(_, s)| sd < s) {
            widest = Some((frequency, sd));
        }
    }
    match widest {
        Some((f, sd)) if sd < WORST_RELATIVE_SD * f => Ok(Some((f, sd))),
        Some((f, sd)) => Err(format!("the noise leaves a standard deviation of {:.1} % of {f:.0} Hz", 100.0 * sd / f)),
        None => Err("a minimum is there, but no rational fit with a zero in the window".to_owned()),
    }
}
