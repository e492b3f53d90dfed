//! Antiresonances: with the poles of the resonances divided out an FRF is smooth; its minima are fitted with the poles
//! held fixed (`local`) and the root of the fit is the zero. Between two neighbouring poles with residues of equal sign
//! an odd number of zeros must lie: where none is found, the antiresonance exists but cannot be identified, and that is
//! said. Limits: lightly damped zeros (ζ ≤ 2 %) at least four lines apart from the ends of the band.

use super::channel::{Channel, Resonance};
use super::local::fit;
use super::window::Window;
use crate::linalg::c64;

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

/// Largest damping ratio of a zero that counts as antiresonance.
const MOST_DAMPING: f64 = 0.02;
/// A frequency with a relative standard deviation above this is not identified: readings off a plot are better.
const WORST_RELATIVE_SD: f64 = 0.005;
/// A zero counts when the slope of the FRF at it is this many standard deviations: random roots of noise reach three.
const SLOPE_SEEN: f64 = 6.0;
/// A residue counts as seen from this many standard deviations on.
const SEEN: f64 = 6.0;
/// Degree of the smooth part round a zero.
const ZERO_DEGREE: usize = 3;

/// Antiresonances of one channel, ascending; `index` is its place in the channels that gave the resonances.
pub fn antiresonances(
    frequency_hz: &[f64],
    channel: &Channel,
    index: usize,
    resonances: &[Resonance],
    from_hz: f64,
) -> Vec<Antiresonance> {
    if channel.value.iter().all(|v| v.norm() == 0.0) {
        let reason = format!("{} is zero at every line of the record, or not determined by it", channel.name);
        let (from_hz, to_hz) = (from_hz, frequency_hz.last().copied().unwrap_or(from_hz));
        return vec![Antiresonance::NotIdentified { from_hz, to_hz, reason }];
    }
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
    channel: &Channel,
    poles_hz: &[c64],
    at_hz: f64,
) -> Result<Option<(f64, f64)>, String> {
    let mut widest = None;
    // A narrow window follows the curve best, a wide one averages more noise: take the narrow one if it is good enough.
    for widen in [1.0, 1.6] {
        let Some(window) = Window::round(frequency_hz, at_hz, widen) else {
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
