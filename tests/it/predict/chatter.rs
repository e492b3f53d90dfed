//! Stability lobes against closed forms and against the delayed equation of motion integrated in time.

use muspin::linalg::{Mat, c64};
use muspin::predict::chatter::{
    ChatterError, CuttingMaterial, Engagement, directional_coefficients, milling, orthogonal,
};
use std::f64::consts::{PI, TAU};

const K: f64 = 2.0e6;
const ZETA: f64 = 0.03;
const OMEGA: f64 = TAU * 1069.0;
const ALUMINIUM: CuttingMaterial = CuttingMaterial { tangential_pa: 7.5e8, radial_ratio: 0.3 };

fn mode(w: f64, k: f64, zeta: f64, omega: f64) -> c64 {
    let r = w / omega;
    c64::new(1.0, 0.0) / (c64::new(1.0 - r * r, 2.0 * zeta * r) * k)
}

fn grid(points: usize) -> Vec<f64> {
    (1..=points).map(|i| 3.0 * OMEGA * i as f64 / points as f64).collect()
}

fn single(points: usize) -> (Vec<f64>, Vec<c64>) {
    let w = grid(points);
    let g = w.iter().map(|w| mode(*w, K, ZETA, OMEGA)).collect();
    (w, g)
}

#[test]
fn orthogonal_minimum_is_two_k_zeta_one_plus_zeta_over_ks() {
    let (w, g) = single(60_000);
    let least = orthogonal(&w, &g, 7.5e8).unwrap().minimum().unwrap();
    let exact = 2.0 * K * ZETA * (1.0 + ZETA) / 7.5e8;
    assert!((least.depth_m / exact - 1.0).abs() < 1e-6, "{} {exact}", least.depth_m);
    // The minimum lies at r = √(1 + 2ζ).
    assert!((least.omega_rad_s / OMEGA - (1.0 + 2.0 * ZETA).sqrt()).abs() < 1e-3);
}

/// Growth of x over the second half of 400 periods of m ẍ + c ẋ + k x = −K_s b (x(t) − x(t − T)), by semi-implicit
/// steps.
fn growth(depth: f64, ks: f64, period: f64) -> f64 {
    let steps = (period * OMEGA / TAU * 400.0).ceil() as usize;
    let dt = period / steps as f64;
    let m = K / (OMEGA * OMEGA);
    let c = 2.0 * ZETA * (K * m).sqrt();
    let total = 160_000usize;
    let mut history = vec![0.0f64; total + 1];
    let (mut x, mut v) = (1e-6, 0.0);
    for n in 0..total {
        history[n] = x;
        let past = if n >= steps { history[n - steps] } else { 0.0 };
        // Velocity Verlet with the damping at mid step: second order, no artificial damping.
        let a = |x: f64, v: f64, past: f64| (-c * v - K * x - ks * depth * (x - past)) / m;
        let v_half = v + 0.5 * dt * a(x, v, past);
        x += dt * v_half;
        let next = if n + 1 >= steps { history[n + 1 - steps] } else { 0.0 };
        v = (v_half + 0.5 * dt * (-K * x - ks * depth * (x - next)) / m) / (1.0 + 0.5 * dt * c / m);
    }
    let size = |a: usize, b: usize| history[a..b].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    size(total - 30_000, total) / size(total / 2 - 30_000, total / 2)
}

#[test]
fn the_limit_separates_decay_from_growth_in_time() {
    let ks = 7.5e8;
    let (w, g) = single(20_000);
    let limit = orthogonal(&w, &g, ks).unwrap();
    for rpm in [9_000.0, 14_500.0, 21_000.0, 33_000.0, 52_000.0] {
        let speed = rpm * TAU / 60.0;
        let depth = limit.depth_at(speed).unwrap();
        assert!(growth(0.95 * depth, ks, TAU / speed) < 1.0, "{rpm} rpm: stable below the limit");
        assert!(growth(1.05 * depth, ks, TAU / speed) > 1.0, "{rpm} rpm: unstable above the limit");
    }
}

fn responses(w: &[f64], f: impl Fn(f64) -> [[c64; 2]; 2]) -> Vec<Mat<c64>> {
    w.iter().map(|w| Mat::from_fn(2, 2, |i, j| f(*w)[i][j])).collect()
}

#[test]
fn slotting_with_one_flexible_direction_has_its_closed_form() {
    let w = grid(60_000);
    let zero = c64::new(0.0, 0.0);
    let phi = responses(&w, |w| [[mode(w, K, ZETA, OMEGA), zero], [zero, zero]]);
    let cut = Engagement::slot(2);
    let least = milling(&w, &phi, &ALUMINIUM, &cut).unwrap().minimum().unwrap();
    // α_xx = −π K_r in a slot, so that the most negative Re Φ = −1/(4kζ(1+ζ)) decides.
    let alpha = PI * ALUMINIUM.radial_ratio;
    assert!((directional_coefficients(&cut, ALUMINIUM.radial_ratio)[0][0] + alpha).abs() < 1e-12);
    let exact = TAU * 4.0 * K * ZETA * (1.0 + ZETA) / (2.0 * ALUMINIUM.tangential_pa * alpha);
    assert!((least.depth_m / exact - 1.0).abs() < 1e-6, "{} {exact}", least.depth_m);
}

#[test]
fn on_the_limit_the_characteristic_determinant_vanishes() {
    let w = grid(40_000);
    let at = |w: f64| {
        let cross = mode(w, 3e7, 0.04, 1.3 * OMEGA);
        [[mode(w, K, ZETA, OMEGA), cross], [-cross, mode(w, 1.4 * K, 0.02, 1.1 * OMEGA)]]
    };
    let cut = Engagement::down_milling(3, 0.4);
    let limit = milling(&w, &responses(&w, at), &ALUMINIUM, &cut).unwrap();
    let a0 = directional_coefficients(&cut, ALUMINIUM.radial_ratio);
    let speed = 17_300.0 * TAU / 60.0;
    let depth = limit.depth_at(speed).unwrap();
    // |det| over frequency at this speed and depth touches zero somewhere, and stays away from it at 0.8 of the depth.
    let smallest = |depth: f64| {
        let det = |w: f64| {
            let p = at(w);
            let turn = c64::new(0.0, -w * TAU / (3.0 * speed)).exp();
            let lambda = (c64::new(1.0, 0.0) - turn) * (-3.0 / (2.0 * TAU) * depth * ALUMINIUM.tangential_pa);
            let e = |i: usize, j: usize| lambda * (p[0][j] * a0[i][0] + p[1][j] * a0[i][1]);
            ((e(0, 0) + 1.0) * (e(1, 1) + 1.0) - e(0, 1) * e(1, 0)).norm()
        };
        (1..200_000).map(|i| det(3.0 * OMEGA * f64::from(i) / 200_000.0)).fold(f64::INFINITY, f64::min)
    };
    assert!(smallest(depth) < 2e-3, "{}", smallest(depth));
    assert!(smallest(0.8 * depth) > 0.03, "{}", smallest(0.8 * depth));
}

#[test]
fn no_speed_is_worse_than_the_minimum_and_stiffer_is_deeper() {
    let (w, g) = single(20_000);
    let limit = orthogonal(&w, &g, 7.5e8).unwrap();
    let least = limit.minimum().unwrap().depth_m;
    let speeds: Vec<f64> = (1..=500).map(|k| TAU / 60.0 * 100.0 * f64::from(k)).collect();
    assert!(limit.depths(&speeds).iter().all(|d| d.is_nan() || *d >= least * (1.0 - 1e-12)));
    let stiffer: Vec<c64> = g.iter().map(|g| g * 0.5).collect();
    let twice = orthogonal(&w, &stiffer, 7.5e8).unwrap().minimum().unwrap().depth_m;
    assert!((twice / least - 2.0).abs() < 1e-12);
}

#[test]
fn values_out_of_range_are_named() {
    let (w, g) = single(100);
    assert!(matches!(orthogonal(&w, &g, -1.0), Err(ChatterError::Value { what: "specific cutting force", .. })));
    assert!(matches!(orthogonal(&w, &g[1..], 1e9), Err(ChatterError::Response { .. })));
    let phi = responses(&w, |_| [[c64::new(0.0, 0.0); 2]; 2]);
    let backwards = Engagement { teeth: 2, entry_rad: 2.0, exit_rad: 1.0 };
    assert!(matches!(milling(&w, &phi, &ALUMINIUM, &backwards), Err(ChatterError::Value { .. })));
    assert!(milling(&w, &phi, &ALUMINIUM, &Engagement::slot(2)).unwrap().minimum().is_none());
}

#[test]
fn up_and_down_milling_mirror_each_other_and_end_in_a_slot() {
    for width in [0.1, 0.5, 0.8] {
        let (up, down) = (Engagement::up_milling(4, width), Engagement::down_milling(4, width));
        assert!((up.exit_rad + down.entry_rad - PI).abs() < 1e-12);
        // The radial width of cut, in diameters, between entry and exit of the tooth.
        let cut = 0.5 * (up.entry_rad.cos() - up.exit_rad.cos());
        assert!((cut - width).abs() < 1e-12);
    }
    assert_eq!(Engagement::up_milling(2, 1.0), Engagement::slot(2));
    assert_eq!(Engagement::down_milling(2, 1.0), Engagement::slot(2));
}
