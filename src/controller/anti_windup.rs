//! Anti-windup: what the states of a controller do in a sample whose output is limited.
//!
//! Law, with v = C x + D y the output before its limit û and u = sat(v) the output behind it, axis by axis:
//!   x⁺ = A x + B y + L (u − v).
//! While no output is limited u = v and the term is not computed: the controller is the same, bit for bit.
//! Order of operations of one sample in float32, on scaled states:
//!   1. v and u as without anti-windup; eⱼ = uⱼ − vⱼ.
//!   2. every xᵢ⁺ as without anti-windup, before its clamp.
//!   3. only if some eⱼ ≠ 0: for every state i with a row of L, in the order of its terms: xᵢ⁺ ← xᵢ⁺ + Lᵢⱼ eⱼ (product
//!      rounded, then the sum); then the clamp of the state.
//!
//! The scales are such that neither step reaches ±1 for any displacements and currents within their limits, except
//! where the clamp of a slow real pole is its own limit: the clamps do not interfere with the correction.
//!
//! Only the slow modes are conditioned, those with |ln z|/Tₛ < α, and those that do not decay: x_s of A_s, C_s. A
//! limited actuator acts as a gain κ < 1. The integral action of a slow mode then turns into phase lag where the loop
//! crosses over with that lower gain, and the rotor swings between its stops. With W the solution of W + C_sᵀC_s = A_sᵀ
//! e^{2αTₛ} W A_s,
//!   L_s = A_s (W + C_sᵀC_s)⁻¹ C_sᵀ
//! is the gain of least energy that leaves all modes of A_s − L_s C_s a decay rate above α: it moves a mode with the
//! rate r to 2α − r (Anderson and Moore, Linear Optimal Control, 1971, prescribed degree of stability). All other rows
//! of L are zero.
//!
//! Choice of α: with dead zone q = v − u and nominal loop M from q to v, M = −(I − KG)⁻¹(KG + Γ), Γ = C(zI − A)⁻¹L, a
//! saturation of gain κ on all axes is q = δ v, δ = 1 − κ. Let κ(α) be the smallest gain such that |1 − δ λᵢ(M)| ≥ 1/5
//! for all gains of [κ, 1], at rest and at the top speed. α is the fastest rate on a grid with κ(α) ≤ κ without L: the
//! fastest forgetting that costs no robustness against a lower gain. A fast rate also leaves room for the lag of coils
//! at their voltage limit, which M does not know.
//!
//! Stability. (a) Limited output: v follows x⁺ = (A − LC)x + (B − LD)y + Lu with y and u bounded, and A − LC is block
//! triangular with the modes of A_s − L_s C_s and the untouched ones of A; so states stay bounded and forget at the
//! rate of [`AntiWindup::forgetting_1_s`]. (b) Loop: circle criterion, λ_max(½(M + Mᴴ)) < 1/(1 − κ) on the unit circle:
//! every saturation whose outputs stay below û/κ leaves the loop asymptotically stable, in this region and for the
//! linear magnet; κ is [`AntiWindup::circle_gain`]. Both hold on a grid of frequencies. An unstable magnet has no
//! global proof.

use super::realise::{Form, Realisation, Row, modal_form};
use super::scaling::{ScaledRealisation, SignalLimits, scale_realisation, with_room};
use super::verification::growth_rate;
use super::verification_error::VerificationError;
use super::{ControllerError, in_step};
use crate::linalg::hermitian::hermitian_eigen;
use crate::linalg::lyapunov::discrete_lyapunov;
use crate::linalg::schur::schur;
use crate::linalg::{Mat, c64, eigenvalues, eigenvalues_complex, solve, solve_complex};
use crate::lti::{Discrete, FrequencyResponder, StateSpace};
use crate::spindle::plant::AXES;
use crate::spindle::{Machine, Plant};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Margin that the loop keeps while its gain falls: 1/5 is the peak sensitivity at which zone C of ISO 14839-3 ends.
const MARGIN: f64 = 0.2;
/// Frequencies of the checks, evenly in the logarithm from 10⁻⁶ of the Nyquist frequency up to it.
const FREQUENCIES: usize = 400;
/// Rates α tried: eight a decade, from 10⁻⁴·⁵ to 10⁻¹ of the Nyquist frequency. Slower is no conditioning within any
/// swing of a rotor, faster acts on the crossover itself.
const RATES: usize = 29;
/// Entries of L this small against the largest of their column come from rounding of the invariant subspace.
const ROUNDING: f64 = 1e-10;

/// The gain of the anti-windup and what is known about it.
#[derive(Clone, Debug)]
pub struct AntiWindup {
    /// L, states × outputs, in the units of the realisation that it was made for (scaled states, A).
    pub gain: Mat<f64>,
    /// Rate α, 1/s; zero when no mode is conditioned.
    pub rate_1_s: f64,
    /// Smallest gain κ of the saturation that keeps the margin, with L.
    pub smallest_gain: f64,
    /// The same without L.
    pub smallest_gain_without: f64,
    /// Smallest gain κ of the circle criterion, with L.
    pub circle_gain: f64,
    /// Decay rate of the slowest mode of A − LC, 1/s: how fast a limited controller forgets.
    pub forgetting_1_s: f64,
}

/// The anti-windup of a realisation in its loop with `plants` (four sampled axes each, u = K y).
///
/// A loop that is unstable without limits gets the gain zero: nothing is known about it.
///
/// # Errors
/// [`ControllerError::Numeric`] when an eigenvalue iteration fails.
pub fn anti_windup(realisation: &Realisation, plants: &[StateSpace<Discrete>]) -> Result<AntiWindup, ControllerError> {
    let step = in_step("anti-windup");
    let system = realisation.to_state_space()?;
    let none = Mat::<f64>::zeros(system.order(), system.outputs());
    let stable = plants
        .par_iter()
        .map(|p| growth_rate(p, &system))
        .collect::<Result<Vec<f64>, _>>()
        .map_err(&step)?
        .iter()
        .all(|rate| *rate < 0.0);
    let loops: Vec<LoopPoint> = plants.par_iter().flat_map(|p| points(p, &system)).collect();
    let without = smallest_gain(&loops, &zero_response(&system));
    let mut best = (without, 0.0, none);
    if stable {
        let nyquist = PI / system.time.period_s;
        let tried: Result<Vec<_>, ControllerError> = (0..RATES)
            .into_par_iter()
            .map(|k| {
                let rate = nyquist * 10f64.powf(-4.5 + k as f64 / 8.0);
                let Some((gain, response)) = condition_rows(realisation, &system, rate)? else {
                    return Ok(None);
                };
                Ok(Some((smallest_gain(&loops, &response), rate, gain)))
            })
            .collect();
        // Modes that do not decay need L even where the margin gains nothing by it.
        let must = system.poles().map_err(&step)?.iter().any(|z| !decays(*z));
        for (gain, rate, l) in tried?.into_iter().flatten() {
            if gain <= without || (must && best.1 == 0.0) {
                best = (gain, rate, l);
            }
        }
    }
    let (smallest, rate_1_s, gain) = best;
    let inner = &system.a - &gain * &system.c;
    let radius = eigenvalues(&inner).map_err(&step)?.iter().map(|z| z.norm()).fold(0.0, f64::max);
    Ok(AntiWindup {
        rate_1_s,
        smallest_gain: smallest,
        smallest_gain_without: without,
        circle_gain: circle_gain(&loops, &gain_response(&system, &gain)).map_err(&step)?,
        forgetting_1_s: -radius.ln() / system.time.period_s,
        gain,
    })
}

/// The rows that firmware runs for a sampled law on a machine: modal form, states and signals scaled, anti-windup.
pub(crate) fn firmware_rows(
    law: &StateSpace<Discrete>,
    machine: &Machine,
) -> Result<(ScaledRealisation, AntiWindup), VerificationError> {
    let scaled = scale_realisation(&modal_form(law)?, SignalLimits::of(machine))?;
    with_anti_windup(scaled, machine)
}

/// A scaled realisation with its anti-windup on a machine, at rest and at its top speed; the scales leave room for what
/// the correction does to the states.
///
/// # Errors
/// [`VerificationError`] when a plant cannot be built or an eigenvalue iteration fails.
pub fn with_anti_windup(
    scaled: ScaledRealisation,
    machine: &Machine,
) -> Result<(ScaledRealisation, AntiWindup), VerificationError> {
    let axes: Vec<usize> = (0..AXES).collect();
    let plants = [0.0, machine.spindle.max_rpm * TAU / 60.0]
        .par_iter()
        .map(|speed| {
            let plant = Plant::design_model(machine, *speed)?.sample_plant()?;
            Ok(plant.select(&axes, &axes))
        })
        .collect::<Result<Vec<_>, VerificationError>>()?;
    let mut found = anti_windup(&scaled.rows, &plants)?;
    let before = scaled.state_scale.clone();
    let scaled = with_room(scaled, &found.gain)?;
    for (i, old) in before.iter().enumerate() {
        for j in 0..found.gain.ncols() {
            found.gain[(i, j)] *= old / scaled.state_scale[i];
        }
    }
    Ok((scaled, found))
}

/// Adds L e to the next states in float32, each product and each sum rounded, in row order; step 3 of the law.
/// `conditioning` has one row a state, a term's source is the output; `excess_a` is u − v.
pub(crate) fn correct_f32(next: &mut [f32], conditioning: &[Row], excess_a: &[f32]) {
    if excess_a.iter().all(|e| *e == 0.0) {
        return;
    }
    for (state, row) in next.iter_mut().zip(conditioning) {
        for term in row {
            let product = term.coefficient as f32 * excess_a[term.source];
            *state += product;
        }
    }
}

/// True when a mode comes to rest: what is within rounding of the unit circle is an integrator.
fn decays(z: c64) -> bool {
    z.norm() < 1.0 - 1e-12
}

/// L and its response Γ for a rate; nothing when no mode is slow or L is not finite.
fn condition_rows(
    realisation: &Realisation,
    system: &StateSpace<Discrete>,
    rate_1_s: f64,
) -> Result<Option<(Mat<f64>, Vec<Mat<c64>>)>, ControllerError> {
    let period = system.time.period_s;
    let slow = |z: c64| z.ln().norm() < rate_1_s * period || !decays(z);
    let Some((left, right)) = subspace(realisation, system, &slow)? else {
        return Ok(None);
    };
    let (a, c) = (&left * &system.a * &right, &system.c * &right);
    let Some(inner) = least_energy(&a, &c, (rate_1_s * period).exp()) else {
        return Ok(None);
    };
    let mut gain = &right * &inner;
    for j in 0..gain.ncols() {
        let largest = (0..gain.nrows()).fold(0.0f64, |m, i| m.max(gain[(i, j)].abs()));
        for i in 0..gain.nrows() {
            if gain[(i, j)].abs() < ROUNDING * largest {
                gain[(i, j)] = 0.0;
            }
        }
    }
    let part = StateSpace::new(a, inner, c, Mat::zeros(system.outputs(), system.outputs()), system.time)
        .map_err(in_step("anti-windup"))?;
    Ok(Some((gain, response(&part))))
}

/// L_s = A (W + CᵀC)⁻¹ Cᵀ with W + CᵀC = Aᵀ g² W A; `growth` is g. Nothing when C does not see a mode.
fn least_energy(a: &Mat<f64>, c: &Mat<f64>, growth: f64) -> Option<Mat<f64>> {
    let k = a.nrows();
    let square = c.transpose() * c;
    let inverse = solve(&(a * growth), &Mat::identity(k, k)).ok()?;
    let start = inverse.transpose() * &square * &inverse;
    let w = discrete_lyapunov(&inverse, &start).ok()?;
    let gain = a * solve(&(w + square), &c.transpose().to_owned()).ok()?;
    let left = eigenvalues(&(a - &gain * c)).ok()?;
    // The promise of the construction; it fails when the modes cannot be told apart from the outputs.
    let kept = left.iter().all(|z| z.norm() * growth < 1.0 + 1e-6);
    (gain.is_all_finite() && kept).then_some(gain)
}

/// Bases of the invariant subspace of the selected modes: V (k×n) and X (n×k) with V A = A_s V, A X = X A_s, V X = I.
fn subspace(
    realisation: &Realisation,
    system: &StateSpace<Discrete>,
    slow: &dyn Fn(c64) -> bool,
) -> Result<Option<(Mat<f64>, Mat<f64>)>, ControllerError> {
    let step = in_step("anti-windup");
    let n = system.order();
    if realisation.form == Form::Modal {
        // Blocks do not act on each other: the states of a block are its coordinates.
        let (mut states, mut start) = (Vec::new(), 0);
        for size in &realisation.blocks {
            let block = system.a.submatrix(start, start, *size, *size).to_owned();
            if eigenvalues(&block).map_err(&step)?.into_iter().any(slow) {
                states.extend(start..start + size);
            }
            start += size;
        }
        let pick = Mat::from_fn(states.len(), n, |i, j| f64::from(u8::from(states[i] == j)));
        let right = pick.transpose().to_owned();
        return Ok((!states.is_empty()).then_some((pick, right)));
    }
    let (form, k) = schur(&system.a).map_err(&step)?.reorder(slow);
    let adjoint = system.a.transpose().to_owned();
    let (other, same) = schur(&adjoint).map_err(&step)?.reorder(slow);
    if k == 0 || k != same {
        return Ok(None);
    }
    let right = form.z.submatrix(0, 0, n, k).to_owned();
    let left = other.z.submatrix(0, 0, n, k).transpose().to_owned();
    let left = solve(&(&left * &right), &left).map_err(&step)?;
    Ok(Some((left, right)))
}

/// What the loop of one plant says at one frequency: (I − KG)⁻¹ and (I − KG)⁻¹KG.
struct LoopPoint {
    index: usize,
    sensitivity: Mat<c64>,
    transmission: Mat<c64>,
}

fn grid() -> impl Iterator<Item = c64> {
    (0..FREQUENCIES).map(|k| {
        let share = k as f64 / (FREQUENCIES - 1) as f64;
        c64::from_polar(1.0, PI * 10f64.powf(-6.0 * (1.0 - share)))
    })
}

fn response(system: &StateSpace<Discrete>) -> Vec<Mat<c64>> {
    let responder = FrequencyResponder::new(system);
    grid().map(|z| responder.transfer(z)).collect()
}

fn zero_response(system: &StateSpace<Discrete>) -> Vec<Mat<c64>> {
    grid().map(|_| Mat::zeros(system.outputs(), system.outputs())).collect()
}

fn gain_response(system: &StateSpace<Discrete>, gain: &Mat<f64>) -> Vec<Mat<c64>> {
    response(&StateSpace { b: gain.clone(), d: Mat::zeros(system.outputs(), system.outputs()), ..system.clone() })
}

fn points(plant: &StateSpace<Discrete>, controller: &StateSpace<Discrete>) -> Vec<LoopPoint> {
    let (g, k) = (response(plant), response(controller));
    let size = controller.outputs();
    let one = Mat::<c64>::identity(size, size);
    g.iter()
        .zip(&k)
        .enumerate()
        .map(|(index, (g, k))| {
            let open = k * g;
            let sensitivity = solve_complex(&(&one - &open), &one);
            let transmission = &sensitivity * &open;
            LoopPoint { index, sensitivity, transmission }
        })
        .collect()
}

/// M = −(I − KG)⁻¹(KG + Γ).
fn dead_zone(point: &LoopPoint, gamma: &[Mat<c64>]) -> Mat<c64> {
    let m = &point.transmission + &point.sensitivity * &gamma[point.index];
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| -m[(i, j)])
}

/// Smallest κ such that |1 − δ λᵢ(M)| ≥ [`MARGIN`] for every δ up to 1 − κ. An eigenvalue λ enters the circle of the
/// margin at the smaller root of |λ|²δ² − 2 Re λ δ + 1 − margin² = 0.
fn smallest_gain(loops: &[LoopPoint], gamma: &[Mat<c64>]) -> f64 {
    let mut reach = 1.0f64;
    for point in loops {
        let m = dead_zone(point, gamma);
        // An integrator on the grid's lowest frequencies may overflow nothing; an iteration that fails counts as no
        // room.
        let Ok(values) = eigenvalues_complex(&m) else {
            return 1.0;
        };
        for value in values {
            let (re, square) = (value.re, value.norm_sqr());
            let root = re * re - square * (1.0 - MARGIN * MARGIN);
            if re > 0.0 && root >= 0.0 {
                reach = reach.min((re - root.sqrt()) / square);
            }
        }
    }
    1.0 - reach
}

/// Smallest κ of the circle criterion, 1 − 1/max λ_max(½(M + Mᴴ)); zero when every sector is proven.
fn circle_gain(loops: &[LoopPoint], gamma: &[Mat<c64>]) -> Result<f64, crate::linalg::NumericError> {
    let mut largest = 0.0f64;
    for point in loops {
        let m = dead_zone(point, gamma);
        let size = m.nrows();
        let half = Mat::from_fn(size, size, |i, j| 0.5 * (m[(i, j)] + m[(j, i)].conj()));
        let (values, _) = hermitian_eigen(&half)?;
        largest = values.into_iter().fold(largest, f64::max);
    }
    Ok(if largest > 1.0 { 1.0 - 1.0 / largest } else { 0.0 })
}
