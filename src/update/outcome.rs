//! The result of a fit: the updated rotor, its factors with standard deviations, the table of errors, what the data
//! determine, and whether moduli can explain the data at all.

use super::UpdateError;
use super::alternatives::Alternative;
use super::determine::Determined;
use super::peak_kind::PeakKind;
use super::problem::{MeasuredPeak, UpdateEvaluation, UpdateProblem};
use super::shapes::{self, ShapeComparison};
use super::targets::Targets;
use crate::rotor::spectrum::ModalSpectrum;
use crate::rotor::{Rotor, Section};

named! {
    /// How the factors were found.
    pub enum Method {
        /// Gauss–Newton with sensitivities and prior.
        GaussNewton = "gauss-newton",
        /// Nelder–Mead on Eq. (7).
        NelderMead = "nelder-mead",
    }
}

/// Modulus factor of one region.
#[derive(Clone, Debug, PartialEq)]
pub struct ModulusFactor {
    /// Region.
    pub region: String,
    /// Factor on E and G relative to the model that was given.
    pub factor: f64,
    /// Standard deviation of ln factor, prior and data together; `None` from Nelder–Mead.
    pub standard_deviation_ln: Option<f64>,
}

/// One row of the table of errors.
#[derive(Clone, Debug, PartialEq)]
pub struct PeakError {
    /// Resonance or antiresonance.
    pub kind: PeakKind,
    /// FRF of an antiresonance (`front`, `rear`, …); empty for a resonance.
    pub frf: String,
    /// Place in the measured list, from 1.
    pub number: usize,
    /// Measured frequency, Hz.
    pub measured_hz: f64,
    /// Relative standard deviation that the fit used.
    pub relative_sd: f64,
    /// The model before, Hz; `None` when no peak of it belongs to the measured one.
    pub before_hz: Option<f64>,
    /// The model after, Hz.
    pub after_hz: Option<f64>,
    /// Whether the fit was asked to meet it.
    pub used: bool,
}

impl PeakError {
    /// Model minus measurement, Hz.
    pub(crate) fn error_hz(&self) -> Option<f64> {
        self.after_hz.map(|f| f - self.measured_hz)
    }

    /// Model minus measurement, % of the measured frequency.
    pub fn error_percent(&self) -> Option<f64> {
        self.error_hz().map(|e| 100.0 * e / self.measured_hz)
    }
}

/// Whether moduli can explain the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// True when nothing speaks against it.
    pub explained: bool,
    /// Residuals and factors in standard deviations, squared and summed; χ² with as many degrees of freedom as data.
    pub statistic: f64,
    /// 99 % quantile of χ².
    pub limit: f64,
    /// One sentence.
    pub statement: String,
}

/// Largest frequency error, %, that passes for scatter of readings when their noise had to be estimated.
const READING_ERROR_PERCENT: f64 = 1.0;
/// Standard deviation of a reading that keeps within that error with a probability of 99 % (2.576 is its quantile).
pub(super) const READING_SD: f64 = READING_ERROR_PERCENT / 100.0 / 2.576;
/// A factor beyond this, or below its inverse, is not a modulus any more: no lamination or joint softens a section
/// tenfold, and no steel part is stiffer than its drawing by ten.
const PLAUSIBLE_FACTOR: f64 = 10.0;

impl Explanation {
    pub(super) fn judge(
        problem: &UpdateProblem,
        end: &UpdateEvaluation,
        statistic: f64,
        data: usize,
        noise_estimated: bool,
    ) -> Self {
        let limit = chi_squared_99(data);
        let used = || problem.peaks.iter().zip(&end.compared).filter(|(p, _)| p.used);
        let largest = used().map(|(_, c)| 100.0 * c.residual_ln.abs()).fold(0.0, f64::max);
        let extreme = problem.chain.regions.iter().zip(&end.ln_factors).find(|(_, x)| x.abs() > PLAUSIBLE_FACTOR.ln());
        let of_readings: f64 = used().map(|(_, c)| (c.residual_ln / READING_SD).powi(2)).sum();
        let (explained, statement) = if let Some(words) = missing_words(problem, end) {
            (false, words)
        } else if noise_estimated && largest > READING_ERROR_PERCENT && of_readings > limit {
            let s = format!(
                "the best moduli leave errors up to {largest:.2} %, more than readings scatter \
                 ({READING_ERROR_PERCENT} %): χ² = {of_readings:.1} against {limit:.1} (99 % for {data} data), the \
                 moduli cannot explain the data"
            );
            return Self { explained: false, statistic: of_readings, limit, statement: s };
        } else if !noise_estimated && statistic > limit {
            let s = format!(
                "the best moduli leave χ² = {statistic:.1} against {limit:.1} (99 % for {data} data): the moduli \
                 cannot explain the data within their noise"
            );
            (false, s)
        } else if let Some((region, x)) = extreme {
            let s = format!(
                "the moduli meet the data only with a factor of {:.3} in region {}, which no modulus has: something \
                 else is off",
                x.exp(),
                region.name
            );
            (false, s)
        } else {
            let s = format!(
                "the moduli explain the data: largest error {largest:.3} %, χ² = {statistic:.1} (99 % limit {limit:.1})"
            );
            (true, s)
        };
        Self { explained, statistic, limit, statement }
    }
}

/// Which measured peaks have no counterpart in the model, how far off the others are, and what to do; none where all
/// have one.
fn missing_words(problem: &UpdateProblem, end: &UpdateEvaluation) -> Option<String> {
    let used = || problem.peaks.iter().zip(&end.compared).filter(|(p, _)| p.used);
    let alone: Vec<String> = used()
        .filter(|(_, own)| own.model.is_none())
        .map(|(peak, _)| match peak.kind {
            PeakKind::Resonance => format!("the resonance at {:.1} Hz", peak.target.frequency_hz),
            PeakKind::Antiresonance => {
                format!("the antiresonance {} at {:.1} Hz", problem.frf_names[peak.frf], peak.target.frequency_hz)
            }
        })
        .collect();
    let met = used().filter(|(_, own)| own.model.is_some());
    let (count, largest) = met.fold((0, 0.0f64), |(n, e), (_, own)| (n + 1, e.max(100.0 * own.residual_ln.abs())));
    (!alone.is_empty()).then(|| {
        format!(
            "no counterpart in the model, whatever the moduli, of {}; the best moduli meet the other {count} within \
             {largest:.1} %: if these are peaks of the rig, of the loop or of the other plane, give those of the shaft \
             in a record of kind frequencies, else the model lacks a part",
            alone.join(", ")
        )
    })
}

impl Explanation {
    /// With what explains the data instead, or that nothing looked at does.
    pub(super) fn name_alternative(&mut self, found: Option<&Alternative>) {
        let limit = self.limit;
        self.statement += &match found {
            Some(Alternative { what, factor, statistic }) if *statistic <= limit => format!(
                "; free {what} instead: {factor:.3} times that of the file would explain them (χ² = {statistic:.1} \
                 against {limit:.1})"
            ),
            Some(Alternative { what, factor, statistic }) if 2.0 * statistic < self.statistic => format!(
                "; of density, diameter, discs and supports {what} helps most, {factor:.3} times that of the file, but \
                 does not explain them either (χ² = {statistic:.1} against {limit:.1})"
            ),
            _ => "; no single density, diameter, disc or support explains them: look for a part that the model lacks"
                .to_owned(),
        };
    }
}

/// 99 % quantile of χ² (Wilson and Hilferty 1931, good to 1 %).
pub(super) fn chi_squared_99(degrees: usize) -> f64 {
    let n = degrees.max(1) as f64;
    let c = 2.0 / (9.0 * n);
    // 2.326 is the 99 % quantile of the normal distribution.
    n * (1.0 - c + 2.326 * c.sqrt()).powi(3)
}

/// An updated model with everything one needs to judge it.
#[derive(Clone, Debug)]
pub struct Updated {
    /// Method.
    pub method: Method,
    /// The rotor with the factors applied.
    pub rotor: Rotor,
    /// Factors, in order from the tool end.
    pub factors: Vec<ModulusFactor>,
    /// Number of model solutions.
    pub evaluations: usize,
    /// Number of iterations.
    pub iterations: usize,
    /// Table of errors, resonances first.
    pub errors: Vec<PeakError>,
    /// True when the noise was estimated because no standard deviations were given.
    pub noise_estimated: bool,
    /// What the data determine.
    pub determined: Determined,
    /// Whether moduli can explain the data.
    pub explanation: Explanation,
    /// Poles, shapes and antiresonances before.
    pub before: ModalSpectrum,
    /// Poles, shapes and antiresonances after.
    pub after: ModalSpectrum,
    /// Axial positions of the nodes of the shapes, m from the nose face.
    pub node_position_m: Vec<f64>,
    /// Measured shapes beside those of the updated model.
    pub shapes: Vec<ShapeComparison>,
}

impl Updated {
    /// Factor of a region; 1 for one that the fit does not know.
    pub fn factor(&self, region: &str) -> f64 {
        self.factors.iter().find(|f| f.region == region).map_or(1.0, |f| f.factor)
    }

    /// Multiplies the moduli of the sections of a file by the factors of their regions.
    pub(crate) fn scale(&self, sections: &mut [Section]) {
        for section in sections {
            if let Some(region) = &section.region {
                section.modulus_scale *= self.factor(region);
            }
        }
    }

    /// Largest |error| in % over the peaks that the fit used; infinite when one has no counterpart.
    pub fn largest_error_percent(&self) -> f64 {
        self.errors
            .iter()
            .filter(|e| e.used)
            .map(|e| e.error_percent().map_or(f64::INFINITY, f64::abs))
            .fold(0.0, f64::max)
    }
}

pub(super) struct Finish<'a> {
    pub method: Method,
    pub start: &'a UpdateEvaluation,
    pub end: &'a UpdateEvaluation,
    pub evaluations: usize,
    pub iterations: usize,
    pub relative_sd: Vec<f64>,
    pub noise_estimated: bool,
    pub determined: Determined,
    pub explanation: Explanation,
}

pub(super) fn assemble(
    rotor: &Rotor,
    problem: &UpdateProblem,
    finish: Finish<'_>,
    targets: &Targets,
) -> Result<Updated, UpdateError> {
    let with_sd = finish.method == Method::GaussNewton;
    let factors: Vec<ModulusFactor> = problem
        .chain
        .regions
        .iter()
        .zip(&finish.end.ln_factors)
        .zip(&finish.determined.standard_deviation_ln)
        .map(|((region, x), sd)| ModulusFactor {
            region: region.name.clone(),
            factor: x.exp(),
            standard_deviation_ln: with_sd.then_some(*sd),
        })
        .collect();
    let updated = rotor.with_modulus_factors(|_, section| {
        let of = |name: &String| factors.iter().find(|f| &f.region == name);
        section.region.as_ref().and_then(of).map_or(1.0, |f| f.factor)
    })?;
    Ok(Updated {
        method: finish.method,
        errors: peak_errors(problem, [finish.start, finish.end], &finish.relative_sd),
        shapes: shapes::compare(&updated, &finish.end.spectrum, &targets.mode_shapes)?,
        rotor: updated,
        factors,
        evaluations: finish.evaluations,
        iterations: finish.iterations,
        noise_estimated: finish.noise_estimated,
        determined: finish.determined,
        explanation: finish.explanation,
        before: finish.start.spectrum.clone(),
        after: finish.end.spectrum.clone(),
        node_position_m: problem.chain.position_m.clone(),
    })
}

/// The table of errors of a model before and after, with the relative standard deviation of every peak.
pub(super) fn peak_errors(
    problem: &UpdateProblem,
    [before, after]: [&UpdateEvaluation; 2],
    relative_sd: &[f64],
) -> Vec<PeakError> {
    let hz = |e: &UpdateEvaluation, i: usize| e.compared[i].model.map(|(_, f)| f);
    let row = |((i, peak), sd): ((usize, &MeasuredPeak), &f64)| PeakError {
        kind: peak.kind,
        frf: match peak.kind {
            PeakKind::Resonance => String::new(),
            PeakKind::Antiresonance => problem.frf_names[peak.frf].clone(),
        },
        number: peak.index + 1,
        measured_hz: peak.target.frequency_hz,
        relative_sd: *sd,
        before_hz: hz(before, i),
        after_hz: hz(after, i),
        used: peak.used,
    };
    problem.peaks.iter().enumerate().zip(relative_sd).map(row).collect()
}

/// At least half of the peaks must have a partner before a fit makes sense; a foreign pole and the zero beside it are
/// one.
pub(super) fn check_matches(problem: &UpdateProblem, start: &UpdateEvaluation) -> Result<(), UpdateError> {
    let counts = |p: &MeasuredPeak| p.used && !problem.is_beside_foreign_pole(p, start);
    let used = || problem.peaks.iter().zip(&start.compared).filter(|(p, _)| counts(p));
    let (measured, matched) = (used().count(), used().filter(|(_, c)| c.model.is_some()).count());
    if 2 * matched < measured {
        return Err(UpdateError::NoMatch { matched, measured });
    }
    Ok(())
}
