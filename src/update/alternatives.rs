//! What else than a modulus the frequencies ask for, where no moduli explain them: density or diameter of a region, the
//! discs, the springs that the rotor stands on, the negative stiffness of the magnets, each as one factor beside the
//! moduli.
//!
//! About the best moduli: with r₀ = r − Jθ the residuals at the moduli of the file, J their sensitivities, C the prior
//! of θ and S = diag σ² + J C Jᵀ, a parameter with sensitivities j and the prior deviation s of the logarithm x of its
//! factor moves by −(jᵀS⁻¹r₀ + x/s²)/(jᵀS⁻¹j + 1/s²) to first order. The one that lowers χ² most is taken on: the
//! moduli are fitted again beside its factor, which is refined from there; its own x²/s² counts in χ².

use super::UpdateError;
use super::problem::{UpdateEvaluation, UpdateProblem};
use super::targets::{Target, Targets};
use crate::linalg::{Mat, solve};
use crate::rotor::{Rotor, Section};

/// A parameter, the factor on it that fits best, and what it leaves.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Alternative {
    /// As a sentence has it.
    pub(super) what: String,
    /// Factor on its value in the file.
    pub(super) factor: f64,
    /// χ² with it and the moduli that go with it.
    pub(super) statistic: f64,
}

/// Relative step of the differences: a per cent moves a frequency by half of that at most, and far more than rounding.
const STEP: f64 = 0.01;
/// Largest |ln factor| of one step: beyond, first order tells nothing.
const LONGEST_STEP: f64 = 0.5;
/// Fits of the moduli beside a factor: the first is near, the others refine.
const ROUNDS: usize = 3;

/// A parameter beside the moduli.
enum Parameter<'a> {
    Density(&'a str),
    Diameter(&'a str),
    Discs,
    Supports,
    Magnets,
}

impl Parameter<'_> {
    fn words(&self) -> String {
        match self {
            Self::Density(region) => format!("the density of region {region}"),
            Self::Diameter(region) => format!("the outer diameter of region {region}"),
            Self::Discs => "mass and inertia of the discs".to_owned(),
            Self::Supports => "the stiffness of the supports".to_owned(),
            Self::Magnets => "the negative stiffness of the magnets".to_owned(),
        }
    }

    /// Standard deviation of the logarithm of its factor before the data: drawings give diameters to a few per cent
    /// with what sits on them, densities and discs to a tenth, magnets to the 5 to 10 % of their constants; supports
    /// are known to their size.
    fn spread(&self) -> f64 {
        match self {
            Self::Diameter(_) => 0.05,
            Self::Density(_) | Self::Discs | Self::Magnets => 0.1,
            Self::Supports => 1.0,
        }
    }

    /// Rotor and targets with the parameter multiplied; none where there is no such parameter.
    fn apply(&self, rotor: &Rotor, targets: &Targets, factor: f64) -> Result<Option<(Rotor, Targets)>, UpdateError> {
        let of_region = |name: &str, change: &dyn Fn(&mut Section)| {
            rotor.with_sections(|section| {
                if section.region.as_deref() == Some(name) {
                    change(section);
                }
            })
        };
        let rotor = match self {
            Self::Density(name) => of_region(name, &|section| section.material.density_kg_m3 *= factor)?,
            Self::Diameter(name) => of_region(name, &|section| {
                section.outer_diameter_m = section.outer_diameter_m.map(|d| d * factor);
                section.mass_outer_diameter_m = section.mass_outer_diameter_m.map(|d| d * factor);
            })?,
            Self::Discs => match rotor.with_disc_factor(factor) {
                Some(rotor) => rotor,
                None => return Ok(None),
            },
            Self::Supports if targets.springs.is_empty() => return Ok(None),
            Self::Supports => {
                let springs = targets.springs.iter().map(|(z, k)| (*z, k * factor)).collect();
                return Ok(Some((rotor.clone(), Targets { springs, ..targets.clone() })));
            }
            Self::Magnets => return Ok(with_magnets(targets, factor).map(|targets| (rotor.clone(), targets))),
        };
        Ok(Some((rotor, targets.clone())))
    }
}

/// Readings are free of the magnets: what their stiffness had shifted them by, which is in proportion to it, changes.
fn with_magnets(targets: &Targets, factor: f64) -> Option<Targets> {
    let mut changed = targets.clone();
    let zeros = changed.antiresonances.iter_mut().flat_map(|frf| &mut frf.antiresonances);
    let mut any = false;
    for target in zeros.chain(&mut changed.resonances).flatten() {
        let Target { frequency_hz, magnet_shift_hz, .. } = target;
        any |= *magnet_shift_hz != 0.0;
        *frequency_hz += (factor - 1.0) * *magnet_shift_hz;
        *magnet_shift_hz *= factor;
    }
    any.then_some(changed)
}

/// A fit of the moduli: its problem, its end and its χ².
pub(super) struct ModuliFit {
    pub(super) problem: UpdateProblem,
    pub(super) end: UpdateEvaluation,
    pub(super) statistic: f64,
}

/// Standard deviations of the peaks, root of the prior covariance, and the fit of the moduli of another rotor.
pub(super) struct Refit<'a> {
    pub(super) sigma: &'a [f64],
    pub(super) root: &'a Mat<f64>,
    pub(super) fit: &'a dyn Fn(&Rotor, &Targets) -> Result<ModuliFit, UpdateError>,
}

impl Refit<'_> {
    /// Step in ln factor of a parameter about a fit of the moduli, and χ² after it, both to first order. `prior` is ln
    /// factor so far and its standard deviation.
    fn step(
        &self,
        about: &ModuliFit,
        changed: &UpdateEvaluation,
        prior: (f64, f64),
    ) -> Result<(f64, f64), UpdateError> {
        let ModuliFit { problem, end, .. } = about;
        let used: Vec<usize> = (0..end.compared.len())
            .filter(|i| {
                problem.peaks[*i].used && end.compared[*i].model.is_some() && changed.compared[*i].model.is_some()
            })
            .collect();
        let n = end.ln_factors.len();
        let weighted =
            |value: &dyn Fn(usize) -> f64| -> Vec<f64> { used.iter().map(|i| value(*i) / self.sigma[*i]).collect() };
        let residual = weighted(&|i| {
            let along: f64 = end.compared[i].sensitivity.iter().zip(&end.ln_factors).map(|(j, x)| j * x).sum();
            end.compared[i].residual_ln - along
        });
        let change = weighted(&|i| (changed.compared[i].residual_ln - end.compared[i].residual_ln) / STEP.ln_1p());
        let count = used.len();
        let spread =
            Mat::from_fn(count, n, |i, k| end.compared[used[i]].sensitivity[k] / self.sigma[used[i]]) * self.root;
        let spread = &spread * spread.transpose();
        let covariance = Mat::from_fn(count, count, |i, j| spread[(i, j)] + if i == j { 1.0 } else { 0.0 });
        let solved = solve(&covariance, &Mat::from_fn(count, 2, |i, k| [&residual, &change][k][i]))?;
        let product = |a: &[f64], k: usize| (0..count).map(|i| a[i] * solved[(i, k)]).sum::<f64>();
        let (ln_factor, spread) = prior;
        let weight = (spread * spread).recip();
        let (along, curvature) = (product(&change, 0) + ln_factor * weight, product(&change, 1) + weight);
        let given = product(&residual, 0) + ln_factor * ln_factor * weight;
        Ok((-along / curvature, given - along * along / curvature))
    }

    /// What a per cent of a parameter changes where `factor` of it is there already.
    fn step_of(
        &self,
        parameter: &Parameter<'_>,
        given: (&Rotor, &Targets),
        factor: f64,
        about: &ModuliFit,
    ) -> Result<Option<(f64, f64)>, UpdateError> {
        let Some((rotor, targets)) = parameter.apply(given.0, given.1, factor * (1.0 + STEP))? else {
            return Ok(None);
        };
        let changed = UpdateProblem::new(&rotor, &targets, true)?.evaluate(&about.end.ln_factors, false);
        self.step(about, &changed, (factor.ln(), parameter.spread())).map(Some)
    }

    /// The parameter that lowers the χ² of the best moduli most; none where no step is within first order.
    pub(super) fn best_alternative(
        &self,
        rotor: &Rotor,
        targets: &Targets,
        moduli: ModuliFit,
    ) -> Result<Option<Alternative>, UpdateError> {
        let given = (rotor, targets);
        let regions: Vec<String> = moduli.problem.chain.regions.iter().map(|region| region.name.clone()).collect();
        let of_regions = regions.iter().flat_map(|name| [Parameter::Density(name), Parameter::Diameter(name)]);
        let all = of_regions.chain([Parameter::Discs, Parameter::Supports, Parameter::Magnets]);
        let mut best: Option<(Parameter<'_>, f64, f64)> = None;
        for parameter in all {
            let Some((step, statistic)) = self.step_of(&parameter, given, 1.0, &moduli)? else { continue };
            if step.abs() < LONGEST_STEP && best.as_ref().is_none_or(|(.., least)| statistic < *least) {
                best = Some((parameter, step, statistic));
            }
        }
        let Some((parameter, mut step, _)) = best else { return Ok(None) };
        let mut found: Option<Alternative> = None;
        let mut factor = 1.0;
        for _ in 0..ROUNDS {
            factor *= step.exp();
            let Some((rotor, targets)) = parameter.apply(rotor, targets, factor)? else { break };
            let fit = (self.fit)(&rotor, &targets)?;
            let statistic = fit.statistic + (factor.ln() / parameter.spread()).powi(2);
            if found.as_ref().is_some_and(|found| found.statistic <= statistic) {
                break;
            }
            found = Some(Alternative { what: parameter.words(), factor, statistic });
            match self.step_of(&parameter, given, factor, &fit)? {
                Some((next, _)) if next.abs() < LONGEST_STEP => step = next,
                _ => break,
            }
        }
        Ok(found)
    }
}
