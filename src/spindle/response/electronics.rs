//! Amplifiers, delay and eddy currents before the shaft, sensors behind it, at one line.
//!
//! Force per current  e^{−sT} k_i /((1 + s/ω_a)(1 + √(s/ω_e))) [1 κ; κ 1],  signal per displacement  g R(α)/((1 +
//! s/ω_s) L(s)), L = 1 + 2ζ s/ω_l + (s/ω_l)² the second-order low-pass. Each axis has lags and a factor of its own.

use super::channels::{SIDE, Square, ZERO, planar};
use crate::linalg::c64;
use crate::spindle::correction::LawSite;
use crate::spindle::effective::{AxisElectronics, Effective, EffectiveBearing};
use std::f64::consts::TAU;

/// Damping ratio of the sensor low-pass: Butterworth's.
pub(crate) const LOWPASS_DAMPING: f64 = 0.707;

/// The electronics at one line: 2×2 blocks (x, y) of each bearing, row-major.
#[derive(Clone, Debug)]
pub(crate) struct ElectronicsLine {
    /// Forces per commanded currents, N/A.
    force: [[c64; 4]; 2],
    /// Signals per displacements, −.
    axes: [[c64; 4]; 2],
    /// Share of the signal of each axis in that of another, where there is any.
    crosstalk: Option<[[f64; 4]; 4]>,
    /// What the signals pick up of the currents, where there is any.
    pickup: Option<[c64; 16]>,
}

impl ElectronicsLine {
    /// The electronics of a machine at angular frequency `omega_rad_s`.
    pub(crate) fn new(machine: &Effective, omega_rad_s: f64) -> Self {
        let s = c64::new(0.0, omega_rad_s);
        let delay = (-s * machine.delay_s).exp();
        let sensor = (s / (TAU * machine.sensor_bandwidth_hz) + 1.0).inv();
        Self {
            crosstalk: machine.has_crosstalk().then_some(machine.crosstalk),
            pickup: machine.has_pickup().then(|| pickup(machine, s)),
            force: std::array::from_fn(|b| {
                let own = &machine.bearings[b];
                let law = |p: usize| machine.law_gain(LawSite::Current(2 * b + p), omega_rad_s);
                let gains = [0, 1].map(|p| delay * actuator(&own.axes[p], s) * law(p));
                let shape = own.force_matrix();
                std::array::from_fn(|k| gains[k % 2] * shape[k / 2][k % 2])
            }),
            axes: std::array::from_fn(|b| {
                let own = &machine.bearings[b];
                let law = |p: usize| machine.law_gain(LawSite::Signal(2 * b + p), omega_rad_s);
                let gains = [0, 1].map(|p| sensor * own.sensor_gain * lowpass(&own.axes[p], s) * law(p));
                let shape = own.axes_matrix();
                std::array::from_fn(|k| gains[k / 2] * shape[k / 2][k % 2])
            }),
        }
    }

    /// F from the closed receptance forwards and backwards (3×3: sensors and tool from magnets and tool).
    pub(crate) fn apply(&self, plus: &[c64; 9], minus: Option<&[c64; 9]>) -> Square {
        let mut f = [ZERO; SIDE * SIDE];
        let apart = self.crosstalk.is_none() && self.force.iter().chain(&self.axes).all(apart);
        for k in 0..9 {
            let (o, i) = (2 * (k / 3), 2 * (k % 3));
            let (a, b) = planar(plus[k], minus.map(|minus| minus[k]));
            if apart {
                // Most entries are zero, and each of the others is only scaled.
                let scaled = |v: c64, out: usize, input: usize| {
                    let v = self.force.get(i / 2).map_or(v, |m| v * m[3 * input]);
                    self.axes.get(o / 2).map_or(v, |m| v * m[3 * out])
                };
                f[o * SIDE + i] = scaled(a, 0, 0);
                f[(o + 1) * SIDE + i + 1] = scaled(a, 1, 1);
                if minus.is_some() {
                    f[(o + 1) * SIDE + i] = scaled(b, 1, 0);
                    f[o * SIDE + i + 1] = scaled(-b, 0, 1);
                }
                continue;
            }
            f[o * SIDE + i] = a;
            f[(o + 1) * SIDE + i + 1] = a;
            f[(o + 1) * SIDE + i] = b;
            f[o * SIDE + i + 1] = -b;
        }
        if !apart {
            self.apply_with_pickup(&mut f, SIDE);
        } else if let Some(pickup) = &self.pickup {
            add_pickup(&mut f, pickup, SIDE, 1.0);
        }
        f
    }

    /// F of one unit in an entry of the receptance (row-major 3×3), from x to x, or from x to y.
    pub(crate) fn unit(&self, entry: usize, across: bool) -> Square {
        let (o, i) = (entry / 3, entry % 3);
        let (one, zero) = (c64::new(1.0, 0.0), ZERO);
        let shaft = if across { [zero, -one, one, zero] } else { [one, zero, zero, one] };
        let by = |a: &[c64; 4], b: &[c64; 4]| -> [c64; 4] {
            std::array::from_fn(|n| a[n / 2 * 2] * b[n % 2] + a[n / 2 * 2 + 1] * b[2 + n % 2])
        };
        let forced = self.force.get(i).map_or(shaft, |m| by(&shaft, m));
        let block = self.axes.get(o).map_or(forced, |m| by(m, &forced));
        let mut f = [ZERO; SIDE * SIDE];
        for (n, value) in block.into_iter().enumerate() {
            f[(2 * o + n / 2) * SIDE + 2 * i + n % 2] = value;
        }
        if let Some(shares) = &self.crosstalk {
            mix(&mut f, shares, SIDE);
        }
        f
    }

    /// From displacements and forces to signals and currents in place: a square row-major response whose first four
    /// rows and columns are the axes.
    pub(crate) fn apply_to(&self, f: &mut [c64], side: usize) {
        for (i, m) in self.force.iter().enumerate() {
            let (x, y) = (2 * i, 2 * i + 1);
            let apart = apart(m);
            for row in f.chunks_mut(side) {
                let (on_x, on_y) = (row[x], row[y]);
                (row[x], row[y]) = if apart {
                    (on_x * m[0], on_y * m[3])
                } else {
                    (on_x * m[0] + on_y * m[2], on_x * m[1] + on_y * m[3])
                };
            }
        }
        for (i, m) in self.axes.iter().enumerate() {
            let (x, y) = (2 * i * side, (2 * i + 1) * side);
            let apart = apart(m);
            for column in 0..side {
                let (of_x, of_y) = (f[x + column], f[y + column]);
                (f[x + column], f[y + column]) = if apart {
                    (of_x * m[0], of_y * m[3])
                } else {
                    (m[0] * of_x + m[1] * of_y, m[2] * of_x + m[3] * of_y)
                };
            }
        }
        if let Some(shares) = &self.crosstalk {
            mix(f, shares, side);
        }
    }

    /// As [`Self::apply_to`], with what the signals pick up of the currents, which no derivative to the shaft has.
    pub(crate) fn apply_with_pickup(&self, f: &mut [c64], side: usize) {
        self.apply_to(f, side);
        if let Some(pickup) = &self.pickup {
            add_pickup(f, pickup, side, 1.0);
        }
    }
}

/// Adds to the signals, the first four rows of a square row-major response, their shares of each other.
pub(super) fn mix(f: &mut [c64], shares: &[[f64; 4]; 4], side: usize) {
    let own: Vec<c64> = f[..4 * side].to_vec();
    for (to, row) in shares.iter().enumerate() {
        for (from, share) in row.iter().enumerate().filter(|(_, share)| **share != 0.0) {
            let seen = own[from * side..(from + 1) * side].iter();
            f[to * side..(to + 1) * side].iter_mut().zip(seen).for_each(|(f, seen)| *f += seen * *share);
        }
    }
}

/// Without coupling across a bearing, the usual case, both axes are only scaled.
fn apart(block: &[c64; 4]) -> bool {
    block[1] == ZERO && block[2] == ZERO
}

/// tanh(√q)/√q with q = s/ω_l: the flux of a sheet whose eddy currents shield its middle (Lammeraner and Štafl, Eddy
/// Currents, 1966, chapter 2).
pub(crate) fn sheet_flux(q: c64) -> c64 {
    let x = q.sqrt();
    // Re √q > 0: no overflow.
    let decayed = (x * -2.0).exp();
    let tanh = (c64::new(1.0, 0.0) - decayed) / (c64::new(1.0, 0.0) + decayed);
    if x.norm() < 1e-6 { c64::new(1.0, 0.0) - q / 3.0 } else { tanh / x }
}

/// Coil current per command, weakened by eddy currents: tanh(√(s/ω_l))/√(s/ω_l) / (1 + √(s/ω_e)).
pub(super) fn actuator(axis: &AxisElectronics, s: c64) -> c64 {
    let sheets = axis.lamination_corner_hz.map_or(c64::new(1.0, 0.0), |corner| sheet_flux(s / (TAU * corner)));
    let gain = sheets * axis.coil_current(s);
    match axis.eddy_corner_hz {
        None => gain,
        Some(corner) => gain / ((s / (TAU * corner)).sqrt() + 1.0),
    }
}

/// The low-pass of one sensor axis.
pub(super) fn lowpass(axis: &AxisElectronics, s: c64) -> c64 {
    axis.sensor_lowpass_hz.map_or(c64::new(1.0, 0.0), |corner| {
        let q = s / (TAU * corner);
        (q * (2.0 * LOWPASS_DAMPING) + q * q + 1.0).inv()
    })
}

/// What the signals (rows) pick up of the rates of the currents (columns), per command, 4×4 row-major.
pub(super) fn pickup(machine: &Effective, s: c64) -> [c64; 16] {
    let delay = (-s * machine.delay_s).exp();
    std::array::from_fn(|k| {
        let (to, from) = (k / 4, k % 4);
        let current = machine.bearings[from / 2].axes[from % 2].coil_current(s);
        s * delay * current * machine.current_pickup[to][from]
    })
}

/// Adds to the signals, the first four rows and columns of a square row-major response, times a sign, what they pick up
/// of the currents.
pub(super) fn add_pickup(f: &mut [c64], pickup: &[c64; 16], side: usize, sign: f64) {
    for (k, share) in pickup.iter().enumerate() {
        f[k / 4 * side + k % 4] += share * sign;
    }
}

impl EffectiveBearing {
    /// Forces (x, y) per currents (x, y) behind the amplifiers, N/A.
    pub(crate) fn force_matrix(&self) -> [[f64; 2]; 2] {
        let (direct, cross) = (self.ki_n_per_a, self.ki_n_per_a * self.coupling_ratio);
        let [x, y] = self.axes.map(|axis| axis.force_factor);
        [[direct * x, cross * y], [cross * x, direct * y]]
    }

    /// Sensor axes (x', y') from displacements (x, y).
    pub(crate) fn axes_matrix(&self) -> [[f64; 2]; 2] {
        let (sin, cos) = self.sensor_angle_rad.sin_cos();
        let [x, y] = self.axes.map(|axis| axis.signal_factor);
        [[x * cos, x * sin], [-y * sin, y * cos]]
    }
}
