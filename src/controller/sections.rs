//! Second-order sections: every axis of a decentralised controller as a cascade of biquads in transposed direct
//! form II,  t = b₀e + x₁,  x₁⁺ = b₁e − a₁t + x₂,  x₂⁺ = b₂e − a₂t,  e the output of the section before.
//! Zeros come from the resolvent at a real point z₀ where the axis responds, so zeros at infinity need no care:
//! with w = 1/(z − z₀) and M = (z₀I − A)⁻¹, K = D′ − cM(wI + M)⁻¹Mb, D′ = d + cMb, zeros w = eig(−M + Mb·cM/D′).
//! Pairing: the poles nearest the unit circle take the zeros nearest to them; sections run from damped to resonant.

use super::modal::transfer_change;
use super::realise::{Form, Realisation, Row, Term};
use super::{ControllerError, in_step};
use crate::linalg::{Mat, c64, eigenvalues, solve};
use crate::lti::{Discrete, StateSpace, structure};

/// Accepted change of the transfer matrix, relative to its peak: below single precision (6e-8). Zeros of multiple
/// order cost half the digits of double precision.
const LARGEST_CHANGE: f64 = 2e-8;
/// A zero beyond this radius is one at infinity: its factor is constant within 1e-7 on the unit circle.
const ZERO_AT_INFINITY: f64 = 1e7;

/// The sections of every axis, in order of computation, in metres and amperes; for the tables of firmware libraries.
///
/// # Errors
/// As [`second_order_sections`], without the check of the transfer.
pub(crate) fn cascades(system: &StateSpace<Discrete>) -> Result<Vec<Vec<Section>>, ControllerError> {
    (0..system.inputs().min(system.outputs())).map(|axis| cascade(&axis_system(system, axis)?)).collect()
}

/// Cascades of second-order sections of a decentralised controller (output i depends on input i alone).
///
/// # Errors
/// [`ControllerError::NotDecentralised`] for a controller that mixes axes, [`ControllerError::Inaccurate`] when the
/// cascade does not reproduce the controller, [`ControllerError::Numeric`] from the eigenvalue iterations.
pub fn second_order_sections(system: &StateSpace<Discrete>) -> Result<Realisation, ControllerError> {
    let cascades = cascades(system)?;
    let n: usize = cascades.iter().flatten().map(|s| s.order).sum();
    let m = system.inputs();
    let (mut signals, mut outputs, mut states): (Vec<Row>, Vec<Row>, Vec<Row>) = (Vec::new(), Vec::new(), Vec::new());
    let mut blocks = Vec::new();
    for (axis, cascade) in cascades.iter().enumerate() {
        let mut source = n + axis;
        for section in cascade {
            let first = states.len();
            let out = n + m + signals.len();
            let term = |source, coefficient| Term { source, coefficient };
            let mut row = vec![term(source, section.b[0])];
            if section.order > 0 {
                row.push(term(first, 1.0));
            }
            signals.push(row);
            for k in 1..=section.order {
                let mut row = vec![term(source, section.b[k]), term(out, -section.a[k - 1])];
                if k < section.order {
                    row.push(term(first + k, 1.0));
                }
                states.push(row);
            }
            blocks.push(section.order);
            source = out;
        }
        outputs.push(vec![Term { source, coefficient: 1.0 }]);
    }
    let realisation = Realisation {
        form: Form::SecondOrderSections,
        inputs: m,
        signals,
        outputs,
        states,
        sample_time_s: system.time.period_s,
        blocks,
        condition: 1.0,
        notes: Vec::new(),
    };
    let error = transfer_change(system, &realisation.to_state_space()?);
    if error.is_nan() || error > LARGEST_CHANGE {
        return Err(ControllerError::Inaccurate { step: "second-order sections", error, allowed: LARGEST_CHANGE });
    }
    Ok(realisation)
}

/// One section: b₀ + b₁z⁻¹ + b₂z⁻² over 1 + a₁z⁻¹ + a₂z⁻².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Number of poles, 0 to 2.
    pub order: usize,
    /// b₀, b₁, b₂.
    pub b: [f64; 3],
    /// a₁, a₂.
    pub a: [f64; 2],
}

/// The part of the controller that axis `axis` reads and drives: states both reached from its input and seen at
/// its output through the pattern of A.
fn axis_system(system: &StateSpace<Discrete>, axis: usize) -> Result<StateSpace<Discrete>, ControllerError> {
    let n = system.order();
    let seen = structure::seen(system, &[axis]);
    for input in (0..system.inputs()).filter(|j| *j != axis) {
        let other = structure::driven(system, &[input]);
        if system.d[(axis, input)] != 0.0 || (0..n).any(|i| other[i] && seen[i]) {
            return Err(ControllerError::NotDecentralised { output: axis, input });
        }
    }
    let own = structure::driven(system, &[axis]);
    Ok(system.select(&[axis], &[axis]).keep_states(|i| own[i] && seen[i]))
}

fn cascade(axis: &StateSpace<Discrete>) -> Result<Vec<Section>, ControllerError> {
    let step = "second-order sections";
    let poles = axis.poles().map_err(in_step(step))?;
    // A real point outside the circle, where nothing of interest lies; the second serves if K vanishes at the first.
    let (z0, gain) = [3.0, -3.0, 7.0]
        .into_iter()
        .map(|z| (z, axis.transfer(c64::new(z, 0.0))[(0, 0)].re))
        .find(|(_, gain)| gain.is_finite() && *gain != 0.0)
        .unwrap_or((3.0, 0.0));
    if gain == 0.0 || poles.is_empty() {
        return Ok(vec![Section { order: 0, b: [axis.d[(0, 0)], 0.0, 0.0], a: [0.0; 2] }]);
    }
    let n = axis.order();
    let shifted = Mat::from_fn(n, n, |i, j| -axis.a[(i, j)] + if i == j { z0 } else { 0.0 });
    let m = solve(&shifted, &Mat::identity(n, n)).map_err(in_step(step))?;
    let (mb, cm) = (&m * &axis.b, &axis.c * &m);
    let pencil = Mat::from_fn(n, n, |i, j| -m[(i, j)] + mb[(i, 0)] * cm[(0, j)] / gain);
    let zeros: Vec<c64> = eigenvalues(&pencil)
        .map_err(in_step(step))?
        .into_iter()
        .filter(|w| w.norm() * ZERO_AT_INFINITY > 1.0)
        .map(|w| c64::new(z0, 0.0) + w.inv())
        .collect();
    let mut pole_pairs = pairs(&poles);
    // Most resonant first, so that it chooses its zeros first.
    pole_pairs.sort_by(|p, q| radius(q).total_cmp(&radius(p)));
    let mut zero_pairs = pairs(&zeros);
    let mut sections = Vec::new();
    for pair in &pole_pairs {
        let nearest = (0..zero_pairs.len()).min_by(|i, j| {
            let distance = |k: usize| (zero_pairs[k][0] - pair[0]).norm();
            distance(*i).total_cmp(&distance(*j))
        });
        let zero = nearest.map(|k| zero_pairs.remove(k)).unwrap_or_default();
        sections.push(section(pair, &zero));
    }
    sections.reverse();
    // The overall gain: match the response at z₀, where K is known and no pole or zero is near.
    let response = |s: &Section| {
        let q = 1.0 / z0;
        (s.b[0] + q * (s.b[1] + q * s.b[2])) / (1.0 + q * (s.a[0] + q * s.a[1]))
    };
    // Each section gets unit gain in the middle of the band, z = j, the last one carries the rest.
    let middle = |s: &Section| {
        let q = c64::new(0.0, -1.0);
        let numerator = q * (q * s.b[2] + s.b[1]) + s.b[0];
        let denominator = q * (q * s.a[1] + s.a[0]) + 1.0;
        (numerator / denominator).norm()
    };
    for s in &mut sections {
        let factor = middle(s);
        if factor > 0.0 && factor.is_finite() {
            s.b.iter_mut().for_each(|b| *b /= factor);
        }
    }
    let product: f64 = sections.iter().map(response).product();
    if let Some(last) = sections.last_mut() {
        last.b.iter_mut().for_each(|b| *b *= gain / product);
    }
    Ok(sections)
}

fn radius(pair: &[c64]) -> f64 {
    pair.iter().map(|p| p.norm()).fold(0.0, f64::max)
}

/// Roots as conjugate pairs and couples of real roots (neighbours in size), one single real root left over.
fn pairs(roots: &[c64]) -> Vec<Vec<c64>> {
    let mut list: Vec<Vec<c64>> = roots.iter().filter(|r| r.im > 0.0).map(|r| vec![*r, r.conj()]).collect();
    let mut real: Vec<c64> = roots.iter().filter(|r| r.im == 0.0).copied().collect();
    real.sort_by(|x, y| y.re.total_cmp(&x.re));
    list.extend(real.chunks(2).map(<[c64]>::to_vec));
    list
}

/// Section with the given poles and zeros, leading coefficients one; missing zeros lie at infinity.
fn section(poles: &[c64], zeros: &[c64]) -> Section {
    let monic = |roots: &[c64]| match roots {
        [] => (0.0, 0.0),
        [r] => (-r.re, 0.0),
        [r, s, ..] => (-(r + s).re, (r * s).re),
    };
    let (a1, a2) = monic(poles);
    let (z1, z2) = monic(zeros);
    let order = poles.len();
    let b = match (order, zeros.len()) {
        (1, 0) => [0.0, 1.0, 0.0],
        (1, _) => [1.0, z1, 0.0],
        (_, 0) => [0.0, 0.0, 1.0],
        (_, 1) => [0.0, 1.0, z1],
        _ => [1.0, z1, z2],
    };
    Section { order, b, a: [a1, a2] }
}
