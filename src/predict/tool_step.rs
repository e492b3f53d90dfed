//! Displacement of the tool after a constant force begins to act on it: the linear loop, exact at the sampling
//! instants.

use super::closed_loop::close;
use crate::augment::plane::connected_part;
use crate::linalg::{Mat, NumericError};
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
        let tool = connected_part(&close(sampled, law)?.select(&[0], &[0]));
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
        let outside = displacement.iter().rposition(|x| (x / end - 1.0).abs() > SETTLED);
        let settled = outside.map_or(0, |last| last + 1);
        let time_s: Vec<f64> = (0..=steps).map(|k| k as f64 * period_s).collect();
        Ok(Self {
            settling_s: time_s.get(settled).copied().unwrap_or(f64::NAN),
            overshoot: (largest - 1.0).max(0.0),
            final_m_per_n: end,
            displacement_m_per_n: displacement,
            time_s,
        })
    }
}
