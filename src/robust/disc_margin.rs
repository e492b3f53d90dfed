//! Disc margins (Seiler, Packard and Gahinet 2020): the largest α for which a loop stays stable with every factor
//! f = (1 + (1 − σ)δ/2)/(1 − (1 + σ)δ/2), |δ| < α, in its channels. With the sensitivity S of negative feedback the
//! margin is 1/μ of M = S + (σ − 1)/2: skew σ = 1 gives S, −1 gives T, 0 gives (S − T)/2. One channel has a norm, all
//! channels at once, each with a factor of its own, the μ of a diagonal Δ.

use super::mu::peak::CERTIFICATE_SLACK;
use super::mu::system::MuSystem;
use super::structure::MuError;
use crate::augment::Block;
use crate::linalg::{Mat, NumericError, solve};
use crate::lti::norm::{NormError, hinf_norm};
use crate::lti::{Continuous, StateSpace};

/// Relative tolerance of norms.
const NORM_TOL: f64 = 1e-9;

/// The margin of a skew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscMargin {
    /// σ.
    pub skew: f64,
    /// α that is guaranteed.
    pub alpha: f64,
    /// α at which some factors are known to destabilise; of one channel the same but for rounding, infinite where none
    /// was sought.
    pub alpha_upper: f64,
    /// Frequency where α is smallest, rad/s.
    pub omega_rad_s: f64,
}

impl DiscMargin {
    /// From the largest norm or bound of μ on some lines, with its frequency in rad/s.
    pub(crate) fn on_lines(skew: f64, peak: (f64, f64)) -> Self {
        Self { skew, alpha: peak.0.recip(), alpha_upper: f64::INFINITY, omega_rad_s: peak.1 }
    }

    /// The real factors that the disc holds: from the first, perhaps negative or infinite, to the second, perhaps
    /// infinite.
    pub fn gain_margin(&self) -> (f64, f64) {
        let (near, far) = (0.5 * self.alpha * (1.0 - self.skew), 0.5 * self.alpha * (1.0 + self.skew));
        let largest = if far < 1.0 { (1.0 + near) / (1.0 - far) } else { f64::INFINITY };
        let least = if far > -1.0 { (1.0 - near) / (1.0 + far) } else { f64::NEG_INFINITY };
        (least, largest)
    }

    /// The phase that the disc holds on either side, rad; π where it holds the unit circle.
    pub fn phase_margin_rad(&self) -> f64 {
        let (near, far) = (0.5 * self.alpha * (1.0 - self.skew), 0.5 * self.alpha * (1.0 + self.skew));
        // The circle through both real factors, numerator and denominator times (1 + far)(1 − far).
        let cosine = (1.0 - far * far + 1.0 - near * near) / (2.0 * (1.0 + near * far));
        if cosine.abs() <= 1.0 { cosine.acos() } else { std::f64::consts::PI }
    }
}

/// S = (I + L)⁻¹ of a square loop transfer L in negative feedback.
///
/// # Errors
/// [`NumericError`] for a loop that is not square, or not well posed.
pub fn sensitivity(l: &StateSpace<Continuous>) -> Result<StateSpace<Continuous>, NumericError> {
    let n = l.outputs();
    if l.inputs() != n {
        return Err(NumericError::Dimension {
            what: "loop transfer",
            expected: "as many inputs as outputs".to_owned(),
            found: format!("{} inputs, {n} outputs", l.inputs()),
        });
    }
    let plus = &l.d + Mat::<f64>::identity(n, n);
    let divide = |m: &Mat<f64>| solve(&plus, m).map_err(|_| NumericError::IllPosed { what: "I + D of the loop" });
    let (c, d) = (divide(&l.c)?, divide(&Mat::identity(n, n))?);
    StateSpace::new(&l.a - &l.b * &c, &l.b * &d, -c, d, Continuous)
}

/// The margin of one channel of a stable loop with this sensitivity, the others closed.
///
/// # Errors
/// [`NormError::Unstable`] for an unstable loop.
pub fn channel_margin(s: &StateSpace<Continuous>, channel: usize, skew: f64) -> Result<DiscMargin, NormError> {
    let norm = hinf_norm(&skewed(&s.select(&[channel], &[channel]), skew), NORM_TOL)?;
    Ok(DiscMargin {
        skew,
        alpha: norm.upper.recip(),
        alpha_upper: norm.norm.recip(),
        omega_rad_s: norm.peak_omega_rad_s,
    })
}

/// The margin of all channels at once.
///
/// # Errors
/// [`MuError::Unstable`] for an unstable loop, and a peak of μ that could not be certified.
pub fn multiloop_margin(s: &StateSpace<Continuous>, skew: f64) -> Result<DiscMargin, MuError> {
    let blocks = vec![Block::ComplexScalar { n: 1 }; s.outputs()];
    let peak = MuSystem::new(&skewed(s, skew), &blocks)?.peak(CERTIFICATE_SLACK)?;
    Ok(DiscMargin {
        skew,
        alpha: peak.upper.recip(),
        alpha_upper: peak.bounds.lower.recip(),
        omega_rad_s: peak.omega_rad_s,
    })
}

/// S + (σ − 1)/2.
fn skewed(s: &StateSpace<Continuous>, skew: f64) -> StateSpace<Continuous> {
    let shift = |i: usize, j: usize| if i == j { 0.5 * (skew - 1.0) } else { 0.0 };
    let d = Mat::from_fn(s.outputs(), s.inputs(), |i, j| s.d[(i, j)] + shift(i, j));
    StateSpace { d, ..s.clone() }
}
