//! How far the tool's specification can be tightened.

use super::PipelineError;
use super::posing::pose;
use super::settings::DesignSettings;
use crate::augment::weights::Weights;
use crate::spindle::Machine;

/// Optimal γ with constant scales of the covered problem without a bound on T, the tool's specification tightened by
/// `tightening`: an upper bound of the μ that a design reaches.
///
/// # Errors
/// [`PipelineError`] when the plant or every synthesis fails.
pub fn covered_gamma(
    machine: &Machine,
    weights: &Weights,
    tightening: f64,
    settings: &DesignSettings,
) -> Result<f64, PipelineError> {
    let tightened = Weights {
        tool_tightening: weights.tool_tightening * tightening,
        ..weights.clone()
    };
    let only = DesignSettings {
        sensitivity_limits: vec![],
        give_way: false,
        ..settings.clone()
    };
    Ok(pose(machine, &tightened, &only)?.2)
}

/// Largest factor on the tool's specification (displacements divided by it) for which [`covered_gamma`] is at most one,
/// within 2 %, searched between 1/64 and 64. A bound on T in the weights is kept; without one, none is asked for.
///
/// # Errors
/// As [`covered_gamma`].
pub(crate) fn largest_tightening(
    machine: &Machine,
    weights: &Weights,
    settings: &DesignSettings,
) -> Result<f64, PipelineError> {
    let meets = |factor: f64| {
        Ok::<_, PipelineError>(covered_gamma(machine, weights, factor, settings)? <= 1.0)
    };
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
