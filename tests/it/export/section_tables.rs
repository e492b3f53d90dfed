//! The tables of `sections.h`, read back as a compiler reads them, against transfer functions in closed form.

use crate::export::firmware::{LIMITS, TIME};
use muspin::controller::realise::modal_form;
use muspin::controller::scaling::scale_realisation;
use muspin::controller::sections::second_order_sections;
use muspin::controller::verification::Verification;
use muspin::controller::{ControlLaw, Controller};
use muspin::export::firmware::{Firmware, FirmwareFiles, Format, write_all};
use muspin::linalg::{Mat, c64};
use muspin::lti::connect::append;
use muspin::lti::{Discrete, StateSpace};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

const AXES: [&str; 4] = ["front_x", "front_y", "rear_x", "rear_y"];

/// gain Π(z − zero)/Π(z − pole).
#[derive(Clone, Debug)]
struct Axis {
    gain: f64,
    zeros: Vec<c64>,
    poles: Vec<c64>,
}

impl Axis {
    fn at(&self, z: c64) -> c64 {
        let product = |roots: &[c64]| roots.iter().fold(c64::new(1.0, 0.0), |p, r| p * (z - r));
        product(&self.zeros) / product(&self.poles) * self.gain
    }

    /// The companion form of a transfer function, as `tf2ss` writes it.
    fn companion(&self) -> StateSpace<Discrete> {
        let (n, m) = (self.poles.len(), self.zeros.len());
        let (denominator, numerator) = (polynomial(&self.poles), polynomial(&self.zeros));
        let padded: Vec<f64> = (0..=n).map(|k| if k < n - m { 0.0 } else { numerator[k + m - n] }).collect();
        let a = Mat::from_fn(n, n, |i, j| if i == 0 { -denominator[j + 1] } else { f64::from(i == j + 1) });
        let b = Mat::from_fn(n, 1, |i, _| f64::from(i == 0));
        let c = Mat::from_fn(1, n, |_, j| self.gain * (padded[j + 1] - padded[0] * denominator[j + 1]));
        StateSpace::new(a, b, c, Mat::from_fn(1, 1, |_, _| self.gain * padded[0]), TIME).unwrap()
    }

    /// The same as a chain of first- and second-order systems, which keeps slow poles to full precision.
    fn chain(&self) -> StateSpace<Discrete> {
        let parts = |roots: &[c64]| -> Vec<Vec<c64>> {
            roots
                .iter()
                .filter(|r| r.im >= 0.0)
                .map(|r| if r.im > 0.0 { vec![*r, r.conj()] } else { vec![*r] })
                .collect()
        };
        let (poles, mut zeros) = (parts(&self.poles), parts(&self.zeros));
        let mut chain = StateSpace::gain(Mat::from_fn(1, 1, |_, _| self.gain), TIME);
        for poles in poles {
            let fitting = zeros.iter().position(|z| z.len() <= poles.len());
            let zeros = fitting.map(|k| zeros.remove(k)).unwrap_or_default();
            let part = Self { gain: 1.0, zeros, poles }.companion();
            chain = muspin::lti::connect::series(&chain, &part).unwrap();
        }
        assert!(zeros.is_empty());
        chain
    }
}

/// Π(x − root), leading coefficient first.
fn polynomial(roots: &[c64]) -> Vec<f64> {
    let mut coefficients = vec![c64::new(1.0, 0.0)];
    for root in roots {
        coefficients.push(c64::new(0.0, 0.0));
        for k in (1..coefficients.len()).rev() {
            let lower = coefficients[k - 1];
            coefficients[k] -= lower * root;
        }
    }
    coefficients.iter().map(|c| c.re).collect()
}

fn decentralised(axes: &[StateSpace<Discrete>; 4]) -> StateSpace<Discrete> {
    axes[1..].iter().fold(axes[0].clone(), |all, axis| append(&all, axis))
}

fn exported(law: &StateSpace<Discrete>) -> FirmwareFiles {
    let rows = scale_realisation(&modal_form(law).unwrap(), LIMITS).unwrap();
    let controller = Controller { name: "axes".to_owned(), law: ControlLaw::Discrete(law.clone()) };
    let verification = Verification::none();
    let firmware = Firmware {
        discrete: &controller,
        continuous: None,
        scaled: &rows,
        verification: &verification,
        machine: "none",
        tag: None,
        prefix: "k",
    };
    write_all(&firmware, &[Format::C]).unwrap()
}

fn header(files: &FirmwareFiles) -> Option<String> {
    let file = files.files.iter().find(|f| f.0 == "sections.h")?;
    Some(String::from_utf8(file.1.clone()).unwrap())
}

/// Five numbers a section of the table with this name.
fn table(header: &str, name: &str) -> Option<Vec<Vec<f64>>> {
    let start = header.find(&format!("{name}["))?;
    let body = header[start..].split_once('{')?.1.split_once("};")?.0;
    let values: Vec<f64> = body.split(',').map(str::trim).filter(|v| !v.is_empty()).map(hexadecimal).collect();
    Some(values.chunks(5).map(<[f64]>::to_vec).collect())
}

fn hexadecimal(text: &str) -> f64 {
    let text = text.trim_end_matches('f');
    let (sign, rest) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let Some((mantissa, exponent)) = rest.strip_prefix("0x").and_then(|r| r.split_once('p')) else {
        return sign * rest.parse::<f64>().unwrap();
    };
    let (whole, digits) = mantissa.split_once('.').unwrap();
    let fraction = u64::from_str_radix(digits, 16).unwrap() as f64 / 16f64.powi(digits.len() as i32);
    sign * (whole.parse::<f64>().unwrap() + fraction) * exponent.parse::<f64>().unwrap().exp2()
}

/// Largest relative difference where the axis responds with more than a thousandth of its peak, from 0.01 Hz on.
fn difference(table: &[Vec<f64>], axis: &Axis) -> f64 {
    let points: Vec<(f64, f64)> = (0..=300)
        .map(|k| {
            let z = c64::from_polar(1.0, 0.98 * PI * 10f64.powf(-6.0 + 6.0 * f64::from(k) / 300.0));
            let section = |s: &Vec<f64>| {
                let q = z.inv();
                (q * (q * s[2] + s[1]) + s[0]) / (c64::new(1.0, 0.0) - q * (q * s[4] + s[3]))
            };
            let held = table.iter().map(section).fold(c64::new(1.0, 0.0), |p, s| p * s);
            let exact = axis.at(z);
            (exact.norm(), (held / exact - 1.0).norm())
        })
        .collect();
    let peak = points.iter().map(|p| p.0).fold(0.0, f64::max);
    points.iter().filter(|p| p.0 > 1e-3 * peak).map(|p| p.1).fold(0.0, f64::max)
}

fn random_roots(random: &mut ChaCha8Rng, count: usize, real: std::ops::Range<f64>) -> Vec<c64> {
    let mut roots = Vec::new();
    while roots.len() < count {
        let left = count - roots.len();
        if left >= 2 && random.random_range(0.0..1.0) < 0.55 {
            let root = c64::from_polar(random.random_range(0.1..0.99), random.random_range(0.05..3.1));
            let twice = left >= 4 && random.random_range(0.0..1.0) < 0.2;
            (0..=usize::from(twice)).for_each(|_| roots.extend([root, root.conj()]));
        } else {
            let root = c64::new(random.random_range(real.clone()), 0.0);
            let times = if random.random_range(0.0..1.0) < 0.2 { 2.min(left) } else { 1 };
            roots.extend(std::iter::repeat_n(root, times));
        }
    }
    roots
}

#[test]
fn tables_of_random_axes_of_any_order_follow_them() {
    let mut random = ChaCha8Rng::seed_from_u64(56);
    let (mut single, mut worst) = (0, 0.0f64);
    for _ in 0..15 {
        let axes: [Axis; 4] = std::array::from_fn(|_| {
            let n = random.random_range(1..11);
            let relative_degree = random.random_range(0..=n.min(3));
            Axis {
                gain: 10f64.powf(random.random_range(2.0..5.0)),
                poles: random_roots(&mut random, n, -0.95..0.97),
                zeros: random_roots(&mut random, n - relative_degree, -1.3..1.3),
            }
        });
        let files = exported(&decentralised(&axes.each_ref().map(Axis::companion)));
        let header = header(&files).unwrap_or_else(|| panic!("{:?}", files.notes));
        for (name, axis) in AXES.iter().zip(&axes) {
            // An axis without a table has a sentence that names it.
            let Some(table) = table(&header, &format!("k_cmsis_{name}")) else {
                assert!(files.notes.iter().any(|n| n.contains(name) && n.contains("section")), "{:?}", files.notes);
                continue;
            };
            single += 1;
            let found = difference(&table, axis);
            worst = worst.max(found);
            assert!(found < 0.01, "{found:e} {axis:?}");
        }
    }
    // Rounding costs 1e-4 where roots repeat; a zero that is lost costs the whole response.
    assert!(single >= 57 && worst < 0.01, "{single} {worst:e}");
}

/// Three poles, one of them real, and a pair of zeros that belongs to the pair of poles.
#[test]
fn a_single_real_pole_leaves_the_zeros_to_the_pair() {
    let pair = |re: f64, im: f64| [c64::new(re, im), c64::new(re, -im)];
    let real = |value: f64| c64::new(value, 0.0);
    let axis = Axis {
        gain: 1000.0,
        poles: [&pair(-0.128, 0.830)[..], &[real(0.917)]].concat(),
        zeros: [&pair(0.886, 0.240)[..], &[real(0.25)]].concat(),
    };
    let law = decentralised(&[(); 4].map(|()| axis.companion()));
    let files = exported(&law);
    let sections = table(&header(&files).unwrap(), "k_cmsis_rear_x").unwrap();
    assert_eq!(sections.len(), 2);
    assert!(difference(&sections, &axis) < 1e-6);
    assert!(files.notes.is_empty());
    assert_eq!(second_order_sections(&law).unwrap().order(), law.order());
}

/// PID with lags: an integrator, real poles at 3.0 and 0.05 Hz, slow real zeros.
fn slow_real() -> Axis {
    let at = |hz: f64| c64::new((-2.0 * PI * hz * TIME.period_s).exp(), 0.0);
    Axis {
        gain: 2e4,
        poles: vec![c64::new(1.0, 0.0), at(3.0), at(0.05), c64::new(0.4, 0.3), c64::new(0.4, -0.3)],
        zeros: vec![at(8.0), at(1.0), at(0.2), c64::new(-0.6, 0.0)],
    }
}

#[test]
fn slow_real_poles_stand_apart_and_keep_their_place_in_float32() {
    let axis = slow_real();
    let files = exported(&decentralised(&[(); 4].map(|()| axis.chain())));
    let sections = table(&header(&files).unwrap(), "k_cmsis_front_x").unwrap();
    // The shift of a pole by half an ulp, 3e-8, of its distance from one, 1.6e-5.
    assert!(difference(&sections, &axis) < 3e-3, "{}", difference(&sections, &axis));
    assert!(sections.iter().any(|s| s[3] == 1.0 && s[4] == 0.0), "the integrator is exact: {sections:?}");
    assert!(files.notes.is_empty(), "{:?}", files.notes);
}

#[test]
fn a_slow_pair_that_float32_cannot_hold_gets_a_table_in_double_precision_and_a_sentence() {
    let pole = (c64::new(-0.7, 0.714) * (2.0 * PI * 0.5 * TIME.period_s)).exp();
    let slow = Axis {
        gain: 5e3,
        poles: vec![pole, pole.conj(), c64::new(0.5, 0.0)],
        zeros: vec![c64::new(0.999, 0.0), c64::new(0.9995, 0.0)],
    };
    let fast = slow_real();
    let files = exported(&decentralised(&[slow.chain(), fast.chain(), fast.chain(), fast.chain()]));
    let header = header(&files).unwrap();
    assert!(table(&header, "k_cmsis_front_x").is_none());
    assert!(difference(&table(&header, "k_f64_front_x").unwrap(), &slow) < 1e-6);
    assert!(table(&header, "k_cmsis_front_y").is_some());
    let [note] = &files.notes[..] else { panic!("{:?}", files.notes) };
    for words in ["front_x", "sections", "the pole at 0.4999 Hz", "double precision", "would move to"] {
        assert!(note.contains(words) && header.contains(words), "{words}: {note}");
    }
}
