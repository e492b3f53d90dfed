//! How far the tool's specification can be tightened, and designs with a tightened one.

use super::PipelineError;
use super::design::{Design, design_in_words};
use super::posing::pose;
use super::progress::{Event, Listener};
use super::settings::DesignSettings;
use crate::augment::weights::Weights;
use crate::spindle::Machine;

/// How far the tool's displacement limits are asked to be tightened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Tightening {
    /// As far as µ ≤ 1 allows.
    Auto,
    /// By this factor.
    By(f64),
}

/// What the tool's specification is loosened by beyond the excess of µ: it is not the only one that µ weighs.
const STEP_BACK: f64 = 0.95;
/// Designs tried with looser specifications; each step is at least 5 %.
const STEPS_BACK: usize = 5;

/// The specification with the tool's displacement limits divided by a factor.
pub(crate) fn tighter(weights: &Weights, factor: f64) -> Weights {
    Weights { tool_tightening: weights.tool_tightening * factor, ..weights.clone() }
}

/// The design with the tool's displacement limits divided by the factor asked for, and that factor. `Auto` starts from
/// the largest factor that the problem itself allows and steps back until the controller as it runs, reduced and
/// rounded and stable itself, has µ ≤ 1 as well.
pub(crate) fn tighten_specification(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
    asked: Tightening,
    progress: &mut Listener,
) -> Result<(Design, f64), PipelineError> {
    let mut factor = match asked {
        Tightening::By(factor) => factor,
        Tightening::Auto => {
            progress(Event::Begins("largest tightening"));
            largest_tightening(machine, weights, settings)?
        }
    };
    let mut found = design_in_words(machine, &tighter(weights, factor), settings, progress)?;
    if asked == Tightening::Auto {
        for _ in 0..STEPS_BACK {
            let mu = found.delivery.rounded.specification.upper;
            if mu <= 1.0 {
                break;
            }
            let words = format!("tightening by {factor:.2}: µ {mu:.3}");
            progress(Event::Found(&words));
            factor *= (STEP_BACK / mu).min(STEP_BACK);
            found = design_in_words(machine, &tighter(weights, factor), settings, progress)?;
        }
    }
    Ok((found, factor))
}

/// Optimal γ with constant scales of the covered problem without a bound on T, the tool's specification tightened by
/// `tightening`: an upper bound of the μ that a design reaches.
pub(crate) fn covered_gamma(
    machine: &Machine,
    weights: &Weights,
    tightening: f64,
    settings: &DesignSettings,
) -> Result<f64, PipelineError> {
    let only = DesignSettings { sensitivity_limits: vec![], give_way: false, ..settings.clone() };
    Ok(pose(machine, &tighter(weights, tightening), &only)?.2)
}

/// Largest factor on the tool's specification (displacements divided by it) for which [`covered_gamma`] is at most one,
/// within 2 %, searched between 1/64 and 64. A bound on T in the weights is kept; without one, none is asked for.
pub(crate) fn largest_tightening(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
) -> Result<f64, PipelineError> {
    let meets = |factor: f64| Ok::<_, PipelineError>(covered_gamma(machine, weights, factor, settings)? <= 1.0);
    let (mut low, mut high) = (1.0 / 64.0, 64.0);
    // Octaves first, from the factor asked: most specifications are within a factor of four.
    let mut factor = 1.0;
    let up = meets(factor)?;
    while factor > low && factor < high {
        let next = if up { factor * 2.0 } else { factor / 2.0 };
        if meets(next)? != up {
            (low, high) = if up { (factor, next) } else { (next, factor) };
            break;
        }
        factor = next;
    }
    while high / low > 1.02 {
        let middle = (low * high).sqrt();
        if meets(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(low)
}
