//! Weights of true frequency realised in the w plane of the sampled loop.
//!
//! In the w plane ω = (2/T) atan(vT/2), so a weight written in s has the magnitude it says at low frequency only. With
//! X = (vT/2)² and θ = ωT/2, θ² = atan²√X is a complete Bernstein function of X; the table has its minimax rational
//! approximants ρ(X) = g X Π(1 + X/zᵢ)/Π(1 + X/pᵢ). A first-order section has |W|² = (b₀² + b₁²ω²)/(a₀² + a₁²ω²), so
//! with ω² replaced by (2/T)² ρ(X) it stays rational in X; its roots are real, negative and lie one between each two
//! poles of ρ: zeros and poles of a stable minimum-phase system in v. Relative error of |W| ≤ half that of ρ. The gain
//! is then raised until the fit is nowhere below the section, so a μ bound with the fit is one with the section as
//! written.
//! The same approximant gives the inverse of the hold, 1/sinc² = θ²(1 + X)/X.

use super::weighting::WeightSection;
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::series;
use crate::lti::{Continuous, StateSpace};

/// A weight in the w plane and how far it lies above the one of true frequency.
#[derive(Clone, Debug)]
pub struct FittedWeight {
    /// One input, one output; stable and minimum phase.
    pub system: StateSpace<Continuous>,
    /// max |fit|/|weight| − 1 over true frequency from zero to Nyquist; the minimum is zero.
    pub largest_excess: f64,
}

/// Minimax approximant of atan²√X over X ≥ 0 in relative error.
pub(super) struct Approximant {
    pub gain: f64,
    /// −X of the zeros besides X = 0.
    pub zeros: &'static [f64],
    /// −X of the poles.
    pub poles: &'static [f64],
}

/// Relative errors of θ²: 1.8e-2, 4.5e-3, 1.3e-3.
pub(super) const APPROXIMANTS: [Approximant; 3] = [
    Approximant { gain: 0.982_201_240_5, zeros: &[24.692_003_72], poles: &[1.711_735_63, 35.580_420_55] },
    Approximant {
        gain: 0.995_609_930_5,
        zeros: &[7.682_701_25, 453.348_707_4],
        poles: &[1.484_858_21, 11.632_909_7, 497.433_438_5],
    },
    Approximant {
        gain: 0.998_670_190_3,
        zeros: &[4.471_189_85, 87.744_601_8, 4_840.999_36],
        poles: &[1.371_657_05, 6.812_025_26, 100.653_289, 4_982.038_1],
    },
];

/// Points X per decade, and decades, at which a fit is compared with its weight: θ from 1e-5 to π/2 − 1e-8.
const POINTS_PER_DECADE: i32 = 100;
const DECADES: (i32, i32) = (-10, 16);
/// What a ratio may exceed those at the points by: at an extremum it bends by less than its range, 2 %, per decade
/// squared.
const BETWEEN_POINTS: f64 = 1e-5;

/// Zeros and poles of |W|² in −X, and |W| at X = 0.
struct SquaredFactors {
    gain: f64,
    zeros: Vec<f64>,
    poles: Vec<f64>,
}

impl SquaredFactors {
    fn magnitude(&self, x: f64) -> f64 {
        let pairs = self.zeros.iter().zip(&self.poles);
        let ratio: f64 = pairs.map(|(z, p)| (1.0 + x / z) / (1.0 + x / p)).product();
        self.gain * ratio.sqrt()
    }

    /// The system in v with these factors, `gain` times as large.
    fn system(&self, gain: f64, period_s: f64) -> Result<StateSpace<Continuous>, NumericError> {
        let to_v = |root: &f64| 2.0 / period_s * root.sqrt();
        let one = Mat::from_fn(1, 1, |_, _| self.gain * gain);
        let mut all = StateSpace::gain(one, Continuous);
        for (zero, pole) in self.zeros.iter().map(to_v).zip(self.poles.iter().map(to_v)) {
            let stage = WeightSection { b0: pole, b1: pole / zero, a0: pole, a1: 1.0 };
            all = series(&all, &stage.system()?)?;
        }
        Ok(all)
    }
}

/// A section of true frequency in the w plane: the lowest order whose excess is within `tolerance`, else the highest.
///
/// # Errors
/// [`NumericError`] when the section or the period is not positive.
pub fn fit_sampled_weight(
    section: &WeightSection,
    period_s: f64,
    tolerance: f64,
) -> Result<FittedWeight, NumericError> {
    let plain = |x: f64| section.magnitude(2.0 / period_s * x.sqrt());
    let written = |theta: f64| section.magnitude(2.0 / period_s * theta);
    let (least, excess) = ratio_range(&plain, &written);
    if excess <= tolerance {
        let raise = Mat::from_fn(1, 1, |_, _| least.recip());
        return Ok(FittedWeight { system: section.system()?.scale_outputs(&raise), largest_excess: excess });
    }
    lowest(period_s, tolerance, &written, |approximant| {
        let k = 2.0 / period_s;
        SquaredFactors {
            gain: section.b0 / section.a0,
            zeros: approximant.roots(section.b0.powi(2), (k * section.b1).powi(2)),
            poles: approximant.roots(section.a0.powi(2), (k * section.a1).powi(2)),
        }
    })
}

/// 1/sinc(ωT/2) in the w plane: what an input that acts between the samples has more than one that is held.
///
/// # Errors
/// As [`fit_sampled_weight`].
pub fn inverse_hold(period_s: f64, tolerance: f64) -> Result<FittedWeight, NumericError> {
    let written = |theta: f64| theta / theta.sin();
    lowest(period_s, tolerance, &written, |approximant| {
        let mut zeros = approximant.zeros.to_vec();
        zeros.push(1.0);
        zeros.sort_by(f64::total_cmp);
        SquaredFactors { gain: approximant.gain.sqrt(), zeros, poles: approximant.poles.to_vec() }
    })
}

fn lowest(
    period_s: f64,
    tolerance: f64,
    written: &dyn Fn(f64) -> f64,
    factors: impl Fn(&Approximant) -> SquaredFactors,
) -> Result<FittedWeight, NumericError> {
    let mut last = None;
    for approximant in &APPROXIMANTS {
        let own = factors(approximant);
        let (least, excess) = ratio_range(&|x| own.magnitude(x), written);
        let done = excess <= tolerance;
        last = Some((own, least, excess));
        if done {
            break;
        }
    }
    match last {
        Some((own, least, largest_excess)) if largest_excess.is_finite() && least > 0.0 => {
            Ok(FittedWeight { system: own.system(least.recip(), period_s)?, largest_excess })
        }
        _ => Err(NumericError::NotFinite {
            what: "weight fitted in the w plane (levels, corners and sample period must be positive)",
        }),
    }
}

/// Smallest ratio of a magnitude over X to one over θ, and the largest over the smallest less one.
fn ratio_range(fit: &dyn Fn(f64) -> f64, written: &dyn Fn(f64) -> f64) -> (f64, f64) {
    ratio_range_over(&base_points(), fit, written)
}

/// Values of X at which every fit is compared with its weight.
pub(super) fn base_points() -> Vec<f64> {
    let points = DECADES.0 * POINTS_PER_DECADE..=DECADES.1 * POINTS_PER_DECADE;
    let x = |k| 10f64.powf(f64::from(k) / f64::from(POINTS_PER_DECADE));
    points.map(x).collect()
}

/// As [`ratio_range`], at the given values of X.
pub(super) fn ratio_range_over(points: &[f64], fit: &dyn Fn(f64) -> f64, written: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let ratios = points.iter().map(|x| fit(*x) / written(x.sqrt().atan()));
    let (least, most) = ratios.fold((f64::INFINITY, 0.0f64), |(a, b), r| (a.min(r), b.max(r)));
    let least = least * (1.0 - BETWEEN_POINTS);
    (least, most * (1.0 + BETWEEN_POINTS) / least - 1.0)
}

impl Approximant {
    /// ρ(X).
    pub(super) fn value(&self, x: f64) -> f64 {
        let above: f64 = self.zeros.iter().map(|z| 1.0 + x / z).product();
        let below: f64 = self.poles.iter().map(|p| 1.0 + x / p).product();
        self.gain * x * above / below
    }

    /// −X of the roots of c₀ + c₁ ρ(X), ascending: one between each two poles; those of the poles when c₁ = 0.
    pub(super) fn roots(&self, c0: f64, c1: f64) -> Vec<f64> {
        let value = |u: f64| {
            let q: f64 = self.poles.iter().map(|p| 1.0 - u / p).product();
            let p: f64 = self.zeros.iter().map(|z| 1.0 - u / z).product();
            c0 * q - c1 * self.gain * u * p
        };
        let mut low = 0.0;
        let mut roots = vec![];
        for (k, pole) in self.poles.iter().enumerate() {
            let (mut a, mut b) = (low, *pole);
            // The sign at the lower end alternates from pole to pole.
            let positive = k.is_multiple_of(2);
            // Halving to the spacing of floating-point numbers.
            for _ in 0..200 {
                let middle = 0.5 * (a + b);
                if (value(middle) > 0.0) == positive {
                    a = middle;
                } else {
                    b = middle;
                }
            }
            roots.push(0.5 * (a + b));
            low = *pole;
        }
        roots
    }
}
