//! Modal form of poles that nearly repeat, against closed forms.

use crate::export::firmware::{TIME, hidden, pair, real};
use muspin::controller::realise::modal_form;
use muspin::linalg::{Mat, c64};
use muspin::lti::StateSpace;
use std::f64::consts::{PI, TAU};

/// Pole e^(−ζω + jω√(1−ζ²)) of a damped oscillator, ω in radians a sample.
fn pole(frequency_hz: f64, damping: f64) -> c64 {
    let w = TAU * frequency_hz * TIME.period_s;
    c64::from_polar((-damping * w).exp(), w * (1.0 - damping * damping).sqrt())
}

/// Coupling of the two oscillators.
const COUPLING: f64 = 0.02;

/// Two oscillators in series, ξ₁⁺ = p₁ξ₁ + gξ₂ and ξ₂⁺ = p₂ξ₂ + v with ξ = x₁ − jx₂ of each: a Jordan block when p₁ =
/// p₂. The output is Re ξ₁ and the input drives Re ξ₂. A decaying pole stands beside them.
fn series(relative_distance: f64) -> StateSpace<muspin::lti::Discrete> {
    let (first, second) = (pair(700.0, 0.02), pair(700.0 * (1.0 + relative_distance), 0.02));
    let mut a = Mat::zeros(5, 5);
    a.submatrix_mut(0, 0, 2, 2).copy_from(&first);
    a.submatrix_mut(2, 2, 2, 2).copy_from(&second);
    (a[(0, 2)], a[(1, 3)]) = (COUPLING, COUPLING);
    a[(4, 4)] = 0.8;
    let b = Mat::from_fn(5, 1, |i, _| if i == 2 { 1.0 } else { f64::from(i == 4) });
    let c = Mat::from_fn(1, 5, |_, j| if j == 0 { 1.0 } else { f64::from(j == 4) });
    // An orthogonal similarity (a Householder reflection) hides the structure without spoiling the condition.
    let v = [0.6, -0.3, 0.5, 0.2, -0.4];
    let square: f64 = v.iter().map(|x| x * x).sum();
    let h = Mat::from_fn(5, 5, |i, j| f64::from(i == j) - 2.0 * v[i] * v[j] / square);
    StateSpace::new(&h * &a * &h, &h * &b, &c * &h, Mat::zeros(1, 1), TIME).unwrap()
}

/// The transfer function of [`series`]: half of g/((z−p₁)(z−p₂)) and its conjugate, and 1/(z−0.8).
fn closed_form(relative_distance: f64, z: c64) -> c64 {
    let (p, q) = (pole(700.0, 0.02), pole(700.0 * (1.0 + relative_distance), 0.02));
    let chain = |p: c64, q: c64| 0.5 * COUPLING / ((z - p) * (z - q));
    chain(p, q) + chain(p.conj(), q.conj()) + 1.0 / (z - 0.8)
}

#[test]
fn oscillators_in_series_keep_their_transfer_at_any_distance_of_their_poles() {
    for (distance, largest_block) in
        [(0.0, 4), (1e-12, 4), (1e-9, 4), (1e-7, 4), (1e-6, 4), (1e-5, 0), (1e-4, 0), (1e-3, 2), (1e-2, 2), (0.3, 2)]
    {
        let system = series(distance);
        let form = modal_form(&system).unwrap_or_else(|e| panic!("{distance:e}: {e}"));
        let back = form.to_state_space().unwrap();
        let (mut peak, mut change) = (0.0f64, 0.0f64);
        for k in 1..400 {
            let z = c64::from_polar(1.0, PI * (k as f64 / 400.0).powi(2));
            let exact = closed_form(distance, z);
            peak = peak.max(exact.norm());
            change = change.max((back.transfer(z)[(0, 0)] - exact).norm());
        }
        // The form itself promises 1e-9 against the system, whose entries carry the last digit besides.
        assert!(change < 2e-9 * peak, "{distance:e}: {:e}", change / peak);
        let size = form.blocks.iter().copied().max().unwrap();
        // Where the blocks part is decided by the accuracy; far from it on both sides it is certain.
        assert!(largest_block == 0 || size == largest_block, "{distance:e}: {:?}", form.blocks);
        assert_eq!(form.notes.iter().any(|n| n.contains("4x4")), size == 4, "{distance:e}");
        assert!(form.blocks.contains(&1) && form.condition <= 1e6, "{distance:e}");
    }
}

#[test]
fn several_nearly_equal_pairs_keep_their_transfer() {
    // Seven pairs whose frequencies differ by one part in ten thousand or less, and poles far from them.
    for step in [1e-4, 1e-5, 1e-6, 1e-8] {
        let mut blocks: Vec<Mat<f64>> = (0..7).map(|k| pair(900.0 * (1.0 + step * f64::from(k)), 0.03)).collect();
        blocks.extend([real(0.3), real(-0.6), pair(3000.0, 0.2)]);
        let system = hidden(&blocks, 4, 4, 11);
        let form = modal_form(&system).unwrap_or_else(|e| panic!("{step:e}: {e}"));
        assert_eq!(form.blocks.iter().sum::<usize>(), 18);
        assert!(form.blocks.iter().filter(|n| **n <= 2).count() >= 3, "{:?}", form.blocks);
    }
}
