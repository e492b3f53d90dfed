//! Anti-windup: the law alone, its gain against closed forms, and the rotor that comes back from its backup bearings.

use muspin::controller::ControlLaw;
use muspin::controller::anti_windup::{anti_windup, with_anti_windup};
use muspin::controller::arithmetic::{Float32Program, float32, q31};
use muspin::controller::realise::modal_form;
use muspin::controller::scaling::{ScaledRealisation, SignalLimits, scale_realisation};
use muspin::controller::sections::second_order_sections;
use muspin::input::{load_controller, load_machine};
use muspin::linalg::{Mat, eigenvalues};
use muspin::lti::{Discrete, StateSpace};
use muspin::predict::recovery::{Recovery, touching_force_n};
use muspin::predict::time::TimeSettings;
use muspin::predict::time_cases::{StandardCase, run_case};
use muspin::spindle::{BackupBearings, Machine};
use std::f64::consts::TAU;

const LIMITS: SignalLimits = SignalLimits { input_m: 2.54e-4, output_a: 3.0 };

/// A spindle with updated moduli, its μ controller (order 36, slowest real modes at 73 and 81 1/s) and a tuned PID.
fn file(name: &str) -> String {
    format!("{}/tests/data/anti_windup/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn machine() -> Machine {
    load_machine(&file("spindle.yaml"), &file("tool.yaml")).unwrap()
}

fn law(name: &str) -> StateSpace<Discrete> {
    let ControlLaw::Discrete(law) = load_controller(&file(name)).unwrap().law else { panic!("sampled") };
    law
}

fn conditioned(law: &StateSpace<Discrete>) -> ScaledRealisation {
    let rows = scale_realisation(&modal_form(law).unwrap(), LIMITS).unwrap();
    with_anti_windup(rows, &machine()).unwrap().0
}

/// Four times the same axis: a slow pole that decays at 80 1/s beside a fast one, u = (c₁/(z − a₁) + c₂/(z − a₂) + d)
/// y.
fn lag() -> StateSpace<Discrete> {
    let period_s = 5e-5;
    let (slow, fast) = (f64::exp(-80.0 * period_s), 0.3);
    let n = 8;
    StateSpace::new(
        Mat::from_fn(n, n, |i, j| match (i == j, i % 2) {
            (true, 0) => slow,
            (true, _) => fast,
            _ => 0.0,
        }),
        Mat::from_fn(n, 4, |i, j| f64::from(u8::from(i / 2 == j))),
        Mat::from_fn(4, n, |i, j| match (j / 2 == i, j % 2) {
            (true, 0) => -400.0,
            (true, _) => -2.0e4,
            _ => 0.0,
        }),
        Mat::from_fn(4, 4, |i, j| if i == j { -3.0e4 } else { 0.0 }),
        Discrete { period_s },
    )
    .unwrap()
}

#[test]
fn a_slow_mode_moves_to_twice_the_rate_less_its_own() {
    // A static plant that the controller stabilises at every gain: the fastest rate of the grid is taken, and the
    // closed form of least energy puts a real mode with the rate r to 2α − r.
    let law = lag();
    let plant = StateSpace::gain(Mat::from_fn(4, 4, |i, j| if i == j { 1e-7 } else { 0.0 }), law.time);
    let rows = scale_realisation(&modal_form(&law).unwrap(), LIMITS).unwrap().rows;
    let found = anti_windup(&rows, &[plant]).unwrap();
    assert!(found.rate_1_s > 1000.0, "{}", found.rate_1_s);
    let system = rows.to_state_space().unwrap();
    let inner = &system.a - &found.gain * &system.c;
    let moved = (-(2.0 * found.rate_1_s - 80.0) * law.time.period_s).exp();
    let mut radii: Vec<f64> = eigenvalues(&inner).unwrap().iter().map(|z| z.norm()).collect();
    radii.sort_by(f64::total_cmp);
    for (k, radius) in radii.iter().enumerate() {
        let expected = if k < 4 { 0.3 } else { moved };
        assert!((radius - expected).abs() < 1e-9, "{k}: {radius} {expected}");
    }
    let forgetting = -moved.ln() / law.time.period_s;
    assert!((found.forgetting_1_s / forgetting - 1.0).abs() < 1e-9);
    assert!(found.smallest_gain <= found.smallest_gain_without);
}

#[test]
fn an_unstable_loop_gets_no_anti_windup() {
    let law = lag();
    // K is negative: with this sign the loop gain at rest is 2e-5 · (3e4 + 2.9e4 + 1e5) = 3.1 > 1.
    let plant = StateSpace::gain(Mat::from_fn(4, 4, |i, j| if i == j { -2e-5 } else { 0.0 }), law.time);
    let rows = scale_realisation(&modal_form(&law).unwrap(), LIMITS).unwrap().rows;
    let found = anti_windup(&rows, &[plant]).unwrap();
    assert_eq!(found.gain.norm_max(), 0.0);
    assert_eq!(found.rate_1_s, 0.0);
}

#[test]
fn sections_and_modal_form_have_the_same_anti_windup() {
    let law = law("pid.json");
    let machine = machine();
    let modal = scale_realisation(&modal_form(&law).unwrap(), LIMITS).unwrap();
    let sections = scale_realisation(&second_order_sections(&law).unwrap(), LIMITS).unwrap();
    let (_, a) = with_anti_windup(modal, &machine).unwrap();
    let (_, b) = with_anti_windup(sections, &machine).unwrap();
    assert_eq!(a.rate_1_s, b.rate_1_s);
    // The gain as a transfer matrix does not depend on the coordinates; nor do the numbers that follow from it.
    assert!((a.smallest_gain - b.smallest_gain).abs() < 1e-6);
    assert!((a.circle_gain - b.circle_gain).abs() < 1e-6);
    assert!((a.forgetting_1_s / b.forgetting_1_s - 1.0).abs() < 1e-6);
}

/// Output of axis 0 over `after` samples at zero input, after one second at `input_m` on axis 0.
fn after_a_second(program: &mut Float32Program, input_m: f32, after: usize) -> Vec<f32> {
    for _ in 0..20_000 {
        program.step(&[input_m, 0.0, 0.0, 0.0]);
    }
    (0..after).map(|_| program.step(&[0.0; 4])[0]).collect()
}

#[test]
fn a_second_beyond_the_limit_is_forgotten_within_milliseconds() {
    let law = lag();
    let plant = StateSpace::gain(Mat::from_fn(4, 4, |i, j| if i == j { 1e-7 } else { 0.0 }), law.time);
    let rows = scale_realisation(&modal_form(&law).unwrap(), LIMITS).unwrap();
    let found = anti_windup(&rows.rows, &[plant]).unwrap();
    let without = float32(&rows).unwrap();
    let with = float32(&ScaledRealisation {
        conditioning: (0..8)
            .map(|i| {
                (0..4)
                    .filter(|j| found.gain[(i, *j)] != 0.0)
                    .map(|j| muspin::controller::realise::ProductTerm { source: j, coefficient: found.gain[(i, j)] })
                    .collect()
            })
            .collect(),
        ..rows
    })
    .unwrap();
    let limited = |program: &Float32Program| {
        let tail = after_a_second(&mut program.clone(), 5e-4, 4000);
        tail.iter().rposition(|u| u.abs() >= 3.0).map_or(0, |k| k + 1)
    };
    // 20 samples are a millisecond.
    assert!(limited(&without) > 400, "{}", limited(&without));
    assert!(limited(&with) < 60, "{}", limited(&with));
}

#[test]
fn within_the_limits_nothing_changes() {
    let law = law("mu.json");
    let rows = scale_realisation(&modal_form(&law).unwrap(), LIMITS).unwrap();
    let conditioned = conditioned(&law);
    assert!(conditioned.conditioning.iter().any(|row| !row.is_empty()));
    let (mut without, mut with) = (float32(&rows).unwrap(), float32(&conditioned).unwrap());
    let mut differs = false;
    for k in 0..2000 {
        // Some 0.2 µm inside the limits; at the end far beyond them.
        let size = if k < 1900 { 2e-7 } else { 2e-4 };
        let y: Vec<f32> = (0..4).map(|j| size * ((0.13 * k as f32 + j as f32).sin())).collect();
        let (a, b) = (without.step(&y), with.step(&y));
        if k < 1900 {
            assert!(a.iter().all(|u| u.abs() < 3.0));
            assert_eq!(a, b, "sample {k}");
        }
        differs |= a != b;
    }
    assert!(differs, "beyond the limits the law acts");
}

fn pushed_on(machine: &Machine, program: &Float32Program, settings: &TimeSettings, force_n: f64, rpm: f64) -> Recovery {
    let push = StandardCase::Impulse { force_n, length_s: 5e-4 };
    let speed = rpm * TAU / 60.0;
    let found = run_case(machine, program, push, speed, 0.08, settings).unwrap();
    let recovery = Recovery::of(machine, &found);
    assert_eq!(recovery == Recovery::Clear, found.in_contact == 0.0);
    recovery
}

fn pushed(program: &Float32Program, force_n: f64, rpm: f64) -> Recovery {
    pushed_on(&machine(), program, &TimeSettings::default(), force_n, rpm)
}

/// A spindle whose sensors stand far from its magnets, and the controllers of a run; the μ controller has unstable
/// modes of its own (a pair that grows by 584 1/s).
fn other_machine() -> (Machine, impl Fn(&str) -> StateSpace<Discrete>) {
    let data = |name: &str| format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    let spindle = data("spindles/s04-noncollocated.yaml");
    let law = move |name: &str| {
        let file = data(&format!("designs/s04-noncollocated/{name}"));
        let ControlLaw::Discrete(law) = load_controller(&file).unwrap().law else { panic!("sampled") };
        law
    };
    (load_machine(&spindle, "endmill-12-long").unwrap(), law)
}

fn other_conditioned(machine: &Machine, law: &StateSpace<Discrete>) -> ScaledRealisation {
    let limits = SignalLimits { input_m: machine.spindle.backup_clearance_m, output_a: 3.0 };
    let rows = scale_realisation(&modal_form(law).unwrap(), limits).unwrap();
    with_anti_windup(rows, machine).unwrap().0
}

#[test]
fn the_correction_never_drives_a_state_to_its_clamp() {
    let (machine, other) = other_machine();
    let cases = [
        conditioned(&law("mu.json")),
        other_conditioned(&machine, &other("mu.json")),
        other_conditioned(&machine, &other("pid.json")),
    ];
    for rows in cases {
        let system = rows.rows.to_state_space().unwrap();
        let n = system.order();
        let mut x = Mat::<f64>::zeros(n, 1);
        let mut largest = 0.0f64;
        for k in 0..20_000 {
            // Displacements that jump from stop to stop, at rates that pass through all modes.
            let period = 3 + k / 40;
            let y = Mat::from_fn(4, 1, |i, _| {
                let up = (k / period + i / 2).is_multiple_of(2);
                if up { rows.limits.input_m } else { -rows.limits.input_m }
            });
            let v = &system.c * &x + &system.d * &y;
            x = &system.a * &x + &system.b * &y;
            for (i, row) in rows.conditioning.iter().enumerate() {
                for term in row {
                    let wanted = v[(term.source, 0)];
                    let limit = rows.limits.output_a;
                    x[(i, 0)] += term.coefficient * (wanted.clamp(-limit, limit) - wanted);
                }
                if rows.anti_windup[i] {
                    x[(i, 0)] = x[(i, 0)].clamp(-1.0, 1.0);
                } else {
                    largest = largest.max(x[(i, 0)].abs());
                }
            }
        }
        // The bound is for the worst of all signals; these come within some powers of two of it.
        assert!(largest <= 1.0 && largest > 0.02, "{largest}");
    }
}

#[test]
fn an_unstable_controller_pushes_back_from_either_stop() {
    let (machine, other) = other_machine();
    let rows = other_conditioned(&machine, &other("mu.json"));
    let (mut single, mut fixed) = (float32(&rows).unwrap(), q31(&rows).unwrap());
    for side in [1.0, -1.0, 1.0] {
        // At a stop for 20 ms: the current must have the sign that leaves it, u = K y with K restoring.
        let y = [3e-4 * side, 0.0, 3e-4 * side, 0.0];
        let coded = y.map(|v| fixed.encode_input(v));
        let (mut u, mut q) = (vec![], vec![]);
        for _ in 0..400 {
            u = single.step(&y.map(|v| v as f32));
            q = fixed.step(&coded);
        }
        for axis in [0, 2] {
            let q = fixed.decode_output(q[axis]);
            assert!(f64::from(u[axis]) * side < -2.9, "float32, axis {axis}: {u:?}");
            assert!(q * side < -2.9, "Q31, axis {axis}: {q}");
        }
    }
}

#[test]
fn the_rotor_of_another_machine_comes_back_with_either_controller() {
    let (mut machine, other) = other_machine();
    // The controller with unstable modes of its own comes back only just, so that contact and modes are stated.
    machine.spindle.backup_bearings = BackupBearings {
        contact_stiffness_n_per_m: Some(3.0e7),
        contact_damping_n_s_per_m: Some(3.0e3),
        friction: Some(0.1),
        contact_radius_m: Some(0.02),
    };
    let top = machine.spindle.max_rpm;
    let touching = touching_force_n(&machine, 3.0, 5e-4).unwrap();
    // While it is limited, the μ controller with unstable modes of its own swings at 1.4 kHz from limit to limit. Coils
    // at 300 V cannot follow that, and the rotor stays lost; at 1000 V they can.
    for (name, bus_voltage_v) in [("mu.json", 1000.0), ("pid.json", 300.0)] {
        let program = float32(&other_conditioned(&machine, &other(name))).unwrap();
        let settings = TimeSettings { bus_voltage_v, flexible_modes: Some(6), ..TimeSettings::default() };
        for (rpm, force_n) in [(0.0, 1000.0), (0.0, touching), (top, 1500.0)] {
            let recovery = pushed_on(&machine, &program, &settings, force_n, rpm);
            assert!(recovery != Recovery::Lost, "{name}: {force_n} N at {rpm} rpm");
        }
    }
}

#[test]
fn the_rotor_comes_back_from_its_backup_bearings() {
    for name in ["mu.json", "pid.json"] {
        let program = float32(&conditioned(&law(name))).unwrap();
        for rpm in [0.0, 25_000.0, 50_000.0] {
            for force_n in [1000.0, 1500.0] {
                let recovery = pushed(&program, force_n, rpm);
                let touched = match recovery {
                    Recovery::Lost => panic!("{name}: {force_n} N at {rpm} rpm"),
                    Recovery::Clear => 0.0,
                    Recovery::Recovered { after_s } => after_s,
                };
                assert!(touched < 0.03, "{name}: {touched} s");
            }
        }
    }
}

#[test]
fn without_anti_windup_the_same_push_is_the_end() {
    let rows = scale_realisation(&modal_form(&law("mu.json")).unwrap(), LIMITS).unwrap();
    assert_eq!(pushed(&float32(&rows).unwrap(), 1000.0, 0.0), Recovery::Lost);
}

#[test]
fn the_push_that_touches_does_the_work_of_both_bearings() {
    let machine = machine();
    let force = touching_force_n(&machine, 3.0, 5e-4).unwrap();
    // Half-sine impulse 2FT/π on the rigid rotor: its energy is (270 + 115.4) · 3 N over 254 µm.
    let body = machine.rotor().unwrap().mass_properties();
    let impulse = 2.0 * force * 5e-4 / std::f64::consts::PI;
    let lever = machine.tool_plane_m() - body.centre_of_gravity_m;
    let (v, w) = (impulse / body.mass_kg, impulse * lever / body.diametral_inertia_kg_m2);
    let energy = 0.5 * body.mass_kg * v * v + 0.5 * body.diametral_inertia_kg_m2 * w * w;
    assert!((energy / (385.4 * 3.0 * 2.54e-4) - 1.0).abs() < 1e-12);
    // Twice as long, half the peak.
    let long = touching_force_n(&machine, 3.0, 1e-3).unwrap();
    assert!((force / long - 2.0).abs() < 1e-12);
}
