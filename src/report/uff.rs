//! FRFs as universal files, dataset 58, ASCII, complex double precision, uneven abscissa in full precision where the
//! spacing is uneven. Columns follow the I-DEAS documentation, so that pyuff and the usual modal programs read them.

use crate::linalg::c64;
use std::fmt::Write as _;

/// A compliance to write.
#[derive(Clone, Debug)]
pub struct UffRecord<'a> {
    /// ID line 1.
    pub description: &'a str,
    /// Response node and direction (1 x, 2 y).
    pub response: (i64, i64),
    /// Reference node and direction.
    pub reference: (i64, i64),
    /// Lines, Hz.
    pub frequency_hz: &'a [f64],
    /// Compliance, m/N.
    pub compliance: &'a [c64],
}

/// A universal file with one dataset 58 per record; lists of unequal length are cut to the shorter one.
pub fn universal_file(records: &[UffRecord<'_>]) -> String {
    let mut text = String::new();
    for r in records {
        let n = r.frequency_hz.len().min(r.compliance.len());
        let spacing = even_step(&r.frequency_hz[..n]);
        let (start, step) = spacing.map_or((0.0, 0.0), |d| (r.frequency_hz[0], d));
        let id: String = r.description.chars().map(|c| if c.is_ascii_graphic() { c } else { ' ' }).take(80).collect();
        let id = if id.trim().is_empty() { "NONE" } else { id.trim() };
        let _ = write!(text, "{:>6}\n{:>6}{:74}\n{id:<80}\n", -1, 58, "");
        for _ in 0..4 {
            let _ = writeln!(text, "{:<80}", "NONE");
        }
        let _ = writeln!(
            text,
            "{:>5}{:>10}{:>5}{:>10} {:>10}{:>10}{:>4} {:>10}{:>10}{:>4}",
            4, 0, 0, 0, "NONE", r.response.0, r.response.1, "NONE", r.reference.0, r.reference.1
        );
        let _ = writeln!(
            text,
            "{:>10}{n:>10}{:>10}{}{}{}",
            6,
            i32::from(spacing.is_some()),
            scientific(start, 13, 5),
            scientific(step, 13, 5),
            scientific(0.0, 13, 5)
        );
        let axes = [(18, "Frequency", "Hz"), (8, "Displacement", "m"), (13, "Force", "N"), (0, "NONE", "NONE")];
        for (kind, label, unit) in axes {
            let _ = writeln!(text, "{kind:>10}{:>5}{:>5}{:>5} {label:<20} {unit:<20}", 0, 0, 0);
        }
        let value = |h: &c64| format!("{}{}", scientific(h.re, 20, 11), scientific(h.im, 20, 11));
        let values: Vec<String> = r.compliance[..n].iter().map(value).collect();
        if spacing.is_some() {
            for pair in values.chunks(2) {
                text.push_str(&pair.concat());
                text.push('\n');
            }
        } else {
            for (f, h) in r.frequency_hz.iter().zip(&values) {
                let _ = writeln!(text, "{}{h}", scientific(*f, 13, 5));
            }
        }
        let _ = writeln!(text, "{:>6}", -1);
    }
    text
}

/// The step of an evenly spaced list whose start and step survive the five decimals of the header.
fn even_step(x: &[f64]) -> Option<f64> {
    let (first, second) = (x.first()?, x.get(1)?);
    let step = second - first;
    let printed = |v: f64| format!("{v:.5e}").parse::<f64>().unwrap_or(f64::NAN);
    let (start, printed_step) = (printed(*first), printed(step));
    let same = |k: usize, f: f64| {
        // Half a millionth of the frequency: finer than any line of a sweep.
        (start + printed_step * k as f64 - f).abs() <= 5e-7 * f.abs()
    };
    (step > 0.0 && x.iter().enumerate().all(|(k, f)| same(k, *f))).then_some(step)
}

/// C's `%w.de`: two digits of exponent at least.
fn scientific(x: f64, width: usize, decimals: usize) -> String {
    let text = format!("{x:.decimals$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let e: i32 = exponent.parse().unwrap_or(0);
    let sign = if e < 0 { '-' } else { '+' };
    format!("{:>width$}", format!("{mantissa}e{sign}{:02}", e.abs()))
}
