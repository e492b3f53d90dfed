//! Plane + weights + modal uncertainty → generalized plant of one plane.
//!
//! w = (modal channels, loads through W_d at tool/front/rear, sensor noise front/rear, all normalised to one); z =
//! (modal channels, displacements through W_p at tool/front/rear, currents through W_u, optional T channel, optional
//! integral channel). Optional channels: T, the clean signals over (limit · noise), so that ‖T‖ ≤ limit where it
//! reaches one; integral action, the measured signals y + n through W_i(s) = (1/x_dc)·ω_c/(s + ω_c/1000): what a load
//! moves the shaft at the sensors falls below the corner ω_c as with an integrator, to a thousandth of the displacement
//! allowed at DC. The signals are weighted and not the tool, because two bearings cannot hold the tool against loads at
//! three places; noise is included, because S n falls too. Natural-frequency uncertainty r: z = √(2r) ω₀ q, q̈ = … −
//! √(2r) ω₀ δ z, |δ| ≤ 1 (linearised in r: r² ≤ 0.2 % at 4 %). The weights are written over true frequency;
//! [`WeightPlane`] says how they enter the plane of the plant. Further uncertainty, if there is any, comes after the
//! modal channels ([`super::channels`]). Measurements and commands are scaled to order one: y/σ_y with σ_y =
//! 1e-5 m, u in A.

use super::channels::{Channel, ChannelKind, ChannelWeight, Wiring, problem_blocks};
use super::generalized::GeneralizedPlant;
use super::plane::{LOADS, LOOPS};
use super::weight_plane::WeightPlane;
use super::weight_shapes::WeightShapes;
use super::weights::Weights;
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::{append, block2, series, stack_rows};
use crate::lti::{Continuous, StateSpace};

/// Displacement that counts as one at the controller input of the scaled problem, m: the size of the vibrations.
pub(crate) const SIGNAL_SCALE_M: f64 = 1e-5;

/// A mode with a port in the plane model and its relative natural-frequency uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainMode {
    /// Number of the flexible mode, from 0.
    pub number: usize,
    /// Natural frequency ω₀, rad/s.
    pub omega_rad_s: f64,
    /// Relative uncertainty r.
    pub relative: f64,
}

/// Generalized plant of one plane; `plane` has the ports of [`super::plane`] with one
/// modal port per entry of `modes`.
///
/// # Errors
/// [`NumericError`] when a weight is not positive or channel counts do not fit.
pub fn generalized_plane(
    plane: &StateSpace<Continuous>,
    modes: &[UncertainMode],
    weights: &Weights,
    weight_plane: WeightPlane,
) -> Result<GeneralizedPlant, NumericError> {
    let round = ProblemWeights::new(modes, weights, weight_plane)?;
    let nv = modes.len() + round.channels.len();
    let with_errors = expose_errors(plane, modes.len(), &round.channels, weights)?;
    let weighted = series(&series(&round.input, &with_errors)?, &round.output)?;
    let performance = (LOADS + LOOPS, weighted.outputs() - LOOPS - nv);
    let blocks = problem_blocks(modes.len(), &round.channels, performance.0, performance.1);
    Ok(GeneralizedPlant { system: weighted, controls: LOOPS, measurements: LOOPS, blocks })
}

/// Controller of the scaled problem back in physical units: u (A) from y (m).
pub fn unscale_controller<T: crate::lti::TimeBase>(scaled: &StateSpace<T>) -> StateSpace<T> {
    let y = Mat::from_fn(scaled.inputs(), scaled.inputs(), |i, j| if i == j { 1.0 / SIGNAL_SCALE_M } else { 0.0 });
    scaled.scale_inputs(&y)
}

/// Controller in physical units as the scaled problem sees it.
pub fn scale_controller<T: crate::lti::TimeBase>(physical: &StateSpace<T>) -> StateSpace<T> {
    let y = Mat::from_fn(physical.inputs(), physical.inputs(), |i, j| if i == j { SIGNAL_SCALE_M } else { 0.0 });
    physical.scale_inputs(&y)
}

/// The weights round a plane, and its channels of further uncertainty.
#[derive(Clone, Debug)]
pub(crate) struct ProblemWeights {
    /// Channels, in the order of the problem.
    pub channels: Vec<Channel>,
    /// Weights at the inputs, (w, u) → (modal ports, channels, loads N, noise m, u).
    pub input: StateSpace<Continuous>,
    /// Weights at the outputs, (q, channels, x, u, [clean y for T], [noisy y for integral action], noisy y) → (z, y).
    pub output: StateSpace<Continuous>,
}

impl ProblemWeights {
    /// Of a problem in a plane of frequency.
    pub(crate) fn new(modes: &[UncertainMode], weights: &Weights, plane: WeightPlane) -> Result<Self, NumericError> {
        let shapes = WeightShapes::of(weights)?;
        Ok(Self {
            input: input_weights(modes, weights, &shapes, plane)?,
            output: output_weights(modes, weights, &shapes, plane)?,
            channels: shapes.channels,
        })
    }

    /// Of the specification over true frequency, without the bound on T: that is a means of the design.
    pub(crate) fn of_specification(modes: &[UncertainMode], weights: &Weights) -> Result<Self, NumericError> {
        let weights = Weights { complementary_sensitivity_limit: None, ..weights.clone() };
        Self::new(modes, &weights, WeightPlane::Laplace)
    }
}

fn input_weights(
    modes: &[UncertainMode],
    weights: &Weights,
    shapes: &WeightShapes,
    plane: WeightPlane,
) -> Result<StateSpace<Continuous>, NumericError> {
    let mut all = StateSpace::gain(Mat::zeros(0, 0), Continuous);
    for mode in modes {
        let gain = StateSpace::gain(Mat::from_fn(1, 1, |_, _| modal_gain(mode)), Continuous);
        all = append(&all, &plane.unheld(&gain, Some(mode.omega_rad_s))?);
    }
    for channel in &shapes.channels {
        let gain = StateSpace::gain(Mat::from_fn(1, 1, |_, _| channel.input), Continuous);
        // A force acts between the samples; currents and signals are sampled.
        let acting = match channel.kind {
            ChannelKind::NegativeStiffness => plane.unheld(&gain, None)?,
            _ => gain,
        };
        all = append(&all, &acting);
    }
    for load in &shapes.loads {
        all = append(&all, &plane.unheld(&plane.realise(load)?.system, None)?);
    }
    let noise = match &shapes.noise {
        Some(curve) => {
            let one = plane.realise(curve)?.system;
            append(&one, &one)
        }
        None => StateSpace::gain(diagonal(weights.sensor_noise_m), Continuous),
    };
    all = append(&all, &noise);
    Ok(append(&all, &StateSpace::gain(Mat::identity(LOOPS, LOOPS), Continuous)))
}

fn output_weights(
    modes: &[UncertainMode],
    weights: &Weights,
    shapes: &WeightShapes,
    plane: WeightPlane,
) -> Result<StateSpace<Continuous>, NumericError> {
    let modal = Mat::from_fn(modes.len(), modes.len(), |i, j| if i == j { modal_gain(&modes[i]) } else { 0.0 });
    let mut all = StateSpace::gain(modal, Continuous);
    for channel in &shapes.channels {
        let weight = match &channel.output {
            ChannelWeight::Constant(value) => StateSpace::gain(Mat::from_fn(1, 1, |_, _| *value), Continuous),
            ChannelWeight::OverFrequency(shape) => plane.realise(shape)?.system,
        };
        all = append(&all, &weight);
    }
    for displacement in &shapes.displacements {
        all = append(&all, &plane.realise(displacement)?.system);
    }
    let current = plane.realise(&shapes.current)?.system;
    for _ in 0..LOOPS {
        all = append(&all, &current);
    }
    if let Some(limit) = weights.complementary_sensitivity_limit {
        let gain = 1.0 / (limit * weights.sensor_noise_m);
        all = append(&all, &StateSpace::gain(diagonal(gain), Continuous));
    }
    for integral in shapes.integral.iter().flatten() {
        all = append(&all, &plane.realise(integral)?.system);
    }
    Ok(append(&all, &StateSpace::gain(diagonal(1.0 / SIGNAL_SCALE_M), Continuous)))
}

/// Plane (v, loads, u) → (q, x, y) with noise inputs and with currents and signals as extra errors:
/// (v, loads, noise, u) → (q, x, u, [y clean], [y + noise], y + noise), wired with the channels.
fn expose_errors(
    plane: &StateSpace<Continuous>,
    nv: usize,
    channels: &[Channel],
    weights: &Weights,
) -> Result<StateSpace<Continuous>, NumericError> {
    let (n, w) = (plane.order(), nv + LOADS);
    let extra = if weights.complementary_sensitivity_limit.is_some() { LOOPS } else { 0 };
    let part = |m: &Mat<f64>, r0, c0, r, c| m.submatrix(r0, c0, r, c).to_owned();
    let noise_gap = |rows: usize| Mat::<f64>::zeros(rows, LOOPS);
    let widen = |m: &Mat<f64>| {
        let rows = m.nrows();
        let left = part(m, 0, 0, rows, w);
        let right = part(m, 0, w, rows, LOOPS);
        crate::lti::connect::stack_cols(&crate::lti::connect::stack_cols(&left, &noise_gap(rows)), &right)
    };
    let b = widen(&plane.b);
    let rows = |m: &Mat<f64>, from, count| part(m, from, 0, count, m.ncols());
    let d_errors = widen(&rows(&plane.d, 0, w));
    let d_signal = widen(&rows(&plane.d, w, LOOPS));
    let currents = Mat::from_fn(LOOPS, w + 2 * LOOPS, |i, j| if j == w + LOOPS + i { 1.0 } else { 0.0 });
    let noise = Mat::from_fn(LOOPS, w + 2 * LOOPS, |i, j| if j == w + i { 1.0 } else { 0.0 });
    let c_signal = rows(&plane.c, w, LOOPS);
    let clean_c = rows(&c_signal, 0, extra);
    let clean_d = rows(&d_signal, 0, extra);
    let noisy_d = &d_signal + &noise;
    let regulated = if weights.integral_corner_hz.is_some() { LOOPS } else { 0 };
    let c = [Mat::zeros(LOOPS, n), clean_c, rows(&c_signal, 0, regulated), c_signal.clone()]
        .iter()
        .fold(rows(&plane.c, 0, w), |all, next| stack_rows(&all, next));
    let d = [currents, clean_d, rows(&noisy_d, 0, regulated), noisy_d]
        .iter()
        .fold(d_errors, |all, next| stack_rows(&all, next));
    let wiring = Wiring::new(nv, d.nrows(), channels);
    let b = Mat::from_fn(n, wiring.columns.len(), |i, j| b[(i, wiring.columns[j])]);
    let c = Mat::from_fn(wiring.rows.len(), n, |i, j| c[(wiring.rows[i], j)]);
    let d = wiring.matrix(&0.0, |i, j| d[(i, j)]);
    StateSpace::new(plane.a.clone(), b, c, d, Continuous)
}

/// √(2r) ω₀.
fn modal_gain(mode: &UncertainMode) -> f64 {
    (2.0 * mode.relative).sqrt() * mode.omega_rad_s
}

fn diagonal(value: f64) -> Mat<f64> {
    block2(&Mat::from_fn(1, 1, |_, _| value), &Mat::zeros(1, 1), &Mat::zeros(1, 1), &Mat::from_fn(1, 1, |_, _| value))
}
