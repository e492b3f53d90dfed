//! A stable, minimum-phase rational function as factors, its log magnitude with derivatives, and its state space.
//!
//!   ln|d(jω)| = g + Σ_zeros L(ω) − Σ_poles L(ω),   L = ½ ln(1 + u²) or ½ ln((1 − u²)² + 4ζ²u²),   u = ω/ω₀
//!
//! The parameters g, ln ω₀ and ln ζ are free real numbers: every value is stable and minimum phase, ζ ≥ 1 is a pair of
//! real roots and the step from real to complex roots is smooth. Both lists have the same length and kinds.

use crate::linalg::{Mat, NumericError};
use crate::lti::connect::series;
use crate::lti::{Continuous, StateSpace};

/// 1 + s/ω₀, or 1 + 2ζ s/ω₀ + (s/ω₀)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor {
    /// ln of the corner frequency, rad/s.
    pub ln_omega: f64,
    /// ln ζ of a second-order factor; `None` for a first-order one.
    pub ln_damping: Option<f64>,
}

impl Factor {
    /// Degree in s.
    pub fn degree(&self) -> usize {
        1 + usize::from(self.ln_damping.is_some())
    }

    /// L at a frequency and its derivatives with respect to ln ω₀ and ln ζ.
    fn log_magnitude(&self, omega_rad_s: f64) -> (f64, f64, f64) {
        let u2 = (omega_rad_s * (-self.ln_omega).exp()).powi(2);
        match self.ln_damping {
            None => (0.5 * u2.ln_1p(), -u2 / (1.0 + u2), 0.0),
            Some(ln_damping) => {
                let z2 = (2.0 * ln_damping).exp();
                // u⁴ overflows beyond 1e77 only: corners stay within a few decades of the data.
                let q = (1.0 - u2).powi(2) + 4.0 * z2 * u2;
                let along = (4.0 * z2 * u2 - 2.0 * u2 * (1.0 - u2)) / q;
                (0.5 * q.ln(), -along, 4.0 * z2 * u2 / q)
            }
        }
    }

    /// Second derivatives of L: by ln ω₀ twice, by both, by ln ζ twice.
    fn second_derivatives(&self, omega_rad_s: f64) -> [f64; 3] {
        let u2 = (omega_rad_s * (-self.ln_omega).exp()).powi(2);
        match self.ln_damping {
            None => [2.0 * u2 / (1.0 + u2).powi(2), 0.0, 0.0],
            Some(ln_damping) => {
                let z2 = (2.0 * ln_damping).exp();
                let damped = 4.0 * z2 * u2;
                let q = (1.0 - u2).powi(2) + damped;
                // u² ∂q/∂u² and u² times its derivative by u².
                let along = damped - 2.0 * u2 * (1.0 - u2);
                let bent = along + 2.0 * u2 * u2;
                let square = 2.0 / (q * q);
                [square * (bent * q - along * along), -square * damped * (q - along), square * damped * (q - damped)]
            }
        }
    }
}

/// Ranges of the parameters of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRanges {
    /// ln of the corner frequencies, rad/s.
    pub ln_omega: (f64, f64),
    /// ln ζ of second-order factors.
    pub ln_damping: (f64, f64),
}

/// gain · Π zeros / Π poles.
#[derive(Clone, Debug, PartialEq)]
pub struct Factors {
    /// ln of the gain at ω = 0.
    pub ln_gain: f64,
    /// Zeros, all in the open left half plane.
    pub zeros: Vec<Factor>,
    /// Poles, of the same kinds in the same order as the zeros.
    pub poles: Vec<Factor>,
}

impl Factors {
    /// A constant.
    pub fn constant(ln_gain: f64) -> Self {
        Self { ln_gain, zeros: vec![], poles: vec![] }
    }

    /// Order of the rational function.
    pub fn order(&self) -> usize {
        self.poles.iter().map(Factor::degree).sum()
    }

    /// Whether another function has factors of the same kinds in the same order.
    pub(crate) fn orders_match(&self, other: &Self) -> bool {
        let kinds = |list: &[Factor]| list.iter().map(Factor::degree).collect::<Vec<_>>();
        kinds(&self.zeros) == kinds(&other.zeros) && kinds(&self.poles) == kinds(&other.poles)
    }

    /// 1/d.
    pub fn inverse(&self) -> Self {
        Self { ln_gain: -self.ln_gain, zeros: self.poles.clone(), poles: self.zeros.clone() }
    }

    /// ln|d(jω)|.
    pub(crate) fn ln_magnitude(&self, omega_rad_s: f64) -> f64 {
        let sum = |list: &[Factor]| -> f64 { list.iter().map(|f| f.log_magnitude(omega_rad_s).0).sum() };
        self.ln_gain + sum(&self.zeros) - sum(&self.poles)
    }

    /// ln|d(jω)| with its derivatives in the order of [`Self::parameters`].
    pub(crate) fn ln_magnitude_with_gradient(&self, omega_rad_s: f64) -> (f64, Vec<f64>) {
        let (mut value, mut gradient) = (self.ln_gain, vec![1.0]);
        for (list, sign) in [(&self.zeros, 1.0), (&self.poles, -1.0)] {
            for factor in list {
                let (l, d_omega, d_damping) = factor.log_magnitude(omega_rad_s);
                value += sign * l;
                gradient.push(sign * d_omega);
                if factor.ln_damping.is_some() {
                    gradient.push(sign * d_damping);
                }
            }
        }
        (value, gradient)
    }

    /// Adds `weight` times the second derivatives of ln|d(jω)| to a matrix in the order of [`Self::parameters`].
    pub(crate) fn add_second_derivatives(&self, omega_rad_s: f64, weight: f64, sum: &mut Mat<f64>) {
        let mut k = 1;
        for (list, sign) in [(&self.zeros, weight), (&self.poles, -weight)] {
            for factor in list {
                let [own, mixed, damping] = factor.second_derivatives(omega_rad_s);
                sum[(k, k)] += sign * own;
                if factor.ln_damping.is_some() {
                    sum[(k, k + 1)] += sign * mixed;
                    sum[(k + 1, k)] += sign * mixed;
                    sum[(k + 1, k + 1)] += sign * damping;
                }
                k += factor.degree();
            }
        }
    }

    /// g, then ln ω₀ (and ln ζ) of every zero, then of every pole.
    pub fn parameters(&self) -> Vec<f64> {
        let mut list = vec![self.ln_gain];
        for factor in self.zeros.iter().chain(&self.poles) {
            list.push(factor.ln_omega);
            list.extend(factor.ln_damping);
        }
        list
    }

    /// The function of the same kinds with other parameters, clamped to the limits.
    pub(crate) fn with_parameters(&self, values: &[f64], limits: &FitRanges) -> Self {
        let mut next = self.clone();
        let mut source = values.iter().copied();
        next.ln_gain = source.next().unwrap_or(self.ln_gain);
        for factor in next.zeros.iter_mut().chain(&mut next.poles) {
            if let Some(v) = source.next() {
                factor.ln_omega = v.clamp(limits.ln_omega.0, limits.ln_omega.1);
            }
            if let Some(ln_damping) = &mut factor.ln_damping
                && let Some(v) = source.next()
            {
                *ln_damping = v.clamp(limits.ln_damping.0, limits.ln_damping.1);
            }
        }
        next
    }

    /// The function with one more first-order pole and zero; two first-order factors are joined to a second-order one.
    pub(crate) fn extend_factors(&self, ln_zero: f64, ln_pole: f64) -> Self {
        let mut next = self.clone();
        let join = |list: &mut Vec<Factor>, ln_omega: f64| {
            let single = list.iter().position(|f| f.ln_damping.is_none());
            match single {
                Some(k) => {
                    let other = list.remove(k).ln_omega;
                    list.push(join_roots(other, ln_omega));
                }
                None => list.push(Factor { ln_omega, ln_damping: None }),
            }
        };
        join(&mut next.zeros, ln_zero);
        join(&mut next.poles, ln_pole);
        next
    }

    /// State space of the function: sections in series, poles and zeros paired in order of frequency.
    ///
    /// # Errors
    /// [`NumericError`] when a parameter is not finite.
    pub fn state_space(&self) -> Result<StateSpace<Continuous>, NumericError> {
        let gain = Mat::from_fn(1, 1, |_, _| self.ln_gain.exp());
        let mut system = StateSpace::gain(gain, Continuous);
        let sorted = |list: &[Factor]| {
            let mut list = list.to_vec();
            list.sort_by(|a, b| {
                let kind = a.degree().cmp(&b.degree());
                kind.then(a.ln_omega.total_cmp(&b.ln_omega))
            });
            list
        };
        for (zero, pole) in sorted(&self.zeros).iter().zip(&sorted(&self.poles)) {
            system = series(&system, &section(zero, pole)?)?;
        }
        Ok(system)
    }
}

/// (1 + s/a)(1 + s/b) as one second-order factor.
pub(crate) fn join_roots(ln_a: f64, ln_b: f64) -> Factor {
    Factor { ln_omega: 0.5 * (ln_a + ln_b), ln_damping: Some((0.5 * (ln_a - ln_b)).cosh().ln()) }
}

fn section(zero: &Factor, pole: &Factor) -> Result<StateSpace<Continuous>, NumericError> {
    let row = |values: &[f64]| Mat::from_fn(1, values.len(), |_, j| values[j]);
    let (wz, wp) = (zero.ln_omega.exp(), pole.ln_omega.exp());
    match (zero.ln_damping, pole.ln_damping) {
        (Some(dz), Some(dp)) => {
            let (dz, dp) = (dz.exp(), dp.exp());
            let k = (2.0 * (pole.ln_omega - zero.ln_omega)).exp();
            let a = Mat::from_fn(2, 2, |i, j| match (i, j) {
                (0, 0) => 0.0,
                (0, _) => wp,
                (_, 0) => -wp,
                _ => -2.0 * dp * wp,
            });
            let b = Mat::from_fn(2, 1, |i, _| if i == 0 { 0.0 } else { wp });
            let c = row(&[k * ((wz / wp).powi(2) - 1.0), 2.0 * k * (dz * wz / wp - dp)]);
            StateSpace::new(a, b, c, row(&[k]), Continuous)
        }
        _ => {
            let k = wp / wz;
            let one = |v: f64| Mat::from_fn(1, 1, |_, _| v);
            StateSpace::new(one(-wp), one(wp), one(k * (wz / wp - 1.0)), one(k), Continuous)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_derivatives_are_differences_of_the_gradient() {
        let factor = |ln_omega: f64, ln_damping: Option<f64>| Factor { ln_omega, ln_damping };
        let function = Factors {
            ln_gain: 0.3,
            zeros: vec![factor(0.2, Some(-0.7)), factor(-0.4, None)],
            poles: vec![factor(-0.1, Some(0.9)), factor(0.5, None)],
        };
        let limits = FitRanges { ln_omega: (-9.0, 9.0), ln_damping: (-9.0, 9.0) };
        let x = function.parameters();
        let step = 1e-5;
        for omega in [0.05, 0.8, 1.3, 20.0] {
            let mut found = Mat::zeros(x.len(), x.len());
            function.add_second_derivatives(omega, 1.5, &mut found);
            for k in 0..x.len() {
                let gradient = |by: f64| {
                    let mut moved = x.clone();
                    moved[k] += by;
                    let moved = function.with_parameters(&moved, &limits);
                    moved.ln_magnitude_with_gradient(omega).1
                };
                let (up, down) = (gradient(step), gradient(-step));
                for i in 0..x.len() {
                    let expected = 1.5 * (up[i] - down[i]) / (2.0 * step);
                    assert!((found[(i, k)] - expected).abs() < 1e-8, "{omega} {i} {k}");
                }
            }
        }
    }
}
