//! Which candidates of the stabilisation diagram are modes, and their maximum-likelihood poles.
//!
//! Candidates enter one after the other, the one first that takes most of the misfit away; each is fitted in its own
//! window together with the modes that lie in it (`local`), those beside it held. Where one pole leaves a misfit well
//! above the noise, two are tried. At last every mode must stand in the presence of all others, or the weakest of those
//! that do not is dropped. A pole is a mode when
//! - its gain, Σ |r|²/σ² over the channels, exceeds what noise reaches at the best of all lines and dampings,
//! - half of that is left without the line that tells most of it: a disturbed line is no mode,
//! - damping and standard deviation are those of a mode,
//! - it does not share shape and place with a stronger one, nor place where each channel alone has one pole there:
//!   peaks of a record whose poles drift are no Lorentzians.
//!
//! Where the misfit stays far above the noise, the record is no sum of modes: its poles drift within an entry, or the
//! structure moves otherwise. What is left is then no noise that an average over lines takes away, and gains tell
//! nothing. A pole must then be a fair share of the response at its own frequency, and two poles within a half
//! bandwidth are one that drifts. Limit: an image of a mode that is a clean resonance itself is taken for one.

use super::channel::Channel;
use super::local::{LocalData, LocalFit, STEPS, fit, fit_in_steps};
use super::stabilisation::PoleCluster;
use super::window::Window;
use crate::linalg::c64;
use rayon::prelude::*;

/// Largest damping ratio of a mode.
const MOST_DAMPING: f64 = 0.08;
/// Probability that noise alone makes a mode of a record.
const FALSE_ALARM: f64 = 1e-3;
/// The noise is believed to be a tenth of what the record says at least: less is what a record does not repeat of
/// itself.
const LEAST_CHI_SQUARED: f64 = 1e-2;
/// A pole is identified where the standard deviation of its frequency is below this part of the frequency, which is
/// what a reading off a plot has, or below this part of its half bandwidth, which tells the damping to about a fifth.
const WORST_RELATIVE_SD: f64 = 0.005;
const WORST_SD_OF_BANDWIDTH: f64 = 0.2;
/// Degree of the smooth part round a pole: in a window of a quarter of the frequency, what degree two leaves of the
/// modes beside it is many standard deviations.
const DEGREE: usize = 4;
/// Most poles beside a window that are fitted along: with more their responses and the polynomial depend on each other
/// to the last digit, and the fit is lost.
const MOST_BESIDE: usize = 6;
/// Two poles replace one when it leaves this χ² per degree of freedom and they bring it down by this factor.
const SPLIT_RESIDUAL: f64 = 2.0;
const SPLIT_GAIN: f64 = 0.7;
/// Poles of one shape (by their modal assurance) are one within this part of the larger half bandwidth.
const SAME_SHAPE: f64 = 0.9;
const SAME_PLACE: f64 = 0.75;
/// Steps of a fit in a round in which poles may yet be dropped: the next round goes on where it ended.
const STEPS_OF_ROUND: usize = 6;
/// Rounds in which no pole was dropped and some still move: three are usual.
const MOST_SETTLING_ROUNDS: usize = 5;

/// A misfit of this many times the variance of the noise, three standard deviations, is none of noise: the record is no
/// sum of modes there.
const UNEXPLAINED: f64 = 9.0;
/// A mode of such a record makes at least this part of the response at the line where it is strongest; a side peak of a
/// mode that drifts makes several hundredths. Set with one measured record in view, a beam
/// that warmed while it was hit, whose side peaks reached 0.10: what this limit gives on that beam confirms nothing.
const LEAST_SHARE: f64 = 0.2;

/// A mode as fitted in its window.
#[derive(Clone, Debug)]
pub(super) struct FittedMode {
    /// Pole on the frequency axis, Hz: damped frequency + jζf.
    pub(super) pole_hz: c64,
    /// Standard deviation of its real and of its imaginary part, Hz.
    pub(super) sd_hz: f64,
    /// Residue and its standard deviation per channel, in half windows.
    pub(super) residues: Vec<(c64, f64)>,
    gain: f64,
    gain_without_line: f64,
    chi_squared: f64,
    /// Part of the response of all channels, root of sums of squares, at the line where the mode is strongest.
    share: f64,
    pub(super) half_hz: f64,
    /// Modes fitted along with it: number among the others, pole.
    beside: Vec<(usize, c64)>,
    /// One of these is the same mode.
    is_double: bool,
}

fn without(poles: &[c64], k: usize) -> Vec<c64> {
    [&poles[..k], &poles[k + 1..]].concat()
}

/// The channels of a record and what noise makes of them.
pub(super) struct Survey<'a> {
    frequency_hz: &'a [f64],
    channels: Vec<&'a Channel>,
    /// Least gain of a mode.
    least_gain: f64,
}

impl<'a> Survey<'a> {
    /// All `channels` must have values other than zero.
    pub(super) fn of(frequency_hz: &'a [f64], channels: Vec<&'a Channel>) -> Self {
        // Bound of the χ² of 2·channels degrees of freedom at a trial per line (Laurent and Massart 2000, lemma 1).
        let freedom = 2.0 * channels.len() as f64;
        let trials = (frequency_hz.len() as f64 / FALSE_ALARM).ln();
        let least_gain = 0.5 * (freedom + 2.0 * (freedom * trials).sqrt() + 2.0 * trials);
        Self { frequency_hz, channels, least_gain }
    }

    /// Modes, ascending.
    pub(super) fn modes(&self, candidates: &[PoleCluster]) -> Vec<FittedMode> {
        let mut poles = vec![];
        // What hid behind a mode that is fitted by now gets a second chance.
        for _ in 0..2 {
            self.add_modes(candidates, &mut poles);
            self.split_modes(&mut poles);
            self.drop_modes(&mut poles);
        }
        let mut modes: Vec<FittedMode> = (0..poles.len()).filter_map(|k| self.mode_of(&poles, k, STEPS)).collect();
        modes.retain(|m| self.accepts(m));
        modes.sort_by(|a, b| a.pole_hz.re.total_cmp(&b.pole_hz.re));
        modes
    }

    fn add_modes(&self, candidates: &[PoleCluster], poles: &mut Vec<c64>) {
        let known = |p: c64| poles.iter().any(|q| (p - q).norm() < 0.2 * q.im.abs());
        let new = candidates.iter().map(|c| c.pole_hz).filter(|p| !known(*p));
        let mut pool: Vec<(c64, f64)> = new.map(|p| (p, self.gain_of(p, poles))).collect();
        while let Some(best) = (0..pool.len()).max_by(|i, j| pool[*i].1.total_cmp(&pool[*j].1)) {
            let (start, gain) = pool.swap_remove(best);
            // The fit finds a better place: somewhat less is worth a trial.
            if gain < 0.7 * self.least_gain {
                break;
            }
            let Some(mode) = self.fit_mode(start, poles, STEPS).filter(|m| self.accepts(m)) else {
                continue;
            };
            for (k, pole) in &mode.beside {
                poles[*k] = *pole;
            }
            poles.push(mode.pole_hz);
            let touched = |p: c64| (p.re - mode.pole_hz.re).abs() < 3.0 * mode.half_hz;
            for (pole, gain) in pool.iter_mut().filter(|(p, _)| touched(*p)) {
                *gain = self.gain_of(*pole, poles);
            }
        }
    }

    /// Two poles for one where the misfit asks for it.
    fn split_modes(&self, poles: &mut Vec<c64>) {
        for pole in poles.clone() {
            let others: Vec<c64> = poles.iter().filter(|p| **p != pole).copied().collect();
            let Some(single) = self.fit_mode(pole, &others, STEPS).filter(|m| m.chi_squared > SPLIT_RESIDUAL) else {
                continue;
            };
            let pair = |part: f64| {
                let apart = c64::new(part * pole.im.abs(), 0.0);
                let with: Vec<c64> = others.iter().copied().chain([pole + apart]).collect();
                self.fit_mode(pole - apart, &with, STEPS)
            };
            // Poles half a bandwidth and more apart; closer ones drift into place.
            let pairs = [0.5, 1.5].into_iter().filter_map(pair);
            let best = pairs.min_by(|a, b| a.chi_squared.total_cmp(&b.chi_squared));
            let Some(best) = best.filter(|m| m.chi_squared < SPLIT_GAIN * single.chi_squared) else {
                continue;
            };
            let Some((_, second)) = best.beside.iter().find(|(k, _)| *k == others.len()) else {
                continue;
            };
            let mut next = others;
            next.extend([best.pole_hz, *second]);
            let stands = |k: usize| self.mode_of(&next, k, STEPS).is_some_and(|m| self.accepts(&m));
            if stands(next.len() - 1) && stands(next.len() - 2) {
                *poles = next;
            }
        }
    }

    /// Fits every mode in the presence of the others until all stand still and are accepted; of those that are not, the
    /// weakest is dropped, and what it was fitted along with is fitted again.
    fn drop_modes(&self, poles: &mut Vec<c64>) {
        let mut modes: Vec<Option<FittedMode>> = vec![None; poles.len()];
        let mut stale = vec![true; poles.len()];
        let mut unsettled = 0;
        while unsettled < MOST_SETTLING_ROUNDS {
            let again: Vec<usize> = (0..poles.len()).filter(|k| stale[*k]).collect();
            let fit = |k: &usize| self.mode_of(poles, *k, STEPS_OF_ROUND);
            let fitted: Vec<Option<FittedMode>> = again.par_iter().map(fit).collect();
            let mut moved = 0.0f64;
            for (k, mode) in again.into_iter().zip(fitted) {
                if let Some(mode) = mode.as_ref().filter(|m| self.accepts(m)) {
                    moved = moved.max((mode.pole_hz - poles[k]).norm() / mode.sd_hz);
                    poles[k] = mode.pole_hz;
                }
                modes[k] = mode;
            }
            let gain = |k: usize| modes[k].as_ref().map_or(0.0, |m| m.gain);
            let fails = |k: &usize| !modes[*k].as_ref().is_some_and(|m| self.accepts(m));
            let weakest = (0..poles.len()).filter(fails).min_by(|i, j| gain(*i).total_cmp(&gain(*j)));
            match weakest {
                Some(k) => {
                    stale = (0..poles.len()).map(|i| self.takes_along(poles, i, k)).collect();
                    poles.remove(k);
                    modes.remove(k);
                    stale.remove(k);
                    unsettled = 0;
                }
                // A hundredth of a standard deviation.
                None if moved < 1e-2 => return,
                None => {
                    stale = vec![true; poles.len()];
                    unsettled += 1;
                }
            }
        }
    }

    /// Whether the fit of pole `i` takes pole `k` along, free or held.
    fn takes_along(&self, poles: &[c64], i: usize, k: usize) -> bool {
        let view = self.window(poles[i], &without(poles, i));
        let place = if k > i { k - 1 } else { k };
        i != k && view.is_some_and(|(_, _, free, held)| free.contains(&place) || held.contains(&place))
    }

    /// Mode `k` in the presence of the others.
    pub(super) fn mode_of(&self, poles: &[c64], k: usize, most_steps: usize) -> Option<FittedMode> {
        self.fit_mode(poles[k], &without(poles, k), most_steps)
    }

    fn accepts(&self, mode: &FittedMode) -> bool {
        let (pole, sd) = (mode.pole_hz, mode.sd_hz);
        let (first, last) = (self.frequency_hz.first(), self.frequency_hz.last());
        let inside = first.is_some_and(|f| pole.re > *f) && last.is_some_and(|f| pole.re < *f);
        // A damping ratio of zero within its standard deviation is possible, a negative one beyond it is not a mode.
        let damped = pole.im < MOST_DAMPING * pole.re && pole.im > -3.0 * sd;
        let seen = mode.gain > self.least_gain && mode.gain_without_line > 0.5 * self.least_gain;
        let told = mode.chi_squared < UNEXPLAINED || mode.share > LEAST_SHARE;
        let precise = sd < (WORST_RELATIVE_SD * pole.re).max(WORST_SD_OF_BANDWIDTH * pole.im);
        inside && damped && seen && told && precise && !mode.is_double
    }

    /// Window of a pole, its data, and the numbers of the other poles that lie in it and beside it.
    fn window(&self, pole_hz: c64, others: &[c64]) -> Option<(Window, LocalData, Vec<usize>, Vec<usize>)> {
        let window = Window::about(self.frequency_hz, pole_hz)?;
        let data = window.data(self.frequency_hz, &self.channels);
        let place = |k: usize| window.normalise(others[k]).re.abs();
        let free: Vec<usize> = (0..others.len()).filter(|k| place(*k) < 1.0).collect();
        let mut fixed: Vec<usize> = (0..others.len()).filter(|k| (1.0..3.0).contains(&place(*k))).collect();
        fixed.sort_by(|i, j| place(*i).total_cmp(&place(*j)));
        // Two lines for every coefficient; the nearest poles shape the window most, and many beside it are as one.
        fixed.truncate((data.x.len() / 2).saturating_sub(free.len() + DEGREE + 2).min(MOST_BESIDE));
        Some((window, data, free, fixed))
    }

    /// Gain of a pole where it stands, relative to what the fit leaves.
    fn gain_of(&self, pole_hz: c64, others: &[c64]) -> f64 {
        let gain = || {
            let (window, data, free, fixed) = self.window(pole_hz, others)?;
            let held = free.iter().chain(&fixed).map(|k| window.normalise(others[*k]));
            let held: Vec<c64> = [window.normalise(pole_hz)].into_iter().chain(held).collect();
            let found = fit(&data, &[], &held, DEGREE)?;
            Some(found.gain(0) / found.chi_squared.max(LEAST_CHI_SQUARED))
        };
        gain().unwrap_or(0.0)
    }

    /// The mode that starts at a pole, fitted with those of the others that lie in its window.
    fn fit_mode(&self, start_hz: c64, others: &[c64], most_steps: usize) -> Option<FittedMode> {
        let (window, mut data, free, fixed) = self.window(start_hz, others)?;
        let start = free.iter().map(|k| window.normalise(others[*k]));
        let start: Vec<c64> = [window.normalise(start_hz)].into_iter().chain(start).collect();
        let held: Vec<c64> = fixed.iter().map(|k| window.normalise(others[*k])).collect();
        let found = fit_in_steps(&data, &start, &held, DEGREE, most_steps)?;
        let channels = 0..self.channels.len();
        let is_double = self.is_double(&data, &found, &held);
        let strength = |l: usize| {
            let gap = (c64::new(data.x[l], 0.0) - found.poles[0]).norm_sqr();
            let each = channels.clone().map(|c| (found.residue(c, 0) / data.channels[c].sigma[l]).norm_sqr());
            each.sum::<f64>() / gap
        };
        let scale = found.chi_squared_of(&data, strength).max(LEAST_CHI_SQUARED);
        let strongest = (0..data.x.len()).max_by(|i, j| strength(*i).total_cmp(&strength(*j)))?;
        let gap = (c64::new(data.x[strongest], 0.0) - found.poles[0]).norm();
        let size = |value: &dyn Fn(usize) -> c64| channels.clone().map(|c| value(c).norm_sqr()).sum::<f64>().sqrt();
        let share = size(&|c| found.residue(c, 0)) / (gap * size(&|c| data.channels[c].value[strongest]));
        for channel in &mut data.channels {
            channel.sigma[strongest] = f64::INFINITY;
        }
        let all: Vec<c64> = found.poles.iter().chain(&held).copied().collect();
        let without_line = fit(&data, &[], &all, DEGREE)?;
        Some(FittedMode {
            pole_hz: window.hz(found.poles[0]),
            sd_hz: found.pole_sd[0] * scale.sqrt() * window.half_hz,
            residues: channels.map(|c| (found.residue(c, 0), found.residue_sd(c, 0) * scale.sqrt())).collect(),
            gain: found.gain(0) / scale,
            gain_without_line: without_line.gain(0) / scale,
            chi_squared: found.chi_squared,
            share,
            half_hz: window.half_hz,
            beside: free.iter().zip(&found.poles[1..]).map(|(k, p)| (*k, window.hz(*p))).collect(),
            is_double,
        })
    }

    /// Whether pole 0 of a fit with the poles `held` shares its place with another free one and is the same mode: both
    /// have one shape, the record is no sum of modes, or each channel alone is as well off with one pole of its own,
    /// which drifts from channel to channel.
    fn is_double(&self, data: &LocalData, found: &LocalFit, held: &[c64]) -> bool {
        let (pole, others) = (found.poles[0], &found.poles[1..]);
        let reach = |q: c64| pole.im.abs().max(q.im.abs());
        let near: Vec<usize> = (0..others.len()).filter(|k| (pole - others[*k]).norm() < reach(others[*k])).collect();
        let has_shape = |k: &usize| {
            (pole - others[*k]).norm() < SAME_PLACE * reach(others[*k]) && self.have_one_shape(found, k + 1)
        };
        if near.is_empty() || near.iter().any(has_shape) || found.chi_squared > UNEXPLAINED {
            return !near.is_empty();
        }
        let apart = (0..others.len()).filter(|k| !near.contains(k)).map(|k| others[k]);
        let fixed: Vec<c64> = apart.chain(held.iter().copied()).collect();
        let alone = data.channels.iter().map(|channel| {
            let one = LocalData { x: data.x.clone(), channels: vec![channel.clone()] };
            fit(&one, &[pole], &fixed, DEGREE).map_or(f64::INFINITY, |f| f.chi_squared)
        });
        found.chi_squared > SPLIT_GAIN * alone.sum::<f64>() / data.channels.len() as f64
    }

    fn have_one_shape(&self, found: &LocalFit, k: usize) -> bool {
        let shape = |a: usize, b: usize| {
            let each = (0..self.channels.len()).map(|c| found.residue(c, a).conj() * found.residue(c, b));
            each.sum::<c64>().norm_sqr()
        };
        shape(0, k) > SAME_SHAPE * (shape(0, 0) * shape(k, k)).sqrt()
    }
}
