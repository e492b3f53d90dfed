//! A PID for the thrust axis: one loop, tuned for the largest minimum of the dynamic stiffness of the shaft along its
//! axis, subject to stability of the sampled loop, a sensitivity peak within zone A of ISO 14839-3 and a limit on the
//! current from sensor noise. PI + D, roll-off and one biquad, sampled by Tustin's rule as in [`super::parameters`].
//! Search: descents of a simplex from gains of a rigid mass, then random steps on lines that follow the poles of
//! the loop; the figures that are reported come from lines set round those of the loop that was found.

use super::parameters::{AxisParameters, Biquad};
use super::settings::TuneSettings;
use crate::controller::verification::growth_words;
use crate::controller::verification_error::VerificationError;
use crate::controller::{ControlLaw, Controller, ControllerError, in_step};
use crate::linalg::simplex_search::descend_simplex;
use crate::linalg::{Mat, c64};
use crate::lti::connect::lower_lft;
use crate::lti::held::hold_magnitude;
use crate::lti::sample::tustin;
use crate::lti::{Continuous, Discrete, FrequencyGrid, Response, StateSpace, TimeBase};
use crate::spindle::ThrustAxis;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

/// Sensitivity peak aimed at as a share of the end of zone A: peaks between the lines of the search are higher by less
/// than the rest.
const AIM: f64 = 0.98;
/// Zone A of ISO 14839-3 ends at this peak of |S|.
const ZONE_A: f64 = 3.0;
/// Lines of the search, and of the figures before those round the poles.
const SEARCH_LINES: usize = 200;
const FIGURE_LINES: usize = 600;
/// Lines on each side of a pole: three to a half-power width.
const LINES_A_SIDE: usize = 3;
/// Restoring stiffness of the starts over the negative stiffness of the magnet: soft, usual, stiff.
const START_STIFFNESS: [f64; 3] = [0.5, 1.5, 4.0];
/// Damping ratio of the starts.
const START_DAMPING: f64 = 0.7;
/// A magnet with little negative stiffness starts as one whose unstable pole lies at this share of Nyquist; the
/// stiffest start then has its crossover at about twice that.
const LEAST_UNSTABLE_POLE: f64 = 0.01;
/// Descents from each start, each from a new simplex round the end of the one before, and largest number of steps of a
/// descent: eight numbers settle within some hundred.
const DESCENTS: usize = 2;
const STEPS: usize = 400;
/// Side of the first simplex, in the logarithms of the numbers; each later one has half of it.
const FIRST_SIDE: f64 = 0.3;
/// Rounds of random steps from the best end, each on lines round the poles of the loop so far, and steps of a round:
/// from an end that missed zone A by a half, five hundred led into it.
const ROUNDS: usize = 3;
const RANDOM_STEPS: usize = 700;
/// First length of a step in the logarithms, how it changes with a step that is kept and one that is not, and below
/// what it begins anew.
const FIRST_STEP: f64 = 0.1;
const LONGER: f64 = 1.5;
const SHORTER: f64 = 0.95;
const LEAST_STEP: f64 = 2e-3;
const SEED: u64 = 1;
/// Penalty per logarithm of the excess over a limit: far more than the logarithm of the stiffness that the excess buys.
const EXCESS_WEIGHT: f64 = 30.0;
/// Corner of the integral part, the fastest of [`AxisParameters`]. It is held: a slower one is hardly stiffer within
/// the band, but leaves a static load displaced for seconds.
const INTEGRAL_RAD_S: f64 = TAU * 5.0;
/// Numbers of the search: those of [`AxisParameters`] without the integral part and the second biquad.
const FREE: usize = 8;

/// The loop of a thrust axis at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrustLine {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Force over displacement of the shaft, N/m.
    pub stiffness_n_per_m: f64,
    /// |S|.
    pub sensitivity: f64,
}

/// A tuned PID of a thrust axis with the figures of its loop.
#[derive(Clone, Debug)]
pub struct ThrustPid {
    /// Its numbers; the second biquad is one and not realised.
    pub parameters: AxisParameters,
    /// One signal to one current, u = K y, as it runs.
    pub controller: Controller,
    /// Largest growth rate of the sampled loop in double precision, 1/s; negative when stable.
    pub growth_rate_per_s: f64,
    /// Smallest dynamic stiffness within the stiffness band: N/m, and its frequency, Hz.
    pub minimum: (f64, f64),
    /// Peak of |S| on the lines, which go to 0.98 of Nyquist.
    pub sensitivity_peak: f64,
    /// Current from sensor noise, rms A.
    pub noise_current_a: f64,
    /// Stiffness and sensitivity over frequency.
    pub lines: Vec<ThrustLine>,
}

/// Tunes the PID of a thrust axis whose stiffness counts within a band, Hz.
///
/// # Errors
/// [`ControllerError::Infeasible`] where no start leads to a stable loop, and failures of plant and eigenvalues.
pub fn tune_thrust(axis: &ThrustAxis, band_hz: (f64, f64)) -> Result<ThrustPid, VerificationError> {
    let mut search = ThrustSearch::new(axis, band_hz)?;
    let mut best: Option<(f64, Vec<f64>)> = None;
    for ratio in START_STIFFNESS {
        let mut at = search.start(ratio);
        for descent in 0..DESCENTS {
            let side = FIRST_SIDE / (1 << descent) as f64;
            let vertices = (0..=FREE).map(|k| {
                let mut vertex = at.clone();
                vertex.iter_mut().take(k).skip(k.saturating_sub(1)).for_each(|v| *v += side);
                vertex
            });
            let Some(end) = descend_simplex(vertices.collect(), STEPS, |x| search.loss(x)) else { break };
            at = end.point;
        }
        let value = search.loss(&at);
        if best.as_ref().is_none_or(|(least, _)| value < *least) {
            best = Some((value, at));
        }
    }
    let no_numbers = || infeasible("no start has gains that are numbers".to_owned());
    let (_, mut at) = best.ok_or_else(no_numbers)?;
    for _ in 0..ROUNDS {
        let found = search.parameters(&at).ok_or_else(no_numbers)?;
        search.lines = search.lines_round_poles(&found, SEARCH_LINES)?.1;
        at = search.step_randomly(at);
    }
    let found = search.parameters(&at).ok_or_else(no_numbers)?;
    search.judge(found)
}

/// The plant at one frequency.
struct PlantLine {
    omega_rad_s: f64,
    /// jω as Tustin's rule sees it.
    s: c64,
    /// Signal and displacement of the shaft per current, with hold and delay.
    per_current: [c64; 2],
    /// The same per load, m/N.
    per_load: [c64; 2],
}

/// A search for one axis.
struct ThrustSearch<'a> {
    axis: &'a ThrustAxis,
    continuous: StateSpace<Continuous>,
    sampled: StateSpace<Discrete>,
    lines: Vec<PlantLine>,
    band_hz: (f64, f64),
    nyquist_rad_s: f64,
}

impl<'a> ThrustSearch<'a> {
    fn new(axis: &'a ThrustAxis, band_hz: (f64, f64)) -> Result<Self, VerificationError> {
        let build = || Ok((axis.plant_without_delay()?, axis.sample_plant()?));
        let (continuous, sampled) = build().map_err(in_step("plant of the thrust axis"))?;
        let nyquist_rad_s = PI * axis.electronics.sample_rate_hz;
        let mut search = Self { axis, continuous, sampled, lines: vec![], band_hz, nyquist_rad_s };
        search.lines = search.plant_lines(search.grid(SEARCH_LINES).omega_rad_s());
        Ok(search)
    }

    /// Steps along about half of the axes at a time, kept where the loss falls: a simplex comes to rest where two
    /// limits meet, which these pass (the (1+1) evolution strategy of Rechenberg, 1973).
    fn step_randomly(&self, mut at: Vec<f64>) -> Vec<f64> {
        let mut least = self.loss(&at);
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let mut length = FIRST_STEP;
        for _ in 0..RANDOM_STEPS {
            let mut step = || if random.random::<bool>() { length * random.random_range(-1.7..1.7) } else { 0.0 };
            let next: Vec<f64> = at.iter().map(|x| x + step()).collect();
            let loss = self.loss(&next);
            if loss < least {
                (least, at) = (loss, next);
                length *= LONGER;
            } else {
                length *= SHORTER;
            }
            if length < LEAST_STEP {
                length = FIRST_STEP;
            }
        }
        at
    }

    fn grid(&self, lines: usize) -> FrequencyGrid {
        FrequencyGrid::log_hz(self.band_hz.0.min(1.0), 0.98 * self.nyquist_rad_s / TAU, lines)
    }

    fn plant_lines(&self, omega_rad_s: &[f64]) -> Vec<PlantLine> {
        let period_s = self.axis.electronics.sample_period_s();
        let at = |omega: &f64| {
            let p = self.continuous.at(*omega);
            let hold = c64::new(0.0, -omega * self.axis.delay_s()).exp() * hold_magnitude(*omega, period_s);
            PlantLine {
                omega_rad_s: *omega,
                s: c64::new(0.0, 2.0 / period_s * (0.5 * omega * period_s).tan()),
                per_current: [0, 1].map(|row| hold * p[(row, 0)]),
                per_load: [0, 1].map(|row| p[(row, 1)]),
            }
        };
        omega_rad_s.iter().map(at).collect()
    }

    /// Gains of a rigid mass whose restoring stiffness is `ratio` times the negative one, in the order of the search.
    fn start(&self, ratio: f64) -> Vec<f64> {
        let (bearing, mass_kg) = (&self.axis.bearing, self.axis.mass_kg);
        let negative = bearing.ks_n_per_m.max(mass_kg * (LEAST_UNSTABLE_POLE * self.nyquist_rad_s).powi(2));
        let restoring = ratio * negative;
        let gain = (restoring + bearing.ks_n_per_m) / bearing.ki_n_per_a;
        let derivative_s = 2.0 * START_DAMPING * (restoring * mass_kg).sqrt() / (bearing.ki_n_per_a * gain);
        let corner = 0.4 * self.nyquist_rad_s;
        // The biquad begins as one: at the mode of the disc, where there is one below Nyquist.
        let mode = bearing.disc_mode_hz.map(|hz| TAU * hz).filter(|w| *w < 0.7 * self.nyquist_rad_s);
        let section = mode.unwrap_or(0.2 * self.nyquist_rad_s);
        [gain, derivative_s, corner, corner, section, 0.5, section, 0.5].map(f64::ln).to_vec()
    }

    fn parameters(&self, x: &[f64]) -> Option<AxisParameters> {
        let (gain, others) = x.split_first()?;
        let all = [&[*gain, INTEGRAL_RAD_S.ln()], others, &self.none().map(f64::ln)].concat();
        AxisParameters::from_log(&all, self.nyquist_rad_s)
    }

    /// A biquad that is one.
    fn none(&self) -> [f64; 4] {
        let frequency = 0.2 * self.nyquist_rad_s;
        [frequency, 0.5, frequency, 0.5]
    }

    /// −C(z) of the parameters.
    fn law(&self, parameters: &AxisParameters) -> Result<StateSpace<Discrete>, ControllerError> {
        let own: &[Biquad] = &parameters.biquads[..1];
        let negative = Mat::from_fn(1, 1, |_, _| -1.0);
        let system = parameters.system_with(own)?.scale_outputs(&negative);
        tustin(&system, self.axis.electronics.sample_period_s()).map_err(in_step("PID of the thrust axis"))
    }

    /// The sampled loop.
    fn close_loop(&self, law: &StateSpace<Discrete>) -> Result<StateSpace<Discrete>, ControllerError> {
        lower_lft(&self.sampled, law).map_err(in_step("loop of the thrust axis"))
    }

    /// Negative logarithm of the smallest stiffness plus the penalties of exceeded limits. An unstable loop has a
    /// larger loss than any stable one; it rises with the growth rate.
    fn loss(&self, x: &[f64]) -> f64 {
        let Some(parameters) = self.parameters(x) else { return f64::INFINITY };
        let growth = self.law(&parameters).and_then(|law| {
            let closed = self.close_loop(&law)?;
            closed.growth_rate().map_err(in_step("poles of the thrust axis"))
        });
        let Ok(growth_rate_per_s) = growth else { return f64::INFINITY };
        if growth_rate_per_s >= 0.0 {
            // The loss of a stable loop, a logarithm, stays far below.
            return 1e6 + growth_rate_per_s;
        }
        let figures = self.figures(&parameters, &self.lines);
        let excess = |value: f64, limit: f64| EXCESS_WEIGHT * (value / limit).ln().max(0.0);
        let peak = excess(figures.sensitivity_peak, AIM * ZONE_A);
        let noise = excess(figures.noise_current_a, TuneSettings::quick().noise_current_a);
        peak + noise - figures.minimum.0.ln()
    }

    /// Figures of the loop of the continuous plant with the hold and the exact delay, on some lines.
    fn figures(&self, parameters: &AxisParameters, lines: &[PlantLine]) -> Figures {
        let (mut minimum, mut sensitivity_peak, mut power) = ((f64::INFINITY, f64::NAN), 0.0f64, 0.0);
        let mut before: Option<(f64, f64)> = None;
        let mut drawn = Vec::with_capacity(lines.len());
        for line in lines {
            let k = -parameters.response(line.s);
            let sensitivity = (c64::new(1.0, 0.0) - line.per_current[0] * k).inv();
            let compliance = line.per_load[1] + line.per_current[1] * k * sensitivity * line.per_load[0];
            let frequency_hz = line.omega_rad_s / TAU;
            let stiffness_n_per_m = compliance.norm().recip();
            if (self.band_hz.0..=self.band_hz.1).contains(&frequency_hz) && stiffness_n_per_m < minimum.0 {
                minimum = (stiffness_n_per_m, frequency_hz);
            }
            sensitivity_peak = sensitivity_peak.max(sensitivity.norm());
            let density = (k * sensitivity).norm_sqr();
            if let Some((hz, earlier)) = before {
                power += 0.5 * (earlier + density) * (frequency_hz - hz);
            }
            before = Some((frequency_hz, density));
            drawn.push(ThrustLine { frequency_hz, stiffness_n_per_m, sensitivity: sensitivity.norm() });
        }
        // The noise of a sensor is white up to Nyquist.
        let share = power / (self.nyquist_rad_s / TAU);
        Figures {
            minimum,
            sensitivity_peak,
            noise_current_a: self.axis.electronics.sensor_noise_m * share.sqrt(),
            drawn,
        }
    }

    /// Growth rate of the sampled loop, 1/s, and so many lines with others round its poles.
    fn lines_round_poles(
        &self,
        parameters: &AxisParameters,
        lines: usize,
    ) -> Result<(f64, Vec<PlantLine>), ControllerError> {
        let closed = self.close_loop(&self.law(parameters)?)?;
        let poles = closed.poles().map_err(in_step("poles of the thrust axis"))?;
        let growth_rate_per_s = closed.time.largest_growth_rate(&poles);
        let grid = self.grid(lines).refine_round_poles(&closed.time.continuous_poles(poles), LINES_A_SIDE);
        Ok((growth_rate_per_s, self.plant_lines(grid.omega_rad_s())))
    }

    /// The PID with the figures of its loop on lines round its poles.
    fn judge(&self, parameters: AxisParameters) -> Result<ThrustPid, VerificationError> {
        let law = self.law(&parameters)?;
        let (growth_rate_per_s, lines) = self.lines_round_poles(&parameters, FIGURE_LINES)?;
        if growth_rate_per_s.is_nan() || growth_rate_per_s >= 0.0 {
            let words = growth_words(growth_rate_per_s, 0.0);
            return Err(infeasible(format!(
                "of {} starts the best leads to a loop that {words}",
                START_STIFFNESS.len()
            ))
            .into());
        }
        let figures = self.figures(&parameters, &lines);
        Ok(ThrustPid {
            parameters,
            controller: Controller { name: "thrust PID".to_owned(), law: ControlLaw::Discrete(law) },
            growth_rate_per_s,
            minimum: figures.minimum,
            sensitivity_peak: figures.sensitivity_peak,
            noise_current_a: figures.noise_current_a,
            lines: figures.drawn,
        })
    }
}

fn infeasible(reason: String) -> ControllerError {
    let advice = "check mass, k_i, k_s and delay of the thrust axis";
    ControllerError::Infeasible { step: "PID of the thrust axis", reason, advice }
}

struct Figures {
    minimum: (f64, f64),
    sensitivity_peak: f64,
    noise_current_a: f64,
    drawn: Vec<ThrustLine>,
}
