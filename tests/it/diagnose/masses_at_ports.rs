//! Masses as forces at their ports against the same masses in the mass matrix of the plant.
//!
//! Round the modes without it, a mass m at a port with receptance h answers as  h/(1 − ω²mh); in the matrices it makes
//! other modes. Both are the same rotor as long as no mode is damped: a mass at a port leaves the damping ratios to the
//! modes without it.

use muspin::diagnose::fit::model::Model;
use muspin::input::load_machine;
use muspin::lti::Response;
use muspin::spindle::halved::refine_mesh;
use muspin::spindle::response::Assembly;
use muspin::spindle::{Effect, EffectKind, Location, Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

/// Machines whose masses, planes and modes differ most.
const MACHINES: [(&str, &str); 3] =
    [("s01-short-fast", "endmill-6"), ("s12-big-discs", "endmill-10"), ("s04-noncollocated", "endmill-20-short")];

/// Without damping of the shaft.
fn undamped(spindle: &str, tool: &str) -> Machine {
    let root = env!("CARGO_MANIFEST_DIR");
    let spindle = format!("{root}/tests/data/spindles/{spindle}.yaml");
    let mut machine = load_machine(&spindle, &format!("{root}/spindles/tools/{tool}.yaml")).expect("machine");
    machine.spindle.damping_ratio = vec![0.0];
    machine
}

/// Masses at the planes of both bearings and between them, from a thousandth to a third of the rotor, and what a place
/// can lose; a disc at each; and masses at the tip.
fn additions(machine: &Machine, model: &Model) -> Vec<Effect> {
    let planes = &machine.spindle.planes;
    let rotor = machine.rotor().expect("rotor").mass_properties().mass_kg;
    let mut all = vec![];
    let mut add = |kind, place, values| all.push(Effect::new(kind, place, values).expect("effect"));
    let between = 0.5 * (planes.front_actuator_m + planes.rear_actuator_m);
    for z in [planes.front_actuator_m, planes.front_sensor_m, planes.rear_actuator_m, planes.rear_sensor_m, between] {
        for kg in
            [0.001 * rotor, 0.03 * rotor, 0.3 * rotor, -0.4 * model.reduced.inertia_kg(z, false).expect("inertia")]
        {
            add(EffectKind::AddedMass, Location::Position(z), vec![kg]);
        }
        let kg = 0.05 * rotor;
        // A disc as thin as a sheet, as wide as a tenth of the span.
        let polar = 0.5 * kg * (0.1 * (planes.rear_actuator_m - planes.front_actuator_m)).powi(2);
        add(EffectKind::AddedDisc, Location::Position(z), vec![kg, polar, 0.5 * polar]);
    }
    for kg in [1e-4 * rotor, 0.01 * rotor] {
        add(EffectKind::ToolMass, Location::None, vec![kg]);
    }
    all
}

/// Relative error of frequencies that the reduction may leave: undamped resonances make any error of a response of it.
const OF_FREQUENCY: f64 = 1e-4;
/// Of a response elsewhere, as of every other effect (`diagnose_model`).
const OF_RESPONSE: f64 = 2e-3;
/// Masses above this share of the rotor are held against the same coordinates only: a third of the rotor at one place
/// bends it at 3 kHz otherwise than the coordinates of the reduced model can, by 3e-3 of a response. So are masses that
/// are taken away: at a node of the finer mesh there is less than that.
const RESOLVED_SHARE: f64 = 0.1;
/// Of the same coordinates closed in two ways: rounding, times what resonances make of it.
const ROUNDING: f64 = 1e-7;

#[test]
fn masses_at_ports_are_masses_of_the_shaft() {
    for (spindle, tool) in MACHINES {
        let machine = undamped(spindle, tool);
        let model = Model::new(&machine, &[]).expect("model");
        let p = vec![0.0; model.layout.len()];
        let fine = refine_mesh(&machine);
        for effect in additions(&machine, &model) {
            let effects = std::slice::from_ref(&effect);
            let assemble = |masses_at_ports: bool| {
                let assembly = Assembly { effects, masses_at_ports, ..Assembly::default() };
                model.reduced.assemble(&p, assembly).expect("assembled")
            };
            let (at_port, in_modes) = (assemble(true), assemble(false));
            let rotor_kg = machine.rotor().expect("rotor").mass_properties().mass_kg;
            let resolved = effect.values[0] > 0.0 && effect.values[0] < RESOLVED_SHARE * rotor_kg;
            let plant =
                resolved.then(|| Plant::new(&fine.with_effect(effect.clone()), 0.0, ModelDetail::Full).expect("plant"));
            for hz in [55.0, 190.0, 430.0, 830.0, 1370.0, 2110.0, 2960.0] {
                let found = at_port.line(TAU * hz, None).response;
                let same = in_modes.line(TAU * hz, None).response;
                let at = |by: f64| plant.as_ref().map(|plant| plant.at(TAU * hz * by));
                let (exact, beside) = (at(1.0), at(1.0 + OF_FREQUENCY));
                // What currents do, and what forces do.
                for forces in [false, true] {
                    let entries = || (0..36).filter(|n| (n % 6 >= 4) == forces).map(|n| (n, (n / 6, n % 6)));
                    let size = entries().map(|(n, _)| same[n].norm()).fold(0.0, f64::max);
                    for (n, at) in entries() {
                        let rounding = (found[n] - same[n]).norm();
                        let told = format!("{spindle}, {effect:?}, {hz} Hz, {at:?}: {rounding} of {size}");
                        assert!(rounding < ROUNDING * size, "{told}");
                    }
                    let Some((exact, beside)) = exact.as_ref().zip(beside.as_ref()) else { continue };
                    let size = entries().map(|(_, at)| exact[at].norm()).fold(0.0, f64::max);
                    let steep = entries().map(|(_, at)| (exact[at] - beside[at]).norm()).fold(0.0, f64::max);
                    for (n, at) in entries() {
                        let off = (found[n] - exact[at]).norm();
                        let told = format!("{spindle}, {effect:?}, {hz} Hz, {at:?}: {off} of {size}");
                        assert!(off < OF_RESPONSE * size + steep, "{told}");
                    }
                }
            }
        }
    }
}
