//! The fit of a whole machine: spindle and tool go in, both come out with their elements' `modulus_scale` multiplied.

use super::UpdateError;
use super::gauss_newton::gauss_newton_rotor;
use super::nelder_mead::nelder_mead_rotor;
use super::outcome::Updated;
use super::problem::UpdateSettings;
use super::targets::{FrfTargets, Target, Targets};
use crate::identify::{Identification, Reading};
use crate::spindle::Machine;

/// A machine with updated moduli and the fit behind it.
#[derive(Clone, Debug)]
pub struct UpdatedMachine {
    /// Spindle and tool with the factors applied to every element of a region.
    pub machine: Machine,
    /// Factors, errors, determinability, verdict.
    pub fit: Updated,
}

/// Targets of the two coaxial FRFs: front sensor over front actuator, rear sensor over rear actuator, free-free rotor.
pub fn front_and_rear(
    machine: &Machine,
    resonances: Vec<Option<Target>>,
    front: Vec<Option<Target>>,
    rear: Vec<Option<Target>>,
) -> Targets {
    let [f, r] = machine.effective().bearings;
    let frf = |name: &str, b: &crate::spindle::EffectiveBearing, antiresonances| FrfTargets {
        name: name.to_owned(),
        output_m: b.sensor_m,
        input_m: b.actuator_m,
        antiresonances,
        held_out: false,
    };
    Targets { resonances, antiresonances: vec![frf("front", &f, front), frf("rear", &r, rear)], ..Targets::default() }
}

/// Targets of what was identified from a sweep at rest; the crossed FRFs are held out.
pub(crate) fn identified_targets(machine: &Machine, found: &Identification) -> Targets {
    let list = |readings: &[Reading]| readings.iter().map(Target::of).collect();
    let lists = [&found.resonances, &found.front, &found.rear].map(|readings| list(readings));
    let [resonances, front, rear] = lists;
    let mut targets = front_and_rear(machine, resonances, front, rear);
    let [f, r] = machine.effective().bearings;
    let crossed = [
        ("13", f.sensor_m, r.actuator_m, &found.front_over_rear),
        ("31", r.sensor_m, f.actuator_m, &found.rear_over_front),
    ];
    for (name, output_m, input_m, readings) in crossed {
        targets.antiresonances.push(FrfTargets {
            name: name.to_owned(),
            output_m,
            input_m,
            antiresonances: list(readings),
            held_out: true,
        });
    }
    targets
}

/// Gauss–Newton on the moduli of a machine; see [`super::gauss_newton`](mod@super::gauss_newton).
///
/// # Errors
/// As [`gauss_newton_rotor`], and [`UpdateError::Machine`] when the machine breaks a rule.
pub fn gauss_newton(
    machine: &Machine,
    targets: &Targets,
    settings: &UpdateSettings,
) -> Result<UpdatedMachine, UpdateError> {
    let fit = gauss_newton_rotor(&machine.rotor()?, targets, settings)?;
    Ok(apply(machine, fit))
}

/// Nelder–Mead on the moduli of a machine; see [`super::nelder_mead`](mod@super::nelder_mead).
///
/// # Errors
/// As [`gauss_newton`].
pub fn nelder_mead(
    machine: &Machine,
    targets: &Targets,
    settings: &UpdateSettings,
) -> Result<UpdatedMachine, UpdateError> {
    let fit = nelder_mead_rotor(&machine.rotor()?, targets, settings)?;
    Ok(apply(machine, fit))
}

fn apply(machine: &Machine, fit: Updated) -> UpdatedMachine {
    let mut machine = machine.clone();
    fit.scale(&mut machine.spindle.sections);
    fit.scale(&mut machine.tool.sections);
    UpdatedMachine { machine, fit }
}
