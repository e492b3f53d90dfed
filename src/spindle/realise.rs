//! The plant as a state space: continuous with Padé delays, or sampled with the hold and the exact delay.
//!
//! States: delays, amplifiers, eddy-current filters, shaft of the x plane (s·η, η̇), shaft of the y plane, sensors. A
//! matrix A + jB that acts on r = x + jy is [[A, −B], [B, A]] on (x, y). Two things have no finite state space and are
//! stated: the delay in continuous time (Padé of the order asked), and eddy currents: 1/(1+√(s/ω_e)) is replaced by
//! real poles half a decade apart from 1 Hz to 100 kHz, fitted to its Stieltjes density √x/(π(1+x)); error below 1 %
//! there.

use super::SpindleError;
use super::correction::LawSite;
use super::effective::{Amplifier, AxisElectronics, FeedbackLaw};
use super::plant::{AXES, CHANNELS, Plant};
use super::response::electronics::LOWPASS_DAMPING;
use super::response::feedback::Feedback;
use crate::linalg::equal_planes::EqualPlanes;
use crate::linalg::{Mat, NumericError, c64};
use crate::lti::connect::{add, append, check_sample_times, lower_lft, series};
use crate::lti::delay::{pade_delay, sample_planes};
use crate::lti::structure::planes_apart;
use crate::lti::{Continuous, Discrete, StateSpace};
use crate::rotor::modes::RIGID;
use std::f64::consts::{PI, TAU};

/// Force inputs and displacement outputs besides the four axes.
const LOADS: usize = CHANNELS - AXES;

impl Plant {
    /// Continuous state space, 10×10, with Padé approximants of `pade_order` for the delay (0: without delay).
    ///
    /// # Errors
    /// [`SpindleError::Numeric`] when the connection fails.
    pub fn state_space(&self, pade_order: usize) -> Result<StateSpace<Continuous>, SpindleError> {
        self.state_space_with_modal_ports(pade_order, 0)
    }

    /// As [`Plant::state_space`], with the ports of modal uncertainty behind the ten channels: for each of the first
    /// `modes` flexible modes an input w (x, then y) that adds to q̈ and the modal coordinate q (x, then y) as output.
    ///
    /// # Errors
    /// As [`Plant::state_space`].
    pub fn state_space_with_modal_ports(
        &self,
        pade_order: usize,
        modes: usize,
    ) -> Result<StateSpace<Continuous>, SpindleError> {
        let delay = if pade_order == 0 || self.delay_s() <= 0.0 {
            StateSpace::gain(Mat::identity(AXES, AXES), Continuous)
        } else {
            let one = pade_delay(self.delay_s(), pade_order)?;
            append(&append(&one, &one), &append(&one, &one))
        };
        let undelayed = self.realise_undelayed(modes)?;
        let others = undelayed.inputs() - AXES;
        let pass = StateSpace::gain(Mat::identity(others, others), Continuous);
        Ok(series(&append(&delay, &pass), &undelayed)?)
    }

    /// Sampled state space, 10×10: zero-order hold on every input, currents later by delay_s − Tₛ/2, outputs at the
    /// sample instants. Exact between the samples; a delay below half a sample counts as half a sample.
    ///
    /// # Errors
    /// [`SpindleError::Numeric`] when the exponential overflows.
    pub fn sample_plant(&self) -> Result<StateSpace<Discrete>, SpindleError> {
        self.sampled_with_modal_ports(0)
    }

    /// As [`Plant::sample_plant`] with the modal ports of [`Plant::state_space_with_modal_ports`].
    pub(crate) fn sampled_with_modal_ports(&self, modes: usize) -> Result<StateSpace<Discrete>, SpindleError> {
        let period = self.sample_period_s;
        let pure = (self.delay_s() - 0.5 * period).max(0.0);
        let undelayed = self.realise_undelayed(modes)?;
        // Inputs come in pairs (x, y).
        let inputs: Vec<bool> = (0..undelayed.inputs()).map(|k| k % 2 == 1).collect();
        let states = self.planes_of_states(undelayed.order())?;
        let planes = states.zip(EqualPlanes::of(&inputs));
        let planes = planes.map(|(states, inputs)| states.followed_by(&inputs));
        let delays = (pure, period);
        Ok(sample_planes(&undelayed, AXES, delays.0, delays.1, planes.as_ref())?)
    }

    /// The planes of the states of [`Plant::sample_plant`], of which there are `order`, the last of them late commands,
    /// or of [`Plant::state_space`] without delay; none when the states are others.
    pub(crate) fn planes_of_states(&self, order: usize) -> Result<Option<EqualPlanes>, NumericError> {
        if self.effective.has_pickup() {
            return Ok(None);
        }
        let plane = 2 * self.mechanics.omega_rad_s().len();
        let mut sizes = vec![];
        for x in [0, 2] {
            sizes.push([self.actuator_axis(x)?.order(), self.actuator_axis(x + 1)?.order()]);
        }
        sizes.push([plane; 2]);
        sizes.extend(self.mechanics.shaft_laws().iter().map(|law| [law.law.order(); 2]));
        for x in [0, 2] {
            sizes.push([self.sensor_axis(x)?.order(), self.sensor_axis(x + 1)?.order()]);
        }
        let undelayed = sizes.as_flattened().iter().sum::<usize>();
        sizes.extend(vec![[1; 2]; order.saturating_sub(undelayed) / 2]);
        let in_y: Vec<bool> = sizes.iter().flat_map(|[x, y]| [vec![false; *x], vec![true; *y]].concat()).collect();
        Ok(EqualPlanes::of(&in_y).filter(|_| in_y.len() == order))
    }

    /// The planes of the states of the loop of [`Plant::sample_plant`], which has `order` states, with a law; none
    /// where they are not known or the law joins the planes.
    pub(crate) fn planes_of_loop(
        &self,
        order: usize,
        law: &StateSpace<Discrete>,
    ) -> Result<Option<EqualPlanes>, NumericError> {
        let planes = self.planes_of_states(order)?.zip(planes_apart(law));
        Ok(planes.map(|(own, of_law)| own.followed_by(&of_law)))
    }

    /// Poles of the sampled loop of this plant with u = K y; `sampled` is [`Plant::sample_plant`].
    pub(crate) fn loop_poles(
        &self,
        sampled: &StateSpace<Discrete>,
        law: &StateSpace<Discrete>,
    ) -> Result<Vec<c64>, NumericError> {
        let axes: Vec<usize> = (0..AXES).collect();
        check_sample_times(sampled, law)?;
        let closed = lower_lft(&sampled.select(&axes, &axes), law)?;
        let planes = self.planes_of_loop(sampled.order(), law)?;
        EqualPlanes::eigenvalues_on(planes.as_ref(), &closed.a)
    }

    /// The plant without its delay.
    fn realise_undelayed(&self, modes: usize) -> Result<StateSpace<Continuous>, SpindleError> {
        let before = append(&self.actuator_chain(0)?, &self.actuator_chain(1)?);
        let crosstalk = &self.effective.crosstalk;
        let mix = Mat::from_fn(4, 4, |i, j| f64::from(u8::from(i == j)) + crosstalk[i][j]);
        let after = append(&self.sensor_chain(0)?, &self.sensor_chain(1)?).scale_outputs(&mix);
        let shaft = self.shaft(modes)?;
        let pass = |n: usize| StateSpace::gain(Mat::identity(n, n), Continuous);
        let ports = 2 * modes.min(self.mechanics.flexible());
        let first = series(&append(&before, &pass(LOADS + ports)), &shaft)?;
        let all = series(&first, &append(&after, &pass(LOADS + ports)))?;
        if self.effective.has_pickup() {
            let none = StateSpace::gain(Mat::zeros(LOADS + ports, LOADS + ports), Continuous);
            return Ok(add(&all, &append(&self.pickup_chain()?, &none))?);
        }
        Ok(all)
    }

    /// Displacements (x, y) to signals (x, y) of one bearing.
    fn sensor_chain(&self, bearing: usize) -> Result<StateSpace<Continuous>, NumericError> {
        let own = &self.effective.bearings[bearing];
        let axes = own.axes_matrix();
        let gain = Mat::from_fn(2, 2, |i, j| own.sensor_gain * axes[i][j]);
        let x = 2 * bearing;
        Ok(append(&self.sensor_axis(x)?, &self.sensor_axis(x + 1)?).scale_inputs(&gain))
    }

    /// The lag of the sensor of one axis.
    fn sensor_axis(&self, axis: usize) -> Result<StateSpace<Continuous>, NumericError> {
        let mut chain = first_order(self.effective.sensor_bandwidth_hz)?;
        if let Some(hz) = self.effective.bearings[axis / 2].axes[axis % 2].sensor_lowpass_hz {
            chain = series(&chain, &second_order(hz, LOWPASS_DAMPING)?)?;
        }
        self.behind_laws(chain, LawSite::Signal(axis))
    }

    /// A chain with the factors 1 + X of the laws at a site behind it.
    fn behind_laws(
        &self,
        chain: StateSpace<Continuous>,
        site: LawSite,
    ) -> Result<StateSpace<Continuous>, NumericError> {
        let here = self.effective.laws.iter().filter(|own| own.site == site);
        here.map(|own| own.law.state_space()).try_fold(chain, |chain, law| {
            let mut factor = law?;
            factor.d[(0, 0)] += 1.0;
            series(&chain, &factor)
        })
    }

    /// Command to coil current of one axis, with its delay beyond that of the others.
    fn coil_current(&self, axis: &AxisElectronics) -> Result<StateSpace<Continuous>, NumericError> {
        let amplifier = match axis.amplifier {
            Amplifier::FirstOrder { bandwidth_hz } => first_order(bandwidth_hz)?,
            Amplifier::SecondOrder { frequency_hz, damping_ratio } => second_order(frequency_hz, damping_ratio)?,
        };
        let delay_s = self.effective.delay_s + axis.further_delay_s - self.effective.common_delay_s();
        if delay_s > 0.0 { series(&pade_delay(delay_s, FURTHER_DELAY_ORDER)?, &amplifier) } else { Ok(amplifier) }
    }

    /// Command to the current that makes force, of one axis.
    fn actuator_axis(&self, axis: usize) -> Result<StateSpace<Continuous>, NumericError> {
        let own = &self.effective.bearings[axis / 2].axes[axis % 2];
        let mut chain = self.coil_current(own)?;
        if let Some(corner) = own.eddy_corner_hz {
            chain = series(&chain, &half_order_lag(corner)?)?;
        }
        if let Some(corner) = own.lamination_corner_hz {
            chain = series(&chain, &sheet_lag(corner)?)?;
        }
        self.behind_laws(chain, LawSite::Current(axis))
    }

    /// Currents (x, y) to forces (x, y) of one bearing.
    fn actuator_chain(&self, bearing: usize) -> Result<StateSpace<Continuous>, NumericError> {
        let force = self.effective.bearings[bearing].force_matrix();
        let x = 2 * bearing;
        let both = append(&self.actuator_axis(x)?, &self.actuator_axis(x + 1)?);
        Ok(both.scale_outputs(&Mat::from_fn(2, 2, |i, j| force[i][j])))
    }

    /// Commands to what the signals pick up of the rates of the coil currents, 4×4.
    fn pickup_chain(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let mut rates = StateSpace::gain(Mat::zeros(0, 0), Continuous);
        for axis in self.effective.bearings.iter().flat_map(|b| b.axes) {
            let current = self.coil_current(&axis)?;
            // i̇ = C A x + C B u: a coil current does not follow its command at once.
            let rate = StateSpace::new(
                current.a.clone(),
                current.b.clone(),
                &current.c * &current.a,
                &current.c * &current.b,
                Continuous,
            )?;
            rates = append(&rates, &rate);
        }
        let shares = &self.effective.current_pickup;
        Ok(rates.scale_outputs(&Mat::from_fn(AXES, AXES, |i, j| shares[i][j])))
    }

    /// Forces (two controls, tool, two actuators; modal ports) to displacements (two sensors, tool, two actuators; q).
    /// Laws in one plane have ports behind these until they are closed at the end.
    fn shaft(&self, modes: usize) -> Result<StateSpace<Continuous>, SpindleError> {
        let closed = self.mechanics.close_loop();
        let omega = self.mechanics.omega_rad_s();
        let (n, m) = (omega.len(), modes.min(self.mechanics.flexible()));
        let (laws, filters) = (self.mechanics.plane_laws(), self.mechanics.shaft_laws());
        let (size, channels) = (2 * n, 5 + m + laws.len() + filters.len());
        // Port of a channel: named ones, then those of laws in one plane and with poles; modal ones have none.
        let port = |channel: usize| match channel {
            named @ 0..5 => Some(named),
            modal if modal < 5 + m => None,
            law => Some(law - m),
        };
        let modal = |channel: usize| RIGID + channel - 5;
        // Displacement states scaled to velocity size; 100 rad/s for the rigid modes is of the order of the magnets'
        // poles.
        let scale: Vec<f64> = omega.iter().map(|w| w.max(100.0)).collect();
        let zero = c64::new(0.0, 0.0);
        let a = Mat::from_fn(size, size, |i, j| match (i < n, j < n) {
            (true, true) => zero,
            (true, false) => c64::new(if i + n == j { scale[i] } else { 0.0 }, 0.0),
            (false, true) => -closed.k[(i - n, j)] / scale[j],
            (false, false) => -closed.c[(i - n, j - n)],
        });
        let b = Mat::from_fn(size, channels, |i, j| match (i < n, port(j)) {
            (true, _) => zero,
            (false, Some(p)) => closed.b[(i - n, p)],
            (false, None) => c64::new(f64::from(u8::from(i - n == modal(j))), 0.0),
        });
        let damps = |channel: usize| {
            let law = channel.checked_sub(5 + m).and_then(|k| laws.get(k));
            law.is_some_and(|l| l.law == FeedbackLaw::Dashpot)
        };
        let c = Mat::from_fn(channels, size, |i, j| match (j < n, port(i)) {
            (velocity, Some(p)) if damps(i) => {
                if velocity {
                    zero
                } else {
                    closed.c_out[(p, j - n)]
                }
            }
            (false, _) => zero,
            (true, Some(p)) => closed.c_out[(p, j)] / scale[j],
            (true, None) => c64::new(f64::from(u8::from(j == modal(i))) / scale[j], 0.0),
        });
        let d = Mat::from_fn(channels, channels, |i, j| match (port(i), port(j)) {
            (Some(p), Some(q)) if !damps(i) => closed.d[(p, q)],
            _ => zero,
        });
        // States by plane, channels in pairs (x, y).
        let by_plane = |k: usize, count: usize| (k / count, k % count);
        let by_pair = |k: usize, _: usize| (k % 2, k / 2);
        type Split = fn(usize, usize) -> (usize, usize);
        let both = |m: &Mat<c64>, row: Split, column: Split| {
            let (rows, columns) = (m.nrows(), m.ncols());
            Mat::from_fn(2 * rows, 2 * columns, |i, j| {
                let ((p, r), (q, s)) = (row(i, rows), column(j, columns));
                match (p, q) {
                    (0, 1) => -m[(r, s)].im,
                    (1, 0) => m[(r, s)].im,
                    _ => m[(r, s)].re,
                }
            })
        };
        let open = StateSpace::new(
            both(&a, by_plane, by_plane),
            both(&b, by_plane, by_pair),
            both(&c, by_pair, by_plane),
            both(&d, by_pair, by_pair),
            Continuous,
        )?;
        if laws.is_empty() && filters.is_empty() {
            return Ok(open);
        }
        let loops: Vec<Feedback> = (5 + m..).zip(laws).map(|(k, s)| s.beside(k)).collect();
        let filtered = 2 * (5 + m + laws.len())..2 * channels;
        let kept = (0..2 * (5 + m)).chain(loops.iter().map(|f| f.port)).chain(filtered);
        let kept: Vec<usize> = kept.collect();
        let law = Mat::from_fn(loops.len(), loops.len(), |i, j| if i == j { -loops[i].value } else { 0.0 });
        let mut law = StateSpace::gain(law, Continuous);
        for filter in filters {
            let force = filter.law.state_space()?.scale_outputs(&Mat::from_fn(1, 1, |_, _| -1.0));
            law = append(&law, &append(&force, &force));
        }
        Ok(lower_lft(&open.select(&kept, &kept), &law)?)
    }
}

/// 1/(1 + s/ω).
pub(super) fn first_order(bandwidth_hz: f64) -> Result<StateSpace<Continuous>, NumericError> {
    let w = TAU * bandwidth_hz;
    let m = |x: f64| Mat::from_fn(1, 1, |_, _| x);
    StateSpace::new(m(-w), m(w), m(1.0), m(0.0), Continuous)
}

/// ω²/(s² + 2ζωs + ω²).
fn second_order(frequency_hz: f64, damping_ratio: f64) -> Result<StateSpace<Continuous>, NumericError> {
    let w = TAU * frequency_hz;
    StateSpace::new(
        Mat::from_fn(2, 2, |i, j| match (i, j) {
            (0, 0) => 0.0,
            (0, _) => w,
            (_, 0) => -w,
            _ => -2.0 * damping_ratio * w,
        }),
        Mat::from_fn(2, 1, |i, _| if i == 1 { w } else { 0.0 }),
        Mat::from_fn(1, 2, |_, j| if j == 0 { 1.0 } else { 0.0 }),
        Mat::zeros(1, 1),
        Continuous,
    )
}

/// Order of the Padé approximant of what an axis is later than the others: a few samples at most.
const FURTHER_DELAY_ORDER: usize = 4;

/// Lowest and highest pole of the rational half-order lag, Hz, and poles per decade.
const HALF_ORDER_BAND_HZ: (f64, f64) = (0.1, 1e6);
const HALF_ORDER_PER_DECADE: f64 = 2.0;

/// 1/(1 + √(s/ω_e)) = (1/π) ∫ √x/(1+x) · dx/(x + s/ω_e), by the trapezoidal rule in ln x; the tail beyond the highest
/// pole becomes a gain, what is missing below the lowest one is added there, so that the DC gain is 1.
pub(super) fn half_order_lag(corner_hz: f64) -> Result<StateSpace<Continuous>, NumericError> {
    let (low, high) = HALF_ORDER_BAND_HZ;
    let step = std::f64::consts::LN_10 / HALF_ORDER_PER_DECADE;
    let count = ((high / low).log10() * HALF_ORDER_PER_DECADE).round() as usize + 1;
    let x = |k: usize| low / corner_hz * (step * k as f64).exp();
    // Weight of 1/(x + s): (1/π) √x/(1+x) · x · step.
    let weight = |x: f64| step / PI * x * x.sqrt() / (1.0 + x);
    // ∫ beyond the last panel of (1/π) √x/(1+x)/x dx = (2/π) atan(1/√x) at its upper edge.
    let edge = x(count - 1) * (0.5 * step).exp();
    let tail = 2.0 / PI * edge.sqrt().recip().atan();
    let inside: f64 = (0..count).map(|k| weight(x(k)) / x(k)).sum();
    let missing = 1.0 - tail - inside;
    let rate = TAU * corner_hz;
    let gain = |k: usize| {
        let extra = if k == 0 { missing * x(0) } else { 0.0 };
        weight(x(k)) + extra
    };
    StateSpace::new(
        Mat::from_fn(count, count, |i, j| if i == j { -rate * x(i) } else { 0.0 }),
        Mat::from_fn(count, 1, |i, _| rate * x(i)),
        Mat::from_fn(1, count, |_, j| gain(j) / x(j)),
        Mat::from_fn(1, 1, |_, _| tail),
        Continuous,
    )
}

/// First-order lags of the partial fractions of laminated iron: the last stands at 1300 times the corner.
const SHEET_LAGS: usize = 12;

/// tanh(√q)/√q = Σ 2/(q + p_k) with p_k = ((k − ½)π)², q = s/ω_l. The lags beyond the last are one that has their sum
/// and their slope at rest, where the whole has 1 and −1/3.
fn sheet_lag(corner_hz: f64) -> Result<StateSpace<Continuous>, NumericError> {
    let mut lags: Vec<(f64, f64)> = (1..=SHEET_LAGS)
        .map(|k| {
            let pole = ((k as f64 - 0.5) * PI).powi(2);
            (2.0 / pole, pole)
        })
        .collect();
    let rest = 1.0 - lags.iter().map(|(gain, _)| gain).sum::<f64>();
    let slope = 1.0 / 3.0 - lags.iter().map(|(gain, pole)| gain / pole).sum::<f64>();
    lags.push((rest, rest / slope));
    let (n, rate) = (lags.len(), TAU * corner_hz);
    StateSpace::new(
        Mat::from_fn(n, n, |i, j| if i == j { -rate * lags[i].1 } else { 0.0 }),
        Mat::from_fn(n, 1, |i, _| rate * lags[i].1),
        Mat::from_fn(1, n, |_, j| lags[j].0),
        Mat::zeros(1, 1),
        Continuous,
    )
}
