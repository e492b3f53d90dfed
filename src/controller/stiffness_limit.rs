//! The smallest tool stiffness at rest, maximised over all linear controllers within the limits of the polish: a convex
//! problem.
//!
//! With a controller K₀ that is stable itself and stabilises the machine, every other one that stabilises it is K₀
//! beside Q(I + G₁Q)⁻¹, G₁ = G(I − K₀G)⁻¹, Q stable (Youla, Jabr and Bongiorno 1976, for a stable plant). Every
//! quantity of the problem is affine in Q: with S₀ = (I − GK₀)⁻¹ and S_u = (I − K₀G)⁻¹ the response of the currents to
//! the signals is
//!   R = K S = K₀S₀ + S_u Q S₀,
//! the tool's compliance H = H₀ + (d S_u) Q (S₀ r), the sensitivity S = S₀ + (G S_u) Q S₀. Q(z) = Σ Q_n z⁻ⁿ with a
//! finite number of taps; more taps can only raise the stiffness. With a quarter, half and all of them the limit is
//! extrapolated as if every doubling gained the same share of what the one before did. Taps of a stable Q fall
//! geometrically, so that a doubling gains less than that: the extrapolation lies above, but proves nothing.
//!
//! Limits: |S_jj| and the noise current as they are; the gain above the modes of the model is asked of the entries of
//! R = K S, which is K where S is one. Lines as dense as those of the polish; between them the loop may be worse.

use super::polish::LoopLimits;
use super::polish::lines::sharp_lines;
use super::polish::matrix2::{Matrix2, close_loop, product, row_times, times};
use super::polish::modal_law::ModalLaw;
use super::polish::responses::{Known, LoopResponse, Plants};
use super::polish::structure::{LawStructure, LoopLine};
use super::verification_error::VerificationError;
use super::{ControllerError, in_step};
use crate::augment::plane::x_plane;
use crate::linalg::c64;
use crate::lti::connect::lower_lft;
use crate::lti::{Discrete, StateSpace};
use crate::robust::conic::{Affine, NormInequality, Programme};
use crate::spindle::Machine;
use std::f64::consts::{PI, TAU};

/// The limit of the smallest tool stiffness, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessLimit {
    /// Largest smallest stiffness found, N/m.
    pub stiffness_n_per_m: f64,
    /// The same with half the taps: how far from its limit the first still is.
    pub with_half_the_taps_n_per_m: f64,
    /// Limit for ever more taps, N/m; none where a doubling gains no less than the one before.
    pub extrapolated_n_per_m: Option<f64>,
    /// Taps of Q.
    pub taps: usize,
    /// Lines.
    pub lines: usize,
}

/// Taps of Q unless others are asked: on the reference spindle 24 give 4.07 N/µm, 48 give 4.21 N/µm.
pub(crate) const TAPS: usize = 48;
/// Lines closer than this share of their frequency are one.
const APART: f64 = 1e-2;
/// First line, Hz.
const FROM_HZ: f64 = 1.0;
/// Unit of the entries of Q, A/m.
const GAIN: f64 = 1e6;

/// The limit for the machine at rest with Q of so many taps, from a controller of one plane (signals m to currents A).
///
/// # Errors
/// [`VerificationError`] from plants; [`ControllerError::Infeasible`] when `controller` is unstable itself or does not
/// stabilise the machine, or the convex problem has no answer.
pub fn stiffness_limit(
    machine: &Machine,
    limits: &LoopLimits,
    controller: &StateSpace<Discrete>,
    taps: usize,
) -> Result<StiffnessLimit, VerificationError> {
    let plants = Plants::new(machine, 1.0, &[])?;
    let own = controller.growth_rate().map_err(in_step("poles of the controller"))?;
    if own >= 0.0 {
        return Err(infeasible("the controller to start from is unstable itself").into());
    }
    let poles = loop_poles(&plants, controller)?;
    if poles.iter().any(|p| p.re >= 0.0) {
        return Err(infeasible("the controller to start from does not levitate the machine").into());
    }
    let lines = sharp_lines(&plants, FROM_HZ, &poles, &[], APART);
    let rotors = plants.on(&lines, &Known::NOTHING);
    let Some(responses) = rotors.first().and_then(|r| r.directions.first()) else {
        return Err(infeasible("the machine has no response").into());
    };
    let (law, x) = ModalLaw::of(controller)?;
    let mut gains = vec![];
    law.with(&x).add_gains(&lines, &mut gains);
    let base: Vec<BaseLine> = lines
        .iter()
        .zip(responses)
        .zip(&gains)
        .map(|((line, response), gain)| BaseLine::new(line, response, gain))
        .collect();
    let nyquist = PI / plants.period_s();
    let solve = |taps: usize| problem(&base, limits, nyquist, taps);
    let [quarter, half, all] = [solve(taps / 4)?, solve(taps / 2)?, solve(taps)?];
    let share = (all - half) / (half - quarter);
    Ok(StiffnessLimit {
        stiffness_n_per_m: all,
        with_half_the_taps_n_per_m: half,
        extrapolated_n_per_m: (0.0..1.0).contains(&share).then(|| all + (all - half) * share / (1.0 - share)),
        taps,
        lines: lines.len(),
    })
}

/// Poles of the loop at rest as continuous ones, rad/s.
fn loop_poles(plants: &Plants, controller: &StateSpace<Discrete>) -> Result<Vec<c64>, VerificationError> {
    let numeric = in_step("poles of the loop");
    // One plane: the other one is unstable without its own controller.
    let plant = x_plane(&plants.at_rest().sample_plant()?);
    let closed = lower_lft(&plant, controller).map_err(&numeric)?;
    let poles = closed.continuous_poles().map_err(&numeric)?;
    Ok(poles.into_iter().filter(|p| p.im >= 0.0).collect())
}

/// The loop with K₀ at one line, and what Q adds to it.
struct BaseLine {
    line: LoopLine,
    /// S₀, S_u, R₀.
    s: Matrix2,
    su: Matrix2,
    r: Matrix2,
    /// G S_u.
    gsu: Matrix2,
    /// H₀, d S_u, S₀ r.
    compliance: c64,
    drive: [c64; 2],
    read: [c64; 2],
}

impl BaseLine {
    fn new(line: &LoopLine, g: &LoopResponse, gain: &Matrix2) -> Self {
        let (_, s) = close_loop(&product(&g.loops, gain));
        let (_, su) = close_loop(&product(gain, &g.loops));
        let r = product(gain, &s);
        let u = times(&r, &g.read);
        Self {
            line: *line,
            gsu: product(&g.loops, &su),
            compliance: g.tool + g.drive[0] * u[0] + g.drive[1] * u[1],
            drive: row_times(&g.drive, &su),
            read: times(&s, &g.read),
            s,
            su,
            r,
        }
    }

    /// Real and imaginary part of `scale`·(base + left Q right) as affine functions of the taps.
    fn parts(&self, base: c64, left: [c64; 2], right: [c64; 2], scale: f64, taps: usize) -> [Affine; 2] {
        let mut both = [base.re, base.im]
            .map(|constant| Affine { terms: Vec::with_capacity(4 * taps), constant: scale * constant });
        let mut delay = c64::new(scale * GAIN, 0.0);
        for n in 0..taps {
            for i in 0..2 {
                for j in 0..2 {
                    let value = left[i] * right[j] * delay;
                    both[0].terms.push((4 * n + 2 * i + j, value.re));
                    both[1].terms.push((4 * n + 2 * i + j, value.im));
                }
            }
            delay /= self.line.z;
        }
        both
    }
}

fn column(m: &Matrix2, j: usize) -> [c64; 2] {
    [m[0][j], m[1][j]]
}

/// The convex problem with a number of taps; the smallest stiffness, N/m.
fn problem(base: &[BaseLine], limits: &LoopLimits, nyquist_rad_s: f64, taps: usize) -> Result<f64, ControllerError> {
    let level = 4 * taps;
    let constant = |constant: f64| Affine { terms: vec![], constant };
    let mut norms = vec![];
    let mut noise: [Vec<Affine>; 2] = [vec![], vec![]];
    let (low, high) = limits.stiffness_band_hz;
    for (k, here) in base.iter().enumerate() {
        let omega = here.line.omega_rad_s;
        let hz = omega / TAU;
        if hz >= low * (1.0 - 1e-9) && hz <= high * (1.0 + 1e-9) {
            // Compliance in µm/N.
            let h = (here.compliance, here.drive, here.read);
            norms.push(NormInequality {
                bound: Affine { terms: vec![(level, 1.0)], constant: 0.0 },
                parts: here.parts(h.0, h.1, h.2, 1e6, taps).to_vec(),
            });
        }
        for j in 0..2 {
            let s = (here.s[j][j], here.gsu[j], column(&here.s, j));
            norms.push(NormInequality {
                bound: constant(limits.sensitivity),
                parts: here.parts(s.0, s.1, s.2, 1.0, taps).to_vec(),
            });
        }
        let neighbour = |at: Option<&BaseLine>, end: f64| at.map_or(end, |b| 0.5 * (b.line.omega_rad_s + omega));
        let below = neighbour(k.checked_sub(1).and_then(|k| base.get(k)), 0.0);
        let above = neighbour(base.get(k + 1), nyquist_rad_s);
        let share = ((above - below) / nyquist_rad_s).sqrt();
        for (i, sum) in noise.iter_mut().enumerate() {
            for j in 0..2 {
                let r = (here.r[i][j], here.su[i], column(&here.s, j));
                let weight = share * limits.sensor_noise_m / limits.noise_current_a;
                sum.extend(here.parts(r.0, r.1, r.2, weight, taps));
                if hz >= limits.high_frequency_hz {
                    norms.push(NormInequality {
                        bound: constant(1.0),
                        parts: here.parts(r.0, r.1, r.2, limits.high_frequency_gain_a_per_m.recip(), taps).to_vec(),
                    });
                }
            }
        }
    }
    norms.extend(noise.into_iter().map(|parts| NormInequality { bound: constant(1.0), parts }));
    let mut objective = vec![0.0; level + 1];
    objective[level] = 1.0;
    let programme = Programme { objective, norms, ..Programme::default() };
    let found = programme.solve().map_err(|error| infeasible(&error.to_string()))?;
    // Whatever accuracy the solver claims: the point it ended at has to keep every limit.
    let exceeded = programme.norms.iter().map(|n| n.excess(&found.x));
    let exceeded = exceeded.fold(0.0, |a: f64, b| if b.is_nan() { b } else { a.max(b) });
    if exceeded.is_nan() || exceeded > KEPT {
        let reason = format!("the solution of the convex problem exceeds a limit by {exceeded:.1e} of it");
        return Err(infeasible(&reason));
    }
    Ok(1e6 / found.x[level])
}

/// What a solution may exceed its limits by, relative: far below what the taps leave open.
const KEPT: f64 = 1e-3;

fn infeasible(reason: &str) -> ControllerError {
    ControllerError::Infeasible {
        step: "stiffness limit",
        reason: reason.to_owned(),
        advice: "it starts from a controller that is stable itself and levitates the machine; a polished one is",
    }
}
