//! Universal files in any unit are one compliance; units, systems of units and directions that contradict each other
//! are refused by name.

use muspin::input::InputError;
use muspin::input::hammer::{HammerKeys, Tap, read_tap};
use muspin::linalg::c64;
use std::f64::consts::TAU;

const POUND_N: f64 = 4.448_221_615_260_5;
const GRAVITY: f64 = 9.80665;

/// A function of dataset 58 as text.
#[derive(Clone)]
struct Function {
    /// Type and unit of ordinate and denominator.
    ordinate: (i64, &'static str),
    denominator: &'static str,
    response: i64,
    force: i64,
    frequency: &'static str,
    values: Vec<(f64, c64)>,
}

/// The compliance that all files hold, m/N.
fn compliance() -> Vec<(f64, c64)> {
    (0..12).map(|k| 10.0 + 5.0 * f64::from(k)).map(|f| (f, c64::new(1e-6 / (1.0 + f), -2e-8 * f.sqrt()))).collect()
}

impl Function {
    fn new(kind: i64, ordinate: &'static str, denominator: &'static str) -> Self {
        let (response, force, frequency) = (1, 1, "Hz");
        Self { ordinate: (kind, ordinate), denominator, response, force, frequency, values: compliance() }
    }

    /// The function with every value multiplied.
    fn times(mut self, factor: impl Fn(f64) -> c64) -> Self {
        self.values.iter_mut().for_each(|(f, v)| *v *= factor(*f));
        self
    }

    fn text(&self) -> String {
        let mut text = format!("    -1\n    58\nTap\n{}", "NONE\n".repeat(4));
        text += &format!(
            "    4         1    1         0 NONE{:>16}{:>4} NONE{:>16}{:>4}\n",
            1, self.response, 1, self.force
        );
        text += &format!("{:>10}{:>10}{:>10}{:>13.5e}{:>13.5e}{:>13.5e}\n", 6, self.values.len(), 0, 0.0, 0.0, 0.0);
        let axis = |kind: i64, units: &str| format!("{kind:>10}    0    0    0 {:<20} {units:<20}\n", "NONE");
        text += &(axis(18, self.frequency) + &axis(self.ordinate.0, self.ordinate.1));
        text += &(axis(13, self.denominator) + &axis(0, "NONE"));
        for (f, v) in &self.values {
            text += &format!("{f:>13.6e}{:>20.11e}{:>20.11e}\n", v.re, v.im);
        }
        text + "    -1\n"
    }
}

fn system(code: i64, length: f64, force: f64) -> String {
    format!(
        "    -1\n   164\n{code:>10}{:<20}{:>10}\n{length:>25.17e}{force:>25.17e}{:>25.17e}\n{:>25.17e}\n    -1\n",
        "units", 2, 1.0, 273.15
    )
}

fn tap(text: &str, keys: &HammerKeys) -> Result<Tap, InputError> {
    // Latin-1, as most of these programs write.
    let bytes: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap_or(b'?')).collect();
    read_tap("tap.uff", &bytes, keys)
}

fn assert_is_compliance(text: &str, what: &str) -> Tap {
    let found = tap(text, &HammerKeys::default()).unwrap_or_else(|e| panic!("{what}: {e}"));
    for ((f, h), (frequency, value)) in
        compliance().iter().zip(found.frf.frequency_hz.iter().zip(&found.frf.compliance))
    {
        // The abscissa has seven digits.
        assert!((frequency / f - 1.0).abs() < 1e-5, "{what}: {frequency} {f}");
        assert!((value / h - 1.0).norm() < 1e-5, "{what}: {value} {h} at {f} Hz");
    }
    found
}

fn refused(text: &str, words: &[&str]) {
    let error = tap(text, &HammerKeys::default()).expect_err(&words.join(" "));
    let told = format!("{error} {}", error.hint.clone().unwrap_or_default());
    assert!(words.iter().all(|w| told.contains(w)), "{words:?}: {told}");
}

#[test]
fn every_unit_of_motion_and_force_is_read_as_si() {
    let s = |f: f64| c64::new(0.0, TAU * f);
    for (unit, per_unit) in [
        ("m", 1.0),
        ("M", 1.0),
        ("mm", 1e-3),
        ("MM", 1e-3),
        ("cm", 1e-2),
        ("micron", 1e-6),
        ("µm", 1e-6),
        ("um", 1e-6),
        ("nm", 1e-9),
        ("in", 0.0254),
        ("inch", 0.0254),
        ("IN", 0.0254),
        ("mil", 2.54e-5),
        ("ft", 0.3048),
    ] {
        for (force, newton) in [
            ("N", 1.0),
            ("mN", 1e-3),
            ("kN", 1e3),
            ("lbf", POUND_N),
            ("LBF", POUND_N),
            ("lb", POUND_N),
            ("kgf", GRAVITY),
            ("dyn", 1e-5),
        ] {
            let file = Function::new(8, unit, force).times(|_| (newton / per_unit).into());
            assert_is_compliance(&file.text(), &format!("{unit} over {force}"));
        }
    }
    for (unit, per_unit) in [("m/s", 1.0), ("in/s", 0.0254), ("mm/sec", 1e-3), ("IN/SEC", 0.0254)] {
        let file = Function::new(11, unit, "lbf").times(|f| s(f) * POUND_N / per_unit);
        assert_is_compliance(&file.text(), unit);
    }
    for (unit, per_unit) in [
        ("g", GRAVITY),
        ("G", GRAVITY),
        ("gn", GRAVITY),
        ("mg", 1e-3 * GRAVITY),
        ("m/s^2", 1.0),
        ("m/s²", 1.0),
        ("m/s/s", 1.0),
        ("m/s2", 1.0),
        ("ms-2", 1.0),
        ("mm/s**2", 1e-3),
        ("in/s^2", 0.0254),
    ] {
        let file = Function::new(12, unit, "lbf").times(|f| s(f) * s(f) * POUND_N / per_unit);
        assert_is_compliance(&file.text(), unit);
    }
    // The unit of the whole response on the ordinate.
    for (unit, newton, per_unit) in
        [("g/N", 1.0, GRAVITY), ("(1/N)*(m/s^2)", 1.0, 1.0), ("(in/s^2)/lbf", POUND_N, 0.0254)]
    {
        let file = Function::new(12, unit, "NONE").times(|f| s(f) * s(f) * newton / per_unit);
        assert_is_compliance(&file.text(), unit);
    }
}

#[test]
fn units_that_are_not_understood_or_do_not_fit_are_named() {
    for (kind, ordinate, denominator, words) in [
        (8, "furlong", "N", "furlong"),
        (8, "m", "stone", "stone"),
        (8, "m", "MN", "MN"),
        (8, "V", "N", "\"V\""),
        (12, "m", "N", "acceleration"),
        (8, "g", "N", "displacement"),
        (8, "m", "m", "no force"),
        (8, "Nm", "N", "no displacement"),
        (8, "m^", "(N", "(N"),
    ] {
        refused(&Function::new(kind, ordinate, denominator).text(), &["unit", words]);
    }
    let cycles = Function { frequency: "orders", ..Function::new(8, "m", "N") };
    refused(&cycles.text(), &["unit", "orders"]);
}

#[test]
fn other_units_of_frequency_are_converted() {
    for (unit, hz) in [("kHz", 1e3), ("rad/s", 1.0 / TAU), ("RPM", 1.0 / 60.0), ("NONE", 1.0)] {
        let mut file = Function { frequency: unit, ..Function::new(8, "m", "N") };
        file.values.iter_mut().for_each(|(f, _)| *f /= hz);
        assert_is_compliance(&file.text(), unit);
    }
}

#[test]
fn units_of_dataset_164_serve_functions_without_labels() {
    let inch = |f: Function| f.times(|_| (POUND_N / 0.0254).into()).text();
    let unlabelled = Function::new(8, "NONE", "NONE");
    for (code, length, force) in [(7, 39.370_078_740_157, 0.224_808_943_1), (9, 39.3701, 0.224809)] {
        let found = assert_is_compliance(&(system(code, length, force) + &inch(unlabelled.clone())), "164");
        assert!(found.notes.is_empty(), "{:?}", found.notes);
        // The same labels, or gravity, agree with the dataset.
        assert_is_compliance(&(system(code, length, force) + &inch(Function::new(8, "in", "lbf"))), "both");
        let g = Function::new(12, "g", "lbf").times(|f| -c64::from((TAU * f).powi(2) * POUND_N / GRAVITY));
        assert_is_compliance(&(system(code, length, force) + &g.text()), "g");
        let file = system(code, length, force) + &Function::new(8, "m", "N").text();
        refused(&file, &["unit", "\"m\"", "dataset 164"]);
    }
    let milli = Function::new(8, "", "").times(|_| c64::from(1.0));
    assert_is_compliance(&(system(5, 1e3, 1e3) + &milli.text()), "mm and mN");
    refused(&(system(7, 1.0, 1.0) + &unlabelled.text()), &["dataset 164", "units code 7"]);
    refused(&(system(9, 0.0, 0.0) + &unlabelled.text()), &["dataset 164", "factors"]);
    // Without labels and without the dataset it is SI, and said.
    let found = assert_is_compliance(&unlabelled.text(), "nothing");
    assert!(found.notes.iter().any(|n| n.contains("taken as SI")), "{:?}", found.notes);
}

#[test]
fn the_direction_of_the_response_is_that_of_the_axis() {
    let along = |response: i64, force: i64| Function { response, force, ..Function::new(8, "m", "N") };
    let keys = |axis| HammerKeys { axis, ..HammerKeys::default() };
    let refused = |response: i64, force: i64, axis| {
        let error = tap(&along(response, force).text(), &keys(axis)).unwrap_err().to_string();
        assert!(error.contains("direction of the response") || error.contains("direction of response"), "{error}");
    };
    refused(2, 1, Some(0));
    refused(1, 2, Some(1));
    refused(2, 2, Some(0));
    refused(3, 3, None);
    for (response, force, axis, expected) in
        [(2, 2, None, 1), (2, 2, Some(1), 1), (1, 1, None, 0), (0, 0, Some(1), 1), (-2, -2, None, 1), (0, 0, None, 0)]
    {
        let found = tap(&along(response, force).text(), &keys(axis)).unwrap();
        assert_eq!(found.axis, expected, "{response} {force}");
        assert!(found.notes.is_empty(), "{:?}", found.notes);
    }
    // An accelerometer on the other side: the response against the force.
    for (response, force) in [(-1, 1), (1, -1)] {
        let turned = along(response, force).times(|_| c64::from(-1.0));
        let found = assert_is_compliance(&turned.text(), "turned");
        assert!(found.notes.iter().any(|n| n.contains("direction of the response is")), "{:?}", found.notes);
    }
}

#[test]
fn a_file_of_several_functions_is_read_by_number_or_by_axis() {
    let [x, y] = [1, 2].map(|d| Function { response: d, force: d, ..Function::new(8, "mm", "N") });
    let y = y.times(|_| 1e3.into());
    let across = Function { response: 2, ..Function::new(8, "mm", "N") };
    let file = [&across, &x, &y].map(Function::text).concat();
    let read = |axis, function| tap(&file, &HammerKeys { axis, function, ..HammerKeys::default() });
    // Two drive points: the axis tells, else the number.
    assert_eq!(read(Some(1), None).unwrap().axis, 1);
    assert_eq!(read(None, Some(3)).unwrap().axis, 1);
    assert_eq!(read(None, Some(2)).unwrap().axis, 0);
    let error = read(None, None).unwrap_err();
    assert!(error.message.contains("2: \"Tap\"") && error.hint.unwrap().contains("function: N"), "{}", error.message);
    for (number, words) in [(0, "there is no function 0"), (4, "the file has 3"), (1, "direction of the response")] {
        let error = read(None, Some(number)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let csv = read_tap("tap.csv", b"", &HammerKeys { function: Some(1), ..HammerKeys::default() });
    assert!(csv.unwrap_err().to_string().contains("function"));
}
