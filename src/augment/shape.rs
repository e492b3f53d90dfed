//! A weight over frequency as stages in series, each of first or second order.
//!
//! The limits of Table 2 change from one level to another and have one stage; the current has two. A weight that is
//! given as a transfer function or by points has as many as it needs. Only its magnitude counts, so every stage is
//! stable and minimum phase.

use super::root::Root;
use super::second_order::SecondOrder;
use super::weighting::WeightSection;
use crate::linalg::{Mat, NumericError};
use crate::lti::connect::series;
use crate::lti::{Continuous, StateSpace};

/// One factor of a weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WeightStage {
    /// (b₁ s + b₀)/(a₁ s + a₀).
    First(WeightSection),
    /// (b₂ s² + b₁ s + b₀)/(a₂ s² + a₁ s + a₀).
    Second(SecondOrder),
}

impl WeightStage {
    /// |W(jω)|.
    pub fn magnitude(&self, omega_rad_s: f64) -> f64 {
        match self {
            Self::First(section) => section.magnitude(omega_rad_s),
            Self::Second(stage) => stage.magnitude(omega_rad_s),
        }
    }

    pub(crate) fn system(&self) -> Result<StateSpace<Continuous>, NumericError> {
        match self {
            Self::First(section) => section.system(),
            Self::Second(stage) => stage.system(),
        }
    }
}

/// gain · Π stages.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Factor before the stages.
    pub gain: f64,
    /// At least one.
    pub stages: Vec<WeightStage>,
    /// How far it may lie above the points that it was fitted to, relative; zero of one that was written as it is.
    pub excess_over_points: f64,
}

impl Shape {
    /// One stage of first order.
    pub fn section(section: WeightSection) -> Self {
        Self { gain: 1.0, stages: vec![WeightStage::First(section)], excess_over_points: 0.0 }
    }

    /// One that goes from `low` to `high` and is their geometric mean at `crossover_hz`.
    ///
    /// # Errors
    /// As [`WeightSection::level_change`].
    pub fn level_change(low: f64, high: f64, crossover_hz: f64) -> Result<Self, NumericError> {
        Ok(Self::section(WeightSection::level_change(low, high, crossover_hz)?))
    }

    /// The shape with value `gain` at zero frequency and these roots.
    ///
    /// # Errors
    /// [`NumericError::NotFinite`] when there are more zeros than poles.
    pub fn from_roots(gain: f64, zeros: &[Root], poles: &[Root]) -> Result<Self, NumericError> {
        let degree = |list: &[Root]| list.iter().map(Root::degree).sum::<usize>();
        if degree(zeros) > degree(poles) {
            return Err(NumericError::NotFinite { what: "weight at high frequency (it has more zeros than poles)" });
        }
        let mut stages = vec![];
        let (mut zeros, mut poles) = (Roots::of(zeros), Roots::of(poles));
        while !zeros.pairs.is_empty() || !poles.pairs.is_empty() {
            let over = zeros.second_order();
            stages.push(WeightStage::Second(SecondOrder { b: over, a: poles.second_order() }));
        }
        while let Some(pole) = poles.single() {
            let over = zeros.single().map_or([1.0, 0.0, 0.0], |z| z.coefficients());
            let under = pole.coefficients();
            stages.push(WeightStage::First(WeightSection { b0: over[0], b1: over[1], a0: under[0], a1: under[1] }));
        }
        if stages.is_empty() {
            // No roots: a constant.
            stages.push(WeightStage::First(WeightSection { b0: 1.0, b1: 1.0, a0: 1.0, a1: 1.0 }));
        }
        Ok(Self { gain, stages, excess_over_points: 0.0 })
    }

    /// Multiplied by a positive factor.
    #[must_use]
    pub(crate) fn times(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        match scaled.stages.as_mut_slice() {
            // The factor goes into a lone section, so that its states are scaled with it.
            [WeightStage::First(section)] => *section = section.times(factor),
            _ => scaled.gain *= factor,
        }
        scaled
    }

    /// |W(jω)|.
    pub fn magnitude(&self, omega_rad_s: f64) -> f64 {
        let stages = self.stages.iter().map(|s| s.magnitude(omega_rad_s));
        self.gain * stages.product::<f64>()
    }

    /// Stages in series as a function of each makes them.
    pub(super) fn in_series(
        &self,
        mut own: impl FnMut(&WeightStage) -> Result<StateSpace<Continuous>, NumericError>,
    ) -> Result<StateSpace<Continuous>, NumericError> {
        let mut all: Option<StateSpace<Continuous>> = None;
        for stage in &self.stages {
            let next = own(stage)?;
            all = Some(match all {
                None => next,
                Some(before) => series(&before, &next)?,
            });
        }
        let one = || StateSpace::gain(Mat::identity(1, 1), Continuous);
        let all = all.unwrap_or_else(one);
        Ok(if self.gain == 1.0 { all } else { all.scale_outputs(&Mat::from_fn(1, 1, |_, _| self.gain)) })
    }
}

/// Roots by kind, ascending, taken from the low end.
struct Roots {
    pairs: Vec<Root>,
    singles: Vec<Root>,
}

impl Roots {
    fn of(list: &[Root]) -> Self {
        let sorted = |pairs: bool| {
            let own = list.iter().filter(|r| r.damping.is_some() == pairs);
            let mut own: Vec<Root> = own.copied().collect();
            // Descending: the lowest is taken from the end.
            own.sort_by(|a, b| b.omega_rad_s.total_cmp(&a.omega_rad_s));
            own
        };
        Self { pairs: sorted(true), singles: sorted(false) }
    }

    fn single(&mut self) -> Option<Root> {
        self.singles.pop()
    }

    /// The next pair, else two real roots as far as there are.
    fn second_order(&mut self) -> [f64; 3] {
        if let Some(pair) = self.pairs.pop() {
            return pair.coefficients();
        }
        let [first, second] = [self.single(), self.single()].map(|root| root.map_or(0.0, |r| r.coefficients()[1]));
        [1.0, first + second, first * second]
    }
}
