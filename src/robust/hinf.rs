//! H∞ synthesis: the smallest γ for which a controller u = K y with ‖F_l(P, K)‖∞ < γ exists, and that controller.
//! Conditions at γ (Glover and Doyle 1988): γ above the feedthrough bound, no axis eigenvalue of either Hamiltonian,
//! X ≥ 0, Y ≥ 0, ρ(XY) < γ². All five are tested; stability of the closed loop alone proves nothing.
//!
//! Search: the first two conditions are peaks of lower bounds over frequency, found directly without Riccati equations
//! (hinf_level). X and Y fall with γ, so √ρ(X₂Y₂) of the γ = ∞ solutions is one more lower bound. If the rest holds just
//! above the largest lower bound, that is the optimum; otherwise a bracketed secant on γ²/ρ(XY) − 1 finds it.
//! The controller is delivered slightly above the optimum, where I − YX/γ² is invertible, and is verified by closing the
//! loop and computing its norm.

use super::assumptions::explain;
use super::error::{Condition, SynthesisError};
use super::hinf_controller::central;
use super::hinf_level::{Side, control_side, filter_side};
use super::hinf_normal::NormalForm;
use crate::augment::GeneralizedPlant;
use crate::linalg::riccati::Effort;
use crate::linalg::{Mat, NumericError, symmetric_eigen};
use crate::lti::connect::lower_lft;
use crate::lti::level_set::Peak;
use crate::lti::norm::{NormError, hinf_norm};
use crate::lti::{Continuous, StateSpace};

/// What to search for and how closely.
#[derive(Clone, Debug)]
pub struct HinfSettings {
    /// Level of the central controller; none: search the optimum.
    pub gamma: Option<f64>,
    /// Relative tolerance of the optimum.
    pub rel_tol: f64,
    /// The controller is delivered at γ_opt·(1 + slack), or further off when that one fails its check.
    pub slack: f64,
    /// A level near the optimum, from an earlier similar problem; saves evaluations, changes no result.
    pub hint: Option<f64>,
}

impl Default for HinfSettings {
    fn default() -> Self {
        Self {
            gamma: None,
            rel_tol: 1e-7,
            slack: 1e-3,
            hint: None,
        }
    }
}

/// Margins and residuals at the level of the delivered controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate {
    /// Smallest level that the control Hamiltonian and D11 allow.
    pub control_level: f64,
    /// Its frequency, rad/s.
    pub control_omega_rad_s: f64,
    /// Smallest level that the filter Hamiltonian and D11 allow.
    pub filter_level: f64,
    /// Its frequency, rad/s.
    pub filter_omega_rad_s: f64,
    /// Relative residual of X.
    pub x_residual: f64,
    /// Relative residual of Y.
    pub y_residual: f64,
    /// Smallest eigenvalue of X relative to the largest.
    pub x_min: f64,
    /// Smallest eigenvalue of Y relative to the largest.
    pub y_min: f64,
    /// ρ(XY)/γ², below one.
    pub coupling: f64,
    /// Largest growth rate of the closed loop, 1/s.
    pub growth_rate: f64,
    /// Riccati pairs solved in the search.
    pub pairs: usize,
}

/// Controller with its levels.
#[derive(Clone, Debug)]
pub struct HinfSolution {
    /// u = K y.
    pub controller: StateSpace<Continuous>,
    /// Level of the controller: that of its Riccati equations, or the verified norm where rounding put it above.
    pub gamma: f64,
    /// Optimal level (feasible end of the bracket); the level given, when one was given.
    pub gamma_opt: f64,
    /// Norm of the closed loop, computed independently.
    pub closed_loop_norm: f64,
    /// Frequency of that norm, rad/s.
    pub closed_loop_peak_rad_s: f64,
    /// Margins and residuals.
    pub certificate: Certificate,
}

/// Synthesis for a generalized plant.
///
/// # Errors
/// [`SynthesisError`] names the assumption, the condition or the check that fails.
pub fn synthesise(
    plant: &GeneralizedPlant,
    settings: &HinfSettings,
) -> Result<HinfSolution, SynthesisError> {
    let search = Search::new(plant)?;
    let mut pairs = 0;
    if let Some(gamma) = settings.gamma {
        let found = search.deliver(plant, gamma, gamma, &mut pairs)?;
        return match found.closed_loop_norm > gamma * (1.0 + 2.0 * LEVEL_TOL) {
            true => Err(refuted(gamma, &found)),
            false => Ok(found),
        };
    }
    let gamma_opt = search.optimum(settings, &mut pairs)?;
    let mut failure = SynthesisError::NoLevel {
        gamma: gamma_opt,
        condition: Condition::Unsolved,
    };
    for slack in LADDER {
        let slack = slack.max(settings.slack);
        let gamma = gamma_opt * (1.0 + slack);
        match search.deliver(plant, gamma_opt, gamma, &mut pairs) {
            // Rounding in a nearly singular problem can leave the loop above its level: the level is then the norm.
            Ok(found) if found.gamma <= gamma_opt * (1.0 + slack.max(CLOSE)) => return Ok(found),
            Ok(found) => failure = refuted(gamma, &found),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// Distances from the optimum at which a controller is formed; a larger one is taken only when the smaller ones fail
/// their check, which happens on plants near the end of what f64 can hold.
const LADDER: [f64; 6] = [0.0, 1e-3, 3e-3, 9e-3, 5e-2, 2e-1];

/// Distance from the optimum within which a verified norm is as good as the level aimed at.
const CLOSE: f64 = 9.9e-3;

fn refuted(gamma: f64, found: &HinfSolution) -> SynthesisError {
    SynthesisError::Refuted {
        gamma,
        norm: found.closed_loop_norm,
        growth_rate: found.certificate.growth_rate,
    }
}

/// The optimal level alone, without a controller: for searches over weights and scales.
///
/// # Errors
/// As [`synthesise`].
pub fn optimal_level(
    plant: &GeneralizedPlant,
    settings: &HinfSettings,
) -> Result<f64, SynthesisError> {
    Search::new(plant)?.optimum(settings, &mut 0)
}

/// Relative tolerance of the level peaks and of the verified norm.
const LEVEL_TOL: f64 = 1e-9;

struct Search {
    normal: NormalForm,
    control: Side,
    filter: Side,
    control_level: Peak,
    filter_level: Peak,
    /// √ρ(X₂Y₂).
    coupling_level: f64,
    /// Largest eigenvalues of X₂ and Y₂, the scale of X and Y far from their singularities.
    sizes: [f64; 2],
}

/// X and Y at a level with everything that the conditions need.
struct Pair {
    x: Mat<f64>,
    y: Mat<f64>,
    x_residual: f64,
    y_residual: f64,
    x_min: f64,
    y_min: f64,
    /// ρ(XY)/γ².
    coupling: f64,
    /// Positive when feasible, negative when not, zero at the boundary and continuous through it.
    measure: f64,
    failed: Option<Condition>,
}

impl Search {
    fn new(plant: &GeneralizedPlant) -> Result<Self, SynthesisError> {
        let normal = NormalForm::new(plant)?;
        let (control, filter) = (control_side(&normal), filter_side(&normal));
        // The named tests are cheap and decide on exact defects; a regulator that fails later is reported as such.
        explain(&control, &filter)?;
        let regulator = |side: &Side, which| {
            side.regulator()
                .map_err(|source| SynthesisError::Regulator { which, source })
        };
        let (k, f) = (
            regulator(&control, "control")?,
            regulator(&filter, "filter")?,
        );
        let regulators = coupling(&k.x, &f.x)?;
        Ok(Self {
            control_level: control.smallest_level(&k, LEVEL_TOL)?,
            filter_level: filter.smallest_level(&f, LEVEL_TOL)?,
            coupling_level: regulators.ratio.max(0.0).sqrt(),
            sizes: regulators.extremes,
            normal,
            control,
            filter,
        })
    }

    fn lower_bound(&self) -> f64 {
        self.control_level
            .lower
            .max(self.filter_level.lower)
            .max(self.coupling_level)
    }

    /// Conditions that need no Riccati equation.
    fn below_level(&self, gamma: f64) -> Option<Condition> {
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

    fn pair(&self, gamma: f64, effort: Effort) -> Result<Pair, SynthesisError> {
        let solutions = (
            self.control.riccati(gamma, effort),
            self.filter.riccati(gamma, effort),
        );
        let (x, y) = match solutions {
            (Ok(x), Ok(y)) => (x, y),
            _ => {
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
            }
        };
        let c = coupling(&x.x, &y.x)?;
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
    fn optimum(&self, settings: &HinfSettings, pairs: &mut usize) -> Result<f64, SynthesisError> {
        let tol = settings.rel_tol.max(1e-9);
        let lower = self.lower_bound();
        let mut test = |gamma: f64| -> Result<(f64, Option<Condition>), SynthesisError> {
            *pairs += 1;
            let pair = self.pair(gamma, Effort::Fast)?;
            Ok((pair.measure, pair.failed))
        };
        if lower == 0.0 {
            return self.from_zero(&mut test);
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
    fn from_zero(
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

    fn deliver(
        &self,
        plant: &GeneralizedPlant,
        gamma_opt: f64,
        gamma: f64,
        pairs: &mut usize,
    ) -> Result<HinfSolution, SynthesisError> {
        if !(gamma.is_finite() && gamma > 0.0) {
            return Err(SynthesisError::Partition(format!(
                "gamma must be a positive number, found {gamma}"
            )));
        }
        if let Some(condition) = self.below_level(gamma) {
            return Err(SynthesisError::Infeasible { gamma, condition });
        }
        // X and Y exact to the last bit are needed for few plants, and cost more than all the rest.
        let fast = self.deliver_with(plant, gamma_opt, gamma, Effort::Fast, pairs);
        if fast.as_ref().is_ok_and(|f| f.gamma <= gamma) {
            return fast;
        }
        match (
            fast,
            self.deliver_with(plant, gamma_opt, gamma, Effort::Full, pairs),
        ) {
            (Ok(f), Ok(g)) => Ok(if f.gamma < g.gamma { f } else { g }),
            (Ok(found), Err(_)) | (_, Ok(found)) => Ok(found),
            (_, Err(error)) => Err(error),
        }
    }

    fn deliver_with(
        &self,
        plant: &GeneralizedPlant,
        gamma_opt: f64,
        gamma: f64,
        effort: Effort,
        pairs: &mut usize,
    ) -> Result<HinfSolution, SynthesisError> {
        *pairs += 1;
        let pair = self.pair(gamma, effort)?;
        if let Some(condition) = pair.failed {
            return Err(SynthesisError::Infeasible { gamma, condition });
        }
        let k = central(
            &self.normal,
            &self.control,
            &self.filter,
            gamma,
            &pair.x,
            &pair.y,
        )?;
        let controller = self.normal.original_controller(&k)?;
        let closed = lower_lft(&plant.system, &controller)?;
        let norm = match hinf_norm(&closed, LEVEL_TOL) {
            Ok(norm) => norm,
            Err(NormError::Unstable { growth_rate }) => {
                return Err(SynthesisError::Refuted {
                    gamma,
                    norm: f64::INFINITY,
                    growth_rate,
                });
            }
            Err(other) => return Err(other.into()),
        };
        let growth_rate = closed.growth_rate()?;
        // The two bounds of the norm lie 2·LEVEL_TOL apart.
        let above = norm.norm > gamma * (1.0 + 2.0 * LEVEL_TOL);
        Ok(HinfSolution {
            controller,
            gamma: if above { norm.upper } else { gamma },
            gamma_opt,
            closed_loop_norm: norm.norm,
            closed_loop_peak_rad_s: norm.peak_omega_rad_s,
            certificate: Certificate {
                control_level: self.control_level.lower,
                control_omega_rad_s: self.control_level.omega_rad_s,
                filter_level: self.filter_level.lower,
                filter_omega_rad_s: self.filter_level.omega_rad_s,
                x_residual: pair.x_residual,
                y_residual: pair.y_residual,
                x_min: pair.x_min,
                y_min: pair.y_min,
                coupling: pair.coupling,
                growth_rate,
                pairs: *pairs,
            },
        })
    }
}

/// Negative eigenvalues of X and Y relative to the largest that count as rounding. X turns indefinite through infinity,
/// so a true negative eigenvalue is a large one.
const DEFINITE: f64 = 1e-7;

struct Coupling {
    x_min: f64,
    y_min: f64,
    /// ρ(XY), or the most negative eigenvalue of XY when one of them is indefinite.
    ratio: f64,
    /// Largest eigenvalue of X and of Y, or the most negative one of an indefinite matrix.
    extremes: [f64; 2],
}

impl Coupling {
    /// γ²/ρ(XY) − 1, and what is left until X and Y pass through infinity, whichever is smaller.
    fn measure(&self, gamma: f64, sizes: [f64; 2]) -> f64 {
        let passage = |k: usize| {
            if self.extremes[k] == 0.0 {
                1.0
            } else {
                sizes[k] / self.extremes[k]
            }
        };
        let near = passage(0).min(passage(1));
        if near < 0.0 {
            return near.max(-1.0);
        }
        let coupling = gamma * gamma / self.ratio.max(1e-12 * gamma * gamma) - 1.0;
        coupling.min(near)
    }
}

/// Eigenvalues of XY through a factor of the definite one: Y = LLᵀ, eigenvalues of LᵀXL.
fn coupling(x: &Mat<f64>, y: &Mat<f64>) -> Result<Coupling, NumericError> {
    let n = x.nrows();
    if n == 0 {
        return Ok(Coupling {
            x_min: 0.0,
            y_min: 0.0,
            ratio: 0.0,
            extremes: [0.0; 2],
        });
    }
    let ((xv, xu), (yv, yu)) = (symmetric_eigen(x)?, symmetric_eigen(y)?);
    let relative = |v: &[f64]| {
        let size = v[0].abs().max(v[n - 1].abs());
        if size > 0.0 { v[0] / size } else { 0.0 }
    };
    let (x_min, y_min) = (relative(&xv), relative(&yv));
    let through = |values: &[f64], vectors: &Mat<f64>, other: &Mat<f64>| {
        let l = Mat::from_fn(n, n, |i, j| vectors[(i, j)] * values[j].max(0.0).sqrt());
        symmetric_eigen(&(l.transpose() * other * &l)).map(|(v, _)| v)
    };
    let indefinite = x_min < -DEFINITE || y_min < -DEFINITE;
    let values = if y_min >= -DEFINITE {
        through(&yv, &yu, x)?
    } else {
        through(&xv, &xu, y)?
    };
    Ok(Coupling {
        x_min,
        y_min,
        ratio: if indefinite { values[0] } else { values[n - 1] },
        extremes: [(x_min, &xv), (y_min, &yv)]
            .map(|(least, v)| if least < -DEFINITE { v[0] } else { v[n - 1] }),
    })
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
