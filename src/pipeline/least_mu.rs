//! A bound below which no controller brings μ of a specification, so that "impossible" and "not found" are told apart.
//!
//! With μ < β the performance block is below β for every stable Δ of the natural frequencies with ‖Δ‖∞ ≤ 1/β, hence for
//! one that is fixed:
//!   β > ‖F_l(F_u(P, Δ), K)‖∞ ≥ γ_opt(F_u(P, Δ)),
//! the H∞ optimum of loads and noise to displacements and current on a rotor that the specification admits. A β with
//! γ_opt(F_u(P, Δ)) ≥ β is therefore a bound, whatever the linear controller: one of four axes does no better at rest,
//! where the planes are two copies of one problem. Δ is zero, or for each mode an all-pass ±(s − a)/(s + a)/β, which at
//! the mode itself turns what is allowed of its frequency into a loss of damping. The bound is that of the sampled loop
//! of the whole machine at rest, exact hold and delay included; μ over speed is no less.

use super::problems::Problems;
use crate::augment::{Block, GeneralizedPlant};
use crate::linalg::Mat;
use crate::lti::connect::lower_lft;
use crate::lti::{Continuous, StateSpace};
use crate::robust::hinf::optimal_level;
use crate::robust::hinf::settings::HinfSettings;
use rayon::prelude::*;

/// What the tolerance of the search takes off an optimum, relative to it.
const ROUNDING: f64 = 1e-4;
/// The same of the search, ten times closer.
const LEVEL_TOL: f64 = 1e-5;
/// Turns of the search for β: each at least halves what is left, and a bound is one where it ends.
const TURNS: usize = 8;
/// Modes whose all-passes are tried in all signs: 3³ problems at most.
const MOST_MODES: usize = 3;

/// The bound for the problems of a design; none where the optimum of the performance alone cannot be computed.
pub(crate) fn least_mu(problems: &Problems) -> Option<f64> {
    let period_s = problems.period_s;
    let in_plane = |omega: f64| 2.0 / period_s * (0.5 * omega * period_s).tan();
    let modes: Vec<f64> = problems.written_modes.iter().map(|mode| in_plane(mode.omega_rad_s)).collect();
    least_mu_of(&problems.specification, &modes)
}

/// The bound for a specification in the w plane whose first channels are those of modes with these natural frequencies
/// there, rad/s.
pub fn least_mu_of(specification: &GeneralizedPlant, modes_rad_s: &[f64]) -> Option<f64> {
    let modes = &modes_rad_s[..modes_rad_s.len().min(MOST_MODES)];
    let signs = (0..3usize.pow(modes.len() as u32)).map(|code| {
        (0..modes.len())
            .map(|k| (code / 3usize.pow(k as u32) % 3) as f64)
            .map(|s| if s > 1.5 { -1.0 } else { s })
            .collect()
    });
    let signs: Vec<Vec<f64>> = signs.collect();
    let level = |signs: &[f64], beta: f64| optimum(specification, modes, signs, beta);
    let nominal = level(&vec![0.0; modes.len()], 1.0)?;
    // At the bound of the performance alone the perturbations are those that count there.
    let start = nominal.max(1.0);
    let found = signs.par_iter().filter_map(|signs| Some((level(signs, start)?, signs)));
    let (reached, signs) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
    // γ below β is a bound as well: the perturbations of 1/β are among those of 1/γ.
    let (mut low, mut high) = if reached >= start { (start, reached) } else { (nominal.max(reached), start) };
    for _ in 0..TURNS {
        let middle = (low * high).sqrt();
        match level(signs, middle) {
            Some(at) if at >= middle => low = middle,
            Some(at) => (low, high) = (low.max(at), middle),
            None => high = middle,
        }
    }
    Some((1.0 - ROUNDING) * low.max(nominal))
}

/// γ_opt of the last block with the modes perturbed in these signs, none where it is zero, by 1/β.
fn optimum(plant: &GeneralizedPlant, modes: &[f64], signs: &[f64], beta: f64) -> Option<f64> {
    let block = plant.blocks.last()?;
    let (w, z) = (plant.disturbances(), plant.errors());
    let perturbed: Vec<usize> = (0..modes.len()).filter(|k| signs[*k] != 0.0).collect();
    // Those that are perturbed last, where a system closes them.
    let inputs: Vec<usize> = (w - block.rows()..plant.system.inputs()).chain(perturbed.iter().copied()).collect();
    let outputs: Vec<usize> = (z - block.cols()..plant.system.outputs()).chain(perturbed.iter().copied()).collect();
    let open = plant.system.select(&outputs, &inputs);
    let n = perturbed.len();
    let diagonal =
        |value: &dyn Fn(usize) -> f64| Mat::from_fn(n, n, |i, j| if i == j { value(perturbed[i]) } else { 0.0 });
    let size = |k: usize| signs[k] / beta;
    let delta = StateSpace::new(
        diagonal(&|k| -modes[k]),
        diagonal(&|_| 1.0),
        diagonal(&|k| -2.0 * modes[k] * size(k)),
        diagonal(&size),
        Continuous,
    );
    let system = if n == 0 { open } else { lower_lft(&open, &delta.ok()?).ok()? };
    let whole = Block::ComplexFull { rows: block.rows(), cols: block.cols() };
    let plant = GeneralizedPlant { system, blocks: vec![whole], ..plant.clone() };
    let level = optimal_level(&plant, &HinfSettings { rel_tol: LEVEL_TOL, ..HinfSettings::default() }).ok()?;
    Some(level).filter(|level| level.is_finite())
}
