//! A spring in one plane against closed forms of the machine without it.

use crate::spindle::spindle_plant::{block_error, krpm, reference};
use muspin::linalg::{Mat, c64};
use muspin::lti::Response;
use muspin::spindle::{Effect, EffectKind, Location, Machine, ModelDetail, Plane, Plant};
use std::f64::consts::TAU;

const STIFFNESS_N_PER_M: f64 = 8e5;

fn spring(machine: &Machine, location: Location) -> Machine {
    let values = vec![STIFFNESS_N_PER_M];
    machine.with_effect(Effect::new(EffectKind::AddedStiffness, location, values).expect("effect"))
}

fn plant(machine: &Machine, rpm_in_thousands: f64) -> Plant {
    Plant::new(machine, krpm(rpm_in_thousands), ModelDetail::Full).expect("plant")
}

/// With the magnets off, what their negative stiffness differs by in x and y is gone, and own springs stay.
#[test]
fn magnets_that_differ_in_x_and_y_are_no_supports_of_the_rotor_without_them() {
    let mut machine = reference();
    let z = machine.spindle.planes.front_actuator_m;
    for (plane, spring_n_per_m) in [(Plane::X, -3e5), (Plane::Y, 3e5)] {
        let effect = Effect::new(EffectKind::AddedStiffness, Location::InPlane(z, plane), vec![spring_n_per_m]);
        machine = machine.with_effect(effect.expect("effect"));
    }
    assert_eq!((machine.supports().len(), machine.supports_without_magnets().len()), (2, 0));
    let beside = spring(&machine, Location::InPlane(0.5 * z, Plane::X));
    assert_eq!(beside.supports_without_magnets().len(), 1);
    let alone = spring(&reference(), Location::InPlane(z, Plane::X));
    assert_eq!(alone.supports_without_magnets().len(), 1);
}

/// At the tool plane the plant has the force and the displacement of the spring among its channels:
/// G' = G − g_f k g_x / (1 + k g_xf), at any speed.
#[test]
fn at_the_tool_it_is_one_loop_round_the_plant() {
    let machine = reference();
    let z = machine.tool_plane_m();
    for (plane, channel) in [(Plane::X, 4), (Plane::Y, 5)] {
        let with = spring(&machine, Location::InPlane(z, plane));
        for speed in [0.0, 30.0, 50.0] {
            let (without, with) = (plant(&machine, speed), plant(&with, speed));
            for hz in [5.0, 180.0, 560.0, 1150.0, 2500.0, 3900.0] {
                let g = without.at(TAU * hz);
                let one = c64::new(1.0, 0.0);
                let own = one + g[(channel, channel)] * STIFFNESS_N_PER_M;
                let expected = Mat::from_fn(10, 10, |i, j| {
                    g[(i, j)] - g[(i, channel)] * g[(channel, j)] * STIFFNESS_N_PER_M / own
                });
                let error = block_error(&with.at(TAU * hz), &expected);
                assert!(error < 1e-10, "{plane:?} {speed} {hz} Hz: {error:.1e}");
            }
        }
    }
}

/// One in each plane is one in both.
#[test]
fn two_planes_are_a_spring_in_both() {
    let machine = reference();
    let (x, y) = (Plane::X, Plane::Y);
    let apart = spring(&machine, Location::InPlane(0.21, x));
    let apart = spring(&apart, Location::InPlane(0.21, y));
    let both = spring(&machine, Location::Position(0.21));
    for speed in [0.0, 40.0] {
        let (apart, both) = (plant(&apart, speed), plant(&both, speed));
        for hz in [5.0, 560.0, 1150.0, 3900.0] {
            let error = block_error(&apart.at(TAU * hz), &both.at(TAU * hz));
            assert!(error < 1e-10, "{speed} {hz} Hz: {error:.1e}");
        }
    }
}

/// Beside a spring in both planes and a housing, which act through the same shaft.
#[test]
fn at_rest_the_other_plane_does_not_know_of_it() {
    let mut machine = spring(&reference(), Location::Position(0.1));
    let values = vec![120.0, 400.0, 0.03];
    let housing = Effect::new(EffectKind::HousingMode, Location::None, values).expect("effect");
    machine = machine.with_effect(housing);
    let in_x = plant(&spring(&machine, Location::InPlane(0.3, Plane::X)), 0.0);
    let (without, both) = (plant(&machine, 0.0), plant(&spring(&machine, Location::Position(0.3)), 0.0));
    for hz in [5.0, 395.0, 1150.0, 3900.0] {
        let (found, without, both) = (in_x.at(TAU * hz), without.at(TAU * hz), both.at(TAU * hz));
        let of = |m: &Mat<c64>, plane: usize| {
            Mat::from_fn(10, 10, |i, j| if (i % 2, j % 2) == (plane, plane) { m[(i, j)] } else { c64::new(0.0, 0.0) })
        };
        // Beside what stands in both planes the shaft has the same basis; without a port of the spring another one,
        // which a full plant keeps to 1.2e-5 up to 4 kHz.
        let in_x = block_error(&of(&found, 0), &of(&both, 0));
        let in_y = block_error(&of(&found, 1), &of(&without, 1));
        assert!(in_x < 1e-10 && in_y < 1.2e-5, "{hz} Hz: {in_x:.1e} {in_y:.1e}");
        let rest = Mat::from_fn(10, 10, |i, j| if i % 2 == j % 2 { c64::new(0.0, 0.0) } else { found[(i, j)] });
        assert_eq!(rest.norm_max(), 0.0);
    }
}

#[test]
fn a_file_keeps_the_plane() {
    let machine = spring(&reference(), Location::InPlane(0.21, Plane::Y));
    let effect = machine.spindle.effects.last().expect("effect");
    let text = muspin::input::write::effect(effect);
    assert_eq!(text, "{effect: added_stiffness, position_m: 0.21, axis: y, stiffness_n_per_m: 800000.0}");
    let yaml = muspin::input::write::spindle_yaml(&machine.spindle);
    let again = muspin::input::read_spindle("spindle.yaml", &yaml).expect("spindle");
    assert_eq!(again.effects.last(), Some(effect));
    let wrong = yaml.replace("axis: y", "axis: front_y");
    let error = muspin::input::read_spindle("spindle.yaml", &wrong).expect_err("no plane");
    let words = error.to_string();
    assert!(words.contains("effects[0].axis") && words.contains("must be x or y"), "{words}");
    let nowhere = Effect::new(EffectKind::CrossCoupling, Location::InPlane(0.2, Plane::X), vec![1e5]);
    assert!(nowhere.is_err(), "a circulatory force has no plane");
}
