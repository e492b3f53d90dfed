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

/// The distance to the end is C Aᵏ e₀. The sum of its squares over 1, 2, 4 … samples bounds it on all of them: where a
/// sum exceeds the square of the limit, its later half is searched first. Not a number of a loop whose decay rounding
/// hides, or whose tool stays where it was.
fn settling_of(tool: &StateSpace<Discrete>) -> Result<f64, NumericError> {
    let period_s = tool.time.period_s;
    let decay = -tool.growth_rate()? * period_s;
    let rest = Mat::<f64>::identity(tool.order(), tool.order()) - &tool.a;
    let end = tool.at(0.0)[(0, 0)].re;
    if decay < f64::EPSILON || end == 0.0 {
        return Ok(f64::NAN);
    }
    let halves = Halves::of(tool, (FINEST / decay).log2().floor().max(0.0) as usize);
    let last = halves.last_beyond(&solve(&rest, &tool.b)?, halves.sums.len() - 1, (SETTLED * end).powi(2));
    Ok(last.map_or(0.0, |last| (last + 1.0) * period_s))
}

/// Share of a time constant of the slowest pole to which a settling time is searched, or a sample: a slow loop takes no
/// longer than a fast one.
const FINEST: f64 = 1e-6;
/// Relative change of a mean square over that time below which only slow poles are left.
const LEVEL: f64 = 1e-3;
/// Doublings after which no loop that is stable to rounding moves.
const MOST_DOUBLINGS: usize = 60;

/// Steps over 1, 2, 4 … samples, and the sums Σ (Aᵏ)ᵀ Cᵀ C Aᵏ over as many.
struct Halves {
    steps: Vec<Mat<f64>>,
    sums: Vec<Mat<f64>>,
    /// What is not halved any more once the distance is level.
    finest: usize,
}

impl Halves {
    fn of(tool: &StateSpace<Discrete>, finest: usize) -> Self {
        let mut steps = vec![tool.a.clone()];
        let mut sums = vec![tool.c.transpose() * &tool.c];
        for k in 0..MOST_DOUBLINGS {
            let later = steps[k].transpose() * &sums[k] * &steps[k];
            let (size, added) = (sums[k].norm_max(), later.norm_max());
            sums.push(&sums[k] + later);
            steps.push(&steps[k] * &steps[k]);
            if added <= f64::EPSILON * size {
                break;
            }
        }
        Self { steps, sums, finest }
    }

    /// The last sample of 2ⁿ from a state on whose squared distance exceeds a limit.
    fn last_beyond(&self, state: &Mat<f64>, doublings: usize, limit: f64) -> Option<f64> {
        let sum = (state.transpose() * (&self.sums[doublings] * state))[(0, 0)];
        let samples = 2f64.powi(doublings as i32);
        let first = (state.transpose() * (&self.sums[0] * state))[(0, 0)];
        // Where nothing but slow poles moves the tool, its distance is one number over so short a time.
        let is_level = (sum - samples * first).abs() <= LEVEL * sum;
        if doublings == 0 || doublings <= self.finest && is_level {
            return (sum > limit * samples).then_some(samples - 1.0);
        }
        if sum <= limit {
            return None;
        }
        let half = doublings - 1;
        let later = self.last_beyond(&(&self.steps[half] * state), half, limit).map(|last| last + 0.5 * samples);
        later.or_else(|| self.last_beyond(state, half, limit))
    }
}
