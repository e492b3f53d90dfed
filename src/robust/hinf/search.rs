//! Search of the smallest feasible level of an H∞ problem.
//! √ρ(X₂Y₂) of the γ = ∞ solutions is a lower bound, since X and Y fall with γ. The root of ρ(XY) = γ² is sought from
//! the level that their derivatives predict (`coupling_root`). Where that leads nowhere, a side binds, or nearly: the
//! peaks of both sides over frequency (`side`) are further lower bounds. If the rest holds just above the largest one,
//! that is the optimum; otherwise the root of the measure of `riccati_pair` is bracketed and interpolated: about eight
//! pairs of Riccati equations to 1e-7.

use super::assumptions::explain;
use super::coupling_root::{Asked, SHARE, coupling_root};
use super::couplings::Couplings;
use super::level_bracket::{Test, Tested, bracket, narrow};
use super::limit::{Limit, Optimum};
use super::normal::NormalForm;
use super::riccati_pair::{Coupling, DEFINITE, Pair, Solved, coupling, solve_pair};
use super::settings::HinfSettings;
use super::side::{Regulator, RiccatiSide, control_side, filter_side};
use crate::augment::GeneralizedPlant;
use crate::linalg::riccati::RiccatiEffort;
use crate::linalg::{Mat, NumericError};
use crate::lti::level_set::Peak;
use crate::robust::error::{Condition, SynthesisError};
use std::cell::Cell;
use std::sync::OnceLock;

/// Relative tolerance of the level peaks and of the verified norm.
pub(super) const LEVEL_TOL: f64 = 1e-9;

/// Closest tolerance of a level: where Riccati equations are solved in f64, rounding is not far below.
const LEAST_TOL: f64 = 1e-9;
/// Factor on the lower bound from which the root of the coupling is sought where it is above.
const BEYOND: f64 = 1.25;
/// At so many times the lower bounds X and Y are those of γ = ∞ to half the digits of f64.
const FAR: f64 = 1e4;
/// So many decades below the size of the data there is nothing but rounding.
const DECADES: i32 = 15;

/// A problem in normal form with its lower bounds.
pub(super) struct GammaSearch {
    pub normal: NormalForm,
    pub control: RiccatiSide,
    pub filter: RiccatiSide,
    /// Each side at γ = ∞.
    pub control_regulator: Regulator,
    pub filter_regulator: Regulator,
    /// Smallest level of each side, once asked for.
    levels: OnceLock<Result<[Peak; 2], NumericError>>,
    /// That of X₂ and Y₂; their largest eigenvalues are the scale of X and Y far from their singularities.
    regulators: Coupling,
}

impl GammaSearch {
    pub(super) fn new(plant: &GeneralizedPlant) -> Result<Self, SynthesisError> {
        let normal = NormalForm::new(plant)?;
        let (control, filter) = (control_side(&normal), filter_side(&normal));
        let regulator = |side: &RiccatiSide, which| {
            side.regulator().map_err(|source| match explain(&control, &filter) {
                Err(named) => named,
                Ok(()) => SynthesisError::Regulator { which, source },
            })
        };
        let (k, f) = rayon::join(|| regulator(&control, "control"), || regulator(&filter, "filter"));
        let (k, f) = (k?, f?);
        if k.is_marginal(&control) || f.is_marginal(&filter) {
            explain(&control, &filter)?;
        }
        let regulators = coupling(&k.x, &f.x)?;
        Ok(Self {
            levels: OnceLock::new(),
            regulators,
            control_regulator: k,
            filter_regulator: f,
            normal,
            control,
            filter,
        })
    }

    /// Whether the conditions hold at a level.
    pub(super) fn feasible(plant: &GeneralizedPlant, gamma: f64) -> Result<bool, SynthesisError> {
        let normal = NormalForm::new(plant)?;
        let sides = [control_side(&normal), filter_side(&normal)];
        if sides.iter().any(|s| s.level_at_infinity() >= gamma) {
            return Ok(false);
        }
        let [control, filter] = sides;
        let found = solve_pair(&control, &filter, gamma, RiccatiEffort::Decision)?;
        Ok(found.is_some_and(|Solved { coupling, .. }| coupling.is_definite() && coupling.ratio < gamma * gamma))
    }

    /// Smallest levels that the control side and the filter side allow, with their frequencies.
    pub(super) fn levels(&self) -> Result<[Peak; 2], NumericError> {
        let found = self.levels.get_or_init(|| {
            let (control, filter) = rayon::join(
                || self.control.smallest_level(&self.control_regulator, LEVEL_TOL),
                || self.filter.smallest_level(&self.filter_regulator, LEVEL_TOL),
            );
            Ok([control?, filter?])
        });
        found.clone()
    }

    /// Conditions that need no Riccati equation.
    pub(super) fn below_level(&self, gamma: f64) -> Result<Option<Condition>, NumericError> {
        for (level, control) in self.levels()?.into_iter().zip([true, false]) {
            if gamma > level.lower {
                continue;
            }
            let (bound, omega_rad_s) = (level.lower, level.omega_rad_s);
            return Ok(Some(match (omega_rad_s.is_infinite(), control) {
                (true, _) => Condition::Feedthrough { bound },
                (false, true) => Condition::ControlAxis { bound, omega_rad_s },
                (false, false) => Condition::FilterAxis { bound, omega_rad_s },
            }));
        }
        Ok(None)
    }

    pub(super) fn pair(&self, gamma: f64, effort: RiccatiEffort) -> Result<Pair, SynthesisError> {
        let found = solve_pair(&self.control, &self.filter, gamma, effort)?;
        let Some(Solved { x, y, coupling: c }) = found else {
            let nothing = Mat::zeros(0, 0);
            return Ok(Pair {
                x: nothing.clone(),
                y: nothing,
                x_residual: f64::NAN,
                y_residual: f64::NAN,
                x_min: f64::NAN,
                y_min: f64::NAN,
                coupling: f64::NAN,
                measure: -1.0,
                nearest: Limit::Coupling,
                failed: Some(Condition::Unsolved),
            });
        };
        let ratio = c.ratio / gamma / gamma;
        let (measure, nearest) = c.measure(gamma, self.regulators.extremes);
        let failed = if c.x_min < -DEFINITE {
            Some(Condition::ControlIndefinite)
        } else if c.y_min < -DEFINITE {
            Some(Condition::FilterIndefinite)
        } else if ratio >= 1.0 {
            Some(Condition::Coupling { ratio })
        } else {
            None
        };
        Ok(Pair {
            x: x.x,
            y: y.x,
            x_residual: x.residual,
            y_residual: y.residual,
            x_min: c.x_min,
            y_min: c.y_min,
            coupling: ratio,
            measure,
            nearest,
            failed,
        })
    }

    /// Smallest feasible level within the tolerance.
    pub(super) fn optimum(&self, settings: &HinfSettings, pairs: &Cell<usize>) -> Result<Optimum, SynthesisError> {
        let start = match settings.hint {
            Some(hint) => hint,
            None => self.start()?,
        };
        match self.coupled_from(start, settings, pairs)? {
            Some(found) => Ok(found),
            None => self.above_bounds(settings, pairs),
        }
    }

    /// √ρ(X₂Y₂), a lower bound.
    pub(super) fn coupling_level(&self) -> f64 {
        self.regulators.ratio.max(0.0).sqrt()
    }

    /// The level at which the coupling binds, as far as X₂, Y₂ and their derivatives by 1/γ² tell.
    pub(super) fn start(&self) -> Result<f64, SynthesisError> {
        let lowest = self.coupling_level();
        let sides = [&self.control, &self.filter];
        let far = sides.map(RiccatiSide::level_at_infinity).into_iter();
        let far = FAR * far.fold(lowest, f64::max);
        if !(lowest > 0.0 && far.is_finite()) {
            return Ok(lowest);
        }
        let solutions = [&self.control_regulator.x, &self.filter_regulator.x];
        let couplings = Couplings::of_solutions(sides, solutions, &self.regulators, far)?;
        let start = lowest * couplings.binding_per_root();
        Ok(if start.is_finite() { start } else { lowest })
    }

    /// The root of ρ(XY) = γ² from a level.
    fn coupled_from(
        &self,
        start: f64,
        settings: &HinfSettings,
        pairs: &Cell<usize>,
    ) -> Result<Option<Optimum>, SynthesisError> {
        let tol = settings.rel_tol.max(LEAST_TOL);
        let asked = (start, tol);
        let found = coupling_root(&self.control, &self.filter, asked.0, asked.1, Asked::Level, pairs)?;
        Ok(found.map(|(ln, _)| Optimum {
            // The feasible end of what is left.
            gamma: ln.exp() * (1.0 + SHARE * tol),
            limit: Limit::Coupling,
        }))
    }

    /// Smallest feasible level where the coupling has no root that derivatives lead to from afar: just above the lower
    /// bounds, or bracketed.
    pub(super) fn above_bounds(&self, settings: &HinfSettings, pairs: &Cell<usize>) -> Result<Optimum, SynthesisError> {
        let tol = settings.rel_tol.max(LEAST_TOL);
        let Optimum { gamma: lower, limit } = self.lower_bound()?;
        let mut test = |gamma: f64| -> Result<Tested, SynthesisError> {
            pairs.set(pairs.get() + 1);
            let pair = self.pair(gamma, RiccatiEffort::Fast)?;
            let failed = match pair.failed {
                None => self.below_level(gamma)?,
                failed => failed,
            };
            Ok(Tested { gamma, measure: pair.measure, nearest: pair.nearest, failed })
        };
        if lower == 0.0 {
            return self.without_bound(settings, &mut test);
        }
        // Just above the axis conditions, as close as a Riccati equation can be solved in f64.
        let mut lo = Tested::infeasible(lower);
        for step in [tol, 1e-6, 1e-5, 1e-4] {
            if step < tol {
                continue;
            }
            let found = test(lower * (1.0 + step))?;
            match found.failed {
                // The conditions hold here, and none holds below `lower`.
                None => {
                    let gamma = lower * (1.0 + tol);
                    return Ok(Optimum { gamma, limit });
                }
                Some(Condition::Unsolved) => {}
                Some(_) => {
                    lo = found;
                    break;
                }
            }
        }
        if let Some(found) = self.coupled_from(lower * BEYOND, settings, pairs)? {
            return Ok(found);
        }
        let (lo, hi) = bracket(lo, settings.hint, &mut test)?;
        narrow(lo, hi, tol, &mut test)
    }

    /// The largest of the bounds that need no Riccati equation at a level.
    fn lower_bound(&self) -> Result<Optimum, NumericError> {
        let [control, filter] = self.levels()?;
        let sides = [
            (control.lower, Limit::ControlSide { omega_rad_s: control.omega_rad_s }),
            (filter.lower, Limit::FilterSide { omega_rad_s: filter.omega_rad_s }),
        ];
        let first = Optimum { gamma: self.coupling_level(), limit: Limit::Coupling };
        Ok(sides.into_iter().fold(
            first,
            |largest, (gamma, limit)| if gamma > largest.gamma { Optimum { gamma, limit } } else { largest },
        ))
    }

    /// Smallest feasible level where the lower bound is zero: it is bracketed in steps of a decade from the size of the
    /// data. An infimum of zero is not attained: then the level ends where rounding begins.
    fn without_bound(&self, settings: &HinfSettings, test: &mut Test) -> Result<Optimum, SynthesisError> {
        let tol = settings.rel_tol.max(LEAST_TOL);
        let size = 1.0 + self.normal.d11.norm_l2() + self.normal.b1.norm_l2() * self.normal.c1.norm_l2();
        let mut hi = test(size)?;
        if hi.failed.is_some() {
            let (lo, hi) = bracket(hi, settings.hint, test)?;
            return narrow(lo, hi, tol, test);
        }
        for k in 1..=DECADES {
            let next = test(size * 10f64.powi(-k))?;
            match next.failed {
                None => hi = next,
                Some(Condition::Unsolved) => break,
                Some(_) => return narrow(next, hi, tol, test),
            }
        }
        Ok(Optimum { gamma: hi.gamma, limit: Limit::Rounding })
    }
}
