//! The optimal level of a problem near one whose level is known, with its slopes: neither brackets nor the peaks of the
//! sides are computed.

use super::coupling_root::{Asked, coupling_root};
use super::couplings::BindingLevel;
use super::normal::NormalForm;
use super::side::{control_side, filter_side};
use crate::augment::GeneralizedPlant;
use crate::robust::error::SynthesisError;
use std::cell::Cell;

/// ln γ to `tolerance`, and the couplings that bind there, from the level `hint`; `None` where the way leads to levels
/// at which X or Y does not exist or is indefinite.
pub(super) fn near_level(
    plant: &GeneralizedPlant,
    hint: f64,
    tolerance: f64,
) -> Result<Option<(f64, Vec<BindingLevel>)>, SynthesisError> {
    let normal = NormalForm::new(plant)?;
    let (control, filter) = (control_side(&normal), filter_side(&normal));
    let found = coupling_root(&control, &filter, hint, tolerance, Asked::Slopes, &Cell::new(0))?;
    Ok(found.map(|(ln, couplings)| (ln, couplings.levels(&normal))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::augment::GeneralizedPlant;
    use crate::linalg::Mat;
    use crate::lti::connect::append;
    use crate::lti::norm::hinf_norm;
    use crate::lti::{Continuous, StateSpace};
    use crate::robust::hinf::search::GammaSearch;
    use crate::robust::hinf::settings::HinfSettings;
    use crate::robust::hinf::{is_feasible, optimal_level, optimal_level_with_slopes};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const CONTROLS: usize = 2;
    const MEASUREMENTS: usize = 1;

    fn random(rows: usize, columns: usize, from: &mut ChaCha8Rng) -> Mat<f64> {
        Mat::from_fn(rows, columns, |_, _| from.random_range(-1.0..1.0))
    }

    /// A channel that no control reaches.
    fn channel() -> StateSpace<Continuous> {
        StateSpace {
            a: Mat::from_fn(2, 2, |i, j| [[0.0, 3.0], [-3.0, -0.4]][i][j]),
            b: Mat::from_fn(2, 1, |i, _| i as f64),
            c: Mat::from_fn(1, 2, |_, j| if j == 0 { 160.0 } else { 20.0 }),
            d: Mat::from_fn(1, 1, |_, _| 12.0),
            time: Continuous,
        }
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
        let system = match apart {
            // The channel comes first, so that u and y stay last.
            true => append(&channel(), &inner),
            false => inner,
        };
        GeneralizedPlant { system, controls: CONTROLS, measurements: MEASUREMENTS, blocks: vec![] }
    }

    /// Largest distance of a slope from central differences of the searched level along random changes.
    fn error(plant: &GeneralizedPlant, hint: Option<f64>) -> Result<f64, SynthesisError> {
        let settings = HinfSettings { rel_tol: 1e-9, hint, ..HinfSettings::default() };
        let (ln_level, levels) = optimal_level_with_slopes(plant, &settings)?;
        let top =
            levels.iter().max_by(|a, b| a.ln_level.total_cmp(&b.ln_level)).expect("an optimum has a level that binds");
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
    fn a_search_begins_nearer_to_the_level_than_its_lower_bound() -> Result<(), SynthesisError> {
        let mut halved = 0;
        for seed in 0..12 {
            let plant = plant(seed, false);
            let search = GammaSearch::new(&plant)?;
            let level = optimal_level(&plant, &HinfSettings::default())?;
            let [start, bound] = [search.start()?, search.coupling_level()];
            let apart = |from: f64| (from / level).ln().abs();
            assert!(bound <= level && start >= bound, "{seed}: {bound} {start}");
            assert!(apart(start) < apart(bound), "{seed}: {start} to {level}");
            halved += usize::from(apart(start) < 0.5 * apart(bound));
        }
        assert!(halved >= 8, "{halved}");
        Ok(())
    }

    #[test]
    fn newton_from_a_level_near_by_ends_at_the_same_level_and_slope() -> Result<(), SynthesisError> {
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

    /// Two plants side by side, the levels of which differ by the share `apart`, that act on each other a little: two
    /// eigenvalues of XY that nearly meet, and grow differently.
    fn neighbours(seed: u64, apart: f64) -> Result<GeneralizedPlant, SynthesisError> {
        let settings = HinfSettings { rel_tol: 1e-10, ..HinfSettings::default() };
        let mut pair = Vec::new();
        for (one, level) in [(seed, 1.0), (seed + 1, 1.0 + apart)] {
            let mut one = plant(one, false);
            let share = level / optimal_level(&one, &settings)?;
            let errors = one.errors();
            for m in [&mut one.system.c, &mut one.system.d] {
                for j in 0..m.ncols() {
                    (0..errors).for_each(|i| m[(i, j)] *= share);
                }
            }
            pair.push(one);
        }
        let both = append(&pair[0].system, &pair[1].system);
        // Errors of both before measurements of both, disturbances of both before controls of both.
        let order = |first: usize, second: usize| -> Vec<usize> {
            let of = |copy: usize| copy * (first + second);
            let kind = |from: usize, many: usize| (0..2).flat_map(move |c| (0..many).map(move |k| of(c) + from + k));
            kind(0, first).chain(kind(first, second)).collect()
        };
        let rows = order(pair[0].errors(), MEASUREMENTS);
        let columns = order(pair[0].disturbances(), CONTROLS);
        let mut system = both.select(&rows, &columns);
        let n = system.order();
        let mut from = ChaCha8Rng::seed_from_u64(seed + 1000);
        system.a += random(n, n, &mut from) * (0.1 * apart);
        Ok(GeneralizedPlant { system, controls: 2 * CONTROLS, measurements: 2 * MEASUREMENTS, blocks: vec![] })
    }

    #[test]
    fn a_level_where_two_couplings_nearly_meet_is_that_of_a_bisection() -> Result<(), SynthesisError> {
        let mut direct = 0;
        for seed in 0..6 {
            for apart in [1e-5, 1e-4, 1e-3] {
                let plant = neighbours(seed, apart)?;
                let start = optimal_level(&plant, &HinfSettings::default())?;
                let hi = bisect_gamma(&plant, start * (1.0 - 1e-3), start * (1.0 + 1e-3))?;
                assert!((start / hi - 1.0).abs() < 2e-7, "{seed} {apart}: {start} {hi}");
                for off in [-1e-4, -1e-5, 1e-5, 1e-4, 1e-2] {
                    let Some((ln, _)) = near_level(&plant, hi * (1.0 + off), 1e-7)? else {
                        continue;
                    };
                    direct += 1;
                    assert!((ln - hi.ln()).abs() < 1e-7, "{seed} {apart} {off}: {}", ln - hi.ln());
                }
            }
        }
        assert!(direct >= 40, "{direct}");
        Ok(())
    }

    /// The optimal level by bisection, to a relative 1e-9.
    fn bisect_gamma(plant: &GeneralizedPlant, mut lo: f64, mut hi: f64) -> Result<f64, SynthesisError> {
        assert!(is_feasible(plant, hi)? && !is_feasible(plant, lo)?);
        while hi / lo > 1.0 + 1e-9 {
            let middle = (lo * hi).sqrt();
            if is_feasible(plant, middle)? { hi = middle } else { lo = middle }
        }
        Ok(hi)
    }

    /// A plant with a channel that no control reaches, the norm of which is 1 + `above` times the level of the rest;
    /// random entries of A of the size `coupled` join the two. Where the coupling binds it is steep, because X and Y
    /// pass infinity just below.
    fn beside_a_channel(seed: u64, above: f64, coupled: f64) -> Result<GeneralizedPlant, SynthesisError> {
        let inner = optimal_level(&plant(seed, false), &HinfSettings::default())?;
        let mut plant = plant(seed, true);
        let norm = hinf_norm(&channel(), 1e-9).map_or(f64::NAN, |norm| norm.norm);
        let share = (1.0 + above) * inner / norm;
        for m in [&mut plant.system.c, &mut plant.system.d] {
            (0..m.ncols()).for_each(|j| m[(0, j)] *= share);
        }
        let n = plant.system.order();
        let mut from = ChaCha8Rng::seed_from_u64(seed + 2000);
        plant.system.a += random(n, n, &mut from) * coupled;
        Ok(plant)
    }

    #[test]
    fn a_level_just_above_that_of_a_side_is_that_of_a_bisection() -> Result<(), SynthesisError> {
        let mut direct = 0;
        for seed in 0..50 {
            for (above, coupled) in [(-1e-2, 3e-2), (1e-2, 1e-2)] {
                let plant = beside_a_channel(seed, above, coupled)?;
                let near = optimal_level(&plant, &HinfSettings::default())?;
                let level = bisect_gamma(&plant, near * (1.0 - 1e-3), near * (1.0 + 1e-3))?;
                for off in [-0.9, 1e-5, 1e-4, 1e-3] {
                    for tolerance in [1e-5, 1e-7] {
                        let hint = level * (1.0 + off);
                        let settings = HinfSettings { rel_tol: tolerance, hint: Some(hint), ..HinfSettings::default() };
                        let searched = (optimal_level(&plant, &settings)? / level).ln();
                        let near = near_level(&plant, hint, tolerance)?.map(|(ln, _)| ln - level.ln());
                        direct += usize::from(near.is_some());
                        let error = near.unwrap_or(0.0).abs().max(searched.abs());
                        // The level of a search is the feasible end of its tolerance, a tenth above it.
                        assert!(error <= 1.1 * tolerance, "{seed} {above} {off} {tolerance}: {searched:e} {near:?}");
                    }
                }
            }
        }
        assert!(direct >= 100, "{direct}");
        Ok(())
    }

    #[test]
    fn the_slope_of_a_side_is_that_of_its_peak() -> Result<(), SynthesisError> {
        slopes_hold(4, true)
    }
}
