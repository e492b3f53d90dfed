//! Search of the smallest feasible level of an H∞ problem.
//! Lower bounds come first: the peaks of both sides over frequency (`side`), and √ρ(X₂Y₂) of the γ = ∞ solutions,
//! since X and Y fall with γ. If the rest holds just above the largest bound, that is the optimum; otherwise the root
//! of the measure of `riccati_pair` is bracketed and interpolated: about eight Riccati pairs to 1e-7.

use super::assumptions::explain;
use super::normal::NormalForm;
use super::riccati_pair::{DEFINITE, Pair, Solved, coupling, solved};
use super::settings::HinfSettings;
use super::side::{Regulator, Side, control_side, filter_side};
use crate::augment::GeneralizedPlant;
use crate::linalg::Mat;
use crate::linalg::riccati::Effort;
use crate::lti::level_set::Peak;
use crate::robust::error::{Condition, SynthesisError};

/// Relative tolerance of the level peaks and of the verified norm.
pub(super) const LEVEL_TOL: f64 = 1e-9;

/// A problem in normal form with its lower bounds.
pub(super) struct Search {
    pub normal: NormalForm,
    pub control: Side,
    pub filter: Side,
    /// Each side at γ = ∞.
    pub control_regulator: Regulator,
    pub filter_regulator: Regulator,
    pub control_level: Peak,
    pub filter_level: Peak,
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
        let (control_level, filter_level) = rayon::join(
            || control.smallest_level(&k, LEVEL_TOL),
            || filter.smallest_level(&f, LEVEL_TOL),
        );
        Ok(Self {
            control_level: control_level?,
            filter_level: filter_level?,
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

    fn lower_bound(&self) -> f64 {
        self.control_level
            .lower
            .max(self.filter_level.lower)
            .max(self.coupling_level)
    }

    /// Conditions that need no Riccati equation.
    pub(super) fn below_level(&self, gamma: f64) -> Option<Condition> {
        for (level, control) in [(self.control_level, true), (self.filter_level, false)] {
            if gamma > level.lower {
                continue;
            }
            let (bound, omega_rad_s) = (level.lower, level.omega_rad_s);
            return Some(match (omega_rad_s.is_infinite(), control) {
                (true, _) => Condition::Feedthrough { bound },
                (false, true) => Condition::ControlAxis { bound, omega_rad_s },
                (false, false) => Condition::FilterAxis { bound, omega_rad_s },
            });
        }
        None
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
            failed: failed.or_else(|| self.below_level(gamma)),
        })
    }

    /// Smallest feasible level within the tolerance.
    pub(super) fn optimum(
        &self,
        settings: &HinfSettings,
        pairs: &mut usize,
    ) -> Result<f64, SynthesisError> {
        let tol = settings.rel_tol.max(1e-9);
        let lower = self.lower_bound();
        let mut test = |gamma: f64| -> Result<(f64, Option<Condition>), SynthesisError> {
            *pairs += 1;
            let pair = self.pair(gamma, Effort::Fast)?;
            Ok((pair.measure, pair.failed))
        };
        if lower == 0.0 {
            return self.lowered_to_zero(&mut test);
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
                None => return Ok(lower * (1.0 + tol)),
                Some(Condition::Unsolved) => {}
                Some(_) => {
                    lo = (gamma, value);
                    break;
                }
            }
        }
        let (lo, hi) = self.bracket(lo, settings.hint, &mut test)?;
        narrow(lo, hi, tol, &mut test)
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
            if !gamma.is_finite() || gamma > 1e14 * self.lower_bound() {
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
