//! Step at the tool and amplification factors of one mass, spring and damper against their closed forms.

use muspin::linalg::{Mat, c64};
use muspin::lti::{Discrete, StateSpace};
use muspin::predict::amplification::{CriticalSpeed, find_critical_speeds};
use muspin::predict::tool_step::{ToolStep, static_load_settling_s};
use std::convert::Infallible;
use std::f64::consts::TAU;

const PERIOD_S: f64 = 1e-5;

/// Force (after four control channels that do nothing) to displacement, ẍ + 2ζωẋ + ω²x = ω² f, sampled with a hold.
fn oscillator(omega: f64, zeta: f64) -> StateSpace<Discrete> {
    let root = (1.0 - zeta * zeta).sqrt();
    let (decay, turn) = ((-zeta * omega * PERIOD_S).exp(), omega * root * PERIOD_S);
    let (c, s) = (decay * turn.cos(), decay * turn.sin() / root);
    let a = [[c + zeta * s, s], [-s, c - zeta * s]];
    StateSpace::new(
        Mat::from_fn(2, 2, |i, j| a[i][j]),
        Mat::from_fn(2, 5, |i, j| if j == 4 { [1.0 - a[0][0], -a[1][0]][i] } else { 0.0 }),
        Mat::from_fn(5, 2, |i, j| if (i, j) == (4, 0) { 1.0 } else { 0.0 }),
        Mat::zeros(5, 5),
        Discrete { period_s: PERIOD_S },
    )
    .unwrap()
}

#[test]
fn a_step_overshoots_and_settles_as_the_closed_form() {
    let nothing = StateSpace::gain(Mat::zeros(4, 4), Discrete { period_s: PERIOD_S });
    for (omega, zeta) in [(2000.0, 0.1), (700.0, 0.5), (5000.0, 0.02)] {
        let step = ToolStep::of(&oscillator(omega, zeta), &nothing).unwrap();
        let root = (1.0f64 - zeta * zeta).sqrt();
        let overshoot = (-std::f64::consts::PI * zeta / root).exp();
        assert!((step.final_m_per_n - 1.0).abs() < 1e-9, "{}", step.final_m_per_n);
        assert!((step.overshoot - overshoot).abs() < 1e-4, "ζ {zeta}: {} for {overshoot}", step.overshoot);
        let away = |t: f64| {
            let turn = omega * root * t;
            (-zeta * omega * t).exp() * (turn.cos() + zeta / root * turn.sin())
        };
        let mut last = 0.0;
        for k in 0..2_000_000 {
            let t = 1e-7 * f64::from(k);
            if away(t).abs() > 0.02 {
                last = t;
            }
        }
        assert!((step.settling_s - last).abs() < 2.0 * PERIOD_S, "ζ {zeta}: {} for {last}", step.settling_s);
    }
}

/// x(t) = 1 + R e^(−t/T) − (1 + R) e^(−1000 t/T): a slow integral action takes back R times the static deflection, and
/// settles after T ln(50 R), however many time constants that are.
#[test]
fn a_slow_return_settles_by_what_it_has_to_take_back() {
    let nothing = StateSpace::gain(Mat::zeros(4, 4), Discrete { period_s: PERIOD_S });
    for (slow_s, back) in [(0.3, 160.0), (1.0, 3.0), (1.0, 0.1), (0.05, 1.0), (100.0, 0.5)] {
        let rates = [1.0 / slow_s, 1000.0 / slow_s];
        let decays = rates.map(|rate: f64| (-rate * PERIOD_S).exp());
        let plant = StateSpace::new(
            Mat::from_fn(2, 2, |i, j| if i == j { decays[i] } else { 0.0 }),
            Mat::from_fn(2, 5, |i, j| if j == 4 { 1.0 - decays[i] } else { 0.0 }),
            Mat::from_fn(5, 2, |i, j| if i == 4 { [-back, 1.0 + back][j] } else { 0.0 }),
            Mat::zeros(5, 5),
            Discrete { period_s: PERIOD_S },
        )
        .unwrap();
        let found = static_load_settling_s(&plant, &nothing).unwrap();
        let expected = slow_s * (50.0f64 * back).ln();
        assert!((found - expected).abs() < 2.0 * PERIOD_S, "{slow_s} s, {back}: {found} for {expected}");
    }
}

/// An oscillation beside a slow state that moves the tool by next to nothing: every sample counts, also those that a
/// search in steps of the slow one would pass over.
#[test]
fn a_slow_state_that_hardly_acts_does_not_hide_an_oscillation() {
    let nothing = StateSpace::gain(Mat::zeros(4, 4), Discrete { period_s: PERIOD_S });
    for (hz, rate, slow_rate) in [(300.0, 90.0, 0.2), (1700.0, 900.0, 3.0), (40.0, 25.0, 20.0), (300.0, 90.0, 1e-3)] {
        let turn = c64::new(-rate, TAU * hz) * PERIOD_S;
        let (pole, slow) = (turn.exp(), (-slow_rate * PERIOD_S).exp());
        let a = [[pole.re, -pole.im, 0.0], [pole.im, pole.re, 0.0], [0.0, 0.0, slow]];
        // 1 − Re(pole)ᵏ in the end, and 1e-8 of the slow one.
        let (b, c) = ([1.0 - pole.re, -pole.im, 1.0 - slow], [1.0, 0.0, 1e-8]);
        let plant = StateSpace::new(
            Mat::from_fn(3, 3, |i, j| a[i][j]),
            Mat::from_fn(3, 5, |i, j| if j == 4 { b[i] } else { 0.0 }),
            Mat::from_fn(5, 3, |i, j| if i == 4 { c[j] } else { 0.0 }),
            Mat::zeros(5, 5),
            Discrete { period_s: PERIOD_S },
        )
        .unwrap();
        let found = static_load_settling_s(&plant, &nothing).unwrap();
        let beyond = |k: &u32| pole.powu(*k).re.abs() > 0.02;
        let last = (0..40_000u32).rfind(beyond).unwrap();
        let expected = f64::from(last + 1) * PERIOD_S;
        assert!((found - expected).abs() < 1.5 * PERIOD_S, "{hz} Hz: {found} for {expected}");
    }
}

/// Amplitude of an unbalanced mass over speed.
fn unbalance(rpm: f64, critical_rpm: f64, zeta: f64) -> f64 {
    let r = rpm / critical_rpm;
    r * r / ((1.0 - r * r).powi(2) + (2.0 * zeta * r).powi(2)).sqrt()
}

fn critical_speeds(zeta: f64, critical_rpm: f64) -> Vec<CriticalSpeed> {
    let speeds: Vec<f64> = (1..=60).map(|k| 1000.0 * f64::from(k)).collect();
    let values: Vec<f64> = speeds.iter().map(|rpm| unbalance(*rpm, critical_rpm, zeta)).collect();
    find_critical_speeds(&speeds, &values, &|rpm| Ok::<_, Infallible>(unbalance(rpm, critical_rpm, zeta))).unwrap()
}

#[test]
fn an_amplification_factor_is_the_speed_over_the_width_at_half_power() {
    for (zeta, critical_rpm) in [(0.05, 31_300.0), (0.02, 30_500.0), (0.15, 20_000.0)] {
        let [found] = critical_speeds(zeta, critical_rpm)[..] else { panic!("one maximum") };
        // The maximum and its half-power points, ω² terms solved exactly: 1/a² = ((1 − x)² + 4ζ²x)/x², x = r².
        let top = 1.0 / (1.0 - 2.0 * zeta * zeta);
        let least = ((1.0 - top).powi(2) + 4.0 * zeta * zeta * top) / (top * top);
        // (1 − 2·least) x² − (2 − 4ζ²) x + 1 = 0.
        let (a, b) = (1.0 - 2.0 * least, 2.0 - 4.0 * zeta * zeta);
        let root = (b * b - 4.0 * a).sqrt();
        let ends = [(b - root) / (2.0 * a), (b + root) / (2.0 * a)].map(|x| critical_rpm * x.sqrt());
        let stated = critical_rpm * top.sqrt() / (ends[1] - ends[0]);
        assert!((found.speed_rpm / (critical_rpm * top.sqrt()) - 1.0).abs() < 2e-3, "{found:?}");
        assert!((found.amplification / stated - 1.0).abs() < 0.05, "ζ {zeta}: {found:?} for {stated}");
        assert!((found.half_power_rpm[0] - ends[0]).abs() < 25.0 && (found.half_power_rpm[1] - ends[1]).abs() < 25.0);
    }
    assert!(critical_speeds(0.8, 30_000.0).is_empty(), "no maximum");
}

#[test]
fn a_critical_speed_above_the_top_speed_keeps_the_distance_that_api_617_asks_for() {
    let at = |speed_rpm: f64, amplification: f64| CriticalSpeed { speed_rpm, half_power_rpm: [0.0; 2], amplification };
    // 10 + 17 (1 − 1/(5 − 1.5)) percent.
    assert!((at(60_000.0, 5.0).separation_asked() - 0.221_428_571_428_571_4).abs() < 1e-12);
    assert!(at(61_100.0, 5.0).is_acceptable(50_000.0) && !at(61_000.0, 5.0).is_acceptable(50_000.0));
    assert!(!at(30_000.0, 2.6).is_acceptable(50_000.0) && at(30_000.0, 2.4).is_acceptable(50_000.0));
}
