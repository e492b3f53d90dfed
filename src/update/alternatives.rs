//! What else than a modulus the frequencies ask for, where no moduli explain them: density or diameter of a region, the
//! discs, the springs that the rotor stands on, the negative stiffness of the magnets, each as one factor beside the
//! moduli.
//!
//! About the best moduli: with r₀ = r − Jθ the residuals at the moduli of the file, J their sensitivities, C the prior
//! of θ and S = diag σ² + J C Jᵀ, a parameter with sensitivities j and the prior deviation s of the logarithm x of its
//! factor moves by −(jᵀS⁻¹r₀ + x/s²)/(jᵀS⁻¹j + 1/s²) to first order. The one that lowers χ² most is taken on: the
//! moduli are fitted again beside its factor, which is refined from there; its own x²/s² counts in χ².

use super::UpdateError;
use super::moduli_fit::{ModuliFit, fit_moduli};
use super::problem::{UpdateEvaluation, UpdateProblem, UpdateSettings};
use super::targets::{Target, Targets};
use crate::linalg::{Mat, solve};
use crate::rotor::{Disc, Rotor, Section};

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

/// A parameter that one factor changes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RotorParameter {
    /// Young's and shear modulus of a region, beyond what moduli scatter by.
    Modulus(String),
    /// Density of a region.
    Density(String),
    /// Outer diameter of a region.
    Diameter(String),
    /// Mass and inertia of all discs.
    Discs,
    /// Stiffness of all supports.
    Supports,
    /// Negative stiffness of the magnets.
    Magnets,
    /// A point mass at a place, m, which makes the rotor heavier by the factor.
    Mass(f64),
}

/// Whether a region with its outer diameters multiplied has an element whose bore is as wide.
fn has_no_wall(rotor: &Rotor, region: &str, factor: f64) -> bool {
    let pairs = |section: &Section| {
        let stiff = section.outer_diameter_m.into_iter().zip(section.inner_diameter_m);
        let heavy = section.mass_outer_diameter_m.into_iter().zip(section.mass_inner_diameter_m);
        stiff.chain(heavy).any(|(outer, inner)| factor * outer <= inner)
    };
    rotor.sections().iter().any(|section| section.region.as_deref() == Some(region) && pairs(section))
}

impl RotorParameter {
    /// As a sentence has it.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Modulus(region) => format!("the modulus of region {region}"),
            Self::Density(region) => format!("the density of region {region}"),
            Self::Diameter(region) => format!("the outer diameter of region {region}"),
            Self::Discs => "mass and inertia of the discs".to_owned(),
            Self::Supports => "the stiffness of the supports".to_owned(),
            Self::Magnets => "the negative stiffness of the magnets".to_owned(),
            Self::Mass(position_m) => format!("a mass at {position_m:.4} m"),
        }
    }

    /// Standard deviation of the logarithm of its factor before the data: drawings give diameters to a few per cent
    /// with what sits on them, densities and discs to a tenth, magnets to the 5 to 10 % of their constants; what is
    /// forgotten weighs a tenth of the rotor at most; supports and laminated regions are known to their size.
    fn spread(&self) -> f64 {
        match self {
            Self::Diameter(_) => 0.05,
            Self::Density(_) | Self::Discs | Self::Magnets | Self::Mass(_) => 0.1,
            Self::Supports | Self::Modulus(_) => 1.0,
        }
    }

    /// Rotor and targets with the parameter multiplied; none where there is no such parameter.
    pub(super) fn apply(
        &self,
        rotor: &Rotor,
        targets: &Targets,
        factor: f64,
    ) -> Result<Option<(Rotor, Targets)>, UpdateError> {
        let of_region = |name: &str, change: &dyn Fn(&mut Section)| {
            rotor.with_sections(|section| {
                if section.region.as_deref() == Some(name) {
                    change(section);
                }
            })
        };
        let rotor = match self {
            Self::Modulus(name) => of_region(name, &|section| section.modulus_scale *= factor)?,
            Self::Density(name) => of_region(name, &|section| section.material.density_kg_m3 *= factor)?,
            Self::Diameter(name) if has_no_wall(rotor, name, factor) => return Ok(None),
            Self::Diameter(name) => of_region(name, &|section| {
                section.outer_diameter_m = section.outer_diameter_m.map(|d| d * factor);
                section.mass_outer_diameter_m = section.mass_outer_diameter_m.map(|d| d * factor);
            })?,
            Self::Mass(_) if factor < 1.0 => return Ok(None),
            Self::Mass(position_m) => {
                let mass_kg = (factor - 1.0) * rotor.mass_properties().mass_kg;
                rotor.clone().with_added_disc(point_mass(*position_m, mass_kg))?
            }
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

/// A disc without inertia.
pub(super) fn point_mass(position_m: f64, mass_kg: f64) -> Disc {
    Disc { position_m, mass_kg, polar_inertia_kg_m2: 0.0, diametral_inertia_kg_m2: 0.0 }
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

/// Standard deviations of the peaks, root of the prior covariance and options with which moduli are fitted again.
pub(super) struct Refit<'a> {
    pub(super) sigma: &'a [f64],
    pub(super) root: &'a Mat<f64>,
    pub(super) settings: &'a UpdateSettings,
}

/// A parameter with the factor that fits best, and the moduli beside it.
pub(super) struct RefinedChange {
    pub(super) factor: f64,
    /// χ² with the prior of the factor.
    pub(super) statistic: f64,
    pub(super) fit: ModuliFit,
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
        parameter: &RotorParameter,
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

    pub(super) fn fit(&self, rotor: &Rotor, targets: &Targets) -> Result<ModuliFit, UpdateError> {
        fit_moduli(rotor, targets, self.settings, self.sigma, self.root)
    }

    /// The factor of a parameter that fits best beside the moduli; none where no step is within first order.
    pub(super) fn refine(
        &self,
        parameter: &RotorParameter,
        given: (&Rotor, &Targets),
        moduli: &ModuliFit,
    ) -> Result<Option<RefinedChange>, UpdateError> {
        let mut found: Option<RefinedChange> = None;
        let mut factor = 1.0;
        for _ in 0..ROUNDS {
            let about = found.as_ref().map_or(moduli, |found| &found.fit);
            let Some((step, _)) = self.step_of(parameter, given, factor, about)? else { break };
            if step.abs() >= LONGEST_STEP {
                break;
            }
            factor *= step.exp();
            let Some((rotor, targets)) = parameter.apply(given.0, given.1, factor)? else { break };
            let fit = self.fit(&rotor, &targets)?;
            let statistic = fit.statistic + (factor.ln() / parameter.spread()).powi(2);
            if found.as_ref().is_some_and(|found| found.statistic <= statistic) {
                break;
            }
            found = Some(RefinedChange { factor, statistic, fit });
        }
        Ok(found)
    }

    /// The parameter that lowers the χ² of the best moduli most to first order, refined.
    pub(super) fn best_alternative(
        &self,
        rotor: &Rotor,
        targets: &Targets,
    ) -> Result<Option<Alternative>, UpdateError> {
        let given = (rotor, targets);
        let moduli = self.fit(rotor, targets)?;
        let mut best: Option<(RotorParameter, f64)> = None;
        let of_parts = [RotorParameter::Discs, RotorParameter::Supports, RotorParameter::Magnets];
        for parameter in of_regions(&moduli.problem).into_iter().chain(of_parts) {
            let Some((step, statistic)) = self.step_of(&parameter, given, 1.0, &moduli)? else { continue };
            if step.abs() < LONGEST_STEP && best.as_ref().is_none_or(|(_, least)| statistic < *least) {
                best = Some((parameter, statistic));
            }
        }
        let Some((parameter, _)) = best else { return Ok(None) };
        let found = self.refine(&parameter, given, &moduli)?;
        Ok(found.map(|c| Alternative { what: parameter.words(), factor: c.factor, statistic: c.statistic }))
    }
}

/// Density and outer diameter of every region of the shaft.
pub(super) fn of_regions(problem: &UpdateProblem) -> Vec<RotorParameter> {
    let names = problem.chain.regions.iter().map(|region| &region.name);
    names.flat_map(|name| [RotorParameter::Density(name.clone()), RotorParameter::Diameter(name.clone())]).collect()
}
