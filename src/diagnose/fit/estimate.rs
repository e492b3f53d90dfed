//! The most probable parameters of a set of effects: min χ²(θ, η) + Σ(η/sd)² by Levenberg–Marquardt, the model
//! error lowered in steps.

use super::super::DiagnoseError;
use super::geodesic::GaussNewtonStep;
use super::linearise::Linearised;
use super::problem::{Point, Problem};
use crate::linalg::dense::solve_normal;
use crate::linalg::{Mat, symmetric_eigen};
use crate::spindle::{Effect, EffectKind, Location};

/// Relative model error of final fits: what a fine mesh, modal damping and re-levitation leave.
pub(crate) const FINAL_MODEL_ERROR: f64 = 5e-4;

#[derive(Clone, Debug)]
pub struct Fit {
    /// Where.
    pub at: Point,
    /// χ² of the data and of the priors.
    pub chi2: f64,
    /// χ² of the data alone.
    pub data_chi2: f64,
    pub residuals: usize,
    /// JᵀJ with priors at the end, nuisance parameters first, then the effects'.
    pub information: Mat<f64>,
}

/// A step of the schedule: model error and iterations.
pub(crate) type Stage = (f64, usize);

/// Curvature of χ² that every effect's coordinate has at least in a step. A unit is a large effect, so that a
/// coordinate of which the data know nothing (the place of no mass) stays where it is, and next to priors (weights of
/// 25 to 10⁴) it is nothing.
pub(super) const UNKNOWN: f64 = 1.0;
/// Share of a place's inertia that a negative mass may take away: two of them leave some of it.
const MOST_TAKEN: f64 = 0.45;
/// Relative decrease of χ² below which an iteration ends a stage; χ² differences below 0.01 mean nothing.
const SETTLED: f64 = 1e-5;

impl Problem<'_> {
    /// A point between two that lies lower than the first: the second, or half the way, or half of that; the last of
    /// them when all lie higher (a start without any size may be no better). With its χ², which is infinite where there
    /// is no model.
    pub(crate) fn downhill(&self, from: &Point, to: &Point, model_error: f64) -> Result<(Point, f64), DiagnoseError> {
        let here = self.chi2(from, model_error)?;
        let chi2 = |at: &Point| self.chi2(at, model_error).unwrap_or(f64::INFINITY);
        let mut there = to.clone();
        let mut value = chi2(&there);
        for _ in 0..4 {
            if value < here {
                break;
            }
            let half = |a: &mut f64, b: &f64| *a = 0.5 * (*a + b);
            there.p.iter_mut().zip(&from.p).for_each(|(a, b)| half(a, b));
            for (a, b) in there.theta.iter_mut().zip(&from.theta) {
                a.iter_mut().zip(b).for_each(|(a, b)| half(a, b));
            }
            value = chi2(&there);
        }
        Ok((there, value))
    }

    pub(super) fn prior(&self, at: &Point) -> f64 {
        let sizes = self.effects.iter().zip(&at.theta).map(|(h, theta)| h.deviation(theta).0.powi(2));
        self.model.layout.prior(&at.p) + sizes.sum::<f64>()
    }

    /// Weights of the priors on the diagonal of the normal equations, and what they add to the right-hand side.
    pub(super) fn add_priors(&self, at: &Point, normal: &mut Mat<f64>, slope: &mut Mat<f64>) {
        for (k, (weight, pull)) in self.model.layout.pull(&at.p).enumerate() {
            normal[(k, k)] += weight;
            slope[(k, 0)] += pull;
        }
        let mut first = at.p.len();
        for (h, theta) in self.effects.iter().zip(&at.theta) {
            let (off, by_size) = h.deviation(theta);
            normal[(first, first)] += by_size * by_size;
            slope[(first, 0)] -= off * by_size;
            first += theta.len();
        }
    }

    /// What the amplitude of the smooth model error costs.
    pub(super) fn cost(&self, at: &Point, model_error: f64) -> Result<f64, DiagnoseError> {
        let smooth = self.smooth(model_error)?;
        Ok(smooth.map_or(0.0, |s| s.cost(at.smooth)))
    }

    /// The most probable amplitude of the smooth model error, with the residuals and derivatives that belong to it.
    fn tune_point(&self, at: &mut Point, here: &mut Linearised, model_error: f64) -> Result<(), DiagnoseError> {
        if let Some(smooth) = self.smooth(model_error)? {
            let amplitude = smooth.amplitude(&here.residual, at.smooth);
            if amplitude != at.smooth {
                smooth.apply(&mut here.residual, at.smooth, amplitude);
                here.jacobian.tune(amplitude);
                at.smooth = amplitude;
            }
        }
        Ok(())
    }

    /// χ² with priors at a point.
    ///
    /// # Errors
    /// As [`Self::residual`].
    pub fn chi2(&self, at: &Point, model_error: f64) -> Result<f64, DiagnoseError> {
        let r = self.residual(at, model_error)?;
        let data: f64 = r.iter().map(|r| r * r).sum();
        Ok(data + self.prior(at) + self.cost(at, model_error)?)
    }

    /// A point moved by a step of all parameters, kept where it makes sense.
    pub(super) fn take_step(&self, at: &Point, step: &Mat<f64>) -> Point {
        let mut there = at.clone();
        for (k, p) in there.p.iter_mut().enumerate() {
            *p += step[(k, 0)];
        }
        self.model.layout.clamp(&mut there.p);
        let mut c = there.p.len();
        for (hypothesis, theta) in self.effects.iter().zip(&mut there.theta) {
            for t in theta.iter_mut() {
                *t += step[(c, 0)];
                c += 1;
            }
            hypothesis.clamp(theta);
            let effect = hypothesis.effect(theta);
            let (value, least) = (effect.values.first(), self.lightest_kg(&effect));
            if let (Some(value), Some(least), Some(t)) = (value, least, theta.first_mut())
                && *value < least
            {
                // Masses are proportional to their coordinate.
                *t *= least / value;
            }
        }
        there
    }

    /// The least mass that a place can be given.
    pub(crate) fn lightest_kg(&self, effect: &Effect) -> Option<f64> {
        let jointed = self.effects.iter().any(|h| h.kind == EffectKind::ToolJoint);
        let position_m = match (effect.kind, &effect.location) {
            (EffectKind::ToolMass, _) => self.model.reduced.span_m().0,
            (EffectKind::AddedMass | EffectKind::AddedDisc, Location::Position(z)) => *z,
            _ => return None,
        };
        let inertia = self.model.reduced.inertia_kg(position_m, jointed).ok()?;
        Some(-MOST_TAKEN * inertia)
    }

    /// Which coordinates sit at a bound that a descent along `slope` would leave.
    fn held(&self, at: &Point, slope: &Mat<f64>) -> Vec<bool> {
        // Far below every step that matters, far above rounding.
        let nudge = Mat::from_fn(slope.nrows(), 1, |k, _| 1e-9 * slope[(k, 0)].signum());
        let moved = self.take_step(at, &nudge);
        let flat = |p: &Point| -> Vec<f64> {
            let effects = p.theta.iter().flatten();
            p.p.iter().chain(effects).copied().collect()
        };
        let both = flat(at).into_iter().zip(flat(&moved));
        both.map(|(a, b)| a == b).collect()
    }

    /// Fits from a start through stages.
    ///
    /// # Errors
    /// [`DiagnoseError`] when a model cannot be assembled.
    pub fn fit(&self, start: &Point, stages: &[Stage]) -> Result<Fit, DiagnoseError> {
        let mut at = start.clone();
        let mut end = None;
        for (model_error, iterations) in stages {
            let mut here = self.linearise_records(&at, *model_error)?;
            let mut expected = true;
            for iteration in 0..=*iterations {
                self.tune_point(&mut at, &mut here, *model_error)?;
                let cost = self.cost(&at, *model_error)?;
                let equations = self.equations(&at, &here, cost);
                let chi2 = equations.fit.chi2;
                let gain = end.replace(equations.fit.clone()).map(|before: Fit| before.chi2 - chi2);
                // The last step gained next to nothing: the point and its curvature are final.
                let still = iteration > 0 && gain.is_some_and(|g| g < negligible(chi2));
                if iteration == *iterations || still {
                    break;
                }
                let from = (&at, &here);
                let Some(next) = self.improve_point(from.0, from.1, equations, expected, *model_error)? else {
                    break;
                };
                (at, expected) = (next.there, next.whole);
                here = match next.ahead {
                    Some(ahead) => ahead,
                    None => self.linearise_records(&at, *model_error)?,
                };
            }
        }
        match end {
            Some(fit) => Ok(fit),
            None => self.keep_start(at),
        }
    }

    /// χ² of a point without a step.
    fn keep_start(&self, at: Point) -> Result<Fit, DiagnoseError> {
        let r = self.residual(&at, FINAL_MODEL_ERROR)?;
        let data: f64 = r.iter().map(|r| r * r).sum();
        let small = self.model.layout.len();
        Ok(Fit {
            chi2: data + self.prior(&at) + self.cost(&at, FINAL_MODEL_ERROR)?,
            data_chi2: data,
            residuals: r.len(),
            information: Mat::identity(small, small),
            at,
        })
    }

    /// The normal equations with priors at a point.
    pub(super) fn equations(&self, at: &Point, here: &Linearised, cost: f64) -> Equations {
        let (r, j) = (&here.residual, &here.jacobian);
        let data_chi2: f64 = r.iter().map(|r| r * r).sum();
        let mut normal = j.normal();
        let mut slope = j.transpose_times(r);
        self.add_priors(at, &mut normal, &mut slope);
        Equations {
            fit: Fit {
                at: at.clone(),
                chi2: data_chi2 + self.prior(at) + cost,
                data_chi2,
                residuals: r.len(),
                information: normal.clone(),
            },
            normal,
            slope,
        }
    }

    /// A point of smaller χ²; none where no step decreases χ² by more than a negligible part. Where the whole step is
    /// `expected` to be taken, its derivatives are computed with it.
    fn improve_point(
        &self,
        at: &Point,
        here: &Linearised,
        equations: Equations,
        expected: bool,
        model_error: f64,
    ) -> Result<Option<Improved>, DiagnoseError> {
        let Equations { fit, mut normal, mut slope } = equations;
        let (n, small, chi2) = (normal.nrows(), self.model.layout.len(), fit.chi2);
        // Coordinates at a bound do not take part: the others would be moved for what they cannot do.
        let held = self.held(at, &slope);
        for k in (0..n).filter(|k| held[*k]) {
            for l in (0..n).filter(|l| *l != k) {
                normal[(k, l)] = 0.0;
                normal[(l, k)] = 0.0;
            }
            slope[(k, 0)] = 0.0;
        }
        for k in small..n {
            normal[(k, k)] += UNKNOWN;
        }
        let Ok(whole) = solve_normal(&normal, &slope) else {
            return Ok(None);
        };
        let predicted: f64 = (0..n).map(|k| whole[(k, 0)] * slope[(k, 0)]).sum();
        if predicted < negligible(chi2) {
            return Ok(None);
        }
        let lower = |value: f64| value < chi2;
        let alone = |there: Point, whole: bool| Improved { there, ahead: None, whole };
        let there = self.take_step(at, &whole);
        if !expected {
            if self.chi2(&there, model_error).is_ok_and(lower) {
                return Ok(Some(alone(there, true)));
            }
        } else if let Ok(ahead) = self.linearise_records(&there, model_error) {
            let data: f64 = ahead.residual.iter().map(|r| r * r).sum();
            if lower(data + self.prior(&there) + self.cost(&there, model_error)?) {
                return Ok(Some(Improved { there, ahead: Some(ahead), whole: true }));
            }
        }
        let gauss_newton = GaussNewtonStep { normal: &normal, held: &held, step: &whole, chi2 };
        if let Some(there) = self.along(at, here, &gauss_newton, model_error)? {
            return Ok(Some(alone(there, false)));
        }
        // Twelve tries span twelve decades of damping; beyond, the point is a minimum to rounding.
        for damping in (0..12).map(|k| 10f64.powi(k - 6)) {
            let damped = Mat::from_fn(n, n, |a, b| normal[(a, b)] * if a == b { 1.0 + damping } else { 1.0 });
            let Ok(step) = solve_normal(&damped, &slope) else {
                continue;
            };
            let there = self.take_step(at, &step);
            if self.chi2(&there, model_error).is_ok_and(lower) {
                return Ok(Some(alone(there, false)));
            }
        }
        Ok(None)
    }
}

/// A point of smaller χ².
struct Improved {
    there: Point,
    /// Its linearisation, where that is known.
    ahead: Option<Linearised>,
    /// Whether the whole step leads there: where it did not, the next one is tried without derivatives first.
    whole: bool,
}

/// The normal equations at a point.
pub(super) struct Equations {
    /// The point with its χ².
    fit: Fit,
    /// JᵀJ with priors, n×n.
    pub(super) normal: Mat<f64>,
    /// Jᵀr with priors, n×1.
    pub(super) slope: Mat<f64>,
}

/// A decrease of χ² that means nothing.
fn negligible(chi2: f64) -> f64 {
    (SETTLED * chi2).max(0.01)
}

impl Fit {
    /// Covariance of the effects' fit coordinates; infinite variances where the data say nothing.
    pub fn covariance(&self) -> Result<Mat<f64>, DiagnoseError> {
        let n = self.information.nrows();
        let scale: Vec<f64> = (0..n).map(|i| self.information[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip()).collect();
        let unit = Mat::from_fn(n, n, |i, j| self.information[(i, j)] * scale[i] * scale[j]);
        let (values, vectors) = symmetric_eigen(&unit)?;
        Ok(Mat::from_fn(n, n, |i, j| {
            let sum: f64 = (0..n)
                // A direction below rounding is undetermined, its variance large but finite.
                .map(|k| vectors[(i, k)] * vectors[(j, k)] / values[k].max(1e-13))
                .sum();
            sum * scale[i] * scale[j]
        }))
    }
}
