//! The open loop of one whirl coordinate at a speed, with every mode of the mesh: forces and currents in,
//! displacements and sensor signals out.

use super::beam::Shaft;
use super::files::{SpindleFile, ToolFile};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side, c64};
use std::f64::consts::TAU;

/// Tool, front and rear actuator.
pub const PLACES: usize = 3;
/// Front and rear bearing.
pub const BEARINGS: usize = 2;

/// A machine in modal coordinates, VᵀMV = I.
#[derive(Clone)]
pub struct Rotor {
    /// Natural frequencies at rest, magnets off, rad/s; the first two are zero.
    pub omega_rad_s: Vec<f64>,
    /// Modal dampers 2ζω, 1/s.
    pub damper_per_s: Vec<f64>,
    gyroscopic: Mat<f64>,
    /// What the magnets take from the modal stiffness, 1/s².
    magnets: Mat<f64>,
    /// Rows of tool, front actuator, rear actuator.
    places: [Vec<f64>; PLACES],
    /// Rows of front and rear sensor, gain included.
    sensors: [Vec<f64>; BEARINGS],
    ki_n_per_a: [f64; BEARINGS],
    amplifier_rad_s: f64,
    sensor_rad_s: f64,
    pub period_s: f64,
    pub delay_s: f64,
    pub max_rpm: f64,
}

/// How commanded currents reach the amplifier.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Samples through a zero-order hold, then the delay less half a sample.
    Held,
    /// A continuous signal through the whole delay.
    Continuous,
}

impl Rotor {
    /// The machine of two files.
    pub fn new(spindle: &SpindleFile, tool: &ToolFile) -> Self {
        assert!(spindle.effects.is_empty(), "no effects here");
        let shaft = Shaft::new(spindle, tool);
        let (omega_rad_s, shapes) = modes(&shaft);
        let ratio = &spindle.rotor.damping_ratio;
        let damper = |k: usize| match k {
            0 | 1 => 0.0,
            _ => 2.0 * ratio[(k - 2).min(ratio.len() - 1)] * omega_rad_s[k],
        };
        let row = |z: f64, gain: f64| -> Vec<f64> {
            let row = shaft.row(z);
            (0..shapes.ncols()).map(|k| gain * (0..row.len()).map(|i| row[i] * shapes[(i, k)]).sum::<f64>()).collect()
        };
        let (p, e) = (spindle.planes, spindle.electronics);
        let bearings = [spindle.bearings.front, spindle.bearings.rear];
        let gain = bearings.map(|b| b.sensor_gain.unwrap_or(1.0));
        let gyroscopic = if spindle.gyroscopics {
            shapes.transpose() * &shaft.gyroscopic * &shapes
        } else {
            Mat::zeros(shapes.ncols(), shapes.ncols())
        };
        let places = [-tool.tool_plane_m, p.front_actuator_m, p.rear_actuator_m];
        let places = places.map(|z| row(z, 1.0));
        let magnet = |b: usize, i: usize, j: usize| bearings[b].ks_n_per_m * places[1 + b][i] * places[1 + b][j];
        let n = omega_rad_s.len();
        Self {
            damper_per_s: (0..n).map(damper).collect(),
            gyroscopic,
            magnets: Mat::from_fn(n, n, |i, j| magnet(0, i, j) + magnet(1, i, j)),
            places,
            sensors: [row(p.front_sensor_m, gain[0]), row(p.rear_sensor_m, gain[1])],
            ki_n_per_a: bearings.map(|b| b.ki_n_per_a),
            amplifier_rad_s: TAU * e.amplifier_bandwidth_hz,
            sensor_rad_s: TAU * e.sensor_bandwidth_hz,
            period_s: 1.0 / e.sample_rate_hz,
            delay_s: e.delay_s,
            max_rpm: spindle.speed.max_rpm,
            omega_rad_s,
        }
    }

    /// The machine with the natural frequencies of its first flexible modes multiplied; the dampers 2ζω keep their
    /// values.
    pub fn with_scaled_modes(&self, factors: &[f64]) -> Self {
        let mut scaled = self.clone();
        for (omega, factor) in scaled.omega_rad_s[2..].iter_mut().zip(factors) {
            *omega *= factor;
        }
        scaled
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.omega_rad_s.len()
    }

    /// Modal stiffness with magnets, 1/s².
    fn stiffness(&self, i: usize, j: usize) -> f64 {
        let own = if i == j { self.omega_rad_s[i].powi(2) } else { 0.0 };
        own - self.magnets[(i, j)]
    }

    /// Modal damping with gyroscopic moments, 1/s.
    fn damping(&self, i: usize, j: usize, speed_rad_s: f64) -> c64 {
        let own = if i == j { self.damper_per_s[i] } else { 0.0 };
        c64::new(own, -speed_rad_s * self.gyroscopic[(i, j)])
    }

    /// Response at a signed frequency (forward whirl positive). Columns: forces on the first `modal` flexible modes,
    /// on tool, front and rear actuator, commanded currents front and rear. Rows: those modal coordinates,
    /// displacements of the three places, sensor signals front and rear.
    pub fn response(&self, hz: f64, rpm: f64, modal: usize, command: Command) -> Mat<c64> {
        let (n, speed) = (self.modes(), rpm * TAU / 60.0);
        let s = c64::new(0.0, TAU * hz);
        // s·(−jΩG) is real at s = jω.
        let turning = speed * TAU * hz;
        let mut dynamic =
            Mat::from_fn(n, n, |i, j| c64::new(turning * self.gyroscopic[(i, j)] - self.magnets[(i, j)], 0.0));
        for i in 0..n {
            dynamic[(i, i)] += s * s + s * self.damper_per_s[i] + self.omega_rad_s[i].powi(2);
        }
        let ports = modal + PLACES;
        let unit = |k: usize, i: usize| if i == 2 + k { 1.0 } else { 0.0 };
        let loads = Mat::from_fn(n, ports + BEARINGS, |i, p| match p {
            p if p < modal => c64::new(unit(p, i), 0.0),
            p if p < ports => c64::new(self.places[p - modal][i], 0.0),
            p => self.current_path(s, command) * self.ki_n_per_a[p - ports] * self.places[1 + p - ports][i],
        });
        let q = dynamic.partial_piv_lu().solve(&loads);
        let sensor = c64::new(1.0, 0.0) / (c64::new(1.0, 0.0) + s / self.sensor_rad_s);
        let read = Mat::from_fn(ports + BEARINGS, n, |p, i| match p {
            p if p < modal => c64::new(unit(p, i), 0.0),
            p if p < ports => c64::new(self.places[p - modal][i], 0.0),
            p => sensor * self.sensors[p - ports][i],
        });
        read * q
    }

    /// Current in the magnet per commanded current.
    fn current_path(&self, s: c64, command: Command) -> c64 {
        let one = c64::new(1.0, 0.0);
        let amplifier = one / (one + s / self.amplifier_rad_s);
        let st = s * self.period_s;
        let way = match command {
            Command::Continuous => (-s * self.delay_s).exp(),
            Command::Held => {
                let hold = if st.norm() < 1e-9 { one } else { (one - (-st).exp()) / st };
                hold * (-s * self.pure_delay_s()).exp()
            }
        };
        amplifier * way
    }

    /// Delay besides the hold's half sample, s.
    pub fn pure_delay_s(&self) -> f64 {
        (self.delay_s - 0.5 * self.period_s).max(0.0)
    }

    /// First-order form (A, B, C) from the currents at the amplifiers to the sensor signals; states: modal
    /// coordinates times max(ω, 100 rad/s), modal velocities, currents, signals.
    pub fn first_order(&self, rpm: f64) -> (Mat<c64>, Mat<c64>, Mat<c64>) {
        let (n, speed) = (self.modes(), rpm * TAU / 60.0);
        let (current, signal) = (2 * n, 2 * n + BEARINGS);
        let scale: Vec<f64> = self.omega_rad_s.iter().map(|w| w.max(100.0)).collect();
        let real = |x: f64| c64::new(x, 0.0);
        let mut a = Mat::<c64>::zeros(signal + BEARINGS, signal + BEARINGS);
        for i in 0..n {
            a[(i, n + i)] = real(scale[i]);
            for j in 0..n {
                a[(n + i, j)] = real(-self.stiffness(i, j) / scale[j]);
                a[(n + i, n + j)] = -self.damping(i, j, speed);
            }
            for b in 0..BEARINGS {
                a[(n + i, current + b)] = real(self.ki_n_per_a[b] * self.places[1 + b][i]);
                a[(signal + b, i)] = real(self.sensor_rad_s * self.sensors[b][i] / scale[i]);
            }
        }
        let mut input = Mat::<c64>::zeros(signal + BEARINGS, BEARINGS);
        let mut output = Mat::<c64>::zeros(BEARINGS, signal + BEARINGS);
        for b in 0..BEARINGS {
            a[(current + b, current + b)] = real(-self.amplifier_rad_s);
            a[(signal + b, signal + b)] = real(-self.sensor_rad_s);
            input[(current + b, b)] = real(self.amplifier_rad_s);
            output[(b, signal + b)] = real(1.0);
        }
        (a, input, output)
    }
}

/// Natural frequencies, ascending, rad/s, and mass-normalised shapes of the free shaft.
fn modes(shaft: &Shaft) -> (Vec<f64>, Mat<f64>) {
    let n = shaft.mass.nrows();
    let unit: Vec<f64> = (0..n).map(|i| shaft.mass[(i, i)].sqrt().recip()).collect();
    let scaled = |m: &Mat<f64>| Mat::from_fn(n, n, |i, j| m[(i, j)] * unit[i] * unit[j]);
    let cholesky = scaled(&shaft.mass).llt(Side::Lower).expect("mass matrix is positive definite");
    let inverse = cholesky.L().partial_piv_lu().solve(Mat::<f64>::identity(n, n));
    let reduced = &inverse * scaled(&shaft.stiffness) * inverse.transpose();
    let symmetric = Mat::from_fn(n, n, |i, j| 0.5 * (reduced[(i, j)] + reduced[(j, i)]));
    let eigen = symmetric.self_adjoint_eigen(Side::Lower).expect("eigenvalues of the free shaft");
    let omega = (0..n).map(|k| if k < 2 { 0.0 } else { eigen.S()[k].sqrt() }).collect();
    let shapes = inverse.transpose() * eigen.U();
    (omega, Mat::from_fn(n, n, |i, j| unit[i] * shapes[(i, j)]))
}
