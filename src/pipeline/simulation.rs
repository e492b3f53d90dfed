//! Time response of the levitated rotor to a case, with the program that firmware runs, and the influence of the
//! sensors' quantisation on it.

use crate::controller::arithmetic::Float32Program;
use crate::controller::scaling::SignalLimits;
use crate::predict::recovery::Recovery;
use crate::predict::time::{TimeError, TimeResponse, TimeSample, TimeSettings};
use crate::predict::time_cases::{Quantisation, StandardCase, TimeFigures, figures, run_case};
use crate::spindle::Machine;
use std::f64::consts::TAU;

/// When a case went well.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Goal {
    /// A push is over: the rotor may touch if it recovers.
    Recovers,
    /// A load stays: the rotor must not touch at all.
    StaysClear,
    /// The rotor leaves the backup bearings and stays free.
    LiftsOff,
}

/// What is simulated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimulationScenario {
    /// The case with its size.
    pub case: StandardCase,
    /// When it went well.
    pub goal: Goal,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// Whether the loop is stable at the speed.
    pub stable: bool,
}

/// Limits that the spindle file does not hold in this form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SimulationLimits {
    /// Control current that the firmware allows, A.
    pub current_a: f64,
    /// Bus voltage of the amplifiers, V.
    pub voltage_v: f64,
}

/// What a simulation found.
#[derive(Clone, Debug)]
pub(crate) struct Simulated {
    /// The response.
    pub response: TimeResponse,
    /// Its figures.
    pub figures: TimeFigures,
    /// Limits of current and voltage.
    pub limits: SimulationLimits,
    /// Whether the loop is stable at the speed.
    pub stable: bool,
    /// Recovery from contact with the backup bearings.
    pub recovery: Recovery,
    /// Influence of the sensors' quantisation.
    pub steps: Quantisation,
    /// Whether the case went well.
    pub met: bool,
    /// The sentence about it.
    pub end: String,
}

/// Simulates a case, and once more without the quantisation of the sensors.
///
/// # Errors
/// [`TimeError`] for settings out of range or a plant that cannot be built.
pub(crate) fn simulate_scenario(
    machine: &Machine,
    program: &Float32Program,
    scenario: &SimulationScenario,
    settings: &TimeSettings,
) -> Result<Simulated, TimeError> {
    let (case, seconds) = (scenario.case, scenario.duration_s);
    let speed = scenario.speed_rpm * TAU / 60.0;
    let response = run_case(machine, program, case, speed, seconds, settings)?;
    let smooth = TimeSettings { quantum_m: 0.0, ..*settings };
    let smooth = run_case(machine, program, case, speed, seconds, &smooth)?;
    let steps = Quantisation::of(settings.quantum_m, &response, &smooth);
    let recovery = Recovery::of(machine, &response);
    let (met, end) = if scenario.stable {
        let (met, end) = verdict(scenario.goal, &response, recovery);
        if met && steps.dominates() { (met, format!("{end}; {}", steps.sentence())) } else { (met, end) }
    } else {
        (false, "the closed loop is unstable at this speed".to_owned())
    };
    Ok(Simulated {
        figures: figures(machine, &response),
        limits: SimulationLimits { current_a: SignalLimits::of(machine).output_a, voltage_v: settings.bus_voltage_v },
        stable: scenario.stable,
        response,
        recovery,
        steps,
        met,
        end,
    })
}

/// Whether the case went well, and the sentence about it.
fn verdict(goal: Goal, response: &TimeResponse, recovery: Recovery) -> (bool, String) {
    if response.diverged {
        return (false, "the rotor left every reasonable range".to_owned());
    }
    match goal {
        Goal::LiftsOff if lies(response) => (false, "the rotor does not leave the backup bearings".to_owned()),
        Goal::LiftsOff => (true, "the rotor lifts off and stays free".to_owned()),
        Goal::Recovers => (recovery != Recovery::Lost, recovery.sentence()),
        Goal::StaysClear => (recovery == Recovery::Clear, recovery.sentence()),
    }
}

/// Whether the rotor still touches in the last quarter of the run.
fn lies(response: &TimeResponse) -> bool {
    let samples = &response.samples;
    let from = samples.len() - samples.len() / 4;
    let touches = |s: &TimeSample| s.contact_n.iter().any(|f| *f != 0.0);
    samples.is_empty() || samples[from..].iter().any(touches)
}
