//! μ of the whole machine closed with a controller: certified peaks, curves over frequency, D-scales asked and used.

use super::PipelineError;
use super::problems::Problems;
use super::speed_mu::SpeedMu;
use crate::augment::plane::Route;
use crate::augment::{Block, GeneralizedPlant};
use crate::lti::connect::lower_lft;
use crate::lti::{Continuous, FrequencyGrid, StateSpace};
use crate::robust::MuError;
use crate::robust::dk::DkOutcome;
use crate::robust::mu::peak::MuPeak;
use crate::robust::mu::system::MuSystem;
use crate::robust::prescale::scale_signals;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Peak of μ of one loop of the whole machine.
#[derive(Clone, Copy, Debug)]
pub struct PeakFigures {
    /// No frequency of the sampled problem in the w plane has a larger μ (certified), nor any line of the exact
    /// frequency responses where those were asked; infinite for an unstable loop, which has no μ.
    pub upper: f64,
    /// Largest bound that the search met in the w plane; infinite for an unstable loop.
    pub attained: f64,
    /// Lower bound at the certified peak, with a perturbation behind it.
    pub lower: f64,
    /// Frequency of the peak, Hz, in the w plane mapped back to true frequency.
    pub frequency_hz: f64,
}

impl PeakFigures {
    /// Of an unstable loop.
    const UNSTABLE: Self =
        Self { upper: f64::INFINITY, attained: f64::INFINITY, lower: f64::NAN, frequency_hz: f64::NAN };

    /// The larger of this peak and that of the exact frequency responses.
    #[must_use]
    pub(super) fn at_least(&self, exact: &SpeedMu) -> Self {
        if exact.mu > self.upper {
            return Self { upper: exact.mu, frequency_hz: exact.frequency_hz.abs(), ..*self };
        }
        *self
    }

    /// The figure to three digits, or that there is none.
    pub(crate) fn words(&self) -> String {
        mu_words(self.upper)
    }
}

/// μ to three digits, or that an unstable loop has none.
pub(crate) fn mu_words(mu: f64) -> String {
    if mu.is_finite() { format!("{mu:.3}") } else { "none (unstable loop)".to_owned() }
}

/// A stage of the controller: order and μ of the three problems.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    /// States of one plane's controller.
    pub order: usize,
    /// Specification.
    pub specification: PeakFigures,
    /// Covered problem.
    pub covered: PeakFigures,
    /// Largest bound found on the synthesis problem.
    pub synthesis: f64,
}

/// The D-scale of one uncertainty block, relative to that of the performance block.
#[derive(Clone, Debug)]
pub struct DScaleCurve {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Magnitude that minimises the bound at each line.
    pub asked: Vec<f64>,
    /// Magnitude of the scale that the synthesis used.
    pub used: Vec<f64>,
}

/// What is known of a [`Stage`] already.
#[derive(Clone, Copy, Default)]
pub(super) struct KnownStage {
    pub(super) specification: Option<PeakFigures>,
    /// Largest bound found on the synthesis problem.
    pub(super) synthesis: Option<f64>,
}

/// μ of the three problems with a controller of scaled signals.
pub(super) fn stage(
    name: &'static str,
    problems: &Problems,
    controller: &StateSpace<Continuous>,
    known: KnownStage,
) -> Result<Stage, PipelineError> {
    let certificate = |plant: &GeneralizedPlant| certify_peak(name, plant, controller, problems.period_s);
    let ((specification, covered), synthesis) = rayon::join(
        || {
            rayon::join(
                || match known.specification {
                    Some(peak) => Ok(peak),
                    None => certificate(&problems.specification),
                },
                || certificate(&problems.covered),
            )
        },
        || match known.synthesis {
            Some(mu) => Ok(Some(mu)),
            None => attained_gain(&problems.synthesis, controller),
        },
    );
    Ok(Stage {
        order: controller.order(),
        specification: specification?,
        covered: covered?,
        synthesis: synthesis?.unwrap_or(f64::INFINITY),
    })
}

/// Certified peak of μ of a problem closed with a controller of scaled signals.
///
/// # Errors
/// [`PipelineError`] when the loop is unstable or the certificate fails.
pub fn peak(
    name: &'static str,
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
) -> Result<MuPeak, PipelineError> {
    // Certified a tenth of a percent above what is attained: below the digits reported.
    close_problem(name, plant, controller)?.peak(1e-3).map_err(PipelineError::mu(name))
}

pub(super) fn close_problem(
    name: &'static str,
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
) -> Result<MuSystem, PipelineError> {
    let loop_system = lower_lft(&plant.system, controller).map_err(PipelineError::numeric(name))?;
    let blocks: &[Block] = &plant.blocks;
    MuSystem::new(&loop_system, blocks).map_err(PipelineError::mu(name))
}

pub(super) fn certify_peak(
    name: &'static str,
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
    period_s: f64,
) -> Result<PeakFigures, PipelineError> {
    match peak(name, plant, controller) {
        Ok(peak) => Ok(PeakFigures {
            upper: peak.upper,
            attained: peak.attained,
            lower: peak.bounds.lower,
            frequency_hz: true_frequency_hz(peak.omega_rad_s, period_s),
        }),
        Err(PipelineError::Mu { source: MuError::Unstable { .. }, .. }) => Ok(PeakFigures::UNSTABLE),
        Err(error) => Err(error),
    }
}

/// Largest upper bound of μ found over frequency; `None` for an unstable loop.
pub(super) fn attained_gain(
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
) -> Result<Option<f64>, PipelineError> {
    Ok(attained_at(plant, controller)?.map(|(mu, _)| mu))
}

/// As [`attained_gain`], with its frequency in rad/s.
pub(super) fn attained_at(
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
) -> Result<Option<(f64, f64)>, PipelineError> {
    const STAGE: &str = "largest bound of μ";
    match close_problem(STAGE, plant, controller) {
        Ok(system) => {
            let (top, _) = system.largest().map_err(PipelineError::mu(STAGE))?;
            Ok(Some((top.upper, top.omega_rad_s)))
        }
        Err(PipelineError::Mu { source: MuError::Unstable { .. }, .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// D-scales of the iteration's answer, asked and used.
pub(super) fn d_scales(
    problems: &Problems,
    constant: &[f64],
    outcome: &DkOutcome,
) -> Result<Vec<DScaleCurve>, PipelineError> {
    const STAGE: &str = "D-scales";
    let plant = scale_signals(&problems.posed, constant);
    let system = close_problem(STAGE, &plant, &outcome.controller)?;
    let grid = FrequencyGrid::log_hz(1.0, 0.9 * 0.5 / problems.period_s, D_POINTS);
    let points = grid
        .omega_rad_s()
        .par_iter()
        .map(|w| {
            let v = match problems.route {
                Route::Direct => 2.0 / problems.period_s * (0.5 * w * problems.period_s).tan(),
                Route::Emulation { .. } => *w,
            };
            let point = system.point(v).map_err(PipelineError::mu(STAGE))?;
            Ok((point.scaling.left, outcome.scales.magnitudes(v)))
        })
        .collect::<Result<Vec<_>, PipelineError>>()?;
    let starts: Vec<usize> = plant
        .blocks
        .iter()
        .scan(0, |at, b| {
            let start = *at;
            *at += b.cols();
            Some(start)
        })
        .collect();
    let Some((last, performance)) = starts.len().checked_sub(1).map(|k| (k, starts[k])) else {
        return Ok(vec![]);
    };
    Ok((0..last)
        .map(|k| {
            let at = starts[k];
            DScaleCurve {
                frequency_hz: grid.hz(),
                asked: points
                    .iter()
                    .map(|(d, _)| constant[k] * d[(at, at)].norm() / d[(performance, performance)].norm())
                    .collect(),
                used: points.iter().map(|(_, m)| constant[k] * m[k] / m[last]).collect(),
            }
        })
        .collect())
}

/// Points of the D-scale curves of the report.
const D_POINTS: usize = 120;

/// μ over true frequency: Hz, upper, lower, on a log grid with the peak.
pub(super) fn mu_curve(
    plant: &GeneralizedPlant,
    controller: &StateSpace<Continuous>,
    peak: &PeakFigures,
    period_s: f64,
) -> Result<Vec<(f64, f64, f64)>, PipelineError> {
    const STAGE: &str = "μ over frequency";
    // An unstable loop has no μ.
    if !peak.upper.is_finite() {
        return Ok(vec![]);
    }
    let system = close_problem(STAGE, plant, controller)?;
    let nyquist_hz = 0.5 / period_s;
    let grid = FrequencyGrid::log_hz(1.0, 0.98 * nyquist_hz, CURVE_POINTS);
    let mut lines: Vec<f64> = grid.hz();
    lines.push(peak.frequency_hz);
    lines.retain(|f| *f < nyquist_hz);
    lines.sort_by(f64::total_cmp);
    lines
        .par_iter()
        .map(|f| {
            let omega = 2.0 / period_s * (0.5 * TAU * f * period_s).tan();
            let bounds = system.bounds(omega).map_err(PipelineError::mu(STAGE))?;
            Ok((*f, bounds.upper, bounds.lower))
        })
        .collect()
}

/// Points of the μ curves of the report.
const CURVE_POINTS: usize = 160;

/// True frequency of a point of the w plane: ω = (2/T) atan(vT/2).
pub(crate) fn true_frequency_hz(w_plane_rad_s: f64, period_s: f64) -> f64 {
    2.0 / period_s * (0.5 * w_plane_rad_s * period_s).atan() / TAU
}
