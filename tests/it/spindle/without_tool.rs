//! Machines without a tool, discs by dimensions and bearings whose axes differ, against the same bodies written in
//! another way.

use crate::cli::program::muspin;
use crate::spindle::spindle_plant::{block_error, krpm};
use muspin::input::{load_machine, load_spindle, read_spindle};
use muspin::lti::Response;
use muspin::spindle::{Machine, ModelDetail, Plant, Spindle, Tool};
use std::f64::consts::{PI, TAU};
use std::path::Path;
use tempfile::TempDir;

const SPINDLE: &str = include_str!("../../../spindles/reference.yaml");

fn plant(machine: &Machine, rpm_in_thousands: f64) -> Plant {
    Plant::new(machine, krpm(rpm_in_thousands), ModelDetail::Full).unwrap()
}

fn changed(from: &str, to: &str) -> Spindle {
    assert!(SPINDLE.contains(from), "{from}");
    read_spindle("spindle.yaml", &SPINDLE.replacen(from, to, 1)).unwrap()
}

/// The first element of the shaft as a tool, the place of the output on its face or inside.
fn nose_as_tool(spindle: &Spindle, output_m: f64) -> Machine {
    let mut rest = spindle.clone();
    let first = rest.sections.remove(0);
    let length = first.length_m;
    rest.discs.iter_mut().for_each(|disc| disc.position_m -= length);
    let planes = &mut rest.planes;
    let all = [
        &mut planes.front_sensor_m,
        &mut planes.front_actuator_m,
        &mut planes.rear_actuator_m,
        &mut planes.rear_sensor_m,
    ];
    all.into_iter().for_each(|z| *z -= length);
    let tool = Tool {
        name: "nose".into(),
        sections: vec![first],
        discs: vec![],
        tool_plane_m: length - output_m,
        teeth: None,
    };
    Machine::new(rest, tool).unwrap()
}

#[test]
fn a_shaft_without_a_tool_is_the_shaft_whose_nose_is_called_a_tool() {
    let spindle = load_spindle("reference").unwrap();
    let inside = 0.4 * spindle.sections[0].length_m;
    for output_m in [None, Some(inside)] {
        let own = Machine::without_tool(Spindle { output_m, ..spindle.clone() }).unwrap();
        let same = nose_as_tool(&spindle, output_m.unwrap_or(0.0));
        for rpm in [0.0, 45.0] {
            let (own, same) = (plant(&own, rpm), plant(&same, rpm));
            for hz in [7.0, 480.0, 1400.0, 2700.0] {
                let error = block_error(&own.at(TAU * hz), &same.at(TAU * hz));
                assert!(error < 1e-8, "{output_m:?} {rpm} {hz} Hz: {error:.1e}");
            }
        }
    }
}

#[test]
fn an_output_off_the_shaft_and_an_effect_of_a_tool_are_refused() {
    let bad = read_spindle("s.yaml", &format!("{SPINDLE}\noutput_m: 2.0\n"));
    assert!(bad.unwrap_err().to_string().contains("output_m"));
    let spindle = read_spindle("s.yaml", &SPINDLE.replacen("effects: []", "", 1)).unwrap();
    let text =
        format!("{}\neffects:\n  - {{effect: tool_mass, mass_kg: 0.05}}\n", SPINDLE.replacen("effects: []", "", 1));
    let with = read_spindle("s.yaml", &text).unwrap();
    assert!(Machine::without_tool(spindle).is_ok());
    assert!(Machine::without_tool(with).unwrap_err().to_string().contains("needs a tool"));
}

/// m = ρπ(D² − d²)t/4, m(R² + r²)/2 about the axis, m(3(R² + r²) + t²)/12 about a diameter.
#[test]
fn a_disc_by_its_dimensions_has_their_mass_and_inertia() {
    let spindle = load_spindle("reference").unwrap();
    let at = spindle.sections[0].length_m;
    let (thick, outer, inner) = (0.012, 0.11, 0.03);
    let name = spindle.sections[0].material.name.clone();
    let disc = format!(
        "  discs:\n    - {{position_m: {at}, thickness_m: {thick}, outer_diameter_m: {outer}, inner_diameter_m: {inner}, \
         material: {name}}}\n"
    );
    let lines: Vec<&str> =
        SPINDLE.lines().filter(|line| !line.contains("position_m:") && line.trim() != "discs:").collect();
    let text = lines.join("\n").replacen("  damping_ratio:", &format!("{disc}  damping_ratio:"), 1);
    let found = read_spindle("s.yaml", &text).unwrap().discs[0];
    let mass = spindle.sections[0].material.density_kg_m3 * PI * (outer * outer - inner * inner) * thick / 4.0;
    let squares = 0.25 * (outer * outer + inner * inner);
    let expected = [mass, 0.5 * mass * squares, mass * (3.0 * squares + thick * thick) / 12.0];
    let own = [found.mass_kg, found.polar_inertia_kg_m2, found.diametral_inertia_kg_m2];
    own.into_iter().zip(expected).for_each(|(own, one)| assert!((own / one - 1.0).abs() < 1e-12, "{own} {one}"));
    let both = text.replacen("thickness_m", "mass_kg: 1.0, thickness_m", 1);
    assert!(read_spindle("s.yaml", &both).unwrap_err().to_string().contains("discs[0]"));
}

/// At rest x and y are two machines, each with the numbers of its axis.
#[test]
fn axes_of_a_bearing_that_differ_are_two_machines_at_rest() {
    let both = "{x: 290.0, y: 250.0}";
    let ki = |value: &str| changed("ki_n_per_a: 270.0", &format!("ki_n_per_a: {value}"));
    let ks = |value: &str| changed("ks_n_per_m: 1.5e+6", &format!("ks_n_per_m: {value}"));
    for (apart, x, y) in
        [(ki(both), ki("290.0"), ki("250.0")), (ks("{x: 1.7e+6, y: 1.2e+6}"), ks("1.7e+6"), ks("1.2e+6"))]
    {
        let of = |spindle: Spindle| plant(&Machine::without_tool(spindle).unwrap(), 0.0);
        let (apart, x, y) = (of(apart), of(x), of(y));
        for hz in [9.0, 700.0, 1395.0, 3000.0] {
            let [apart, x, y] = [&apart, &x, &y].map(|plant| plant.at(TAU * hz));
            for i in 0..apart.nrows() {
                for j in (0..apart.ncols()).filter(|j| j % 2 == i % 2) {
                    let one = if i % 2 == 0 { &x } else { &y }[(i, j)];
                    let error = (apart[(i, j)] - one).norm() / one.norm();
                    assert!(error < 1e-8, "{i} {j} {hz} Hz: {error:.1e}");
                }
            }
        }
    }
    let refused = read_spindle("s.yaml", &SPINDLE.replacen("ki_n_per_a: 270.0", "ki_n_per_a: {x: 290.0}", 1));
    assert!(refused.unwrap_err().to_string().contains("bearings.front.ki_n_per_a"));
}

#[test]
fn commands_take_a_spindle_without_a_tool_and_speak_of_its_output() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("blower.yaml");
    std::fs::write(&file, format!("{SPINDLE}\noutput_m: 0.01\n")).unwrap();
    let (code, out, error) = muspin(&["modes", "--spindle", "blower.yaml", "--text"], folder.path());
    assert!(code == 0 && out.contains("no tool"), "{out}{error}");
    let tuned = ["pid", "--spindle", "blower.yaml", "--out", "pid", "--text"];
    let (code, out, error) = muspin(&tuned, folder.path());
    assert!(code < 2 && out.contains("settling after a static load"), "{out}{error}");
    let page = std::fs::read_to_string(folder.path().join("pid/report.html")).unwrap();
    assert!(page.contains("at the output") && !page.contains("the tool"), "the words of the page");
    assert!(!folder.path().join("pid/tool.yaml").exists());
    // The files of the run are found again without a word about the tool.
    let controller = "pid/controller/discrete.json";
    let (code, out, error) = muspin(&["compare", "--controller", controller, "--out", "c", "--text"], folder.path());
    assert!(code < 2 && !error.contains("another machine"), "{out}{error}");
    let again = load_machine(folder.path().join("pid/spindle.yaml").to_str().unwrap(), "none").unwrap();
    assert_eq!(again.tool_plane_m(), 0.01);
    assert!(Path::new(&folder.path().join("c/report.html")).exists());
}

/// From a rehearsed measurement with a hidden mass to its name, and time responses: nothing speaks of a tool.
#[test]
fn records_of_a_shaft_without_a_tool_are_identified_diagnosed_compared_and_simulated() {
    let folder = TempDir::new().unwrap();
    let at = folder.path();
    let truth = format!("{SPINDLE}\neffects:\n  - {{effect: added_mass, position_m: 0.35, mass_kg: 0.06}}\n");
    std::fs::write(at.join("truth.yaml"), truth).unwrap();
    let run = |arguments: &str, expected: i32| {
        let list: Vec<&str> = arguments.split(' ').collect();
        let (code, text, error) = muspin(&list, at);
        assert_eq!(code, expected, "{arguments}: {text}{error}");
        let said = format!("{text}{error}");
        for words in ["the tool", "its tool", "tool.yaml"] {
            assert!(!said.contains(words), "{arguments}: {said}");
        }
        said
    };
    run("rehearse --tool none --truth truth.yaml --lines 160 --out measured --text", 0);
    run("identify --measurement measured --out identified --text", 0);
    let said = run("diagnose --measurement measured --out found --text", 0);
    assert!(said.contains("z = 350 mm") && said.contains("the output is"), "{said}");
    let corrected = load_machine(&at.join("found/spindle.yaml").display().to_string(), "none").unwrap();
    assert!((corrected.spindle.effects[0].values[0] / 0.06 - 1.0).abs() < 0.05, "{:?}", corrected.spindle.effects);
    // The drawing has no such mass: moduli do not explain it.
    run("update --measurement measured --out updated --text", 1);
    run("compare --tool none --controller measured/pid.json --measurement measured --out compared --text", 0);
    for case in ["impulse", "lift-off"] {
        run(&format!("simulate --tool none --controller measured/pid.json --case {case} --out {case} --text"), 0);
    }
}
