//! Singular values of a loop whose channels are apart, in closed form.

use muspin::linalg::{Mat, c64};
use muspin::lti::{FrequencyGrid, HeldResponse, Response};
use muspin::predict::loop_sigma::LoopSigma;

/// Lags g/(1 + jω τ) on the diagonal.
struct Lags([f64; 4], f64);

impl Lags {
    fn channel(&self, k: usize, omega: f64) -> c64 {
        c64::new(self.0[k], 0.0) / c64::new(1.0, omega * self.1)
    }

    fn matrix(&self, omega: f64) -> Mat<c64> {
        Mat::from_fn(4, 4, |i, j| if i == j { self.channel(i, omega) } else { c64::new(0.0, 0.0) })
    }
}

impl Response for Lags {
    fn at(&self, omega_rad_s: f64) -> Mat<c64> {
        self.matrix(omega_rad_s)
    }
}

impl HeldResponse for Lags {
    fn held_at(&self, omega_rad_s: f64) -> Mat<c64> {
        self.matrix(omega_rad_s)
    }
}

#[test]
fn channels_that_are_apart_have_the_largest_of_their_own_values() {
    let (plant, law) = (Lags([1e-4, 2e-4, 5e-5, 1e-5], 2e-3), Lags([-3e4, -1e4, -8e4, -9e4], 1e-4));
    let grid = FrequencyGrid::log_hz(1.0, 3e3, 25);
    let found = LoopSigma::new(&plant, &law, &grid);
    for (n, omega) in grid.omega_rad_s().iter().enumerate() {
        let largest = |of: &dyn Fn(c64, c64) -> c64| {
            let each = (0..4).map(|k| of(plant.channel(k, *omega), law.channel(k, *omega)).norm());
            each.fold(0.0, f64::max)
        };
        let one = c64::new(1.0, 0.0);
        let pairs = [
            (found.controller[n], largest(&|_, k| k)),
            (found.loop_gain[n], largest(&|g, k| g * k)),
            (found.sensitivity[n], largest(&|g, k| one / (one - g * k))),
            (found.complementary[n], largest(&|g, k| g * k / (one - g * k))),
            (found.effort[n], largest(&|g, k| k / (one - g * k))),
        ];
        for (found, expected) in pairs {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
    }
}
