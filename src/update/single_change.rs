//! Single changes of a rotor that hammer tests ask for, each fitted beside moduli that scatter no more than steel does:
//! modulus, density or diameter of a region, the discs, the supports, a mass somewhere on the shaft.

use super::UpdateError;
use super::alternatives::{RefinedChange, Refit, RotorParameter, of_regions};
use super::determine::prior_root;
use super::outcome::{PeakError, check_matches, chi_squared_99, peak_errors};
use super::problem::{UpdateEvaluation, UpdateProblem, UpdateSettings};
use super::targets::Targets;
use crate::linalg::Mat;
use crate::rotor::Rotor;

/// Standard deviation of ln θ: handbooks give the modulus of steels within 2 %.
const MODULUS_SD: f64 = 0.02;
/// Most places at which a mass is tried: closer ones show the same in the modes that are measured.
const MOST_PLACES: usize = 40;

/// Halvings of the distance of two nodes: to some hundredth of it, which frequencies hardly tell.
const PLACE_HALVINGS: usize = 6;

/// A change with what it leaves.
#[derive(Clone, Debug)]
pub(crate) struct FittedChange {
    /// What changes; none is the rotor as drawn.
    pub(crate) parameter: Option<RotorParameter>,
    /// Factor on it.
    pub(crate) factor: f64,
    /// χ² of the frequencies that were fitted, with the priors.
    pub(crate) statistic: f64,
    /// Sum of squares of the antiresonances that were held out, in standard deviations.
    pub(crate) held_out: f64,
    /// Factor on the modulus of every region beside it.
    pub(crate) modulus_factors: Vec<(String, f64)>,
    /// Every frequency of the file's rotor, and of the rotor with the change and those moduli.
    pub(crate) errors: Vec<PeakError>,
}

/// The rotor as drawn and all single changes.
#[derive(Clone, Debug)]
pub(crate) struct SingleChanges {
    pub(crate) as_drawn: FittedChange,
    /// The best first.
    pub(crate) changes: Vec<FittedChange>,
    /// Frequencies that were fitted, and that were held out.
    pub(crate) fitted: usize,
    pub(crate) held_out: usize,
    /// 99 % quantile of χ².
    pub(crate) limit: f64,
    /// Mass as drawn, kg.
    pub(crate) mass_kg: f64,
}

/// Fits every single change of a rotor to its frequencies; masses are tried on the shaft, from z = 0 on.
///
/// # Errors
/// [`UpdateError`] when there is nothing to fit, nothing matches, or a matrix computation fails.
pub(crate) fn single_changes(rotor: &Rotor, targets: &Targets) -> Result<SingleChanges, UpdateError> {
    let settings = UpdateSettings::default();
    let problem = UpdateProblem::new(rotor, targets, true)?;
    let n = problem.parameters();
    let drawn = problem.evaluate(&vec![0.0; n], false);
    check_matches(&problem, &drawn)?;
    let positions: Vec<f64> = problem.chain.regions.iter().map(|r| r.position_m).collect();
    let unit_root = prior_root(&positions, 1.0, settings.prior_correlation_m)?;
    let root = Mat::from_fn(n, n, |i, j| MODULUS_SD * unit_root[(i, j)]);
    let deviation = |sd: Option<f64>, hz: f64| sd.map_or(0.0, |sd| sd / hz).max(settings.floor_relative_sd);
    let of_peaks = problem.peaks.iter().map(|p| deviation(p.target.standard_deviation_hz, p.target.frequency_hz));
    let sigma: Vec<f64> = of_peaks.collect();
    let refit = Refit { sigma: &sigma, root: &root, settings: &settings };
    let moduli = refit.fit(rotor, targets)?;
    let fitted_change =
        |parameter: Option<RotorParameter>, found: &RefinedChange| change_of(parameter, found, &drawn, &sigma);
    let unchanged = RefinedChange { factor: 1.0, statistic: moduli.statistic, fit: moduli };
    let (as_drawn, moduli) = (fitted_change(None, &unchanged), &unchanged.fit);
    let mut changes = vec![];
    for parameter in parameters(rotor, &problem) {
        if let Some(found) = refit.refine(&parameter, (rotor, targets), moduli)? {
            changes.push(fitted_change(Some(parameter), &found));
        }
    }
    changes.sort_by(|a, b| a.statistic.total_cmp(&b.statistic));
    // A mass need not sit on a node: the best place is sought between those beside it, by halving steps.
    if let Some(FittedChange { parameter: Some(RotorParameter::Mass(place_m)), .. }) = changes.first().cloned() {
        let mut step_m = (rotor.to_m() - rotor.from_m()) / MOST_PLACES.min(rotor.node_positions_m().len()) as f64;
        let mut best_m = place_m;
        for _ in 0..PLACE_HALVINGS {
            step_m /= 2.0;
            for trial_m in [best_m - step_m, best_m + step_m] {
                let parameter = RotorParameter::Mass(trial_m);
                let inside = (rotor.from_m().max(0.0)..=rotor.to_m()).contains(&trial_m);
                let found = if inside { refit.refine(&parameter, (rotor, targets), moduli)? } else { None };
                if let Some(found) = found.filter(|found| found.statistic < changes[0].statistic) {
                    best_m = trial_m;
                    changes.insert(0, fitted_change(Some(parameter), &found));
                }
            }
        }
    }
    let fitted = problem.peaks.iter().filter(|p| p.used).count();
    Ok(SingleChanges {
        as_drawn,
        changes,
        fitted,
        held_out: problem.peaks.len() - fitted,
        limit: chi_squared_99(fitted),
        mass_kg: rotor.mass_properties().mass_kg,
    })
}

/// Everything that is tried.
fn parameters(rotor: &Rotor, problem: &UpdateProblem) -> Vec<RotorParameter> {
    let moduli = problem.chain.regions.iter().map(|region| RotorParameter::Modulus(region.name.clone()));
    let mut places: Vec<f64> = rotor.node_positions_m().iter().copied().filter(|z| *z >= 0.0).collect();
    places.dedup();
    let every = places.len().div_ceil(MOST_PLACES).max(1);
    let masses = places.into_iter().step_by(every).map(RotorParameter::Mass);
    let parts = [RotorParameter::Discs, RotorParameter::Supports];
    moduli.chain(of_regions(problem)).chain(parts).chain(masses).collect()
}

fn change_of(
    parameter: Option<RotorParameter>,
    found: &RefinedChange,
    drawn: &UpdateEvaluation,
    sigma: &[f64],
) -> FittedChange {
    let RefinedChange { factor, statistic, fit } = found;
    let each = fit.problem.peaks.iter().zip(&fit.end.compared).zip(sigma);
    let unseen = each.filter(|((peak, _), _)| !peak.used);
    let held_out = unseen.fold(0.0, |sum, ((_, own), s)| sum + (own.residual_ln / s).powi(2));
    let regions = fit.problem.chain.regions.iter().zip(&fit.end.ln_factors);
    FittedChange {
        parameter,
        factor: *factor,
        statistic: *statistic,
        held_out,
        modulus_factors: regions.map(|(region, x)| (region.name.clone(), x.exp())).collect(),
        errors: peak_errors(&fit.problem, [drawn, &fit.end], sigma),
    }
}
