//! The optimal level of a problem near one whose level is known, by Newton's method on ρ(XY) = γ².
//!
//! γ²/ρ(XY) − 1 is nearly linear in ln γ, and its derivative costs a Lyapunov equation a side ([`super::slope`]): three
//! pairs of Riccati equations, and neither brackets nor the peaks of the sides. Where X and Y exist and are positive at
//! a root, it is the optimum, for both fall with γ.

use super::normal::NormalForm;
use super::riccati_pair::solved;
use super::side::{control_side, filter_side};
use super::slope::{BindingLevel, Couplings};
use crate::augment::GeneralizedPlant;
use crate::linalg::riccati::Effort;
use crate::robust::error::SynthesisError;

/// Steps at most: quadratic convergence needs three or four; a problem that needs more is not near.
const STEPS: usize = 6;
/// Share of the tolerance that the square of the last step may be: the curvature of the measure beside its slope is of
/// the order of one, and larger near a singularity of X or Y.
const SQUARE: f64 = 0.1;
/// Largest step in ln γ.
const LONGEST: f64 = 0.3;

/// ln γ to `tolerance`, and the couplings that bind there, from the level `hint`; `None` where the way leads to levels
/// at which X or Y does not exist or is indefinite.
///
/// # Errors
/// [`SynthesisError`] when the problem has no normal form or a decomposition fails.
pub(super) fn near_level(
    plant: &GeneralizedPlant,
    hint: f64,
    tolerance: f64,
) -> Result<Option<(f64, Vec<BindingLevel>)>, SynthesisError> {
    let normal = NormalForm::new(plant)?;
    let (control, filter) = (control_side(&normal), filter_side(&normal));
    let least = control.level_at_infinity().max(filter.level_at_infinity());
    let mut ln = hint.ln();
    for _ in 0..STEPS {
        let gamma = ln.exp();
        if gamma <= least || !gamma.is_finite() {
            return Ok(None);
        }
        let found = solved(&control, &filter, gamma, Effort::Fast)?;
        let Some(found) = found.filter(|found| found.coupling.is_definite()) else {
            return Ok(None);
        };
        let found = Couplings::new(&control, &filter, &found, gamma)?;
        let Some(step) = found.newton() else {
            return Ok(None);
        };
        // What is left after a step is about its square.
        if step * step <= SQUARE * tolerance {
            return Ok(Some((ln + step, found.levels(&normal))));
        }
        ln += step.clamp(-LONGEST, LONGEST);
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::augment::GeneralizedPlant;
    use crate::linalg::Mat;
    use crate::lti::connect::append;
    use crate::lti::{Continuous, StateSpace};
    use crate::robust::hinf::settings::HinfSettings;
    use crate::robust::hinf::{optimal_level, optimal_level_with_slopes};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const CONTROLS: usize = 2;
    const MEASUREMENTS: usize = 1;

    fn random(rows: usize, columns: usize, from: &mut ChaCha8Rng) -> Mat<f64> {
        Mat::from_fn(rows, columns, |_, _| from.random_range(-1.0..1.0))
    }

    /// Order 5, three disturbances and errors; the last pair, `apart`, is a channel that no control reaches.
    fn plant(seed: u64, apart: bool) -> GeneralizedPlant {
        let mut from = ChaCha8Rng::seed_from_u64(seed);
        let n = 5;
        let a = random(n, n, &mut from) - Mat::<f64>::identity(n, n);
        let inner = StateSpace {
            a,
            b: random(n, 3 + CONTROLS, &mut from),
            c: random(3 + MEASUREMENTS, n, &mut from),
            d: random(3 + MEASUREMENTS, 3 + CONTROLS, &mut from),
            time: Continuous,
        };
        let alone = StateSpace {
            a: Mat::from_fn(2, 2, |i, j| [[0.0, 3.0], [-3.0, -0.4]][i][j]),
            b: Mat::from_fn(2, 1, |i, _| i as f64),
            c: Mat::from_fn(1, 2, |_, j| if j == 0 { 4.0 } else { 0.5 }),
            d: Mat::from_fn(1, 1, |_, _| 0.3),
            time: Continuous,
        };
        let system = match apart {
            // The channel comes first, so that u and y stay last.
            true => append(
                &alone.scale_outputs(&Mat::from_fn(1, 1, |_, _| 40.0)),
                &inner,
            ),
            false => inner,
        };
        GeneralizedPlant {
            system,
            controls: CONTROLS,
            measurements: MEASUREMENTS,
            blocks: vec![],
        }
    }

    /// Largest distance of a slope from central differences of the searched level along random changes.
    fn error(plant: &GeneralizedPlant, hint: Option<f64>) -> Result<f64, SynthesisError> {
        let settings = HinfSettings {
            rel_tol: 1e-9,
            hint,
            ..HinfSettings::default()
        };
        let (ln_level, levels) = optimal_level_with_slopes(plant, &settings)?;
        let top = levels
            .iter()
            .max_by(|a, b| a.ln_level.total_cmp(&b.ln_level))
            .expect("an optimum has a level that binds");
        assert!((top.ln_level - ln_level).abs() < 1e-6);
        let mut from = ChaCha8Rng::seed_from_u64(99);
        let s = &plant.system;
        let step = 1e-4;
        let mut worst = 0.0f64;
        for _ in 0..4 {
            let change = [&s.a, &s.b, &s.c, &s.d].map(|m| random(m.nrows(), m.ncols(), &mut from));
            let moved = |by: f64| {
                let mut moved = plant.clone();
                moved.system.a += &change[0] * by;
                moved.system.b += &change[1] * by;
                moved.system.c += &change[2] * by;
                moved.system.d += &change[3] * by;
                optimal_level(&moved, &settings).map(f64::ln)
            };
            let difference = (moved(step)? - moved(-step)?) / (2.0 * step);
            let slope = top.slope.along(&change);
            worst = worst.max((slope - difference).abs() / difference.abs().max(1.0));
        }
        Ok(worst)
    }

    /// Slopes of some plants are those of the searched level.
    fn slopes_hold(seeds: u64, apart: bool) -> Result<(), SynthesisError> {
        for seed in 0..seeds {
            let found = error(&plant(seed, apart), None)?;
            assert!(found < 1e-4, "{seed}: {found:e}");
        }
        Ok(())
    }

    #[test]
    fn the_slope_of_a_coupling_is_that_of_the_searched_level() -> Result<(), SynthesisError> {
        slopes_hold(6, false)
    }

    #[test]
    fn newton_from_a_level_near_by_ends_at_the_same_level_and_slope() -> Result<(), SynthesisError>
    {
        let mut direct = 0;
        for seed in 0..6 {
            let plant = plant(seed, false);
            let level = optimal_level(&plant, &HinfSettings::default())?;
            let near = near_level(&plant, 1.05 * level, 1e-9)?;
            direct += usize::from(near.is_some());
            let found = error(&plant, Some(1.05 * level))?;
            assert!(found < 1e-4, "{seed}: {found:e}");
        }
        // Where a side binds there is no root.
        assert!(direct >= 4, "{direct}");
        Ok(())
    }

    #[test]
    fn the_slope_of_a_side_is_that_of_its_peak() -> Result<(), SynthesisError> {
        slopes_hold(4, true)
    }
}
