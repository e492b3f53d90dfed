//! A law without a name, read from the table of a diagnosis, against closed forms of the machine without it.

use crate::spindle::spindle_plant::{block_error, krpm, reference};
use muspin::input::{InputError, with_correction};
use muspin::linalg::{Mat, c64};
use muspin::lti::Response;
use muspin::spindle::{Effect, EffectKind, Location, Machine, ModelDetail, Plant};
use std::f64::consts::TAU;
use std::fmt::Write as _;

const HZ: [f64; 6] = [20.0, 180.0, 560.0, 1150.0, 1420.0, 2500.0];

fn lines() -> impl Iterator<Item = f64> {
    (0..240).map(|k| 15.0 * 1.024f64.powi(k))
}

/// The table of a law at a place, with standard deviations of a thousandth.
fn table(place: &str, column: &str, law: impl Fn(c64) -> c64) -> String {
    let mut text = format!("frequency_hz,{column}_re,{column}_im,{column}_sd,place\n");
    for hz in lines() {
        let value = law(c64::new(0.0, TAU * hz));
        let sd = 1e-3 * value.norm();
        writeln!(text, "{hz},{},{},{sd},{place}", value.re, value.im).expect("text");
    }
    text
}

fn corrected(machine: &Machine, text: &str) -> Result<Machine, InputError> {
    let folder = tempfile::tempdir().expect("folder");
    let file = folder.path().join("correction.csv");
    std::fs::write(&file, text).expect("file");
    with_correction(machine.clone(), &file.display().to_string())
}

fn plant(machine: &Machine, rpm_in_thousands: f64) -> Plant {
    Plant::new(machine, krpm(rpm_in_thousands), ModelDetail::Full).expect("plant")
}

/// A force that resonates at 1.4 kHz beside a spring: 4·10⁵ (1 + s ω/(s² + 2ζωs + ω²)).
fn resonant_force(s: c64) -> c64 {
    let w = TAU * 1400.0;
    (s * w / (s * s + s * (0.2 * w) + w * w) + 1.0) * 4e5
}

fn lag(s: c64) -> c64 {
    (s / (TAU * 900.0) + 1.0).inv() - 1.0
}

/// G' = G − G_f Δ (I + Δ G_xf)⁻¹ G_x with the two channels at the tool, at any speed.
#[test]
fn a_force_law_at_the_tool_is_one_loop_round_the_plant() {
    let machine = reference();
    let with = corrected(&machine, &table(&format!("shaft:{}", machine.tool_plane_m()), "law_n_per_m", resonant_force));
    let with = with.expect("correction");
    for speed in [0.0, 50.0] {
        let (without, with) = (plant(&machine, speed), plant(&with, speed));
        for hz in HZ {
            let g = without.at(TAU * hz);
            let law = resonant_force(c64::new(0.0, TAU * hz));
            let one = |i: usize, j: usize| c64::new(f64::from(u8::from(i == j)), 0.0);
            let [[a, b], [c, d]] = [4, 5].map(|i| [4, 5].map(|j| one(i, j) + g[(i, j)] * law));
            let inverse = [[d, -b], [-c, a]].map(|row| row.map(|x| x / (a * d - b * c)));
            let expected = Mat::from_fn(10, 10, |i, j| {
                (0..2)
                    .flat_map(|p| (0..2).map(move |q| (p, q)))
                    .fold(g[(i, j)], |sum, (p, q)| sum - g[(i, 4 + p)] * law * inverse[p][q] * g[(4 + q, j)])
            });
            let error = block_error(&with.at(TAU * hz), &expected);
            assert!(error < 1e-8, "{speed} {hz} Hz: {error:.1e}");
        }
    }
}

/// The state space is another road than the response: poles in place of values at a line.
#[test]
fn the_state_space_has_the_response_of_the_lines() {
    let machine = reference();
    let shaft = corrected(&machine, &table("shaft:0.15", "law_n_per_m", resonant_force)).expect("shaft");
    let currents = corrected(&machine, &table("currents:rear", "law_relative", lag)).expect("currents");
    let signals = corrected(&machine, &table("signals:front_y", "law_relative", lag)).expect("signals");
    for machine in [shaft, currents, signals] {
        for speed in [0.0, 50.0] {
            let plant = Plant::design_model(&machine, krpm(speed)).expect("plant");
            let system = plant.state_space(12).expect("state space");
            for hz in HZ {
                let error = block_error(&system.at(TAU * hz), &plant.at(TAU * hz));
                // Padé of order 12 is exact to rounding at these frequencies.
                assert!(error < 1e-8, "{speed} {hz} Hz: {error:.1e}");
            }
        }
    }
}

#[test]
fn laws_at_currents_and_signals_are_factors() {
    let machine = reference();
    for (place, row, column) in [
        ("currents:rear", None, Some([2, 3].as_slice())),
        ("signals:front_y", Some([1].as_slice()), None),
        ("loop", None, Some([0, 1, 2, 3].as_slice())),
    ] {
        let with = corrected(&machine, &table(place, "law_relative", lag)).expect("correction");
        let (without, with) = (plant(&machine, 20.0), plant(&with, 20.0));
        for hz in HZ {
            let g = without.at(TAU * hz);
            let factor = lag(c64::new(0.0, TAU * hz)) + 1.0;
            let hit = |list: Option<&[usize]>, k: usize| list.is_some_and(|list| list.contains(&k));
            let expected =
                Mat::from_fn(10, 10, |i, j| if hit(row, i) || hit(column, j) { g[(i, j)] * factor } else { g[(i, j)] });
            let error = block_error(&with.at(TAU * hz), &expected);
            assert!(error < 1e-8, "{place} {hz} Hz: {error:.1e}");
        }
    }
}

/// Spring, damper and mass of a law are those that the model knows by name.
#[test]
fn a_polynomial_law_is_spring_damper_and_mass() {
    let machine = reference();
    let (k, c, m) = (3e5, 120.0, 0.02);
    let law = |s: c64| s * s * m + s * c + k;
    let with = corrected(&machine, &table("shaft:0.2", "law_n_per_m", law)).expect("correction");
    let named = |kind, value| Effect::new(kind, Location::Position(0.2), vec![value]).expect("effect");
    let named = machine
        .with_effect(named(EffectKind::AddedStiffness, k))
        .with_effect(named(EffectKind::AddedDamper, c))
        .with_effect(named(EffectKind::AddedMass, m));
    for speed in [0.0, 40.0] {
        let (with, named) = (plant(&with, speed), plant(&named, speed));
        for hz in HZ {
            let error = block_error(&with.at(TAU * hz), &named.at(TAU * hz));
            assert!(error < 1e-6, "{speed} {hz} Hz: {error:.1e}");
        }
    }
}

#[test]
fn a_delay_of_a_signal_is_fitted_within_its_error() {
    let machine = reference();
    let late = |s: c64| (s * -25e-6).exp() - 1.0;
    let with = corrected(&machine, &table("signals:rear", "law_relative", late)).expect("correction");
    let (without, with) = (plant(&machine, 0.0), plant(&with, 0.0));
    for hz in HZ {
        let g = without.at(TAU * hz);
        let factor = late(c64::new(0.0, TAU * hz)) + 1.0;
        let error = (with.at(TAU * hz)[(2, 2)] / g[(2, 2)] - factor).norm();
        assert!(error < 2e-4, "{hz} Hz: {error:.1e}");
    }
}

#[test]
fn what_no_model_can_take_is_said() {
    let machine = reference();
    let said = |text: &str| corrected(&machine, text).expect_err("refused");
    let error = said(&table("housing", "law_n_per_m", resonant_force));
    assert!(error.to_string().contains("housing") && error.to_string().contains("shaft:position_m"), "{error}");
    let error = said(&table("shaft:9", "law_n_per_m", resonant_force));
    assert!(error.to_string().contains("must lie on the rotor"), "{error}");
    // Noise without a law: signs by a rule that no transfer function has.
    let noise = |s: c64| c64::new((s.im * s.im).sin(), (s.im * s.im * 0.7).cos()) * 1e5;
    let error = said(&table("shaft:0.2", "law_n_per_m", noise));
    assert!(error.to_string().contains("stable transfer function"), "{error}");
    let error = said("frequency_hz,law_furlongs_re,law_furlongs_im,law_furlongs_sd,place\n1,2,3,4,loop\n");
    assert_eq!(error.line, Some(1));
    let good = table("loop", "law_relative", lag);
    let error = said(&good.replacen(",loop\n", ",currents:front\n", 1));
    assert!(error.line == Some(3) && error.to_string().contains("another"), "{error}");
    let error = said(&good.replacen("15,", "15 Hz,", 1));
    assert!(error.line == Some(2) && error.to_string().contains("frequency_hz"), "{error}");
}
