//! Stability of a loop at one speed, from its closed-loop poles.
//!
//! A sampled controller: the sampled loop of the full plant with hold and exact delay. A continuous one: the continuous
//! loop, the delay as a Padé approximant of order 8 (phase error below 1e-6 rad up to ωτ = 5, far above any crossover).

use super::PipelineError;
use crate::controller::verification::growth_words;
use crate::controller::{ControlLaw, Controller};
use crate::linalg::{NumericError, c64};
use crate::lti::connect::lower_lft;
use crate::lti::{Discrete, StateSpace, TimeBase};
use crate::spindle::plant::AXES;
use crate::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// Order of the delay's approximant.
const PADE: usize = 8;

/// Poles of a loop at one speed and how fast the least damped of them grows.
#[derive(Clone, Debug)]
pub(crate) struct SpeedPoles {
    /// As continuous poles, rad/s; those of pure delays left out.
    pub poles_rad_s: Vec<c64>,
    /// Largest growth rate, 1/s; negative: stable.
    pub growth_rate_per_s: f64,
}

pub(crate) fn loop_poles(plant: &Plant, controller: &Controller) -> Result<SpeedPoles, PipelineError> {
    let numeric = PipelineError::numeric("closed-loop stability");
    match &controller.law {
        ControlLaw::Discrete(law) => {
            let sampled = plant.sample_plant()?;
            check_sample_time(law, sampled.time.period_s)?;
            let poles = plant.loop_poles(&sampled, law).map_err(&numeric)?;
            Ok(SpeedPoles {
                growth_rate_per_s: sampled.time.largest_growth_rate(&poles),
                poles_rad_s: sampled.time.continuous_poles(poles),
            })
        }
        ControlLaw::Continuous(law) => {
            let axes: Vec<usize> = (0..AXES).collect();
            let open = plant.state_space(PADE)?.select(&axes, &axes);
            let closed = lower_lft(&open, law).map_err(&numeric)?;
            let poles_rad_s = closed.poles().map_err(&numeric)?;
            let growth_rate_per_s = closed.time.largest_growth_rate(&poles_rad_s);
            // Eigenvalues carry the rounding of the largest one.
            let largest = poles_rad_s.iter().map(|p| p.norm()).fold(0.0, f64::max);
            if growth_rate_per_s.abs() < f64::EPSILON * closed.order() as f64 * largest {
                return Err(numeric(NumericError::Contradiction {
                    what: "poles of the loop: the fastest hides on which side of stability the slowest lie, leave out \
                           of the controller what is far beyond its sample rate",
                    residual: growth_rate_per_s.abs() / largest,
                }));
            }
            Ok(SpeedPoles { growth_rate_per_s, poles_rad_s })
        }
    }
}

/// Refuses a law at another sample time than that of its machine.
pub(super) fn check_sample_time(law: &StateSpace<Discrete>, period_s: f64) -> Result<(), PipelineError> {
    let given_s = law.time.period_s;
    // Sample times are decimals of the same number; only rounding is forgiven.
    if (given_s - period_s).abs() > 1e-9 * period_s {
        return Err(PipelineError::SampleTime { given_s, rate_hz: period_s.recip() });
    }
    Ok(())
}

/// Largest growth rate of the loop of the full plant at a speed, 1/s; negative: stable.
pub(crate) fn growth_rate_at(machine: &Machine, controller: &Controller, speed_rpm: f64) -> Result<f64, PipelineError> {
    let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
    Ok(loop_poles(&plant, controller)?.growth_rate_per_s)
}

/// The first line of the message about an unstable loop.
pub(crate) fn unstable_words(growth_rate_per_s: f64, speed_rpm: f64) -> String {
    format!(
        "unstable: the closed loop {}; it has no stiffness, no zone and no response that lasts",
        growth_words(growth_rate_per_s, speed_rpm)
    )
}
