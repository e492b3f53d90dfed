//! Universal files: third-party ones, every binary variant, and what is written is read back.

use muspin::input::hammer::read_hammer;
use muspin::input::uff::read;
use muspin::input::uff_frf::frfs;
use muspin::linalg::c64;
use muspin::report::uff::{UffRecord, universal_file};
use std::f64::consts::TAU;

fn file(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/uff/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

#[test]
fn receptance_in_double_precision_ascii_is_read() {
    let found = frfs("g11.uff", &read("g11.uff", &file("u01_g11.uff")).unwrap()).unwrap();
    assert_eq!(found.len(), 1);
    let g = &found[0];
    assert_eq!((g.response, g.reference), ((8, 1), (11, 1)));
    assert_eq!(g.frequency_hz.len(), 1976);
    assert_eq!(g.frequency_hz[3], 56.0);
    assert_eq!(g.compliance[0], c64::new(-1.51265890077e-6, 3.53986239253e-14));
}

#[test]
fn header_that_is_not_ascii_is_read_and_accelerance_converted() {
    let bytes = file("non_ascii_header.uff");
    let functions = read("f", &bytes).unwrap();
    assert_eq!(functions[0].ordinate.units, "(1/N)*(m/s²)");
    let g = &frfs("f", &functions).unwrap()[0];
    // The line at 0 Hz is dropped; accelerance −0.0599924 − 0.055326j at 0.195313 Hz.
    assert_eq!(g.frequency_hz.len(), 5);
    let s2 = -(TAU * 0.195313).powi(2);
    let expected = c64::new(-5.99924e-2, -5.53260e-2) / s2;
    assert!((g.compliance[0] / expected - 1.0).norm() < 1e-12);
}

#[test]
fn records_that_are_no_frequency_response_are_refused_with_the_reason() {
    for (name, words) in [
        ("sample_dataset58_psd.uff", "power spectral density"),
        ("Sample_UFF58b_bin.uff", "time record"),
        ("binary8byte.uff", "time record"),
    ] {
        let functions = read(name, &file(name)).unwrap();
        assert_eq!(functions.len(), 1);
        let error = frfs(name, &functions).unwrap_err();
        assert!(error.message.contains(words), "{}", error.message);
        assert!(error.hint.is_some());
    }
    let eight = &read("b", &file("binary8byte.uff")).unwrap()[0];
    // A sine of 5 Hz sampled every 10 ms.
    assert_eq!(eight.x.len(), 250);
    assert!((eight.y[1].re - (TAU * 0.05).sin()).abs() < 1e-7);
    let sound = &read("s", &file("Sample_UFF58b_bin.uff")).unwrap()[0];
    assert_eq!(sound.x.len(), 79_292);
    assert!(sound.y.iter().all(|v| v.re.abs() < 1.0));
}

/// A dataset 58b as programs write it.
fn binary(big: bool, double: bool, even: bool, wide_x: bool, values: &[(f64, c64)]) -> Vec<u8> {
    let mut text = format!("{:>6}\r\n{:>6}b", -1, 58);
    text += &format!(
        "{:>6}{:>6}{:>12}{:>12}{:>6}{:>6}{:>12}{:>12}\r\n",
        if big { 2 } else { 1 },
        2,
        11,
        // Wrong on purpose, as in many files.
        7,
        0,
        0,
        0,
        0
    );
    text += &"NONE\r\n".repeat(5);
    text += "    4         0    0         0       TOOL         1   1       TOOL         1   1\r\n";
    text += &format!(
        "{:>10}{:>10}{:>10}{:>13.5e}{:>13.5e}{:>13.5e}\r\n",
        if double { 6 } else { 5 },
        values.len(),
        i32::from(even),
        if even { values[0].0 } else { 0.0 },
        if even { values[1].0 - values[0].0 } else { 0.0 },
        0.0
    );
    text += "        18    0    0    0 NONE                 Hz                  \r\n";
    text += "        11    0    0    0 NONE                 NONE                \r\n";
    text += "        13    0    0    0 NONE                 NONE                \r\n";
    text += "         0    0    0    0 NONE                 NONE                \r\n";
    let mut bytes = text.into_bytes();
    let mut put = |v: f64, wide: bool| {
        let mut b = if wide { v.to_le_bytes().to_vec() } else { (v as f32).to_le_bytes().to_vec() };
        if big {
            b.reverse();
        }
        bytes.extend(b);
    };
    for (x, y) in values {
        if !even {
            put(*x, wide_x);
        }
        put(y.re, double);
        put(y.im, double);
    }
    bytes.extend(b"\r\n    -1\r\n");
    bytes
}

#[test]
fn every_binary_variant_gives_the_same_compliance() {
    let values: Vec<(f64, c64)> = (0..40)
        .map(|k| {
            let f = 10.0 + 2.5 * k as f64;
            (f, c64::new(1e-3 * f.sin(), 2e-3 / f))
        })
        .collect();
    for big in [false, true] {
        for double in [false, true] {
            for (even, wide_x) in [(true, false), (false, false), (false, true)] {
                if wide_x && !double {
                    continue;
                }
                let bytes = binary(big, double, even, wide_x, &values);
                let h = read_hammer("tap.uff", &bytes, 0.0).unwrap();
                for ((f, v), (g, c)) in values.iter().zip(h.frequency_hz.iter().zip(&h.compliance)) {
                    assert!((f - g).abs() < 1e-5, "{f} {g}");
                    // Mobility to compliance; single precision carries seven digits.
                    let expected = v / c64::new(0.0, TAU * g);
                    assert!((c / expected - 1.0).norm() < 1e-6);
                }
            }
        }
    }
}

#[test]
fn what_is_written_is_read_back() {
    for uneven in [0.0, 0.1] {
        let x: Vec<f64> = (0..33).map(|k| 50.0 + 2.0 * k as f64 + uneven * ((k * k) % 7) as f64).collect();
        let y: Vec<c64> = x.iter().map(|f| c64::new(-1.23456789012e-7 * f, 9.87654321e-12 / f)).collect();
        let record = |node| UffRecord {
            description: "tool plane µ",
            response: (node, 1),
            reference: (1, 1),
            frequency_hz: &x,
            compliance: &y,
        };
        let text = universal_file(&[record(1), record(2)]);
        assert!(text.is_ascii());
        let back = frfs("w", &read("w", text.as_bytes()).unwrap()).unwrap();
        assert_eq!(back.len(), 2);
        for (f, g) in x.iter().zip(&back[1].frequency_hz) {
            assert!((f / g - 1.0).abs() < 1e-5);
        }
        for (a, b) in y.iter().zip(&back[1].compliance) {
            assert!((a / b - 1.0).norm() < 1e-10);
        }
        // Two FRFs, one of them at the driving point: that one is the hammer test.
        assert!(read_hammer("w.uff", text.as_bytes(), 0.0).is_ok());
    }
}

#[test]
fn damaged_files_are_refused_without_panic() {
    for name in ["u01_g11.uff", "binary8byte.uff", "non_ascii_header.uff"] {
        let bytes = file(name);
        // Cut anywhere: an error or fewer functions, never a panic.
        for k in 0..60 {
            let cut = bytes.len() * k / 60;
            if let Ok(functions) = read(name, &bytes[..cut]) {
                let _ = frfs(name, &functions);
            }
        }
    }
    let error = read("x.uff", b"frequency_hz,h_re\n1,2\n").unwrap_err();
    assert!(error.message.contains("not a universal file"));
    let mut huge = String::from_utf8(file("u01_g11.uff")).unwrap();
    huge = huge.replacen("      1976", "2000000000", 1);
    let error = read("x.uff", huge.as_bytes()).unwrap_err();
    assert!(error.message.contains("do not fit"), "{}", error.message);
}
