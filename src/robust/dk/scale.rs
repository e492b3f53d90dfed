//! The D-scales of a D-K iteration: one stable, minimum-phase dᵢ(s) per block, the last block's is 1.
//!
//! P_D = blkdiag(D_L, I) P blkdiag(D_R⁻¹, I) is the plant of the next synthesis; D_L repeats dᵢ over the outputs that
//! block i reads, D_R over the inputs that it feeds. Repeated scalars get dᵢI: the bound of that choice holds for them,
//! too.

use crate::augment::GeneralizedPlant;
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::{append, series};
use crate::lti::{Continuous, StateSpace};
use crate::robust::dfit::factors::{Factors, FitRanges};
use crate::robust::structure::Structure;

/// One rational scale per block.
#[derive(Clone, Debug, PartialEq)]
pub struct DScales {
    /// Scales in block order; the last one is the constant 1.
    pub factors: Vec<Factors>,
}

impl DScales {
    /// D = I.
    pub fn identity(blocks: usize) -> Self {
        Self { factors: vec![Factors::constant(0.0); blocks] }
    }

    /// The scales without the last.
    pub(crate) fn free(&self) -> &[Factors] {
        &self.factors[..self.factors.len().saturating_sub(1)]
    }

    /// Orders of the scales, without the last.
    pub fn orders(&self) -> Vec<usize> {
        self.free().iter().map(Factors::order).collect()
    }

    /// Parameters of the scales, without the last, one after the other.
    pub(crate) fn parameters(&self) -> Vec<f64> {
        self.free().iter().flat_map(Factors::parameters).collect()
    }

    /// Scales of the same kinds with other parameters, clamped to the limits.
    pub(crate) fn with_parameters(&self, parameters: &[f64], limits: &FitRanges) -> Self {
        let mut next = self.clone();
        let last = next.factors.len().saturating_sub(1);
        let mut rest = parameters;
        for factors in &mut next.factors[..last] {
            let (own, others) = rest.split_at(factors.parameters().len().min(rest.len()));
            *factors = factors.with_parameters(own, limits);
            rest = others;
        }
        next
    }

    /// |dᵢ(jω)| per block; at infinity the high-frequency gain.
    pub fn magnitudes(&self, omega_rad_s: f64) -> Vec<f64> {
        // Corners lie many decades below this frequency, and its fourth power is finite.
        let omega = omega_rad_s.min(1e60);
        self.factors.iter().map(|f| f.ln_magnitude(omega).exp()).collect()
    }

    /// (1 − t)·self + t·other in the parameters; `None` when the factors are of different kinds.
    pub fn towards(&self, other: &Self, t: f64, limits: &FitRanges) -> Option<Self> {
        let mut mixed = other.clone();
        let pairs = self.factors.iter().zip(&other.factors);
        for (target, (x, y)) in mixed.factors.iter_mut().zip(pairs) {
            if !x.orders_match(y) {
                return None;
            }
            let (px, py) = (x.parameters(), y.parameters());
            let values: Vec<f64> = px.iter().zip(&py).map(|(x, y)| x + t * (y - x)).collect();
            *target = y.with_parameters(&values, limits);
        }
        Some(mixed)
    }

    /// The scales times one number per block.
    #[must_use]
    pub fn times(&self, constant: &[f64]) -> Self {
        let mut product = self.clone();
        for (factors, scale) in product.factors.iter_mut().zip(constant) {
            factors.ln_gain += scale.ln();
        }
        product
    }

    /// D_L over the outputs that the blocks read, D_R⁻¹ over the inputs that they feed.
    ///
    /// # Errors
    /// [`NumericError`] when a scale cannot be realised.
    pub fn systems(
        &self,
        structure: &Structure,
    ) -> Result<(StateSpace<Continuous>, StateSpace<Continuous>), NumericError> {
        let empty = StateSpace::gain(Mat::zeros(0, 0), Continuous);
        let (mut left, mut right) = (empty.clone(), empty);
        for (span, factors) in structure.spans.iter().zip(&self.factors) {
            let (d, inverse) = (factors.state_space()?, factors.inverse().state_space()?);
            for _ in span.z.clone() {
                left = append(&left, &d);
            }
            for _ in span.w.clone() {
                right = append(&right, &inverse);
            }
        }
        Ok((left, right))
    }

    /// The scaled generalized plant.
    pub(crate) fn scaled_plant(
        &self,
        plant: &GeneralizedPlant,
        structure: &Structure,
    ) -> Result<GeneralizedPlant, NumericError> {
        let (mut left, mut right) = self.systems(structure)?;
        let through = |n: usize| StateSpace::gain(Mat::identity(n, n), Continuous);
        left = append(&left, &through(plant.measurements));
        right = append(&right, &through(plant.controls));
        Ok(GeneralizedPlant {
            system: series(&series(&right, &plant.system)?, &left)?,
            blocks: vec![],
            ..plant.clone()
        })
    }
}

/// Every error of a plant times one function.
pub(crate) fn scale_errors(plant: &GeneralizedPlant, scale: &Factors) -> Result<GeneralizedPlant, NumericError> {
    let one = scale.state_space()?;
    let gain = |n: usize| StateSpace::gain(Mat::identity(n, n), Continuous);
    let errors = (0..plant.errors()).fold(gain(0), |left, _| append(&left, &one));
    let left = append(&errors, &gain(plant.measurements));
    Ok(GeneralizedPlant { system: series(&plant.system, &left)?, ..plant.clone() })
}
