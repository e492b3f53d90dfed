//! The thrust axis: the plant against its equations of motion, the loop in time and over frequency against these, the
//! C of its controller, and what a file may say of it.

use crate::cli::program::muspin;
use crate::export::firmware_c::Case;
use muspin::controller::ControlLaw;
use muspin::input::spindle::read_spindle;
use muspin::input::write::spindle_yaml;
use muspin::linalg::c64;
use muspin::lti::{Discrete, Response, StateSpace};
use muspin::pipeline::thrust::{ThrustDesign, design_thrust};
use muspin::spindle::{Machine, ThrustAxis, ThrustBearing};
use std::f64::consts::{PI, TAU};

const RIGID: ThrustBearing = ThrustBearing {
    ki_n_per_a: 250.0,
    ks_n_per_m: 1.2e6,
    bias_current_a: 3.0,
    max_current_a: 8.0,
    gap_m: 4e-4,
    mass_kg: None,
    disc_mass_kg: None,
    disc_mode_hz: None,
    disc_damping_ratio: None,
    eddy_corner_hz: None,
};

fn machine(spindle: &str, thrust: ThrustBearing) -> Machine {
    let path = format!("{}/tests/data/spindles/{spindle}.yaml", env!("CARGO_MANIFEST_DIR"));
    let mut machine = muspin::input::load_machine(&path, "paper-tool").unwrap();
    machine.spindle.thrust = Some(thrust);
    machine
}

/// Rigid and flexible discs, solid and laminated cores, on rotors of 0.7 to 8 kg at 10 to 25 kHz.
fn machines() -> [Machine; 5] {
    let flexible = ThrustBearing {
        disc_mass_kg: Some(0.9),
        disc_mode_hz: Some(1900.0),
        disc_damping_ratio: Some(0.004),
        mass_kg: Some(7.5),
        ..RIGID
    };
    let both = ThrustBearing {
        ki_n_per_a: 250.0,
        ks_n_per_m: 1.2e6,
        mass_kg: Some(9.1),
        disc_damping_ratio: Some(0.002),
        eddy_corner_hz: Some(300.0),
        ..flexible
    };
    let small = ThrustBearing { ki_n_per_a: 90.0, ks_n_per_m: 3e5, ..RIGID };
    let solid = ThrustBearing { eddy_corner_hz: Some(400.0), ks_n_per_m: 4e5, ..RIGID };
    [
        machine("reference-updated", RIGID),
        machine("reference-updated", flexible),
        machine("reference-updated", both),
        machine("s01-short-fast", small),
        machine("s04-noncollocated", solid),
    ]
}

/// Displacement of the shaft per force of the magnet and per load, from the equations of motion.
fn receptances(axis: &ThrustAxis, s: c64) -> [c64; 2] {
    let (b, m) = (&axis.bearing, axis.mass_kg);
    let Some((disc, hz)) = b.disc_mass_kg.zip(b.disc_mode_hz) else {
        let h = (s * s * m - b.ks_n_per_m).inv();
        return [h, h];
    };
    let w = TAU * hz;
    let coupling = s * (2.0 * b.disc_damping_ratio.unwrap() * w * disc) + disc * w * w;
    // [m_d s² − k_s + k, −k; −k, (m − m_d) s² + k] by Cramer's rule.
    let (first, second) = (s * s * disc - b.ks_n_per_m + coupling, s * s * (m - disc) + coupling);
    let determinant = first * second - coupling * coupling;
    [coupling / determinant, first / determinant]
}

/// Current to force and displacement to signal, without the delay.
fn electronics(axis: &ThrustAxis, s: c64) -> [c64; 2] {
    let lag = |hz: f64| (s / (TAU * hz) + 1.0).inv();
    let eddy = axis.bearing.eddy_corner_hz.map_or(c64::new(1.0, 0.0), |hz| ((s / (TAU * hz)).sqrt() + 1.0).inv());
    let e = &axis.electronics;
    [lag(e.amplifier_bandwidth_hz) * eddy * axis.bearing.ki_n_per_a, lag(e.sensor_bandwidth_hz)]
}

#[test]
fn the_plant_follows_its_equations_of_motion() {
    for machine in machines() {
        let axis = ThrustAxis::of(&machine).unwrap().unwrap();
        if axis.bearing.mass_kg.is_none() {
            let own = machine.rotor().unwrap().mass_properties().mass_kg;
            assert!((axis.mass_kg - own).abs() < 1e-12 * own);
        }
        let plant = axis.plant_without_delay().unwrap();
        // The rational form of the eddy currents is within 1 % of the half-order lag.
        let tolerance = if axis.bearing.eddy_corner_hz.is_some() { 0.01 } else { 1e-9 };
        for hz in [1.0, 30.0, 95.0, 600.0, 1899.0, 5000.0] {
            let s = c64::new(0.0, TAU * hz);
            let ([by_magnet, by_load], [force, signal]) = (receptances(&axis, s), electronics(&axis, s));
            let expected = [[signal * by_magnet * force, signal * by_load], [by_magnet * force, by_load]];
            let found = plant.at(TAU * hz);
            for (i, row) in expected.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    let error = (found[(i, j)] - value).norm() / value.norm();
                    assert!(error < tolerance, "{hz} Hz, {i} {j}: {error}");
                }
            }
        }
    }
}

fn law(design: &ThrustDesign) -> &StateSpace<Discrete> {
    match &design.pid.controller.law {
        ControlLaw::Discrete(law) => law,
        ControlLaw::Continuous(_) => panic!("not sampled"),
    }
}

/// Smallest stiffness within the band of a machine, largest |S| to Nyquist and current from sensor noise, from the
/// equations of motion and the response of the controller as it runs.
fn figures(machine: &Machine, design: &ThrustDesign) -> [f64; 3] {
    let (axis, law) = (&design.axis, law(design));
    let period_s = law.time.period_s;
    let (mut stiffness, mut peak, mut power) = (f64::INFINITY, 0.0f64, 0.0);
    let last = 0.5 / period_s * 0.98;
    for k in 0..20_000 {
        let hz = (last.ln() * f64::from(k) / 19_999.0).exp();
        let (w, s) = (TAU * hz, c64::new(0.0, TAU * hz));
        let ([by_magnet, by_load], [force, signal]) = (receptances(axis, s), electronics(axis, s));
        let half = 0.5 * w * period_s;
        let delay = axis.electronics.delay_s.max(0.5 * period_s);
        let current = law.at(w)[(0, 0)] * (half.sin() / half) * c64::new(0.0, -w * delay).exp() * force;
        let sensitivity = (c64::new(1.0, 0.0) - signal * by_magnet * current).inv();
        peak = peak.max(sensitivity.norm());
        power += (law.at(w)[(0, 0)] * sensitivity).norm_sqr() * hz * last.ln() / 19_999.0;
        let (from, to) = machine.spindle.stiffness_band_hz;
        if (from..=to).contains(&hz) {
            let compliance = by_load + by_magnet * current * sensitivity * signal * by_load;
            stiffness = stiffness.min(compliance.norm().recip());
        }
    }
    // White noise of the sensors has its power evenly up to Nyquist.
    [stiffness, peak, axis.electronics.sensor_noise_m * (power * 2.0 * period_s).sqrt()]
}

#[test]
fn the_figures_of_a_thrust_pid_are_those_of_the_equations() {
    for machine in machines() {
        let design = design_thrust(&machine).unwrap().unwrap();
        let [stiffness, peak, noise_a] = figures(&machine, &design);
        let pid = &design.pid;
        assert!((pid.minimum.0 / stiffness - 1.0).abs() < 0.02, "{} for {stiffness}", pid.minimum.0);
        assert!((pid.noise_current_a / noise_a - 1.0).abs() < 0.02, "{} for {noise_a}", pid.noise_current_a);
        assert!((pid.sensitivity_peak / peak - 1.0).abs() < 0.02, "{} for {peak}", pid.sensitivity_peak);
        // Zone A of ISO 14839-3, and no softer than the magnet is unstable.
        assert!(peak < 3.0 && stiffness > 0.1 * design.axis.bearing.ks_n_per_m, "{peak}, {stiffness}");
        assert!(pid.noise_current_a <= 0.1 * 1.02 && design.verification.is_stable());
    }
}

/// Displacement of a rigid shaft over time under a static load, from small steps of the equations of motion with the
/// controller at its samples.
fn displacements(design: &ThrustDesign, load_n: f64, seconds: f64) -> Vec<f64> {
    let (axis, law) = (&design.axis, law(design));
    let (b, e, period_s) = (&axis.bearing, &axis.electronics, law.time.period_s);
    let late_s = e.delay_s.max(0.5 * period_s) - 0.5 * period_s;
    const STEPS: usize = 40;
    let step_s = period_s / STEPS as f64;
    let late = (late_s / step_s).round() as usize;
    let mut state = vec![0.0; law.order()];
    // Displacement, velocity, coil current, signal.
    let mut x = [0.0; 4];
    let mut commands = std::collections::VecDeque::from(vec![0.0; late + 1]);
    let mut found = vec![];
    for _ in 0..(seconds / period_s) as usize {
        let y = x[3];
        let row = |m: &muspin::linalg::Mat<f64>, i: usize| (0..law.order()).map(|j| m[(i, j)] * state[j]).sum::<f64>();
        let command = row(&law.c, 0) + law.d[(0, 0)] * y;
        let next: Vec<f64> = (0..law.order()).map(|i| row(&law.a, i) + law.b[(i, 0)] * y).collect();
        for _ in 0..STEPS {
            commands.push_back(command);
            let acting = commands.pop_front().unwrap();
            let slope = |x: [f64; 4]| {
                let force = b.ki_n_per_a * x[2] + b.ks_n_per_m * x[0] + load_n;
                [
                    x[1],
                    force / axis.mass_kg,
                    TAU * e.amplifier_bandwidth_hz * (acting - x[2]),
                    TAU * e.sensor_bandwidth_hz * (x[0] - x[3]),
                ]
            };
            let ahead = |x: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| x[i] + h * k[i]);
            let k1 = slope(x);
            let k2 = slope(ahead(x, k1, 0.5 * step_s));
            x = ahead(x, k2, step_s);
        }
        state = next;
        found.push(x[0]);
    }
    found
}

#[test]
fn a_static_load_moves_the_shaft_and_the_integrator_brings_it_back() {
    for machine in machines()
        .into_iter()
        .filter(|m| m.spindle.thrust.is_some_and(|t| t.disc_mass_kg.is_none() && t.eddy_corner_hz.is_none()))
    {
        let design = design_thrust(&machine).unwrap().unwrap();
        let decay = -design.pid.growth_rate_per_s;
        assert!(decay > 0.0);
        // Ten time constants of the slowest pole.
        let moved = displacements(&design, 100.0, (10.0 / decay).min(20.0));
        let largest = moved.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        let end = moved.last().unwrap().abs();
        let static_m = 100.0 / design.pid.minimum.0;
        assert!(largest > 0.2 * static_m && largest < 3.0 * static_m, "{largest} for {static_m}");
        assert!(end < 0.02 * largest, "{end} of {largest}, decay {decay}");
    }
}

#[test]
fn the_firmware_of_the_thrust_axis_has_one_channel_and_is_stable() {
    let design = design_thrust(&machines()[0]).unwrap().unwrap();
    let case = Case::new(law(&design).clone(), design.realisation.clone(), "axis");
    let folder = tempfile::TempDir::new().unwrap();
    case.write(folder.path());
    let header = std::fs::read_to_string(folder.path().join("controller.h")).unwrap();
    assert!(header.contains("#define AXIS_INPUTS 1\n") && header.contains("displacements axial, m"), "{header}");
    let text = "#include <stdio.h>\n#include \"controller.h\"\nint main(void) {\n    axis_f32 k;\n    axis_f32_init(&k);\n    \
                float y[1] = {1e-6f}, u[1];\n    axis_f32_step(&k, y, u);\n    printf(\"%.9g\", (double)u[0]);\n    \
                return 0;\n}\n";
    let printed: f64 = crate::export::firmware_c::main_prints(folder.path(), text, &["controller.c"]).parse().unwrap();
    let exact = law(&design).d[(0, 0)] * 1e-6;
    assert!((printed / exact - 1.0).abs() < 1e-5, "{printed} for {exact}");
    assert!(design.verification.is_stable() && design.verification.speeds.len() == 2);
    let limits = design.realisation.limits;
    assert!((limits.input_m, limits.output_a) == (2e-4, 3.0));
}

#[test]
fn a_file_says_a_thrust_axis_and_is_read_again() {
    let path = format!("{}/tests/data/spindles/reference-updated.yaml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let with = |keys: &str| format!("{text}\nthrust: {{ki_n_per_a: 250, ks_n_per_m: 1.2e+6, {keys}}}\n");
    let coils = "bias_current_a: 3, max_current_a: 8, gap_m: 4.0e-4";
    let read = read_spindle("s.yaml", &with(&format!("{coils}, eddy_corner_hz: 300"))).unwrap();
    assert_eq!(read.thrust, Some(ThrustBearing { eddy_corner_hz: Some(300.0), ..RIGID }));
    assert_eq!(read_spindle("again.yaml", &spindle_yaml(&read)).unwrap().thrust, read.thrust);
    assert!(read_spindle("s.yaml", &text).unwrap().thrust.is_none());
    for (keys, words) in [
        ("bias_current_a: 3, max_current_a: 2, gap_m: 4.0e-4", "thrust.max_current_a"),
        (&format!("{coils}, disc_mass_kg: 1"), "thrust.disc_mass_kg"),
        (&format!("{coils}, disc_mode_hz: -1, disc_mass_kg: 1"), "thrust.disc_mode_hz"),
        (&format!("{coils}, mass: 1"), "mass"),
    ] {
        let error = read_spindle("s.yaml", &with(keys)).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("s.yaml"), "{error}");
    }
    // A disc as heavy as all that the magnet carries is no disc on a shaft.
    let heavy = ThrustBearing { mass_kg: Some(2.0), disc_mass_kg: Some(2.0), disc_mode_hz: Some(900.0), ..RIGID };
    let error = ThrustAxis::of(&machine("reference-updated", heavy)).unwrap_err().to_string();
    assert!(error.contains("thrust.disc_mass_kg") && error.contains("smaller"), "{error}");
}

#[test]
fn an_axis_that_no_pid_holds_says_so() {
    // The magnet pushes the shaft out with 1/e in half the delay: no loop can be that fast.
    let delay_s = machine("reference-updated", RIGID).spindle.electronics.delay_s;
    let wild = ThrustBearing { mass_kg: Some(1.2e6 * (0.5 * delay_s / PI).powi(2)), ..RIGID };
    let error = design_thrust(&machine("reference-updated", wild)).unwrap_err().to_string();
    assert!(error.contains("thrust axis") && error.contains("grows by"), "{error}");
}

#[test]
fn a_design_has_the_thrust_axis_beside_it_and_is_the_same_without() {
    let folder = tempfile::TempDir::new().unwrap();
    let text = spindle_yaml(&machine("reference-updated", RIGID).spindle);
    let (thrust, without): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with("thrust:"));
    assert_eq!(thrust.len(), 1);
    std::fs::write(folder.path().join("with.yaml"), &text).unwrap();
    std::fs::write(folder.path().join("without.yaml"), without.join("\n") + "\n").unwrap();
    let found = ["with", "without"].map(|name| {
        let spindle = format!("{name}.yaml");
        let arguments =
            ["design", "--no-polish", "--spindle", &spindle, "--tool", "paper-tool", "--out", name, "--text"];
        let (code, said, errors) = muspin(&arguments, folder.path());
        assert!(code <= 1, "{errors}");
        let out = folder.path().join(name);
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        (said, serde_json::from_str::<serde_json::Value>(&summary).unwrap(), out)
    });
    let [(said, mut summary, out), (said_without, summary_without, out_without)] = found;
    assert!(said.contains("Thrust axis: PID, smallest stiffness") && !said_without.contains("Thrust"), "{said}");
    let own = summary.as_object_mut().unwrap().remove("thrust").unwrap();
    assert!(own["zone"] == "A" && own["proven_stable"] == true, "{own}");
    assert_eq!(summary, summary_without);
    let files = out.join("controller/thrust");
    let header = std::fs::read_to_string(files.join("controller.h")).unwrap();
    assert!(header.contains("displacements axial, m") && header.contains("_VERIFIED 1"), "{header}");
    let law = std::fs::read_to_string(files.join("discrete.json")).unwrap();
    assert!(law.contains("\"inputs\":[\"axial\"]") && law.contains("../../spindle.yaml"), "{law}");
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Thrust axis") && out.join("plots/thrust.svg").is_file());
    assert!(!out_without.join("controller/thrust").exists());
}
