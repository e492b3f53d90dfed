//! A measurement before the rig runs: sweeps and hammer tests as the sensors of a machine would give them, with their
//! noise.
//!
//! The loop is closed with u = K y_m + r. White noise n of `sensor_noise_m` rms per axis adds to the signals,
//! y_m = G u + n, and reaches the currents through the controller:
//!   U = (I − K G)⁻¹ (R + K N),   Y = G U + N,
//! with the full finite-element plant, the hold and the exact delay. A Fourier coefficient taken over T seconds at f_s
//! samples a second has noise of the variance E|N|² = 4σ²/(f_s T). Same machine, controller and seed: same record.

use super::frf::{AXES, SweepRecord};
use super::hammer::{HammerFrf, closed_loop_compliance};
use crate::linalg::{Mat, c64, solve_complex};
use crate::lti::held::return_difference;
use crate::lti::response::even_in_logarithm;
use crate::lti::{HeldResponse, Response};
use crate::rotor::PlanarModes;
use crate::rotor::modes::RIGID;
use crate::spindle::band::sweep_end_hz;
use crate::spindle::{Machine, ModelDetail, Plant, SpindleError};
use ndarray::Array4;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// How the measurement is taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Rehearsal {
    /// Lines, Hz, ascending and positive.
    pub frequency_hz: Vec<f64>,
    /// Repeats of every experiment.
    pub repeats: usize,
    /// Amplitude of the current that is injected into one axis after the other, A.
    pub injection_a: f64,
    /// Time over which a line is averaged, s, or ten periods where that is longer.
    pub averaging_s: f64,
    /// Amplitude of the force of a hammer blow at a line, N.
    pub hammer_force_n: f64,
    /// Blows that are averaged.
    pub blows: usize,
    /// Seed of the noise.
    pub seed: u64,
}

impl Rehearsal {
    /// Even lines in the logarithm, from a fiftieth of the first bending mode, at most 20 Hz, to a quarter beyond the
    /// last mode of the design model (at most a fifth of the sample rate, at least the end of the stiffness band, but
    /// never beyond 0.4 of the sample rate); an injection of a twentieth of the front bias current, half a second or
    /// ten periods a line, three repeats; blows of 1 N a line, five averages.
    ///
    /// # Errors
    /// [`SpindleError`] when the modes of the rotor cannot be computed.
    pub fn usual(machine: &Machine) -> Result<Self, SpindleError> {
        let modes = PlanarModes::new(&machine.rotor()?)?;
        let flexible = &modes.omega_rad_s[RIGID..];
        let end_hz = sweep_end_hz(machine, flexible);
        let last = (0.4 * machine.spindle.electronics.sample_rate_hz).min(end_hz);
        let bending_hz = flexible.first().map_or(f64::INFINITY, |w| w / TAU);
        let first = (bending_hz / 50.0).min(20.0);
        let mut rehearsal = Self {
            frequency_hz: vec![],
            repeats: 3,
            injection_a: 0.05 * machine.spindle.front.bias_current_a,
            averaging_s: 0.5,
            hammer_force_n: 1.0,
            blows: 5,
            seed: 1,
        };
        rehearsal.spread(first, last, None);
        Ok(rehearsal)
    }

    /// First and last line, Hz; zero for none.
    pub fn range_hz(&self) -> (f64, f64) {
        let end = |hz: Option<&f64>| hz.copied().unwrap_or_default();
        let lines = &self.frequency_hz;
        (end(lines.first()), end(lines.last()))
    }

    /// Even lines in the logarithm from `first_hz` to `last_hz`, both positive: so many, or one for each 0.9 %, the
    /// width of a peak with 0.4 % of damping.
    pub fn spread(&mut self, first_hz: f64, last_hz: f64, lines: Option<usize>) {
        let usual = || 1 + (LINES_PER_E_FOLD * (last_hz / first_hz).ln()).round() as usize;
        let lines = lines.unwrap_or_else(usual);
        self.frequency_hz = even_in_logarithm(first_hz, last_hz, lines).collect();
    }

    /// Standard deviation of the complex coefficient of a sensor at a line, m.
    fn noise_m(&self, machine: &Machine, line_hz: f64) -> f64 {
        let electronics = &machine.spindle.electronics;
        let time_s = self.averaging_s.max(10.0 / line_hz);
        let samples = electronics.sample_rate_hz * time_s;
        2.0 * electronics.sensor_noise_m / samples.sqrt()
    }

    /// The sweep of a machine that floats on `controller`, four axes in turn; `name` is that of the record.
    ///
    /// # Errors
    /// [`SpindleError`] when the plant of the machine cannot be built.
    pub fn sweep(
        &self,
        machine: &Machine,
        controller: &dyn HeldResponse,
        speed_rpm: f64,
        name: &str,
    ) -> Result<SweepRecord, SpindleError> {
        let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
        let mut random = Random::new(self.seed, speed_rpm);
        let shape = (self.frequency_hz.len(), AXES, self.repeats, AXES);
        let zero = c64::new(0.0, 0.0);
        let mut current = Array4::from_elem(shape, zero);
        let mut signal = Array4::from_elem(shape, zero);
        for (line, hz) in self.frequency_hz.iter().enumerate() {
            let (omega, sd) = (TAU * hz, self.noise_m(machine, *hz));
            let g = plant.at(omega).submatrix(0, 0, AXES, AXES).to_owned();
            let k = controller.held_at(omega);
            let loop_gain = return_difference(&k, &g);
            for experiment in 0..AXES {
                for repeat in 0..self.repeats {
                    let noise = Mat::from_fn(AXES, 1, |_, _| random.complex(sd));
                    let mut injected = &k * &noise;
                    injected[(experiment, 0)] += c64::new(self.injection_a, 0.0);
                    let u = solve_complex(&loop_gain, &injected);
                    let y = &g * &u + noise;
                    for axis in 0..AXES {
                        current[[line, experiment, repeat, axis]] = u[(axis, 0)];
                        signal[[line, experiment, repeat, axis]] = y[(axis, 0)];
                    }
                }
            }
        }
        Ok(SweepRecord {
            name: name.to_owned(),
            speed_rpm,
            frequency_hz: self.frequency_hz.clone(),
            current,
            signal,
            left_out: vec![],
            run_out: false,
        })
    }

    /// The compliance at the tool plane in x from blows of a hammer: the mean over the blows, and the coherence that
    /// they have among each other. One blow alone has none.
    pub(crate) fn hammer(
        &self,
        machine: &Machine,
        controller: &dyn HeldResponse,
        speed_rpm: f64,
    ) -> Result<HammerFrf, SpindleError> {
        let plant = Plant::new(machine, speed_rpm * TAU / 60.0, ModelDetail::Full)?;
        let blows = self.blows.max(1);
        // Another stream than that of the sweep.
        let mut random = Random::new(self.seed.wrapping_add(1 << 32), speed_rpm);
        let (mut compliance, mut coherence) = (vec![], vec![]);
        for hz in &self.frequency_hz {
            let exact = closed_loop_compliance(&plant, controller, TAU * hz, 0);
            // Of one blow.
            let one = self.noise_m(machine, *hz) / self.hammer_force_n;
            let (mut sum, mut power) = (c64::new(0.0, 0.0), 0.0);
            for _ in 0..blows {
                let blow = exact + random.complex(one);
                sum += blow;
                power += blow.norm_sqr();
            }
            let mean = sum / blows as f64;
            compliance.push(mean);
            coherence.push(blows as f64 * mean.norm_sqr() / power);
        }
        let averages = Some(vec![blows as f64; compliance.len()]);
        Ok(HammerFrf {
            speed_rpm,
            frequency_hz: self.frequency_hz.clone(),
            compliance,
            coherence: Some(coherence),
            averages,
        })
    }
}

/// Lines of a usual sweep for each factor e of frequency: 599 steps from 20 Hz to 4 kHz.
const LINES_PER_E_FOLD: f64 = 113.056;

/// Normal deviates of one record.
struct Random(ChaCha8Rng);

impl Random {
    /// A stream of its own for every seed and speed.
    fn new(seed: u64, speed_rpm: f64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed ^ speed_rpm.to_bits()))
    }

    /// A circular complex deviate with E|z|² = sd².
    fn complex(&mut self, sd: f64) -> c64 {
        let mut part = || -> f64 { StandardNormal.sample(&mut self.0) };
        let (re, im) = (part(), part());
        c64::new(re, im) * (sd / std::f64::consts::SQRT_2)
    }
}
