//! Factor by which the limits of a missed specification have to be widened, and the limit that binds.
//!
//! The displacements and the control current that the specification allows are multiplied by one factor; loads, noise
//! and the natural-frequency uncertainty stay. The factor is the smallest at which μ is at most one at every speed of
//! [`super::speed_mu::mu_over_speed`], on the exact responses of the whole machine.

use super::PipelineError;
use super::least_mu::least_mu;
use super::problems::Problems;
use super::shank_limit::ShankLimit;
use super::speed_mu::{SpeedMu, mu_at_speed};
use super::widening::Widening;
use crate::augment::assembly::UncertainMode;
use crate::augment::weights::Weights;
use crate::lti::{Discrete, StateSpace};
use crate::spindle::Machine;
use rayon::prelude::*;

/// A specification with wider limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecificationScale {
    /// Factor on displacements and control current; infinite where the uncertainty alone exceeds what the loop bears.
    pub factor: f64,
    /// What binds at that factor.
    pub binds: &'static str,
    /// The key of the weights file that relaxes it.
    pub key: &'static str,
    /// Speed at which it binds, rpm.
    pub speed_rpm: f64,
    /// Frequency at which it binds, Hz.
    pub frequency_hz: f64,
    /// What no controller can change.
    pub shank: Option<ShankLimit>,
    /// Below this no controller brings μ; none where it is not known.
    pub least_mu: Option<f64>,
}

impl SpecificationScale {
    pub(crate) fn sentence(&self) -> String {
        let place = format!(
            "{} at {:.0} Hz and {:.0} rpm binds (`{}` relaxes it)",
            self.binds, self.frequency_hz, self.speed_rpm, self.key
        );
        let widened = if self.factor.is_finite() {
            format!("The specification is met at {:.2} times its limits: {place}.", self.factor)
        } else {
            format!("The specification is not met at any multiple of its limits: {place}.")
        };
        match (self.shank, self.least_mu) {
            (Some(shank), _) => format!("{} {widened}", shank.sentence()),
            (None, Some(least)) if least > 1.0 => {
                format!("No controller can: µ is at least {least:.2} with any. {widened}")
            }
            (None, Some(least)) => format!(
                "None was found that meets the specification; that none can is not shown: no controller brings µ below \
                 {least:.2}. {widened}"
            ),
            (None, None) => widened,
        }
    }

    /// True where it is shown that no controller meets the specification.
    pub fn is_impossible(&self) -> bool {
        self.shank.is_some() || self.least_mu.is_some_and(|least| least > 1.0)
    }

    /// The scale in a few words, for a line over several tools.
    pub(crate) fn words(&self) -> String {
        match self.shank {
            Some(_) => "its shank is softer than its static limit: no controller can".to_owned(),
            None if self.is_impossible() => {
                format!("no controller can: µ is at least {:.2} with any", self.least_mu.unwrap_or(f64::NAN))
            }
            None if self.factor.is_finite() => {
                format!("met at {:.2} times its limits, where {} binds", self.factor, self.binds)
            }
            None => format!("met at no multiple of its limits: {} binds", self.binds),
        }
    }
}

/// Factors beyond this count as none.
const LARGEST: f64 = 1e5;
/// Width of the factor, relative: below the digits reported.
const WIDTH: f64 = 4e-3;
/// What a limit is loosened by to see whether it binds.
const LOOSER: f64 = 1.1;
#[derive(Clone, Copy)]
enum SpecificationRow {
    /// Displacement at a place: 0 tool, 1 front, 2 rear.
    Displacement(usize),
    Current,
    NaturalFrequencies,
    /// Actuators, sensors and delay.
    Hardware,
}

impl SpecificationRow {
    fn all(weights: &Weights) -> Vec<Self> {
        let mut rows = [0, 1, 2].map(Self::Displacement).to_vec();
        rows.extend([Self::Current, Self::NaturalFrequencies]);
        if !weights.uncertainty.is_none() {
            rows.push(Self::Hardware);
        }
        rows
    }

    fn words(self) -> &'static str {
        match self {
            Self::Displacement(0) => "the displacement of the tool",
            Self::Displacement(1) => "the displacement at the front bearing",
            Self::Displacement(_) => "the displacement at the rear bearing",
            Self::Current => "the control current",
            Self::NaturalFrequencies => "the natural-frequency uncertainty",
            Self::Hardware => "the uncertainty of actuators, sensors and delay",
        }
    }

    /// The key that relaxes it: of a displacement the level that acts at the frequency, or its curve.
    fn key(self, weights: &Weights, frequency_hz: f64) -> &'static str {
        const LEVELS: [[&str; 2]; 3] = [
            ["tool.max_dc_displacement_m", "tool.max_hf_displacement_m"],
            ["front.max_dc_displacement_m", "front.max_hf_displacement_m"],
            ["rear.max_dc_displacement_m", "rear.max_hf_displacement_m"],
        ];
        const CURVES: [&str; 3] = [
            "over_frequency.tool_displacement_m",
            "over_frequency.front_displacement_m",
            "over_frequency.rear_displacement_m",
        ];
        match self {
            Self::Displacement(place) if weights.curves.displacement[place].is_some() => CURVES[place],
            Self::Displacement(place) => {
                let above = frequency_hz > weights.displacement_crossover_hz[place];
                LEVELS[place][usize::from(above)]
            }
            Self::Current if weights.curves.current.is_some() => "over_frequency.current_a",
            Self::Current => "current_limit_a",
            Self::NaturalFrequencies => "mode_uncertainty",
            Self::Hardware => "uncertainty",
        }
    }

    /// Specification and modes, widened by a factor, with this row wider still.
    fn loosen_specification(
        self,
        factor: f64,
        weights: &Weights,
        modes: &[UncertainMode],
    ) -> (Weights, Vec<UncertainMode>) {
        let mut wider = Widening::all(factor);
        let (mut modes, mut looser) = (modes.to_vec(), weights.clone());
        match self {
            Self::Displacement(0) => wider.tool *= LOOSER,
            Self::Displacement(1) => wider.front *= LOOSER,
            Self::Displacement(_) => wider.rear *= LOOSER,
            Self::Current => wider.current *= LOOSER,
            Self::NaturalFrequencies => modes.iter_mut().for_each(|m| m.relative /= LOOSER),
            Self::Hardware => looser.uncertainty = looser.uncertainty.times(LOOSER.recip()),
        }
        (wider.apply(&looser), modes)
    }
}

/// The scale of a four-axis law whose μ over speed is `over_speed`; none when it meets the specification or is unstable
/// at a speed.
pub(crate) fn specification_scale(
    machine: &Machine,
    weights: &Weights,
    problems: &Problems,
    law: &StateSpace<Discrete>,
    over_speed: &[SpeedMu],
) -> Result<Option<SpecificationScale>, PipelineError> {
    let modes = problems.written_modes.as_slice();
    let mut speeds: Vec<SpeedMu> = over_speed.to_vec();
    speeds.sort_by(|a, b| b.mu.total_cmp(&a.mu));
    let Some(worst) = speeds.first().copied() else {
        return Ok(None);
    };
    if worst.mu <= 1.0 || !worst.mu.is_finite() {
        return Ok(None);
    }
    let at = |widening: Widening, modes: &[UncertainMode], rpm: f64| {
        mu_at_speed(machine, &widening.apply(weights), modes, law, rpm)
    };
    let (mut factor, mut binding) = (1.0f64, worst);
    for speed in &speeds {
        let rpm = speed.speed_rpm;
        let mut found = match factor {
            1.0 => *speed,
            _ => at(Widening::all(factor), modes, rpm)?,
        };
        if found.mu <= 1.0 {
            continue;
        }
        binding = found;
        // μ falls at most as fast as the factor grows.
        let mut low = factor;
        let mut high = factor * found.mu;
        while found.mu > 1.0 && high <= LARGEST {
            found = at(Widening::all(high), modes, rpm)?;
            if found.mu > 1.0 {
                binding = found;
                low = high;
                high *= found.mu.max(1.05);
            }
        }
        if found.mu > 1.0 {
            factor = f64::INFINITY;
            break;
        }
        while high / low > 1.0 + WIDTH {
            let middle = (low * high).sqrt();
            let there = at(Widening::all(middle), modes, rpm)?;
            if there.mu > 1.0 {
                (low, binding) = (middle, there);
            } else {
                high = middle;
            }
        }
        factor = high;
    }
    let used = factor.min(LARGEST);
    let rows = SpecificationRow::all(weights);
    let loosened: Result<Vec<f64>, PipelineError> = rows
        .par_iter()
        .map(|row| {
            let (specification, modes) = row.loosen_specification(used, weights, modes);
            Ok(mu_at_speed(machine, &specification, &modes, law, binding.speed_rpm)?.mu)
        })
        .collect();
    let softest = rows.into_iter().zip(loosened?);
    let row = softest.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(SpecificationRow::Displacement(0), |(row, _)| row);
    let frequency_hz = binding.frequency_hz.abs();
    Ok(Some(SpecificationScale {
        factor,
        binds: row.words(),
        key: row.key(weights, frequency_hz),
        speed_rpm: binding.speed_rpm,
        frequency_hz,
        shank: ShankLimit::of(machine, weights)?,
        // A bound above what is reached would be one of rounding.
        least_mu: least_mu(problems).filter(|least| *least <= worst.mu),
    }))
}
