//! Change of the controller at run time on the full machine: the exported C of a PID, of the μ controllers of two tools
//! and of a PD, in a loop with the sampled model of all modes (tests/firmware/hand_over.c).

use crate::export::firmware_c::{Case, main_prints};
use muspin::controller::ControlLaw;
use muspin::controller::realise::modal_form;
use muspin::controller::scaling::{SignalLimits, scale_realisation};
use muspin::controller::verification::growth_rate;
use muspin::export::table::controller_table;
use muspin::input::{load_controller, load_machine};
use muspin::linalg::Mat;
use muspin::lti::{Discrete, StateSpace};
use muspin::spindle::plant::AXES;
use muspin::spindle::{Machine, ModelDetail, Plant};
use std::f64::consts::TAU;
use std::fmt::Write;
use tempfile::TempDir;

const DRIVER: &str = include_str!("../../firmware/hand_over.c");

fn data(name: &str) -> String {
    format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn machine() -> Machine {
    let spindle = data("spindles/reference-updated.yaml");
    load_machine(&spindle, "paper-tool").unwrap()
}

fn law(name: &str) -> StateSpace<Discrete> {
    let file = data(&format!("designs/reference-updated/{name}"));
    let ControlLaw::Discrete(law) = load_controller(&file).unwrap().law else { panic!("sampled") };
    law
}

/// Decentralised kp (1 + T_d s/(1 + s/w_d)) by Tustin's rule, without an integrator: u = −K y.
fn pd(period_s: f64) -> StateSpace<Discrete> {
    let (derivative_s, corner) = (6e-4, TAU * 1000.0);
    let pole = (2.0 - corner * period_s) / (2.0 + corner * period_s);
    let step = 2.0 * derivative_s * corner / (2.0 + corner * period_s);
    let gain = |i: usize| if i < 2 { 12_200.0 } else { 7_200.0 };
    let diagonal = |f: &dyn Fn(usize) -> f64| Mat::from_fn(4, 4, |i, j| if i == j { f(i) } else { 0.0 });
    StateSpace::new(
        diagonal(&|_| pole),
        diagonal(&|_| 1.0),
        diagonal(&|i| -gain(i) * step * (pole - 1.0)),
        diagonal(&|i| -gain(i) * (1.0 + step)),
        Discrete { period_s },
    )
    .unwrap()
}

/// The sampled plant as C arrays: A, B (currents), E (force at the tool in x), C (displacements), LOAD.
fn plant_header(plant: &StateSpace<Discrete>, load_n: f64) -> String {
    let n = plant.order();
    let mut text = format!("#define N {n}\n#define LOAD {load_n:e}\n");
    let mut table = |name: &str, rows: usize, cols: usize, value: &dyn Fn(usize, usize) -> f64| {
        writeln!(text, "static const double {name}[{rows}][{cols}] = {{").unwrap();
        for i in 0..rows {
            let row: Vec<String> = (0..cols).map(|j| format!("{:e}", value(i, j))).collect();
            writeln!(text, "{{{}}},", row.join(",")).unwrap();
        }
        text.push_str("};\n");
    };
    table("A", n, n, &|i, j| plant.a[(i, j)]);
    table("B", n, AXES, &|i, j| plant.b[(i, j)]);
    table("C", AXES, n, &|i, j| plant.c[(i, j)]);
    table("E1", 1, n, &|_, j| plant.b[(j, AXES)]);
    text.push_str("static const double *const E = E1[0];\n");
    text
}

#[test]
fn a_change_of_controller_on_the_full_machine_has_no_jump_and_stays_within_the_clearance() {
    let machine = machine();
    let limits = SignalLimits { input_m: machine.spindle.backup_clearance_m, output_a: 3.0 };
    let period_s = machine.spindle.electronics.sample_period_s();
    let laws =
        [("pid", law("pid.json")), ("mu", law("mu.json")), ("other", law("mu-endmill-16.json")), ("pd", pd(period_s))];
    for rpm in [0.0, machine.spindle.max_rpm] {
        let plant = Plant::new(&machine, rpm * TAU / 60.0, ModelDetail::Full).unwrap();
        let plant = plant.sample_plant().unwrap();
        let axes: Vec<usize> = (0..AXES).collect();
        for (name, law) in &laws {
            let growth = growth_rate(&plant.select(&axes, &axes), law).unwrap();
            assert!(growth < 0.0, "{name} at {rpm} rpm: {growth}");
        }
        // The currents act a sample later at the earliest, so the displacements of a sample do not depend on them.
        assert!((0..AXES).all(|i| (0..AXES).all(|j| plant.d[(i, j)] == 0.0)));
        let folder = TempDir::new().unwrap();
        let cases: Vec<Case> = laws
            .iter()
            .map(|(name, law)| {
                let rows = scale_realisation(&modal_form(law).unwrap(), limits).unwrap();
                Case::new(law.clone(), rows, name)
            })
            .collect();
        let mut sources = vec!["controllers.c".to_owned(), "-lm".to_owned()];
        for case in &cases {
            case.write(&folder.path().join(case.prefix));
            sources.insert(0, format!("{}/controller.c", case.prefix));
        }
        let firmware: Vec<_> = cases.iter().map(Case::firmware).collect();
        for (name, bytes) in controller_table(&firmware).unwrap() {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        // The PD yields to a constant force at the tool by 13 µm a newton, because its rear bearing is soft.
        std::fs::write(folder.path().join("plant.h"), plant_header(&plant, 4.0)).unwrap();
        let sources: Vec<&str> = sources.iter().map(String::as_str).collect();
        let printed = main_prints(folder.path(), DRIVER, &sources);
        assert_eq!(printed.lines().count(), 16, "{printed}");
        for line in printed.lines() {
            let values: Vec<f64> = line.split(' ').map(|v| v.parse().unwrap()).collect();
            let (q31, jump_a, peak_um, moved_um) = (values[0] == 1.0, values[3], values[4], values[5]);
            // Single precision: terms of 10 A at most, each rounded to 6e-8 of itself, a hundred of them.
            assert!(jump_a < 1e-3, "{rpm} rpm, Q31 {q31}: the current jumps by {jump_a} A: {printed}");
            // A quarter of the clearance.
            assert!(peak_um < 63.0, "{rpm} rpm: {peak_um} µm: {printed}");
            assert!(moved_um < 1.0, "{rpm} rpm: still moves by {moved_um} µm: {printed}");
        }
    }
}
