//! Margins of single channels against closed forms: a unit mass on a unit negative stiffness under a PD and a PID.

use muspin::linalg::{Mat, c64};
use muspin::lti::{FrequencyGrid, HeldResponse, Response};
use muspin::predict::loop_gain::LoopGain;

/// y = u/(s² − 1) in every channel.
struct Fall;

/// u = −(P + D s + I/s) y in every channel.
struct Law {
    p: f64,
    d: f64,
    i: f64,
}

fn every_channel(value: c64) -> Mat<c64> {
    Mat::from_fn(4, 4, |i, j| if i == j { value } else { c64::new(0.0, 0.0) })
}

impl Response for Fall {
    fn at(&self, omega: f64) -> Mat<c64> {
        every_channel(c64::new(-1.0 / (omega * omega + 1.0), 0.0))
    }
}

impl HeldResponse for Law {
    fn held_at(&self, omega: f64) -> Mat<c64> {
        every_channel(-c64::new(self.p, self.d * omega - self.i / omega))
    }
}

fn grid() -> FrequencyGrid {
    FrequencyGrid::log_hz(1e-3, 1e3, 20_000)
}

#[test]
fn a_mass_on_negative_stiffness_falls_below_its_static_gain() {
    let (p, d) = (3.0, 0.8f64);
    let gain = LoopGain::new(&Fall, &Law { p, d, i: 0.0 }, &grid());
    for channel in 0..4 {
        let found = gain.margin(channel);
        // s² + k D s + k P − 1: stable for k > 1/P, however large.
        assert!((found.smallest_gain_factor - 1.0 / p).abs() < 1e-6, "{found:?}");
        assert_eq!(found.largest_gain_factor, f64::INFINITY);
        // |L| = 1: P² + D² x = (1 + x)², x = ω²; the angle from −1 is atan(ω D/P).
        let half = 0.5 * d * d - 1.0;
        let x = half + (half * half + p * p - 1.0).sqrt();
        let hz = x.sqrt() / std::f64::consts::TAU;
        assert!((found.crossover_hz / hz - 1.0).abs() < 1e-6, "{found:?} for {hz}");
        assert!((found.phase_deg - (x.sqrt() * d / p).atan().to_degrees()).abs() < 1e-3, "{found:?}");
        assert_eq!(found.phase_hz, found.crossover_hz);
    }
}

#[test]
fn an_integral_raises_the_smallest_gain() {
    let (p, d, i) = (3.0, 0.8, 0.4);
    let found = LoopGain::new(&Fall, &Law { p, d, i }, &grid()).margin(2);
    // Routh for s³ + k D s² + (k P − 1) s + k I: k > (1 + I/D)/P.
    let smallest = (1.0 + i / d) / p;
    assert!((found.smallest_gain_factor / smallest - 1.0).abs() < 1e-5, "{found:?} for {smallest}");
    assert_eq!(found.largest_gain_factor, f64::INFINITY);
}
