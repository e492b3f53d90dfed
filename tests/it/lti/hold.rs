//! The hold of a sampled controller in closed-loop responses: against the integral that defines it, against the loop in
//! the time domain of its definition (signals at the samples, currents constant between them), on the reference machine
//! and on one that samples at half the rate, where leaving it out is a quarter of the gain at 4 kHz.

use muspin::controller::ControlLaw;
use muspin::input::{load_controller, load_machine, load_measurement};
use muspin::linalg::{Mat, c64, solve_complex};
use muspin::lti::held::{closed_response, hold_magnitude};
use muspin::lti::sample::tustin;
use muspin::lti::{Continuous, Discrete, FrequencyGrid, HeldResponse, Response, StateSpace};
use muspin::pid::certificate::softest;
use muspin::predict::closed_loop::{close, sensitivity};
use muspin::predict::stiffness::dynamic_stiffness;
use muspin::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/diagnosis/c03");

/// The reference spindle as it was updated, sampled at another rate with the same total delay.
fn reference_at(sample_rate_hz: f64) -> Machine {
    let files = ["spindle.yaml", "tool.yaml"].map(|name| format!("{DATA}/{name}"));
    let mut machine = load_machine(&files[0], &files[1]).unwrap();
    machine.spindle.electronics.sample_rate_hz = sample_rate_hz;
    machine
}

/// The PID that levitates it, at the machine's sample rate.
fn pid(machine: &Machine) -> StateSpace<Discrete> {
    let period = machine.spindle.electronics.sample_period_s();
    let law = load_controller(&format!("{DATA}/pid.json")).unwrap().law;
    match law {
        ControlLaw::Continuous(law) => tustin(&law, period).unwrap(),
        ControlLaw::Discrete(_) => panic!("continuous"),
    }
}

/// The hold as the integral that defines it, (1 − e^{−jωT})/(jωT), with its half sample.
fn hold(omega: f64, period: f64) -> c64 {
    let s = c64::new(0.0, omega);
    (c64::new(1.0, 0.0) - (-s * period).exp()) / (s * period)
}

#[test]
fn a_sampled_controller_acts_with_the_magnitude_of_its_hold_and_a_continuous_one_without() {
    let law = pid(&reference_at(10_000.0));
    for hz in [1e-3, 1.0, 700.0, 2500.0, 4900.0] {
        let omega = TAU * hz;
        let (plain, held) = (law.at(omega), law.held_at(omega));
        let magnitude = hold(omega, 1e-4).norm();
        assert!((hold_magnitude(omega, 1e-4) - magnitude).abs() < 1e-9, "{hz} Hz");
        let off = (held[(0, 0)] - plain[(0, 0)] * magnitude).norm();
        assert!(off <= 1e-9 * plain[(0, 0)].norm(), "{hz} Hz: {off}");
    }
    // Half of the gain is lost at 0.603 of the sample rate; a quarter of it at 4.13 kHz of 10 kHz.
    assert!((hold_magnitude(TAU * 4130.0, 1e-4) - 0.742).abs() < 1e-3);
    let lag = StateSpace::new(
        Mat::from_fn(1, 1, |_, _| -500.0),
        Mat::from_fn(1, 1, |_, _| 500.0),
        Mat::from_fn(1, 1, |_, _| 1.0),
        Mat::zeros(1, 1),
        Continuous,
    )
    .unwrap();
    assert_eq!(lag.at(2e4)[(0, 0)], lag.held_at(2e4)[(0, 0)]);
}

/// One mass on a magnet, its current late by `delay_s` and behind an amplifier: command and force to signal and
/// displacement.
struct Mass {
    delay_s: f64,
}

const MASS_KG: f64 = 2.0;
const KS: f64 = 1e6;
const KI: f64 = 200.0;
const AMPLIFIER_RAD_S: f64 = TAU * 2000.0;

impl Response for Mass {
    fn at(&self, omega_rad_s: f64) -> Mat<c64> {
        let s = c64::new(0.0, omega_rad_s);
        let compliance = (s * s * MASS_KG - KS).inv();
        let force = (-s * self.delay_s).exp() * KI / (s / AMPLIFIER_RAD_S + 1.0);
        Mat::from_fn(2, 2, |_, j| if j == 0 { compliance * force } else { compliance })
    }
}

#[test]
fn the_compliance_of_a_levitated_mass_is_the_one_worked_out_by_hand() {
    let (period, delay_s) = (1e-4, 1.3e-4);
    // u = −kp (y + T_d (y − y₋)/T): one state, the last signal.
    let (kp, derivative) = (3e4, 2e-3);
    let law = StateSpace::new(
        Mat::zeros(1, 1),
        Mat::from_fn(1, 1, |_, _| 1.0),
        Mat::from_fn(1, 1, |_, _| kp * derivative / period),
        Mat::from_fn(1, 1, |_, _| -kp * (1.0 + derivative / period)),
        Discrete { period_s: period },
    )
    .unwrap();
    for hz in [5.0, 120.0, 900.0, 2400.0, 4000.0] {
        let omega = TAU * hz;
        let s = c64::new(0.0, omega);
        let k = -kp * (c64::new(1.0, 0.0) + derivative / period * (c64::new(1.0, 0.0) - (-s * period).exp()));
        // The rest of the delay is pure.
        let chain = hold(omega, period) * (-s * (delay_s - 0.5 * period)).exp() * KI / (s / AMPLIFIER_RAD_S + 1.0);
        let expected = (s * s * MASS_KG - KS - chain * k).inv();
        let found = closed_response(&Mass { delay_s }, &law, 1, omega)[(0, 0)];
        assert!((found - expected).norm() < 1e-9 * expected.norm(), "{hz} Hz");
    }
}

/// Tool stiffness of the loop at a frequency, the commands multiplied by the hold by hand.
fn stiffness_by_hand(plant: &Plant, law: &StateSpace<Discrete>, omega: f64, with_hold: bool) -> f64 {
    let (p, k) = (plant.at(omega), law.at(omega));
    // `delay_s` is in the plant whole: the hold replaces half a sample of it by its own response.
    let (s, period) = (c64::new(0.0, omega), plant.sample_period_s());
    let factor = if with_hold { hold(omega, period) * (s * (0.5 * period)).exp() } else { c64::new(1.0, 0.0) };
    let commands = Mat::from_fn(10, 4, |i, j| p[(i, j)] * factor);
    let open = Mat::from_fn(4, 4, |i, j| commands[(i, j)]);
    let difference = Mat::<c64>::identity(4, 4) - &open * &k;
    let y = solve_complex(&difference, &Mat::from_fn(4, 1, |i, _| p[(i, 4)]));
    let u = &k * &y;
    let x = (0..4).fold(p[(4, 4)], |x, j| x + commands[(4, j)] * u[(j, 0)]);
    x.norm().recip()
}

#[test]
fn the_certified_stiffness_is_that_of_the_held_loop_at_two_sample_rates() {
    for rate in [20_000.0, 10_000.0] {
        let machine = reference_at(rate);
        let law = pid(&machine);
        let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
        let closed = close(&plant.sample_plant().unwrap(), &law).unwrap();
        let (certified, hz) = softest(&plant, &law, closed.poles().unwrap(), 1.0, 4000.0);
        let there = stiffness_by_hand(&plant, &law, TAU * hz, true);
        assert!((certified / there - 1.0).abs() < 1e-9, "{rate} Hz: {certified} and {there} N/m");
        // No line of a grid of its own lies lower, and the prediction on that grid is the same curve.
        let grid = FrequencyGrid::log_hz(1.0, 4000.0, 2000);
        let predicted = dynamic_stiffness(&plant, &law, 0, &grid);
        let mut hold_shows = 0.0f64;
        for (omega, found) in grid.omega_rad_s().iter().zip(&predicted.magnitude_n_per_m) {
            let by_hand = stiffness_by_hand(&plant, &law, *omega, true);
            assert!(by_hand > certified * (1.0 - 1e-6), "{rate} Hz: {by_hand} at {omega} rad/s");
            assert!((found / by_hand - 1.0).abs() < 1e-6, "{rate} Hz: {found} and {by_hand} N/m");
            let without = stiffness_by_hand(&plant, &law, *omega, false);
            hold_shows = hold_shows.max((without / by_hand - 1.0).abs());
        }
        assert!(hold_shows > 0.02, "{rate} Hz: {hold_shows}");
    }
}

#[test]
fn the_sensitivity_is_that_of_the_sampled_loop() {
    // Second road: the sampled plant, hold and delay by exponentials, images of the spectrum included. The prediction
    // has the fundamental alone. Tolerance: five times less than what leaving out the hold costs (0.018 and 0.033 at
    // the worst line), above what the images add here. At 10 kHz this loop nearly oscillates at 2 kHz (|S| = 7), where
    // images count: not a line.
    let lines = [10.0, 100.0, 500.0, 833.0, 1200.0, 3000.0, 3500.0];
    for (rate, tolerance) in [(20_000.0, 0.0035), (10_000.0, 0.0085)] {
        let machine = reference_at(rate);
        let law = pid(&machine);
        let plant = Plant::new(&machine, 0.0, ModelDetail::Full).unwrap();
        let axes = [0, 1, 2, 3];
        let sampled = plant.sample_plant().unwrap().select(&axes, &axes);
        for hz in lines {
            let omega = TAU * hz;
            let one = Mat::<c64>::identity(4, 4);
            let exact = solve_complex(&(&one - &sampled.at(omega) * &law.at(omega)), &one);
            let found = sensitivity(&plant, &law, omega);
            for axis in axes {
                let (a, b) = (found[(axis, axis)], exact[(axis, axis)]);
                let off = (a - b).norm() / b.norm().max(1.0);
                assert!(off < tolerance, "{rate} Hz, axis {axis}, {hz} Hz: {off}");
            }
        }
    }
}

#[test]
fn currents_logged_before_the_hold_are_brought_behind_it() {
    let data = std::path::Path::new(DATA);
    let usual = load_measurement(DATA).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for file in std::fs::read_dir(data).unwrap() {
        let path = file.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let list = folder.path().join("measurement.yaml");
    let text = std::fs::read_to_string(&list).unwrap();
    let said = text.replacen("file: sweep-0.csv", "file: sweep-0.csv\n  hold: true", 1);
    assert_ne!(text, said);
    std::fs::write(&list, &said).unwrap();
    let source = folder.path().to_str().unwrap().to_owned();
    let held = load_measurement(&source).unwrap();
    let (before, after) = (&held.sweeps[0].record, &usual.sweeps[0].record);
    assert_eq!(before.signal, after.signal);
    for (l, hz) in after.frequency_hz.iter().enumerate() {
        // The spindle of the record samples at 20 kHz.
        let magnitude = hold(TAU * hz, 5e-5).norm();
        let (x, y) = (before.current[[l, 0, 0, 0]], after.current[[l, 0, 0, 0]]);
        assert!((x - y * magnitude).norm() < 1e-9 * y.norm(), "{hz} Hz");
    }
    let wrong = text.replacen("file: hammer-0.csv", "file: hammer-0.csv\n  hold: true", 1);
    std::fs::write(&list, wrong).unwrap();
    let refused = load_measurement(&source).unwrap_err().to_string();
    assert!(refused.contains("hold") && refused.contains("hammer"), "{refused}");
}
