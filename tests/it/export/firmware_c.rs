//! The exported C, compiled and run: bit for bit, after invalid samples, two controllers in a program, change at run
//! time.

use crate::export::firmware::{LIMITS, TIME, hidden, pair, pid_like, real, typical};
use muspin::controller::hand_over::hand_over;
use muspin::controller::realise::{ProductTerm, modal_form};
use muspin::controller::scaling::{ScaledRealisation, scale_realisation};
use muspin::controller::sections::second_order_sections;
use muspin::controller::verification::Verification;
use muspin::controller::{ControlLaw, Controller};
use muspin::export::c::{c_identifier, is_prefix};
use muspin::export::firmware::{Firmware, Format, write_all};
use muspin::export::table::controller_table;
use muspin::linalg::Mat;
use muspin::lti::{Discrete, StateSpace};
use std::cmp::Ordering;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const STRICT: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-pedantic"];

/// What an export needs to own.
pub(crate) struct Case {
    controller: Controller,
    rows: ScaledRealisation,
    verification: Verification,
    pub(crate) prefix: &'static str,
}

impl Case {
    pub(crate) fn new(law: StateSpace<Discrete>, rows: ScaledRealisation, prefix: &'static str) -> Self {
        Self {
            controller: Controller { name: "test */ case".to_owned(), law: ControlLaw::Discrete(law) },
            rows,
            verification: Verification::none(),
            prefix,
        }
    }

    fn modal(law: StateSpace<Discrete>, prefix: &'static str) -> Self {
        let rows = scale_realisation(&modal_form(&law).unwrap(), LIMITS).unwrap();
        Self::new(law, rows, prefix)
    }

    pub(crate) fn firmware(&self) -> Firmware<'_> {
        Firmware {
            discrete: &self.controller,
            continuous: None,
            scaled: &self.rows,
            verification: &self.verification,
            machine: "none",
            tag: None,
            prefix: self.prefix,
        }
    }

    pub(crate) fn write(&self, folder: &Path) {
        std::fs::create_dir_all(folder).unwrap();
        let files = write_all(&self.firmware(), &Format::ALL).unwrap();
        assert_eq!(files, write_all(&self.firmware(), &Format::ALL).unwrap());
        for (name, bytes) in &files.files {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
    }
}

fn compiles(folder: &Path, compiler: &str, arguments: &[&str]) -> Result<(), String> {
    let done = Command::new(compiler).args(arguments).current_dir(folder).output().unwrap();
    let message = String::from_utf8_lossy(&done.stderr).into_owned();
    if done.status.success() { Ok(()) } else { Err(message) }
}

fn run(folder: &Path, program: &str, arguments: &[&str]) -> String {
    let done = Command::new(folder.join(program)).args(arguments).current_dir(folder).output().unwrap();
    let printed = String::from_utf8_lossy(&done.stdout).trim().to_owned();
    assert!(done.status.success(), "{printed}");
    printed
}

/// Writes `main.c` beside the export, compiles all strictly and returns what the program prints.
pub(crate) fn main_prints(folder: &Path, text: &str, sources: &[&str]) -> String {
    std::fs::write(folder.join("main.c"), text).unwrap();
    let arguments = [&STRICT[..], &["-O2", "main.c"], sources, &["-o", "main"]].concat();
    compiles(folder, "cc", &arguments).unwrap_or_else(|e| panic!("{e}"));
    run(folder, "main", &[])
}

fn reproduces_the_vectors(case: &Case, flags: &[&str]) {
    let folder = TempDir::new().unwrap();
    case.write(folder.path());
    let header = std::fs::read_to_string(folder.path().join("controller.h")).unwrap();
    let verified = format!("#define {}_VERIFIED 0", case.prefix.to_uppercase());
    assert!(header.contains("NOT VERIFIED") && header.contains(&verified));
    let own = ["-O2", "-DMUSPIN_SELF_TEST", "controller.c", "-o", "selftest"];
    compiles(folder.path(), "cc", &[flags, &own[..]].concat()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(
        run(folder.path(), "selftest", &["test_vectors.csv"]),
        "256 samples, float32 mismatches 0, Q31 mismatches 0"
    );
}

#[test]
fn generated_c_reproduces_the_vectors_bit_for_bit() {
    let sections = scale_realisation(&second_order_sections(&pid_like()).unwrap(), LIMITS).unwrap();
    let gain = Mat::from_fn(4, 4, |i, j| -1e4 * f64::from(u8::from(i == j)));
    // Two equal pairs and three equal real poles of one law: blocks of four and of three states.
    let twice = pair(700.0, 0.02);
    let jordan = Mat::from_fn(3, 3, |i, j| match j.cmp(&i) {
        Ordering::Equal => 0.95,
        Ordering::Greater if j == i + 1 => 0.05,
        _ => 0.0,
    });
    let merged = hidden(&[twice.clone(), twice, jordan, pair(90.0, 0.3)], 4, 4, 3);
    let blocks = modal_form(&merged).unwrap().blocks;
    assert!(blocks.iter().any(|n| *n > 2), "{blocks:?}");
    for case in [
        Case::modal(typical(), "typical"),
        Case::modal(merged, "merged"),
        Case::new(pid_like(), sections, "sections"),
        Case::modal(StateSpace::gain(gain, TIME), "gain"),
    ] {
        reproduces_the_vectors(&case, &STRICT);
    }
}

#[test]
fn generated_c_corrects_the_states_of_a_limited_controller_bit_for_bit() {
    let sections = scale_realisation(&second_order_sections(&pid_like()).unwrap(), LIMITS).unwrap();
    let modal = scale_realisation(&modal_form(&typical()).unwrap(), LIMITS).unwrap();
    for (law, plain) in [(typical(), modal), (pid_like(), sections)] {
        let mut rows = plain.clone();
        for i in [0, 1, 5] {
            let term = |j: usize| ProductTerm { source: j, coefficient: 0.003 * (i as f64 - 2.5 + j as f64) };
            rows.conditioning[i] = (0..4).map(term).collect();
        }
        let vectors = |rows: &ScaledRealisation| {
            let case = Case::new(law.clone(), rows.clone(), "conditioned");
            let files = write_all(&case.firmware(), &[Format::Csv]).unwrap();
            files.files.into_iter().find(|f| f.0 == "test_vectors.csv").unwrap().1
        };
        let (with, without) = (vectors(&rows), vectors(&plain));
        let lines =
            |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap().lines().map(str::to_owned).collect::<Vec<_>>();
        let (with, without) = (lines(&with), lines(&without));
        // Lines 97 to 176 stay within the limits, where nothing is corrected; the step after them is limited.
        assert!(with[177..] != without[177..], "the correction must act");
        let case = Case::new(law.clone(), rows, "conditioned");
        reproduces_the_vectors(&case, &STRICT);
    }
}

#[test]
fn no_option_of_the_compiler_brings_in_a_fused_multiply_add() {
    let case = Case::modal(typical(), "typical");
    reproduces_the_vectors(&case, &[]);
    if cfg!(target_arch = "x86_64") {
        reproduces_the_vectors(&case, &["-mfma", "-ffp-contract=fast"]);
    }
    let folder = TempDir::new().unwrap();
    case.write(folder.path());
    let refused = compiles(folder.path(), "cc", &["-O2", "-ffast-math", "-c", "controller.c"]);
    assert!(refused.unwrap_err().contains("-ffast-math"));
}

const INVALID_SAMPLES: &str = include_str!("../../firmware/invalid_samples.c");

#[test]
fn an_invalid_sample_is_held_counted_and_leaves_nothing_behind() {
    let sections = scale_realisation(&second_order_sections(&pid_like()).unwrap(), LIMITS).unwrap();
    for case in [Case::modal(typical(), "typical"), Case::new(pid_like(), sections, "sections")] {
        let folder = TempDir::new().unwrap();
        case.write(folder.path());
        assert_eq!(main_prints(folder.path(), INVALID_SAMPLES, &["controller.c"]), "0");
    }
}

#[test]
fn two_controllers_link_and_generic_names_are_withdrawn() {
    let folder = TempDir::new().unwrap();
    Case::modal(typical(), "first").write(&folder.path().join("first"));
    Case::modal(pid_like(), "second").write(&folder.path().join("second"));
    let sources = ["first/controller.c", "second/controller.c"];
    let includes = "#include \"first/controller.h\"\n#include \"second/controller.h\"\n#include \
        \"first/controller.h\"\n";
    let main = format!(
        "{includes}#include <stdio.h>\nint main(void)\n{{\n    first_f32 a;\n    second_q31 b;\n    \
         first_f32_init(&a);\n    \
         second_q31_init(&b);\n    printf(\"%d %d\\n\", FIRST_STATES, SECOND_STATES);\n    return 0;\n}}\n"
    );
    assert_eq!(main_prints(folder.path(), &main, &sources), "16 24");
    let check = |text: String, compiler: &str, name: &str| {
        std::fs::write(folder.path().join(name), text).unwrap();
        compiles(folder.path(), compiler, &["-Wall", "-Wextra", "-Werror", "-c", name])
    };
    let generic = "muspin_f32 state;\nint states = MUSPIN_STATES;\n";
    let single = "#include \"first/controller.h\"\n";
    check(format!("{single}{generic}"), "cc", "single.c").unwrap();
    assert!(check(format!("{includes}{generic}"), "cc", "both.c").is_err());
    let call = "void start(void);\nvoid start(void) { static first_f32 c; first_f32_init(&c); }\n";
    check(format!("{single}{call}"), "c++", "caller.cpp").unwrap();
    let symbols = Command::new("nm").args(["-u", "caller.o"]).current_dir(folder.path()).output().unwrap();
    assert!(String::from_utf8_lossy(&symbols.stdout).contains(" first_f32_init\n"), "linked by its C name");
}

#[test]
fn names_become_c_identifiers() {
    for (name, identifier) in [
        ("paper-tool", "paper_tool"),
        ("Endmill 14", "endmill_14"),
        ("14mm", "tool_14mm"),
        ("µ", "tool_"),
        ("", "controller"),
    ] {
        assert_eq!(c_identifier(name), identifier);
        assert!(is_prefix(identifier), "{identifier}");
    }
    assert!(["1a", "_a", "a-b", "", "MUSPIN", "é"].iter().all(|p| !is_prefix(p)));
}

/// Both library structures as their manuals define them, on the tables of sections.h and the vectors before any limit.
const LIBRARIES: &str = include_str!("../../firmware/libraries.c");

#[test]
fn library_tables_of_sections_reproduce_the_vectors() {
    let rows = scale_realisation(&second_order_sections(&pid_like()).unwrap(), LIMITS).unwrap();
    let folder = TempDir::new().unwrap();
    Case::new(pid_like(), rows, "sections").write(folder.path());
    std::fs::write(folder.path().join("main.c"), LIBRARIES).unwrap();
    // The tables of the two axes in between are not used.
    let arguments = [&STRICT[..], &["-Wno-unused-variable", "-O2", "main.c", "-o", "main", "-lm"]].concat();
    compiles(folder.path(), "cc", &arguments).unwrap_or_else(|e| panic!("{e}"));
    let printed = run(folder.path(), "main", &[]);
    let values: Vec<f64> = printed.split(' ').map(|v| v.parse().unwrap()).collect();
    assert_eq!(values[0], 176.0);
    assert!(values[1] > 0.01, "the vectors must move the outputs");
    // The slow pole, 3e-4 from one, holds single precision to 6e-8/3e-4 of its share.
    assert!(values[2] < 5e-4 * values[1], "{printed}");
    let coupled = TempDir::new().unwrap();
    Case::modal(typical(), "typical").write(coupled.path());
    assert!(!coupled.path().join("sections.h").exists());
}

/// Decentralised PD, or PID with `integral` > 0 (1/s): u = kp·y + derivative, negative gains push back.
fn levitation(integral: f64) -> StateSpace<Discrete> {
    let (kp, kd, pole) = (-12_000.0, -11.7, 0.5);
    let g = kd * (1.0 - pole) / TIME.period_s;
    let order = if integral > 0.0 { 8 } else { 4 };
    let axis = |i: usize| i % 4;
    let a = Mat::from_fn(order, order, |i, j| {
        if i != j {
            0.0
        } else if i < 4 {
            pole
        } else {
            1.0
        }
    });
    let b = Mat::from_fn(order, 4, |i, j| if axis(i) == j { 1.0 } else { 0.0 });
    let c = Mat::from_fn(4, order, |i, j| match axis(j) == i {
        true if j < 4 => g * (pole - 1.0),
        true => kp * integral * TIME.period_s,
        false => 0.0,
    });
    let d = Mat::from_fn(4, 4, |i, j| if i == j { kp + g } else { 0.0 });
    StateSpace::new(a, b, c, d, TIME).unwrap()
}

/// Four rigid axes on magnets with negative stiffness under a static load; changes the controller twice.
const CHANGE: &str = include_str!("../../firmware/change.c");

#[test]
fn a_change_of_controller_continues_the_currents_and_the_loop_settles() {
    let folder = TempDir::new().unwrap();
    let (lift, work) = (Case::modal(levitation(0.0), "lift"), Case::modal(levitation(100.0), "work"));
    for case in [&lift, &work] {
        case.write(&folder.path().join(case.prefix));
    }
    for (name, bytes) in controller_table(&[lift.firmware(), work.firmware()]).unwrap() {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let sources = ["lift/controller.c", "work/controller.c", "controllers.c", "-lm"];
    let printed = main_prints(folder.path(), CHANGE, &sources);
    assert_eq!(printed.lines().count(), 2);
    for line in printed.lines() {
        let values: Vec<f64> = line.split(' ').map(|v| v.parse().unwrap()).collect();
        // Rounding: 1e5 A/m on displacements of 4e-5 m held to 6e-8 of themselves. A start from zero states jumps by 3
        // A.
        assert!(values[0] < 1e-4, "the current jumps by {} A", values[0]);
        // The integrator starts at the resting current and moves on by 60 A/m times 4e-5 m a sample. The way back is to
        // a controller whose only memory is a derivative filter with the pole 0.5: it continues the current for one
        // sample.
        assert!(values[1] < 5e-2, "the current moves by {} A in a sample", values[1]);
        // The integrator has 0.2 s, 20 of its time constants; 1e-3 µm is 2e-5 of the resting position.
        assert!(values[2] < 1e-3, "{} µm from rest", values[2]);
    }
    let twice = [lift.firmware(), lift.firmware()];
    let message = controller_table(&twice).unwrap_err().to_string();
    assert!(message.contains("--prefix"), "{message}");
}

#[test]
fn a_controller_with_a_fast_unstable_mode_is_handed_over() {
    // A pole of 1.6 grows by 1e209 within the usual horizon of 1024 samples.
    let blocks = [real(0.99), real(0.3), real(1.6), pair(900.0, 0.05)];
    let law = hidden(&blocks, 4, 4, 5);
    let rows = scale_realisation(&modal_form(&law).unwrap(), LIMITS).unwrap();
    let map = hand_over(&rows).unwrap();
    let system = rows.rows.to_state_space().unwrap();
    let y = Mat::from_fn(4, 1, |i, _| 1e-6 * (i as f64 + 1.0));
    let wanted = [0.5, -1.0, 2.0, 0.1];
    let given: Vec<f64> = (0..8).map(|i| if i < 4 { y[(i, 0)] } else { wanted[i - 4] }).collect();
    let mut x = Mat::from_fn(system.order(), 1, |i, _| {
        let terms = map.float32[i].iter();
        terms.map(|t| t.coefficient * given[t.source]).sum::<f64>()
    });
    let (first, mut last) = (&system.c * &x + &system.d * &y, Mat::zeros(4, 1));
    // Five states cannot hold four currents for long; the unstable one alone would grow by 1.6⁵ = 10.
    for _ in 0..5 {
        x = &system.a * &x + &system.b * &y;
        last = &system.c * &x + &system.d * &y;
    }
    for i in 0..4 {
        assert!((first[(i, 0)] - wanted[i]).abs() < 1e-4, "output {i}: {first:?}");
        assert!((last[(i, 0)] - wanted[i]).abs() < 4.0, "output {i}: {last:?}");
    }
}

#[test]
fn the_handed_over_states_reproduce_the_last_output() {
    let rows = scale_realisation(&modal_form(&typical()).unwrap(), LIMITS).unwrap();
    let map = hand_over(&rows).unwrap();
    let system = rows.rows.to_state_space().unwrap();
    let given = [1e-5, -2e-5, 0.0, 3e-5, 0.5, -1.0, 2.0, 0.1];
    let x: Vec<f64> = map.float32.iter().map(|row| row.iter().map(|t| t.coefficient * given[t.source]).sum()).collect();
    for i in 0..4 {
        let states: f64 = (0..x.len()).map(|j| system.c[(i, j)] * x[j]).sum();
        let inputs: f64 = (0..4).map(|j| system.d[(i, j)] * given[j]).sum();
        // Single-precision coefficients, sums of 20 products that cancel by less than a hundred.
        assert!((states + inputs - given[4 + i]).abs() < 1e-4, "output {i}");
    }
}
