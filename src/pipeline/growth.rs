//! Sections that give a controller more freedom where μ of the whole machine peaks.
//!
//! A polish moves the poles and residues that a law has. Where a law of low order leaves μ above one, its order grows
//! where that helps most: every channel is followed by a section that changes little, and the polish makes of it what
//! lowers the peak. Three kinds at the peak ω, of strength a:
//!   notch and resonance  (s² + 2ζ(1 ∓ a)ωs + ω²)/(s² + 2ζωs + ω²),
//!   shelf  (s + (1 + a/2)w)/(s + w), w = 5ω: more gain below the peak and round it.
//! Sampled by Tustin's rule with ω moved so that it is exact.

use super::PipelineError;
use crate::linalg::Mat;
use crate::lti::connect::{append, series};
use crate::lti::sample::tustin;
use crate::lti::{Continuous, Discrete, StateSpace};
use crate::pid::parameters::Biquad;
use std::f64::consts::{PI, TAU};

/// ζ: as wide as what moves with speed and uncertainty.
const DAMPING: f64 = 0.3;
/// w/ω: the phase that a shelf takes at the peak is then small.
const SHELF: f64 = 5.0;
/// Frequencies of the front and the rear section relative to ω: the poles of a law in modal form must not be double.
const APART: [f64; 2] = [0.99, 1.01];
/// Lowest peak, Hz: a static one counts as one at the first line of a polish.
const LOWEST_HZ: f64 = 1.0;
/// Highest corner of a section as a share of Nyquist.
const HIGHEST: f64 = 0.9;

/// A controller of one plane with a section of a strength from 0 to 1 more behind each channel: with notches, with
/// resonances, with shelves.
///
/// # Errors
/// [`PipelineError::Numeric`] for numbers that make no section.
pub fn with_section(
    plane: &StateSpace<Discrete>,
    peak_hz: f64,
    strength: f64,
) -> Result<Vec<StateSpace<Discrete>>, PipelineError> {
    let period_s = plane.time.period_s;
    let omega = TAU * peak_hz.max(LOWEST_HZ);
    let corner = |relative: f64, apart: f64| {
        let half = (0.5 * (relative * apart) * omega * period_s).min(0.5 * HIGHEST * apart * PI);
        2.0 / period_s * half.tan()
    };
    let resonance = |apart: f64, gain: f64| {
        let w = corner(1.0, apart);
        Biquad { zero_rad_s: w, zero_damping: gain * DAMPING, pole_rad_s: w, pole_damping: DAMPING }.system()
    };
    let shelf = |apart: f64| {
        let w = corner(SHELF, apart);
        let own = |value: f64| Mat::from_fn(1, 1, |_, _| value);
        StateSpace::new(own(-w), own(1.0), own(0.5 * strength * w), own(1.0), Continuous)
    };
    let kinds = [
        APART.map(|apart| resonance(apart, 1.0 - strength)),
        APART.map(|apart| resonance(apart, 1.0 + strength)),
        APART.map(shelf),
    ];
    let mut grown = vec![];
    for [front, rear] in kinds {
        let sections = front.and_then(|front| Ok(append(&front, &rear?)));
        let sampled = sections.and_then(|sections| tustin(&sections, period_s));
        let found = sampled.and_then(|sampled| series(plane, &sampled));
        grown.push(found.map_err(PipelineError::numeric("section at a peak of µ"))?);
    }
    Ok(grown)
}
