//! Search of the smallest feasible level of an H∞ problem.
//! √ρ(X₂Y₂) of the γ = ∞ solutions is a lower bound, since X and Y fall with γ. From there the root of ρ(XY) = γ² is
//! sought by derivatives (`coupling_root`). Where that leads nowhere, a side binds, or nearly: the peaks of both sides
//! over frequency (`side`) are further lower bounds. If the rest holds just above the largest one, that is the
//! optimum; otherwise the root of the measure of `riccati_pair` is bracketed and interpolated: about eight pairs of
//! Riccati equations to 1e-7.

use super::assumptions::explain;
use super::coupling_root::{Asked, SHARE, coupling_root};
use super::normal::NormalForm;
use super::riccati_pair::{DEFINITE, Pair, Solved, coupling, solved};
use super::settings::HinfSettings;
use super::side::{Regulator, Side, control_side, filter_side};
use crate::augment::GeneralizedPlant;
use crate::linalg::riccati::Effort;
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

/// The condition that fails just below the optimal level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// The coupling ρ(XY) < γ² of the control and the filter Riccati equation.
    Coupling,
    /// The control Riccati equation: with all states and disturbances measured, no control reaches a lower level at
    /// this frequency (rad/s).
    ControlSide {
        /// Infinite where the feedthrough binds.
        omega_rad_s: f64,
    },
    /// The filter Riccati equation: no estimate of the errors reaches a lower level at this frequency (rad/s).
    FilterSide {
        /// Infinite where the feedthrough binds.
        omega_rad_s: f64,
    },
    /// None: the infimum is zero and not attained; the level is where rounding ends the search.
    Rounding,
}

/// The smallest feasible level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Optimum {
    pub gamma: f64,
    pub limit: Limit,
}

/// A problem in normal form with its lower bounds.
pub(super) struct Search {
    pub normal: NormalForm,
    pub control: Side,
    pub filter: Side,
    /// Each side at γ = ∞.
    pub control_regulator: Regulator,
    pub filter_regulator: Regulator,
    /// Smallest level of each side, once asked for.
    levels: OnceLock<Result<[Peak; 2], NumericError>>,
    /// √ρ(X₂Y₂).
    coupling_level: f64,
    /// Largest eigenvalues of X₂ and Y₂, the scale of X and Y far from their singularities.
    sizes: [f64; 2],
}

impl Search {
    pub(super) fn new(plant: &GeneralizedPlant) -> Result<Self, SynthesisError> {
        let normal = NormalForm::new(plant)?;
        let (control, filter) = (control_side(&normal), filter_side(&normal));
        let regulator = |side: &Side, which| {
            side.regulator()
                .map_err(|source| match explain(&control, &filter) {
                    Err(named) => named,
                    Ok(()) => SynthesisError::Regulator { which, source },
                })
        };
        let (k, f) = rayon::join(
            || regulator(&control, "control"),
            || regulator(&filter, "filter"),
        );
        let (k, f) = (k?, f?);
        if k.is_marginal(&control) || f.is_marginal(&filter) {
            explain(&control, &filter)?;
        }
        let regulators = coupling(&k.x, &f.x)?;
        Ok(Self {
            levels: OnceLock::new(),
            coupling_level: regulators.ratio.max(0.0).sqrt(),
            sizes: regulators.extremes,
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
        let found = solved(&control, &filter, gamma, Effort::Decision)?;
        Ok(found.is_some_and(|Solved { coupling, .. }| {
            coupling.is_definite() && coupling.ratio < gamma * gamma
        }))
    }

    /// Smallest levels that the control side and the filter side allow, with their frequencies.
    pub(super) fn levels(&self) -> Result<[Peak; 2], NumericError> {
        let found = self.levels.get_or_init(|| {
            let (control, filter) = rayon::join(
                || {
                    self.control
                        .smallest_level(&self.control_regulator, LEVEL_TOL)
                },
                || {
                    self.filter
                        .smallest_level(&self.filter_regulator, LEVEL_TOL)
                },
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

    pub(super) fn pair(&self, gamma: f64, effort: Effort) -> Result<Pair, SynthesisError> {
        let found = solved(&self.control, &self.filter, gamma, effort)?;
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
                failed: Some(Condition::Unsolved),
            });
        };
        let ratio = c.ratio / gamma / gamma;
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
            measure: c.measure(gamma, self.sizes),
            failed,
        })
    }

    /// Smallest feasible level within the tolerance.
    pub(super) fn optimum(
        &self,
        settings: &HinfSettings,
        pairs: &Cell<usize>,
    ) -> Result<Optimum, SynthesisError> {
        let start = settings.hint.unwrap_or(self.coupling_level);
        match self.coupled_from(start, settings, pairs)? {
            Some(found) => Ok(found),
            None => self.above_bounds(settings, pairs),
        }
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
        let found = coupling_root(&self.control, &self.filter, asked, Asked::Level, pairs)?;
        Ok(found.map(|(ln, _)| Optimum {
            // The feasible end of what is left.
            gamma: ln.exp() * (1.0 + SHARE * tol),
            limit: Limit::Coupling,
        }))
    }

    /// Smallest feasible level where the coupling has no root that derivatives lead to from afar: just above the lower
    /// bounds, or bracketed.
    pub(super) fn above_bounds(
        &self,
        settings: &HinfSettings,
        pairs: &Cell<usize>,
    ) -> Result<Optimum, SynthesisError> {
        let tol = settings.rel_tol.max(LEAST_TOL);
        let Optimum {
            gamma: lower,
            limit,
        } = self.lower_bound()?;
        let mut test = |gamma: f64| -> Result<(f64, Option<Condition>), SynthesisError> {
            pairs.set(pairs.get() + 1);
            let pair = self.pair(gamma, Effort::Fast)?;
            let failed = match pair.failed {
                None => self.below_level(gamma)?,
                failed => failed,
            };
            Ok((pair.measure, failed))
        };
        if lower == 0.0 {
            return Ok(Optimum {
                gamma: self.lowered_to_zero(&mut test)?,
                limit: Limit::Rounding,
            });
        }
        // Just above the axis conditions, as close as a Riccati equation can be solved in f64.
        let mut lo = (lower, -1.0);
        for step in [tol, 1e-6, 1e-5, 1e-4] {
            if step < tol {
                continue;
            }
            let gamma = lower * (1.0 + step);
            let (value, failed) = test(gamma)?;
            match failed {
                // The conditions hold here, and none holds below `lower`.
                None => {
                    let gamma = lower * (1.0 + tol);
                    return Ok(Optimum { gamma, limit });
                }
                Some(Condition::Unsolved) => {}
                Some(_) => {
                    lo = (gamma, value);
                    break;
                }
            }
        }
        if let Some(found) = self.coupled_from(lower * BEYOND, settings, pairs)? {
            return Ok(found);
        }
        let (lo, hi) = self.bracket(lo, settings.hint, &mut test)?;
        Ok(Optimum {
            gamma: narrow(lo, hi, tol, &mut test)?,
            limit: Limit::Coupling,
        })
    }

    /// The largest of the bounds that need no Riccati equation at a level.
    fn lower_bound(&self) -> Result<Optimum, NumericError> {
        let [control, filter] = self.levels()?;
        let sides = [
            (
                control.lower,
                Limit::ControlSide {
                    omega_rad_s: control.omega_rad_s,
                },
            ),
            (
                filter.lower,
                Limit::FilterSide {
                    omega_rad_s: filter.omega_rad_s,
                },
            ),
        ];
        let first = Optimum {
            gamma: self.coupling_level,
            limit: Limit::Coupling,
        };
        Ok(sides.into_iter().fold(first, |largest, (gamma, limit)| {
            match gamma > largest.gamma {
                true => Optimum { gamma, limit },
                false => largest,
            }
        }))
    }

    /// An infimum of zero is not attained: the level is lowered as long as the conditions hold, to a floor.
    fn lowered_to_zero(
        &self,
        test: &mut dyn FnMut(f64) -> Result<(f64, Option<Condition>), SynthesisError>,
    ) -> Result<f64, SynthesisError> {
        let size =
            1.0 + self.normal.d11.norm_l2() + self.normal.b1.norm_l2() * self.normal.c1.norm_l2();
        let mut best = None;
        // Sixteen decades below the size of the data there is nothing but rounding.
        for k in 0..16 {
            let gamma = size * 10f64.powi(-k);
            match test(gamma)?.1 {
                None => best = Some(gamma),
                Some(condition) => {
                    return best.ok_or(SynthesisError::NoLevel { gamma, condition });
                }
            }
        }
        best.ok_or(SynthesisError::NoLevel {
            gamma: size,
            condition: Condition::Unsolved,
        })
    }

    /// A feasible level above `lo`.
    fn bracket(
        &self,
        mut lo: (f64, f64),
        hint: Option<f64>,
        test: &mut dyn FnMut(f64) -> Result<(f64, Option<Condition>), SynthesisError>,
    ) -> Result<((f64, f64), (f64, f64)), SynthesisError> {
        let lowest = lo.0;
        let mut ratio = 1.5f64;
        let mut gamma = match hint {
            Some(g) if g > lo.0 * 1.0001 && g < 1e3 * lo.0 => g * 1.001,
            _ => lo.0 * ratio,
        };
        let mut condition = Condition::Unsolved;
        // 1e12 above a lower bound: a problem that needs more is out of the range of f64.
        while gamma < 1e12 * lo.0.max(f64::MIN_POSITIVE) || ratio < 10.0 {
            let (value, failed) = test(gamma)?;
            match failed {
                None => return Ok((lo, (gamma, value))),
                Some(c) => {
                    condition = c;
                    lo = (gamma, value);
                }
            }
            ratio = (ratio * ratio).min(100.0);
            gamma *= ratio;
            if !gamma.is_finite() || gamma > 1e14 * lowest {
                break;
            }
        }
        Err(SynthesisError::NoLevel { gamma, condition })
    }
}

/// Root of the measure in log γ by inverse quadratic interpolation inside a bracket, bisection where that is not safe
/// (Chandrupatla 1997). Returns the feasible end.
fn narrow(
    lo: (f64, f64),
    hi: (f64, f64),
    tol: f64,
    test: &mut dyn FnMut(f64) -> Result<(f64, Option<Condition>), SynthesisError>,
) -> Result<f64, SynthesisError> {
    // Bisection alone needs 40 steps from a ratio of 100 to 1e-9.
    const STEPS: usize = 100;
    // A feasible measure counts as positive whatever its rounding, an infeasible one as negative.
    let signed = |value: f64, feasible: bool| {
        if feasible {
            value.clamp(f64::MIN_POSITIVE, 10.0)
        } else {
            value.min(-f64::MIN_POSITIVE)
        }
    };
    let mut new = (lo.0.ln(), signed(lo.1, false));
    let mut old = (hi.0.ln(), signed(hi.1, true));
    let mut best = hi.0;
    let mut fraction = 0.5;
    for _ in 0..STEPS {
        let x = new.0 + fraction * (old.0 - new.0);
        let gamma = x.exp();
        let (value, failed) = test(gamma)?;
        let point = (x, signed(value, failed.is_none()));
        if failed.is_none() {
            best = best.min(gamma);
        }
        let third;
        if (point.1 > 0.0) == (new.1 > 0.0) {
            third = new;
        } else {
            third = old;
            old = new;
        }
        new = point;
        let width = (old.0 - new.0).abs();
        if width <= tol {
            break;
        }
        let xi = (new.0 - old.0) / (third.0 - old.0);
        let phi = (new.1 - old.1) / (third.1 - old.1);
        let smooth = phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi;
        fraction = if smooth {
            new.1 / (old.1 - new.1) * third.1 / (old.1 - third.1)
                + (third.0 - new.0) / (old.0 - new.0) * new.1 / (third.1 - new.1) * old.1
                    / (third.1 - old.1)
        } else {
            0.5
        };
        // Half a tolerance past the root closes the bracket from the other side.
        let margin = 0.5 * tol / width;
        fraction = if fraction.is_finite() {
            fraction.clamp(margin, 1.0 - margin)
        } else {
            0.5
        };
    }
    Ok(best)
}
