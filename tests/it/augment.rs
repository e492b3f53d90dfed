//! Weights against closed forms, the w plane against the sampled plane.

use muspin::augment::weighting::{level_change, roll_on};
use muspin::lti::Response;
use std::f64::consts::TAU;

#[test]
fn level_change_meets_both_levels_and_the_crossing() {
    for (dc, hf) in [(40.0, 5.0), (1e5, 1e4 / 3.0), (2e4, 1e5)] {
        let w = level_change(dc, hf, 40.0).unwrap();
        assert!((w.at(1e-9)[(0, 0)].norm() / dc - 1.0).abs() < 1e-9);
        assert!((w.at(1e12)[(0, 0)].norm() / hf - 1.0).abs() < 1e-6);
        let crossing = w.at(TAU * 40.0)[(0, 0)].norm();
        assert!((crossing / (dc * hf).sqrt() - 1.0).abs() < 1e-12);
    }
    let w = roll_on(2.5, 3000.0, 10.0).unwrap();
    assert!((w.at(1e-6)[(0, 0)].norm() * 2.5 - 1.0).abs() < 1e-9);
    assert!((w.at(1e12)[(0, 0)].norm() * 2.5 / 100.0 - 1.0).abs() < 1e-6);
    assert!((w.at(TAU * 3000.0)[(0, 0)].norm() * 2.5 - 2.0 / 1.01).abs() < 1e-9);
}

#[test]
fn the_w_plane_keeps_the_transfer_and_maps_back() {
    let period_s = 5e-5;
    let sampled = StateSpace::new(
        Mat::from_fn(3, 3, |i, j| {
            [[0.9, 0.2, 0.0], [-0.2, 0.9, 0.1], [0.0, 0.0, -0.4]][i][j]
        }),
        Mat::from_fn(3, 2, |i, j| 1.0 + (i as f64) - 2.0 * (j as f64)),
        Mat::from_fn(2, 3, |i, j| 0.5 - (i * j) as f64),
        Mat::from_fn(2, 2, |i, j| (i + j) as f64),
        Discrete { period_s },
    )
    .unwrap();
    let w_plane = to_w_plane(&sampled).unwrap();
    let back = from_w_plane(&w_plane, period_s).unwrap();
    for f in [3.0, 300.0, 1070.0, 6000.0] {
        let omega = TAU * f;
        let v = 2.0 / period_s * (0.5 * omega * period_s).tan();
        let z = sampled.at(omega);
        let scale = max_singular_value_complex(&z);
        assert!(max_singular_value_complex(&(w_plane.at(v) - &z)) < 1e-9 * scale);
        assert!(max_singular_value_complex(&(back.at(omega) - &z)) < 1e-9 * scale);
    }
}
