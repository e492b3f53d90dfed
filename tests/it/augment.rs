//! Weights and the planar design model against closed forms.

use muspin::augment::plane::{PlaneModel, PortMode};
use muspin::augment::sampled::{continuous_plane, from_w_plane, pade, sampled_plane, to_w_plane};
use muspin::augment::weighting::{level_change, roll_on};
use muspin::linalg::{Mat, c64, max_singular_value_complex};
use muspin::lti::Response;
use std::f64::consts::TAU;

fn plane(delay_s: f64) -> PlaneModel {
    let mode = |omega: f64, load: [f64; 3], sensor: [f64; 2]| PortMode {
        omega_rad_s: omega,
        damping_ratio: 0.004,
        load_shape: load,
        sensor_shape: sensor,
    };
    PlaneModel {
        modes: vec![
            mode(0.0, [0.34, 0.34, 0.34], [0.34, 0.34]),
            mode(0.0, [-0.9, -0.3, 0.4], [-0.5, 0.45]),
            mode(TAU * 1069.0, [2.7, -0.2, 0.3], [0.03, 0.45]),
        ],
        residual_m_per_n: Mat::from_fn(5, 3, |i, j| 1e-9 * (1.0 + (i + j) as f64)),
        ki_n_per_a: [270.0, 115.4],
        ks_n_per_m: [1.5e6, 6.4e5],
        sensor_gain: [1.0, 1.02],
        amplifier_bandwidth_hz: 2000.0,
        sensor_bandwidth_hz: 12000.0,
        delay_s,
        sample_time_s: 5e-5,
    }
}

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
fn pade_matches_the_delay_to_its_order() {
    for order in 1..=4 {
        let d = pade(75e-6, order).unwrap();
        let w = TAU * 1000.0;
        let error = (d.at(w)[(0, 0)] - c64::from_polar(1.0, -w * 75e-6)).norm();
        // Error of the diagonal approximant: 2·(n!)²/((2n)!(2n+1)!)·(ωτ)^(2n+1) to leading order.
        let f = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
        let bound = f(order).powi(2) / (f(2 * order) * f(2 * order + 1))
            * (w * 75e-6).powi(2 * order as i32 + 1);
        assert!(
            error < 1.1 * bound + 1e-13,
            "order {order}: {error:e} against {bound:e}"
        );
        assert!((d.at(w)[(0, 0)].norm() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_sampled_plane_approaches_the_exact_chain_at_low_frequency() {
    // The hold's half sample is part of the effective delay; a delay of 1.5 and of 1.9 samples in all.
    for delay in [75e-6, 95e-6] {
        let model = plane(delay);
        let sampled = sampled_plane(&model, &[2]).unwrap();
        let exact = model.state_space(&[2]).unwrap();
        let f = 200.0;
        let (s, e) = (sampled.at(TAU * f), exact.at(TAU * f));
        let lag = c64::from_polar(1.0, -TAU * f * delay);
        for (row, column) in [(4, 4), (5, 5), (1, 4), (0, 5)] {
            let expected = e[(row, column)] * lag;
            let error = (s[(row, column)] - expected).norm() / expected.norm();
            // sinc of the hold at 200 Hz: 1 − (πfT)²/6 ≈ 1.6e-4; aliased poles add as much again.
            assert!(error < 1e-3, "{row},{column}: {error:e}");
        }
    }
}

#[test]
fn the_w_plane_keeps_the_transfer_and_maps_back() {
    let sampled = sampled_plane(&plane(75e-6), &[2]).unwrap();
    let w_plane = to_w_plane(&sampled).unwrap();
    let back = from_w_plane(&w_plane, 5e-5).unwrap();
    for f in [3.0, 300.0, 1070.0, 6000.0] {
        let omega = TAU * f;
        let v = 2.0 / 5e-5 * (omega * 2.5e-5).tan();
        let z = sampled.at(omega);
        let scale = max_singular_value_complex(&z);
        assert!(max_singular_value_complex(&(w_plane.at(v) - &z)) < 1e-9 * scale);
        assert!(max_singular_value_complex(&(back.at(omega) - &z)) < 1e-9 * scale);
    }
}

#[test]
fn residual_flexibility_acts_through_the_magnets() {
    // Static balance by hand: no modes but two rigid ones pinned by nothing, so use f high enough that modes are stiff:
    // compare with the dense solution of x = (R + Φ(ω²-..)⁻¹Φᵀ) f, f = F + K_s x.
    let model = plane(0.0);
    let system = continuous_plane(&model, &[2], 0).unwrap();
    let omega = TAU * 700.0;
    let s = c64::new(0.0, omega);
    let receptance = |i: usize, j: usize| {
        model
            .modes
            .iter()
            .fold(c64::new(model.residual_m_per_n[(i, j)], 0.0), |sum, m| {
                let shape = if i < 3 {
                    m.load_shape[i]
                } else {
                    m.sensor_shape[i - 3]
                };
                sum + c64::new(shape * m.load_shape[j], 0.0)
                    / (s * s + s * (2.0 * m.damping_ratio * m.omega_rad_s) + m.omega_rad_s.powi(2))
            })
    };
    let ks = [0.0, 1.5e6, 6.4e5];
    let h = Mat::from_fn(3, 3, &receptance);
    let pencil = Mat::from_fn(3, 3, |i, j| {
        c64::new(f64::from(u8::from(i == j)), 0.0) - h[(i, j)] * ks[j]
    });
    let x = muspin::linalg::solve_complex(&pencil, &h);
    let found = system.at(omega);
    for i in 0..3 {
        for j in 0..3 {
            assert!((found[(1 + i, 1 + j)] - x[(i, j)]).norm() < 1e-10 * x[(i, j)].norm());
        }
    }
}
