//! Emulation: a controller is designed in continuous time and discretised by Tustin's rule.
//!
//! The rule bends frequencies, s = k (z − 1)/(z + 1): it keeps the response at one frequency, chosen by k =
//! ω/tan(ωT/2), and shifts every other one. The best choice depends on where μ peaks: the frequencies of the uncertain
//! modes and the geometric means between them are tried, and the one with the lowest μ of the *sampled* loop is taken.
//! In the w plane of the direct route, v = (2/T)(z − 1)/(z + 1), the sampled controller is K(s) with s = (kT/2) v: a
//! stretch of the frequency axis, nothing else.

use super::PipelineError;
use super::certificates::attained_gain;
use super::problems::Problems;
use crate::linalg::Mat;
use crate::lti::{Continuous, StateSpace};
use std::f64::consts::TAU;

/// Order of the Padé approximant of the delay: its phase is exact to 0.1° up to half the sample rate at 1.5 samples.
pub(crate) const PADE_ORDER: usize = 4;

/// A discretised controller of the continuous design.
#[derive(Clone, Copy, Debug)]
pub struct Emulated {
    /// Frequency at which the response is kept, Hz.
    pub prewarp_hz: f64,
    /// μ of the synthesis problem in continuous time, with the delay as a Padé approximant.
    pub mu_continuous: f64,
    /// μ of the synthesis problem on the sampled loop.
    pub mu_sampled: f64,
}

/// The controller of a continuous design in the w plane of the sampled loop.
pub(super) fn sampled_by_tustin(
    problems: &Problems,
    controller: &StateSpace<Continuous>,
) -> Result<(StateSpace<Continuous>, Emulated), PipelineError> {
    let mut modes: Vec<f64> = problems.covered_modes.iter().map(|m| m.omega_rad_s).collect();
    modes.sort_by(f64::total_cmp);
    let between: Vec<f64> = modes.windows(2).map(|w| (w[0] * w[1]).sqrt()).collect();
    // Without modes, a tenth of the sample rate.
    let mut tried: Vec<f64> = modes.into_iter().chain(between).collect();
    tried.push(0.1 * TAU / problems.period_s);
    tried.retain(|w| w * problems.period_s < std::f64::consts::PI);
    let mut best: Option<(StateSpace<Continuous>, f64, f64)> = None;
    for omega in &tried {
        let half = 0.5 * omega * problems.period_s;
        let stretched = stretch(controller, half / half.tan());
        let Some(mu) = attained_gain(&problems.synthesis, &stretched)? else {
            continue;
        };
        if best.as_ref().is_none_or(|b| mu < b.1) {
            best = Some((stretched, mu, *omega));
        }
    }
    let Some((sampled, mu_sampled, omega)) = best else {
        return Err(PipelineError::Emulated { tried: tried.len() });
    };
    Ok((
        sampled,
        Emulated {
            prewarp_hz: omega / TAU,
            mu_continuous: attained_gain(&problems.posed, controller)?.unwrap_or(f64::INFINITY),
            mu_sampled,
        },
    ))
}

/// K(r v) as a system in v.
fn stretch(k: &StateSpace<Continuous>, r: f64) -> StateSpace<Continuous> {
    let over = |m: &Mat<f64>| Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] / r);
    StateSpace { a: over(&k.a), b: over(&k.b), c: k.c.clone(), d: k.d.clone(), time: Continuous }
}
