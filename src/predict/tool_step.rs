//! Displacement of the tool after a constant force begins to act on it: the linear loop, exact at the sampling
//! instants.

use super::closed_loop::close;
use crate::augment::plane::connected_part;
use crate::linalg::{Mat, NumericError, solve};
use crate::lti::{Discrete, Response, StateSpace};

/// Step response of the tool in x.
#[derive(Clone, Debug)]
pub struct ToolStep {
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// Displacement, m/N.
    pub displacement_m_per_n: Vec<f64>,
    /// Its end, m/N.
    pub final_m_per_n: f64,
    /// Largest displacement over that of the end, less one.
    pub overshoot: f64,
    /// From here on the displacement stays within 2 % of its end, s; not a number where it does not settle in time.
    pub settling_s: f64,
}

/// Share of the end within which the response has settled, as is usual.
pub(crate) const SETTLED: f64 = 0.02;
/// Time constants of the slowest pole that are computed: what is left of it then is e⁻⁸, a sixtieth of [`SETTLED`].
const TIME_CONSTANTS: f64 = 8.0;
/// Steps of a search of the settling time over these time constants.
const SEARCH_STEPS: f64 = 2048.0;
/// Longest response, s: an integrator slower than this shows as a response that has not settled.
const LONGEST_S: f64 = 2.0;

impl ToolStep {
    /// Of the sampled plant (forces after the control channels) with a controller whose loop is stable.
    ///
    /// # Errors
    /// [`NumericError`] when the loop is not well posed or its eigenvalues fail.
    pub fn of(sampled: &StateSpace<Discrete>, law: &StateSpace<Discrete>) -> Result<Self, NumericError> {
        let tool = tool_in_x(sampled, law)?;
        let period_s = tool.time.period_s;
        let horizon_s = (TIME_CONSTANTS / -tool.growth_rate()?).clamp(period_s, LONGEST_S);
        let steps = (horizon_s / period_s).ceil() as usize;
        let mut state = Mat::<f64>::zeros(tool.order(), 1);
        let mut displacement = Vec::with_capacity(steps + 1);
        for _ in 0..=steps {
            displacement.push((&tool.c * &state)[(0, 0)] + tool.d[(0, 0)]);
            state = &tool.a * &state + &tool.b;
        }
        let end = tool.at(0.0)[(0, 0)].re;
        let largest = displacement.iter().map(|x| x / end).fold(f64::NEG_INFINITY, f64::max);
        let settling_s = settling_of(&tool)?;
        let time_s: Vec<f64> = (0..=steps).map(|k| k as f64 * period_s).collect();
        Ok(Self {
            settling_s: if settling_s <= horizon_s { settling_s } else { f64::NAN },
            overshoot: (largest - 1.0).max(0.0),
            final_m_per_n: end,
            displacement_m_per_n: displacement,
            time_s,
        })
    }
}

/// From force to displacement of the tool in x, the loop closed.
fn tool_in_x(sampled: &StateSpace<Discrete>, law: &StateSpace<Discrete>) -> Result<StateSpace<Discrete>, NumericError> {
    Ok(connected_part(&close(sampled, law)?.select(&[0], &[0])))
}

/// Time from the begin of a static load at the tool in x from which on its displacement stays within 2 % of its end, s;
/// not a number of an unstable loop.
///
/// # Errors
/// As [`ToolStep::of`].
pub fn static_load_settling_s(sampled: &StateSpace<Discrete>, law: &StateSpace<Discrete>) -> Result<f64, NumericError> {
    settling_of(&tool_in_x(sampled, law)?)
}

/// The distance to the end is C Aᵏ e₀. Its last value beyond 2 % is searched in steps of 2ⁿ samples, then within the
/// last of them by halving, so that a slow loop takes no longer than a fast one. A distance that grows at first is
/// followed for longer. Not a number of a loop whose decay rounding hides, or whose tool stays where it was.
fn settling_of(tool: &StateSpace<Discrete>) -> Result<f64, NumericError> {
    let period_s = tool.time.period_s;
    let decay = -tool.growth_rate()? * period_s;
    if decay < f64::EPSILON {
        return Ok(f64::NAN);
    }
    let rest = Mat::<f64>::identity(tool.order(), tool.order()) - &tool.a;
    let mut state = solve(&rest, &tool.b)?;
    let end = tool.at(0.0)[(0, 0)].re;
    if end == 0.0 {
        return Ok(f64::NAN);
    }
    let distance = |state: &Mat<f64>| ((&tool.c * state)[(0, 0)] / end).abs();
    // A to the powers 1, 2, 4 …: the last one is a step of the search.
    let doublings = (TIME_CONSTANTS / (decay * SEARCH_STEPS)).log2().ceil().max(0.0) as usize;
    let mut powers = vec![tool.a.clone()];
    for k in 0..doublings {
        powers.push(&powers[k] * &powers[k]);
    }
    let samples = |doublings: usize| 2f64.powi(doublings as i32);
    let (mut at, mut largest, mut last) = (0.0, 1.0f64, None);
    while at * decay < TIME_CONSTANTS + largest.ln() {
        let away = distance(&state);
        largest = largest.max(away);
        if away > SETTLED {
            last = Some((at, state.clone()));
        }
        state = &powers[doublings] * &state;
        at += samples(doublings);
    }
    let Some((mut at, mut state)) = last else {
        return Ok(0.0);
    };
    for k in (0..doublings).rev() {
        let next = &powers[k] * &state;
        if distance(&next) > SETTLED {
            (at, state) = (at + samples(k), next);
        }
    }
    Ok((at + 1.0) * period_s)
}
