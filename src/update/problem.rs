//! The comparison of one candidate with the data: matched peaks, residuals ln(f/f̂) and their analytic sensitivities.
//!
//! With mass-normalised φ at a pole and x = A⁻¹b, w = A⁻¹c at a zero (A = K − λM, cᵀx = 0; the right and left vectors
//! of the pencil [[K − λM, b], [cᵀ, 0]]):  ∂λ/∂θᵣ = φᵀKᵣφ  and  ∂λ/∂θᵣ = wᵀKᵣx / wᵀMx;  ∂ln f/∂ln θᵣ = θᵣ ∂λ/∂θᵣ / 2λ.

use super::UpdateError;
use super::matching::{align, warp};
use super::peak_kind::PeakKind;
use super::targets::{Target, Targets};
use crate::rotor::Rotor;
use crate::rotor::chain::{Chain, ChainFactor, ChainPort};
use crate::rotor::chain_assembly;
use crate::rotor::spectrum::{ModalSpectrum, Query, lambda, lowest_hz, spectrum};

/// A zero this close to a pole (relative) hardly shows in a Bode plot and may have been overlooked; beside a pole that
/// the model does not have it is the other half of what that mode adds.
const SHALLOW: f64 = 0.02;
/// Residual, in ln f, of a measured peak without partner in the model.
pub(super) const MISSING_LN: f64 = 0.4;

/// Options of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct UpdateSettings {
    /// Standard deviation of ln θ before seeing data. Default ln 3: a region may be three times stiffer or softer than
    /// its drawing (laminations, tapers, shrink fits), which leaves the data in charge wherever they say anything.
    pub prior_sd_ln: f64,
    /// Distance over which factors of neighbouring regions go together, m: ρ = exp(−|Δz|/length). Default 10 mm.
    pub prior_correlation_m: f64,
    /// Smallest relative standard deviation of a measured frequency that is believed: below it lies what two ways of
    /// reading the same peak differ by. Default 2e-4.
    pub floor_relative_sd: f64,
    /// `false` fits resonances only, as in the published case study; antiresonances are still reported.
    pub use_antiresonances: bool,
    /// Limit on model evaluations of Gauss–Newton. Default 30.
    pub max_evaluations: usize,
    /// Exponent of a resonance error in Eq. (7), errors in Hz. Default 2.
    pub resonance_exponent: f64,
    /// Exponent of an antiresonance error in Eq. (7). Default 2.
    pub antiresonance_exponent: f64,
    /// Iterations of Nelder–Mead in all. Default 500.
    pub iterations: usize,
    /// Number of simplexes Nelder–Mead starts, one after the other, each at the best point so far. Default 8.
    pub simplexes: usize,
}

impl Default for UpdateSettings {
    fn default() -> Self {
        Self {
            prior_sd_ln: 3f64.ln(),
            prior_correlation_m: 0.010,
            floor_relative_sd: 2e-4,
            use_antiresonances: true,
            max_evaluations: 30,
            resonance_exponent: 2.0,
            antiresonance_exponent: 2.0,
            iterations: 500,
            simplexes: 8,
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct MeasuredPeak {
    pub kind: PeakKind,
    /// FRF for an antiresonance.
    pub frf: usize,
    /// Place in its list of targets, from 0.
    pub index: usize,
    pub target: Target,
    /// Whether the fit uses it.
    pub used: bool,
}

/// A measured peak beside the model.
#[derive(Clone, Debug)]
pub(super) struct ComparedPeak {
    /// Place in the model's list and its frequency, Hz.
    pub model: Option<(usize, f64)>,
    /// ln(f/f̂), or [`MISSING_LN`].
    pub residual_ln: f64,
    /// ∂ln f/∂ln θ, one entry per region; empty when not asked for.
    pub sensitivity: Vec<f64>,
}

/// A candidate with everything computed for it.
#[derive(Clone, Debug)]
pub(super) struct UpdateEvaluation {
    pub ln_factors: Vec<f64>,
    pub spectrum: ModalSpectrum,
    /// In the order of [`UpdateProblem::peaks`].
    pub compared: Vec<ComparedPeak>,
}

/// Chain, ports and peaks of a fit.
#[derive(Clone, Debug)]
pub(super) struct UpdateProblem {
    pub chain: Chain,
    pub peaks: Vec<MeasuredPeak>,
    pub frf_names: Vec<String>,
    query: Query,
    targets: Targets,
}

impl UpdateProblem {
    pub(super) fn new(rotor: &Rotor, targets: &Targets, use_zeros: bool) -> Result<Self, UpdateError> {
        let mut chain = chain_assembly::chain(rotor)?;
        for (position_m, n_per_m) in &targets.springs {
            chain = chain.with_spring(&chain_assembly::port(rotor, "support", *position_m)?, *n_per_m);
        }
        if chain.regions.is_empty() {
            return Err(UpdateError::NoRegions);
        }
        if targets.count(use_zeros) == 0 {
            let what = if use_zeros { "resonances and antiresonances" } else { "resonances" };
            return Err(UpdateError::NoTargets { what });
        }
        let mut targets = targets.clone();
        sort_ascending(&mut targets.resonances);
        for frf in &mut targets.antiresonances {
            sort_ascending(&mut frf.antiresonances);
        }
        let mut peaks = vec![];
        let mut collect = |list: &[Option<Target>], kind, frf, used, what: &str| {
            for (index, target) in list.iter().enumerate() {
                let Some(target) = *target else { continue };
                if !(target.frequency_hz.is_finite() && target.frequency_hz > 0.0) {
                    return Err(UpdateError::BadTarget { what: what.to_owned(), frequency_hz: target.frequency_hz });
                }
                peaks.push(MeasuredPeak { kind, frf, index, target, used });
            }
            Ok(())
        };
        collect(&targets.resonances, PeakKind::Resonance, 0, true, "resonances")?;
        let mut frfs: Vec<(ChainPort, ChainPort)> = vec![];
        for (k, frf) in targets.antiresonances.iter().enumerate() {
            collect(&frf.antiresonances, PeakKind::Antiresonance, k, use_zeros && !frf.held_out, &frf.name)?;
            frfs.push((
                chain_assembly::port(rotor, "displacement of an FRF", frf.output_m)?,
                chain_assembly::port(rotor, "force of an FRF", frf.input_m)?,
            ));
        }
        // On springs the rigid modes are measured as well: from an octave below the lowest peak on.
        let least_hz = if targets.springs.is_empty() { f64::INFINITY } else { 0.5 * targets.lowest_hz() };
        let from_hz = lowest_hz(rotor)?.min(least_hz);
        let query = Query {
            frfs,
            from_hz,
            // Moduli up to 2.5 times too high still show every measured peak at the start.
            to_hz: (1.6 * targets.highest_hz()).max(2.0 * from_hz),
        };
        let frf_names = targets.antiresonances.iter().map(|f| f.name.clone()).collect();
        Ok(Self { chain, peaks, frf_names, query, targets })
    }

    pub(super) fn parameters(&self) -> usize {
        self.chain.regions.len()
    }

    /// Solves the model once; sensitivities on demand.
    pub(super) fn evaluate(&self, ln_factors: &[f64], sensitivities: bool) -> UpdateEvaluation {
        let factors: Vec<f64> = ln_factors.iter().map(|x| x.exp()).collect();
        let spectrum = spectrum(&self.chain, &factors, &self.query);
        let partners = self.partners(&spectrum);
        let stiffness = sensitivities.then(|| self.chain.stiffness(&factors));
        let mut scratch = ChainFactor::new(self.chain.nodes());
        let compared = self
            .peaks
            .iter()
            .zip(partners)
            .map(|(peak, partner)| {
                let list = match peak.kind {
                    PeakKind::Resonance => &spectrum.poles_hz,
                    PeakKind::Antiresonance => &spectrum.zeros_hz[peak.frf],
                };
                let model = partner.and_then(|k| list.get(k).map(|f| (k, *f)));
                let sensitivity = match (&stiffness, model) {
                    (Some(stiffness), Some((k, f))) => {
                        let at = lambda(f);
                        let (left, right) = match peak.kind {
                            PeakKind::Resonance => (spectrum.shapes[k].clone(), spectrum.shapes[k].clone()),
                            PeakKind::Antiresonance => {
                                let (c, b) = &self.query.frfs[peak.frf];
                                scratch.compute(stiffness, &self.chain.mass, at);
                                (scratch.solve_port(c), scratch.solve_port(b))
                            }
                        };
                        let modal = self.chain.mass.quadratic(&left, &right);
                        let of = |(region, factor): (_, &f64)| {
                            factor * self.chain.region_energy(region, &left, &right) / (2.0 * at * modal)
                        };
                        self.chain.regions.iter().zip(&factors).map(of).collect()
                    }
                    (Some(_), None) => vec![0.0; self.parameters()],
                    (None, _) => vec![],
                };
                ComparedPeak {
                    model,
                    residual_ln: model.map_or(MISSING_LN, |(_, f)| (f / peak.target.frequency_hz).ln()),
                    sensitivity,
                }
            })
            .collect();
        UpdateEvaluation { ln_factors: ln_factors.to_vec(), spectrum, compared }
    }

    /// Whether a measured peak is a zero beside a pole that the model does not have.
    pub(super) fn is_beside_foreign_pole(&self, peak: &MeasuredPeak, at: &UpdateEvaluation) -> bool {
        let peaks = self.peaks.iter().zip(&at.compared);
        let foreign = peaks.filter(|(p, own)| p.kind == PeakKind::Resonance && own.model.is_none());
        let foreign: Vec<f64> = foreign.map(|(p, _)| p.target.frequency_hz.ln()).collect();
        peak.kind == PeakKind::Antiresonance && is_beside(peak.target.frequency_hz.ln(), &foreign)
    }

    /// Partner in the model of every peak, by the pattern of poles and zeros.
    fn partners(&self, spectrum: &ModalSpectrum) -> Vec<Option<usize>> {
        let ln = |list: &[Option<Target>]| -> Vec<Option<f64>> {
            let each = |t: &Option<Target>| t.map(|t| t.frequency_hz.ln());
            list.iter().map(each).collect()
        };
        let poles: Vec<f64> = spectrum.poles_hz.iter().map(|f| f.ln()).collect();
        let measured = ln(&self.targets.resonances);
        let of_poles = align(&measured, &poles, &[]);
        let fixed: Vec<(f64, f64)> =
            measured.iter().zip(&of_poles).filter_map(|(m, k)| Some(((*m)?, *poles.get((*k)?)?))).collect();
        let foreign: Vec<f64> =
            measured.iter().zip(&of_poles).filter_map(|(m, k)| k.is_none().then_some(*m).flatten()).collect();
        let mut of_zeros = vec![];
        for (frf, zeros) in self.targets.antiresonances.iter().zip(&spectrum.zeros_hz) {
            let own = ln(&frf.antiresonances);
            let is_of_shaft = |k: &usize| own[*k].is_none_or(|z| !is_beside(z, &foreign));
            let of_shaft: Vec<usize> = (0..own.len()).filter(is_of_shaft).collect();
            let carried: Vec<Option<f64>> = of_shaft.iter().map(|k| own[*k].map(|f| warp(&fixed, f))).collect();
            let model: Vec<f64> = zeros.iter().map(|f| f.ln()).collect();
            let depth = |z: &f64| {
                let gap = poles.iter().map(|p| (p - z).abs());
                (gap.fold(f64::INFINITY, f64::min) / SHALLOW).min(1.0)
            };
            let priority: Vec<f64> = model.iter().map(depth).collect();
            let mut partners = vec![None; own.len()];
            for (k, partner) in of_shaft.iter().zip(align(&carried, &model, &priority)) {
                partners[*k] = partner;
            }
            of_zeros.push(partners);
        }
        let of = |peak: &MeasuredPeak| match peak.kind {
            PeakKind::Resonance => of_poles[peak.index],
            PeakKind::Antiresonance => of_zeros[peak.frf][peak.index],
        };
        self.peaks.iter().map(of).collect()
    }
}

/// Ascending order; placeholders keep their place when the list ascends already, else they go last, where they say
/// least.
fn sort_ascending(list: &mut [Option<Target>]) {
    let found: Vec<f64> = list.iter().flatten().map(|t| t.frequency_hz).collect();
    if found.windows(2).all(|w| w[0] <= w[1]) {
        return;
    }
    list.sort_by(|a, b| match (a, b) {
        (Some(a), Some(b)) => a.frequency_hz.total_cmp(&b.frequency_hz),
        (Some(_), None) => std::cmp::Ordering::Less,
        (None, Some(_)) => std::cmp::Ordering::Greater,
        (None, None) => std::cmp::Ordering::Equal,
    });
}

/// Whether a zero lies beside one of some poles; all in ln f.
fn is_beside(zero: f64, poles: &[f64]) -> bool {
    poles.iter().any(|pole| (pole - zero).abs() <= SHALLOW)
}
