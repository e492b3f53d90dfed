//! Nonlinear time response: force law against its closed form and derivatives, small signals against the linear loop,
//! limits and contact, and the commands `export` and `simulate` end to end.

use crate::cli::program::muspin;
use muspin::controller::anti_windup::with_anti_windup;
use muspin::controller::arithmetic::{Float32Program, float32};
use muspin::controller::realise::modal_form;
use muspin::controller::scaling::{SignalLimits, scale_realisation};
use muspin::controller::{ControlLaw, Controller};
use muspin::export::json::controller_json;
use muspin::input::load_machine;
use muspin::linalg::Mat;
use muspin::lti::connect::lower_lft;
use muspin::lti::{Discrete, StateSpace};
use muspin::pid::settings::TuneSettings;
use muspin::pid::tune::textbook;
use muspin::predict::shaft_line::ShaftLine;
use muspin::predict::time::TimeSettings;
use muspin::predict::time_cases::{Quantisation, StandardCase, figures, run_case};
use muspin::predict::time_force::{BackupBearing, Magnet};
use muspin::rotor::PlanarModes;
use muspin::spindle::{Bearings, Effect, EffectKind, Location, Machine, ModelDetail, Plant};
use std::f64::consts::TAU;
use std::sync::OnceLock;

fn machine() -> Machine {
    load_machine("reference", "paper-tool").unwrap()
}

/// The textbook PID: quickly found, stable at every speed.
fn pid() -> (Controller, StateSpace<Discrete>) {
    static FOUND: OnceLock<Controller> = OnceLock::new();
    let controller = FOUND.get_or_init(|| textbook(&machine(), &TuneSettings::quick()).unwrap().controller).clone();
    let ControlLaw::Discrete(law) = controller.law.clone() else { panic!("sampled") };
    (controller, law)
}

/// What firmware makes of the textbook PID, computed once.
fn program(law: &StateSpace<Discrete>) -> Float32Program {
    static FOUND: OnceLock<Float32Program> = OnceLock::new();
    let make = || {
        let limits = SignalLimits { input_m: 2.54e-4, output_a: 3.0 };
        let rows = scale_realisation(&modal_form(law).unwrap(), limits).unwrap();
        float32(&with_anti_windup(rows, &machine()).unwrap().0).unwrap()
    };
    FOUND.get_or_init(make).clone()
}

#[test]
fn the_force_law_is_the_closed_form_with_the_gains_of_the_file() {
    let machine = machine();
    let bearing = machine.spindle.front;
    let magnet = Magnet::new(&bearing, &machine.effective().bearings[0], 0, 300.0);
    let kappa = bearing.ks_n_per_m * bearing.gap_m / (bearing.ki_n_per_a * bearing.bias_current_a);
    for (i, x) in [(0.3, 2e-5), (-1.2, 1e-4), (2.9, -2e-4), (0.0, 0.0)] {
        let (eta, xi) = (i / bearing.bias_current_a, kappa * x / bearing.gap_m);
        let closed: f64 =
            bearing.ki_n_per_a * bearing.bias_current_a * (eta + xi) * (1.0 + eta * xi) / (1.0 - xi * xi).powi(2);
        assert!((magnet.force_n(i, x) - closed).abs() < 1e-9 * closed.abs().max(1.0));
    }
    let slope = |f: &dyn Fn(f64) -> f64, h: f64| (f(h) - f(-h)) / (2.0 * h);
    let by_current = slope(&|h| magnet.force_n(h, 0.0), 1e-4);
    let by_position = slope(&|h| magnet.force_n(0.0, h), 1e-9);
    assert!((by_current / bearing.ki_n_per_a - 1.0).abs() < 1e-9);
    assert!((by_position / bearing.ks_n_per_m - 1.0).abs() < 1e-6);
    // Full one-sided current would pull 1440 N; the iron ends at the static capacity of the file.
    assert_eq!(magnet.force_n(5.0, 0.0), bearing.max_force_n);
}

/// L = k_i²/(2 k_s) of the linear law, so that k_i U/L = 2 U k_s/k_i; a centred rotor is pulled by k_i i₀/4 (i_max/i₀)²
/// or by what the iron bears.
#[test]
fn static_capacity_and_slew_rate_are_those_of_the_two_coils() {
    let machine = machine();
    for (k, magnet) in Magnet::both(&machine, 250.0).into_iter().enumerate() {
        let side = [muspin::spindle::Side::Front, muspin::spindle::Side::Rear][k];
        let (bearing, own) = (machine.spindle.bearing(side), &machine.effective().bearings[k]);
        let slew = 2.0 * 250.0 * own.ks_n_per_m / own.ki_n_per_a;
        assert!((magnet.slew_n_per_s() / slew - 1.0).abs() < 1e-12);
        let (i0, most) = (bearing.bias_current_a, bearing.max_current_a);
        assert!(most >= 2.0 * i0, "the other coil is without current");
        let pull = 0.25 * own.ki_n_per_a * i0 * (most / i0).powi(2);
        assert!((magnet.static_capacity_n() / pull.min(bearing.max_force_n) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn no_magnet_pulls_more_than_its_capacity() {
    let machine = machine();
    let effective = machine.effective();
    for (bearing, effective) in [machine.spindle.front, machine.spindle.rear].iter().zip(&effective.bearings) {
        let magnet = Magnet::new(bearing, effective, 0, 300.0);
        let mut reached = 0.0f64;
        for k in -40..=40 {
            for i in -30..=30 {
                let force = magnet.force_n(0.1 * f64::from(i), 1e-5 * f64::from(k));
                assert!(force.abs() <= bearing.max_force_n, "{i} {k}: {force}");
                reached = reached.max(force.abs());
            }
        }
        // Without the limit the rotor at the stop and full current would give several times the capacity.
        assert!(reached > 0.9 * bearing.max_force_n, "{reached}");
    }
}

#[test]
fn voltage_limits_the_slew_of_the_current() {
    let machine = machine();
    let effective = machine.effective();
    let magnet = Magnet::new(&machine.spindle.front, &effective.bearings[0], 0, 300.0);
    // L = 24.4 mH from the force constant; 300 V drive 12.3 A/ms.
    let (next, limited) = magnet.advance(0.0, 3.0, 1e-5);
    assert!(limited && (next / 1e-5 / 12_300.0 - 1.0).abs() < 0.1, "{}", next / 1e-5);
    let (next, limited) = magnet.advance(0.0, 0.01, 1e-5);
    assert!(!limited && (next / (0.01 * (1.0 - (-TAU * 2000.0 * 1e-5f64).exp())) - 1.0).abs() < 1e-12);
}

#[test]
fn the_voltage_of_a_current_ramp_is_inductance_times_slope() {
    let machine = machine();
    let bearing = machine.spindle.front;
    let magnet = Magnet::new(&bearing, &machine.effective().bearings[0], 0, 300.0);
    // L = k_i s₀/(2 i₀ κ), κ = k_s s₀/(k_i i₀).
    let kappa = bearing.ks_n_per_m * bearing.gap_m / (bearing.ki_n_per_a * bearing.bias_current_a);
    let inductance = bearing.ki_n_per_a * bearing.gap_m / (2.0 * bearing.bias_current_a * kappa);
    let found = magnet.voltage_v(0.05, 1e-5);
    assert!((found / (inductance * 0.05 / 1e-5) - 1.0).abs() < 1e-12);
    // At the limit the voltage is that of the bus.
    let (next, limited) = magnet.advance(0.0, 3.0, 1e-5);
    assert!(limited && (magnet.voltage_v(next, 1e-5) / 300.0 - 1.0).abs() < 1e-12);
}

#[test]
fn the_line_of_the_shaft_goes_through_the_recorded_planes() {
    let machine = machine();
    let line = ShaftLine::new(&machine, 2000).unwrap();
    let planes = [3e-6, -1e-6, 2e-6];
    let drawn = line.through(planes);
    let positions =
        [machine.tool_plane_m(), machine.spindle.planes.front_actuator_m, machine.spindle.planes.rear_actuator_m];
    for (z, expected) in positions.iter().zip(planes) {
        let nearest = (0..drawn.len())
            .min_by(|a, b| {
                let off = |k: &usize| (line.position_m[*k] - z).abs();
                off(a).total_cmp(&off(b))
            })
            .unwrap();
        // A quarter of a millimetre off at most: some 1e-8 m of a line with slopes of 1e-4.
        assert!((drawn[nearest] - expected).abs() < 5e-8, "{z}");
    }
    // A rigid translation stays one.
    for x in line.through([1e-6; 3]) {
        assert!((x - 1e-6).abs() < 1e-15);
    }
}

#[test]
fn contact_pushes_back_and_never_pulls() {
    let backup = BackupBearing {
        clearance_m: 2.54e-4,
        stiffness_n_per_m: 3e7,
        damping_n_s_per_m: 3e3,
        friction: 0.1,
        radius_m: 0.02,
    };
    assert_eq!(backup.force_n([2.5e-4, 0.0], [1.0, 0.0], 5000.0), [0.0, 0.0]);
    let f = backup.force_n([2.64e-4, 0.0], [0.0, 0.0], 5000.0);
    assert!((f[0] + 300.0).abs() < 1e-6 && (f[1] + 30.0).abs() < 1e-6, "{f:?}");
    assert_eq!(backup.force_n([2.55e-4, 0.0], [-1.0, 0.0], 0.0)[0].abs(), 0.0);
}

/// Force constants that differ from axis to axis, and currents that pull across: both act on the currents alone.
#[test]
fn small_signals_follow_the_linear_prediction() {
    let with = |effects: &[(EffectKind, Location, f64)]| {
        effects.iter().fold(machine(), |machine, (kind, place, value)| {
            machine.with_effect(Effect::new(*kind, place.clone(), vec![*value]).unwrap())
        })
    };
    let uneven = [0, 1, 2, 3].map(|axis| (EffectKind::ForceConstant, Location::Axis(axis), [1.2, 0.8][axis % 2]));
    let across = [(EffectKind::BearingCoupling, Location::Bearing(Bearings::Front), 0.2)];
    for machine in [machine(), with(&uneven), with(&across)] {
        follows_the_linear_prediction(&machine);
    }
}

fn follows_the_linear_prediction(machine: &Machine) {
    let (_, law) = pid();
    let force = 0.5;
    let flexible = 6;
    let settings = TimeSettings { flexible_modes: Some(flexible), quantum_m: 0.0, ..TimeSettings::default() };
    // Linear prediction from a plant whose force constant is that of the file times a factor: the error relative to the
    // peak.
    let distance = |speed: f64, factor: f64| -> (f64, f64) {
        let case = StandardCase::Step { force_n: force };
        let found = run_case(machine, &program(&law), case, speed, 0.05, &settings).unwrap();
        let mut machine = machine.clone();
        machine.spindle.front.ki_n_per_a *= factor;
        let detail = ModelDetail::Modes { flexible, static_residual: true };
        let plant = Plant::new(&machine, speed, detail).unwrap().sample_plant().unwrap();
        let open = plant.select(&[4, 5, 0, 1, 2, 3], &[4, 0, 1, 2, 3]);
        let closed = lower_lft(&open, &law).unwrap();
        let mut x = Mat::<f64>::zeros(closed.order(), 1);
        let (mut worst, mut peak) = (0.0f64, 0.0f64);
        for sample in &found.samples {
            let y = &closed.c * &x;
            for axis in 0..2 {
                let expected = y[(axis, 0)] + closed.d[(axis, 0)] * force;
                worst = worst.max((sample.displacements_m[axis] - expected).abs());
                peak = peak.max(expected.abs());
            }
            let input = Mat::from_fn(closed.order(), 1, |i, _| closed.b[(i, 0)] * force);
            x = &closed.a * &x + input;
        }
        (worst / peak, peak)
    };
    for speed in [0.0, 3000.0] {
        let (error, peak) = distance(speed, 1.0);
        // Second-order force terms are 1e-4 at this size, the integrator's substep 1e-3.
        assert!(error < 3e-3, "{error:e} of {peak:e} m at {speed} rad/s");
        assert!(peak > 1e-8);
    }
    // The comparison can fail: a prediction with one percent more force constant is outside.
    let (error, _) = distance(0.0, 1.01);
    assert!(error > 4e-3, "{error:e}");
}

#[test]
fn unless_given_every_mode_below_four_tenths_of_the_sample_rate_takes_part() {
    let machine = machine();
    let (_, law) = pid();
    let modes = PlanarModes::new(&machine.rotor().unwrap()).unwrap();
    let highest_hz = 0.4 * machine.spindle.electronics.sample_rate_hz;
    let inside = modes.flexible_hz().iter().filter(|f| **f < highest_hz).count();
    assert!(inside > machine.spindle.flexible_modes);
    let case = StandardCase::Impulse { force_n: 20.0, length_s: 2e-4 };
    let with = |flexible_modes| {
        let settings = TimeSettings { flexible_modes, ..TimeSettings::default() };
        run_case(&machine, &program(&law), case, 0.0, 0.01, &settings).unwrap().samples
    };
    assert_eq!(with(None), with(Some(inside)));
    assert_ne!(with(None), with(Some(inside - 1)));
}

/// A push in x at rest, where y stays still: the amplifier of x counts, that of y does not.
#[test]
fn each_axis_has_its_own_amplifier() {
    let (_, law) = pid();
    let case = StandardCase::Impulse { force_n: 20.0, length_s: 2e-4 };
    let currents = |effect: Option<(EffectKind, usize, Vec<f64>)>| -> Vec<[f64; 4]> {
        let mut machine = machine();
        if let Some((kind, axis, values)) = effect {
            machine = machine.with_effect(Effect::new(kind, Location::Axis(axis), values).unwrap());
        }
        let settings = TimeSettings::default();
        let found = run_case(&machine, &program(&law), case, 0.0, 0.01, &settings).unwrap();
        found.samples.iter().map(|sample| sample.currents_a).collect()
    };
    let slow = |axis| Some((EffectKind::AmplifierBandwidth, axis, vec![700.0]));
    let nominal = currents(None);
    assert_eq!(currents(slow(1)), nominal);
    assert_ne!(currents(slow(0)), nominal);
    // One of second order counts as that of first order with the same lag, ω/2ζ.
    let second = currents(Some((EffectKind::AmplifierSecondOrder, 0, vec![840.0, 0.6])));
    for (found, expected) in second.iter().flatten().zip(currents(slow(0)).iter().flatten()) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

#[test]
fn the_rotor_lifts_off_and_unbalance_stays_inside_the_clearance() {
    let machine = machine();
    let (_, law) = pid();
    let settings = TimeSettings::default();
    let lift = run_case(&machine, &program(&law), StandardCase::LiftOff, 0.0, 0.5, &settings).unwrap();
    let start = lift.samples.first().unwrap();
    let radius = start.displacements_m[2].hypot(start.displacements_m[3]);
    assert!((radius / machine.spindle.backup_clearance_m - 1.0).abs() < 0.02, "{radius}");
    let f = figures(&machine, &lift);
    assert!(!lift.diverged && f.settled_displacement_m[1] < 2e-5, "{f:?}");

    let speed = 50_000.0 * TAU / 60.0;
    let grade = StandardCase::Unbalance { grade_m_s: 4e-4 };
    let turning = run_case(&machine, &program(&law), grade, speed, 0.1, &settings).unwrap();
    let f = figures(&machine, &turning);
    assert!(!turning.diverged && turning.in_contact == 0.0 && f.clearance_ratio < 0.3, "{f:?}");
    // The same once more gives the same numbers.
    let again = run_case(&machine, &program(&law), grade, speed, 0.1, &settings).unwrap();
    assert_eq!(turning.samples, again.samples);
}

#[test]
fn too_hard_a_push_saturates_and_is_reported() {
    let machine = machine();
    let (_, law) = pid();
    let case = StandardCase::Step { force_n: 3000.0 };
    let found = run_case(&machine, &program(&law), case, 0.0, 0.05, &TimeSettings::default()).unwrap();
    assert!(found.current_limited > 0.1 && found.in_contact > 0.1);
    let bad = TimeSettings { substeps: 0, ..TimeSettings::default() };
    assert!(run_case(&machine, &program(&law), case, 0.0, 0.05, &bad).is_err());
}

#[test]
fn what_the_steps_of_the_sensors_leave_is_told_from_the_rest() {
    let (machine, (_, law)) = (machine(), pid());
    let case = StandardCase::Impulse { force_n: 5.0, length_s: 5e-4 };
    let with_steps = |quantum_m: f64| {
        let settings = TimeSettings { quantum_m, ..TimeSettings::default() };
        run_case(&machine, &program(&law), case, 0.0, 0.1, &settings).unwrap()
    };
    let smooth = with_steps(0.0);
    let none = Quantisation::of(0.0, &smooth, &smooth);
    assert_eq!((none.displacement_m, none.part), ([0.0; 3], 0.0));
    // A push of 5 N has decayed after 75 ms, and a loop with steps of a micrometre does not come to rest within one.
    let coarse = Quantisation::of(1e-6, &with_steps(1e-6), &smooth);
    assert!(coarse.dominates() && coarse.displacement_m[0] > 1e-7, "{coarse:?}");
    // The limit cycle of a loop that is otherwise linear grows with the step.
    let fine = Quantisation::of(1e-8, &with_steps(1e-8), &smooth);
    assert!(fine.displacement_m[0] < 0.1 * coarse.displacement_m[0], "{fine:?} {coarse:?}");
}

#[test]
fn export_and_simulate_run_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let (controller, law) = pid();
    std::fs::write(folder.path().join("pid.json"), controller_json(&controller, None)).unwrap();
    let (code, out, err) = muspin(&["export", "--controller", "pid.json", "--out", "x"], folder.path());
    assert_eq!(code, 0, "{err}");
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(summary["verified"], true);
    let header = std::fs::read_to_string(folder.path().join("x/controller.h")).unwrap();
    assert!(header.contains("#define PAPER_TOOL_VERIFIED 1") && header.contains("verified, closed loop proven stable"));
    for name in ["controller.c", "coefficients.csv", "test_vectors.csv", "controller.mat", "discrete.json"] {
        assert!(folder.path().join("x").join(name).exists(), "{name}");
    }
    let sections = ["export", "--controller", "pid.json", "--form", "sections", "--format", "c", "--out", "s"];
    let (code, _, err) = muspin(&sections, folder.path());
    assert_eq!(code, 0, "{err}");
    assert!(!folder.path().join("s/discrete.json").exists());

    // The wrong sign: refused, and with the flag written with a warning inside.
    let wrong = Controller {
        name: "wrong".to_owned(),
        law: ControlLaw::Discrete(StateSpace { c: &law.c * -1.0, d: &law.d * -1.0, ..law }),
    };
    std::fs::write(folder.path().join("wrong.json"), controller_json(&wrong, None)).unwrap();
    let (code, out, err) = muspin(&["export", "--controller", "wrong.json", "--out", "w"], folder.path());
    assert_eq!(code, 1);
    assert!(out.is_empty() && err.contains("unstable") && err.contains("--force-unverified"), "{err}");
    assert!(!folder.path().join("w").exists());
    let forced = ["export", "--controller", "wrong.json", "--out", "w", "--force-unverified"];
    assert_eq!(muspin(&forced, folder.path()).0, 1);
    let header = std::fs::read_to_string(folder.path().join("w/controller.h")).unwrap();
    assert!(header.contains("UNSTABLE") && header.contains("#define PAPER_TOOL_VERIFIED 0"));

    let lift = ["simulate", "--controller", "pid.json", "--case", "lift-off", "--out", "l"];
    let (code, _, err) = muspin(&[&lift[..], &["--force", "500"]].concat(), folder.path());
    assert!(code == 2 && err.contains("--force: 500 must be left out"), "{err}");
    let (code, out, err) = muspin(&[&lift[..], &["--ramp", "1"]].concat(), folder.path());
    let lifted: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(code == 0 && lifted["duration_s"] == 2.0, "{err}");

    let simulate = ["simulate", "--controller", "pid.json", "--case", "impulse", "--duration", "0.02", "--out", "t"];
    let (code, out, err) = muspin(&simulate, folder.path());
    assert_eq!(code, 0, "{err}");
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(summary["simulation"]["peak_displacement_m"]["tool"].as_f64().unwrap() > 0.0);
    for margin in ["displacement", "current", "voltage", "force"] {
        let left = &summary["simulation"]["margin"][margin]["front"];
        assert!((0.0..1.0).contains(&left.as_f64().unwrap()), "{margin}: {left}");
    }
    for file in ["plots/orbits.svg", "plots/animation.csv", "report.html", "response.csv"] {
        assert!(folder.path().join("t").join(file).exists(), "{file}");
    }
    let moving = std::fs::read_to_string(folder.path().join("t/plots/animation.svg")).unwrap();
    let report = std::fs::read_to_string(folder.path().join("t/report.html")).unwrap();
    assert_eq!(moving.matches("<animate ").count(), 13);
    assert_eq!(report.matches("<animate ").count(), 13);
    assert!(!moving.contains("NaN") && !moving.contains("inf"));

    let contact = ["simulate", "--controller", "pid.json", "--case", "contact", "--duration", "0.06", "--out", "c"];
    let (code, out, err) = muspin(&contact, folder.path());
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
    let met = summary["verdict"]["met"].as_bool().unwrap();
    let touch = &summary["simulation"]["backup_bearings"];
    assert_eq!(code, i32::from(!met), "{err}");
    assert_eq!(touch["recovers"], met);
    assert_eq!(touch["touches"], true);
    assert!(summary["speed_rpm"] == 50_000.0 && summary["force_n"].as_f64().unwrap() > 1500.0);
    assert_eq!(summary["push_s"], 5e-4);
    let push = |length: &str| {
        let rest = ["--case", "impulse", "--duration", "0.01", "--out", "p"];
        let begin = ["simulate", "--controller", "pid.json", "--push", length];
        muspin(&[&begin[..], &rest].concat(), folder.path())
    };
    let (code, out, err) = push("0.001");
    let longer: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(code < 2 && longer["push_s"] == 1e-3, "{err}");
    let (code, _, err) = push("1e-6");
    assert!(code == 2 && err.contains("sampling period"), "{err}");

    let lift = ["simulate", "--controller", "pid.json", "--case", "lift-off", "--duration", "0.4", "--out", "l"];
    let (code, out, err) = muspin(&lift, folder.path());
    assert_eq!(code, 0, "{err}");
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
    // Where the steps of the sensors make most of what is left, which depends on the last digits of the PID, the
    // sentence says so with the figures.
    let steps = &summary["simulation"]["quantisation"];
    let (left, part) =
        (steps["displacement_m"]["tool"].as_f64().unwrap(), steps["part_of_settled_displacement"].as_f64().unwrap());
    let cycle = if part > 0.5 {
        format!(
            "; what is left at the tool, {:.0} nm, is the limit cycle of the sensors' step of {:.0} nm",
            1e9 * left,
            1e9 * steps["quantum_m"].as_f64().unwrap()
        )
    } else {
        String::new()
    };
    assert_eq!(summary["verdict"]["sentence"], format!("the rotor lifts off and stays free{cycle}"));
    assert_eq!(muspin(&["export", "--controller", "absent.json"], folder.path()).0, 2);
    let bad = ["simulate", "--controller", "pid.json", "--case", "step", "--force", "-3"];
    assert_eq!(muspin(&bad, folder.path()).0, 2);
}
