//! Time response of the levitated rotor to a case, with the program that firmware runs, and the influence of the
//! sensors' quantisation on it.

use super::PipelineError;
use super::loop_stability::growth_rate_at;
use super::sampled::SampledController;
use crate::controller::anti_windup::{AntiWindup, firmware_rows};
use crate::controller::arithmetic::{Float32Program, float32};
use crate::controller::scaling::SignalLimits;
use crate::predict::recovery::{Recovery, touching_force_n};
use crate::predict::time::{TimeError, TimeResponse, TimeSample, TimeSettings};
use crate::predict::time_cases::{PUSH_S, Quantisation, StandardCase, TimeFigures, figures, run_case};
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

#[derive(Clone, Copy, Debug)]
pub(crate) struct SimulationScenario {
    /// The case with its size.
    pub case: StandardCase,
    /// When it went well.
    pub goal: Goal,
    pub speed_rpm: f64,
    pub duration_s: f64,
    /// Whether the loop is stable at the speed.
    pub stable: bool,
}

named! {
    pub(crate) enum SimulationCase {
        Impulse = "impulse",
        Step = "step",
        /// Unbalance of a balance grade at speed.
        Unbalance = "unbalance",
        LiftOff = "lift-off",
        /// Half-sine push at the tool that throws the rotor into its backup bearings.
        Contact = "contact",
    }
}

/// A case with what is said of it; what is not said is as usual for the case.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimulationWish {
    pub case: SimulationCase,
    pub speed_rpm: Option<f64>,
    /// Balance grade, m/s.
    pub grade_m_s: Option<f64>,
    pub force_n: Option<f64>,
    /// Length of the half sine, s.
    pub push_s: Option<f64>,
    pub duration_s: Option<f64>,
    /// Time over which the reference moves to the centre at lift-off, s.
    pub ramp_s: Option<f64>,
}

/// Longest simulation, s: every sample is kept in memory and written.
const LONGEST_S: f64 = 20.0;

/// Balance grade unless given, mm/s: G 0.4 of ISO 21940-11, precision spindles.
const USUAL_GRADE_MM_S: f64 = 0.4;
/// Time of the reference at lift-off unless given, s: several periods of a suspension of 50 Hz.
const USUAL_RAMP_S: f64 = 0.1;

impl SimulationWish {
    /// What is simulated on a machine; whether the loop is stable is not known yet.
    pub(crate) fn scenario(&self, machine: &Machine) -> Result<SimulationScenario, TimeError> {
        let period_s = machine.spindle.electronics.sample_period_s();
        let length_s = self.push_s.unwrap_or(PUSH_S);
        let positive = |what: &'static str, value: Option<f64>| match value {
            Some(value) if !(value.is_finite() && value > 0.0) => {
                Err(TimeError::Setting { what, value, rule: "a positive number" })
            }
            _ => Ok(()),
        };
        positive("force", self.force_n)?;
        positive("duration", self.duration_s)?;
        positive("grade", self.grade_m_s)?;
        self.check_own_settings()?;
        let ramp_s = self.ramp_s();
        if let Some(value) = self.duration_s.filter(|d| *d > LONGEST_S) {
            return Err(TimeError::Setting { what: "duration", value, rule: "at most 20 s" });
        }
        if !(length_s.is_finite() && length_s >= period_s) {
            let rule = "a time of at least one sampling period";
            return Err(TimeError::Setting { what: "push", value: length_s, rule });
        }
        let top_rpm = machine.spindle.max_rpm;
        let impulse = |force_n: f64| StandardCase::Impulse { force_n, length_s };
        // A long push or ramp leaves time for what comes after it.
        let longer = |usual_s: f64, event_s: f64| usual_s.max(2.0 * event_s).min(LONGEST_S);
        let (case, goal, usual_rpm, usual_s) = match self.case {
            SimulationCase::Impulse => {
                (impulse(self.force_n.unwrap_or(50.0)), Goal::Recovers, 0.0, longer(0.1, length_s))
            }
            SimulationCase::Contact => {
                let force_n = match self.force_n {
                    Some(given) => given,
                    None => touching_force_n(machine, SignalLimits::of(machine).output_a, length_s)?,
                };
                (impulse(force_n), Goal::Recovers, top_rpm, longer(0.2, length_s))
            }
            SimulationCase::Step => {
                let force_n = self.force_n.unwrap_or(40.0);
                (StandardCase::Step { force_n }, Goal::StaysClear, 0.0, 0.3)
            }
            SimulationCase::Unbalance => {
                let grade_m_s = self.grade_m_s.unwrap_or(1e-3 * USUAL_GRADE_MM_S);
                (StandardCase::Unbalance { grade_m_s }, Goal::StaysClear, top_rpm, 0.2)
            }
            SimulationCase::LiftOff => (StandardCase::LiftOff, Goal::LiftsOff, 0.0, longer(0.5, ramp_s)),
        };
        Ok(SimulationScenario {
            case,
            goal,
            speed_rpm: self.speed_rpm.unwrap_or(usual_rpm),
            duration_s: self.duration_s.unwrap_or(usual_s),
            stable: true,
        })
    }
}

impl SimulationWish {
    fn ramp_s(&self) -> f64 {
        self.ramp_s.unwrap_or(USUAL_RAMP_S)
    }

    /// Refuses what the case does not have.
    fn check_own_settings(&self) -> Result<(), TimeError> {
        let own: &[&str] = match self.case {
            SimulationCase::Impulse | SimulationCase::Contact => &["force", "push"],
            SimulationCase::Step => &["force"],
            SimulationCase::Unbalance => &["grade"],
            SimulationCase::LiftOff => &["ramp"],
        };
        let given = [("force", self.force_n), ("push", self.push_s), ("grade", self.grade_m_s), ("ramp", self.ramp_s)];
        for (what, value) in given.into_iter().filter(|(what, _)| !own.contains(what)) {
            if let Some(value) = value {
                return Err(TimeError::Setting { what, value, rule: "left out: this case has none" });
            }
        }
        Ok(())
    }
}

/// A simulated case with the loop and the arithmetic behind it.
pub(crate) struct SimulatedController {
    pub scenario: SimulationScenario,
    /// Largest growth rate of the loop, 1/s.
    pub growth_rate_per_s: f64,
    /// How the slow states are conditioned while an output is limited.
    pub anti_windup: AntiWindup,
    pub found: Simulated,
}

/// Simulates what is wished with a controller as firmware computes it.
pub(crate) fn simulate_controller(
    machine: &Machine,
    sampled: &SampledController,
    wish: &SimulationWish,
    settings: &TimeSettings,
) -> Result<SimulatedController, PipelineError> {
    let mut scenario = wish.scenario(machine)?;
    let (rows, anti_windup) = firmware_rows(&sampled.law, machine)?;
    let program = float32(&rows)?;
    let growth_rate_per_s = growth_rate_at(machine, &sampled.controller, scenario.speed_rpm)?;
    scenario.stable = growth_rate_per_s < 0.0;
    let lifts = wish.case == SimulationCase::LiftOff;
    let settings = TimeSettings { reference_ramp_s: if lifts { wish.ramp_s() } else { 0.0 }, ..*settings };
    let found = simulate_scenario(machine, &program, &scenario, &settings)?;
    Ok(SimulatedController { scenario, growth_rate_per_s, anti_windup, found })
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
    pub response: TimeResponse,
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
        if !met {
            (met, end)
        } else if steps.dominates() {
            (met, format!("{end}; {}", steps.sentence()))
        } else if matches!(case, StandardCase::Step { .. }) && still_moves(&response, settings.quantum_m) {
            (met, format!("{end}; the tool has not settled within {seconds} s"))
        } else {
            (met, end)
        }
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

/// Share of its displacement by which the tool may differ between both halves of the last quarter of a run that has
/// settled: more than the share of the linear step, as noise and steps of the sensors add to it.
const STILL: f64 = 0.05;

/// Whether the largest displacement of the tool still changes in the last quarter of the run, by more than two steps of
/// the sensors.
fn still_moves(response: &TimeResponse, quantum_m: f64) -> bool {
    let samples = &response.samples;
    let eighth = samples.len() / 8;
    let radial = |s: &TimeSample| s.displacements_m[0].hypot(s.displacements_m[1]);
    let largest = |part: &[TimeSample]| part.iter().map(radial).fold(0.0, f64::max);
    let (before, last) = samples[samples.len() - 2 * eighth..].split_at(eighth);
    let (before, last) = (largest(before), largest(last));
    (before - last).abs() > (STILL * last).max(2.0 * quantum_m)
}

/// Whether the rotor still touches in the last quarter of the run.
fn lies(response: &TimeResponse) -> bool {
    let samples = &response.samples;
    let from = samples.len() - samples.len() / 4;
    let touches = |s: &TimeSample| s.contact_n.iter().any(|f| *f != 0.0);
    samples.is_empty() || samples[from..].iter().any(touches)
}
