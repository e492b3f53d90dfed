//! Butterworth low passes in the companion form in which other tools write a transfer function: entries tens of decades
//! apart. Hankel values and sampled responses do not depend on state coordinates.

use crate::robust::solve_cases::{answer, matrix, number};
use muspin::controller::discretise::discretise_law;
use muspin::controller::realise::modal_form;
use muspin::controller::{ControlLaw, Controller};
use muspin::input::load_machine;
use muspin::linalg::{Mat, c64};
use muspin::lti::balance::{Balancing, hankel_values};
use muspin::lti::connect::{add, append, series};
use muspin::lti::norm::linf_norm;
use muspin::lti::sample::{tustin, zoh};
use muspin::lti::{Continuous, Discrete, Response, StateSpace};
use muspin::pipeline::comparison::predict;
use std::f64::consts::{PI, TAU};

/// 1/Π(s/ω + …): coefficients aₖ = aₖ₋₁ cos((k − 1)π/2n)/sin(kπ/2n) of the normalised filter (Butterworth 1930).
fn companion(n: usize, corner_rad_s: f64) -> StateSpace<Continuous> {
    let step = PI / (2 * n) as f64;
    let mut coefficient = vec![1.0];
    for k in 1..=n {
        coefficient.push(coefficient[k - 1] * ((k - 1) as f64 * step).cos() / (k as f64 * step).sin());
    }
    let power = |k: usize| corner_rad_s.powi(k as i32);
    let a =
        Mat::from_fn(
            n,
            n,
            |i, j| {
                if i == 0 { -coefficient[j + 1] * power(j + 1) } else { f64::from(u8::from(i == j + 1)) }
            },
        );
    StateSpace::new(
        a,
        Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == 0))),
        Mat::from_fn(1, n, |_, j| if j + 1 == n { power(n) } else { 0.0 }),
        Mat::zeros(1, 1),
        Continuous,
    )
    .unwrap()
}

/// The same filter as a chain of sections with entries of one size.
fn chain(n: usize, corner_rad_s: f64) -> StateSpace<Continuous> {
    let w = corner_rad_s;
    let mut chain = StateSpace::gain(Mat::identity(1, 1), Continuous);
    for k in 0..n / 2 {
        let damping = ((2 * k + 1) as f64 * PI / (2 * n) as f64).sin();
        let a = Mat::from_fn(2, 2, |i, j| [[0.0, w], [-w, -2.0 * damping * w]][i][j]);
        let b = Mat::from_fn(2, 1, |i, _| [0.0, w][i]);
        let c = Mat::from_fn(1, 2, |_, j| [1.0, 0.0][j]);
        chain = series(&chain, &StateSpace::new(a, b, c, Mat::zeros(1, 1), Continuous).unwrap()).unwrap();
    }
    if n % 2 == 1 {
        let one = |value: f64| Mat::from_fn(1, 1, |_, _| value);
        let last = StateSpace::new(one(-w), one(w), one(1.0), one(0.0), Continuous).unwrap();
        chain = series(&chain, &last).unwrap();
    }
    chain
}

#[test]
fn hankel_values_of_companion_forms_are_those_of_the_filter() {
    // First values from 60 digits; they do not depend on the corner.
    let exact = [(9, 1e5, 0.988_907_9), (11, 1e5, 0.996_403_4), (14, 6283.0, 0.999_382_4), (26, 1.0, 0.999_999_6)];
    for (n, corner, first) in exact {
        let values = hankel_values(&companion(n, corner)).unwrap();
        assert!((values[0] - first).abs() < 1e-6, "{n}: {}", values[0]);
        let other = hankel_values(&chain(n, corner)).unwrap();
        for (x, y) in values.iter().zip(&other) {
            // The coefficients of order 26 are rounded, and its poles move by a thousand times that.
            assert!((x - y).abs() < 1e-9, "{n}: {x} {y}");
        }
    }
}

#[test]
fn reduced_companion_forms_keep_the_error_bound() {
    let full = companion(11, 1e5);
    let balancing = Balancing::with_check(&full).unwrap();
    for order in [4, 7] {
        let reduced = balancing.truncate_states(order).unwrap();
        let minus = reduced.scale_outputs(&Mat::from_fn(1, 1, |_, _| -1.0));
        let error = linf_norm(&add(&chain(11, 1e5), &minus).unwrap(), 1e-6).unwrap().norm;
        let bound = 2.0 * balancing.hankel[order..].iter().sum::<f64>();
        assert!(error <= bound && error >= balancing.hankel[order], "{order}: {error} {bound}");
    }
}

#[test]
fn sampled_companion_forms_have_the_response_of_the_filter() {
    let (n, corner, period_s) = (4, TAU * 1000.0, 5e-5);
    let system = companion(n, corner);
    let (held, by_rule) = (zoh(&system, period_s).unwrap(), tustin(&system, period_s).unwrap());
    let other = zoh(&chain(n, corner), period_s).unwrap();
    for frequency_hz in [1.0, 333.0, 1000.0, 5000.0] {
        let omega = TAU * frequency_hz;
        // Tustin's rule warps the frequency.
        let warped = 2.0 / period_s * (0.5 * omega * period_s).tan();
        let exact = 1.0 / (1.0 + (warped / corner).powi(2 * n as i32)).sqrt();
        assert!((by_rule.at(omega)[(0, 0)].norm() / exact - 1.0).abs() < 1e-9, "{frequency_hz}");
        let [held, other] = [&held, &other].map(|s| s.at(omega)[(0, 0)]);
        assert!((held / other - c64::new(1.0, 0.0)).norm() < 1e-9, "{frequency_hz}");
    }
}

#[test]
fn every_rule_of_sampling_stands_alone() {
    let problem = r#"{"A": [[20.0]], "B": [[1]], "C": [[1]], "D": [[0]], "Ts": 0.1, "w_prewarp": 5}"#;
    let mut file = tempfile::Builder::new().suffix(".json").tempfile().unwrap();
    std::io::Write::write_all(&mut file, problem.as_bytes()).unwrap();
    let found = answer("discretise", file.path());
    assert!((number(&found["zoh"]["A"][0][0]) - 2f64.exp()).abs() < 1e-14);
    assert!(found.get("tustin").is_none());
    let [note] = &found["notes"].as_array().unwrap()[..] else { panic!("{found}") };
    let note = note.as_str().unwrap();
    assert!(note.contains("pole at s = 20") && note.contains("tustin"), "{note}");
    // Prewarped, the rule has its pole elsewhere.
    let k = 5.0 / 0.25f64.tan();
    assert!((matrix(&found["tustin_prewarp"]["A"])[(0, 0)] - (k + 20.0) / (k - 20.0)).abs() < 1e-12);
}

#[test]
fn a_continuous_controller_in_companion_form_is_realised_as_in_any_other() {
    let (n, corner, period_s) = (7, TAU * 2000.0, 5e-5);
    let sampled = |law: StateSpace<Continuous>| -> StateSpace<Discrete> {
        let controller = Controller { name: "filter".to_owned(), law: ControlLaw::Continuous(law) };
        match discretise_law(&controller, period_s, 1000.0).unwrap().unwrap().law {
            ControlLaw::Discrete(law) => modal_form(&law).unwrap().to_state_space().unwrap(),
            ControlLaw::Continuous(_) => panic!("it is sampled"),
        }
    };
    let (given, other) = (sampled(companion(n, corner)), sampled(chain(n, corner)));
    for k in 1..40 {
        let z = c64::from_polar(1.0, PI * f64::from(k) / 40.0);
        let difference = given.transfer(z)[(0, 0)] - other.transfer(z)[(0, 0)];
        assert!(difference.norm() < 1e-9, "{k}: {difference}");
    }
}

/// Numbers of a PID whose filter an optimiser has left 1e20 beyond every frequency: a chain of integrators with gains
/// of powers of two, and the coefficients that feed back to its first.
const CHAIN: [f64; 3] = [1.9807040628566084e28, 7.737125245533627e25, 8796093022208.0];
const BACK: [f64; 4] = [1.7062135810636688e28, 1.0206459859056757e28, 8.858210155597783e25, 10070619004634.162];
const DRIVE: f64 = 1.29246971e-26;
const READ: [f64; 4] = [0.0, -1.31654101e78, -1.12267900e55, -7.64642265e42];

fn filter_beyond_every_frequency() -> StateSpace<Continuous> {
    let a = Mat::from_fn(4, 4, |i, j| match i {
        0 => -BACK[j],
        _ if i == j + 1 => CHAIN[j],
        _ => 0.0,
    });
    let b = Mat::from_fn(4, 1, |i, _| if i == 0 { DRIVE } else { 0.0 });
    StateSpace::new(a, b, Mat::from_fn(1, 4, |_, j| READ[j]), Mat::zeros(1, 1), Continuous).unwrap()
}

#[test]
fn a_filter_beyond_every_frequency_leaves_the_response_its_digits() {
    let law = filter_beyond_every_frequency();
    for hz in [1.0, 10.0, 100.0, 1000.0, 4000.0] {
        let s = c64::new(0.0, TAU * hz);
        // From the last state of the chain backwards: no difference of large numbers.
        let mut x = [c64::new(1.0, 0.0); 4];
        for k in (0..3).rev() {
            x[k] = s * x[k + 1] / CHAIN[k];
        }
        let sum = |row: &[f64; 4]| row.iter().zip(&x).map(|(c, x)| x * c).sum::<c64>();
        let exact = sum(&READ) * DRIVE / (s * x[0] + sum(&BACK));
        let found = law.at(s.im)[(0, 0)];
        assert!((found - exact).norm() < 1e-12 * exact.norm(), "{hz} Hz: {found} {exact}");
    }
}

#[test]
fn a_loop_whose_stability_rounding_hides_is_an_error_and_neither_stable_nor_unstable() {
    let machine = load_machine("reference", "paper-tool").unwrap();
    let one = filter_beyond_every_frequency();
    let all = append(&append(&one, &one), &append(&one, &one));
    let controller = Controller { name: "pid".to_owned(), law: ControlLaw::Continuous(all) };
    let error = predict(&machine, &controller, 0.0).unwrap_err().to_string();
    assert!(error.contains("hides on which side of stability"), "{error}");
}
